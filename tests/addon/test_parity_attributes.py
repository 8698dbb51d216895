# SPDX-License-Identifier: GPL-3.0-or-later
"""The Attribute node beside Cycles: properties of objects, of the view layer, the scene and the world, and attributes of meshes."""

import unittest

import bpy
import export_kit as kit
import numpy


class Attributes(kit.ExportTest):
    """A plane that glows by an attribute, by both programs."""

    def setUp(self):
        super().setUp()
        self.write_graphs(True)
        kit.unbiased(self.scene.cycles)
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 1
        self.material = bpy.data.materials.new("glow")
        self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        self.node = self.tree.nodes.new("ShaderNodeAttribute")
        self.glow, self.end = self.tree.nodes.new("ShaderNodeEmission"), self.tree.nodes.new("ShaderNodeOutputMaterial")
        self.tree.links.new(self.node.outputs["Color"], self.glow.inputs["Color"])
        self.tree.links.new(self.glow.outputs[0], self.end.inputs["Surface"])

    def shown_on(self, mesh, name="thing"):
        """An object with a mesh that has the material."""
        mesh.materials.append(self.material)
        return self.link(name, mesh)

    def compare(self, words, error=1e-3, least=0.0):
        """Both pictures are alike, but for places in pixels; some pixel is at least so bright."""
        shown = kit.cycles_pixels(16, 16, 64)
        found = self.export()
        ours = kit.rendered(found.path, 16, 16, 64)
        differs = float(numpy.abs(ours - shown).mean())
        print(f"{words}: {ours.mean(axis=(0, 1))} Cycles {shown.mean(axis=(0, 1))}, differs {differs:.5f}", flush=True)
        self.assertLessEqual(differs, error, words)
        self.assertGreaterEqual(float(shown.max()), least, words)
        return found

    def test_properties_of_objects(self):
        """Arrays of truths, and one number of several, are nothing."""
        thing = self.shown_on(kit.plane("plane", 4))
        thing["truths"], thing["numbers"] = [True, False, True], [1, 0, 2]
        thing.location = (0.1, 0.2, 0.3)
        for kind in ("OBJECT", "INSTANCER"):
            for name in ("truths", "numbers", "location", "location[1]", "location.x", "scale[0]", "color[2]"):
                with self.subTest(name=name, kind=kind):
                    self.node.attribute_type, self.node.attribute_name = kind, name
                    self.compare(f"{kind} {name}", 1e-5)

    def test_properties_of_the_view_layer(self):
        """They come before the scene's, and those of the world last."""
        self.shown_on(kit.plane("plane", 4))
        self.scene.world = self.scene.world or bpy.data.worlds.new("world")
        layer = self.scene.view_layers[0]
        layer["all"], self.scene["all"], self.scene.world["all"] = 0.8, 0.2, 0.5
        self.scene["two"], self.scene.world["two"], self.scene.world["one"] = 0.3, 0.6, 0.4
        self.node.attribute_type = "VIEW_LAYER"
        for name in ("all", "two", "one"):
            with self.subTest(name=name):
                self.node.attribute_name = name
                self.compare(name, 1e-5, 0.1)
    def test_places_of_instances(self):
        """What geometry nodes place has attributes, of which the place is none."""
        if bpy.app.version < (4, 5, 0):
            self.skipTest("this Blender does not tell of attributes of instances")
        made = bpy.data.node_groups.new("made", "GeometryNodeTree")
        made.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        kinds = ("GeometryNodeMeshGrid", "GeometryNodeInstanceOnPoints", "GeometryNodeMeshCube", "GeometryNodeSetMaterial", "NodeGroupOutput")
        points, placing, cube, setting, leaving = (made.nodes.new(kind) for kind in kinds)
        points.inputs["Vertices X"].default_value = points.inputs["Vertices Y"].default_value = 2
        setting.inputs["Material"].default_value = self.material
        cube.inputs["Size"].default_value = (0.9, 0.9, 0.9)
        made.links.new(points.outputs[0], placing.inputs["Points"])
        made.links.new(cube.outputs[0], setting.inputs["Geometry"])
        made.links.new(setting.outputs[0], placing.inputs["Instance"])
        made.links.new(placing.outputs[0], leaving.inputs[0])
        self.link("holder", bpy.data.meshes.new("holder")).modifiers.new("made", "NODES").node_group = made
        self.node.attribute_type, self.node.attribute_name = "INSTANCER", "position"
        more = self.tree.nodes.new("ShaderNodeVectorMath")
        more.inputs[1].default_value = (0.5, 0.5, 0.5)
        self.tree.links.new(self.node.outputs["Vector"], more.inputs[0])
        self.tree.links.new(more.outputs[0], self.glow.inputs["Color"])
        self.compare("position", 5e-3, 0.4)

    def test_kinds_without_numbers(self):
        """They are there, and zero."""
        self.node.attribute_name = "a"
        self.tree.links.new(self.node.outputs["Alpha"], self.glow.inputs["Color"])
        for kind in ("INT32_2D", "INT16_2D", "FLOAT4X4"):
            for domain in ("POINT", "EDGE", "FACE", "CORNER"):
                with self.subTest(kind=kind, domain=domain):
                    mesh = kit.plane("plane", 4)
                    try:
                        mesh.attributes.new("a", kind, domain)
                    except TypeError:
                        continue
                    thing = self.shown_on(mesh)
                    self.compare(f"{kind} {domain}", 1e-5)
                    bpy.data.objects.remove(thing)

    def grid(self, name, kind, domain):
        """A mesh of nine faces with an attribute of random numbers."""
        steps = numpy.linspace(-0.5, 0.5, 4)
        mesh = bpy.data.meshes.new(name)
        faces = [(4 * j + i, 4 * j + i + 1, 4 * j + i + 5, 4 * j + i + 4) for j in range(3) for i in range(3)]
        mesh.from_pydata([(x, y, 0) for y in steps for x in steps], [], faces)
        made = mesh.attributes.new("a", kind, domain)
        random = numpy.random.default_rng(5)
        field, width = {"BOOLEAN": ("value", 1), "INT": ("value", 1), "INT8": ("value", 1), "FLOAT": ("value", 1), "QUATERNION": ("value", 4)}.get(kind, ("color", 4))
        values = random.random(len(made.data) * width)
        if kind == "BOOLEAN":
            values = values > 0.7
        elif kind in {"INT", "INT8"}:
            values = (values * 5).astype(int)
        made.data.foreach_set(field, values)
        return mesh

    def test_edges(self):
        """Blender mixes them at vertices by the kind of their numbers."""
        self.node.attribute_name = "a"
        for kind in ("FLOAT", "BOOLEAN", "INT", "INT8", "FLOAT_COLOR", "BYTE_COLOR", "QUATERNION"):
            with self.subTest(kind=kind):
                thing = self.shown_on(self.grid(kind, kind, "EDGE"))
                self.compare(kind, 5e-3, 0.3)
                bpy.data.objects.remove(thing)

    def test_the_active_color(self):
        """It is one whatever it is on."""
        node = self.tree.nodes.new("ShaderNodeVertexColor")
        self.tree.links.new(node.outputs["Color"], self.glow.inputs["Color"])
        for kind in ("FLOAT_COLOR", "BYTE_COLOR"):
            for domain in ("POINT", "EDGE", "FACE", "CORNER"):
                with self.subTest(kind=kind, domain=domain):
                    thing = self.shown_on(self.grid(kind, kind, domain))
                    self.compare(f"{kind} {domain}", 5e-3, 0.3)
                    bpy.data.objects.remove(thing)

    def test_the_active_color_by_cycles_name(self):
        """An Attribute node finds it as "vertex_color", whatever it is called. (It was black, and told as exact.)"""
        self.node.attribute_name = "vertex_color"
        self.shown_on(self.grid("FLOAT_COLOR", "FLOAT_COLOR", "CORNER"))
        self.compare("vertex_color", 5e-3, 0.3)


if __name__ == "__main__":
    unittest.main()
