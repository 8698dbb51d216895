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


if __name__ == "__main__":
    unittest.main()
