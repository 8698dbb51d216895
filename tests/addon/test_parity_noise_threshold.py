# SPDX-License-Identifier: GPL-3.0-or-later
"""The noise threshold beside Cycles': the samples that a file takes, and its picture."""

import math
import os
import unittest

import bpy
import numpy

import export_kit as kit
from engine_kit import EngineTest
from sundog import properties

WIDTH, HEIGHT, MOST = 96, 64, 1024
COUNT = "ViewLayer.Debug Sample Count"


class NoiseThreshold(EngineTest):
    """Settings copied from Cycles, and both engines' files."""

    def setUp(self):
        super().setUp()
        self.scene.render.resolution_x, self.scene.render.resolution_y = WIDTH, HEIGHT
        cycles, layer = self.scene.cycles, self.scene.view_layers[0]
        cycles.samples, cycles.use_adaptive_sampling, cycles.adaptive_threshold = MOST, True, 0.01
        cycles.use_denoising = False
        cycles.sample_clamp_indirect = cycles.blur_glossy = 0
        layer.cycles.pass_debug_sample_count = True

    def both(self):
        """(sample counts, picture) of Sundog and of Cycles."""
        properties.copy_from_cycles(self.scene)
        self.scene.sundog.denoising = "OFF"
        found = []
        for engine in ("SUNDOG", "CYCLES"):
            self.scene.render.engine = engine
            passes = self.render(engine)
            found.append((passes[COUNT][..., 0].astype(float), passes["ViewLayer.Combined"][..., :3].astype(float)))
        return found

    def compare(self, name, off=0.15, **settings):
        for key, value in settings.items():
            setattr(self.scene.cycles, key, value)
        (a, ours), (b, theirs) = self.both()
        # Cycles' pass is a share of the most samples that a pixel has. Both take the same ones before the first look.
        b *= a.min() / b.min()
        self.assertLessEqual(b.max(), MOST + 0.5)
        self.assertLess(numpy.abs(b - b.round()).max(), 1e-2)
        samples, mean = a.mean() / b.mean() - 1, ours.mean() / theirs.mean() - 1
        print(f"{name}: {a.mean():.1f} samples a pixel, Cycles {b.mean():.1f} ({samples:+.1%}), least {a.min():.0f}, most {a.max():.0f} and {b.max():.0f}, picture {mean:+.2%}", flush=True)
        self.assertLess(abs(mean), 0.01, name)
        self.assertLess(abs(samples), off, name)

    def test_the_default_scene(self):
        self.compare("cube under a sky")
        self.compare("cube under a sky, 0.05", adaptive_threshold=0.05)
        self.compare("cube under a sky, at least 200", adaptive_min_samples=200)

    def test_a_room_with_a_small_lamp(self):
        bpy.ops.mesh.primitive_cube_add(size=8, location=(0, 0, 2))
        room = bpy.context.object
        room.data.materials.append(kit.material("wall", Base_Color=(0.7, 0.6, 0.5, 1), Roughness=0.6))
        for light in [o for o in self.scene.objects if o.type == "LIGHT"]:
            bpy.data.objects.remove(light)
        bpy.ops.object.light_add(type="AREA", location=(1, 1, 4))
        bpy.context.object.data.energy, bpy.context.object.data.size = 100, 0.3
        camera = self.scene.camera
        camera.location, camera.rotation_euler = (3.5, -3.5, 2), (math.radians(75), 0, math.radians(45))
        camera.data.angle = 1.2
        self.compare("room")
        self.compare("room, 0.1", adaptive_threshold=0.1)

    def test_glass_and_metal(self):
        cube = bpy.data.objects["Cube"]
        bpy.data.objects.remove(cube)
        for x, values in ((-1.2, dict(Transmission_Weight=1.0, Roughness=0.0)), (1.2, dict(Metallic=1.0, Roughness=0.2))):
            bpy.ops.mesh.primitive_uv_sphere_add(radius=1, location=(x, 0, 0))
            bpy.context.object.data.shade_smooth()
            bpy.context.object.data.materials.append(kit.material(f"ball {x}", **values))
        self.compare("glass and metal")


if __name__ == "__main__":
    unittest.main()
