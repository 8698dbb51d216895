# SPDX-License-Identifier: GPL-3.0-or-later
"""What the engine's tests share: a small scene, renders through Blender and through the command line, stand-in programs."""

import contextlib
import os
import shutil
import stat
import subprocess
import sys
import tempfile
import time
import unittest

import bpy
import numpy

import exr
import export_kit
from export_kit import quiet

import sundog
from sundog import engine, export, process, properties

WIDTH, HEIGHT, SAMPLES = 48, 32, 4


def small_scene():
    """Blender's default scene on a floor, small, with few samples and a world that is not grey."""
    bpy.ops.wm.read_factory_settings()
    sundog.register()
    scene = bpy.context.scene
    render = scene.render
    render.engine = "SUNDOG"
    render.resolution_x, render.resolution_y, render.resolution_percentage = WIDTH, HEIGHT, 100
    scene.sundog.samples = SAMPLES
    # Pictures are compared bit by bit with those that were not denoised.
    scene.sundog.denoising = "OFF"
    bpy.ops.mesh.primitive_plane_add(size=8, location=(0, 0, -1))
    bpy.context.object.name = "Floor"
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.5, 0.9, 1)
    return scene


def write_exact(scene):
    """Output as EXR with all passes, 32 bits, uncompressed."""
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "MULTI_LAYER_IMAGE"
    image.file_format = "OPEN_EXR_MULTILAYER"
    image.color_depth, image.exr_codec = "32", "NONE"
    if hasattr(image, "use_exr_interleave"):
        image.use_exr_interleave = True


class EngineTest(unittest.TestCase):
    """Each test has a new scene and a folder, and leaves neither processes nor files."""

    def setUp(self):
        self.program = os.environ["SUNDOG_PROGRAM"] = export_kit.program()
        self.folder = tempfile.mkdtemp(prefix="sundog-test-")
        self.addCleanup(shutil.rmtree, self.folder)
        # Other tests' exports may have left a process that bakes: it stays for the next.
        self.before = set(children())
        self.scene = small_scene()
        write_exact(self.scene)
        self.addCleanup(self.check_clean)

    def check_clean(self):
        """No child, no zombie, no temporary file is left that the test has made."""
        os.environ["SUNDOG_PROGRAM"] = self.program
        # After Esc, the end of the program is waited for in a thread.
        deadline = time.monotonic() + 60
        while process._running and time.monotonic() < deadline:
            time.sleep(0.01)
        self.assertEqual(set(children()) - self.before, set())
        self.assertEqual([name for name in os.listdir(bpy.app.tempdir) if name.startswith("sundog-")], [])

    def for_both(self, size, samples):
        """The scene, which both engines render with a size and so many samples in each pixel."""
        scene = self.scene
        scene.render.resolution_x, scene.render.resolution_y = size
        scene.cycles.samples = scene.sundog.samples = samples
        scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
        return scene

    def render(self, name="picture", **options):
        """Renders as F12 does; the passes of the EXR file by name ("ViewLayer.Combined", …)."""
        self.scene.render.filepath = os.path.join(self.folder, name)
        with quiet():
            bpy.ops.render.render(write_still=True, **options)
        return self.read(name) if not self.scene.render.use_multiview else None

    def by_both(self):
        """Renders by both engines, each by two seeds: the engine, the seed, and what `render` gives, of a file of both names."""
        for name in ("SUNDOG", "CYCLES"):
            self.scene.render.engine = name
            for seed in (1, 2):
                self.scene.cycles.seed = seed
                properties.copy_from_cycles(self.scene)
                self.scene.sundog.denoising = "OFF"
                yield name, seed, self.render(f"{name}{seed}")

    def both(self):
        """The passes of Sundog's files and of Cycles', each by two seeds."""
        found = [passes for _, _, passes in self.by_both()]
        return found[:2], found[2:]

    def read(self, name):
        """A file that was rendered."""
        return exr.passes(exr.read(os.path.join(self.folder, f"{name}.exr")))

    def by_command_line(self, *flags, layer=None):
        """The program's own picture of the exported scene: passes by name, "" for Combined."""
        folder = tempfile.mkdtemp(dir=self.folder)

        def task(depsgraph):
            return export.write_scene(depsgraph, depsgraph.scene, folder, folder)

        scene_file = export_kit.in_render(task, layer or "").path
        picture = os.path.join(folder, "picture.exr")
        command = [self.program, "render", scene_file, "-o", picture, "--exr-compression", "none", "--quiet", "--allow-outside"]
        command += ["--bounces-diffuse", "4", "--bounces-glossy", "4", "--bounces-transmission", "12"]
        command += ["--bounces-transparent", "8"]
        for name, value in (("--width", WIDTH), ("--height", HEIGHT), ("--samples", SAMPLES)):
            if name not in flags:
                command += [name, str(value)]
        subprocess.run([*command, *flags], check=True, capture_output=True)
        return exr.passes(exr.read(picture))

    def fails(self, *words):
        """Rendering fails with a report that has all the words."""
        with self.assertRaises(RuntimeError) as caught:
            self.render("failed")
        for word in words:
            self.assertIn(word, str(caught.exception))
        return str(caught.exception)

    def still_renders(self):
        """The next render works."""
        os.environ["SUNDOG_PROGRAM"] = self.program
        picture = self.render("again")["ViewLayer.Combined"]
        self.assertEqual(picture.shape, (HEIGHT, WIDTH, 4))
        self.assertGreater(picture[..., :3].max(), 0)

    def stand_in(self, body):
        """Makes a Python program the one that renders; what is not `render` the true one answers."""
        path = os.path.join(self.folder, "stand-in")
        with open(path, "w", encoding="utf-8") as file:
            file.write(
                f"#!{sys.executable} -S\nimport json, os, signal, sys, time\n"
                f"if sys.argv[1] != 'render':\n    os.execv({self.program!r}, [{self.program!r}, *sys.argv[1:]])\n"
                f"def tell(**event):\n    print(json.dumps(event), flush=True)\n{body}\n"
            )
        os.chmod(path, os.stat(path).st_mode | stat.S_IXUSR)
        os.environ["SUNDOG_PROGRAM"] = path
        return path


def children():
    """Numbers of this process's children, zombies included."""
    found = []
    for task in os.listdir("/proc/self/task"):
        with contextlib.suppress(OSError), open(f"/proc/self/task/{task}/children", encoding="ascii") as file:
            found += file.read().split()
    return found


def same_bits(a, b):
    """Whether two arrays of floats are equal, bit for bit."""
    a, b = (numpy.ascontiguousarray(x, numpy.float32) for x in (a, b))
    return a.shape == b.shape and bool((a.view(numpy.uint32) == b.view(numpy.uint32)).all())


__all__ = ["EngineTest", "HEIGHT", "SAMPLES", "WIDTH", "children", "engine", "exr", "export_kit", "quiet", "same_bits", "small_scene", "sundog"]
