# SPDX-License-Identifier: GPL-3.0-or-later
"""What used to be told wrongly or not at all: each is rendered as Cycles does, or has a true verdict."""

import os
import struct
import unittest
import zlib

import bpy
import export_kit as kit
import numpy
from sundog import passes, records
from sundog.export import images


class Told(kit.ExportTest):
    """Verdicts and what stands behind them."""

    def textured(self, name="textured", **settings):
        """A plane that shows an image as it is, its material's tree, and the image node."""
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        tree = made.node_tree
        tree.nodes.clear()
        emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
        shown = tree.nodes.new("ShaderNodeTexImage")
        tree.links.new(shown.outputs["Color"], emission.inputs["Color"])
        tree.links.new(emission.outputs[0], output.inputs["Surface"])
        mesh = kit.plane(name)
        mesh.materials.append(made)
        return self.link(name, mesh, **settings), tree, shown

    def image(self, name="image", size=8, alpha=None):
        """A packed image of random colours."""
        made = bpy.data.images.new(name, size, size, alpha=alpha is not None)
        values = numpy.random.default_rng(1).random((size, size, 4), numpy.float32)
        values[..., 3] = 1 if alpha is None else alpha
        made.pixels.foreach_set(values.reshape(-1))
        made.pack()
        return made

    def test_random_textures_of_modifiers(self):
        """Noise is drawn anew at each evaluation; other textures of modifiers are in the mesh, and nothing is lost of them."""
        for kind, verdict in (("NOISE", "approximated"), ("CLOUDS", "exact")):
            texture = bpy.data.textures.new(kind, kind)
            made = self.link(kind, kit.plane(kind))
            modifier = made.modifiers.new("moved", "DISPLACE")
            modifier.texture = texture
            told = lambda: [v["verdict"] for v in self.export().result.verdicts if (v["kind"], v["name"]) == ("object", kind)] or ["exact"]  # noqa: B023, E731
            self.assertEqual(told(), [verdict])
            modifier.show_render = False
            self.assertEqual(told(), ["exact"])

    def test_shining_twins(self):
        """Of two objects that shine in one place rounding decides in Cycles how much light they give; without emission nothing is to be told."""
        for strength, verdict in ((0, "exact"), (5, "approximated")):
            material = kit.material(f"of {strength}", Emission_Color=(1, 1, 1, 1), Emission_Strength=strength)
            mesh = kit.cube(f"cube {strength}")
            mesh.materials.append(material)
            for name, height in (("one", 1), ("other", 1), ("above", 4)):
                self.link(f"{name} {strength}", mesh, location=(strength, 0, height))
            found = self.export().result.verdicts
            told = [v["name"] for v in found if v["kind"] == "object" and "stands in the place" in v["detail"]]
            self.assertEqual(told, [] if verdict == "exact" else [f"other {strength}"])

    def test_culling_by_camera_and_distance(self):
        for name, place in (("seen", (0, 0, 0)), ("beside", (9, 0, 0)), ("behind", (0, 0, 14)), ("far", (0, 0, -30))):
            self.link(name, kit.cube(name), location=place)
        render, cycles = self.scene.render, self.scene.cycles
        render.resolution_x, render.resolution_y = 32, 32
        cycles.camera_cull_margin, cycles.distance_cull_margin = 0.1, 20
        cycles.use_camera_cull = cycles.use_distance_cull = True
        for made in self.scene.objects:
            made.cycles.use_camera_cull = True
        everything = ["behind", "beside", "far", "seen"]
        self.assertEqual(self.export().names(), everything)
        render.use_simplify = True
        self.assertEqual(self.export().names(), ["far", "seen"])
        for made in self.scene.objects:
            made.cycles.use_distance_cull = True
        # By both only what is outside by both.
        self.assertEqual(self.export().names(), everything)
        cycles.use_camera_cull = False
        self.assertEqual(self.export().names(), ["behind", "beside", "seen"])
        cycles.camera_cull_margin, cycles.use_camera_cull, cycles.use_distance_cull = 2, True, False
        self.assertEqual(self.export().names(), ["beside", "far", "seen"])

    def test_cycles_culls_the_same(self):
        glow = kit.material("glow", Emission_Color=(1, 1, 1, 1), Emission_Strength=50)
        mesh = kit.cube("lamp")
        mesh.materials.append(glow)
        lamp = self.link("lamp", mesh)
        lamp.cycles.use_camera_cull = True
        self.link("floor", kit.plane("floor", 60), location=(0, 0, -4))
        self.scene.render.use_simplify = self.scene.cycles.use_camera_cull = True
        self.scene.cycles.camera_cull_margin = 0.1
        self.scene.render.resolution_x = self.scene.render.resolution_y = 8
        for kind in ("PERSP", "ORTHO"):
            self.camera.data.type, self.camera.data.ortho_scale = kind, 7.2
            for place in ((4.0, 0, 0), (5.0, 0, 0), (5.8, 0, 0), (0, 5.5, 0), (0, 0, 11.2), (0, 0, 11.5)):
                with self.subTest(kind=kind, place=place):
                    lamp.location = place
                    shown = bool(kit.cycles_pixels(8, 8, 16).max() > 0)
                    self.scene.render.engine = "BLENDER_EEVEE_NEXT" if (4, 2) <= bpy.app.version < (5, 0) else "BLENDER_EEVEE"
                    self.assertEqual("lamp" in self.export().names(), shown)

    def test_light_groups(self):
        layer = self.scene.view_layers[0]
        made = self.link("cube", kit.cube())
        lamp = self.link("lamp", bpy.data.lights.new("lamp", "POINT"))
        self.scene.world = bpy.data.worlds.new("world")
        made.lightgroup = lamp.lightgroup = self.scene.world.lightgroup = "key"
        # Without the view layer's own group of that name Cycles knows none either.
        self.assertNotIn("cube", [v["name"] for v in self.export().result.verdicts])
        layer.lightgroups.add(name="key")
        self.assertEqual(passes.left_out(layer), [])
        self.assertEqual([p.name for p in passes.light_groups(layer)], ["Combined_key"])
        found = self.export()
        scene = found.root["scenes"][0]["extensions"]["SUNDOG_scene"]
        self.assertEqual((scene["light_groups"], scene["world"]["light_group"]), (["key"], "key"))
        self.assertEqual(found.node("cube")["extensions"]["SUNDOG_object"]["light_group"], "key")
        (light,) = found.root["extensions"]["KHR_lights_punctual"]["lights"]
        self.assertEqual(light["extensions"]["SUNDOG_light"]["light_group"], "key")

    def test_grease_pencil_is_blenders_own(self):
        name = "grease_pencils" if bpy.app.version >= (5, 0, 0) else "grease_pencils_v3" if bpy.app.version >= (4, 3, 0) else "grease_pencils"
        self.link("strokes", getattr(bpy.data, name).new("strokes"))
        self.assertEqual(self.export().verdict("object", "strokes")["verdict"], "exact")

    def test_transparent_glass(self):
        def glass():
            return self.export().root["scenes"][0]["extensions"]["SUNDOG_scene"]["render"].get("transparent_glass")

        self.scene.cycles.film_transparent_glass, self.scene.cycles.film_transparent_roughness = True, 0.25
        self.assertIsNone(glass())
        self.scene.render.film_transparent = True
        self.assertEqual(glass(), 0.25)

    def fed(self, made, kind, output, socket):
        """A new node that feeds an input of the material's Principled BSDF."""
        tree = made.node_tree
        node = tree.nodes.new(kind)
        tree.links.new(node.outputs[output], tree.nodes["Principled BSDF"].inputs[socket])
        return node

    def shown(self, made):
        """The export of a plane of a material."""
        mesh = kit.plane()
        mesh.materials.append(made)
        self.link("plane", mesh)
        return self.export()

    def test_ambient_occlusion(self):
        self.write_graphs(False)
        made = kit.material("old")
        self.fed(made, "ShaderNodeAmbientOcclusion", "Color", "Base Color").inputs["Color"].default_value = (0.5, 0.2, 0.1, 1)
        self.fed(made, "ShaderNodeAmbientOcclusion", "AO", "Roughness")
        found = self.shown(made)
        verdict = found.verdict("material", "old")
        self.assertEqual(verdict["verdict"], "approximated")
        self.assertIn("Ambient Occlusion node, which is taken as open", verdict["detail"])
        self.near(found.material("old")["pbrMetallicRoughness"]["baseColorFactor"], [0.5, 0.2, 0.1, 1])

    def test_normal_maps_without_an_image(self):
        self.write_graphs(False)
        for color, feeder, verdict in (
            ((0.5, 0.5, 1, 1), None, "exact"),
            ((0.7, 0.5, 0.9, 1), None, "lost"),
            ((0.5, 0.5, 1, 1), "ShaderNodeTexNoise", "lost"),
            ((0.5, 0.5, 1, 1), "ShaderNodeVertexColor", "lost"),
        ):
            with self.subTest(color=color, feeder=feeder):
                made = kit.material("bumpy")
                node = self.fed(made, "ShaderNodeNormalMap", "Normal", "Normal")
                node.inputs["Color"].default_value = color
                if feeder:
                    source = made.node_tree.nodes.new(feeder)
                    made.node_tree.links.new(source.outputs["Color"], node.inputs["Color"])
                found = self.shown(made)
                self.assertEqual(found.verdict("material", "bumpy")["verdict"], verdict)
                node.inputs["Strength"].default_value = 0
                self.assertEqual(self.export().verdict("material", "bumpy")["verdict"], "exact")
                bpy.data.objects.remove(bpy.data.objects["plane"])
                bpy.data.materials.remove(made)

    def test_image_coordinates_by_an_attribute(self):
        self.write_graphs(False)
        made, tree, shown = self.textured()
        shown.image = self.image()
        where = tree.nodes.new("ShaderNodeAttribute")
        where.attribute_name = "where"
        tree.links.new(where.outputs["Vector"], shown.inputs["Vector"])
        mesh = made.data
        rng = numpy.random.default_rng(3)
        for kind, field, width in (("FLOAT_VECTOR", "vector", 3), ("FLOAT2", "vector", 2), ("FLOAT_COLOR", "color", 4), ("FLOAT", "value", 1)):
            for domain, count in (("POINT", 4), ("EDGE", 4), ("FACE", 1), ("CORNER", 4)):
                if mesh.attributes.get("where") is not None:
                    mesh.attributes.remove(mesh.attributes["where"])
                values = rng.random((count, width), numpy.float32)
                mesh.attributes.new("where", kind, domain).data.foreach_set(field, values.reshape(-1))
                expected = numpy.repeat(values, 2, axis=1) if width == 1 else values[:, :2]
                if domain == "POINT":
                    expected = expected[[loop.vertex_index for loop in mesh.loops]]
                elif domain == "EDGE":
                    edges = [loop.edge_index for loop in mesh.loops]
                    expected = (expected[edges] + expected[[*edges[-1:], *edges[:-1]]]) / 2
                elif domain == "FACE":
                    expected = numpy.repeat(expected, 4, axis=0)
                with self.subTest(kind=kind, domain=domain):
                    found = self.export()
                    (primitive,) = found["meshes"][0]["primitives"]
                    got = found.array(primitive["attributes"]["TEXCOORD_0"])
                    self.near(got[:, 0], expected[:, 0])
                    self.near(1 - got[:, 1], expected[:, 1], 1e-5)
                    self.assertEqual(found.verdict("material", "textured")["verdict"], "exact")
        tree.links.new(where.outputs["Fac" if "Fac" in where.outputs else "Factor"], shown.inputs["Vector"])
        self.assertEqual(self.export().verdict("material", "textured")["verdict"], "approximated")

    def test_cycles_reads_attributes_of_geometry_nodes_the_same(self):
        made, tree, shown = self.textured()
        shown.image = self.image()
        where = tree.nodes.new("ShaderNodeAttribute")
        where.attribute_name = "where"
        tree.links.new(where.outputs["Vector"], shown.inputs["Vector"])
        group = bpy.data.node_groups.new("group", "GeometryNodeTree")
        for way in ("INPUT", "OUTPUT"):
            group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
        first, last = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
        stored, position = group.nodes.new("GeometryNodeStoreNamedAttribute"), group.nodes.new("GeometryNodeInputPosition")
        placed = group.nodes.new("ShaderNodeVectorMath")
        placed.operation = "MULTIPLY_ADD"
        placed.inputs[1].default_value, placed.inputs[2].default_value = (0.3, 0.2, 0.1), (0.4, 0.6, 0.2)
        stored.data_type, stored.domain = "FLOAT_VECTOR", "POINT"
        stored.inputs["Name"].default_value = "where"
        group.links.new(position.outputs[0], placed.inputs[0])
        group.links.new(first.outputs[0], stored.inputs[0])
        group.links.new(placed.outputs[0], next(s for s in stored.inputs if s.name == "Value" and s.enabled))
        group.links.new(stored.outputs[0], last.inputs[0])
        made.modifiers.new("nodes", "NODES").node_group = group
        self.camera.location = (0, 0, 2.5)
        expected = kit.cycles_pixels(16, 16, 16)
        got = kit.rendered(self.export().path, 16, 16, 16)
        self.assertGreater(expected.std(), 0.1)
        self.assertLess(numpy.abs(got - expected).mean(), 0.02)

    def test_uv_pass_of_what_has_no_texture(self):
        mesh = kit.plane()
        other = mesh.uv_layers.new(name="other")
        for corner, value in zip(other.data, [(0.2, 0.1), (0.4, 0.1), (0.4, 0.5), (0.2, 0.5)]):
            corner.uv = value
        other.active_render = True
        self.link("plane", mesh)
        textured, tree, shown = self.textured(location=(3, 0, 0))
        shown.image = self.image()
        uv = tree.nodes.new("ShaderNodeUVMap")
        uv.uv_map = "second"
        textured.data.uv_layers.new(name="second")
        tree.links.new(uv.outputs[0], shown.inputs["Vector"])
        found = self.export()
        names = {m["name"]: sorted(m["primitives"][0]["attributes"]) for m in found["meshes"]}
        self.assertNotIn("TEXCOORD_0", names["plane"])
        self.scene.view_layers[0].use_pass_uv = True
        found = self.export()
        attributes = {m["name"]: m["primitives"][0]["attributes"] for m in found["meshes"]}
        self.near(found.array(attributes["plane"]["TEXCOORD_0"]), [(0.2, 0.9), (0.4, 0.9), (0.4, 0.5), (0.2, 0.5)], 1e-6)
        self.near(found.array(attributes["textured"]["TEXCOORD_0"]), [(0, 1), (1, 1), (1, 0), (0, 0)])
        emissive = found.material("textured")["emissiveTexture"]
        self.assertEqual(emissive["texCoord"], 1)

    def sequence(self, alpha=False):
        """A plane that shows a sequence of the files 1 to 5, each of its own grey; and the image node."""
        for number in range(1, 6):
            picture = bpy.data.images.new("picture", 4, 4, alpha=alpha)
            values = numpy.full((16, 4), number / 10, numpy.float32)
            values[:, 3] = numpy.where(numpy.arange(16) < 8, 0.5, 1.0) if alpha else 1
            picture.pixels.foreach_set(values.reshape(-1))
            picture.filepath_raw = os.path.join(self.folder, f"picture{number:03}.png")
            picture.file_format = "PNG"
            picture.save()
            bpy.data.images.remove(picture)
        made, tree, shown = self.textured()
        shown.image = bpy.data.images.load(os.path.join(self.folder, "picture001.png"))
        shown.image.source = "SEQUENCE"
        shown.image_user.frame_duration, shown.image_user.frame_start = 5, 10
        self.camera.location = (0, 0, 1)
        return made, tree, shown

    def test_sequences_of_images(self):
        _, tree, shown = self.sequence()
        for frame, offset, expected in ((10, 0, 1), (12, 0, 3), (20, 0, 5), (11, 2, 4)):
            with self.subTest(frame=frame, offset=offset):
                shown.image_user.frame_offset = offset
                self.scene.frame_set(frame)
                found = self.export()
                self.assertTrue(found["images"][0]["uri"].endswith(f"picture{expected:03}.png"), found["images"])
                self.assertEqual(found.verdict("material", "textured")["verdict"], "exact")
        self.near(kit.rendered(found.path, 4, 4, 4).mean(), kit.cycles_pixels(4, 4, 4).mean(), 0.01)
        # Before its first frame Cycles shows that there is no picture.
        shown.image_user.frame_offset = 0
        self.scene.frame_set(5)
        self.assertIn("pink", self.export().verdict("material", "textured")["detail"])
        # An expression of a picture.
        self.scene.frame_set(12)
        inverted = tree.nodes.new("ShaderNodeInvert")
        tree.links.new(shown.outputs["Color"], inverted.inputs["Color"])
        tree.links.new(inverted.outputs[0], tree.nodes["Emission"].inputs["Color"])
        found = self.export()
        self.assertEqual(found.verdict("material", "textured")["verdict"], "exact")
        self.near(kit.rendered(found.path, 4, 4, 4).mean(), kit.cycles_pixels(4, 4, 4).mean(), 0.01)

    def test_sequences_with_alpha(self):
        _, _, shown = self.sequence(alpha=True)
        shown.interpolation = "Closest"
        self.scene.frame_set(14)
        found = self.export()
        self.near(kit.rendered(found.path, 4, 4, 4).mean(), kit.cycles_pixels(4, 4, 4).mean(), 0.01)

    def test_pictures_of_sequences_are_decoded_as_blender_does(self):
        rng = numpy.random.default_rng(5)
        for channels, kind in ((1, 0), (3, 2), (2, 4), (4, 6)):
            for bits in (8, 16):
                step = channels * bits // 8
                pixels = rng.integers(0, 256, (10, 7 * step), numpy.uint8)
                pixels[..., :] //= 3
                lines = []
                for number, row in enumerate(pixels):
                    above = pixels[number - 1] if number else numpy.zeros_like(row)
                    lines.append(bytes([number % 5]) + filtered(number % 5, row, above, step))
                header = struct.pack(">IIBBBBB", 7, 10, bits, kind, 0, 0, 0)
                path = os.path.join(self.folder, f"{channels}-{bits}.png")
                with open(path, "wb") as file:
                    file.write(b"\x89PNG\r\n\x1a\n" + b"".join(
                        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
                        for name, data in ((b"IHDR", header), (b"IDAT", zlib.compress(b"".join(lines))), (b"IEND", b""))
                    ))
                loaded = bpy.data.images.load(path)
                loaded.colorspace_settings.name = "Non-Color"
                with self.subTest(channels=channels, bits=bits):
                    expected = images._raw_pixels(loaded)
                    got = images._raw_pixels(images.Picture(loaded, path))
                    # Blender keeps 16 bits by its own rounding to floats.
                    self.near(got, expected, 1 / 65535)
                bpy.data.images.remove(loaded)

    def test_cut_outs_have_no_fringes(self):
        """A leaf on a card, whose transparent texels are red: Cycles shows no red, be it cut out hard or softly."""
        size = 16
        y, x = numpy.mgrid[:size, :size]
        radius = numpy.hypot(x - size / 2 + 0.5, y - size / 2 + 0.5)
        for soft, by, packed in ((1e-3, "alpha", False), (3, "alpha", False), (1e-3, "mix", False), (1e-3, "mask", False), (1e-3, "alpha", True)):
            with self.subTest(soft=soft, by=by, packed=packed):
                self.setUp()
                opacity = numpy.clip((size * 0.35 - radius) / soft + 0.5, 0, 1)
                values = numpy.empty((size, size, 4), numpy.float32)
                values[..., :3] = numpy.where(opacity[..., None] > 0, (0.1, 0.6, 0.1), (1, 0, 0))
                values[..., 3] = opacity
                leaf = bpy.data.images.new("leaf", size, size, alpha=True)
                leaf.pixels.foreach_set(values.reshape(-1))
                leaf.pack()
                leaf.alpha_mode = "CHANNEL_PACKED" if packed else "STRAIGHT"
                card, tree, shown = self.textured("leaf")
                shown.image = leaf
                factor = shown.outputs["Alpha"]
                if by == "mask":
                    threshold = tree.nodes.new("ShaderNodeMath")
                    threshold.operation = "GREATER_THAN"
                    tree.links.new(factor, threshold.inputs[0])
                    factor = threshold.outputs[0]
                output = tree.nodes["Material Output"].inputs["Surface"]
                if by == "mix":
                    mixed, clear = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
                    tree.links.new(factor, mixed.inputs[0])
                    tree.links.new(clear.outputs[0], mixed.inputs[1])
                    tree.links.new(tree.nodes["Emission"].outputs[0], mixed.inputs[2])
                    tree.links.new(mixed.outputs[0], output)
                else:
                    principled = tree.nodes.new("ShaderNodeBsdfPrincipled")
                    principled.inputs["Specular IOR Level"].default_value = 0
                    tree.links.new(shown.outputs["Color"], principled.inputs["Base Color"])
                    tree.links.new(factor, principled.inputs["Alpha"])
                    tree.links.new(principled.outputs[0], output)
                self.link("sun", bpy.data.lights.new("sun", "SUN")).data.energy = 3
                self.camera.location = (0, 0, 2.8)
                expected = kit.cycles_pixels(32, 32, 64).mean(axis=(0, 1))
                found = self.export()
                got = kit.rendered(found.path, 32, 32, 64).mean(axis=(0, 1))
                # Without weights red was 2.8 to 4.7 times as much, and green a tenth less.
                self.near(got, expected, 0.01)
                self.near(got[0], expected[0], 0.03)
                self.assertEqual("SUNDOG_sampler" in found.root["extensionsUsed"], not packed)

    def test_nothing_is_listed_twice(self):
        # Without its node tree both tell of what goes on below the surface.
        self.write_graphs(False)
        made = kit.material("full", Coat_Weight=1, Sheen_Weight=1, Subsurface_Weight=1, Anisotropic=0.5, Thin_Film_Thickness=300)
        if "Diffuse Roughness" in made.node_tree.nodes["Principled BSDF"].inputs:
            made.node_tree.nodes["Principled BSDF"].inputs["Diffuse Roughness"].default_value = 0.5
        self.link("lamp", bpy.data.lights.new("lamp", "SUN"))
        found = self.shown(made)
        diagnostics = found.info()["diagnostics"]
        self.assertGreater(len(diagnostics), 0)
        record = records.begin_alone(self.scene, self.scene.view_layers[0])
        record.update(verdicts=found.result.verdicts, diagnostics=diagnostics)
        told = records.last_verdicts()
        self.assertEqual([v for v in told if v["kind"] == "program"], [])
        self.assertEqual(len([v for v in told if "subsurface" in v["detail"]]), 1)
        # By the ids of the effects, whatever the words are.
        # Films of before 5.0 are rendered, but not as that Cycles does: only the add-on tells.
        old_film = {"thin-film"} if bpy.app.version < (5, 0, 0) else set()
        self.assertEqual(set(found.verdict("material", "full")["effects"]), {d["effect"] for d in diagnostics} | old_film)
        for each in diagnostics:
            each["feature"] = "other words"
        self.assertEqual([v for v in records.last_verdicts() if v["kind"] == "program"], [])
        # What the export has not said is told.
        record["verdicts"] = []
        self.assertEqual(len(records.last_verdicts()), len(diagnostics))


def filtered(kind, row, above, step):
    """A row of a PNG with one of its five filters."""
    left = numpy.concatenate([numpy.zeros(step, numpy.uint8), row[:-step]]).astype(int)
    corner = numpy.concatenate([numpy.zeros(step, numpy.uint8), above[:-step]]).astype(int)
    up = above.astype(int)
    guess = left + up - corner
    a, b, c = abs(guess - left), abs(guess - up), abs(guess - corner)
    paeth = numpy.where((a <= b) & (a <= c), left, numpy.where(b <= c, up, corner))
    taken = (numpy.zeros_like(left), left, up, (left + up) // 2, paeth)[kind]
    return ((row.astype(int) - taken) & 255).astype(numpy.uint8).tobytes()


if __name__ == "__main__":
    unittest.main()
