# SPDX-License-Identifier: GPL-3.0-or-later
"""The working space of a .blend (Blender 5.0 and later): what is written, and the picture against Cycles'."""

import itertools
import os
import unittest
from unittest import mock

import bpy
import export_kit as kit
import numpy
from sundog.export import blackbody, colorspace, images

SPACES = ("Linear Rec.709", "Linear Rec.2020", "ACEScg")


def set_space(name):
    """Makes it that of the open file; numbers stay as they are."""
    bpy.ops.wm.set_working_color_space(working_space=name, convert_colors=False)


def blocks(picture, size=8):
    """Means of blocks of pixels."""
    height, width = picture.shape[:2]
    return picture.reshape(height // size, size, width // size, size, 3).mean(axis=(1, 3))


@unittest.skipIf(bpy.app.version < (5, 0, 0), "files have a working space from Blender 5.0 on")
class WorkingSpace(kit.ExportTest):
    """Numbers in another space."""

    def picture(self, name, extension, space):
        """An image of four colours in a file; those of ACEScg are within Rec.709 too."""
        values = numpy.array([[(230, 120, 90), (100, 200, 110)], [(90, 110, 220), (200, 190, 80)]], numpy.uint8)
        values = numpy.repeat(numpy.repeat(values, 4, axis=0), 4, axis=1)
        path = os.path.join(self.folder, f"{name}{extension}")
        if extension == ".png":
            images.write_png(path, values)
        else:
            images.write_exr(path, images.decode_srgb(values / 255))
        image = bpy.data.images.load(path)
        image.colorspace_settings.name = space
        return image

    def textured(self, name, image, place, interpolation, turned=False):
        material = kit.material(name)
        tree = material.node_tree
        principled = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
        principled.inputs["Specular IOR Level"].default_value = 0
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image, node.interpolation = image, interpolation
        color = node.outputs["Color"]
        if turned:
            # What cannot be written as it stands is computed here.
            turn = tree.nodes.new("ShaderNodeHueSaturation")
            turn.inputs["Saturation"].default_value = 0.5
            tree.links.new(color, turn.inputs["Color"])
            color = turn.outputs["Color"]
        tree.links.new(color, principled.inputs["Base Color"])
        mesh = kit.plane(name)
        mesh.materials.append(material)
        return self.link(name, mesh, location=place)

    def painted(self, name, domain, place):
        painted = kit.plane(name)
        layer = painted.color_attributes.new("paint", "BYTE_COLOR", domain)
        for corner, value in zip(layer.data, [(0.9, 0.1, 0.05, 1), (0.1, 0.8, 0.1, 1), (0.1, 0.1, 0.9, 1), (0.8, 0.7, 0.1, 1)]):
            corner.color_srgb = value
        material = kit.material(name)
        tree = material.node_tree
        principled = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
        principled.inputs["Specular IOR Level"].default_value = 0
        node = tree.nodes.new("ShaderNodeVertexColor")
        node.layer_name = "paint"
        tree.links.new(node.outputs["Color"], principled.inputs["Base Color"])
        painted.materials.append(material)
        self.link(name, painted, location=place)

    def scene_in(self, space, interpolation="Closest"):
        set_space(space)
        # In the order of the columns of blocks.
        self.textured("png", self.picture("a", ".png", "sRGB"), (-3, 1, 0), interpolation)
        self.textured("exr", self.picture("b", ".exr", "Linear Rec.709"), (-1, 1, 0), interpolation)
        self.textured("acescg", self.picture("c", ".exr", "ACEScg"), (1, 1, 0), interpolation)
        self.textured("computed", self.picture("d", ".png", "sRGB"), (3, 1, 0), interpolation, turned=True)
        self.painted("painted", "CORNER", (-3, -1, 0))
        self.painted("by point", "POINT", (-1, -1, 0))
        glowing, grey = bpy.data.materials.new("glowing"), bpy.data.materials.new("grey")
        for material, kind in ((glowing, "ShaderNodeBlackbody"), (grey, "ShaderNodeRGBToBW")):
            tree = material.node_tree
            tree.nodes.clear()
            emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
            source = tree.nodes.new(kind)
            source.inputs[0].default_value = 1500 if kind == "ShaderNodeBlackbody" else (0.8, 0.2, 0.1, 1)
            tree.links.new(source.outputs[0], emission.inputs["Color"])
            tree.links.new(emission.outputs[0], output.inputs["Surface"])
        for material, place in ((glowing, (1, -1, 0)), (grey, (3, -1, 0))):
            mesh = kit.plane(material.name)
            mesh.materials.append(material)
            self.link(material.name, mesh, location=place)
        sun, lamp = bpy.data.lights.new("sun", "SUN"), bpy.data.lights.new("warm", "POINT")
        sun.energy, sun.color, sun.angle = 2, (0.9, 0.6, 0.3), 0.1
        lamp.energy, lamp.shadow_soft_size = 300, 0.2
        lamp.use_temperature, lamp.temperature = True, 2500
        self.link("sun", sun)
        self.link("warm", lamp, location=(0, 0, 3))
        self.scene.world = bpy.data.worlds.new("world")
        background = next(n for n in self.scene.world.node_tree.nodes if n.type == "BACKGROUND")
        background.inputs["Color"].default_value = (0.1, 0.2, 0.4, 1)
        data = self.camera.data
        data.type, data.ortho_scale = "ORTHO", 8
        render = self.scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = 64, 32, 100

    def test_pictures_are_those_of_cycles(self):
        # Between texels other spaces than Rec.709 have light, not codes.
        for space, interpolation in itertools.product(SPACES, ("Linear", "Closest")):
            with self.subTest(space=space, interpolation=interpolation):
                self.setUp()
                self.scene_in(space, interpolation)
                found = self.export()
                self.assertEqual(found.scene().get("working_space", SPACES[0]), space)
                self.assertEqual(found.info()["working_space"], space)
                seen = blocks(kit.cycles_pixels(64, 32, 1024))
                got = blocks(kit.rendered(found.path, 64, 32, 1024))
                # A black body of 1500 K has no blue in Rec.709.
                worst = numpy.abs(got - seen) / numpy.maximum(seen, 1e-6)
                self.assertLess(worst.max(), 0.01, f"{worst.max(axis=2)}")
                # Taken for Rec.709, they are another picture.
                if space != SPACES[0]:
                    del found.scene()["working_space"]
                    with mock.patch.object(colorspace, "_own_name", lambda: (SPACES[0], SPACES[0])):
                        wrong = blocks(kit.rendered(self.export().path, 64, 32, 16))
                    self.assertGreater((numpy.abs(wrong - seen) / numpy.maximum(seen, 1e-6)).max(), 0.2)

    def test_environment_image(self):
        pictures = ((".png", "sRGB"), (".exr", "Linear Rec.709"), (".exr", "ACEScg"))
        for (extension, space), interpolation in itertools.product(pictures, ("Linear", "Closest")):
            with self.subTest(extension=extension, space=space, interpolation=interpolation):
                self.setUp()
                set_space("ACEScg")
                world = self.scene.world = bpy.data.worlds.new("world")
                tree = world.node_tree
                node = tree.nodes.new("ShaderNodeTexEnvironment")
                node.image, node.interpolation = self.picture("sky", extension, space), interpolation
                background = next(n for n in tree.nodes if n.type == "BACKGROUND")
                tree.links.new(node.outputs["Color"], background.inputs["Color"])
                data = self.camera.data
                data.type, data.panorama_type = "PANO", "EQUIRECTANGULAR"
                found = self.export()
                self.assertEqual(found.verdict("world", "world")["verdict"], "exact")
                # The file itself, where its numbers are those of the scene after the program's own decoding.
                # Codes stand in a tree, and so does what is not interpolated linearly.
                shown = found.scene()["world"]
                in_tree = space == "sRGB" or interpolation != "Linear"
                self.assertEqual("shader_graph" in shown, in_tree)
                shown = found["images"][0]["uri"] if in_tree else shown["image"]
                own = os.path.basename(shown) == f"sky{extension}"
                self.assertEqual(own, in_tree or space != "Linear Rec.709")
                seen, got = kit.cycles_pixels(32, 16, 16), kit.rendered(found.path, 32, 16, 16)
                self.assertLess(numpy.median(numpy.abs(got - seen)), 0.01 * seen.max())
                self.near(got.mean(axis=(0, 1)), seen.mean(axis=(0, 1)), 0.01)

    def test_baked_world(self):
        set_space("ACEScg")
        world = self.scene.world = bpy.data.worlds.new("world")
        tree = world.node_tree
        sky = tree.nodes.new("ShaderNodeTexSky")
        sky.sun_disc = False
        background = next(n for n in tree.nodes if n.type == "BACKGROUND")
        background.inputs["Strength"].default_value = 0.1
        tree.links.new(sky.outputs["Color"], background.inputs["Color"])
        data = self.camera.data
        data.type, data.panorama_type = "PANO", "EQUIRECTANGULAR"
        found = self.export()
        seen, got = kit.cycles_pixels(64, 32, 16), kit.rendered(found.path, 64, 32, 16)
        self.near(got.mean(axis=(0, 1)), seen.mean(axis=(0, 1)), 0.01)

    def test_the_picture_says_its_space(self):
        self.scene_in("ACEScg")
        found = self.export()
        kit.rendered(found.path, 8, 4, 1)
        image = bpy.data.images.load(found.path + ".exr")
        # Blender itself finds the space of a file by what stands in it.
        self.assertEqual(image.colorspace_settings.name, "ACEScg")

    def test_a_space_that_is_not_known_is_told(self):
        with mock.patch.object(colorspace, "_own_name", lambda: ("Linear FilmLight E-Gamut", None)):
            found = self.export()
        self.assertNotIn("working_space", found.scene())
        verdict = found.verdict("scene", self.scene.name)
        self.assertEqual(verdict["verdict"], "lost")
        self.assertIn("E-Gamut", verdict["detail"])


class Matrices(unittest.TestCase):
    """Conversions, in any Blender."""

    def test_spaces_convert_as_in_blender(self):
        # `Image.pixels` of Blender 5.0.1 of a float image of linear Rec.709.
        light = numpy.array([0.90633386, 0.48452866, 0.34918913])
        wanted = {
            "ACEScg": ([0.73672408, 0.51231611, 0.37550414], 0.35480),
            "Linear Rec.2020": ([0.74330896, 0.5121364, 0.37023327], 0.35169),
            "Linear Rec.709": (light, 0.32036),
        }
        for name, (there, grey) in wanted.items():
            with mock.patch.object(colorspace, "_own_name", lambda name=name: (name, name)):
                numpy.testing.assert_allclose(colorspace.from_rec709(light), there, rtol=5e-6)
                # Cycles 5.0.1's RGB to BW of (0.8, 0.2, 0.1).
                self.assertAlmostEqual(float(colorspace.luminance() @ [0.8, 0.2, 0.1]), grey, 4)

    def test_black_bodies(self):
        # Cycles 5.0.1's Blackbody node.
        wanted = {
            "Linear Rec.709": (3.26431, 0.43405, 0.0),
            "ACEScg": (2.14566, 0.62601, 0.05898),
            "Linear Rec.2020": (2.18818, 0.62395, 0.03418),
        }
        for name, color in wanted.items():
            with mock.patch.object(colorspace, "_own_name", lambda name=name: (name, name)):
                numpy.testing.assert_allclose(blackbody.color(1500), color, rtol=5e-4, atol=1e-4)

    def test_the_role_of_a_foreign_configuration(self):
        if hasattr(bpy.data, "colorspace"):
            self.skipTest("Blender 5.0 and later say it themselves")
        import tempfile

        with tempfile.TemporaryDirectory() as folder:
            config = os.path.join(folder, "config.ocio")
            with open(config, "w", encoding="utf-8") as file:
                file.write("ocio_profile_version: 2\nroles:\n  data: Raw\n  scene_linear: ACES - ACEScg\n")
            with mock.patch.dict(os.environ, {"OCIO": config}):
                self.assertEqual(colorspace.working_space(), "ACEScg")


if __name__ == "__main__":
    unittest.main()
