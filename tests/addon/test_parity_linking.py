# SPDX-License-Identifier: GPL-3.0-or-later
"""Light groups, light linking and shadow linking beside Cycles'."""

import math
import unittest

import bpy
import numpy

import export_kit as kit
from engine_kit import EngineTest

WIDTH, HEIGHT, SAMPLES = 48, 32, 512
# Where groups of little light are compared.
MANY = 4096


class LinkingTest(EngineTest):
    """One scene by both engines."""

    def setUp(self):
        super().setUp()
        scene = self.for_both((WIDTH, HEIGHT), SAMPLES)
        scene.cycles.pixel_filter_type = "BOX"
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

    def linked(self, thing, kind, **states):
        """Links a light to objects, each included or excluded."""
        collection = bpy.data.collections.new(f"{thing.name} {kind}")
        for number, (name, state) in enumerate(states.items()):
            collection.objects.link(bpy.data.objects[name])
            collection.collection_objects[number].light_linking.link_state = state
        setattr(thing.light_linking, f"{kind}_collection", collection)

    def compare(self, *names, **limits):
        ours, theirs = self.both()
        for name in names:
            pictures = [[passes[f"ViewLayer.{name}"] for passes in both] for both in (ours, theirs)]
            self.near(name, *pictures, **limits)
        return ours[0]

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
        # The mirror's caustics of the ball are rare and bright: of a group of little light they are most of the noise.
        self.scene.cycles.caustics_reflective = False
        layer = self.scene.view_layers[0]
        for name in ("key", "of the sky", "empty"):
            layer.lightgroups.add(name=name)
        self.lamp.lightgroup = self.ball.lightgroup = "key"
        self.sun.lightgroup = self.scene.world.lightgroup = "of the sky"
        self.panel.lightgroup = "nobody's"

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

    @kit.long
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


class Linking(LinkingTest):
    @kit.long
    def test_receivers(self):
        """Lamps, a sun, a panel and a mesh that light some objects; the mirror shows them by rays of its own."""
        self.linked(self.lamp, "receiver", Cube="INCLUDE")
        self.linked(self.sun, "receiver", Floor="EXCLUDE")
        self.linked(self.panel, "receiver", Floor="INCLUDE", mirror="INCLUDE", Cube="EXCLUDE")
        self.linked(self.ball, "receiver", Cube="EXCLUDE")
        for name, thing in (("lamp", self.lamp), ("sun", self.sun), ("panel", self.panel), ("ball", self.ball)):
            thing.lightgroup = name
            self.scene.view_layers[0].lightgroups.add(name=name)
        self.lamp.data.shadow_soft_size = 0.5
        self.scene.cycles.samples = MANY
        self.compare("Combined", *(f"Combined_{name}" for name in ("lamp", "sun", "panel", "ball")))

    def test_a_light_that_nothing_receives(self):
        """One lamp alone is drawn without a look at where it shines."""
        for thing in (self.sun, self.panel, self.ball):
            bpy.data.objects.remove(thing)
        self.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
        self.linked(self.lamp, "receiver", Floor="INCLUDE")
        ours = self.compare("Combined")
        self.assertGreater(ours["ViewLayer.Combined"][..., :3].max(), 0)

    @kit.long
    def test_blockers(self):
        """What is excluded casts no shadow of lamps, a sun, a panel and a mesh."""
        self.lamp.data.shadow_soft_size = 0.5
        for thing in (self.lamp, self.sun, self.ball):
            self.linked(thing, "blocker", Cube="EXCLUDE")
        self.linked(self.panel, "blocker", ball="EXCLUDE", mirror="EXCLUDE")
        for name, thing in (("lamp", self.lamp), ("sun", self.sun), ("panel", self.panel), ("ball", self.ball)):
            thing.lightgroup = name
            self.scene.view_layers[0].lightgroups.add(name=name)
        self.scene.cycles.samples = MANY
        self.compare("Combined", *(f"Combined_{name}" for name in ("lamp", "sun", "panel", "ball")))

    def test_mirrors_show_lights_with_blockers_of_their_own(self):
        self.mirror.data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0
        self.lamp.data.shadow_soft_size = 1
        for thing in (self.lamp, self.panel, self.ball):
            self.linked(thing, "blocker", Cube="EXCLUDE")
        self.compare("Combined")

    def test_only_what_is_included_casts_shadows(self):
        self.linked(self.lamp, "blocker", Cube="INCLUDE")
        self.linked(self.sun, "blocker", mirror="INCLUDE")
        self.compare("Combined")

    def instanced(self):
        """An empty that places a collection with a board above the floor."""
        inside = bpy.data.collections.new("inside")
        bpy.ops.mesh.primitive_plane_add(size=1.5, location=(0, 0, 0))
        board = bpy.context.object
        board.name = "board"
        for owner in board.users_collection:
            owner.objects.unlink(board)
        inside.objects.link(board)
        empty = self.link("empty", None, location=(1.6, 0.8, 1.4))
        empty.instance_type, empty.instance_collection = "COLLECTION", inside
        self.lamp.data.energy = 1500

    def test_an_instancer_in_sets_stands_for_what_it_places(self):
        self.instanced()
        self.linked(self.lamp, "receiver", empty="EXCLUDE")
        self.linked(self.lamp, "blocker", empty="EXCLUDE")
        self.compare("Combined")

    def test_an_instancer_in_no_set_leaves_it_to_what_it_places(self):
        self.instanced()
        self.linked(self.lamp, "receiver", board="EXCLUDE")
        self.linked(self.lamp, "blocker", board="EXCLUDE")
        self.compare("Combined")

    def test_an_instancer_in_other_sets(self):
        self.instanced()
        self.linked(self.sun, "receiver", empty="EXCLUDE")
        self.linked(self.lamp, "receiver", board="EXCLUDE")
        self.linked(self.lamp, "blocker", board="EXCLUDE")
        self.compare("Combined")

    def test_a_lamp_that_a_collection_places(self):
        self.instanced()
        inside = bpy.data.collections["inside"]
        self.scene.collection.objects.unlink(self.panel)
        inside.objects.link(self.panel)
        self.panel.location = (-3, -2, 2)
        self.linked(self.panel, "receiver", Cube="INCLUDE", mirror="INCLUDE")
        self.linked(self.panel, "blocker", Cube="EXCLUDE")
        self.compare("Combined")

    def test_both(self):
        self.linked(self.ball, "receiver", Floor="INCLUDE", mirror="INCLUDE")
        self.linked(self.ball, "blocker", mirror="EXCLUDE")
        self.linked(self.sun, "receiver", Cube="EXCLUDE")
        self.linked(self.sun, "blocker", mirror="EXCLUDE")
        self.compare("Combined")


if __name__ == "__main__":
    unittest.main()
