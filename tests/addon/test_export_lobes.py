# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders that glTF's metallic-roughness has no word for: what is written, and the picture against Cycles'."""

import unittest

import bpy
import export_kit as kit
import numpy

PARTS = (0.0, 0.25, 0.5, 0.75, 1.0)
RED, GOLD, BLUE = (0.9, 0.4, 0.2, 1), (0.9, 0.6, 0.2, 1), (0.2, 0.5, 0.9, 1)


def tree_of(name):
    """A material without a shader: its nodes, and the input of its surface."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    return material, tree, tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]


def alone(name, kind, **inputs):
    """A material of one shader."""
    material, tree, surface = tree_of(name)
    shader = tree.nodes.new(kind)
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    tree.links.new(shader.outputs[0], surface)
    return material


def both(name, first, second, how):
    """A material that is a mix or a sum of two shaders: each of a kind, with values of inputs."""
    material, tree, surface = tree_of(name)
    joined = tree.nodes.new(f"ShaderNode{how}Shader")
    sockets = [s for s in joined.inputs if s.type == "SHADER"]
    for (kind, inputs), socket in zip((first, second), sockets):
        shader = tree.nodes.new(kind)
        for key, value in inputs.items():
            shader.inputs[key].default_value = value
        tree.links.new(shader.outputs[0], socket)
    tree.links.new(joined.outputs[0], surface)
    return material


def along_u(material):
    """The material with a tangent along its UV map."""
    tree = material.node_tree
    tangent = tree.nodes.new("ShaderNodeTangent")
    tangent.direction_type = "UV_MAP"
    shader = next(n for n in tree.nodes if "Tangent" in n.inputs)
    tree.links.new(tangent.outputs[0], shader.inputs["Tangent"])
    return material


def part_clear(name, part):
    """Red matte, a part of which lets blue light pass."""
    material, tree, surface = tree_of(name)
    matte, clear, mixed = (tree.nodes.new(f"ShaderNode{k}") for k in ("BsdfDiffuse", "BsdfTransparent", "MixShader"))
    matte.inputs["Color"].default_value, clear.inputs["Color"].default_value = RED, BLUE
    mixed.inputs[0].default_value = part
    tree.links.new(matte.outputs[0], mixed.inputs[1])
    tree.links.new(clear.outputs[0], mixed.inputs[2])
    tree.links.new(mixed.outputs[0], surface)
    return material


class Lobes(kit.ExportTest):
    """Rough diffuse surfaces, Glossy BSDFs, transparency of a colour."""

    def material(self, made):
        """What a material is in the file."""
        self.link("object", self.with_material(made))
        return self.export().material(made.name)

    @staticmethod
    def with_material(made):
        mesh = kit.plane(made.name)
        mesh.materials.append(made)
        return mesh

    def balls(self):
        """Four rows of five balls under a sun, before a dim world."""
        rows = [
            [alone(f"diffuse {r}", "ShaderNodeBsdfDiffuse", Color=RED, Roughness=r) for r in PARTS],
            # Smoother ones throw caustics on their neighbours, which are noise at so few samples.
            [alone(f"glossy {r}", "ShaderNodeBsdfGlossy", Color=GOLD, Roughness=r) for r in (0.5, 0.6, 0.7, 0.8, 1.0)],
            [part_clear(f"clear {part}", part) for part in PARTS],
        ]
        if "Diffuse Roughness" in alone("probe", "ShaderNodeBsdfPrincipled").node_tree.nodes[1].inputs:
            rows.append([alone(f"base {r}", "ShaderNodeBsdfPrincipled", Base_Color=RED, Roughness=0.4, Diffuse_Roughness=r) for r in PARTS])
        self.show(rows)

    def show(self, rows):
        """Balls in rows, under a sun and before a dim world."""
        for line, row in enumerate(rows):
            for column, made in enumerate(row):
                bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.42, location=(column - 2, line - 1.5, 0))
                ball = bpy.context.object
                ball.data.shade_smooth()
                ball.data.materials.append(made)
        kit.sun_and_grey_world(self.scene)
        data = self.camera.data
        data.type, data.ortho_scale = "ORTHO", 6
        # What makes light go lost or spread on purpose stays out of it.
        kit.unbiased(self.scene.cycles)
        render = self.scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = 96, 64, 100

    def test_pictures_are_those_of_cycles(self):
        self.balls()
        self.agree()

    def test_anisotropic_pictures_are_those_of_cycles(self):
        """Around the Z axis, and along the UV maps of the balls."""
        rows = [
            [alone(f"principled {a}", "ShaderNodeBsdfPrincipled", Base_Color=GOLD, Metallic=1, Roughness=0.5, Anisotropic=a) for a in PARTS],
            [alone(f"glossy {a}", "ShaderNodeBsdfGlossy", Color=GOLD, Roughness=0.6, Anisotropy=a, Rotation=0.125) for a in (-0.8, -0.4, 0, 0.4, 0.8)],
            [along_u(alone(f"turned {r}", "ShaderNodeBsdfPrincipled", Roughness=0.5, Anisotropic=0.8, Anisotropic_Rotation=r)) for r in PARTS],
            [alone(f"edge {t}", "ShaderNodeBsdfPrincipled", Base_Color=GOLD, Metallic=1, Roughness=0.4, Specular_Tint=(t, 1, 1 - t, 1)) for t in PARTS],
        ]
        self.show(rows)
        self.assertEqual({v["verdict"] for v in self.agree().values()}, {"exact"})

    def test_layered_pictures_are_those_of_cycles(self):
        """Coats of all roughnesses, indices and tints, and sheen."""
        def principled(name, **inputs):
            return alone(name, "ShaderNodeBsdfPrincipled", Base_Color=RED, **inputs)
        rows = [
            [principled(f"coat {r}", Roughness=0.7, Coat_Weight=1, Coat_Roughness=r) for r in (0.3, 0.4, 0.5, 0.75, 1)],
            [principled(f"index {i}", Roughness=0.5, Coat_Weight=0.5, Coat_Roughness=0.4, Coat_IOR=i) for i in (1, 1.2, 1.6, 2, 3)],
            [principled(f"tint {t}", Metallic=t, Roughness=0.5, Coat_Weight=t, Coat_Roughness=0.5, Coat_Tint=BLUE) for t in PARTS],
            [principled(f"sheen {r}", Sheen_Weight=1, Sheen_Roughness=r, Sheen_Tint=GOLD) for r in (0.1, 0.3, 0.5, 0.75, 1)],
        ]
        self.show(rows)
        self.assertEqual({v["verdict"] for v in self.agree().values()}, {"exact"})

    def test_shaders_of_one_lobe_are_those_of_cycles(self):
        """Diffuse transmission, metals, fibres, toon shading and refraction."""
        def toon(kind, size):
            made = alone(f"{kind} toon {size}", "ShaderNodeBsdfToon", Color=RED, Size=size, Smooth=0.3)
            made.node_tree.nodes["Toon BSDF"].component = kind
            return made
        def metal(kind, roughness):
            made = alone(f"{kind} {roughness}", "ShaderNodeBsdfMetallic", Roughness=roughness)
            made.node_tree.nodes["Metallic BSDF"].fresnel_type = kind
            return made
        rows = [
            [alone("translucent", "ShaderNodeBsdfTranslucent", Color=BLUE), metal("F82", 0.5), metal("F82", 0.7),
             metal("PHYSICAL_CONDUCTOR", 0.5), metal("PHYSICAL_CONDUCTOR", 0.7)],
            [alone(f"fibres {r}", "ShaderNodeBsdfSheen", Color=GOLD, Roughness=r) for r in (0.1, 0.3, 0.5, 0.75, 1)],
            [toon("DIFFUSE", 0.3), toon("DIFFUSE", 0.9), toon("GLOSSY", 0.2), toon("GLOSSY", 0.6),
             alone("refraction", "ShaderNodeBsdfRefraction", Roughness=0.5, IOR=1.3)],
        ]
        # Rough glass leaks the light of lamps in Cycles: test_parity_lobes compares it in the light of a uniform world.
        self.show(rows)
        self.assertEqual({v["verdict"] for v in self.agree().values()}, {"exact"})

    def test_mixes_that_are_none_of_their_inputs_are_those_of_cycles(self):
        """What is flattened is exact: of matte surfaces of one roughness and with the same normals alone."""
        smooth, rough = ("ShaderNodeBsdfDiffuse", {"Color": RED}), ("ShaderNodeBsdfDiffuse", {"Color": BLUE, "Roughness": 0.8})
        coated = ("ShaderNodeBsdfPrincipled", {"IOR": 1, "Coat Weight": 1, "Sheen Weight": 0.5, "Base Color": BLUE})
        clear, tinted = (("ShaderNodeBsdfTransparent", {"Color": c}) for c in ((1, 1, 1, 1), (0.2, 0.6, 0.9, 1)))
        glow = ("ShaderNodeEmission", {"Color": GOLD, "Strength": 0.5})
        rows = [
            [both("smooth and rough", smooth, rough, "Mix"), both("rough and rough", rough, (rough[0], {"Color": RED, "Roughness": 0.8}), "Mix"),
             both("sum of them", smooth, rough, "Add"), both("rough and glow", rough, glow, "Mix"), both("smooth and smooth", smooth, (smooth[0], {"Color": BLUE}), "Mix")],
            [both("coated", smooth, coated, "Mix"), both("sum of coated", smooth, coated, "Add"), both("coated and glow", coated, glow, "Add"),
             both("two transparent", clear, tinted, "Mix"), both("transparent and matte", tinted, smooth, "Mix")],
        ]
        self.show(rows)
        self.assertEqual({v["verdict"] for v in self.agree().values()}, {"exact"})
        written = {name: "SUNDOG_shader_graph" in self.material(made)["extensions"] for name, made in ((m.name, m) for row in rows for m in row)}
        self.assertFalse(written["smooth and smooth"])
        self.assertTrue(all(is_graph for name, is_graph in written.items() if name not in {"smooth and smooth", "transparent and matte"}), written)

    def agree(self):
        """Compares the picture with Cycles'; the verdicts on materials."""
        found = self.export()
        seen = kit.cycles_pixels(96, 64, 512)
        got = kit.rendered(found.path, 96, 64, 512)

        def blocks(picture):
            return picture.reshape(8, 8, 12, 8, 3).mean(axis=(1, 3))

        worst = numpy.abs(blocks(got) - blocks(seen)) / numpy.maximum(blocks(seen), 1e-3)
        self.assertLess(worst.max(), 0.03, f"{worst.max(axis=2).round(3)}")
        self.assertLess(abs(got.mean() / seen.mean() - 1), 0.005)
        return {v["name"]: v for v in found.result.verdicts if v["kind"] == "material"}

    def test_what_is_written(self):
        made = self.material(alone("glossy", "ShaderNodeBsdfGlossy", Color=GOLD, Roughness=0.25))
        self.assertEqual(made["extensions"]["SUNDOG_material"]["glossy"], "multiscatter-ggx")
        made = self.material(alone("rough", "ShaderNodeBsdfDiffuse", Roughness=0.75))
        self.assertAlmostEqual(made["extensions"]["SUNDOG_material"]["diffuse_roughness"], 0.75)
        made = self.material(part_clear("clear", 0.25))
        self.assertEqual([round(v, 4) for v in made["extensions"]["SUNDOG_material"]["transparent_color"]], [0.2, 0.5, 0.9])
        self.assertAlmostEqual(made["pbrMetallicRoughness"]["baseColorFactor"][3], 0.75)


if __name__ == "__main__":
    unittest.main()
