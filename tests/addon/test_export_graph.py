# SPDX-License-Identifier: GPL-3.0-or-later
"""SUNDOG_shader_graph: what is written of node trees, when it is, and what it asks of meshes and objects."""

import os
import time
import unittest

import bpy
import export_kit as kit
import numpy
from sundog.export import evaluated, graph, nodes


class GraphTest(kit.ExportTest):
    """A test with materials on planes, whose graphs are written."""

    def setUp(self):
        super().setUp()
        self.write_graphs(True)

    def tree(self, name="m", mesh=None):
        """An emission on a plane of that name: (tree, emission)."""
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        tree = made.node_tree
        tree.nodes.clear()
        glow, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(glow.outputs[0], output.inputs["Surface"])
        mesh = mesh or kit.plane(name)
        mesh.materials.append(made)
        self.link(name, mesh)
        return tree, glow

    def graph_of(self, found, name="m"):
        """The graph of a material, of which the verdict is exact unless told otherwise."""
        return found.material(name)["extensions"].get("SUNDOG_shader_graph")

    def only(self, found, kind, name="m"):
        """The one node of that type."""
        (node,) = [n for n in self.graph_of(found, name)["nodes"] if n["type"] == kind]
        return node

    def varying(self, tree, output="Color"):
        """An output that no glTF can carry without a graph."""
        return tree.nodes.new("ShaderNodeTexNoise").outputs[output]


