# SPDX-License-Identifier: GPL-3.0-or-later
"""What arrives at the end of links beside Cycles: muted nodes, reroutes, and groups whose sockets are of other types."""

import unittest

import bpy
import export_kit as kit
import numpy

# Values of groups' sockets.
OWN = {"Float": 0.37, "Int": 3, "Bool": True, "Vector": (0.2, 0.5, 0.9), "Color": (0.2, 0.5, 0.9, 0.4)}


class Links(kit.ExportTest):
    """A plane that glows by what arrives, by both programs."""

    def setUp(self):
        super().setUp()
        self.write_graphs(True)
        kit.unbiased(self.scene.cycles)
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 1

    def begin(self):
        """A new material: its tree."""
        for made in (*bpy.data.objects, *bpy.data.materials, *bpy.data.node_groups):
            if made != self.camera:
                bpy.data.batch_remove([made])
        self.material = bpy.data.materials.new("glow")
        self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        mesh = kit.plane("plane", 4)
        mesh.materials.append(self.material)
        self.link("plane", mesh)
        return self.tree

    def new(self, kind, tree=None, mute=False, **inputs):
        """A node whose inputs have these values, by their numbers (_0)."""
        node = (tree or self.tree).nodes.new(kind)
        node.mute = mute
        for name, value in inputs.items():
            node.inputs[int(name[1:])].default_value = value
        return node

    def group(self, of, to, fill=None):
        """The node of a group with one input and one output of these types, which are linked unless it is filled otherwise."""
        inner = bpy.data.node_groups.new("inner", "ShaderNodeTree")
        inner.interface.new_socket("In", in_out="INPUT", socket_type=f"NodeSocket{of}").default_value = OWN[of]
        inner.interface.new_socket("Out", in_out="OUTPUT", socket_type=f"NodeSocket{to}")
        entry, leaving = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput")
        if fill:
            fill(inner, entry, leaving)
        else:
            inner.links.new(entry.outputs[0], leaving.inputs[0])
        use = self.tree.nodes.new("ShaderNodeGroup")
        use.node_tree = inner
        return use

    def compare(self, words, output, error=0.01):
        """Both pictures of what an output shines are alike, for all that places in pixels differ; the verdict is exact."""
        glow, end = self.new("ShaderNodeEmission"), self.new("ShaderNodeOutputMaterial")
        glow.inputs["Color"].default_value = (0.7, 0.6, 0.5, 1)
        self.tree.links.new(output, glow.inputs["Color"])
        self.tree.links.new(glow.outputs[0], end.inputs["Surface"])
        shown = kit.cycles_pixels(8, 8, 4)
        found = self.export()
        ours = kit.rendered(found.path, 8, 8, 4)
        differs = float(numpy.abs(ours - shown).max())
        print(f"{words}: {ours[4, 4]} Cycles {shown[4, 4]}", flush=True)
        self.assertLessEqual(differs, error, words)
        self.assertEqual(found.verdict("material", "glow")["verdict"], "exact", words)

    def test_muted_nodes_that_nothing_feeds(self):
        """From 5.0 on what asks takes its own value, before it gets zero."""
        def plain():
            return self.new("ShaderNodeMath", mute=True, _0=0.3).outputs[0]

        def reroute():
            passing = self.new("NodeReroute")
            self.tree.links.new(plain(), passing.inputs[0])
            return passing.outputs[0]

        def twice():
            node = self.new("ShaderNodeMath", mute=True, _0=0.6)
            self.tree.links.new(plain(), node.inputs[0])
            return node.outputs[0]

        def in_a_group():
            def fill(inner, _, leaving):
                inner.links.new(self.new("ShaderNodeMath", inner, True, _0=0.3).outputs[0], leaving.inputs[0])
                leaving.inputs[0].default_value = 0.8

            return self.group("Float", "Float", fill).outputs[0]

        def into_a_group():
            use = self.group("Float", "Float")
            self.tree.links.new(plain(), use.inputs[0])
            return use.outputs[0]

        def coordinates():
            noise, muted = self.new("ShaderNodeTexGradient"), self.new("ShaderNodeVectorCurve", mute=True)
            self.tree.links.new(muted.outputs[0], noise.inputs["Vector"])
            return noise.outputs[0]

        def muted_group():
            use = self.group("Float", "Float")
            use.mute = True
            return use.outputs[0]

        for made in (plain, reroute, twice, in_a_group, into_a_group, coordinates, muted_group):
            with self.subTest(made=made.__name__):
                self.begin()
                self.compare(made.__name__, made())

    def test_values_of_groups_that_shine(self):
        """What nothing feeds in a group shines by its socket's value, as surface and as what fills. (Both were black.)"""
        def value(inner, _, leaving):
            leaving.inputs[0].default_value = OWN[of]

        for of in OWN:
            for socket in ("Surface", "Volume"):
                with self.subTest(of=of, socket=socket):
                    self.begin()
                    end = self.new("ShaderNodeOutputMaterial")
                    self.tree.links.new(self.group(of, of, value).outputs[0], end.inputs[socket])
                    if socket == "Volume":
                        bpy.data.objects["plane"].data = kit.cube("cube", 4)
                        bpy.data.objects["plane"].data.materials.append(self.material)
                    shown = kit.cycles_pixels(8, 8, 4)
                    found = self.export()
                    ours = kit.rendered(found.path, 8, 8, 4)
                    print(f"{of} {socket}: {ours[4, 4]} Cycles {shown[4, 4]}", flush=True)
                    self.assertGreater(shown.max(), 0.1)
                    numpy.testing.assert_allclose(ours, shown, rtol=0.01)
                    self.assertEqual(found.verdict("material", "glow")["verdict"], "exact")

    def test_curves_of_known_colours_beyond_their_ends(self):
        """RGB Curves go on in a straight line where they are told to. (They ended at 1 and 0: half of the light of a black body.)"""
        for extend in ("EXTRAPOLATED", "HORIZONTAL"):
            for bend in (None, 0.6):
                with self.subTest(extend=extend, bend=bend):
                    self.begin()
                    curves = self.new("ShaderNodeRGBCurve")
                    curves.mapping.extend = extend
                    for curve in curves.mapping.curves if bend else ():
                        curve.points.new(0.5, bend)
                    curves.mapping.update()
                    self.tree.links.new(self.new("ShaderNodeCombineXYZ", _0=1.8, _1=0.5, _2=-0.4).outputs[0], curves.inputs["Color"])
                    self.compare(f"curves {extend} {bend}", curves.outputs[0])

    def test_muted_nodes_of_another_type(self):
        """Before 5.0 the type of the output alone converts."""
        for kind, number in (("ValToRGB", 0), ("SeparateXYZ", 0), ("FloatCurve", 1), ("Blackbody", 0)):
            for source in ("ShaderNodeTexNoise", "ShaderNodeRGB"):
                with self.subTest(kind=kind, source=source):
                    self.begin()
                    muted = self.new(f"ShaderNode{kind}", mute=True)
                    node = self.new(source)
                    color = node.outputs["Color"]
                    if source == "ShaderNodeRGB":
                        color.default_value = (0.3, 0.6, 0.8, 0.5)
                    else:
                        node.inputs["Scale"].default_value = 0.5
                    self.tree.links.new(color, muted.inputs[number])
                    self.compare(f"{kind} {source}", muted.outputs[0])

    def test_types_of_groups(self):
        """Values that a group has, is given by a node, or takes from what varies."""
        for of in OWN:
            for to in OWN:
                for source in ("own", "Value", "CombineXYZ", "varying"):
                    with self.subTest(of=of, to=to, source=source):
                        self.begin()
                        use = self.group(of, to)
                        if source == "Value":
                            node = self.new("ShaderNodeValue")
                            node.outputs[0].default_value = 1.7
                            self.tree.links.new(node.outputs[0], use.inputs[0])
                        elif source == "CombineXYZ":
                            self.tree.links.new(self.new("ShaderNodeCombineXYZ", _0=0.4, _1=0.1, _2=2.9).outputs[0], use.inputs[0])
                        elif source == "varying":
                            # No step of whole numbers is within the picture.
                            node = self.new("ShaderNodeVectorMath", _1=(2.6, 2.7, 2.8))
                            self.tree.links.new(self.new("ShaderNodeTexGradient").outputs["Color"], node.inputs[0])
                            self.tree.links.new(node.outputs[0], use.inputs[0])
                        self.compare(f"{of} {to} {source}", use.outputs[0])

    def shows(self, output, value=(0.2, 0.5, 0.8)):
        """An emission of that colour, at an output."""
        glow = self.new("ShaderNodeEmission", output.id_data)
        glow.inputs["Color"].default_value = (*value, 1)
        output.id_data.links.new(glow.outputs[0], output.inputs["Surface"])

    def pictures(self):
        """What is exported, and the pixel in the middle of both pictures."""
        shown = kit.cycles_pixels(8, 8, 4)
        found = self.export()
        ours = kit.rendered(found.path, 8, 8, 4)
        print(f"{ours[4, 4]} Cycles {shown[4, 4]}", flush=True)
        return found, ours[4, 4], shown[4, 4]

    def test_muted_outputs(self):
        """Before 5.0 such are none, and nothing is black."""
        self.begin()
        end = self.new("ShaderNodeOutputMaterial")
        self.shows(end)
        end.mute = True
        _, ours, shown = self.pictures()
        self.near(ours, shown, 1e-4)

    def test_outputs_in_groups(self):
        """One counts where there is no other; before 5.0 it is told that it is not rendered."""
        self.begin()
        inner = bpy.data.node_groups.new("inner", "ShaderNodeTree")
        self.shows(inner.nodes.new("ShaderNodeOutputMaterial"))
        self.new("ShaderNodeGroup").node_tree = inner
        found, ours, shown = self.pictures()
        if bpy.app.version < (5, 0, 0):
            self.assertEqual(found.verdict("material", "glow")["verdict"], "lost")
            return
        self.near(shown, numpy.array((0.2, 0.5, 0.8)), 1e-4)
        self.near(ours, shown, 1e-4)

    def test_slots_of_objects_without_a_material(self):
        """From 5.1 on such a slot is grey, before it has the mesh's material."""
        self.begin()
        self.shows(self.new("ShaderNodeOutputMaterial"))
        thing = bpy.data.objects["plane"]
        thing.material_slots[0].link = "OBJECT"
        thing.material_slots[0].material = None
        _, ours, shown = self.pictures()
        self.near(ours, shown, 0.02)


if __name__ == "__main__":
    unittest.main()
