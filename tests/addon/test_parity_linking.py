# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups beside Cycles'."""

import math
import unittest

import bpy
import numpy

import export_kit as kit
from engine_kit import EngineTest

from sundog import properties

WIDTH, HEIGHT, SAMPLES = 48, 32, 512


class LinkingTest(EngineTest):
    """One scene by both engines."""

    def setUp(self):
        super().setUp()
        scene = self.scene
        scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
        scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = False, False
        scene.cycles.pixel_filter_type = "BOX"
        scene.cycles.samples = SAMPLES
        scene.cycles.sample_clamp_indirect, scene.cycles.blur_glossy = 0, 0
        self.lamp = bpy.data.objects["Light"]
        self.lamp.data.energy = 300
        self.sun = self.link("sun", bpy.data.lights.new("sun", "SUN"), rotation=(0.6, 0.3, 0))
        self.sun.data.energy, self.sun.data.angle = 1.5, math.radians(20)
        self.panel = self.link("panel", bpy.data.lights.new("panel", "AREA"), location=(-2, -3, 3), rotation=(0.7, -0.4, 0))
        self.panel.data.energy = 80
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.4, location=(1.7, -1.4, 0.2))
        self.ball = bpy.context.object
        self.ball.name = "ball"
        self.ball.data.materials.append(kit.material("glow", Base_Color=(0, 0, 0, 1), Emission_Color=(1, 0.6, 0.2, 1), Emission_Strength=8))
        bpy.ops.mesh.primitive_plane_add(size=3, location=(-2.4, 1.2, 0.4), rotation=(math.radians(80), 0, 0.7))
        self.mirror = bpy.context.object
        self.mirror.name = "mirror"
        self.mirror.data.materials.append(kit.material("metal", Metallic=1, Roughness=0.2))

    def link(self, name, data, location=(0, 0, 0), rotation=(0, 0, 0)):
        made = bpy.data.objects.new(name, data)
        made.location, made.rotation_euler = location, rotation
        self.scene.collection.objects.link(made)
        return made

    def both(self):
        """The passes of Sundog's files and of Cycles', each by two seeds."""
        found = []
        for engine in ("SUNDOG", "CYCLES"):
            self.scene.render.engine = engine
            for seed in (1, 2):
                self.scene.cycles.seed = seed
                properties.copy_from_cycles(self.scene)
                self.scene.sundog.denoising = "OFF"
                found.append(self.render(f"{engine}{seed}"))
        return found[:2], found[2:]

    def near(self, name, ours, theirs, off=0.01, error=1e-3):
        """Pictures of two seeds by both: the product of two differences is without noise."""
        ours, theirs = ([picture[..., :3].astype(float) for picture in pictures] for pictures in (ours, theirs))
        reference = numpy.mean(theirs, axis=0)
        mean = numpy.mean(ours) / reference.mean() - 1 if reference.any() else abs(ours[0]).max()
        relative = ((ours[0] - theirs[0]) * (ours[1] - theirs[1]) / (reference**2 + 0.01)).mean()
        print(f"{name}: mean {reference.mean():.4f}, off {mean:+.3%}, relMSE {relative:.1e}", flush=True)
        self.assertLess(abs(mean), off, name)
        self.assertLess(relative, error, name)


class LightGroups(LinkingTest):
    def setUp(self):
        super().setUp()
        layer = self.scene.view_layers[0]
        for name in ("key", "of the sky", "empty"):
            layer.lightgroups.add(name=name)
        self.lamp.lightgroup = self.ball.lightgroup = "key"
        self.sun.lightgroup = self.scene.world.lightgroup = "of the sky"
        self.panel.lightgroup = "nobody's"

    def compare(self, *names, **limits):
        ours, theirs = self.both()
        for name in names:
            pictures = [[passes[f"ViewLayer.{name}"] for passes in both] for both in (ours, theirs)]
            self.near(name, *pictures, **limits)
        return ours[0]

    def test_light_groups(self):
        names = ("Combined", "Combined_key", "Combined_of the sky", "Combined_empty")
        ours = self.compare(*names)
        # The panel is in no group: the rest is its own.
        rest = ours["ViewLayer.Combined"][..., :3] - sum(ours[f"ViewLayer.{name}"].astype(float) for name in names[1:])
        self.panel.lightgroup = "empty"
        self.scene.render.engine = "SUNDOG"
        again = self.render("again")
        total = sum(again[f"ViewLayer.{name}"].astype(float) for name in names[1:])
        self.assertLess(abs(total - again["ViewLayer.Combined"][..., :3]).max(), 1e-4 * total.max())
        self.assertLess(abs(rest.mean() / again["ViewLayer.Combined_empty"].mean() - 1), 0.02)

    def test_with_clamping_and_a_transparent_film(self):
        scene = self.scene
        scene.render.film_transparent = True
        scene.cycles.sample_clamp_indirect, scene.cycles.film_exposure = 4, 1.5
        layer = self.scene.view_layers[0]
        for layer.use_pass_environment in (False, True):
            self.compare("Combined", "Combined_key", "Combined_of the sky")

    def test_each_light_by_the_command_line(self):
        flags = ("--width", str(WIDTH), "--height", str(HEIGHT), "--samples", "4", "--passes", "Combined")
        found = self.by_command_line(*flags, "--light-groups", "each")
        self.assertEqual(set(found), {"", *(f"Combined_{name}" for name in ("Light", "sun", "panel", "ball", "World"))})
        total = sum(found[name].astype(float) for name in found if name)
        self.assertLess(abs(total - found[""][..., :3]).max(), 1e-4 * total.max())
        self.assertEqual(set(self.by_command_line(*flags, "--light-groups", "none")), {""})
        self.assertEqual(set(self.by_command_line(*flags)), {"", "Combined_key", "Combined_of the sky", "Combined_empty"})


if __name__ == "__main__":
    unittest.main()
