# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: what node trees become, and the verdict that says what is used instead."""

import json
import math
import os
import unittest

import bpy
import export_kit as kit
import numpy
from sundog.export import images


class MaterialTest(kit.ExportTest):
    """A plane with a material "m" whose node tree the test fills."""

    def setUp(self):
        super().setUp()
        self.write_graphs(False)
        self.mesh = kit.plane()
        self.link("plane", self.mesh)
        self.made = kit.material("m")
        self.mesh.materials.append(self.made)
        self.tree = self.made.node_tree
        self.principled = next(n for n in self.tree.nodes if n.type == "BSDF_PRINCIPLED")
        self.output = next(n for n in self.tree.nodes if n.type == "OUTPUT_MATERIAL")

    def node(self, kind, tree=None, **settings):
        made = (tree or self.tree).nodes.new(kind)
        for key, value in settings.items():
            setattr(made, key, value)
        return made

    def join(self, output, socket):
        self.tree.links.new(output, socket)

    def set(self, **inputs):
        for key, value in inputs.items():
            self.principled.inputs[key.replace("_", " ")].default_value = value

    def written(self):
        """The glTF material; `found` is the export."""
        self.found = self.export()
        return self.found.material("m")

    def verdict(self):
        return self.found.verdict("material", "m")

    def image(self, name="image", pixels=None, space="sRGB", packed=False):
        """An image by a PNG file of 4 × 4 (or given) pixels of 8 bits, top row first."""
        if pixels is None:
            pixels = numpy.arange(48).reshape(4, 4, 3) * 5
        path = os.path.join(self.folder, f"{name}.png")
        images.write_png(path, numpy.asarray(pixels, numpy.uint8))
        made = bpy.data.images.load(path)
        made.name = name
        made.colorspace_settings.name = space
        if packed:
            made.pack()
            os.remove(path)
        return made

    def textured(self, socket, image=None, output="Color", **settings):
        made = self.node("ShaderNodeTexImage", image=image or self.image(), **settings)
        self.join(made.outputs[output], socket)
        return made

    def texture_file(self, info):
        texture = self.found["textures"][info["index"]]
        uri = self.found["images"][texture["source"]]["uri"]
        return os.path.normpath(os.path.join(os.path.dirname(self.found.path), uri))


