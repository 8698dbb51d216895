# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: what is written, looked up in every direction, against what Cycles shows in that direction."""

import math
import os
import unittest
from unittest import mock

import bpy
import export_kit as kit
import mathutils
import numpy
from sundog.export import baker, images, world as worlds


def directions(width, height):
    """Of the texels of an equirectangular picture, the bottom row first: height × width × 3, Blender's axes.

    As Cycles has it: the middle is +X, and the azimuth falls to the right.
    """
    u, v = (numpy.arange(width) + 0.5) / width, (numpy.arange(height) + 0.5) / height
    phi, theta = -2 * math.pi * (u - 0.5), math.pi * (v - 0.5)
    x = numpy.cos(theta)[:, None] * numpy.cos(phi)
    y = numpy.cos(theta)[:, None] * numpy.sin(phi)
    return numpy.stack([x, y, numpy.broadcast_to(numpy.sin(theta)[:, None], x.shape)], axis=-1)


def radiance(world, path, toward):
    """What a SUNDOG_scene's world shines with from directions (nearest texel)."""
    color = numpy.array(world["color"])
    if "image" not in world:
        return numpy.broadcast_to(color, toward.shape)
    values = kit.exr_pixels(os.path.join(os.path.dirname(path), world["image"]))
    turned = toward @ numpy.array(world.get("rotation", [1, 0, 0, 0, 1, 0, 0, 0, 1])).reshape(3, 3).T
    height, width = values.shape[:2]
    u = 0.5 - numpy.arctan2(turned[..., 1], turned[..., 0]) / (2 * math.pi)
    v = 0.5 + numpy.arcsin(numpy.clip(turned[..., 2], -1, 1)) / math.pi
    column = numpy.clip((u * width).astype(int), 0, width - 1)
    row = numpy.clip((v * height).astype(int), 0, height - 1)
    return values[row, column] * color


