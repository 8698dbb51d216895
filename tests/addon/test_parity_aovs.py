# SPDX-License-Identifier: GPL-3.0-or-later
"""AOVs beside Cycles': colours and values, through veils, in groups, of bumps, of the world; in Blender's result and in the program's file."""

import math
import os
import subprocess
import unittest

import bpy
import numpy

import exr
import export_kit as kit
from engine_kit import EngineTest

WIDTH, HEIGHT, SAMPLES = 32, 24, 1024
COLORS, VALUES = ("mine", "by texture", "by bump"), ("a number", "of a colour")


class Aovs(EngineTest):
    """One scene by both engines."""

    def setUp(self):
        super().setUp()
        scene = self.for_both((WIDTH, HEIGHT), SAMPLES)
        layer = scene.view_layers[0]
        for name, kind in [*((n, "COLOR") for n in COLORS), *((n, "VALUE") for n in VALUES)]:
            aov = layer.aovs.add()
            aov.name, aov.type = name, kind
        cube = bpy.data.objects["Cube"].active_material
        self.tell(cube, "mine", Color=(0.2, -0.5, 3.0, 1))
        self.tell(cube, "a number", Value=0.25)
        noise = self.node(cube, "TexNoise", Scale=3.0)
        self.tell(cube, "by texture", Color=noise.outputs["Color"])
        self.tell(cube, "of a colour", Value=noise.outputs["Color"])
        bump = self.node(cube, "Bump", Strength=0.6, Height=noise.outputs[0])
        self.tell(cube, "by bump", Color=bump.outputs["Normal"])
        floor = kit.material("floor")
        bpy.data.objects["Floor"].data.materials.append(floor)
        geometry = self.node(floor, "NewGeometry")
        self.tell(floor, "by texture", Color=geometry.outputs["Position"])
        self.tell(floor, "by bump", Color=geometry.outputs["Normal"])
        # In a group, once muted, and for a pass that there is not.
        inside = bpy.data.node_groups.new("inside", "ShaderNodeTree")
        teller = inside.nodes.new("ShaderNodeOutputAOV")
        teller.aov_name = "a number"
        teller.inputs["Value"].default_value = 1.5
        floor.node_tree.nodes.new("ShaderNodeGroup").node_tree = inside
        self.tell(floor, "mine", Color=(9, 9, 9, 1)).mute = True
        self.tell(floor, "nobody's", Color=(9, 9, 9, 1))
        # Veils before all: one of which most passes, one of which less than half does, and one that only shines.
        for place, (name, alpha) in enumerate({"thin": 0.3, "dense": 0.7}.items()):
            bpy.ops.mesh.primitive_plane_add(size=1.6, location=(2.5 - 1.2 * place, -2.2 - 1.5 * place, 0.6), rotation=(math.radians(70), 0, 0.6))
            veil = kit.material(name, Alpha=alpha, Base_Color=(0.7, 0.5, 0.9, 1))
            bpy.context.object.data.materials.append(veil)
            self.tell(veil, "mine", Color=(1, 0.5, 0.25, 1))
            self.tell(veil, "a number", Value=2.0)

    @staticmethod
    def node(owner, kind, **inputs):
        tree = owner.node_tree
        node = tree.nodes.new(f"ShaderNode{kind}")
        for name, value in inputs.items():
            if isinstance(value, bpy.types.NodeSocket):
                tree.links.new(value, node.inputs[name])
            else:
                node.inputs[name].default_value = value
        return node

    def tell(self, owner, name, **value):
        """An AOV Output."""
        node = self.node(owner, "OutputAOV", **value)
        node.aov_name = name
        return node

    def near(self, name, ours, theirs):
        ours, theirs = ours.astype(float), theirs.astype(float)
        self.assertTrue(theirs.any(), name)
        mean = abs(ours.mean() - theirs.mean()) / numpy.abs(theirs).mean()
        relative = ((ours - theirs) ** 2 / (theirs**2 + 0.01)).mean()
        print(f"{name}: mean {mean:.3%}, relMSE {relative:.1e}", flush=True)
        self.assertLess(mean, 0.01, name)
        self.assertLess(relative, 1e-3, name)

    def both(self):
        found = []
        for engine in ("SUNDOG", "CYCLES"):
            self.scene.render.engine = engine
            found.append(self.render(engine))
        for name in (*COLORS, *VALUES):
            ours, theirs = (passes[f"ViewLayer.{name}"] for passes in found)
            self.assertEqual(ours.shape, theirs.shape, name)
            for channel in range(ours.shape[-1]):
                self.near(f"{name} {channel}", ours[..., channel], theirs[..., channel])

    def test_colours_and_values_through_veils(self):
        self.both()

    def test_the_programs_file_has_them_by_name(self):
        found = kit.in_render(lambda depsgraph: kit.export.write_scene(depsgraph, depsgraph.scene, self.folder, self.folder))
        ours = os.path.join(self.folder, "sundog.exr")
        command = [self.program, "render", found.path, "-o", ours, "--allow-outside", "--quiet", "--passes", "AOV", "--exr-compression", "none"]
        command += ["--width", str(WIDTH), "--height", str(HEIGHT), "--samples", "4"]
        subprocess.run(command, check=True)
        channels = exr.read(ours)
        colors = {f"{name}.{letter}" for name in COLORS for letter in "RGBA"}
        self.assertEqual(set(channels) - set("RGBA"), colors | {f"{name}.X" for name in VALUES})
        self.assertGreater(channels["a number.X"].mean(), 0.1)

    @kit.long
    def test_what_a_world_tells(self):
        world = self.scene.world
        noise = self.node(world, "TexNoise", Scale=2.0)
        world.node_tree.links.new(noise.outputs["Color"], world.node_tree.nodes["Background"].inputs["Color"])
        self.tell(world, "by texture", Color=noise.outputs["Color"])
        self.tell(world, "a number", Value=4.0)
        self.both()


if __name__ == "__main__":
    unittest.main()