class Principled(MaterialTest):
    """Constants of every input."""

    def test_plain(self):
        self.set(Base_Color=(0.1, 0.2, 0.3, 1), Metallic=0.25, Roughness=0.75)
        got = self.written()
        pbr = got["pbrMetallicRoughness"]
        self.near(pbr["baseColorFactor"], [0.1, 0.2, 0.3, 1])
        self.near([pbr["metallicFactor"], pbr["roughnessFactor"]], [0.25, 0.75])
        self.assertTrue(got["doubleSided"])
        self.assertNotIn("alphaMode", got)
        self.assertEqual(got["extensions"]["SUNDOG_material"], {"thin_walled": False})
        self.assertEqual(self.verdict()["verdict"], "exact")

    def test_index(self):
        self.set(IOR=1.33)
        self.assertAlmostEqual(self.written()["extensions"]["KHR_materials_ior"]["ior"], 1.33, 6)

    def test_specular_level_changes_the_index(self):
        self.set(IOR=1.5, **{"Specular_IOR_Level": 1.0})
        ior = self.written()["extensions"]["KHR_materials_ior"]["ior"]
        # Twice the reflectance of index 1.5 at normal incidence.
        self.near(((ior - 1) / (ior + 1)) ** 2, 2 * 0.04, 1e-6)
        self.assertEqual(self.verdict()["verdict"], "exact")
        self.set(**{"Specular_IOR_Level": 0.0})
        self.assertEqual(self.written()["extensions"]["KHR_materials_ior"]["ior"], 1.0)

    def test_specular_level_is_nothing_to_glass_and_metal(self):
        for change in ({"Transmission_Weight": 1.0}, {"Metallic": 1.0}):
            with self.subTest(change=change):
                self.set(Metallic=0.0, **{"Transmission_Weight": 0.0, "Specular_IOR_Level": 0.9})
                self.set(**change)
                extensions = self.written()["extensions"]
                self.assertNotIn("KHR_materials_specular", extensions)
                self.assertNotIn("KHR_materials_ior", extensions)
                self.assertEqual(self.verdict()["verdict"], "exact")

    def test_specular_tint(self):
        self.set(**{"Specular_Tint": (1, 0.5, 0.25, 1)})
        self.near(self.written()["extensions"]["KHR_materials_specular"]["specularColorFactor"], [1, 0.5, 0.25])

    def test_edge_tint(self):
        self.set(Metallic=1.0, Specular_Tint=(1, 0.5, 0.25, 1))
        got = self.written()["extensions"]
        self.near(got["KHR_materials_specular"]["specularColorFactor"], [1, 0.5, 0.25])
        self.assertTrue(got["SUNDOG_material"]["edge_tint"])
        self.assertEqual(self.verdict()["verdict"], "exact")

    def test_glass(self):
        self.set(**{"Transmission_Weight": 1.0, "IOR": 1.6, "Roughness": 0.0})
        got = self.written()["extensions"]
        self.assertEqual(got["KHR_materials_transmission"]["transmissionFactor"], 1)
        self.assertAlmostEqual(got["KHR_materials_ior"]["ior"], 1.6, 6)
        # Not a thin sheet.
        self.assertFalse(got["SUNDOG_material"]["thin_walled"])

    def test_emission(self):
        self.set(Emission_Color=(1, 0.5, 0.25, 1), Emission_Strength=6)
        got = self.written()
        strength = got["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"]
        self.near(numpy.array(got["emissiveFactor"]) * strength, [6, 3, 1.5])
        self.set(Emission_Strength=0.5)
        got = self.written()
        self.assertNotIn("KHR_materials_emissive_strength", got["extensions"])
        self.near(got["emissiveFactor"], [0.5, 0.25, 0.125])
        self.set(Emission_Strength=0)
        self.assertNotIn("emissiveFactor", self.written())

    def test_alpha(self):
        self.set(Alpha=0.25)
        got = self.written()
        self.assertEqual(got["alphaMode"], "BLEND")
        self.near(got["pbrMetallicRoughness"]["baseColorFactor"][3], 0.25)

    def test_colours_above_one(self):
        self.set(Base_Color=(2, 0.5, 0.5, 1))
        got = self.written()
        self.near(got["pbrMetallicRoughness"]["baseColorFactor"], [1, 0.5, 0.5, 1])
        self.near(got["extensions"]["SUNDOG_material"]["base_color"], [2, 0.5, 0.5])

    def test_inputs_that_are_not_rendered(self):
        self.set(
            **{
                "Subsurface_Weight": 0.5,
                "Subsurface_Scale": 0.1,
                "Sheen_Weight": 0.25,
                "Sheen_Roughness": 0.75,
                "Coat_Weight": 0.5,
                "Coat_Roughness": 0.125,
                "Coat_IOR": 1.25,
                "Anisotropic": 0.5,
                "Anisotropic_Rotation": 0.25,
                "Thin_Film_Thickness": 400,
                "Thin_Film_IOR": 1.75,
            }
        )
        if "Diffuse Roughness" in self.principled.inputs:
            self.set(**{"Diffuse_Roughness": 0.5})
        got = self.written()["extensions"]["SUNDOG_material"]
        self.near([got["subsurface"]["weight"], got["subsurface"]["scale"]], [0.5, 0.1])
        self.near(got["subsurface"]["radius"], [1, 0.2, 0.1])
        self.near([got["sheen"]["weight"], got["sheen"]["roughness"]], [0.25, 0.75])
        self.near([got["coat"][k] for k in ("weight", "roughness", "ior")], [0.5, 0.125, 1.25])
        self.near([got["anisotropy"]["strength"], got["anisotropy"]["rotation"]], [0.5, 0.25])
        self.near([got["thin_film"]["thickness"], got["thin_film"]["ior"]], [400, 1.75])
        verdict = self.verdict()
        self.assertEqual(verdict["verdict"], "lost")
        self.assertIn("subsurface", verdict["detail"])

    def test_index_below_one(self):
        """The node tree has it."""
        self.set(IOR=0.8)
        self.write_graphs(True)
        self.written()
        self.assertEqual(self.verdict()["verdict"], "exact")

    def test_driver(self):
        driver = self.principled.inputs["Roughness"].driver_add("default_value").driver
        driver.expression = "0.125 * 3"
        bpy.context.view_layer.update()
        self.near(self.written()["pbrMetallicRoughness"]["roughnessFactor"], 0.375)

    def test_without_nodes(self):
        if bpy.app.version >= (5, 0, 0):
            self.skipTest("from 5.0 on materials always use their nodes")
        self.made.use_nodes = False
        self.made.diffuse_color = (0.25, 0.5, 0.75, 1)
        self.near(self.written()["pbrMetallicRoughness"]["baseColorFactor"], [0.25, 0.5, 0.75, 1])
        self.assertEqual(self.verdict()["verdict"], "exact")

    def test_program_reads_what_is_written(self):
        self.set(Base_Color=(0.5, 0.5, 0.5, 1), Roughness=0.25, Emission_Color=(1, 1, 1, 1), Emission_Strength=3)
        self.written()
        told = next(m for m in self.found.info()["materials"] if m["name"] == "m")
        self.assertIn("roughness 0.25", told["traits"])
        self.assertIn("emission [3.0, 3.0, 3.0]", told["traits"])


