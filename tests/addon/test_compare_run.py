# SPDX-License-Identifier: GPL-3.0-or-later
"""Sundog and Cycles side by side: sundog.compare in the Blender that runs this."""

import contextlib
import io
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import bpy
import numpy

PROJECT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(PROJECT, "blender_addon"))

import sundog  # noqa: E402
from sundog import preferences  # noqa: E402

SIZE = (64, 36)
SAMPLES = 64
FILES = ("sundog.exr", "cycles.exr", "sundog.png", "cycles.png", "difference.png", "difference-view.png", "comparison.json", "comparison.md")
# The luminance of a difference d is at most sqrt(0.7152 · 3) times its root mean square over the channels.
LUMINANCE_OVER_CHANNELS = math.sqrt(0.7152 * 3)
# Standard errors within which the means of two unbiased pictures may differ; the seeds are fixed.
SIGMAS = 4


@contextlib.contextmanager
def quiet():
    """Keeps Blender's own lines out of the test's output: it writes past Python."""
    sys.stdout.flush()
    kept = os.dup(1)
    with open(os.devnull, "w") as nothing:
        os.dup2(nothing.fileno(), 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)


def build():
    """A grey room's corner with a box, a ball lamp and a dim world; a camera."""
    with quiet():
        bpy.ops.wm.read_factory_settings(use_empty=True)
    if not hasattr(bpy.types.Scene, "sundog"):
        sundog.register()
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=8)
    floor = bpy.context.object
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 0.5), rotation=(0, 0, 0.5))
    for index, thing in enumerate((floor, bpy.context.object)):
        material = bpy.data.materials.new(thing.name)
        material.use_nodes = True
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = (0.6, 0.6, 0.6, 1) if index else (0.4, 0.4, 0.4, 1)
        shader.inputs["Roughness"].default_value = 1.0
        shader.inputs["Specular IOR Level"].default_value = 0.0
        thing.data.materials.append(material)
    lamp = bpy.data.lights.new("lamp", "POINT")
    lamp.energy, lamp.shadow_soft_size = 200, 0.3
    if hasattr(lamp, "use_soft_falloff"):
        lamp.use_soft_falloff = False
    node = bpy.data.objects.new("lamp", lamp)
    node.location = (2, -2, 3)
    scene.collection.objects.link(node)
    world = bpy.data.worlds.new("world")
    scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes.get("Background")
    background.inputs["Color"].default_value = (0.2, 0.2, 0.2, 1)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0, -5, 2.5), (math.radians(66), 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *SIZE, 100
    scene.sundog.samples = SAMPLES
    return scene


def values(owner):
    """All settings of a struct that can be set, those of its structs included."""
    found = {}
    for prop in owner.bl_rna.properties:
        if prop.identifier == "rna_type":
            continue
        if prop.type == "POINTER":
            inner = getattr(owner, prop.identifier)
            if prop.identifier in {"image_settings", "view_settings", "display_settings"} and inner is not None:
                found[prop.identifier] = values(inner)
        elif prop.type != "COLLECTION" and not prop.is_readonly:
            value = getattr(owner, prop.identifier)
            found[prop.identifier] = list(value) if getattr(prop, "is_array", False) else value
    return found


def everything(scene):
    """Settings that a comparison might touch."""
    return {
        "scene": {key: value for key, value in values(scene).items() if key != "rna_type"},
        "render": values(scene.render),
        "cycles": values(scene.cycles),
        "sundog": values(scene.sundog),
        "images": sorted(image.name for image in bpy.data.images if image.type != "RENDER_RESULT"),
    }


def pixels(path, colorspace=None):
    """Rows from the bottom, RGBA."""
    image = bpy.data.images.load(path)
    try:
        if colorspace:
            image.colorspace_settings.name = colorspace
        found = numpy.empty(len(image.pixels), numpy.float32)
        image.pixels.foreach_get(found)
        return found.reshape(image.size[1], image.size[0], -1)
    finally:
        bpy.data.images.remove(image)


class Compare(unittest.TestCase):
    """One comparison at matched settings, looked at from all sides."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.scene = build()
        # Settings that a comparison has to leave as they are.
        cls.scene.cycles.samples, cls.scene.cycles.use_adaptive_sampling, cls.scene.cycles.film_exposure = 7, True, 1.5
        cls.scene.cycles.pixel_filter_type, cls.scene.cycles.filter_width, cls.scene.cycles.max_bounces = "GAUSSIAN", 2.5, 3
        cls.scene.sundog.film_exposure = 0.5
        cls.scene.sundog.time_limit, cls.scene.sundog.use_animated_seed = 100.0, True
        cls.scene.render.filepath, cls.scene.render.use_motion_blur, cls.scene.render.dither_intensity = "//somewhere", True, 0.7
        cls.scene.render.image_settings.file_format = "JPEG"
        cls.before = everything(cls.scene)
        cls.told = []
        cls.out = os.path.join(cls.folder, "out")
        with quiet():
            cls.found = sundog.compare.run(None, cls.out, report=lambda *event: cls.told.append(event))
        cls.after = everything(cls.scene)

    def test_the_files_are_there(self):
        self.assertEqual(sorted(os.listdir(self.out)), sorted(FILES))
        with open(os.path.join(self.out, "comparison.json"), encoding="utf-8") as file:
            self.assertEqual(json.load(file), json.loads(json.dumps(self.found)))
        with open(os.path.join(self.out, "comparison.md"), encoding="utf-8") as file:
            text = file.read()
        self.assertIn("It contains the noise of both", text)
        for label in ("Export / synchronization", "ns per pixel sample", "Mean luminance ratio", "FLIP, Standard view"):
            self.assertIn(f"| {label} | ", text)
        for name in ("sundog", "cycles"):
            self.assertEqual(pixels(os.path.join(self.out, f"{name}.exr")).shape[:2], SIZE[::-1])

    def test_settings_are_put_back(self):
        self.assertEqual(self.before, self.after)

    def test_progress_grows_and_ends(self):
        fractions = [fraction for fraction, _ in self.told]
        self.assertEqual(fractions, sorted(fractions))
        self.assertEqual(fractions[-1], 1.0)

    def test_times_and_samples_are_sound(self):
        for side in self.found["engines"].values():
            self.assertEqual(side["samples"], [SAMPLES])
            self.assertGreater(side["render"], 0)
            # Cycles rounds to a hundredth of a second.
            self.assertLessEqual(side["export"] + (side["prepare"] or 0) + side["render"], side["whole_call"] + 0.02)
            self.assertAlmostEqual(side["ns_per_sample"], side["render"] * 1e9 / (SIZE[0] * SIZE[1] * SAMPLES), places=3)

    def test_the_luminances_agree_within_their_noise(self):
        linear = self.found["linear"]
        # The noise of the pixels is independent, so that their mean has this standard error at most, bias included.
        standard_error = LUMINANCE_OVER_CHANNELS * linear["rmse"] / math.sqrt(SIZE[0] * SIZE[1])
        self.assertLess(abs(linear["mean_luminance_a"] - linear["mean_luminance_b"]), SIGMAS * standard_error)
        self.assertGreater(linear["mean_luminance_b"], 0.05)
        self.assertGreater(linear["rel_mse"], 0)
        self.assertEqual(linear["non_finite_a"] + linear["non_finite_b"], 0)

    def test_the_measures_are_those_of_the_files(self):
        a, b = (pixels(os.path.join(self.out, f"{name}.exr"))[:, :, :3].astype(float) for name in ("sundog", "cycles"))
        self.assertAlmostEqual(self.found["linear"]["rel_mse"], float(((a - b) ** 2 / (b**2 + 0.01)).mean()), places=6)
        luminance = a.mean(axis=(0, 1)) @ numpy.array([0.2126, 0.7152, 0.0722])
        self.assertAlmostEqual(self.found["linear"]["mean_luminance_a"], luminance, places=5)

    def test_the_pictures_are_shown_through_the_scenes_view(self):
        path, _ = preferences.find_program()
        config = os.path.join(bpy.utils.resource_path("LOCAL"), "datafiles", "colormanagement", "config.ocio")
        self.assertTrue(os.path.isfile(config), config)
        for name in ("sundog", "cycles"):
            own = os.path.join(self.folder, f"{name}-own.png")
            subprocess.run(
                [path, "color", "apply", os.path.join(self.out, f"{name}.exr"), own, "--ocio", config, "--display",
                 self.scene.display_settings.display_device, "--view", self.scene.view_settings.view_transform],
                check=True, capture_output=True,
            )  # fmt: skip
            difference = pixels(own, "Non-Color") - pixels(os.path.join(self.out, f"{name}.png"), "Non-Color")
            self.assertLessEqual(numpy.abs(difference).max() * 255, 1.01)


class Switches(unittest.TestCase):
    """What the view layer or the settings leave out, both engines leave out."""

    def agree(self, scene):
        with tempfile.TemporaryDirectory() as folder, quiet():
            linear = sundog.compare.run(None, folder, samples=SAMPLES)["linear"]
        standard_error = LUMINANCE_OVER_CHANNELS * linear["rmse"] / math.sqrt(SIZE[0] * SIZE[1])
        self.assertLess(abs(linear["mean_luminance_a"] - linear["mean_luminance_b"]), SIGMAS * standard_error + 1e-6)
        return linear["mean_luminance_b"]

    def test_view_layers(self):
        scene = build()
        layer = scene.view_layers[0]
        whole = self.agree(scene)
        for name in ("use_sky", "use_solid"):
            with self.subTest(name):
                setattr(layer, name, False)
                self.assertGreater(abs(self.agree(scene) / whole - 1), 0.1)
                setattr(layer, name, True)

    def test_caustics(self):
        scene = build()
        for index, thing in enumerate(o for o in scene.objects if o.type == "MESH"):
            shader = thing.data.materials[0].node_tree.nodes["Principled BSDF"]
            shader.inputs["Specular IOR Level"].default_value = 0.5
            shader.inputs["Roughness"].default_value = 0.3
            if index:
                shader.inputs["Metallic"].default_value = 0.5
                shader.inputs["Transmission Weight"].default_value = 0.5
        found = []
        for reflective, refractive in ((True, True), (True, False), (False, True), (False, False)):
            scene.sundog.caustics_reflective, scene.sundog.caustics_refractive = reflective, refractive
            with self.subTest((reflective, refractive)):
                found.append(self.agree(scene))
        self.assertLess(found[3], found[0])


class Ways(unittest.TestCase):
    """Other ways in, and what goes wrong."""

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.scene = build()
        self.scene.render.resolution_percentage = 25
        self.out = os.path.join(self.folder, "out")

    def run_quietly(self, *given, **named):
        with quiet():
            return sundog.compare.run(*given, **named)

    def test_cycles_as_it_is(self):
        self.scene.cycles.samples, self.scene.cycles.use_adaptive_sampling, self.scene.cycles.use_denoising = 3, False, False
        found = self.run_quietly(None, self.out, samples=2, cycles_defaults=True)
        self.assertEqual([found["engines"][name]["samples"] for name in ("Sundog", "Cycles")], [[2], [3]])
        self.assertFalse(found["matched"])

    def test_view_layers_with_samples_of_their_own(self):
        self.scene.view_layers[0].samples = 5
        self.scene.view_layers.new("second")
        self.scene.cycles.use_layer_samples = "IGNORE"
        for samples, expected in ((None, [5, 3]), (4, [4, 4])):
            self.scene.sundog.samples = 3
            found = self.run_quietly(None, self.out, samples=samples)
            for side in found["engines"].values():
                self.assertEqual(side["samples"], expected)
                self.assertAlmostEqual(side["ns_per_sample"], side["render"] * 1e9 / (16 * 9 * sum(expected)), places=3)
        self.assertEqual((self.scene.view_layers[0].samples, self.scene.cycles.use_layer_samples), (5, "IGNORE"))

    def test_another_frame_and_size(self):
        self.scene.camera.location.x = -100
        self.scene.camera.keyframe_insert("location", frame=1)
        self.scene.camera.location.x = 0
        self.scene.camera.keyframe_insert("location", frame=5)
        self.scene.frame_set(1)
        found = self.run_quietly(None, self.out, samples=2, frame=5, percentage=50)
        self.assertEqual((found["size"], found["frame"]), ([32, 18], 5))
        self.assertEqual((self.scene.frame_current, self.scene.render.resolution_percentage), (1, 25))
        self.assertAlmostEqual(self.scene.camera.matrix_world.translation.x, -100, places=4)

    def test_no_camera(self):
        self.scene.camera = None
        with self.assertRaisesRegex(sundog.compare.CompareError, 'the scene "Scene" has no camera'):
            self.run_quietly(None, self.out)

    def test_a_program_that_fails(self):
        bad = os.path.join(self.folder, "bad")
        with open(bad, "w") as file:
            file.write("#!/bin/sh\nexit 3\n")
        os.chmod(bad, 0o755)
        before = everything(self.scene)
        with program(bad), self.assertRaisesRegex(sundog.compare.CompareError, "bad"):
            self.run_quietly(None, self.out)
        self.assertEqual(everything(self.scene), before)

    def test_a_folder_that_cannot_be_made(self):
        with open(self.out, "w"):
            pass
        with self.assertRaisesRegex(sundog.compare.CompareError, "cannot be made"):
            self.run_quietly(None, self.out)

    def test_the_command(self):
        blend = os.path.join(self.folder, "file.blend")
        with quiet():
            bpy.ops.wm.save_as_mainfile(filepath=blend)
        from sundog.compare import command

        said = io.StringIO()
        with quiet(), contextlib.redirect_stdout(said):
            code = command.execute(["compare", blend, "-o", self.out, "--samples", "2"])
        self.assertEqual(code, 0, said.getvalue())
        self.assertIn("| Samples a pixel | 2 | 2 |", said.getvalue())
        self.assertEqual(sorted(os.listdir(self.out)), sorted(FILES))
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            self.assertEqual(command.execute(["compare", os.path.join(self.folder, "none.blend"), "-o", self.out]), 1)
            self.assertEqual(command.execute(["compare", blend]), 2)
            self.assertEqual(command.execute(["compare", blend, "-o", self.out, "--samples", "0"]), 2)
        self.assertIn("there is no file", said.getvalue())

    def test_error_against_time(self):
        from sundog.compare import convergence

        self.assertEqual([convergence.doubling(most) for most in (1, 2, 3, 8)], [[1], [1, 2], [1, 2, 3], [1, 2, 4, 8]])
        self.scene.sundog.max_bounces = 2
        # Passes have flags that the command line of the measuring has not.
        layer = self.scene.view_layers[0]
        layer.use_pass_mist = layer.use_pass_ambient_occlusion = layer.sundog.use_centre_passes = True
        before = everything(self.scene)
        with quiet():
            found = sundog.compare.converge(None, self.out, samples=4, seeds=2)
        self.assertEqual(everything(self.scene), before)
        self.assertEqual([(one["seed"], one["samples"]) for one in found["pictures"]], [(s, n) for s in (0, 1) for n in (1, 2, 4)])
        self.assertEqual(sorted(os.listdir(self.out)), sorted(
            [one["file"] for one in found["pictures"]] + found["reference"] + ["cycles.times.json", "scene"]))
        for one in found["pictures"]:
            self.assertGreater(one["seconds"], 0)
            self.assertEqual(pixels(os.path.join(self.out, one["file"])).shape[:2], (9, 16))
        first, second = (pixels(os.path.join(self.out, f"cycles-{seed}-4.exr")) for seed in (0, 1))
        self.assertGreater(numpy.abs(first - second).max(), 0)
        # What it says measures it: the scene is the same, so that the references lie apart by less than a few percent.
        path, _ = preferences.find_program()
        command = found["command"].split()
        self.assertEqual(command[0], "sundog")
        self.assertIn("--bounces", command)
        done = subprocess.run([path, *command[1:], "--json"], check=False, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        answer = json.loads(done.stdout.splitlines()[-1])["answer"]
        self.assertEqual([(curve["name"][:6], [row["samples"] for row in curve["rows"]]) for curve in answer["renderers"]],
                         [("Sundog", [1, 2, 4]), ("Cycles", [1, 2, 4])])
        apart = answer["renderers"][1]["reference_apart"]
        self.assertTrue(apart["without_noise"])
        self.assertLess(apart["rel_mse"], 0.05**2 + SIGMAS * apart["standard_error"])

    def test_the_command_for_error_against_time(self):
        blend = os.path.join(self.folder, "file.blend")
        with quiet():
            bpy.ops.wm.save_as_mainfile(filepath=blend)
        from sundog.compare import command

        said = io.StringIO()
        with quiet(), contextlib.redirect_stdout(said):
            code = command.execute(["compare", blend, "-o", self.out, "--samples", "1", "--converge", "--seeds", "1", "--cycles-defaults"])
        self.assertEqual(code, 0, said.getvalue())
        self.assertIn("sundog converge", said.getvalue())
        with open(os.path.join(self.out, "cycles.times.json"), encoding="utf-8") as file:
            self.assertEqual(len(json.load(file)["pictures"]), 1)

    def test_the_operator_loads_the_pictures(self):
        self.scene.sundog_compare.percentage = 100
        self.scene.sundog_compare.own_samples, self.scene.sundog_compare.samples = True, 2
        for _ in range(2):
            # A second comparison takes the place of the first one's pictures.
            with quiet():
                self.assertEqual(bpy.ops.sundog.compare(), {"FINISHED"})
            images = {image.name: list(image.size) for image in bpy.data.images if image.get("sundog_compare")}
            self.assertEqual(set(images), {"Sundog", "Cycles", "Difference"})
            self.assertEqual(images["Sundog"], [16, 9])
            self.assertTrue(all(bpy.data.images[name].packed_file for name in images))

    def test_the_operator_reports_a_failure(self):
        bad = os.path.join(self.folder, "bad")
        with open(bad, "w") as file:
            file.write("#!/bin/sh\nexit 3\n")
        os.chmod(bad, 0o755)
        with program(bad), quiet(), self.assertRaisesRegex(RuntimeError, "bad"):
            bpy.ops.sundog.compare()


@contextlib.contextmanager
def program(path):
    """Another program."""
    before = os.environ.get("SUNDOG_PROGRAM")
    os.environ["SUNDOG_PROGRAM"] = path
    try:
        yield
    finally:
        del os.environ["SUNDOG_PROGRAM"]
        if before is not None:
            os.environ["SUNDOG_PROGRAM"] = before


class Header(unittest.TestCase):
    def test_times(self):
        from sundog.compare import exr_header

        for text, seconds in (("00:00.12", 0.12), ("03:02.10", 182.1), ("04:03:02.10", 14582.1), ("2:00:00:01.00", 172801.0)):
            self.assertAlmostEqual(exr_header.seconds(text), seconds)

    def test_broken_files(self):
        from sundog.compare import exr_header

        with tempfile.NamedTemporaryFile() as file:
            for content in (b"", b"no", exr_header.MAGIC + b"\x02\0\0\0name", exr_header.MAGIC + b"\x02\0\0\0a\0string\0\xff\xff\xff\x7f"):
                file.seek(0)
                file.truncate()
                file.write(content)
                file.flush()
                with self.assertRaises(ValueError):
                    exr_header.text_attributes(file.name)


if __name__ == "__main__":
    unittest.main()
