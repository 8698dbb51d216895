# SPDX-License-Identifier: GPL-3.0-or-later
"""The package that `make addon` makes: what is in it, that Blender takes it, and that its program runs with nothing else.

    PYTHON tests/addon/test_package.py [--sundog PROGRAM] [--bpy PYTHON]... [unittest's own arguments]

Any Python 3.11 will do; Blender runs in processes of its own, one for each `--bpy` (a Python that has bpy).
"""

import glob
import json
import os
import re
import stat
import struct
import subprocess
import sys
import tempfile
import unittest
import zipfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "scripts"))

import addon  # noqa: E402
from elf import Elf  # noqa: E402

PROGRAM = os.path.join(ROOT, "target", "release", "sundog")
PYTHONS = []

# Installs the package as the preferences do, in a Blender with settings of its own, renders Blender's first scene (a cube
# and a lamp), and says what came of it.
INSTALL = """
import json, os, stat, subprocess, sys
os.environ.pop("SUNDOG_PROGRAM", None)
import bpy
done = bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
name = "bl_ext.user_default.sundog"
module = sys.modules[name]
bundled = __import__(name + ".bundled", fromlist=["program"])
program = bundled.program()
said = subprocess.run([program, "--version"], capture_output=True, text=True, env={})
scene = bpy.context.scene
scene.render.engine = "SUNDOG"
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 32, 18, 100
scene.sundog.samples = 4
if hasattr(scene.render.image_settings, "media_type"):
    scene.render.image_settings.media_type = "IMAGE"
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.filepath = os.path.join(os.environ["BLENDER_USER_RESOURCES"], "picture.exr")
rendered = bpy.ops.render.render(write_still=True)
image = bpy.data.images.load(scene.render.filepath)
engine = __import__(name + ".engine", fromlist=["last_statistics"])
statistics = engine.last_statistics()
print("TOLD " + json.dumps({
    "done": sorted(done),
    "enabled": name in bpy.context.preferences.addons,
    "program": os.path.relpath(program, bundled.FOLDER),
    "executable": bool(os.stat(program).st_mode & stat.S_IXUSR),
    "inside": bundled.FOLDER.startswith(os.environ["BLENDER_USER_RESOURCES"]),
    "version": said.stdout,
    "rendered": sorted(rendered),
    "size": list(image.size),
    "brightest": max(image.pixels[:]),
    "ran": [statistics["program"] == program, statistics["program_source"]],
}))
bpy.ops.preferences.addon_disable(module=name)
print("TOLD " + json.dumps({"left": hasattr(bpy.types.Scene, "sundog")}))
"""


def write_scene(folder):
    """A square that shines at a camera: every pixel is 0.5, 1, 2 where it covers the picture."""
    points = struct.pack("<12f", -4, -4, 0, 4, -4, 0, 4, 4, 0, -4, 4, 0) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    with open(os.path.join(folder, "scene.bin"), "wb") as file:
        file.write(points)
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 3]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "materials": [{
            "emissiveFactor": [0.25, 0.5, 1],
            "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1},
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 2}, "KHR_materials_specular": {"specularFactor": 0}},
        }],
        "extensionsUsed": ["KHR_materials_emissive_strength", "KHR_materials_specular"],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-4, -4, 0], "max": [4, 4, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "buffers": [{"uri": "scene.bin", "byteLength": 60}],
    }
    path = os.path.join(folder, "scene.gltf")
    with open(path, "w") as file:
        json.dump(scene, file)
    return path


