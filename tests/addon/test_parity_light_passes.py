# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes of light and colour beside Cycles', one by one: each lobe's direct and indirect light, below surfaces, in volumes; and the switches of caustics."""

import math
import unittest

import bpy
import numpy

import export_kit as kit
from engine_kit import EngineTest

WIDTH, HEIGHT, SAMPLES = 48, 32, 512
LOBES = ("diffuse", "glossy", "transmission")


def name_of(lobe, part):
    """Blender's name of a pass."""
    if bpy.app.version >= (5, 0, 0):
        return f"{lobe.title()} {part.title()}"
    short = {"diffuse": "Diff", "glossy": "Gloss", "transmission": "Trans", "volume": "Volume"}
    return short[lobe] + {"direct": "Dir", "indirect": "Ind", "color": "Col"}[part]


def picture(passes, name):
    """The colours of a pass."""
    return passes[f"ViewLayer.{name}"][..., :3].astype(float)


def light(passes, lobe, part):
    """The light of a lobe as it is in the picture."""
    direct = picture(passes, name_of(lobe, part))
    return direct if lobe == "volume" else direct * picture(passes, name_of(lobe, "color"))


class LightPasses(EngineTest):
    """One scene by both engines."""

    def setUp(self):
        super().setUp()
        scene = self.for_both((WIDTH, HEIGHT), SAMPLES)
        cycles, layer = scene.cycles, scene.view_layers[0]
        kit.unbiased(cycles)
        # Behind glass they are rare bright samples, which decide the means; the switches have a test of their own.
        cycles.caustics_reflective = cycles.caustics_refractive = False
        for lobe in LOBES:
            for part in ("direct", "indirect", "color"):
                setattr(layer, f"use_pass_{lobe}_{part}", True)
        layer.use_pass_emit = layer.use_pass_environment = True
        layer.cycles.use_pass_volume_direct = layer.cycles.use_pass_volume_indirect = True
        bpy.data.objects["Light"].data.shadow_soft_size = 0.8
        cube = bpy.data.objects["Cube"]
        cube.active_material = kit.material("plastic", Base_Color=(0.6, 0.2, 0.1, 1), Roughness=0.4, Coat_Weight=0.5, Coat_Roughness=0.3)
        self.ball("metal", (2, 0.5, -0.1), 0.8, Base_Color=(0.9, 0.7, 0.3, 1), Metallic=1.0, Roughness=0.35)
        self.ball("glass", (1.7, -2, 0), 0.8, Base_Color=(0.8, 0.9, 1, 1), Transmission_Weight=1.0, Roughness=0.4)
        # Through a single surface lamps are found. A rougher one has more of their light in Cycles (docs/cycles.md).
        bpy.ops.mesh.primitive_plane_add(size=1.2, location=(0.5, -3, 0.3), rotation=(math.radians(100), 0, 0.5))
        bpy.context.object.name = "pane"
        bpy.context.object.data.materials.append(kit.material("pane", Base_Color=(0.7, 0.9, 0.6, 1), Transmission_Weight=1.0, Roughness=0.25))
        bpy.ops.mesh.primitive_plane_add(size=1, location=(-2, -1, 0.5), rotation=(math.radians(70), 0, 0.6))
        bpy.context.object.data.materials.append(kit.material("shine", Emission_Color=(1, 0.6, 0.2, 1), Emission_Strength=2.0))

    @staticmethod
    def ball(name, place, radius, **inputs):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=radius, location=place)
        ball = bpy.context.object
        ball.data.shade_smooth()
        ball.name = name
        ball.data.materials.append(kit.material(name, **inputs))
        return ball

    def compare(self, lobes, others=(), title=""):
        """The light of each lobe, times its colour as compositors take it, and passes by name."""
        ours, theirs = self.both()
        for lobe in lobes:
            for part in ("direct", "indirect"):
                self.near(title + name_of(lobe, part), *([light(passes, lobe, part) for passes in found] for found in (ours, theirs)))
        for name in others:
            self.near(title + name, *([picture(passes, name) for passes in found] for found in (ours, theirs)))

    def near(self, name, ours, theirs):
        """Pictures of two seeds by both. The product of two differences is without noise; what seeds differ by tells the means' own."""
        reference = numpy.mean(theirs, axis=0)
        self.assertGreater(reference.mean(), 1e-4, name)
        products = ((ours[0] - theirs[0]) * (ours[1] - theirs[1]) / (reference**2 + 0.01)).mean(axis=-1)
        error, doubt = products.mean(), products.std() / math.sqrt(products.size)
        level = reference.mean()
        mean = numpy.mean(ours) / level - 1
        pixels = [((two[0] - two[1]) / 2).mean(axis=-1) for two in (ours, theirs)]
        noise = math.sqrt(sum((p**2).sum() for p in pixels)) / pixels[0].size / level
        print(f"{name}: mean {mean:+.2%} ± {noise:.2%}, relMSE {error:.1e} ± {doubt:.0e}", flush=True)
        with self.subTest(name):
            self.assertLess(noise, 0.015)
            self.assertLess(abs(mean) - 2 * noise, 0.01)
            self.assertLess(error - 2 * doubt, 1e-3)

    def test_lobes(self):
        five = bpy.app.version >= (5, 0, 0)
        colors = [name_of(lobe, "color") for lobe in LOBES]
        self.compare(LOBES, ["Combined", *colors, *(("Emission", "Environment") if five else ("Emit", "Env"))])

    def test_light_below_surfaces_is_diffuse(self):
        """Cycles has no passes of its own for it since 2.90."""
        skin = {"Base_Color": (0.9, 0.6, 0.4, 1), "Subsurface_Weight": 1.0, "Roughness": 0.5}
        for thing in ("metal", "glass"):
            bpy.data.objects.remove(bpy.data.objects[thing])
        self.ball("skin", (1.7, -2, 0), 0.9, **skin).data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Subsurface Scale"].default_value = 0.3
        self.compare(["diffuse"], [name_of("diffuse", "color")], "below: ")

    def test_light_groups_of_what_volumes_emit(self):
        """One cloud within another: what both emit where they overlap is in the group of the one that was entered last."""
        layer = self.scene.view_layers[0]
        for number, (group, size, color) in enumerate((("large", 3.0, (1, 0.5, 0.2, 1)), ("small", 1.4, (0.1, 0.3, 1, 1)))):
            layer.lightgroups.add(name=group)
            bpy.ops.mesh.primitive_cube_add(size=size, location=(1.6, -1.8, 0.2), rotation=(0.1, 0.2, 0.3))
            cloud = bpy.context.object
            cloud.lightgroup = group
            cloud.data.materials.append(bpy.data.materials.new(group))
            cloud.data.materials[0].use_nodes = True
            tree = cloud.data.materials[0].node_tree
            tree.nodes.clear()
            volume, out = tree.nodes.new("ShaderNodeVolumePrincipled"), tree.nodes.new("ShaderNodeOutputMaterial")
            volume.inputs["Density"].default_value, volume.inputs["Emission Strength"].default_value = 0.3, 0.4
            volume.inputs["Emission Color"].default_value = color
            if number:
                # What varies is another way through the program.
                noise = tree.nodes.new("ShaderNodeTexNoise")
                tree.links.new(noise.outputs[0], volume.inputs["Emission Strength"])
            tree.links.new(volume.outputs[0], out.inputs["Volume"])
        for thing in ("metal", "glass"):
            bpy.data.objects.remove(bpy.data.objects[thing])
        self.compare([], ["Combined", "Combined_large", "Combined_small"], "emission of volumes: ")

    def test_volumes(self):
        bpy.ops.mesh.primitive_cube_add(size=1.6, location=(1.6, -1.8, 0))
        fog = bpy.data.materials.new("fog")
        fog.use_nodes = True
        tree = fog.node_tree
        tree.nodes.clear()
        scatter, out = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeOutputMaterial")
        scatter.inputs["Density"].default_value, scatter.inputs["Color"].default_value = 1.5, (0.9, 0.7, 0.5, 1)
        tree.links.new(scatter.outputs[0], out.inputs["Volume"])
        bpy.context.object.data.materials.append(fog)
        for thing in ("metal", "glass"):
            bpy.data.objects.remove(bpy.data.objects[thing])
        self.scene.cycles.volume_bounces = 3
        self.compare(["volume", "diffuse"], title="fog: ")

    @kit.long
    def test_switches_of_caustics(self):
        """A rough mirror and rough glass before a floor, by each switch alone and by both."""
        for reflective, refractive in ((True, False), (False, True), (True, True)):
            self.scene.cycles.caustics_reflective, self.scene.cycles.caustics_refractive = reflective, refractive
            self.compare(["diffuse"], ["Combined"], f"caustics {'reflected' * reflective} {'refracted' * refractive}: ")


if __name__ == "__main__":
    unittest.main()
