# SPDX-License-Identifier: GPL-3.0-or-later
"""Every input and every setting of Blender's surface shaders counts, or the verdict says that it does not: in Blenders to come, too."""

import json
import unittest

import bpy
import export_kit as kit
import numpy

# What counts only where another input is not zero: beginnings of names, and that input.
NEEDS = {
    "Subsurface": "Subsurface Weight",
    "subsurface": "Subsurface Weight",
    "Coat": "Coat Weight",
    "Sheen": "Sheen Weight",
    "Thin Film IOR": "Thin Film Thickness",
    "Anisotropic Rotation": "Anisotropic",
    "Rotation": "Anisotropy",
    # As the Principled BSDF calls it, and as others do.
    "Tangent": ("Anisotropic", "Anisotropy"),
    "Emission Color": "Emission Strength",
    "Thin Wall": "Transmission Weight",
    "Transmission Dispersion": "Transmission Dispersion Scale",
}
# Sockets and settings that no picture by Cycles depends on.
WITHOUT_EFFECT = {"Weight"}


def other_value(value):
    """Another value of the same kind."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + 1
    if isinstance(value, float):
        return 0.37 if value != 0.37 else 0.61
    return [0.3, 0.6, 0.2, 1.0][: len(value)]


class Sockets(kit.ExportTest):
    """Two materials for each: one as it is, one with the input changed."""

    def setUp(self):
        super().setUp()
        self.pairs = []

    def shader(self, kind):
        made = bpy.data.materials.new(f"m{len(bpy.data.materials)}")
        made.use_nodes = True
        tree = made.node_tree
        tree.nodes.clear()
        node, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(node.outputs[0], output.inputs["Surface"])
        # Rough, so that it matters how light scatters between the facets.
        if "Roughness" in node.inputs:
            node.inputs["Roughness"].default_value = 0.8
        mesh = kit.plane(made.name)
        mesh.materials.append(made)
        self.link(made.name, mesh)
        return made, tree, node

    def pair(self, label, kind, change):
        plain, _, first = self.shader(kind)
        changed, tree, second = self.shader(kind)
        for beginning, names in NEEDS.items():
            for needed in [names] if isinstance(names, str) else names:
                if label.startswith(beginning) and label != needed and needed in first.inputs:
                    first.inputs[needed].default_value = second.inputs[needed].default_value = 0.4
        change(second, tree)
        self.pairs.append((f"{kind}: {label}", plain.name, changed.name))

    def change_socket(self, identifier):
        def change(node, tree):
            socket = next(s for s in node.inputs if s.identifier == identifier)
            if not socket.hide_value:
                socket.default_value = other_value(socket.default_value)
                return
            bump, noise = tree.nodes.new("ShaderNodeBump"), tree.nodes.new("ShaderNodeTexNoise")
            tree.links.new(noise.outputs[0], bump.inputs["Height"])
            tree.links.new(bump.outputs[0], socket)

        return change

    def add_pairs(self, kind):
        made, _, node = self.shader(kind)
        for socket in node.inputs:
            if socket.enabled and socket.type in {"VALUE", "RGBA", "VECTOR", "BOOLEAN", "INT"} and socket.name not in WITHOUT_EFFECT:
                self.pair(socket.name, kind, self.change_socket(socket.identifier))
        common = {p.identifier for p in bpy.types.ShaderNode.bl_rna.properties}
        for setting in node.bl_rna.properties:
            if setting.identifier in common or setting.is_readonly:
                continue
            if setting.type == "ENUM" and not setting.is_enum_flag:
                for item in setting.enum_items:
                    if item.identifier != getattr(node, setting.identifier):
                        change = lambda n, _, s=setting.identifier, v=item.identifier: setattr(n, s, v)
                        self.pair(f"{setting.identifier} {item.identifier}", kind, change)
            elif setting.type == "BOOLEAN" and not setting.is_array:
                change = lambda n, _, s=setting.identifier: setattr(n, s, not getattr(n, s))
                self.pair(setting.identifier, kind, change)

    def test_none_of_a_surface_shader_is_left_out_silently(self):
        shaders = [n for n in dir(bpy.types) if n.startswith("ShaderNodeBsdf")]
        for kind in [*shaders, "ShaderNodeEmission", "ShaderNodeSubsurfaceScattering"]:
            self.add_pairs(kind)
        # Blender 4.2's shaders have fewer sockets: 97 pairs; 4.5's have 108.
        self.assertGreater(len(self.pairs), 100 if bpy.app.version >= (4, 5) else 96)
        found = self.export()

        def shown(name):
            (primitive,) = found["meshes"][found.node(name)["mesh"]]["primitives"]
            material = {k: v for k, v in found["materials"][primitive["material"]].items() if k != "name"}
            return json.dumps(material, sort_keys=True), found.verdict("material", name)

        silent = []
        for label, plain, changed in self.pairs:
            before, after = shown(plain), shown(changed)
            same = before[0] == after[0] and before[1]["detail"] == after[1]["detail"]
            if same and after[1]["verdict"] == "exact":
                silent.append(label)
        self.assertEqual(silent, [])


class Newer(kit.ExportTest):
    """What Blender 5.0, 5.1 and 5.2 added to materials."""

    def exported(self, name):
        mesh = kit.plane()
        mesh.materials.append(bpy.data.materials[name])
        self.link("plane", mesh)
        return self.export()

    def alone(self, kind):
        made = bpy.data.materials.new("m")
        made.use_nodes = True
        tree = made.node_tree
        tree.nodes.clear()
        node, output = tree.nodes.new(kind), tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(node.outputs[0], output.inputs["Surface"])
        return node

    def test_thin_film_of_glass_and_metal(self):
        for kind in ("ShaderNodeBsdfGlass", "ShaderNodeBsdfMetallic"):
            self.setUp()
            node = self.alone(kind)
            if "Thin Film Thickness" not in node.inputs:
                self.skipTest("they have it from Blender 5.0 on")
            node.inputs["Thin Film Thickness"].default_value = 300
            found = self.exported("m")
            self.assertEqual(found.verdict("material", "m")["verdict"], "exact")
            self.assertEqual(found.material("m")["extensions"]["SUNDOG_material"]["thin_film"]["thickness"], 300)

    def wall(self, **inputs):
        made = kit.material("m", **inputs)
        node = next(n for n in made.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
        if "Thin Wall" not in node.inputs:
            self.skipTest("Principled has it from Blender 5.2 on")
        node.inputs["Thin Wall"].default_value = True
        return self.exported("m")

    def test_a_thin_wall_is_a_sheet(self):
        found = self.wall(Base_Color=(0.8, 0.6, 0.4, 1), Transmission_Weight=1, Roughness=0)
        self.assertEqual(found.verdict("material", "m")["verdict"], "exact")
        self.assertIs(found.material("m")["extensions"]["SUNDOG_material"]["thin_walled"], True)
        # What is behind is seen in its place and colour; a solid would bend it, and tint it by the root of that.
        behind = kit.plane("behind", 1.0)
        behind.materials.append(bpy.data.materials.new("light"))
        bpy.data.materials["light"].use_nodes = True
        tree = bpy.data.materials["light"].node_tree
        tree.nodes.clear()
        glow, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(glow.outputs[0], output.inputs[0])
        self.link("behind", behind, location=(0, 0, -2))
        self.scene.world = bpy.data.worlds.new("black")
        self.scene.world.color = (0, 0, 0)
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 0.5
        theirs = kit.cycles_pixels(4, 4, 64).mean(axis=(0, 1))
        ours = kit.rendered(self.export().path, 4, 4, 64).mean(axis=(0, 1))
        self.near(ours, theirs, 0.01)

    def test_a_thin_wall_that_lets_nothing_through_is_exact(self):
        found = self.wall(Base_Color=(0.8, 0.6, 0.4, 1))
        self.assertEqual(found.verdict("material", "m")["verdict"], "exact")

    def test_normals_in_the_other_convention(self):
        pixels = numpy.random.default_rng(1).random((4, 4, 4)).astype(numpy.float32)
        textures = []
        for convention in ("OPENGL", "DIRECTX"):
            self.setUp()
            made = kit.material("m")
            tree = made.node_tree
            image = bpy.data.images.new("normals", 4, 4)
            image.colorspace_settings.name = "Non-Color"
            turned = pixels.copy()
            if convention == "DIRECTX":
                turned[..., 1] = 1 - turned[..., 1]
            image.pixels.foreach_set(turned.ravel())
            image.update()
            texture, node = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeNormalMap")
            if not hasattr(node, "convention"):
                self.skipTest("Normal Map has it from Blender 5.1 on")
            texture.image, node.convention = image, convention
            tree.links.new(texture.outputs["Color"], node.inputs["Color"])
            principled = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
            tree.links.new(node.outputs["Normal"], principled.inputs["Normal"])
            found = self.exported("m")
            source = found["textures"][found.material("m")["normalTexture"]["index"]]["source"]
            baked = bpy.data.images.load(found.path.rpartition("/")[0] + "/" + found["images"][source]["uri"])
            baked.colorspace_settings.name = "Non-Color"
            textures.append(numpy.array(baked.pixels[:]).reshape(4, 4, -1)[..., :3])
        # Eight bits, each rounded for itself.
        self.assertLessEqual(float(numpy.abs(textures[0] - textures[1]).max()), 1.01 / 255)

    def test_a_packed_image_of_floats_is_read(self):
        made = kit.material("m")
        tree = made.node_tree
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = bpy.data.images.new("floats", 8, 8, float_buffer=True)
        texture.image.pixels.foreach_set(numpy.linspace(0, 1, 256, dtype=numpy.float32))
        texture.image.update()
        texture.image.pack()
        self.assertIsNotNone(texture.image.packed_file)
        principled = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
        tree.links.new(texture.outputs["Color"], principled.inputs["Base Color"])
        # Blender 5.2 packs files that do not say where their lines are.
        kit.rendered(self.exported("m").path, 4, 4, 1)


if __name__ == "__main__":
    unittest.main()
