# SPDX-License-Identifier: GPL-3.0-or-later
"""The arithmetic of shader nodes, all of it in one picture by Cycles."""

import math
import unittest

import bpy
import export_kit as kit
import numpy

TRIPLES = [(0.3, 0.7, 0.2), (0.9, 0.25, 0.5), (0.0, 0.4, 0.0), (1.7, 0.5, 0.1)]
COLORS = [((0.8, 0.3, 0.1, 1), (0.2, 0.6, 0.9, 1)), ((0.05, 0.5, 1.0, 1), (0.7, 0.7, 0.3, 1)), ((0.4, 0.4, 0.4, 1), (0.0, 1.0, 0.5, 1))]


class Arithmetic(kit.ExportTest):
    """Each case is a patch of its own that shines with what its nodes amount to."""

    def setUp(self):
        super().setUp()
        self.write_graphs(False)
        self.cases = []

    def case(self, label, kind, fill):
        """A patch; `fill(node, tree)` sets the node up and returns its output."""
        made = bpy.data.materials.new(label)
        made.use_nodes = True
        tree = made.node_tree
        tree.nodes.clear()
        node, glow, output = (tree.nodes.new(k) for k in (kind, "ShaderNodeEmission", "ShaderNodeOutputMaterial"))
        tree.links.new(fill(node, tree), glow.inputs["Color"])
        tree.links.new(glow.outputs[0], output.inputs["Surface"])
        mesh = kit.plane(label, 1.0)
        mesh.materials.append(made)
        number = len(self.cases)
        self.link(label, mesh, location=(number % 24 + 0.5, number // 24 + 0.5, 0))
        self.cases.append(label)

    def check(self, tolerance=2e-4):
        rows = -(-len(self.cases) // 24)
        data = self.camera.data
        data.type, data.sensor_fit, data.ortho_scale = "ORTHO", "HORIZONTAL", 24
        self.camera.location = (12, rows / 2, 10)
        self.scene.world = bpy.data.worlds.new("black")
        self.scene.world.color = (0, 0, 0)
        found = self.export()
        # The middle of each patch.
        seen = kit.cycles_pixels(24 * 3, rows * 3, 1)[1::3, 1::3].reshape(-1, 3)
        wrong = []
        # glTF's own materials have no light of less than nothing.
        self.negative = {label for label, color in zip(self.cases, seen) if color.min() < 0}
        for label, color in zip(self.cases, seen):
            material = found.material(label)
            strength = material["extensions"].get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1)
            got = numpy.array(material.get("emissiveFactor", (0, 0, 0))) * strength
            expected = numpy.maximum(color, 0)
            verdict = found.verdict("material", label)
            if verdict["verdict"] == "exact" and numpy.abs(got - expected).max() > tolerance * max(1, expected.max()):
                wrong.append(f"{label}: {got} is not {expected}")
        self.assertEqual(wrong, [])
        return found

    def exact(self, found):
        """How many cases are claimed to be exact, or shine negatively, which is told."""
        exact = {label for label in self.cases if found.verdict("material", label)["verdict"] == "exact"}
        self.assertEqual(exact & self.negative, set())
        return len(exact | self.negative)

    def test_math(self):
        operations = bpy.types.ShaderNodeMath.bl_rna.properties["operation"].enum_items.keys()
        for operation in operations:
            for number, triple in enumerate(TRIPLES):
                def fill(node, tree, operation=operation, triple=triple):
                    node.operation = operation
                    for socket, value in zip(node.inputs, triple):
                        socket.default_value = value
                    return node.outputs[0]

                self.case(f"{operation} {number}", "ShaderNodeMath", fill)
        found = self.check()
        self.assertEqual(self.exact(found), len(self.cases))

    def test_vector_math(self):
        operations = bpy.types.ShaderNodeVectorMath.bl_rna.properties["operation"].enum_items.keys()
        for operation in operations:
            def fill(node, tree, operation=operation):
                node.operation = operation
                vectors = [s for s in node.inputs if s.type == "VECTOR"]
                for socket, value in zip(vectors, ((0.5, 0.25, 1.5), (0.3, 2.0, 0.75), (0.2, 0.4, 0.6))):
                    socket.default_value = value
                for socket in node.inputs:
                    if socket.type == "VALUE":
                        socket.default_value = 0.75
                return next(s for s in node.outputs if s.enabled)

            self.case(operation, "ShaderNodeVectorMath", fill)
        found = self.check()
        self.assertGreaterEqual(self.exact(found), 12)

    def test_blends(self):
        operations = bpy.types.ShaderNodeMix.bl_rna.properties["blend_type"].enum_items.keys()
        for operation in operations:
            for number, pair in enumerate(COLORS):
                for factor in (0.35, 1.0):
                    def fill(node, tree, operation=operation, pair=pair, factor=factor):
                        node.data_type, node.blend_type = "RGBA", operation
                        node.inputs["Factor"].default_value = factor
                        for socket, value in zip([s for s in node.inputs if s.type == "RGBA"], pair):
                            socket.default_value = value
                        return next(s for s in node.outputs if s.type == "RGBA")

                    self.case(f"{operation} {number} {factor}", "ShaderNodeMix", fill)
        found = self.check()
        self.assertGreaterEqual(self.exact(found), 13 * 6)

    def test_colours(self):
        def name_of(node, *names):
            return next(node.inputs[n] for n in names if n in node.inputs)

        for number, (first, second) in enumerate(COLORS):
            def invert(node, tree, first=first):
                node.inputs["Color"].default_value = first
                node.inputs[0].default_value = 0.6
                return node.outputs[0]

            def gamma(node, tree, first=first):
                node.inputs["Color"].default_value, node.inputs["Gamma"].default_value = first, 2.2
                return node.outputs[0]

            def bright(node, tree, first=first):
                node.inputs["Color"].default_value = first
                name_of(node, "Bright", "Brightness").default_value = 0.1
                node.inputs["Contrast"].default_value = 0.4
                return node.outputs[0]

            def hue(node, tree, first=first):
                node.inputs["Color"].default_value = first
                node.inputs["Hue"].default_value, node.inputs["Saturation"].default_value = 0.6, 1.3
                node.inputs["Value"].default_value = 0.8
                return node.outputs[0]

            def curves(node, tree, first=first):
                node.inputs["Color"].default_value = first
                node.mapping.curves[0].points.new(0.4, 0.7)
                node.mapping.curves[3].points.new(0.5, 0.3)
                node.mapping.update()
                return node.outputs[0]

            def grey(node, tree, first=first):
                node.inputs[0].default_value = first
                return node.outputs[0]

            self.case(f"invert {number}", "ShaderNodeInvert", invert)
            self.case(f"gamma {number}", "ShaderNodeGamma", gamma)
            self.case(f"bright {number}", "ShaderNodeBrightContrast", bright)
            self.case(f"hue {number}", "ShaderNodeHueSaturation", hue)
            self.case(f"curves {number}", "ShaderNodeRGBCurve", curves)
            self.case(f"grey {number}", "ShaderNodeRGBToBW", grey)
            for mode in ("RGB", "HSV", "HSL"):
                for channel in range(3):
                    def separate(node, tree, first=first, mode=mode, channel=channel):
                        node.mode = mode
                        node.inputs[0].default_value = first
                        return node.outputs[channel]

                    self.case(f"separate {mode} {channel} {number}", "ShaderNodeSeparateColor", separate)

                def combine(node, tree, first=first, mode=mode):
                    node.mode = mode
                    for socket, value in zip(node.inputs, first):
                        socket.default_value = value
                    return node.outputs[0]

                self.case(f"combine {mode} {number}", "ShaderNodeCombineColor", combine)
        for kelvin in (1500, 3000, 6500, 11000):
            def body(node, tree, kelvin=kelvin):
                node.inputs[0].default_value = kelvin
                return node.outputs[0]

            self.case(f"blackbody {kelvin}", "ShaderNodeBlackbody", body)
        found = self.check(2e-3)
        self.assertGreater(self.exact(found), 40)

    def test_ranges(self):
        for value in (-0.2, 0.1, 0.45, 0.9, 1.4):
            for interpolation in ("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"):
                for clamp in (True, False):
                    def fill(node, tree, value=value, interpolation=interpolation, clamp=clamp):
                        node.interpolation_type, node.clamp = interpolation, clamp
                        for socket, number in zip(node.inputs, (value, 0.2, 0.8, 0.1, 2.0)):
                            socket.default_value = number
                        return node.outputs[0]

                    self.case(f"range {value} {interpolation} {clamp}", "ShaderNodeMapRange", fill)
            for kind in ("MINMAX", "RANGE"):
                def clamp_node(node, tree, value=value, kind=kind):
                    node.clamp_type = kind
                    for socket, number in zip(node.inputs, (value, 0.7, 0.3)):
                        socket.default_value = number
                    return node.outputs[0]

                self.case(f"clamp {value} {kind}", "ShaderNodeClamp", clamp_node)
            for interpolation in ("LINEAR", "CONSTANT", "EASE", "CARDINAL", "B_SPLINE"):
                def ramp(node, tree, value=value, interpolation=interpolation):
                    node.color_ramp.interpolation = interpolation
                    node.color_ramp.elements[0].color, node.color_ramp.elements[1].color = (1, 0.2, 0, 1), (0, 0.5, 1, 1)
                    node.color_ramp.elements.new(0.4).color = (0.9, 0.9, 0.1, 1)
                    node.inputs[0].default_value = value
                    return node.outputs[0]

                self.case(f"ramp {value} {interpolation}", "ShaderNodeValToRGB", ramp)
        # Cycles keeps a ramp in 256 steps: at most one of them beside.
        self.check(2e-2)

    def test_samples_of_what_varies_are_finite(self):
        for operation in ("LOGARITHM", "INVERSE_SQRT", "DIVIDE", "POWER", "TANGENT"):
            def fill(node, tree, operation=operation):
                node.operation = operation
                noise = tree.nodes.new("ShaderNodeTexNoise")
                tree.links.new(noise.outputs[0], node.inputs[0])
                return node.outputs[0]

            self.case(operation, "ShaderNodeMath", fill)
        found = self.export()
        for label in self.cases:
            self.assertEqual(found.verdict("material", label)["verdict"], "approximated")
            self.assertTrue(all(math.isfinite(v) for v in found.material(label).get("emissiveFactor", (0, 0, 0))))


if __name__ == "__main__":
    unittest.main()
