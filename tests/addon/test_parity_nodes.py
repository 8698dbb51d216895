# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes beside Cycles that came last: Radial Tiling, textures of worlds and of lamps on surfaces, holdouts, and rows of the
matrix where versions differ."""

import os
import subprocess
import unittest

import bpy
import export_kit as kit
import numpy
import parity
import parity_table
import parity_tiles

# By node: parts of rows in words, of which each row has one.
ROWS = {
    "RadialTiling": ("Segment",),
    "TexBrick": ("squash 0.0", "TexBrick · →"),
    "VectorMath": ("operation",),
    "FloatCurve": ("Value",),
    "TexEnvironment": ("Color",),
    "TexIES": ("Fac",),
    "TexWave": (" · →",),
}


class Values(unittest.TestCase):
    """What nodes give."""

    def setUp(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        parity.picture()

    def check(self, kind):
        tiles = [t for t in parity_tiles.tiles(kind) if t.kind == "sheet" and any(part in t.words for part in ROWS[kind])]
        rows, _ = parity.run(tiles, say=lambda *words, **settings: None)
        wrong = [row for row in rows if not row["ok"]]
        told = [f"{r['node']} {parity_table.words(r)}: mean {r['mean']:.5f} against {r['cycles']:.5f}, relMSE {r['relmse']:.1e} {r['flattened']}" for r in wrong]
        self.assertFalse(told, "\n" + "\n".join(told))
        self.assertGreater(len(rows), 5)

    def test_vectors_of_all_operations(self):
        self.check("VectorMath")

    def test_bricks_without_width(self):
        self.check("TexBrick")

    def test_waves_of_all_kinds(self):
        self.check("TexWave")

    def test_constant_float_curves(self):
        self.check("FloatCurve")

    def test_environments_on_surfaces(self):
        self.check("TexEnvironment")

    def test_lamps_profiles_on_surfaces(self):
        self.check("TexIES")

    @unittest.skipUnless(hasattr(bpy.types, "ShaderNodeRadialTiling"), "a node of Blender 5")
    def test_radial_tiling(self):
        self.check("RadialTiling")

    def test_an_exclusion_of_a_factor_below_none(self):
        tile = parity_tiles.Tile("MixRGB", (("blend_type", "EXCLUSION"),), (("Fac", "low"),), "Color", "sheet")
        rows, _ = parity.run([tile], say=lambda *words, **settings: None)
        self.assertTrue(rows[0]["ok"], rows[0])


class Holdouts(kit.ExportTest):
    """Where the camera sees a Holdout, the picture is empty; other rays see black."""

    def of(self, build):
        """Opacity and light of both programs in the middle of a plane, and what the add-on says of the material."""
        material = bpy.data.materials.new("held")
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        end = tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(build(tree).outputs[0], end.inputs["Surface"])
        bpy.ops.mesh.primitive_plane_add(size=1.0)
        bpy.context.object.data.materials.append(material)
        self.scene.world = bpy.data.worlds.new("world")
        self.scene.world.use_nodes = True
        camera = self.camera.data
        camera.type, camera.ortho_scale = "ORTHO", 2.0
        render = self.scene.render
        render.film_transparent = False
        render.resolution_x, render.resolution_y, render.resolution_percentage = 16, 16, 100
        found = self.export()
        out = found.path + ".exr"
        command = [kit.program(), "render", found.path, "-o", out, "--width", "16", "--height", "16", "--quiet", "--allow-outside"]
        subprocess.run([*command, "--samples", "4", "--filter", "box", "--exr-layers", "combined"], check=True, capture_output=True)
        kit.for_cycles(16, 16, 4)
        render.image_settings.color_mode = "RGBA"
        render.filepath = os.path.join(os.path.dirname(out), "cycles.exr")
        with kit.quiet():
            bpy.ops.render.render(write_still=True)
        told = [v for v in found.result.verdicts if v["name"] == "held"]
        return self.rgba(out), self.rgba(render.filepath), told

    @staticmethod
    def rgba(path):
        image = bpy.data.images.load(path)
        image.colorspace_settings.name = "Non-Color"
        values = numpy.empty(image.size[0] * image.size[1] * image.channels, numpy.float32)
        image.pixels.foreach_get(values)
        bpy.data.images.remove(image)
        return values.reshape(16, 16, -1)

    def agree(self, build):
        ours, theirs, told = self.of(build)
        self.assertEqual(ours.shape, theirs.shape)
        numpy.testing.assert_allclose(ours, theirs, atol=1e-4)
        # The middle is empty, and around it is the world.
        self.assertEqual(ours[8, 8].tolist(), [0, 0, 0, 0])
        self.assertEqual(ours[0, 0, 3], 1)
        self.assertFalse([v for v in told if v["verdict"] != "exact"], told)

    def test_a_holdout_alone(self):
        self.agree(lambda tree: tree.nodes.new("ShaderNodeHoldout"))

    def test_a_holdout_behind_a_mix_that_shows_it_alone(self):
        def build(tree):
            mix = tree.nodes.new("ShaderNodeMixShader")
            mix.inputs[0].default_value = 1.0
            tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], mix.inputs[1])
            tree.links.new(tree.nodes.new("ShaderNodeHoldout").outputs[0], mix.inputs[2])
            return mix

        self.agree(build)

    def test_a_holdout_among_others_empties_its_share(self):
        def build(tree):
            mix = tree.nodes.new("ShaderNodeMixShader")
            tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], mix.inputs[1])
            tree.links.new(tree.nodes.new("ShaderNodeHoldout").outputs[0], mix.inputs[2])
            return mix

        ours, theirs, told = self.of(build)
        numpy.testing.assert_allclose(ours[..., :3], theirs[..., :3], atol=0.01)
        # Four samples in each pixel are there, or not.
        self.assertAlmostEqual(float(ours[5:11, 5:11, 3].mean()), 0.5, delta=5 * 0.5 / 12)
        self.assertFalse([v for v in told if v["verdict"] != "exact"], told)


if __name__ == "__main__":
    unittest.main()