def blender_root(python):
    """The folder of Blender's own files in a Python that has bpy: …/site-packages/bpy/4.5."""
    prefix = os.path.dirname(os.path.dirname(python))
    (found,) = glob.glob(os.path.join(prefix, "lib", "python3.*", "site-packages", "bpy", "[0-9]*.[0-9]*"))
    return found


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = cls.temporary.name
        cls.files = addon.package(PROGRAM)
        cls.zip = os.path.join(cls.folder, f"sundog-{addon.crate_version()}-linux-x64.zip")
        addon.write_zip(cls.zip, cls.files)
        cls.unpacked = os.path.join(cls.folder, "unpacked")
        with zipfile.ZipFile(cls.zip) as archive:
            archive.extractall(cls.unpacked)
        cls.program = os.path.join(cls.unpacked, "bin", "sundog")
        os.chmod(cls.program, 0o755)

    def test_holds_what_is_needed_and_nothing_else(self):
        names = set(self.files)
        for name in ("__init__.py", "blender_manifest.toml", "bundled.py", "bin/sundog", "LICENSE", "LICENSE-MIT", "LICENSE-APACHE", "NOTICES.md", "licences/crates.txt"):
            self.assertIn(name, names)
        for name in names:
            self.assertNotRegex(name, r"__pycache__|\.pyc$|(^|/)tests/|(^|/)\.")
        libraries = sorted(name for name in names if name.startswith("lib/"))
        self.assertRegex(" ".join(libraries), r"^lib/libOpenColorIO\S* lib/libembree4\S* lib/libtbb\S*$")
        native = [name for name in names if name.startswith("licences/") and name != "licences/crates.txt"]
        self.assertTrue(any("OpenColorIO" in name for name in native), native)
        self.assertTrue(any("embree" in name for name in native), native)
        crates = self.files["licences/crates.txt"][0].decode()
        for crate in ("rayon", "exr", "colorous"):
            self.assertRegex(crates, rf"(?m)^{crate} \d\S* \(.*\): ")

    def test_has_the_version_of_the_program(self):
        manifest = self.files["blender_manifest.toml"][0].decode()
        self.assertIn(f'\nversion = "{addon.crate_version()}"\n', manifest)
        self.assertRegex(manifest, r'(?m)^platforms = \["linux-x64"\]')
        said = subprocess.run([self.program, "--version"], capture_output=True, text=True, env={}, check=True).stdout
        self.assertEqual(said.split()[:2], ["Sundog", addon.crate_version()])

    def test_is_the_same_each_time(self):
        again = os.path.join(self.folder, "again.zip")
        addon.write_zip(again, addon.package(PROGRAM))
        self.assertEqual(addon.read(self.zip), addon.read(again))
        with zipfile.ZipFile(self.zip) as archive:
            entries = archive.infolist()
        self.assertEqual([entry.filename for entry in entries], sorted(self.files))
        self.assertEqual({entry.date_time for entry in entries}, {(1980, 1, 1, 0, 0, 0)})

    def test_needs_only_itself_and_the_system(self):
        shipped = {os.path.basename(name) for name in self.files if name.startswith("lib/")}
        for name, (content, _) in self.files.items():
            if not content.startswith(b"\x7fELF"):
                continue
            elf = Elf(content, name)
            for needed in elf.needed():
                self.assertTrue(needed in shipped or addon.SYSTEM.match(needed), f"{name} needs {needed}")
            for folder in elf.rpath():
                self.assertTrue(folder.startswith("$ORIGIN"), f"{name} looks into {folder}")
            addon.check_versions(name, elf)

    def test_a_newer_glibc_than_promised_is_refused(self):
        class Newer:
            def versions(self):
                return {"GLIBC_2.2.5", "GLIBC_2.38", "GLIBCXX_3.4.21"}

        with self.assertRaisesRegex(addon.Failure, r"needs GLIBC_2\.38 and may need GLIBC_2\.34 at most"):
            addon.check_versions("a program", Newer())

    def test_loads_its_own_libraries_whatever_the_environment_says(self):
        # Files of the same names, which are no libraries, where LD_LIBRARY_PATH points.
        traps = os.path.join(self.folder, "traps")
        os.makedirs(traps, exist_ok=True)
        shipped = [os.path.basename(name) for name in self.files if name.startswith("lib/")]
        for name in shipped:
            with open(os.path.join(traps, name), "w") as file:
                file.write("no library")
        for environment in ({}, {"LD_LIBRARY_PATH": traps}):
            said = subprocess.run(["/usr/bin/ldd", self.program], capture_output=True, text=True, env=environment, check=True).stdout
            found = dict(re.findall(r"(\S+) => (\S+)", said))
            for name in shipped:
                self.assertEqual(os.path.realpath(os.path.dirname(found[name])), os.path.realpath(os.path.join(self.unpacked, "lib")))

    def test_renders_with_nothing_else(self):
        folder = os.path.join(self.folder, "rendered")
        os.makedirs(folder)
        scene = write_scene(folder)
        out = os.path.join(folder, "out.png")
        done = subprocess.run(
            [self.program, "render", scene, "-o", out, "--width", "8", "--height", "8", "--samples", "4", "--frames", folder, "--json",
             "--ocio", "ocio://default"],
            capture_output=True, text=True, env={}, cwd="/", check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(addon.read(out)[:8], b"\x89PNG\r\n\x1a\n")
        events = [json.loads(line) for line in done.stdout.splitlines()]
        last = [event for event in events if event["event"] == "frame"][-1]
        pixels = struct.unpack("<256f", addon.read(os.path.join(folder, last["file"]))[:1024])
        for channel, expected in enumerate((0.5, 1.0, 2.0, 1.0)):
            for value in pixels[channel::4]:
                self.assertAlmostEqual(value, expected, delta=1e-6 * expected)

    def test_blender_accepts_it(self):
        self.assertTrue(PYTHONS, "no --bpy was given")
        for python in PYTHONS:
            validator = os.path.join(blender_root(python), "scripts", "addons_core", "bl_pkg", "cli", "blender_ext.py")
            done = subprocess.run([python, validator, "validate", self.zip], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, f"{python}: {done.stdout}{done.stderr}")

    def test_blender_installs_it_and_renders(self):
        for python in PYTHONS:
            home = tempfile.mkdtemp(dir=self.folder)
            done = subprocess.run(
                [python, "-c", INSTALL, self.zip], capture_output=True, text=True, cwd=home, check=False,
                env={**os.environ, "BLENDER_USER_RESOURCES": home})
            told = [line for line in done.stdout.splitlines() if line.startswith("TOLD ")]
            self.assertEqual(len(told), 2, f"{python}: {done.stdout}{done.stderr}")
            self.assertEqual(json.loads(told[1].removeprefix("TOLD ")), {"left": False})
            told = json.loads(told[0].removeprefix("TOLD "))
            self.assertEqual(told["done"], ["FINISHED"])
            self.assertTrue(told["enabled"] and told["inside"] and told["executable"])
            self.assertEqual(told["program"], os.path.join("bin", "sundog"))
            self.assertTrue(told["version"].startswith(f"Sundog {addon.crate_version()}\n"), told["version"])
            self.assertEqual((told["rendered"], told["size"]), (["FINISHED"], [32, 18]))
            self.assertGreater(told["brightest"], 0.1)
            self.assertEqual(told["ran"], [True, "the add-on"])


class Rpath(unittest.TestCase):
    def test_is_shortened_and_nothing_else_changes(self):
        data = addon.read(PROGRAM)
        elf = Elf(data, PROGRAM)
        before = (elf.needed(), elf.versions())
        self.assertGreater(len(elf.rpath()), 1)
        elf.cut_rpath(["$ORIGIN"])
        again = Elf(elf.data, PROGRAM)
        self.assertEqual(again.rpath(), ["$ORIGIN"])
        self.assertEqual((again.needed(), again.versions()), before)
        self.assertEqual(len(elf.data), len(data))

    def test_another_beginning_is_refused(self):
        elf = Elf(addon.read(PROGRAM), PROGRAM)
        with self.assertRaisesRegex(ValueError, "does not begin with"):
            elf.cut_rpath(["/somewhere"])

    def test_what_is_no_program_is_refused(self):
        with self.assertRaisesRegex(ValueError, "not a 64-bit"):
            Elf(b"#!/bin/sh\n", "script")


def main():
    global PROGRAM
    words = sys.argv[1:]
    rest = []
    while words:
        word = words.pop(0)
        if word == "--sundog":
            PROGRAM = os.path.abspath(words.pop(0))
        elif word == "--bpy":
            PYTHONS.append(words.pop(0))
        else:
            rest.append(word)
    unittest.main(argv=[sys.argv[0], *rest])


if __name__ == "__main__":
    main()
