# SPDX-License-Identifier: GPL-3.0-or-later
"""Shadow catchers beside Cycles'."""

import math
import unittest

import bpy
import numpy

import export_kit as kit
from engine_kit import EngineTest


WIDTH, HEIGHT, SAMPLES = 48, 32, 512


class CatcherTest(EngineTest):
    """The default cube over a floor that is a catcher, by both engines."""

    def setUp(self):
        super().setUp()
        scene = self.for_both((WIDTH, HEIGHT), SAMPLES)
        scene.cycles.pixel_filter_type = "BOX"
        scene.cycles.sample_clamp_indirect, scene.cycles.blur_glossy = 0, 0
        scene.cycles.caustics_reflective = False
        self.lamp, self.cube, self.floor = (bpy.data.objects[name] for name in ("Light", "Cube", "Floor"))
        self.lamp.data.shadow_soft_size, self.lamp.data.energy = 0.5, 500
        self.cube.data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.8, 0.2, 0.1, 1)
        self.floor.is_shadow_catcher = True
        self.floor.data.materials.append(kit.material("grey", Base_Color=(0.6, 0.6, 0.6, 1)))

    def compare(self, *names, off=0.01, error=1e-3):
        """Pictures of two seeds by both: the product of two differences is without noise. All channels, alpha too."""
        ours, theirs = self.both()
        for name in names or ("Combined",):
            mine, cycles = ([passes[f"ViewLayer.{name}"].astype(float) for passes in both] for both in (ours, theirs))
            for what, channels in (("color", slice(0, 3)), ("alpha", slice(3, 4))):
                a, b = ([picture[..., channels] for picture in pictures] for pictures in (mine, cycles))
                if not a[0].size:
                    continue
                reference = numpy.mean(b, axis=0)
                mean = numpy.mean(a) / reference.mean() - 1 if reference.any() else abs(a[0]).max()
                relative = ((a[0] - b[0]) * (a[1] - b[1]) / (reference**2 + 0.01)).mean()
                print(f"{self.id().split('.')[-1]} {name} {what}: mean {reference.mean():.4f}, off {mean:+.3%}, relMSE {relative:.1e}", flush=True)
                self.assertLess(abs(mean), off, (name, what))
                self.assertLess(relative, error, (name, what))
        return ours[0]

    def with_pass(self):
        self.scene.view_layers[0].cycles.use_pass_shadow_catcher = True

    def tint(self, thing, **inputs):
        thing.data.materials[0] = kit.material(f"of {thing.name}", **inputs)