class Structure(GraphTest):
    """Nodes and links."""

    def test_stand_ins_are_small(self):
        """A texture that is made for a flattened material is small where its node tree stands beside it."""
        for trees, varies, side in ((True, True, 1024), (True, False, 1024), (False, True, 2048)):
            with self.subTest(trees=trees, varies=varies):
                graph.ENABLED = trees
                for made in list(bpy.data.materials):
                    bpy.data.materials.remove(made)
                tree, glow = self.tree()
                image, gamma = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeGamma")
                image.image = bpy.data.images.new("wide", 2048, 8)
                gamma.inputs["Gamma"].default_value = 1.5
                tree.links.new(image.outputs["Color"], gamma.inputs["Color"])
                tree.links.new(gamma.outputs["Color"], glow.inputs["Color"])
                if varies:
                    tree.links.new(self.varying(tree), glow.inputs["Strength"])
                found = self.export()
                texture = found.material("m")["emissiveTexture"]["index"]
                uri = found["images"][found["textures"][texture]["source"]]["uri"]
                baked = bpy.data.images.load(os.path.join(os.path.dirname(found.path), uri))
                self.assertEqual(baked.size[0], side)

    def test_a_tree_is_written_as_it_is(self):
        tree, glow = self.tree()
        where, noise = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeTexNoise")
        tree.nodes.new("ShaderNodeTexVoronoi")
        noise.noise_dimensions, noise.normalize = "4D", False
        noise.inputs["Scale"].default_value, noise.inputs["W"].default_value = 7.5, 0.1
        tree.links.new(where.outputs["Object"], noise.inputs["Vector"])
        tree.links.new(noise.outputs["Color"], glow.inputs["Color"])
        found = self.export()
        written = self.graph_of(found)
        self.assertEqual(written["blender"], list(bpy.app.version))
        self.assertEqual([n["type"] for n in written["nodes"]], ["ShaderNodeTexCoord", "ShaderNodeTexNoise", "ShaderNodeEmission"])
        self.assertEqual(written["surface"], {"node": 2, "output": "Emission"})
        node = written["nodes"][1]
        self.assertEqual(node["name"], "Noise Texture")
        self.assertEqual(node["properties"], {"noise_dimensions": "4D", "noise_type": "FBM", "normalize": False})
        expected = {"Vector": {"node": 0, "output": "Object"}, "W": 0.1, "Scale": 7.5, "Detail": 2, "Roughness": 0.5, "Lacunarity": 2, "Distortion": 0}
        self.assertEqual(node["inputs"], expected)
        self.assertEqual(written["nodes"][2]["inputs"], {"Color": {"node": 1, "output": "Color"}, "Strength": 1})
        self.assertEqual(found.verdict("material", "m")["verdict"], "exact")
        self.assertIn("emissiveFactor", found.material("m"))

    def test_groups_are_flattened(self):
        tree, glow = self.tree()
        inner = bpy.data.node_groups.new("inner", "ShaderNodeTree")
        inner.interface.new_socket("Scale", in_out="INPUT", socket_type="NodeSocketFloat")
        inner.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
        entry, noise, leaving, relay = (inner.nodes.new(k) for k in ("NodeGroupInput", "ShaderNodeTexNoise", "NodeGroupOutput", "NodeReroute"))
        inner.links.new(entry.outputs["Scale"], noise.inputs["Scale"])
        inner.links.new(noise.outputs["Color"], relay.inputs[0])
        inner.links.new(relay.outputs[0], leaving.inputs["Color"])
        outer = bpy.data.node_groups.new("outer", "ShaderNodeTree")
        outer.interface.new_socket("Scale", in_out="INPUT", socket_type="NodeSocketFloat")
        outer.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
        entry, leaving, mixed = (outer.nodes.new(k) for k in ("NodeGroupInput", "NodeGroupOutput", "ShaderNodeMixRGB"))
        for number, name in ((1, "first"), (2, "second")):
            use = outer.nodes.new("ShaderNodeGroup")
            use.node_tree, use.name = inner, name
            use.inputs["Scale"].default_value = number
            outer.links.new(use.outputs[0], mixed.inputs[number])
        outer.links.new(entry.outputs["Scale"], outer.nodes["first"].inputs["Scale"])
        outer.links.new(mixed.outputs[0], leaving.inputs["Color"])
        use = tree.nodes.new("ShaderNodeGroup")
        use.node_tree = outer
        use.inputs["Scale"].default_value = 12
        gone, passing = tree.nodes.new("ShaderNodeGamma"), tree.nodes.new("NodeReroute")
        gone.mute = True
        tree.links.new(use.outputs[0], gone.inputs["Color"])
        tree.links.new(gone.outputs[0], passing.inputs[0])
        tree.links.new(passing.outputs[0], glow.inputs["Color"])
        tree.links.new(passing.outputs[0], glow.inputs["Strength"])
        written = self.graph_of(self.export())
        self.assertEqual([n["type"] for n in written["nodes"]], ["ShaderNodeTexNoise"] * 2 + ["ShaderNodeMixRGB", "ShaderNodeEmission"])
        self.assertEqual([n["inputs"]["Scale"] for n in written["nodes"][:2]], [12, 2])
        self.assertEqual(written["nodes"][2]["inputs"], {"Fac": 0.5, "Color1": {"node": 0, "output": "Color"}, "Color2": {"node": 1, "output": "Color"}})
        self.assertEqual(written["nodes"][3]["inputs"], {"Color": {"node": 2, "output": "Color"}, "Strength": {"node": 2, "output": "Color"}})

    def test_groups_with_values_alone(self):
        """What stands at a group's socket counts inside, converted; each against Cycles."""
        for kind, value, sort, socket in (
            ("NodeSocketColor", (0.9, 0.1, 0.2, 1), "ShaderNodeMath", "Value"),
            ("NodeSocketVector", (0.9, 0.1, 0.2), "ShaderNodeMath", "Value"),
            ("NodeSocketFloat", 0.3, "ShaderNodeGamma", "Color"),
            ("NodeSocketVector", (0.3, 0.0, 0.0), "ShaderNodeTexGradient", "Vector"),
        ):
            with self.subTest(kind=kind, sort=sort):
                self.setUp()
                self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 1
                tree, glow = self.tree()
                inner = bpy.data.node_groups.new("inner", "ShaderNodeTree")
                inner.interface.new_socket("In", in_out="INPUT", socket_type=kind)
                inner.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
                entry, node, leaving = (inner.nodes.new(k) for k in ("NodeGroupInput", sort, "NodeGroupOutput"))
                if sort == "ShaderNodeMath":
                    node.inputs[1].default_value = 0
                inner.links.new(entry.outputs[0], node.inputs[socket])
                inner.links.new(node.outputs[0], leaving.inputs[0])
                use = tree.nodes.new("ShaderNodeGroup")
                use.node_tree = inner
                use.inputs[0].default_value = value
                tree.links.new(use.outputs[0], glow.inputs["Color"])
                shown = kit.cycles_pixels(4, 4, 1)
                tree.links.new(self.varying(tree, 0), glow.inputs["Strength"])
                found = self.export()
                entry = self.only(found, sort)
                if sort == "ShaderNodeTexGradient":
                    # From 5.0 on such a value counts as coordinates, before it does not.
                    self.assertEqual(float(numpy.ptp(shown)) < 1e-3, "Vector" in entry.get("inputs", {}))
                    if "Vector" in entry.get("inputs", {}):
                        self.near(shown.mean(), 0.3, 1e-4)
                        self.assertEqual(self.only(found, "ShaderNodeCombineXYZ")["inputs"], {"X": 0.3, "Y": 0, "Z": 0})
                else:
                    # Cycles 4.5 has four digits of the luminances.
                    self.near(numpy.broadcast_to(entry["inputs"][socket], 4)[:3], shown[2, 2], 3e-4)

    def test_sockets_on_the_way_convert(self):
        """A colour through a number's socket of a group: grey or whole before 5.0, as it was from then on, and from 5.3 on true or false."""
        for kind in ("NodeSocketFloat", "NodeSocketVector", "NodeSocketInt", "NodeSocketBool"):
            with self.subTest(kind=kind):
                self.setUp()
                tree, glow = self.tree()
                inner = bpy.data.node_groups.new("inner", "ShaderNodeTree")
                inner.interface.new_socket("In", in_out="INPUT", socket_type=kind)
                inner.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
                inner.links.new(inner.nodes.new("NodeGroupInput").outputs[0], inner.nodes.new("NodeGroupOutput").inputs[0])
                use = tree.nodes.new("ShaderNodeGroup")
                use.node_tree = inner
                tree.links.new(self.varying(tree), use.inputs[0])
                tree.links.new(use.outputs[0], glow.inputs["Color"])
                self.camera.location = (0, 0, 2)
                shown = kit.cycles_pixels(4, 4, 1)
                kinds = [n["type"] for n in self.graph_of(self.export())["nodes"]]
                is_grey = "ShaderNodeRGBToBW" in kinds or "ShaderNodeMath" in kinds
                self.assertEqual(float(numpy.ptp(shown, axis=-1).max()) < 1e-3, is_grey)

    def test_what_leads_nowhere_has_its_own_value(self):
        """A muted node without inputs: Cycles shows the value of the socket that it feeds."""
        for way in ("plain", "reroute", "group"):
            with self.subTest(way=way):
                self.setUp()
                self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 1
                tree, glow = self.tree()
                muted = tree.nodes.new("ShaderNodeRGB")
                muted.mute, muted.outputs[0].default_value = True, (0.9, 0.1, 0.2, 1)
                glow.inputs["Color"].default_value = (0.2, 0.3, 0.4, 1)
                output = muted.outputs[0]
                if way == "reroute":
                    relay = tree.nodes.new("NodeReroute")
                    tree.links.new(output, relay.inputs[0])
                    output = relay.outputs[0]
                elif way == "group":
                    inner = bpy.data.node_groups.new("inner", "ShaderNodeTree")
                    inner.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketColor")
                    inner.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
                    inner.links.new(inner.nodes.new("NodeGroupInput").outputs[0], inner.nodes.new("NodeGroupOutput").inputs[0])
                    use = tree.nodes.new("ShaderNodeGroup")
                    use.node_tree = inner
                    use.inputs[0].default_value = (0.7, 0.8, 0.9, 1)
                    tree.links.new(output, use.inputs[0])
                    output = use.outputs[0]
                tree.links.new(output, glow.inputs["Color"])
                shown = kit.cycles_pixels(4, 4, 1)[2, 2]
                self.near(self.export().material("m").get("emissiveFactor", (0, 0, 0)), shown, 1e-4)
                tree.links.new(self.varying(tree, 0), glow.inputs["Strength"])
                self.near(self.only(self.export(), "ShaderNodeEmission")["inputs"]["Color"][:3], shown, 1e-4)

    def test_drivers_and_animation(self):
        tree, glow = self.tree()
        noise = tree.nodes.new("ShaderNodeTexNoise")
        tree.links.new(noise.outputs["Color"], glow.inputs["Color"])
        noise.inputs["Scale"].driver_add("default_value").driver.expression = "frame * 2"
        noise.inputs["Detail"].default_value = 1
        noise.inputs["Detail"].keyframe_insert("default_value", frame=1)
        noise.inputs["Detail"].default_value = 5
        noise.inputs["Detail"].keyframe_insert("default_value", frame=9)
        self.scene.frame_set(9)
        inputs = self.only(self.export(), "ShaderNodeTexNoise")["inputs"]
        self.assertEqual((inputs["Scale"], inputs["Detail"]), (18, 5))

    def test_every_node_of_the_table_can_be_written(self):
        # The Glossy BSDF has had another name since 4.0; some nodes went with 5.0.
        # Those of functions are of geometry before 5.3.
        kinds = [k for k in evaluated.EVALUATED if k != "ShaderNodeBsdfGlossy" and hasattr(bpy.types, k)]
        kinds = [k for k in kinds if nodes.TRUTHS or not k.startswith("FunctionNode")]
        self.assertGreaterEqual(len(kinds), len(evaluated.EVALUATED) - 9)
        for kind in kinds:
            tree, glow = self.tree(kind)
            tree.links.new(self.varying(tree), glow.inputs["Strength"])
            node = tree.nodes.new(kind)
            outputs = [s for s in node.outputs if s.enabled]
            self.assertEqual(node.bl_idname, kind)
            if kind in {"ShaderNodeTexImage", "ShaderNodeTexEnvironment"}:
                node.image = bpy.data.images.new("image", 2, 2)
            elif kind == "ShaderNodeAttribute":
                node.attribute_name = "here"
            if outputs[0].type == "SHADER":
                both = tree.nodes.new("ShaderNodeAddShader")
                tree.links.new(node.outputs[0], both.inputs[0])
                tree.links.new(glow.outputs[0], both.inputs[1])
                tree.links.new(both.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
                continue
            total = glow.inputs["Color"]
            # All outputs, one added to the other.
            for output in outputs:
                allowed = evaluated.EVALUATED[kind].outputs
                if allowed and output.identifier not in allowed or (kind, output.identifier) == ("ShaderNodeNormal", "Dot"):
                    continue
                summed = tree.nodes.new("ShaderNodeVectorMath")
                tree.links.new(summed.outputs[0], total)
                tree.links.new(output, summed.inputs[0])
                total = summed.inputs[1]
        found = self.export()
        # A Bevel has four rays by default.
        told = {"ShaderNodeBevel": "approximated"}
        for kind in kinds:
            with self.subTest(kind=kind):
                verdict = found.verdict("material", kind)
                self.assertEqual(verdict["verdict"], told.get(kind, "exact"), verdict)
                shown = bpy.data.materials[kind].evaluated_get(bpy.context.evaluated_depsgraph_get())
                source = next(n for n in shown.node_tree.nodes if n.bl_idname == kind)
                constants = {"RGB", "Value", "Blackbody", "Normal", "Wavelength", "VolumeInfo"}
                if kind.removeprefix("ShaderNode") in constants:
                    self.assertNotIn(kind, [n["type"] for n in self.graph_of(found, kind)["nodes"]])
                    continue
                node = next(n for n in self.graph_of(found, kind)["nodes"] if n["type"] == kind and n.get("name") == source.name)
                own = {s.identifier: s for s in source.inputs if s.enabled and s.type not in {"SHADER", "CUSTOM"}}
                linked = {s.identifier for s in source.inputs if s.is_linked}
                # What a Raycast takes by itself comes by nodes of Geometry.
                linked |= {"Position", "Direction"} if kind == "ShaderNodeRaycast" else set()
                silent = {i for i, s in own.items() if s.hide_value and s.type == "VECTOR" and (kind, i) not in graph._VALUED}
                self.assertEqual(set(node.get("inputs", {})) - linked, set(own) - silent - linked)
                for identifier in set(own) - silent - linked:
                    value = own[identifier].default_value
                    width = {"RGBA": 4, "VECTOR": 3}.get(own[identifier].type)
                    # Radial Tiling's vector has two numbers.
                    expected = float(value) if width is None else [*value, 0.0][:width] if len(value) < width else list(value)
                    self.near(node["inputs"][identifier], expected, 1e-7)
        if os.path.isfile(os.environ.get("SUNDOG_PROGRAM", "")):
            found.info()

    def test_circles_of_links_are_cut(self):
        tree, glow = self.tree()
        first, second = tree.nodes.new("ShaderNodeMath"), tree.nodes.new("ShaderNodeMath")
        tree.links.new(self.varying(tree, 0), glow.inputs["Strength"])
        tree.links.new(first.outputs[0], second.inputs[0])
        tree.links.new(second.outputs[0], first.inputs[0])
        tree.links.new(second.outputs[0], glow.inputs["Color"])
        found = self.export()
        if nodes.INLINED:
            # Blender makes a black surface of such trees: test_parity_inlined.py.
            self.assertEqual(found.verdict("material", "m")["verdict"], "exact")
            return
        self.assertEqual([n["type"] for n in self.graph_of(found)["nodes"]], ["ShaderNodeMath"] * 2 + ["ShaderNodeTexNoise", "ShaderNodeEmission"])
        self.assertEqual(found.verdict("material", "m")["verdict"], "approximated")
        self.assertEqual(found.verdict("material", "m")["detail"], nodes.CUT)

    def test_links_of_sockets_that_are_off_are_no_circles(self):
        """Blender calls them invalid, too: what asks takes its own value, and nothing is told."""
        for way in ("output", "input"):
            with self.subTest(way=way):
                self.setUp()
                tree, glow = self.tree()
                node = tree.nodes.new("ShaderNodeVectorMath")
                node.operation = "LENGTH" if way == "output" else "SCALE"
                if way == "output":
                    tree.links.new(node.outputs["Value"], glow.inputs["Color"])
                else:
                    tree.links.new(self.varying(tree, 0), node.inputs["Scale"])
                    tree.links.new(node.outputs["Vector"], glow.inputs["Color"])
                node.operation = "ADD"
                tree.links.new(self.varying(tree, 0), glow.inputs["Strength"])
                verdict = self.export().verdict("material", "m")
                self.assertEqual(verdict["verdict"], "exact", verdict["detail"])

    def test_circles_that_blender_does_not_see_are_cut(self):
        """The walk itself ends whatever the walker finds."""
        tree, glow = self.tree()
        first = tree.nodes.new("ShaderNodeMath")
        tree.links.new(first.outputs[0], glow.inputs["Color"])

        class Circular(nodes.Walker):
            def source(self, place, passed=None):
                if place.node == first and place.socket == first.inputs[0]:
                    passed.append("VALUE")
                    return nodes.Place(first.outputs[0])
                return super().source(place, passed)

        walk = graph.Walk(Circular())
        walk.read(tree.id_data if isinstance(tree.id_data, bpy.types.Material) else bpy.data.materials["m"])
        self.assertTrue(walk.is_cut)
        self.assertEqual([u.node.type for u in walk.uses], ["MATH", "EMISSION"])
        self.assertEqual(list(walk.uses[0].inputs), ["Value_001"])

    def deep(self, tree, groups, nodes_of_each):
        """The output of so many groups behind one another, each a chain of nodes that use the one before twice."""
        inner = bpy.data.node_groups.new("chain", "ShaderNodeTree")
        inner.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketFloat")
        inner.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketFloat")
        before = inner.nodes.new("NodeGroupInput").outputs[0]
        for _ in range(nodes_of_each):
            node = inner.nodes.new("ShaderNodeMath")
            inner.links.new(before, node.inputs[0])
            inner.links.new(before, node.inputs[1])
            before = node.outputs[0]
        inner.links.new(before, inner.nodes.new("NodeGroupOutput").inputs[0])
        before = self.varying(tree, 0)
        for _ in range(groups):
            use = tree.nodes.new("ShaderNodeGroup")
            use.node_tree = inner
            tree.links.new(before, use.inputs[0])
            before = use.outputs[0]
        return before

    def test_ten_thousand_nodes_behind_one_another(self):
        tree, glow = self.tree()
        tree.links.new(self.deep(tree, 100, 100), glow.inputs["Color"])
        started = time.perf_counter()
        found = self.export()
        # Two seconds where it was written.
        self.assertLess(time.perf_counter() - started, 30)
        written = self.graph_of(found)["nodes"]
        self.assertEqual(len(written), 10_002)
        for number, node in enumerate(written[1:-1]):
            self.assertEqual(node["inputs"]["Value_001"]["node"], number)
        self.assertEqual(found.verdict("material", "m")["verdict"], "exact")

    def test_one_node_for_a_thousand(self):
        tree, glow = self.tree()
        noise = tree.nodes.new("ShaderNodeTexNoise")
        total = glow.inputs["Color"]
        for _ in range(300):
            summed = tree.nodes.new("ShaderNodeVectorMath")
            summed.operation = "MULTIPLY_ADD"
            tree.links.new(summed.outputs[0], total)
            tree.links.new(noise.outputs["Color"], summed.inputs[0])
            tree.links.new(noise.outputs["Color"], summed.inputs[1])
            total = summed.inputs[2]
        written = self.graph_of(self.export())["nodes"]
        self.assertEqual(len(written), 302)
        self.assertEqual([n["type"] for n in written].count("ShaderNodeTexNoise"), 1)

    def test_groups_that_amount_to_too_much(self):
        tree, glow = self.tree()
        inner = None
        for number in range(13):
            outer = bpy.data.node_groups.new(f"level {number}", "ShaderNodeTree")
            outer.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
            mixed = outer.nodes.new("ShaderNodeMixRGB")
            for socket in mixed.inputs[1:3]:
                use = outer.nodes.new("ShaderNodeTexNoise" if inner is None else "ShaderNodeGroup")
                if inner is not None:
                    use.node_tree = inner
                outer.links.new(use.outputs[0], socket)
            outer.links.new(mixed.outputs[0], outer.nodes.new("NodeGroupOutput").inputs[0])
            inner = outer
        use = tree.nodes.new("ShaderNodeGroup")
        use.node_tree = inner
        tree.links.new(use.outputs[0], glow.inputs["Color"])
        before, nodes.MOST_NODES = nodes.MOST_NODES, 2000
        graph.MOST_NODES = 2000
        try:
            found = self.export()
        finally:
            nodes.MOST_NODES = graph.MOST_NODES = before
        self.assertIsNone(self.graph_of(found))
        verdict = found.verdict("material", "m")
        self.assertEqual(verdict["verdict"], "lost")
        self.assertIn("its groups amount to more than 2000 nodes", verdict["detail"])

    def test_numbers_that_are_none(self):
        tree, glow = self.tree()
        glow.inputs["Color"].default_value = (float("nan"), 0.5, 0.25, 1)
        found = self.export()
        self.assertEqual(found.verdict("material", "m")["detail"], "\"Color\" of the node Emission is not a number: 0 is used")
        self.assertEqual(found.verdict("material", "m")["verdict"], "approximated")
        noise = tree.nodes.new("ShaderNodeTexNoise")
        noise.inputs["Scale"].default_value = float("nan")
        tree.links.new(noise.outputs[0], glow.inputs["Strength"])
        found = self.export()
        self.assertEqual(self.only(found, "ShaderNodeEmission")["inputs"]["Color"], [0, 0.5, 0.25, 1])
        self.assertEqual(self.only(found, "ShaderNodeTexNoise")["inputs"]["Scale"], 0)
        detail = found.verdict("material", "m")["detail"]
        self.assertIn("\"Color\" of the node Emission", detail)
        self.assertIn("\"Scale\" of the node Noise Texture", detail)
        self.assertNotIn("mean", detail)

    def test_constants_stand_as_numbers(self):
        tree, glow = self.tree()
        color, dot, missing = (tree.nodes.new(f"ShaderNode{k}") for k in ("RGB", "Normal", "TexImage"))
        color.outputs[0].default_value = (0.1, 0.2, 0.3, 1)
        dot.outputs["Normal"].default_value = (0, 0.6, 0.8)
        mixed = tree.nodes.new("ShaderNodeMixRGB")
        tree.links.new(color.outputs[0], mixed.inputs["Color1"])
        tree.links.new(missing.outputs["Color"], mixed.inputs["Color2"])
        tree.links.new(mixed.outputs[0], glow.inputs["Color"])
        bent = tree.nodes.new("ShaderNodeBsdfDiffuse")
        tree.links.new(dot.outputs["Normal"], bent.inputs["Normal"])
        both, parted = tree.nodes.new("ShaderNodeAddShader"), tree.nodes.new("ShaderNodeMixShader")
        tree.links.new(glow.outputs[0], both.inputs[0])
        tree.links.new(bent.outputs[0], both.inputs[1])
        tree.links.new(both.outputs[0], parted.inputs[1])
        tree.links.new(color.outputs[0], parted.inputs[2])
        tree.links.new(self.varying(tree, 0), parted.inputs[0])
        tree.links.new(parted.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        written = self.graph_of(self.export())["nodes"]
        node = next(n for n in written if n["type"] == "ShaderNodeMixRGB")
        self.assertEqual(node["inputs"]["Color1"], [0.1, 0.2, 0.3, 1])
        self.assertEqual(node["inputs"]["Color2"], [1, 0, 1, 1])
        diffuse = next(n for n in written if n["type"] == "ShaderNodeBsdfDiffuse")
        self.near(list(written[diffuse["inputs"]["Normal"]["node"]]["inputs"].values()), (0, 0.6, 0.8))
        mixing = next(n for n in written if n["type"] == "ShaderNodeMixShader")
        shining = written[mixing["inputs"]["Shader_001"]["node"]]
        self.assertEqual(shining, {"type": "ShaderNodeEmission", "inputs": {"Color": [0.1, 0.2, 0.3, 1], "Strength": 1}})


class Tables(GraphTest):
    """Ramps and curves."""

    def test_ramps(self):
        tree, glow = self.tree()
        node = tree.nodes.new("ShaderNodeValToRGB")
        ramp = node.color_ramp
        ramp.elements[0].color, ramp.elements[1].position = (0.5, 0, 0, 0.25), 0.75
        ramp.elements.new(0.3).color = (0, 1, 0, 1)
        tree.links.new(self.varying(tree, 0), node.inputs[0])
        tree.links.new(node.outputs["Color"], glow.inputs["Color"])
        for interpolation in ("EASE", "CARDINAL", "LINEAR", "B_SPLINE", "CONSTANT"):
            ramp.interpolation = interpolation
            written = self.only(self.export(), "ShaderNodeValToRGB")["properties"]["color_ramp"]
            self.assertEqual(written["interpolation"], interpolation)
            self.assertEqual(len(written["table"]), 257)
            self.near(written["table"], [list(ramp.evaluate(i / 256)) for i in range(257)])
        self.near(written["stops"], [[0, 0.5, 0, 0, 0.25], [0.3, 0, 1, 0, 1], [0.75, 1, 1, 1, 1]])
        ramp.elements.remove(ramp.elements[0])
        ramp.elements.remove(ramp.elements[0])
        self.assertEqual(len(self.only(self.export(), "ShaderNodeValToRGB")["properties"]["color_ramp"]["stops"]), 1)

    def test_curves(self):
        tree, glow = self.tree()
        total = glow.inputs["Color"]
        for kind in ("RGBCurve", "VectorCurve", "FloatCurve"):
            node = tree.nodes.new(f"ShaderNode{kind}")
            for number, curve in enumerate(node.mapping.curves):
                curve.points.new(0.2 + number / 10, 0.7)
            node.mapping.curves[0].points[-1].location = (1.5, 1.2)
            node.mapping.extend = "HORIZONTAL"
            node.mapping.use_clip = False
            node.mapping.update()
            tree.links.new(node.outputs[0], total)
            total = node.inputs[1]
        tree.links.new(self.varying(tree, 0), total)
        found = self.export()
        for kind, low, width in (("RGBCurve", 0, 3), ("VectorCurve", -1, 3), ("FloatCurve", 0, 1)):
            mapping = tree.nodes[{"RGBCurve": "RGB Curves", "VectorCurve": "Vector Curves", "FloatCurve": "Float Curve"}[kind]].mapping
            mapping.initialize()
            written = self.only(found, f"ShaderNode{kind}")["properties"]["curves"]
            self.assertEqual((written["min_x"], written["max_x"], written["extend"]), (low, 1.5, "HORIZONTAL"))
            expected = []
            for i in range(257):
                at = low + i / 256 * (1.5 - low)
                at = mapping.evaluate(mapping.curves[3], at) if kind == "RGBCurve" else at
                expected.append([mapping.evaluate(mapping.curves[k], at) for k in range(width)])
            self.near(written["table"], expected)

    def test_cycles_has_as_many_entries(self):
        """A step of a ramp that lies between two entries shows where they are."""
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 1
        tree, glow = self.tree()
        node, slow = tree.nodes.new("ShaderNodeValToRGB"), tree.nodes.new("ShaderNodeMath")
        node.color_ramp.elements[0].position, node.color_ramp.elements[1].position = 0.5, 0.500001
        slow.operation = "MULTIPLY_ADD"
        slow.inputs[1].default_value = 1e-7
        tree.links.new(tree.nodes.new("ShaderNodeTexGradient").outputs[1], slow.inputs[0])
        tree.links.new(slow.outputs[0], node.inputs[0])
        tree.links.new(node.outputs[0], glow.inputs["Color"])
        table = None
        for at in (0.499, 0.501, 0.502, 0.503, 0.504):
            slow.inputs[2].default_value = at
            table = table or [r[0] for r in self.only(self.export(), "ShaderNodeValToRGB")["properties"]["color_ramp"]["table"]]
            expected = numpy.interp(at, numpy.linspace(0, 1, len(table)), table)
            self.assertAlmostEqual(float(kit.cycles_pixels(4, 4, 1)[2, 2, 0]), expected, delta=1e-3)


class When(GraphTest):
    """When a graph is written, and the verdicts."""

    def test_what_glTF_can_say_has_none(self):
        self.tree()
        found = self.export()
        self.assertIsNone(self.graph_of(found))
        self.assertNotIn("SUNDOG_shader_graph", found.root["extensionsUsed"])

    def test_normal_maps_have_one(self):
        """Those of glTF have no normals from below the surface: maps with blue below a half would be another thing."""
        tree, _ = self.tree()
        shader, bent, image = (tree.nodes.new(f"ShaderNode{k}") for k in ("BsdfPrincipled", "NormalMap", "TexImage"))
        image.image = bpy.data.images.new("blue of nothing", 4, 4, is_data=True)
        path = os.path.join(self.folder, "blue.png")
        image.image.filepath_raw, image.image.file_format = path, "PNG"
        image.image.save()
        tree.links.new(image.outputs["Color"], bent.inputs["Color"])
        tree.links.new(bent.outputs["Normal"], shader.inputs["Normal"])
        tree.links.new(shader.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        found = self.export()
        self.assertEqual(self.only(found, "ShaderNodeNormalMap")["properties"]["space"], "TANGENT")
        self.assertIn("normalTexture", found.material("m"))
        self.assertEqual(found.verdict("material", "m")["verdict"], "exact")

    def test_nothing_is_written_while_it_is_off(self):
        tree, glow = self.tree()
        tree.links.new(self.varying(tree), glow.inputs["Color"])
        graph.ENABLED = False
        found = self.export()
        self.assertIsNone(self.graph_of(found))
        self.assertEqual(found.verdict("material", "m")["verdict"], "approximated")
        self.assertNotIn("not evaluated", found.verdict("material", "m")["detail"])

    def test_nodes_that_are_not_evaluated_are_named(self):
        def tiled(tree, glow):
            node = tree.nodes.new("ShaderNodeTexImage")
            node.image = bpy.data.images.new("tiles", 2, 2, tiled=True)
            return node.outputs[0]

        def undisplaced(tree, glow):
            node = tree.nodes.new("ShaderNodeAttribute")
            node.attribute_name = "undisplaced"
            return node.outputs[0]

        for fill, words in (
            (tiled, "Image Texture (tiles that are not saved)"),
            (undisplaced, "Attribute (undisplaced)"),
        ):  # fmt: skip
            with self.subTest(words=words):
                self.setUp()
                tree, glow = self.tree()
                output = fill(tree, glow)
                tree.links.new(output, tree.nodes["Material Output"].inputs["Surface"] if output.type == "SHADER" else glow.inputs["Color"])
                graph.ENABLED = False
                before = self.export().verdict("material", "m")
                graph.ENABLED = True
                found = self.export()
                self.assertIsNone(self.graph_of(found))
                after = found.verdict("material", "m")
                self.assertEqual(after["verdict"], before["verdict"])
                self.assertNotEqual(after["verdict"], "exact")
                self.assertEqual(after["detail"], f"{before['detail']}; its nodes are not evaluated as they are because of: {words}")

    def test_names_of_cycles_are_no_colors(self):
        """What Cycles makes of meshes is told as a node whose mean is used, not as a colour attribute that is white."""
        for name in ("N", "P", "tangent", "UVMap.tangent"):
            with self.subTest(name=name):
                self.setUp()
                tree, glow = self.tree()
                node = tree.nodes.new("ShaderNodeAttribute")
                node.attribute_name = name
                tree.links.new(node.outputs["Vector"], glow.inputs["Color"])
                told = self.export().verdict("material", "m")
                self.assertEqual(told["verdict"], "approximated")
                self.assertNotIn("colour attributes", told["detail"])
                self.assertIn(f"Attribute ({name})", told["detail"])

    def test_shaders_of_hair_are_written(self):
        for kind, settings in (
            ("ShaderNodeBsdfHair", {"component": "Transmission"}),
            ("ShaderNodeBsdfHairPrincipled", {"model": "CHIANG", "parametrization": "MELANIN"}),
            ("ShaderNodeBsdfHairPrincipled", {"model": "HUANG", "parametrization": "ABSORPTION"}),
        ):
            with self.subTest(kind=kind, **settings):
                self.setUp()
                tree, _ = self.tree()
                shader = tree.nodes.new(kind)
                for name, value in settings.items():
                    setattr(shader, name, value)
                tree.links.new(shader.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
                found = self.export()
                node = self.graph_of(found)["nodes"][-1]
                self.assertEqual((node["type"], node["properties"]), (kind, settings))
                self.assertEqual(found.verdict("material", "m")["verdict"], "exact")

    def test_emission_below_a_coat_is_exact(self):
        for color in (None, (0, 0, 0, 1), (1, 0.5, 0, 1)):
            with self.subTest(color=color):
                self.setUp()
                tree, _ = self.tree()
                shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
                shader.inputs["Emission Strength"].default_value = shader.inputs["Coat Weight"].default_value = 1
                tree.links.new(self.varying(tree), shader.inputs["Base Color"])
                if color is None:
                    tree.links.new(self.varying(tree), shader.inputs["Emission Color"])
                else:
                    shader.inputs["Emission Color"].default_value = color
                tree.links.new(shader.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
                found = self.export()
                self.assertIsNotNone(self.graph_of(found))
                self.assertEqual(found.verdict("material", "m")["verdict"], "exact")

    def test_what_a_mix_does_not_show_needs_not_be_evaluated(self):
        tree, glow = self.tree()
        tree.links.new(self.varying(tree), glow.inputs["Color"])
        mixed = tree.nodes.new("ShaderNodeMixShader")
        tree.links.new(glow.outputs[0], mixed.inputs[1])
        hidden, shine = tree.nodes.new("ShaderNodeAttribute"), tree.nodes.new("ShaderNodeEmission")
        hidden.attribute_name = "undisplaced"
        tree.links.new(hidden.outputs[0], shine.inputs["Color"])
        tree.links.new(shine.outputs[0], mixed.inputs[2])
        tree.links.new(mixed.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
        mixed.inputs[0].default_value = 0
        found = self.export()
        self.assertNotIn("ShaderNodeAttribute", [n["type"] for n in self.graph_of(found)["nodes"]])
        mixed.inputs[0].default_value = 0.5
        self.assertIsNone(self.graph_of(self.export()))

    def test_a_volume_that_varies_and_displacement_are_written(self):
        tree, glow = self.tree()
        output = tree.nodes["Material Output"]
        tree.links.new(self.varying(tree), glow.inputs["Color"])
        volume = tree.nodes.new("ShaderNodeVolumeScatter")
        tree.links.new(self.varying(tree), volume.inputs["Color"])
        tree.links.new(volume.outputs[0], output.inputs["Volume"])
        tree.links.new(tree.nodes.new("ShaderNodeDisplacement").outputs[0], output.inputs["Displacement"])
        found = self.export()
        self.assertEqual(self.graph_of(found)["displacement"]["output"], "Displacement")
        self.assertEqual(found.verdict("material", "m")["verdict"], "exact")
        written = found.material("m")["extensions"]["SUNDOG_material"]["volume"]["graph"]
        self.assertIn("ShaderNodeVolumeScatter", [n["type"] for n in written["nodes"]])
        # What a volume cannot be asked for is told, and takes nothing else with it.
        tree.links.new(tree.nodes.new("ShaderNodeWireframe").outputs[0], volume.inputs["Density"])
        verdict = self.export().verdict("material", "m")
        self.assertEqual(verdict["verdict"], "lost")
        self.assertIn("volume", verdict["detail"])
        self.assertNotIn("displacement", verdict["detail"])
        self.assertNotIn("mean", verdict["detail"])

    def test_only_the_output_for_cycles_counts(self):
        tree, glow = self.tree()
        other = tree.nodes.new("ShaderNodeOutputMaterial")
        other.target, tree.nodes["Material Output"].target = "CYCLES", "EEVEE"
        shown = tree.nodes.new("ShaderNodeEmission")
        shown.name = "shown"
        tree.links.new(self.varying(tree), shown.inputs["Color"])
        tree.links.new(shown.outputs[0], other.inputs["Surface"])
        self.assertEqual(self.graph_of(self.export())["nodes"][-1]["name"], "shown")


class Images(GraphTest):
    """The files of images."""

    def test_an_original_and_copies(self):
        tree, glow = self.tree()
        total = glow.inputs["Color"]

        def show(image, name):
            nonlocal total
            node, summed = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeVectorMath")
            node.image, node.name = image, name
            node.extension, node.projection, node.projection_blend = "EXTEND", "BOX", 0.25
            tree.links.new(node.outputs["Color"], summed.inputs[0])
            # Colours whose opacity nothing asks for are flattened.
            tree.links.new(node.outputs["Alpha"], next(s for s in summed.inputs if s.identifier == "Scale"))
            tree.links.new(summed.outputs[0], total)
            total = summed.inputs[1]

        values = numpy.random.default_rng(2).random((4, 4, 4), numpy.float32)
        made = bpy.data.images.new("own", 4, 4, alpha=True)
        made.pixels.foreach_set(values.reshape(-1))
        made.filepath_raw, made.file_format = os.path.join(self.folder, "own.png"), "PNG"
        made.save()
        show(bpy.data.images.load(made.filepath_raw), "own")
        show(made, "own again")
        drawn = bpy.data.images.new("drawn", 4, 4, alpha=True)
        drawn.pixels.foreach_set(values.reshape(-1))
        show(drawn, "drawn")
        data = bpy.data.images.new("data", 4, 4)
        data.pixels.foreach_set(values.reshape(-1))
        data.colorspace_settings.name = "Non-Color"
        show(data, "data")
        floats = bpy.data.images.new("floats", 4, 4, alpha=True, float_buffer=True)
        floats.alpha_mode = "PREMUL"
        floats.pixels.foreach_set(values.reshape(-1))
        show(floats, "floats")
        linear = bpy.data.images.new("linear", 4, 4)
        linear.pixels.foreach_set(values.reshape(-1))
        linear.colorspace_settings.name = "Linear Rec.709"
        show(linear, "linear")
        found = self.export()
        nodes_by_name = {n.get("name"): n for n in self.graph_of(found)["nodes"]}
        seen = {}
        for name in ("own", "own again", "drawn", "data", "floats", "linear"):
            properties = nodes_by_name[name]["properties"]
            self.assertEqual((properties["extension"], properties["projection"], properties["projection_blend"]), ("EXTEND", "BOX", 0.25))
            self.assertEqual(properties["uv_set"], 0)
            seen[name] = properties["image"]
        files = {n: os.path.join(os.path.dirname(found.path), found["images"][i["index"]]["uri"]) for n, i in seen.items()}
        self.assertTrue(os.path.samefile(files["own"], made.filepath_raw))
        self.assertEqual(seen["own"]["index"], seen["own again"]["index"])
        spaces = {n: i["colorspace"] for n, i in seen.items()}
        self.assertEqual(spaces, {"own": "sRGB", "own again": "sRGB", "drawn": "sRGB", "data": "Non-Color", "floats": "Linear Rec.709", "linear": "Linear Rec.709"})
        for name, image in (("drawn", drawn), ("data", data), ("linear", linear)):
            again = bpy.data.images.load(files[name])
            again.colorspace_settings.name = "Non-Color" if name == "data" else "sRGB" if name == "drawn" else "Linear Rec.709"
            got, expected = (numpy.array(i.pixels[:]).reshape(4, 4, 4) for i in (again, image))
            self.near(got, expected, 1 / 1024)
        self.assertEqual(found.verdict("material", "m")["verdict"], "exact")

    def test_missing_images(self):
        tree, glow = self.tree()
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = bpy.data.images.new("gone", 2, 2)
        node.image.source, node.image.filepath = "FILE", "//gone.png"
        tree.links.new(node.outputs["Color"], glow.inputs["Color"])
        tree.links.new(self.varying(tree, 0), glow.inputs["Strength"])
        found = self.export()
        self.assertEqual(self.only(found, "ShaderNodeEmission")["inputs"]["Color"], [1, 0, 1, 1])
        verdict = found.verdict("material", "m")
        self.assertEqual(verdict["verdict"], "exact")
        self.assertIn("missing", verdict["detail"])


class Meshes(GraphTest):
    """What graphs ask of meshes and objects."""

    def primitive(self, found):
        (primitive,) = found["meshes"][0]["primitives"]
        return primitive

    def test_uv_maps_have_one_numbering(self):
        mesh = kit.plane("m")
        for number, name in enumerate(("second", "third")):
            for corner in mesh.uv_layers.new(name=name).data:
                corner.uv = (number + 0.25, 0.5)
        mesh.uv_layers["UVMap"].active_render = True
        tree, glow = self.tree(mesh=mesh)
        image = bpy.data.images.new("image", 2, 2)
        image.pack()
        total = glow.inputs["Color"]
        for name in ("third", "", "second", "third"):
            where, node, summed = (tree.nodes.new(f"ShaderNode{k}") for k in ("UVMap", "TexImage", "VectorMath"))
            where.uv_map, where.name, node.image = name, f"map {name}", image
            tree.links.new(where.outputs[0], node.inputs[0])
            tree.links.new(node.outputs[0], summed.inputs[0])
            tree.links.new(summed.outputs[0], total)
            total = summed.inputs[1]
        tree.links.new(self.varying(tree), total)
        found = self.export()
        sets = {n["properties"]["uv_map"]: n["properties"]["uv_set"] for n in self.graph_of(found)["nodes"] if n["type"] == "ShaderNodeUVMap"}
        self.assertEqual(sorted(sets.values()), [0, 1, 2])
        attributes = self.primitive(found)["attributes"]
        for name, expected in (("third", (1.25, 0.5)), ("second", (0.25, 0.5))):
            self.near(found.array(attributes[f"TEXCOORD_{sets[name]}"])[0], expected)
        self.assertGreater(numpy.ptp(found.array(attributes[f"TEXCOORD_{sets['']}"])), 0.5)
        emissive = found.material("m").get("emissiveTexture")
        if emissive:
            self.assertEqual(emissive.get("texCoord", 0), sets["third"])

    def test_attributes(self):
        mesh = kit.plane("m")
        rng = numpy.random.default_rng(4)
        values = {}
        for name, kind, field, width, domain, count in (
            ("painted", "FLOAT_COLOR", "color", 4, "CORNER", 4), ("flow", "FLOAT_VECTOR", "vector", 3, "POINT", 4), ("pair", "FLOAT2", "vector", 2, "POINT", 4),
        ):  # fmt: skip
            values[name] = rng.random((count, width), numpy.float32)
            mesh.attributes.new(name, kind, domain).data.foreach_set(field, values[name].reshape(-1))
        tree, glow = self.tree(mesh=mesh)
        total = glow.inputs["Color"]
        for name, output in (("painted", "Alpha"), ("painted", "Color"), ("flow", "Vector"), ("pair", "Fac"), ("nowhere", "Vector")):
            node, summed = tree.nodes.new("ShaderNodeAttribute"), tree.nodes.new("ShaderNodeVectorMath")
            node.attribute_name = name
            tree.links.new(next(o for o in node.outputs if o.identifier == output), summed.inputs[0])
            tree.links.new(summed.outputs[0], total)
            total = summed.inputs[1]
        tree.links.new(tree.nodes.new("ShaderNodeVertexColor").outputs[0], total)
        found = self.export()
        names = {}
        for node in self.graph_of(found)["nodes"]:
            properties = node.get("properties", {})
            if "attribute" in properties:
                names[properties.get("attribute_name", properties.get("layer_name"))] = properties["attribute"]
        self.assertEqual(len(set(names.values())), 5)
        attributes = self.primitive(found)["attributes"]
        self.near(found.array(attributes[names["painted"]]), values["painted"])
        corners = found.array(attributes[names["flow"]])
        self.near(corners, values["flow"])
        self.near(found.array(attributes[names["pair"]]), numpy.repeat(values["pair"][:, :1], 3, axis=1))
        self.assertEqual(found.array(attributes[names["nowhere"]]).max(), 0)
        self.near(found.array(attributes[names[""]]), values["painted"][:, :3])
        self.assertEqual(found.verdict("material", "m")["verdict"], "exact")

    def test_cycles_takes_the_first_of_two_numbers(self):
        mesh = kit.plane("m")
        mesh.attributes.new("pair", "FLOAT2", "POINT").data.foreach_set("vector", [0.8, 0.1] * 4)
        tree, glow = self.tree(mesh=mesh)
        node = tree.nodes.new("ShaderNodeAttribute")
        node.attribute_name = "pair"
        tree.links.new(next(o for o in node.outputs if o.identifier == "Fac"), glow.inputs["Color"])
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 1
        self.near(kit.cycles_pixels(4, 4, 1)[2, 2], [0.8] * 3, 1e-4)

    def generated(self, found):
        """Generated coordinates of a cube's vertices by the file's texture space."""
        primitive = self.primitive(found)
        space = primitive["extensions"]["SUNDOG_mesh"]["texture_space"]
        points = found.array(primitive["attributes"]["POSITION"])
        size = numpy.array(space["size"])
        return points, (points - space["location"] + size) / (2 * size)

    def test_texture_spaces_are_those_of_cycles(self):
        """Seen from above: red and green are the first two coordinates."""
        def plain(made):
            pass

        def array(made):
            made.modifiers.new("array", "ARRAY").count = 2

        def own(made):
            made.data.use_auto_texspace = False
            made.data.texspace_location, made.data.texspace_size = (0.2, 0.1, 0), (2, 3, 1)

        for change in (plain, array, own):
            with self.subTest(change=change.__name__):
                self.setUp()
                tree, glow = self.tree(mesh=kit.plane("m"))
                change(bpy.data.objects["m"])
                tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], glow.inputs["Color"])
                self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 2
                shown = kit.cycles_pixels(8, 8, 1)
                points, coordinates = self.generated(self.export())
                # Linear over the plane: fitted by the corners.
                terms = numpy.c_[points[:, :2], numpy.ones(len(points))]
                fitted = numpy.linalg.lstsq(terms, coordinates, rcond=None)[0]
                at = (numpy.arange(8) + 0.5) / 4 - 1
                grid = numpy.stack([*numpy.meshgrid(at, at), numpy.ones((8, 8))], axis=-1)
                self.near(numpy.maximum(grid @ fitted, 0), shown, 2e-3)

    def test_deformed_meshes_carry_the_coordinates_that_they_had(self):
        tree, glow = self.tree(mesh=kit.cube("m"))
        tree.links.new(self.varying(tree), glow.inputs["Color"])
        self.assertNotIn("_GENERATED", self.primitive(self.export())["attributes"])
        made = bpy.data.objects["m"]
        made.modifiers.new("bent", "SIMPLE_DEFORM").deform_method = "TAPER"
        found = self.export()
        self.assertNotIn(("object", "m"), [(v["kind"], v["name"]) for v in found.result.verdicts])
        primitive = self.primitive(found)
        self.assertEqual(primitive["extensions"]["SUNDOG_mesh"], {"generated": "_GENERATED"})
        # Corners of a cube.
        carried = found.array(primitive["attributes"]["_GENERATED"])
        self.near(carried, numpy.rint(carried), 1e-6)
        self.assertEqual(len(numpy.unique(numpy.rint(carried), axis=0)), 8)
        made.modifiers.clear()
        made.modifiers.new("array", "ARRAY")
        self.assertNotIn("_GENERATED", self.primitive(self.export())["attributes"])

    def test_object_info_is_that_of_cycles(self):
        tree, glow = self.tree("Blüte")
        told = tree.nodes.new("ShaderNodeObjectInfo")
        made = bpy.data.objects["Blüte"]
        made.color, made.pass_index = (0.1, 0.2, 0.3, 0.4), 7
        bpy.data.materials["Blüte"].pass_index = 3
        place = self.link("place", None)
        place.instance_type = "COLLECTION"
        inside = bpy.data.collections.new("inside")
        place.instance_collection, place.location = inside, (4, 0, 0)
        inside.objects.link(bpy.data.objects.new("instanced", made.data))
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 8
        self.camera.location = (2, 0, 10)
        for output in ("Random", "Color", "Alpha", "Object Index", "Material Index"):
            tree.links.new(told.outputs[output], glow.inputs["Color"])
            shown = kit.cycles_pixels(8, 8, 1)[3]
            found = self.export()
            for name, pixel in (("Blüte", shown[1]), ("instanced", shown[5])):
                content = found.node(name).get("extensions", {}).get("SUNDOG_object", {})
                if output == "Material Index":
                    self.assertEqual(self.graph_of(found, "Blüte")["pass_index"], 3)
                    self.assertEqual(content, {})
                    self.near(pixel, [3] * 3)
                    continue
                color = content["color"]
                expected = {"Random": content["random"], "Color": color[:3], "Alpha": color[3], "Object Index": content["pass_index"]}[output]
                self.near(pixel, numpy.broadcast_to(expected, 3), 1e-6)
        self.assertEqual(found.verdict("material", "Blüte")["verdict"], "exact")

    def test_objects_without_need_stay_as_they_are(self):
        tree, glow = self.tree()
        tree.links.new(self.varying(tree), glow.inputs["Color"])
        self.assertNotIn("extensions", self.export().node("m"))


if __name__ == "__main__":
    unittest.main()
