# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles' fast GI approximation beside Cycles: bounces that short rays replace, and openness that is added."""

import math
import unittest

import bpy

import export_kit as kit

WIDTH, HEIGHT, SAMPLES = 48, 36, 256


class FastGi(kit.ExportTest):
    """A floor with a wall, a box, metal and a lamp that shines, under a sun and a grey world."""

    def setUp(self):
        super().setUp()
        self.camera.location, self.camera.rotation_euler = (0, -9, 3), (math.radians(75), 0, 0)
        self.shape("floor", kit.plane("floor", 8), Base_Color=(0.7, 0.6, 0.5, 1))
        upright = (math.radians(90), 0, 0)
        self.shape("wall", kit.plane("wall", 8), Base_Color=(0.8, 0.2, 0.2, 1)).rotation_euler = upright
        bpy.data.objects["wall"].location = (0, 3, 2)
        self.box = self.shape("box", kit.cube("box"), Base_Color=(0.3, 0.7, 0.3, 1))
        self.box.location, self.box.rotation_euler = (-1.6, 0, 1.05), (0, 0, 0.5)
        bpy.ops.mesh.primitive_uv_sphere_add(radius=1, location=(1.5, -0.5, 1.1))
        self.ball = bpy.context.object
        self.ball.data.materials.append(kit.material("metal", Base_Color=(0.9, 0.9, 0.9, 1), Metallic=1.0, Roughness=0.2))
        lamp = self.shape("lamp", kit.cube("lamp", 0.6), Emission_Color=(0.2, 0.4, 1, 1), Emission_Strength=4.0)
        lamp.location = (0.2, 1.5, 0.35)
        kit.sun_and_grey_world(self.scene)
        kit.unbiased(self.scene.cycles)
        self.cycles, self.light = self.scene.cycles, self.scene.world.light_settings
        self.cycles.use_fast_gi = True
        self.light.ao_factor, self.light.distance = 0.7, 2.0

    def shape(self, name, mesh, **inputs):
        """An object of one material."""
        mesh.materials.append(kit.material(name, **inputs))
        return self.link(name, mesh)

    def compare(self, name, off=0.004, more=("--tree-lights",)):
        """The means of both pictures by channel, and of the largest blocks of pixels."""
        theirs = kit.cycles_pixels(WIDTH, HEIGHT, SAMPLES)
        found = self.export()
        ours = kit.rendered(found.path, WIDTH, HEIGHT, SAMPLES, *more)
        means = ours.mean(axis=(0, 1)) / theirs.mean(axis=(0, 1)) - 1
        blocks = [p.reshape(HEIGHT // 12, 12, WIDTH // 12, 12, 3).mean(axis=(1, 3, 4)) for p in (ours, theirs)]
        worst = abs(blocks[0] / blocks[1] - 1).max()
        print(f"{name}: mean {', '.join(f'{m:+.2%}' for m in means)}, worst block {worst:.2%}", flush=True)
        self.assertLess(abs(means).max(), off, name)
        # Of 144 pixels.
        self.assertLess(worst, 0.035, name)
        return found

    def test_replaced_bounces(self):
        for bounces, factor, distance in ((1, 0.7, 2.0), (2, 1.5, 1.0), (1, 1.0, 0.3)):
            self.cycles.ao_bounces_render, self.light.ao_factor, self.light.distance = bounces, factor, distance
            self.compare(f"replace after {bounces}, factor {factor}, within {distance}")

    def test_added_openness(self):
        self.cycles.fast_gi_method = "ADD"
        for factor, distance in ((0.7, 2.0), (0.3, 0.5)):
            self.light.ao_factor, self.light.distance = factor, distance
            self.compare(f"add, factor {factor}, within {distance}")

    def test_off(self):
        """No bounces, no factor, no world: all bounces are traced."""
        for method, bounces, factor in (("REPLACE", 0, 1.0), ("REPLACE", 1, 0.0), ("ADD", 1, 0.0)):
            self.cycles.fast_gi_method, self.cycles.ao_bounces_render, self.light.ao_factor = method, bounces, factor
            self.assertNotIn("fast_gi", self.export().scene())
        self.light.ao_factor, self.scene.world = 1.0, None
        self.assertNotIn("fast_gi", self.export().scene())

    def test_objects_have_distances_of_their_own(self):
        self.box.cycles.ao_distance = 0.3
        bpy.data.objects["floor"].cycles.ao_distance = 6
        found = self.compare("replace, distances of objects")
        self.assertAlmostEqual(found.node("box")["extensions"]["SUNDOG_object"]["fast_gi_distance"], 0.3)
        self.assertNotIn("fast_gi_distance", found.node("wall").get("extensions", {}).get("SUNDOG_object", {}))

    def test_a_view_layers_world_has_distances_of_its_own(self):
        layer = self.scene.view_layers[0]
        world = bpy.data.worlds.new("other")
        world.light_settings.distance, world.light_settings.ao_factor = 0.5, 1.5
        layer.world_override = world
        for method in ("REPLACE", "ADD"):
            self.cycles.fast_gi_method = method
            self.compare(f"{method}, world of the view layer")
        layer.world_override, layer.use_sky = None, False
        for method in ("REPLACE", "ADD"):
            self.cycles.fast_gi_method = method
            self.compare(f"{method}, no sky")

    def test_glass_and_what_light_passes_in_part(self):
        material = self.box.data.materials[0]
        principled = next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
        ball = next(n for n in self.ball.data.materials[0].node_tree.nodes if n.type == "BSDF_PRINCIPLED")
        ball.inputs["Metallic"].default_value, ball.inputs["Transmission Weight"].default_value = 0, 1
        ball.inputs["Roughness"].default_value = 0
        principled.inputs["Alpha"].default_value = 0.4
        # They are rare and bright.
        self.cycles.caustics_reflective = self.cycles.caustics_refractive = False
        for method in ("REPLACE", "ADD"):
            self.cycles.fast_gi_method = method
            self.compare(f"{method}, glass and alpha", 0.006, ("--tree-lights", "--caustics", "none"))

    def test_below_surfaces(self):
        principled = next(n for n in self.box.data.materials[0].node_tree.nodes if n.type == "BSDF_PRINCIPLED")
        principled.inputs["Subsurface Weight"].default_value, principled.inputs["Subsurface Scale"].default_value = 1, 0.2
        for method in ("REPLACE", "ADD"):
            self.cycles.fast_gi_method = method
            self.compare(f"{method}, subsurface", 0.006)

    def test_fog(self):
        cube = kit.cube("cloud", 5.5)
        material = bpy.data.materials.new("cloud")
        material.use_nodes = True
        material.node_tree.nodes.remove(next(n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED"))
        scatter = material.node_tree.nodes.new("ShaderNodeVolumeScatter")
        scatter.inputs["Density"].default_value = 0.1
        end = next(n for n in material.node_tree.nodes if n.type == "OUTPUT_MATERIAL")
        material.node_tree.links.new(scatter.outputs[0], end.inputs["Volume"])
        cube.materials.append(material)
        self.link("cloud", cube).location = (0, 0, 2)
        self.cycles.volume_bounces = 2
        for method in ("REPLACE", "ADD"):
            self.cycles.fast_gi_method = method
            self.compare(f"{method}, a cloud", 0.01)


if __name__ == "__main__":
    unittest.main()