class World(kit.ExportTest):
    """SUNDOG_scene's world."""

    def setUp(self):
        super().setUp()
        # What is here is what is done where a tree cannot be evaluated; test_parity_worlds has the others.
        self.write_graphs(False)
        self.world = self.scene.world = bpy.data.worlds.new("world")
        self.world.use_nodes = True
        self.tree = self.world.node_tree
        self.background = next(n for n in self.tree.nodes if n.type == "BACKGROUND")
        # Tiny pictures where the world is baked.
        self.sizes = worlds.SMOOTH_BAKE, worlds.DETAILED_BAKE
        worlds.SMOOTH_BAKE = worlds.DETAILED_BAKE = (128, 16)

    def tearDown(self):
        worlds.SMOOTH_BAKE, worlds.DETAILED_BAKE = self.sizes

    def test_a_view_layer_without_environment(self):
        """As in Cycles: it is not seen, and lights nothing."""
        self.background.inputs["Color"].default_value = (0.2, 0.5, 0.9, 1)
        self.near(self.export().scene()["world"]["color"], [0.2, 0.5, 0.9])
        bpy.context.view_layer.use_sky = False
        self.assertEqual(self.export().scene()["world"]["color"], [0, 0, 0])

    def node(self, kind, **settings):
        made = self.tree.nodes.new(kind)
        for key, value in settings.items():
            setattr(made, key, value)
        return made

    def join(self, output, socket):
        self.tree.links.new(output, socket)

    def gradient_file(self):
        """A picture whose colour tells the direction."""
        rows, columns = numpy.meshgrid((numpy.arange(32) + 0.5) / 32, (numpy.arange(64) + 0.5) / 64, indexing="ij")
        path = os.path.join(self.folder, "sky.exr")
        images.write_exr(path, numpy.stack([columns, rows, 0.5 + 0.5 * numpy.sin(2 * math.pi * columns)], axis=-1))
        return path

    def environment(self):
        made = self.node("ShaderNodeTexEnvironment")
        made.image = bpy.data.images.load(self.gradient_file())
        self.join(made.outputs["Color"], self.background.inputs["Color"])
        return made

    def against_cycles(self, tolerance, expected=None):
        """The export; what it says, and the program's picture of it, is Cycles' in a panorama as large as a baked one."""
        self.as_panorama()
        found = self.export()
        seen = kit.cycles_pixels(128, 64, 16)
        read = radiance(found.scene()["world"], found.path, directions(128, 64))
        for got in (read, kit.rendered(found.path, 128, 64, 16)):
            difference = numpy.abs(got - seen).max(axis=-1)
            self.assertLess(numpy.median(difference), tolerance * seen.max())
            self.near(got.mean(axis=(0, 1)), seen.mean(axis=(0, 1)), tolerance)
        if expected:
            self.assertEqual(found.verdict("world", "world")["verdict"], expected)
        return found

    def as_panorama(self):
        data = self.camera.data
        data.type = "PANO"
        settings = data if hasattr(data, "panorama_type") else data.cycles
        settings.panorama_type = "EQUIRECTANGULAR"
        self.camera.rotation_euler = (math.pi / 2, 0, -math.pi / 2)

    def test_no_world(self):
        self.scene.world = None
        self.near(self.export().scene()["world"]["color"], [0, 0, 0])

    def test_colour(self):
        self.background.inputs["Color"].default_value = (0.25, 0.5, 1, 1)
        self.background.inputs["Strength"].default_value = 3
        found = self.against_cycles(1e-5, "exact")
        self.assertEqual(found.scene()["world"], {"color": [0.75, 1.5, 3.0]})

    def test_world_without_nodes(self):
        if bpy.app.version >= (5, 0, 0):
            self.skipTest("from 5.0 on worlds always use their nodes")
        self.world.use_nodes = False
        self.world.color = (0.25, 0.5, 0.75)
        self.near(self.export().scene()["world"]["color"], [0.25, 0.5, 0.75])

    def test_world_without_output(self):
        self.tree.nodes.remove(next(n for n in self.tree.nodes if n.type == "OUTPUT_WORLD"))
        self.near(self.export().scene()["world"]["color"], [0, 0, 0])

    def test_visibility(self):
        self.world.cycles_visibility.camera = self.world.cycles_visibility.scatter = False
        self.assertEqual(self.export().scene()["world"]["visibility"], {"camera": False, "volume": False})

    def test_image(self):
        self.environment()
        self.background.inputs["Strength"].default_value = 2
        found = self.against_cycles(2e-2, "exact")
        self.assertEqual(os.path.basename(found.scene()["world"]["image"]), "sky.exr")
        self.assertNotIn("rotation", found.scene()["world"])

    def test_mapping(self):
        picture = self.environment()
        mapping, place = self.node("ShaderNodeMapping"), self.node("ShaderNodeTexCoord")
        self.join(place.outputs["Generated"], mapping.inputs["Vector"])
        self.join(mapping.outputs["Vector"], picture.inputs["Vector"])
        for kind in ("POINT", "TEXTURE", "VECTOR", "NORMAL"):
            with self.subTest(kind=kind):
                mapping.vector_type = kind
                mapping.inputs["Rotation"].default_value = (0.4, -0.3, 2)
                found = self.against_cycles(2e-2, "exact")
                self.assertIn("rotation", found.scene()["world"])

    def test_mapping_that_is_no_rotation(self):
        picture = self.environment()
        mapping, place = self.node("ShaderNodeMapping"), self.node("ShaderNodeTexCoord")
        self.join(place.outputs["Generated"], mapping.inputs["Vector"])
        self.join(mapping.outputs["Vector"], picture.inputs["Vector"])
        mapping.inputs["Scale"].default_value = (1, 1, -1)
        self.against_cycles(2e-2, "approximated")

    def test_mirrored_mapping(self):
        picture = self.environment()
        mapping, place = self.node("ShaderNodeMapping"), self.node("ShaderNodeTexCoord")
        self.join(place.outputs["Generated"], mapping.inputs["Vector"])
        self.join(mapping.outputs["Vector"], picture.inputs["Vector"])
        mapping.inputs["Scale"].default_value = (2, 2, 2)
        self.against_cycles(2e-2)

    def test_tinted_image(self):
        picture = self.environment()
        mix = self.node("ShaderNodeMix", data_type="RGBA", blend_type="MULTIPLY")
        colors = [s for s in mix.inputs if s.type == "RGBA"]
        next(s for s in mix.inputs if s.type == "VALUE").default_value = 1
        self.join(picture.outputs["Color"], colors[0])
        colors[1].default_value = (1, 0.5, 0.25, 1)
        self.join(next(s for s in mix.outputs if s.type == "RGBA"), self.background.inputs["Color"])
        found = self.against_cycles(2e-2, "exact")
        self.near(found.scene()["world"]["color"], [1, 0.5, 0.25])

    def test_packed_image(self):
        picture = self.environment()
        picture.image.pack()
        os.remove(os.path.join(self.folder, "sky.exr"))
        self.against_cycles(2e-2, "exact")

    def test_numbers_beyond_half_floats(self):
        for largest in (1e8, 1e-7):
            values = numpy.full((4, 8, 3), 0.25 * largest, numpy.float32)
            values[1, 2] = largest
            path = os.path.join(self.folder, "bright.exr")
            images.write_exr(path, values)
            numpy.testing.assert_array_equal(kit.exr_pixels(path)[::-1], values)

    def test_missing_image(self):
        picture = self.environment()
        os.remove(os.path.join(self.folder, "sky.exr"))
        picture.image.reload()
        found = self.against_cycles(1e-5, "exact")
        self.near(found.scene()["world"]["color"], [1, 0, 1])
        self.assertIn("sky.exr", found.verdict("world", "world")["detail"])
        # Cycles takes light samples of all that has a texture: it is no colour for the program either.
        self.assertIsNotNone(found.info()["environment"]["image"])

    def test_two_images_are_baked(self):
        first = self.environment()
        second = self.node("ShaderNodeTexEnvironment", image=first.image)
        mapping, place = self.node("ShaderNodeMapping"), self.node("ShaderNodeTexCoord")
        mapping.inputs["Rotation"].default_value = (0, 0, 1.5)
        self.join(place.outputs["Generated"], mapping.inputs["Vector"])
        self.join(mapping.outputs["Vector"], second.inputs["Vector"])
        mix = self.node("ShaderNodeMix", data_type="RGBA")
        # A new node's own factor is 0.5 up to 5.1 and 1 from 5.2 on.
        mix.inputs["Factor"].default_value = 0.5
        colors = [s for s in mix.inputs if s.type == "RGBA"]
        self.join(first.outputs["Color"], colors[0])
        self.join(second.outputs["Color"], colors[1])
        self.join(next(s for s in mix.outputs if s.type == "RGBA"), self.background.inputs["Color"])
        self.against_cycles(2e-2, "approximated")

    def test_gradient_is_baked(self):
        place, parts = self.node("ShaderNodeTexCoord"), self.node("ShaderNodeSeparateXYZ")
        self.join(place.outputs["Generated"], parts.inputs[0])
        join = self.node("ShaderNodeCombineXYZ")
        for index in range(3):
            half = self.node("ShaderNodeMath", operation="MULTIPLY_ADD")
            half.inputs[1].default_value, half.inputs[2].default_value = 0.25 * (index + 1), 1
            self.join(parts.outputs[index], half.inputs[0])
            self.join(half.outputs[0], join.inputs[index])
        self.join(join.outputs[0], self.background.inputs["Color"])
        found = self.against_cycles(1e-2, "approximated")
        self.assertIn("baked", found.verdict("world", "world")["detail"])
        # The second time the picture is there: nothing is run.
        with mock.patch.object(baker, "ask", side_effect=AssertionError("baked again")):
            again = self.export()
        self.assertIn("baked", again.verdict("world", "world")["detail"])

    def test_sky(self):
        kinds = self.node("ShaderNodeTexSky").bl_rna.properties["sky_type"].enum_items.keys()
        for kind in kinds:
            with self.subTest(kind=kind):
                sky = self.node("ShaderNodeTexSky", sky_type=kind)
                sky.sun_elevation, sky.sun_rotation = 0.5, 1.0
                if hasattr(sky, "sun_disc"):
                    sky.sun_disc = False
                self.join(sky.outputs["Color"], self.background.inputs["Color"])
                self.background.inputs["Strength"].default_value = 0.1
                self.against_cycles(1e-2, "approximated")

    def sun(self, **settings):
        """A sky with a disc of the sun."""
        for before in [n for n in self.tree.nodes if n.type == "TEX_SKY"]:
            self.tree.nodes.remove(before)
        kind = "NISHITA" if bpy.app.version < (5, 0, 0) else "MULTIPLE_SCATTERING"
        sky = self.node("ShaderNodeTexSky", sky_type=kind)
        sky.sun_elevation, sky.sun_rotation, sky.sun_size, sky.sun_intensity = 0.5, 1.0, 0.0095, 1.0
        for key, value in settings.items():
            setattr(sky, key, value)
        self.join(sky.outputs["Color"], self.background.inputs["Color"])
        return sky

    def test_sun_disc(self):
        # A disc of many degrees is seen by many texels.
        self.sun(sun_size=0.2, sun_intensity=0.1)
        found = self.export()
        self.assertIn("sun disc with them", found.verdict("world", "world")["detail"])
        self.assertNotIn("sun", found.scene()["world"])
        got = radiance(found.scene()["world"], found.path, directions(256, 128))
        self.as_panorama()
        seen = kit.cycles_pixels(256, 128, 16)
        # The disc lies where Cycles has it.
        toward = directions(256, 128)
        bright_got, bright_seen = (toward[p.sum(axis=-1) > 0.5 * p.sum(axis=-1).max()].mean(axis=0) for p in (got, seen))
        self.near(bright_got, bright_seen, 0.03)

    def test_small_sun_is_a_light(self):
        for elevation, rotation in ((0.5, 1.0), (1.2, -2.5)):
            with self.subTest(elevation=elevation):
                self.sun(sun_elevation=elevation, sun_rotation=rotation)
                self.background.inputs["Strength"].default_value = 0.05
                found = self.export()
                sun = found.scene()["world"]["sun"]
                self.assertAlmostEqual(sun["angle"], 0.0095, 6)
                # The middle of the disc, as Cycles shows it.
                data = self.camera.data
                data.type, data.angle = "PERSP", 0.02
                self.scene.render.resolution_x = self.scene.render.resolution_y = 32
                self.camera.rotation_euler = mathutils.Vector(sun["direction"]).to_track_quat("-Z", "Y").to_euler()
                seen, got = kit.cycles_pixels(32, 32, 16), kit.rendered(self.export().path, 32, 32, 16)
                self.assertGreater(seen[14:18, 14:18].mean(), 100 * seen[:4, :4].mean())
                # All of its light; its edge is darker in Cycles (by up to a half), and its radiance here is its mean.
                self.near(got.mean(axis=(0, 1)), seen.mean(axis=(0, 1)), 0.01)

    def test_light_and_shadow_of_a_small_sun(self):
        self.sun()
        self.background.inputs["Strength"].default_value = 0.05
        floor, post = kit.plane("floor", 8), kit.cube("post", 1)
        for mesh in (floor, post):
            mesh.materials.append(kit.material(mesh.name, Base_Color=(0.5, 0.5, 0.5, 1), Specular_IOR_Level=0.0))
        self.link("floor", floor)
        self.link("post", post, location=(0, 0, 0.5))
        data = self.camera.data
        data.type, data.ortho_scale = "ORTHO", 6
        self.scene.render.resolution_x = self.scene.render.resolution_y = 32
        found = self.export()
        seen, got = (p.reshape(8, 4, 8, 4, 3).mean(axis=(1, 3)) for p in (kit.cycles_pixels(32, 32, 128), kit.rendered(found.path, 32, 32, 128)))
        # Blocks in the shadow are the sky's alone.
        self.assertLess(seen.min(), 0.3 * seen.max())
        self.near(got, seen, 0.02)

    def test_animated_sky_is_that_of_the_frame(self):
        sky = self.sun(sun_disc=False)
        self.background.inputs["Strength"].default_value = 0.1
        sky.sun_elevation = 0.05
        sky.keyframe_insert("sun_elevation", frame=1)
        sky.sun_elevation = 1.5
        sky.keyframe_insert("sun_elevation", frame=20)
        self.as_panorama()
        means = []
        for frame in (1, 20):
            self.scene.frame_set(frame)
            found = self.export()
            got = radiance(found.scene()["world"], found.path, directions(128, 64))
            seen = kit.cycles_pixels(128, 64, 16)
            self.near(got.mean(axis=(0, 1)), seen.mean(axis=(0, 1)), 0.01)
            means.append(got.mean())
        self.assertGreater(means[1], 1.2 * means[0])

    def test_one_blender_bakes_all_frames(self):
        sky = self.sun(sun_disc=False)
        self.export()
        first = baker._Kept.baker.child.pid
        sky.sun_elevation = 0.7
        self.export()
        self.assertEqual(baker._Kept.baker.child.pid, first)
        # One that has ended is followed by another.
        baker._Kept.baker.end()
        sky.sun_elevation = 0.9
        self.assertIn("image", self.export().scene()["world"])
        # So is one that ends just when it is asked.
        baker._Kept.baker.child.kill()
        baker._Kept.baker.child.wait()
        sky.sun_elevation = 1.1
        with mock.patch.object(baker.Baker, "is_alive", return_value=True):
            self.assertIn("image", self.export().scene()["world"])

    def test_a_bake_that_fails_is_told(self):
        self.sun()
        with mock.patch.object(baker, "ask", side_effect=baker.BakeError("no reason")):
            verdict = self.export().verdict("world", "world")
        self.assertEqual(verdict["verdict"], "lost")
        self.assertIn("no reason", verdict["detail"])

    def test_esc_ends_the_bake(self):
        self.sun()
        world = self.world
        class Stop(Exception):
            pass
        def report(text):
            raise Stop
        with self.assertRaises(Stop):
            worlds.bake(world, world.node_tree, self.folder, report)
        self.assertIsNone(baker._Kept.baker)

    def test_camera_only_branch(self):
        mix, bright = self.node("ShaderNodeMixShader"), self.node("ShaderNodeBackground")
        path = self.node("ShaderNodeLightPath")
        output = next(n for n in self.tree.nodes if n.type == "OUTPUT_WORLD")
        bright.inputs["Color"].default_value = (1, 0, 0, 1)
        self.background.inputs["Color"].default_value = (0, 0, 1, 1)
        self.join(path.outputs["Is Camera Ray"], mix.inputs[0])
        self.join(self.background.outputs[0], mix.inputs[1])
        self.join(bright.outputs[0], mix.inputs[2])
        self.join(mix.outputs[0], output.inputs["Surface"])
        found = self.export()
        got = radiance(found.scene()["world"], found.path, directions(8, 4))
        self.near(got.mean(axis=(0, 1)), [0, 0, 1], 1e-3)
        self.assertIn("Light Path", found.verdict("world", "world")["detail"])

    def test_volume(self):
        output = next(n for n in self.tree.nodes if n.type == "OUTPUT_WORLD")
        scatter = self.node("ShaderNodeVolumeScatter")
        self.join(scatter.outputs[0], output.inputs["Volume"])
        found = self.export()
        self.assertEqual(found.verdict("world", "world")["verdict"], "exact")
        [scatterer] = found.scene()["world"]["volume"]["scatterers"]
        self.near(scatterer["coefficient"], list(scatter.inputs["Color"].default_value)[:3])
        self.join(self.node("ShaderNodeTexNoise").outputs[0], scatter.inputs["Density"])
        found = self.export()
        self.assertEqual(found.verdict("world", "world")["verdict"], "exact")
        self.assertIn("graph", found.scene()["world"]["volume"])
        self.join(self.node("ShaderNodeWireframe").outputs[0], scatter.inputs["Density"])
        verdict = self.export().verdict("world", "world")
        self.assertEqual(verdict["verdict"], "lost")
        self.assertIn("volume", verdict["detail"])

    def test_driven_strength(self):
        driver = self.background.inputs["Strength"].driver_add("default_value").driver
        driver.expression = "4"
        self.background.inputs["Color"].default_value = (1, 1, 1, 1)
        bpy.context.view_layer.update()
        self.near(self.export().scene()["world"]["color"], [4, 4, 4])


if __name__ == "__main__":
    unittest.main()
