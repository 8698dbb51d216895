# SPDX-License-Identifier: GPL-3.0-or-later
"""Simplify's limits of textures beside Cycles."""

import math
import os
import unittest

import bpy
import numpy

import export_kit as kit

SIDE = 96


class TextureLimits(kit.ExportTest):
    """A sign with a picture, seen from straight before it."""

    def setUp(self):
        super().setUp()
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 2
        self.scene.render.use_simplify = True
        self.material = bpy.data.materials.new("sign")
        self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        self.texture, emission, output = (
            self.tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexImage", "Emission", "OutputMaterial")
        )
        self.texture.interpolation = "Closest"
        self.tree.links.new(self.texture.outputs["Color"], emission.inputs["Color"])
        self.tree.links.new(emission.outputs[0], output.inputs["Surface"])
        self.emission, self.output = emission, output
        mesh = kit.plane()
        mesh.materials.append(self.material)
        self.link("sign", mesh)

    def picture(self, width, height, space="sRGB", floats=False, alpha=False):
        """A picture of random numbers in a file."""
        values = numpy.random.default_rng(1).random((height, width, 4)).astype(numpy.float32)
        if not alpha:
            values[..., 3] = 1
        made = bpy.data.images.new("made", width, height, alpha=True, float_buffer=floats)
        made.colorspace_settings.name = space
        made.pixels.foreach_set(values.ravel())
        made.filepath_raw = os.path.join(self.folder, f"{width}-{height}-{space}-{alpha}.{'exr' if floats else 'png'}")
        made.file_format = "OPEN_EXR" if floats else "PNG"
        made.save()
        found = bpy.data.images.load(made.filepath_raw)
        found.colorspace_settings.name = space
        return found

    def compare(self, name, off=2e-3, mean=math.inf):
        theirs = kit.cycles_pixels(SIDE, SIDE, 4)
        ours = kit.rendered(self.export().path, SIDE, SIDE, 4)
        worst = abs(ours - theirs).max()
        print(f"{name}: {worst:.1e} at most off, mean {theirs.mean():.4f}", flush=True)
        self.assertLess(worst, off, name)
        self.assertLess(abs(ours - theirs).mean(), mean, name)
        return theirs

    def test_pictures_are_halved(self):
        cycles = self.scene.cycles
        for width, height, limit, resolution in ((192, 96, "128", 1), (193, 131, "OFF", 0.3), (384, 96, "128", 0.5), (48, 32, "128", 1)):
            cycles.texture_limit_render, cycles.texture_resolution_render = limit, resolution
            for space, floats in (("sRGB", False), ("Non-Color", False), ("Non-Color", True)):
                self.texture.image = self.picture(width, height, space, floats)
                # Half a byte is rounded either way in Cycles, which counts in floats below 1.
                self.compare(f"{width} × {height} in {space}, limit {limit}, {resolution}", 1e-2, 1e-5)

    def test_off(self):
        self.scene.cycles.texture_resolution_render, self.scene.render.use_simplify = 0.5, False
        self.texture.image = self.picture(96, 96)
        self.compare("without Simplify")
        self.assertNotIn("texture_limit", self.export().scene())

    def test_colours_count_by_their_opacity(self):
        """Up to the rounding of what Cycles multiplies in bytes: its darkest colours have few."""
        clear, mix = (self.tree.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfTransparent", "MixShader"))
        for source, target in (
            (self.texture.outputs["Alpha"], mix.inputs[0]), (clear.outputs[0], mix.inputs[1]),
            (self.emission.outputs[0], mix.inputs[2]), (mix.outputs[0], self.output.inputs["Surface"]),
        ):  # fmt: skip
            self.tree.links.new(source, target)
        self.texture.image = self.picture(192, 192, alpha=True)
        self.scene.cycles.texture_resolution_render = 0.2
        self.scene.world = None
        self.compare("with opacity", 0.03)

    def test_the_world(self):
        self.scene.objects["sign"].hide_render = True
        self.camera.data.type, self.camera.rotation_euler = "PANO", (math.radians(90), 0, 0)
        self.camera.data.panorama_type = "EQUIRECTANGULAR"
        self.scene.world = bpy.data.worlds.new("world")
        self.scene.world.use_nodes = True
        tree = self.scene.world.node_tree
        node = tree.nodes.new("ShaderNodeTexEnvironment")
        node.interpolation = "Closest"
        background = next(n for n in tree.nodes if n.type == "BACKGROUND")
        tree.links.new(node.outputs["Color"], background.inputs["Color"])
        for space, floats in (("sRGB", False), ("Non-Color", True)):
            node.image = self.picture(192, 96, space, floats)
            self.scene.cycles.texture_resolution_render = 0.3
            theirs = self.compare(f"a world in {space}", 2.0)
            ours = kit.rendered(self.export().path, SIDE, SIDE, 16)
            self.assertLess(abs(ours.std() / theirs.std() - 1), 0.02)


if __name__ == "__main__":
    unittest.main()
