# SPDX-License-Identifier: GPL-3.0-or-later
"""Transparent films beside Cycles'."""

import unittest

import bpy
import export_kit as kit
import numpy

SIZE = 16


class Film(kit.ExportTest):
    """Alpha of both programs' pictures."""

    def alpha(self, picture):
        """The mean in the middle of an EXR file."""
        image = bpy.data.images.load(picture)
        try:
            return numpy.array(image.pixels[:]).reshape(SIZE, SIZE, -1)[4:12, 4:12, 3].mean()
        finally:
            bpy.data.images.remove(image)

    def alphas(self, samples):
        """(Sundog's, Cycles')."""
        render = self.scene.render
        render.film_transparent = True
        found = self.export()
        kit.rendered(found.path, SIZE, SIZE, samples, "--transparent")
        kit.for_cycles(SIZE, SIZE, samples)
        render.image_settings.color_mode, render.filepath = "RGBA", found.path + ".cycles.exr"
        with kit.quiet():
            bpy.ops.render.render(write_still=True)
        return self.alpha(found.path + ".exr"), self.alpha(render.filepath)

    def material(self, kind, socket, **values):
        """A material of one shader."""
        made = bpy.data.materials.new(kind)
        made.use_nodes = True
        tree = made.node_tree
        tree.nodes.clear()
        shader, output = (tree.nodes.new(f"ShaderNode{name}") for name in (kind, "OutputMaterial"))
        tree.links.new(shader.outputs[0], output.inputs[socket])
        for name, value in values.items():
            shader.inputs[name].default_value = value
        return made

    def test_what_takes_some_of_the_light(self):
        """The film is behind tinted surfaces and smoke as much as light gets through."""
        color = (0.5, 0.2, 0.1, 1)
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 2
        for material in (
            self.material("BsdfTransparent", "Surface", Color=color),
            self.material("VolumePrincipled", "Volume", Color=color, Density=0.2),
            self.material("VolumeAbsorption", "Volume", Color=color, Density=0.2),
        ):
            with self.subTest(material=material.name):
                for made in list(bpy.data.meshes):
                    bpy.data.meshes.remove(made)
                bpy.ops.mesh.primitive_cube_add(size=4)
                bpy.context.object.data.materials.append(material)
                ours, cycles = self.alphas(1024)
                print(f"alpha of {material.name}: {ours:.5f} {cycles:.5f} {ours / cycles - 1:+.2%}")
                self.near(ours, cycles, 0.01)


if __name__ == "__main__":
    unittest.main()
