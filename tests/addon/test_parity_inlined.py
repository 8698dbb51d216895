# SPDX-License-Identifier: GPL-3.0-or-later
"""Trees with what Blender alone resolves before Cycles reads them: constants, menus, repeated zones, closures, bundles, circles."""

import unittest

import bpy
import export_kit as kit
import numpy


def has(kind):
    """Whether this Blender's shaders have a node."""
    tree = bpy.data.materials.new("scratch").node_tree
    try:
        tree.nodes.new(kind)
    except RuntimeError:
        return False
    return True


@unittest.skipUnless(bpy.app.version >= (5, 0, 0), "Blender resolves trees from 5.0 on")
class Inlined(kit.ExportTest):
    """A plane that glows by such a tree, by both programs."""

    def setUp(self):
        super().setUp()
        self.write_graphs(True)
        kit.unbiased(self.scene.cycles)
        material = bpy.data.materials.new("glow")
        self.tree = material.node_tree
        self.tree.nodes.clear()
        self.glow = self.new("ShaderNodeEmission")
        self.link_to(self.glow.outputs[0], self.new("ShaderNodeOutputMaterial").inputs["Surface"])
        mesh = kit.plane("plane", 8)
        mesh.materials.append(material)
        self.link("plane", mesh)
        self.camera.location, self.camera.rotation_euler = (0, 0, 2), (0, 0, 0)

    def new(self, kind, tree=None, **properties):
        if not has(kind):
            self.skipTest(f"this Blender's shaders have no {kind}")
        node = (tree or self.tree).nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        return node

    def link_to(self, output, socket):
        output.id_data.links.new(output, socket)

    def noise(self, tree=None):
        return self.new("ShaderNodeTexNoise", tree).outputs[0]

    def compare(self, least=0.1):
        """The picture is as in Cycles, not black, and the verdict exact."""
        cycles = kit.cycles_pixels(16, 16, 64)
        found = self.export()
        ours = kit.rendered(found.path, 16, 16, 64)
        self.assertEqual(found.verdict("material", "glow")["verdict"], "exact", found.verdict("material", "glow"))
        self.assertGreaterEqual(float(cycles.max()), least)
        self.near(ours, cycles, 0.02)
        return cycles

    def test_constants(self):
        for kind, properties, expected in (
            ("FunctionNodeInputVector", {"vector": (0.2, 0.5, 0.8)}, (0.2, 0.5, 0.8)),
            ("FunctionNodeInputInt", {"integer": 3}, (3, 3, 3)),
            ("FunctionNodeInputBool", {"boolean": True}, (1, 1, 1)),
        ):
            with self.subTest(kind=kind):
                node = self.new(kind, **properties)
                self.link_to(node.outputs[0], self.glow.inputs["Color"])
                self.near(self.compare()[8, 8], numpy.array(expected), 1e-5)

    def test_menus_of_groups(self):
        """A group whose menu chooses between a pattern and a number, used with either."""
        if not has("GeometryNodeMenuSwitch"):
            self.skipTest("no menus")
        inner = bpy.data.node_groups.new("inner", "ShaderNodeTree")
        inner.interface.new_socket("Which", in_out="INPUT", socket_type="NodeSocketMenu")
        inner.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketFloat")
        switch = self.new("GeometryNodeMenuSwitch", inner, data_type="FLOAT")
        self.link_to(inner.nodes.new("NodeGroupInput").outputs[0], switch.inputs[0])
        self.link_to(self.noise(inner), switch.inputs[1])
        switch.inputs[2].default_value = 0.7
        self.link_to(switch.outputs[0], inner.nodes.new("NodeGroupOutput").inputs[0])
        use = self.new("ShaderNodeGroup")
        use.node_tree = inner
        self.link_to(use.outputs[0], self.glow.inputs["Color"])
        for name in [item.name for item in switch.enum_items]:
            with self.subTest(name=name):
                use.inputs[0].default_value = name
                self.compare()

    def test_repeated_zones(self):
        """A noise that is halved three times, and added to itself."""
        first, last = self.new("GeometryNodeRepeatInput"), self.new("GeometryNodeRepeatOutput")
        first.pair_with_output(last)
        last.repeat_items.clear()
        last.repeat_items.new("FLOAT", "Sum")
        first.inputs["Iterations"].default_value = 3
        add = self.new("ShaderNodeMath", operation="MULTIPLY_ADD")
        self.link_to(self.noise(), first.inputs["Sum"])
        self.link_to(first.outputs["Sum"], add.inputs[0])
        add.inputs[1].default_value, add.inputs[2].default_value = 0.5, 0.1
        self.link_to(add.outputs[0], last.inputs["Sum"])
        self.link_to(last.outputs["Sum"], self.glow.inputs["Color"])
        self.compare()

    def test_closures(self):
        """A closure that multiplies what it is given, evaluated with a pattern."""
        first, last = self.new("NodeClosureInput"), self.new("NodeClosureOutput")
        first.pair_with_output(last)
        last.input_items.new("FLOAT", "x")
        last.output_items.new("FLOAT", "y")
        double = self.new("ShaderNodeMath", operation="MULTIPLY")
        double.inputs[1].default_value = 2.0
        self.link_to(first.outputs["x"], double.inputs[0])
        self.link_to(double.outputs[0], last.inputs["y"])
        use = self.new("NodeEvaluateClosure")
        use.input_items.new("FLOAT", "x")
        use.output_items.new("FLOAT", "y")
        self.link_to(last.outputs[0], use.inputs[0])
        self.link_to(self.noise(), use.inputs["x"])
        self.link_to(use.outputs["y"], self.glow.inputs["Color"])
        self.compare()

    def test_bundles(self):
        """A pattern and a colour that go one way together."""
        pack, unpack = self.new("NodeCombineBundle"), self.new("NodeSeparateBundle")
        for node in (pack, unpack):
            node.bundle_items.new("FLOAT", "strength")
            node.bundle_items.new("RGBA", "color")
        self.link_to(self.noise(), pack.inputs["strength"])
        pack.inputs["color"].default_value = (0.9, 0.5, 0.1, 1)
        self.link_to(pack.outputs[0], unpack.inputs[0])
        self.link_to(unpack.outputs["strength"], self.glow.inputs["Strength"])
        self.link_to(unpack.outputs["color"], self.glow.inputs["Color"])
        self.compare()

    def test_circles(self):
        """Materials with circles of links are black."""
        first, second = (self.new("ShaderNodeMath", operation="ADD") for _ in range(2))
        self.link_to(first.outputs[0], second.inputs[0])
        self.link_to(second.outputs[0], first.inputs[0])
        mix = self.new("ShaderNodeMath", operation="ADD")
        self.link_to(first.outputs[0], mix.inputs[0])
        self.link_to(self.noise(), mix.inputs[1])
        self.link_to(mix.outputs[0], self.glow.inputs["Color"])
        self.assertEqual(float(self.compare(least=0).max()), 0)

    def test_worlds_and_lamps(self):
        """Their trees, too."""
        if not has("FunctionNodeInputVector"):
            self.skipTest("no node for a vector")
        world = self.scene.world = bpy.data.worlds.new("sky")
        lamp = bpy.data.lights.new("lamp", "POINT")
        lamp.use_nodes, lamp.energy = True, 300
        self.link("lamp", lamp, location=(1, 1, 2))
        for owner, kind, color in ((world, "BACKGROUND", (0.1, 0.3, 0.6)), (lamp, "EMISSION", (0.9, 0.5, 0.2))):
            shader = next(n for n in owner.node_tree.nodes if n.type == kind)
            vector = self.new("FunctionNodeInputVector", owner.node_tree, vector=color)
            self.link_to(vector.outputs[0], shader.inputs["Color"])
        tree = self.tree
        diffuse = self.new("ShaderNodeBsdfDiffuse")
        self.link_to(diffuse.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"])
        self.compare()


if __name__ == "__main__":
    unittest.main()


class Outputs(kit.ExportTest):
    """Trees with outputs of several kinds, as old files have them."""

    COLORS = {"Light": (1, 0, 0), "Material": (0, 1, 0), "World": (0, 0, 1)}

    def fill(self, owner, kinds):
        """Another colour by each output."""
        owner.use_nodes = True
        tree = owner.node_tree
        tree.nodes.clear()
        for kind in kinds:
            glow, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new(f"ShaderNodeOutput{kind}")
            glow.inputs["Color"].default_value = (*self.COLORS[kind], 1)
            tree.links.new(glow.outputs[0], output.inputs["Surface"])

    def test_the_output_of_the_trees_own_kind_is_rendered(self):
        """Blender's own function says the first of all, which Cycles went by before 5.0."""
        self.write_graphs(True)
        kit.unbiased(self.scene.cycles)
        kit.even_world(self.scene, 1)
        mesh, floor = kit.plane("plane", 2), kit.plane("floor", 2)
        mesh.materials.append(bpy.data.materials.new("glow"))
        floor.materials.append(kit.material("floor", Base_Color=(0.8, 0.8, 0.8, 1), Roughness=1))
        self.link("plane", mesh, location=(-1, 0, 0))
        self.link("floor", floor, location=(1, 0, 0))
        lamp = bpy.data.lights.new("lamp", "SUN")
        self.link("lamp", lamp)
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 6
        self.camera.location, self.camera.rotation_euler = (0, 0, 2), (0, 0, 0)
        for material, world, light in (
            (("Light", "Material"), ("Light", "World"), ("Material", "Light")),
            (("World", "Light"), ("World", "Material"), ("Light",)),
            (("World",), ("Light",), ("World", "Material")),
        ):
            with self.subTest(material=material, world=world, light=light):
                for owner, kinds in ((mesh.materials[0], material), (self.scene.world, world), (lamp, light)):
                    self.fill(owner, kinds)
                cycles = kit.cycles_pixels(24, 24, 64)
                ours = kit.rendered(self.export().path, 24, 24, 64)
                # The material, the floor and the world, away from edges.
                for part in (numpy.s_[10:14, 6:10], numpy.s_[10:14, 14:18], numpy.s_[1:4, 1:23]):
                    self.near(ours[part].mean((0, 1)), cycles[part].mean((0, 1)), 0.02)