class Catchers(CatcherTest):
    def test_over_the_world(self):
        self.compare()

    def test_over_nothing(self):
        self.scene.render.film_transparent = True
        self.compare()

    @kit.long
    def test_the_pass(self):
        self.with_pass()
        for self.scene.render.film_transparent in (False, True):
            self.compare("Combined", "Shadow Catcher")

    @kit.long
    def test_a_coloured_catcher(self):
        """Light by way of the cube is coloured by the catcher, and by its colour once more where it shines back."""
        self.tint(self.floor, Base_Color=(0.9, 0.3, 0.1, 1), Roughness=0.3)
        self.with_pass()
        self.compare("Combined", "Shadow Catcher")

    @kit.long
    def test_an_object_that_reflects_it(self):
        """A mirror shows the catcher as any object."""
        self.tint(self.cube, Metallic=1, Roughness=0.05)
        self.cube.rotation_euler = (0.3, 0.2, 0.5)
        self.tint(self.floor, Base_Color=(0.2, 0.4, 0.9, 1))
        self.compare()

    @kit.long
    def test_light_of_the_scene_alone(self):
        """A lamp and a mesh that shine in the scene, and not in the photograph, brighten the catcher."""
        self.lamp.is_shadow_catcher = False
        sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
        sun.rotation_euler, sun.data.energy, sun.data.angle = (0.6, 0.3, 0), 2, math.radians(10)
        self.scene.collection.objects.link(sun)
        self.tint(self.cube, Emission_Color=(1, 0.6, 0.2, 1), Emission_Strength=3)
        self.with_pass()
        self.compare("Combined", "Shadow Catcher")

    @kit.long
    def test_an_environment_of_many_colours(self):
        tree = self.scene.world.node_tree
        sky = tree.nodes.new("ShaderNodeTexGradient")
        ramp = tree.nodes.new("ShaderNodeValToRGB")
        ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.1, 0.2, 0.8, 1), (1, 0.5, 0.1, 1)
        coordinates = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(coordinates.outputs["Generated"], sky.inputs["Vector"])
        tree.links.new(sky.outputs["Fac"], ramp.inputs["Fac"])
        tree.links.new(ramp.outputs["Color"], tree.nodes["Background"].inputs["Color"])
        self.lamp.data.energy = 50
        self.compare()

    @kit.long
    def test_two_catchers_shade_each_other(self):
        """What catchers do to each other is in the photograph."""
        bpy.ops.mesh.primitive_plane_add(size=4, location=(-2, 2, 0), rotation=(math.radians(90), 0, 0.8))
        wall = bpy.context.object
        wall.is_shadow_catcher = True
        wall.data.materials.append(kit.material("red", Base_Color=(0.9, 0.1, 0.1, 1)))
        self.with_pass()
        self.compare("Combined", "Shadow Catcher")

    @kit.long
    def test_passes_of_light_leave_the_catcher_out(self):
        layer = self.scene.view_layers[0]
        layer.use_pass_diffuse_direct = layer.use_pass_diffuse_indirect = layer.use_pass_diffuse_color = True
        layer.use_pass_environment = layer.use_pass_z = layer.use_pass_ambient_occlusion = True
        layer.lightgroups.add(name="key")
        self.lamp.lightgroup = "key"
        self.compare("Diffuse Direct", "Diffuse Indirect", "Diffuse Color", "Environment", "Ambient Occlusion", "Combined_key")

    def test_an_instancer_stands_for_what_it_places(self):
        inside = bpy.data.collections.new("inside")
        for owner in list(self.floor.users_collection):
            owner.objects.unlink(self.floor)
        inside.objects.link(self.floor)
        self.floor.is_shadow_catcher = False
        empty = bpy.data.objects.new("empty", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", inside
        empty.is_shadow_catcher = True
        self.scene.collection.objects.link(empty)
        self.compare()

    def test_holdouts_and_what_the_camera_does_not_see(self):
        """A catcher that is a holdout is a hole; one that the camera does not see is nothing."""
        self.scene.render.film_transparent = True
        self.floor.is_holdout = True
        self.compare()
        self.floor.is_holdout, self.floor.visible_camera = False, False
        self.compare()

    @kit.long
    def test_behind_glass_that_tints(self):
        """What passes a transparent sheet comes to the catcher with its colour."""
        bpy.ops.mesh.primitive_plane_add(size=6, location=(3, -3, 1.5), rotation=(math.radians(70), 0, 0.8))
        sheet = kit.material("sheet")
        tree = sheet.node_tree
        clear = tree.nodes.new("ShaderNodeBsdfTransparent")
        clear.inputs["Color"].default_value = (0.3, 0.9, 0.6, 1)
        tree.links.new(clear.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        bpy.context.object.data.materials.append(sheet)
        self.with_pass()
        self.compare("Combined", "Shadow Catcher")

    def test_a_denoised_picture(self):
        """Its noise is in the shadows alone, and the picture stays what it is."""
        self.scene.render.film_transparent = True
        plain = self.render("plain")["ViewLayer.Combined"]
        self.scene.sundog.denoising = "ON" if "ON" in {i.identifier for i in self.scene.sundog.bl_rna.properties["denoising"].enum_items} else "AUTO"
        denoised = self.render("denoised")["ViewLayer.Combined"]
        self.assertLess(abs(plain[..., 3].mean() / denoised[..., 3].mean() - 1), 0.01)

    def test_the_command_line_has_the_pass(self):
        flags = ("--width", str(WIDTH), "--height", str(HEIGHT), "--samples", "64")
        apart = self.by_command_line(*flags, "--passes", "Combined,Shadow Catcher")
        self.assertEqual(set(apart), {"", "Shadow Catcher"})
        self.assertLess(apart["Shadow Catcher"].min(), 0.8)
        whole = self.by_command_line(*flags, "--passes", "Combined", "--effects", "auto")
        self.assertTrue((whole[""][..., 3] == 1).all())


if __name__ == "__main__":
    unittest.main()