class Images(MaterialTest):
    """Image textures: files as they are where that is exact."""

    def test_base_color(self):
        image = self.image()
        self.textured(self.principled.inputs["Base Color"], image)
        info = self.written()["pbrMetallicRoughness"]["baseColorTexture"]
        self.assertEqual(self.texture_file(info), os.path.realpath(bpy.path.abspath(image.filepath)))
        self.assertEqual(self.verdict()["verdict"], "exact")
        self.assertEqual(self.found.info()["images"][0]["width"], 4)

    def test_packed(self):
        self.textured(self.principled.inputs["Base Color"], self.image(packed=True))
        info = self.written()["pbrMetallicRoughness"]["baseColorTexture"]
        self.assertTrue(os.path.isfile(self.texture_file(info)))

    def test_generated(self):
        image = bpy.data.images.new("generated", 8, 4)
        image.generated_type = "COLOR_GRID"
        self.textured(self.principled.inputs["Base Color"], image)
        info = self.written()["pbrMetallicRoughness"]["baseColorTexture"]
        seen = kit.exr_pixels(self.texture_file(info))
        raw = numpy.empty(8 * 4 * 4, numpy.float32)
        image.pixels.foreach_get(raw)
        self.near(seen, images.decode_srgb(raw.reshape(4, 8, 4)[..., :3]), 1e-3)

    def test_painted_pixels_win_over_the_file(self):
        image = self.image()
        image.pixels[0:4] = (1, 0, 0, 1)
        self.textured(self.principled.inputs["Base Color"], image)
        info = self.written()["pbrMetallicRoughness"]["baseColorTexture"]
        self.near(kit.exr_pixels(self.texture_file(info))[0, 0], [1, 0, 0])

    def test_missing(self):
        image = self.image()
        os.remove(bpy.path.abspath(image.filepath))
        image.reload()
        self.textured(self.principled.inputs["Base Color"], image)
        # Cycles shows what cannot be read in pink.
        self.near(self.written()["pbrMetallicRoughness"]["baseColorFactor"], [1, 0, 1, 1])
        # As in Cycles, but to be told.
        self.assertEqual(self.verdict()["verdict"], "exact")
        self.assertIn("image.png", self.verdict()["detail"])

    def test_broken_files(self):
        """Cut off in every place: the program reads what is written, whatever Blender makes of the rest."""
        source = self.image("whole", numpy.random.default_rng(5).integers(0, 255, (64, 64, 3)))
        with open(bpy.path.abspath(source.filepath), "rb") as file:
            data = file.read()
        for number, length in enumerate((0, 4, 20, 60, len(data) // 2, len(data) - 4)):
            path = os.path.join(self.folder, f"broken {number}.png")
            with open(path, "wb") as file:
                file.write(data[:length])
            with kit.quiet():
                node = self.textured(self.principled.inputs["Base Color"], bpy.data.images.load(path))
                self.written()
            self.found.info()
            self.tree.nodes.remove(node)

    def test_node_without_image(self):
        self.join(self.node("ShaderNodeTexImage").outputs["Color"], self.principled.inputs["Base Color"])
        self.near(self.written()["pbrMetallicRoughness"]["baseColorFactor"], [1, 0, 1, 1])

    def test_painted_roughness(self):
        # glTF carries painted colours in the base colour alone: anywhere else they are lost, and that is said.
        paint = self.node("ShaderNodeVertexColor")
        paint.layer_name = "paint"
        self.join(paint.outputs["Color"], self.principled.inputs["Roughness"])
        self.written()
        self.assertEqual(self.verdict()["verdict"], "lost")
        self.assertIn("colour attributes are left out", self.verdict()["detail"])

    def test_tiled(self):
        for number in (1001, 1002):
            images.write_png(os.path.join(self.folder, f"tile.{number}.png"), numpy.full((4, 4, 3), 10, numpy.uint8))
        image = bpy.data.images.load(os.path.join(self.folder, "tile.1001.png"))
        image.source = "TILED"
        image.filepath = os.path.join(self.folder, "tile.<UDIM>.png")
        self.textured(self.principled.inputs["Base Color"], image)
        self.write_graphs(False)
        self.written()
        self.assertEqual(self.verdict()["verdict"], "approximated")
        self.assertIn("first tile", self.verdict()["detail"])

    def test_extension_and_interpolation(self):
        for extension, number in (("REPEAT", 10497), ("EXTEND", 33071), ("MIRROR", 33648)):
            self.textured(self.principled.inputs["Base Color"], extension=extension, interpolation="Closest")
            info = self.written()["pbrMetallicRoughness"]["baseColorTexture"]
            sampler = self.found["samplers"][self.found["textures"][info["index"]]["sampler"]]
            self.assertEqual((sampler["wrapS"], sampler["wrapT"], sampler["magFilter"]), (number, number, 9728))

    def test_a_way_of_wrapping_for_each_direction(self):
        """As Blender's importer of glTF builds it."""
        node = self.textured(self.principled.inputs["Base Color"], extension="EXTEND")
        uv, apart, together = (self.node(k) for k in ("ShaderNodeUVMap", "ShaderNodeSeparateXYZ", "ShaderNodeCombineXYZ"))
        mirror = self.node("ShaderNodeMath", operation="PINGPONG")
        mirror.inputs[1].default_value = 1
        repeat = self.node("ShaderNodeMath", operation="WRAP")
        repeat.inputs[1].default_value, repeat.inputs[2].default_value = 0, 1
        self.join(uv.outputs[0], apart.inputs[0])
        self.join(together.outputs[0], node.inputs["Vector"])
        for first, second, expected in (
            (mirror, None, (33648, 33071)),
            (None, repeat, (33071, 10497)),
            (repeat, mirror, (10497, 33648)),
        ):
            for axis, wrap in enumerate((first, second)):
                if wrap is None:
                    self.join(apart.outputs[axis], together.inputs[axis])
                else:
                    self.join(apart.outputs[axis], wrap.inputs[0])
                    self.join(wrap.outputs[0], together.inputs[axis])
            info = self.written()["pbrMetallicRoughness"]["baseColorTexture"]
            sampler = self.found["samplers"][self.found["textures"][info["index"]]["sampler"]]
            self.assertEqual((sampler["wrapS"], sampler["wrapT"]), expected)
            self.assertEqual(self.verdict()["verdict"], "exact")

    def place(self, uv, texture):
        """Where the texture is looked up (v upwards), by KHR_texture_transform."""
        transform = texture.get("extensions", {}).get("KHR_texture_transform", {})
        (ox, oy), angle, (sx, sy) = transform.get("offset", (0, 0)), transform.get("rotation", 0), transform.get("scale", (1, 1))
        s, t = uv[0] * sx, (1 - uv[1]) * sy
        c, n = math.cos(angle), math.sin(angle)
        # The extension's matrices: translation · rotation · scale, rotation counter-clockwise with v downwards.
        return [c * s + n * t + ox, 1 - (-n * s + c * t + oy)]

    def test_mapping(self):
        node = self.textured(self.principled.inputs["Base Color"])
        mapping, coordinates = self.node("ShaderNodeMapping"), self.node("ShaderNodeTexCoord")
        self.join(coordinates.outputs["UV"], mapping.inputs["Vector"])
        self.join(mapping.outputs["Vector"], node.inputs["Vector"])
        mapping.inputs["Location"].default_value = (0.3, -0.2, 0)
        mapping.inputs["Rotation"].default_value = (0, 0, 0.4)
        mapping.inputs["Scale"].default_value = (2, 2, 1)
        for kind in ("POINT", "TEXTURE", "VECTOR"):
            mapping.vector_type = kind
            info = self.written()["pbrMetallicRoughness"]["baseColorTexture"]
            self.assertEqual(self.verdict()["verdict"], "exact", kind)
            for uv in ((0, 0), (1, 0), (0.3, 0.8)):
                c, s = math.cos(0.4), math.sin(0.4)
                if kind == "TEXTURE":
                    x, y = uv[0] - 0.3, uv[1] + 0.2
                    expected = [(c * x + s * y) / 2, (-s * x + c * y) / 2]
                else:
                    x, y = 2 * uv[0], 2 * uv[1]
                    shift = (0.3, -0.2) if kind == "POINT" else (0, 0)
                    expected = [c * x - s * y + shift[0], s * x + c * y + shift[1]]
                self.near(self.place(uv, info), expected, 1e-6)

    def test_roughness_and_metallic_of_one_file(self):
        image = self.image(space="Non-Color")
        node = self.node("ShaderNodeTexImage", image=image)
        parts = self.node("ShaderNodeSeparateColor")
        self.join(node.outputs["Color"], parts.inputs[0])
        self.join(parts.outputs["Green"], self.principled.inputs["Roughness"])
        self.join(parts.outputs["Blue"], self.principled.inputs["Metallic"])
        pbr = self.written()["pbrMetallicRoughness"]
        self.assertEqual(self.texture_file(pbr["metallicRoughnessTexture"]), os.path.realpath(bpy.path.abspath(image.filepath)))
        self.assertEqual((pbr["roughnessFactor"], pbr["metallicFactor"]), (1, 1))
        self.assertEqual(self.verdict()["verdict"], "exact")

    def test_roughness_of_a_grey_file(self):
        image = self.image(space="Non-Color", pixels=numpy.full((4, 4, 3), 51))
        self.textured(self.principled.inputs["Roughness"], image)
        self.set(Metallic=0.5)
        pbr = self.written()["pbrMetallicRoughness"]
        seen = kit.exr_pixels(self.texture_file(pbr["metallicRoughnessTexture"]))
        self.near(seen[..., 1] * pbr["roughnessFactor"], numpy.full((4, 4), 0.2), 1e-3)
        self.near(seen[..., 2] * pbr["metallicFactor"], numpy.full((4, 4), 0.5), 1e-3)
        self.assertEqual(self.verdict()["verdict"], "exact")

    def test_alpha_of_the_same_file(self):
        pixels = numpy.full((4, 4, 4), 128)
        image = self.image(pixels=pixels)
        node = self.textured(self.principled.inputs["Base Color"], image)
        self.join(node.outputs["Alpha"], self.principled.inputs["Alpha"])
        got = self.written()
        self.assertEqual(got["alphaMode"], "BLEND")
        self.assertEqual(self.texture_file(got["pbrMetallicRoughness"]["baseColorTexture"]), os.path.realpath(bpy.path.abspath(image.filepath)))

    def test_alpha_that_is_not_used(self):
        pixels = numpy.full((4, 4, 4), 128)
        self.textured(self.principled.inputs["Base Color"], self.image(pixels=pixels))
        got = self.written()
        self.assertNotIn("alphaMode", got)

    def test_colours_and_their_alpha_are_cycles(self):
        """Where no node asks for alpha, Cycles multiplies with it, unless the image's settings say otherwise."""
        coded = os.path.join(self.folder, "coded.png")
        images.write_png(coded, numpy.tile(numpy.array([255, 128, 0, 128], numpy.uint8), (4, 4, 1)))
        linear = os.path.join(self.folder, "linear.exr")
        images.write_exr(linear, numpy.tile(numpy.array([0.5, 0.25, 0, 0.5]), (4, 4, 1)))
        self.camera.location.z = 1
        self.tree.nodes.remove(self.principled)
        glow = self.node("ShaderNodeEmission")
        self.join(glow.outputs[0], self.output.inputs["Surface"])
        cases = [(coded, mode, space) for mode in ("STRAIGHT", "CHANNEL_PACKED", "NONE") for space in ("sRGB", "Non-Color")]
        cases += [(linear, mode, "Linear Rec.709") for mode in ("PREMUL", "CHANNEL_PACKED", "NONE")]
        for path, mode, space in cases:
            for linked in (False, True):
                with self.subTest(path=os.path.basename(path), mode=mode, space=space, linked=linked):
                    image = bpy.data.images.load(path)
                    image.alpha_mode, image.colorspace_settings.name = mode, space
                    node = self.textured(glow.inputs["Color"], image)
                    if linked:
                        self.join(node.outputs["Alpha"], glow.inputs["Strength"])
                    self.written()
                    self.assertEqual(self.verdict()["verdict"], "exact")
                    got = kit.rendered(self.found.path, 2, 2, 1)[0, 0]
                    # Cycles divides the numbers of 8 bits that it has multiplied before: steps of 1/128 and of twice that.
                    self.near(got, kit.cycles_pixels(2, 2, 1)[0, 0], 1e-2)
                    self.tree.nodes.remove(node)
                    bpy.data.images.remove(image)

    def test_cut_out(self):
        pixels = numpy.full((4, 4, 4), 128)
        node = self.textured(self.principled.inputs["Base Color"], self.image(pixels=pixels))
        more = self.node("ShaderNodeMath", operation="GREATER_THAN")
        more.inputs[1].default_value = 0.25
        self.join(node.outputs["Alpha"], more.inputs[0])
        self.join(more.outputs[0], self.principled.inputs["Alpha"])
        got = self.written()
        self.assertEqual((got["alphaMode"], got["alphaCutoff"]), ("MASK", 0.25))

    def test_normal_map(self):
        image = self.image(space="Non-Color")
        node, normal = self.node("ShaderNodeTexImage", image=image), self.node("ShaderNodeNormalMap")
        normal.inputs["Strength"].default_value = 0.5
        self.join(node.outputs["Color"], normal.inputs["Color"])
        self.join(normal.outputs["Normal"], self.principled.inputs["Normal"])
        got = self.written()["normalTexture"]
        self.assertEqual(got["scale"], 0.5)
        self.assertEqual(self.texture_file(got), os.path.realpath(bpy.path.abspath(image.filepath)))
        self.assertEqual(self.verdict()["verdict"], "exact")

    def test_emission_texture(self):
        self.textured(self.principled.inputs["Emission Color"])
        self.set(Emission_Strength=5)
        got = self.written()
        self.assertIn("emissiveTexture", got)
        self.near(got["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"], 5)

    def test_operations_are_baked(self):
        image = self.image(pixels=numpy.full((4, 4, 3), 188))
        node = self.node("ShaderNodeTexImage", image=image)
        invert = self.node("ShaderNodeInvert")
        self.join(node.outputs["Color"], invert.inputs["Color"])
        self.join(invert.outputs["Color"], self.principled.inputs["Base Color"])
        info = self.written()["pbrMetallicRoughness"]["baseColorTexture"]
        self.near(kit.exr_pixels(self.texture_file(info)), numpy.full((4, 4, 3), 1 - images.decode_srgb(188 / 255)), 1e-3)
        self.assertEqual(self.verdict()["verdict"], "exact")

    def test_two_uv_maps(self):
        self.mesh.uv_layers.new(name="second")
        self.textured(self.principled.inputs["Base Color"], self.image("one"))
        node = self.textured(self.principled.inputs["Emission Color"], self.image("two"))
        self.set(Emission_Strength=1)
        uv = self.node("ShaderNodeUVMap", uv_map="second")
        self.join(uv.outputs[0], node.inputs["Vector"])
        got = self.written()
        self.assertNotIn("texCoord", got["pbrMetallicRoughness"]["baseColorTexture"])
        self.assertEqual(got["emissiveTexture"]["texCoord"], 1)


class Trees(MaterialTest):
    """Groups, reroutes, muted nodes, circles, and what cannot be carried."""

    def group(self, value):
        """A group with a Value input that goes, times `value`, to its output."""
        tree = bpy.data.node_groups.new("group", "ShaderNodeTree")
        tree.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketFloat")
        tree.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketFloat")
        first, last, math_node = (tree.nodes.new(k) for k in ("NodeGroupInput", "NodeGroupOutput", "ShaderNodeMath"))
        math_node.operation = "MULTIPLY"
        math_node.inputs[1].default_value = value
        tree.links.new(first.outputs[0], math_node.inputs[0])
        tree.links.new(math_node.outputs[0], last.inputs[0])
        return tree

    def test_nested_groups(self):
        inner, outer = self.group(0.5), self.group(0.5)
        # The outer one has the inner one between its product and its output.
        between = outer.nodes.new("ShaderNodeGroup")
        between.node_tree = inner
        last = next(n for n in outer.nodes if n.type == "GROUP_OUTPUT")
        product = next(n for n in outer.nodes if n.type == "MATH")
        outer.links.new(product.outputs[0], between.inputs[0])
        outer.links.new(between.outputs[0], last.inputs[0])
        for start, socket in ((0.8, "Roughness"), (0.4, "Metallic")):
            used = self.node("ShaderNodeGroup", node_tree=outer)
            used.inputs[0].default_value = start
            self.join(used.outputs[0], self.principled.inputs[socket])
        pbr = self.written()["pbrMetallicRoughness"]
        self.near([pbr["roughnessFactor"], pbr["metallicFactor"]], [0.2, 0.1])

    def test_shader_in_a_group(self):
        tree = bpy.data.node_groups.new("group", "ShaderNodeTree")
        tree.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketShader")
        shader, last = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("NodeGroupOutput")
        shader.inputs["Strength"].default_value = 2
        tree.links.new(shader.outputs[0], last.inputs[0])
        used = self.node("ShaderNodeGroup", node_tree=tree)
        self.join(used.outputs[0], self.output.inputs["Surface"])
        got = self.written()
        self.near(got["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"], 2)

    def test_reroutes_and_muted_nodes(self):
        value, knot, invert = self.node("ShaderNodeRGB"), self.node("NodeReroute"), self.node("ShaderNodeInvert", mute=True)
        value.outputs[0].default_value = (0.25, 0.5, 0.75, 1)
        self.join(value.outputs[0], knot.inputs[0])
        self.join(knot.outputs[0], invert.inputs["Color"])
        self.join(invert.outputs["Color"], self.principled.inputs["Base Color"])
        self.near(self.written()["pbrMetallicRoughness"]["baseColorFactor"][:3], [0.25, 0.5, 0.75])

    def test_muted_link(self):
        value = self.node("ShaderNodeRGB")
        self.join(value.outputs[0], self.principled.inputs["Base Color"])
        self.tree.links[-1].is_muted = True
        self.set(Base_Color=(0.5, 0.25, 0.125, 1))
        self.near(self.written()["pbrMetallicRoughness"]["baseColorFactor"][:3], [0.5, 0.25, 0.125])

    def test_muted_shader(self):
        self.principled.mute = True
        self.written()

    def test_circles(self):
        first, second = self.node("ShaderNodeMath"), self.node("ShaderNodeMath")
        self.join(first.outputs[0], second.inputs[0])
        self.join(second.outputs[0], first.inputs[0])
        self.join(first.outputs[0], self.principled.inputs["Roughness"])
        self.written()
        one, two = self.node("ShaderNodeMixShader"), self.node("ShaderNodeMixShader")
        self.join(one.outputs[0], two.inputs[1])
        self.join(two.outputs[0], one.inputs[1])
        self.join(one.outputs[0], self.output.inputs["Surface"])
        self.written()
        knots = [self.node("NodeReroute") for _ in range(2)]
        self.join(knots[0].outputs[0], knots[1].inputs[0])
        self.join(knots[1].outputs[0], knots[0].inputs[0])
        self.join(knots[0].outputs[0], self.output.inputs["Surface"])
        self.written()

    def test_group_without_tree(self):
        used = self.node("ShaderNodeGroup", node_tree=self.group(1))
        self.join(used.outputs[0], self.principled.inputs["Roughness"])
        used.node_tree = None
        self.written()

    def test_no_output(self):
        self.tree.nodes.remove(self.output)
        self.near(self.written()["pbrMetallicRoughness"]["baseColorFactor"], [0, 0, 0, 1])
        self.assertEqual(self.verdict()["verdict"], "exact")

    def test_output_for_another_engine(self):
        other = self.node("ShaderNodeOutputMaterial", target="EEVEE")
        shader = self.node("ShaderNodeEmission")
        self.join(shader.outputs[0], other.inputs["Surface"])
        self.output.target = "CYCLES"
        self.set(Roughness=0.125)
        self.near(self.written()["pbrMetallicRoughness"]["roughnessFactor"], 0.125)

    def test_nothing_on_the_surface(self):
        """Nothing is black; what has a volume alone is passed."""
        self.tree.links.clear()
        got = self.written()
        self.assertNotIn("alphaMode", got)
        self.near(got["pbrMetallicRoughness"]["baseColorFactor"], [0, 0, 0, 1])
        self.join(self.node("ShaderNodeVolumeAbsorption").outputs[0], self.output.inputs["Volume"])
        got = self.written()
        self.assertEqual(got["alphaMode"], "BLEND")
        self.assertEqual(got["pbrMetallicRoughness"]["baseColorFactor"][3], 0)

    def test_procedural(self):
        noise = self.node("ShaderNodeTexNoise")
        self.join(noise.outputs["Color"], self.principled.inputs["Base Color"])
        self.written()
        verdict = self.verdict()
        self.assertEqual(verdict["verdict"], "approximated")
        self.assertIn("Noise Texture", verdict["detail"])
        self.assertIn("base colour", verdict["detail"])

    def test_checker_has_the_mean_of_its_colours(self):
        checker = self.node("ShaderNodeTexChecker")
        checker.inputs["Color1"].default_value, checker.inputs["Color2"].default_value = (1, 0, 0, 1), (0, 0, 1, 1)
        self.join(checker.outputs["Color"], self.principled.inputs["Base Color"])
        self.near(self.written()["pbrMetallicRoughness"]["baseColorFactor"][:3], [0.5, 0, 0.5])
        self.assertIn("mean", self.verdict()["detail"])

    def test_shaders(self):
        """Each shader node alone: a verdict, and a file that the program reads."""
        kinds = [name for name in dir(bpy.types) if name.startswith("ShaderNode")]
        skipped = {"ShaderNodeTree", "ShaderNode", "ShaderNodeCustomGroup"}
        for kind in kinds:
            if kind in skipped:
                continue
            try:
                node = self.node(kind)
            except (RuntimeError, TypeError):
                continue
            shader = next((s for s in node.outputs if s.type == "SHADER"), None)
            other = next((s for s in node.outputs if s.type in {"RGBA", "VALUE", "VECTOR"}), None)
            if shader is not None:
                self.join(shader, self.output.inputs["Surface"])
            elif other is not None:
                self.join(self.principled.outputs[0], self.output.inputs["Surface"])
                self.join(other, self.principled.inputs["Base Color"])
            else:
                self.tree.nodes.remove(node)
                continue
            with self.subTest(kind=kind):
                self.written()
                self.assertNotIn("rendered grey", self.verdict()["detail"])
                self.assertFalse(any(not math.isfinite(v) for v in self.found.material("m")["pbrMetallicRoughness"]["baseColorFactor"]))
            self.tree.nodes.remove(node)
        self.found.info()

    def test_mix_of_transparent(self):
        mix, clear = self.node("ShaderNodeMixShader"), self.node("ShaderNodeBsdfTransparent")
        mix.inputs[0].default_value = 0.25
        self.join(clear.outputs[0], mix.inputs[1])
        self.join(self.principled.outputs[0], mix.inputs[2])
        self.join(mix.outputs[0], self.output.inputs["Surface"])
        got = self.written()
        self.near(got["pbrMetallicRoughness"]["baseColorFactor"][3], 0.25)
        self.assertEqual(self.verdict()["verdict"], "exact")

    def test_unlit(self):
        mix, path, glow = self.node("ShaderNodeMixShader"), self.node("ShaderNodeLightPath"), self.node("ShaderNodeEmission")
        glow.inputs["Color"].default_value = (0.25, 0.5, 0.75, 1)
        self.join(path.outputs["Is Camera Ray"], mix.inputs[0])
        self.join(self.node("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
        self.join(glow.outputs[0], mix.inputs[2])
        self.join(mix.outputs[0], self.output.inputs["Surface"])
        self.near(self.written()["emissiveFactor"], [0.25, 0.5, 0.75])
        self.assertIn("the camera alone", self.verdict()["detail"])

    def test_sum_of_emission_and_diffuse(self):
        add, glow, diffuse = (self.node(k) for k in ("ShaderNodeAddShader", "ShaderNodeEmission", "ShaderNodeBsdfDiffuse"))
        diffuse.inputs["Color"].default_value = (0.25, 0.5, 0.75, 1)
        glow.inputs["Strength"].default_value = 0.5
        self.join(glow.outputs[0], add.inputs[0])
        self.join(diffuse.outputs[0], add.inputs[1])
        self.join(add.outputs[0], self.output.inputs["Surface"])
        got = self.written()
        self.near(got["emissiveFactor"], [0.5, 0.5, 0.5])
        self.near(got["pbrMetallicRoughness"]["baseColorFactor"], [0.25, 0.5, 0.75, 1])
        self.assertEqual(got["extensions"]["KHR_materials_ior"]["ior"], 1)
        self.assertEqual(self.verdict()["verdict"], "exact")

    def test_sum_of_emission_and_transparency(self):
        add, glow, clear = (self.node(k) for k in ("ShaderNodeAddShader", "ShaderNodeEmission", "ShaderNodeBsdfTransparent"))
        glow.inputs["Strength"].default_value = 0.5
        self.join(glow.outputs[0], add.inputs[0])
        self.join(clear.outputs[0], add.inputs[1])
        self.join(add.outputs[0], self.output.inputs["Surface"])
        got = self.written()
        strength = got["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"]
        # The light that leaves is alpha times the emission.
        self.near(numpy.array(got["emissiveFactor"]) * strength * got["pbrMetallicRoughness"]["baseColorFactor"][3], [0.5] * 3)
        self.assertEqual(self.verdict()["verdict"], "approximated")

    def test_glass_shader(self):
        glass = self.node("ShaderNodeBsdfGlass", distribution="MULTI_GGX")
        glass.inputs["Color"].default_value = (0.5, 0.25, 1, 1)
        self.join(glass.outputs[0], self.output.inputs["Surface"])
        got = self.written()
        # Each passage multiplies with the root of the base colour.
        self.near(got["pbrMetallicRoughness"]["baseColorFactor"][:3], [0.25, 0.0625, 1])
        self.near(got["extensions"]["KHR_materials_specular"]["specularColorFactor"], [0.5, 0.25, 1])
        self.near(got["extensions"]["SUNDOG_material"]["bsdf"]["inputs"]["Color"], [0.5, 0.25, 1])
        self.assertEqual(self.verdict()["verdict"], "exact")

    def test_displacement_and_volume(self):
        scatter, bump = self.node("ShaderNodeVolumeScatter"), self.node("ShaderNodeDisplacement")
        self.join(scatter.outputs[0], self.output.inputs["Volume"])
        self.join(self.node("ShaderNodeWireframe").outputs[0], scatter.inputs["Density"])
        self.join(bump.outputs[0], self.output.inputs["Displacement"])
        self.written()
        detail = self.verdict()["detail"]
        self.assertIn("volume", detail)
        self.assertIn("displacement", detail)

    def test_verdicts_are_json(self):
        noise = self.node("ShaderNodeTexNoise")
        self.join(noise.outputs["Color"], self.principled.inputs["Base Color"])
        self.link("lamp", bpy.data.lights.new("lamp", "POINT"))
        self.scene.world = bpy.data.worlds.new("w")
        self.written()
        again = json.loads(json.dumps(self.found.result.verdicts))
        self.assertEqual({v["kind"] for v in again}, {"material", "light", "world", "camera"})
        for verdict in again:
            self.assertIn(verdict["verdict"], {"exact", "approximated", "lost"})
            self.assertEqual(verdict["verdict"] == "exact", verdict["detail"] == "")
        # The worst first.
        self.assertEqual(again[0]["name"], "m")


if __name__ == "__main__":
    unittest.main()
