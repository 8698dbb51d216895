# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors in sockets of normals beside Cycles: of no length, and on the other side of the surface."""

import unittest

import bpy
import export_kit as kit
import numpy


class VectorsForNormals(kit.ExportTest):
    """A ball whose nodes take a vector for a normal."""

    SIZE, SAMPLES = 24, 64

    def setUp(self):
        super().setUp()
        self.write_graphs(True)
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 2
        kit.unbiased(self.scene.cycles)
        kit.sun_and_grey_world(self.scene)
        bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.9, rotation=(0.3, 0.4, 0.5))
        self.ball = bpy.context.object
        bpy.ops.object.shade_smooth()

    def begin(self, vector):
        """A new material: its tree, and an output that gives the vector everywhere."""
        bpy.data.batch_remove(list(bpy.data.materials))
        self.ball.data.materials.clear()
        self.material = bpy.data.materials.new("ball")
        self.material.use_nodes = True
        self.ball.data.materials.append(self.material)
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        # No constant for Cycles.
        place, sum_of = self.tree.nodes.new("ShaderNodeTexCoord"), self.tree.nodes.new("ShaderNodeVectorMath")
        sum_of.operation = "MULTIPLY_ADD"
        sum_of.inputs[1].default_value, sum_of.inputs[2].default_value = (0, 0, 0), vector
        self.tree.links.new(place.outputs["Generated"], sum_of.inputs[0])
        return sum_of.outputs[0]

    def node(self, kind, vector, socket="Normal", **inputs):
        """A node that takes the vector."""
        node = self.tree.nodes.new(f"ShaderNode{kind}")
        for name, value in inputs.items():
            node.inputs[name.replace("_", " ")].default_value = value
        self.tree.links.new(vector, node.inputs[socket])
        return node

    def compare(self, words, output):
        """Both pictures of a shader, or of what an output shines, are alike; the verdict is exact."""
        end = self.tree.nodes.new("ShaderNodeOutputMaterial")
        self.tree.links.new(output, end.inputs["Surface"])
        kit.for_cycles(self.SIZE, self.SIZE, self.SAMPLES)
        found = self.export()
        self.assertEqual(found.verdict("material", "ball")["verdict"], "exact", words)
        ours = kit.rendered(found.path, self.SIZE, self.SIZE, self.SAMPLES)
        theirs = kit.cycles_pixels(self.SIZE, self.SIZE, self.SAMPLES)
        far = float(abs(ours.mean((0, 1)) - theirs.mean((0, 1))).max() / theirs.mean())
        print(f"{words}: {ours.mean():.4f} Cycles {theirs.mean():.4f} ({far:.2%})", flush=True)
        self.assertLess(far, 0.005, words)

    def test_no_length(self):
        """Fresnel gives 1 then, and an open place is one of which no ray goes anywhere. (Fresnel was 77 % off.)"""
        for kind, output in (("Fresnel", "Factor"), ("LayerWeight", "Fresnel"), ("LayerWeight", "Facing"), ("AmbientOcclusion", "Color")):
            with self.subTest(kind=kind, output=output):
                node = self.node(kind, self.begin((0, 0, 0)))
                self.compare(f"{kind} {output}", node.outputs.get(output) or node.outputs[0])
        with self.subTest(kind="Bump"):
            bump = self.node("Bump", self.begin((0, 0, 0)), Distance=0.1)
            self.tree.links.new(self.tree.nodes.new("ShaderNodeTexNoise").outputs[0], bump.inputs["Height"])
            self.compare("Bump", self.node("BsdfDiffuse", bump.outputs[0]).outputs[0])

    def test_other_lengths(self):
        """They are taken as they are."""
        for vector in ((0, 0, 2.5), (0.1, 0.2, 0.3)):
            for kind in ("Fresnel", "LayerWeight"):
                with self.subTest(kind=kind, vector=vector):
                    self.compare(f"{kind} {vector}", self.node(kind, self.begin(vector)).outputs[0])

    def test_coats_from_behind(self):
        """What they reflect along themselves darkens what is below. (The base was up to 3.4 times as bright.)"""
        for vector in ((0, 0, -1), (0.3, 0.2, -0.4)):
            for roughness in (0.05, 0.5, 1.0):
                with self.subTest(vector=vector, roughness=roughness):
                    numbers = {"Coat_Weight": 1.0, "Coat_Roughness": roughness, "Roughness": roughness}
                    node = self.node("BsdfPrincipled", self.begin(vector), "Coat Normal", **numbers)
                    self.compare(f"coat {vector} {roughness}", node.outputs[0])

    def test_known_vectors_below_surfaces(self):
        """Cycles takes them for no bump where light comes out: it leaves about the smooth normal. (It was 1.8 % off.)"""
        self.SAMPLES = 512
        for method in ("RANDOM_WALK", "BURLEY"):
            with self.subTest(method=method):
                self.begin((0, 0, 0))
                known = self.tree.nodes.new("ShaderNodeCombineXYZ")
                for socket, value in zip(known.inputs, (0.3, 0, 1)):
                    socket.default_value = value
                node = self.node("SubsurfaceScattering", known.outputs[0], Scale=0.1)
                node.falloff = method
                self.compare(f"below, {method}", node.outputs[0])

    def test_translucent_from_behind(self):
        """Lights before the surface shine on what looks behind it, where they are sampled. (A flat face had 0.1 of the light.)"""
        bpy.data.objects.remove(self.ball)
        bpy.ops.mesh.primitive_plane_add(size=1.8)
        self.ball = bpy.context.object
        for vector in ((0, 0, -1), (0.3, 0, -1), (0.6, 0, -0.5), (0.8, 0, 0.2)):
            with self.subTest(vector=vector):
                self.compare(f"translucent {vector}", self.node("BsdfTranslucent", self.begin(vector)).outputs[0])


if __name__ == "__main__":
    unittest.main()
