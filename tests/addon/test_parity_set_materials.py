# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that geometry nodes alone give to meshes, beside Cycles."""

import unittest

import bpy
import export_kit as kit
import numpy


class SetMaterials(kit.ExportTest):
    """A sphere that geometry nodes make, with a material that no slot has."""

    def setUp(self):
        super().setUp()
        self.write_graphs(True)
        kit.unbiased(self.scene.cycles)
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 1

    def test_tangents_without_a_map(self):
        """The mesh of the object has a map, the one that is made has none: tangents are about a sphere."""
        for way in ("node", "modifier"):
            with self.subTest(way=way):
                material = bpy.data.materials.new(f"by {way}")
                material.use_nodes = True
                tree = material.node_tree
                tree.nodes.clear()
                tangent, glow, end = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Tangent", "Emission", "OutputMaterial"))
                tangent.direction_type = "UV_MAP"
                up = tree.nodes.new("ShaderNodeVectorMath")
                up.inputs[1].default_value = (1, 1, 1)
                for output, socket in ((tangent.outputs[0], up.inputs[0]), (up.outputs[0], glow.inputs[0]), (glow.outputs[0], end.inputs[0])):
                    tree.links.new(output, socket)
                made = bpy.data.node_groups.new("made", "GeometryNodeTree")
                made.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
                given = made.interface.new_socket("Material", in_out="INPUT", socket_type="NodeSocketMaterial")
                # Its value is of a kind that no set takes.
                made.interface.new_socket("Rotation", in_out="INPUT", socket_type="NodeSocketRotation")
                made.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
                entry, leaving = made.nodes.new("NodeGroupInput"), made.nodes.new("NodeGroupOutput")
                ball, setting = made.nodes.new("GeometryNodeMeshUVSphere"), made.nodes.new("GeometryNodeSetMaterial")
                made.links.new(ball.outputs[0], setting.inputs[0])
                made.links.new(setting.outputs[0], leaving.inputs[0])
                thing = self.link("holder", kit.plane("holder", 1))
                modifier = thing.modifiers.new("made", "NODES")
                modifier.node_group = made
                if way == "node":
                    setting.inputs["Material"].default_value = material
                else:
                    made.links.new(entry.outputs["Material"], setting.inputs["Material"])
                    if hasattr(modifier, "properties"):
                        getattr(modifier.properties.inputs, given.identifier).value = material
                    else:
                        modifier[given.identifier] = material
                shown = kit.cycles_pixels(16, 16, 16)
                found = self.export()
                ours = kit.rendered(found.path, 16, 16, 16)
                print(f"{way}: {ours.mean(axis=(0, 1))} Cycles {shown.mean(axis=(0, 1))}", flush=True)
                self.assertLess(float(numpy.abs(ours - shown).mean()), 0.01)
                bpy.data.objects.remove(thing)


if __name__ == "__main__":
    unittest.main()
