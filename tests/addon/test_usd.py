# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene by USD and by glTF: the same light, as Blender's own exporters write both."""

import os
import subprocess
import sys

import bpy
import numpy

import exr
import export_kit as kit
from engine_kit import EngineTest

WIDTH, HEIGHT = 96, 64


class SameLight(EngineTest):
    """Lamps of each kind that plain glTF knows."""

    def luminance(self, path, *extra):
        out = f"{path}.exr"
        command = [self.program, "render", path, "-o", out, "--quiet", "--samples", "64", "--exr-compression", "none"]
        subprocess.run([*command, "--width", str(WIDTH), "--height", str(HEIGHT), *extra], check=True)
        picture = next(iter(exr.passes(exr.read(out)).values()))[..., :3].astype(float)
        return float((picture @ numpy.array([0.2126, 0.7152, 0.0722])).mean())

    def test_lamps(self):
        self.scene.render.resolution_x, self.scene.render.resolution_y = WIDTH, HEIGHT
        # Plain glTF has no word for the world.
        self.scene.world = None
        lamp = next(o for o in bpy.data.objects if o.type == "LIGHT")
        # The glTF exporter of 5.2 writes suns of 683 lx whatever their strength.
        for kind, energy in (("POINT", 300.0), ("SPOT", 500.0), ("SUN", 1.0)):
            lamp.data.type = kind
            light = lamp.data
            light.energy = energy
            if kind == "SUN":
                light.angle = 0.0
            else:
                light.shadow_soft_size = 0.0
            paths = {name: os.path.join(self.folder, f"{kind}.{name}") for name in ("usdc", "usda", "glb")}
            with kit.quiet():
                bpy.ops.wm.usd_export(filepath=paths["usdc"])
                bpy.ops.wm.usd_export(filepath=paths["usda"], generate_materialx_network=True)
                bpy.ops.export_scene.gltf(filepath=paths["glb"], export_cameras=True, export_lights=True)
            theirs = self.luminance(paths["glb"], "--light-units", "standard")
            self.assertGreater(theirs, 0.0)
            for name in ("usdc", "usda"):
                ours = self.luminance(paths[name])
                print(f"{kind} by {name}: {ours:.5f}, by glTF {theirs:.5f}", flush=True)
                # Both have the same samples; what differs is the order of triangles, and rounding of the place of the lamp.
                self.assertLess(abs(ours / theirs - 1.0), 0.01)


class SamePicture(EngineTest):
    """Scenes of the project's own, as Blender's exporters write them to glTF and to USD."""

    def difference(self, one, other):
        """relMSE of two pictures."""
        done = subprocess.run([self.program, "compare", one, other], check=True, capture_output=True, text=True)
        return next(float(line.split()[1]) for line in done.stdout.splitlines() if line.startswith("relMSE"))

    def test_box(self):
        """The Cornell box: a mesh that shines, and diffuse walls."""
        sys.path.insert(0, os.path.join(kit.PROJECT, "scenes"))
        self.addCleanup(sys.path.pop, 0)
        import build

        with kit.quiet():
            build.build("cornell", self.folder, True)
            bpy.ops.wm.usd_export(filepath=os.path.join(self.folder, "cornell.usdc"), generate_materialx_network=True)
        pictures = []
        for kind in ("glb", "usdc"):
            path = os.path.join(self.folder, f"cornell.{kind}")
            command = [self.program, "render", path, "-o", f"{path}.exr", "--quiet", "--samples", "64"]
            subprocess.run([*command, "--width", str(WIDTH), "--height", str(HEIGHT)], check=True)
            pictures.append(f"{path}.exr")
        found = self.difference(*pictures)
        print(f"cornell by USD and by glTF: relMSE {found:.3g}", flush=True)
        self.assertLess(found, 1e-4)
