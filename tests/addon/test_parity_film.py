# SPDX-License-Identifier: GPL-3.0-or-later
"""Transparent films beside Cycles', and the shadow terminator's Shading Offset."""

import unittest

import bpy
import export_kit as kit
import numpy
from engine_kit import EngineTest

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


class Glass(EngineTest):
    """A film that is transparent behind glass, too."""

    def test_the_film_is_transparent_behind_glass_up_to_a_roughness(self):
        scene = self.for_both((48, 32), 256)
        scene.render.film_transparent = scene.cycles.film_transparent_glass = True
        scene.cycles.film_transparent_roughness = 0.3
        bpy.data.objects.remove(bpy.data.objects["Cube"])
        # Clear, rough, rougher than the threshold; a pane; and one before a matte wall.
        for number, values in enumerate(({"Roughness": 0}, {"Roughness": 0.25}, {"Roughness": 0.4}, {"Roughness": 0.1, "Thin Wall": True})):
            bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.6, location=(1.4 * number - 2.1, 0, 0))
            bpy.ops.object.shade_smooth()
            made = kit.material(f"glass {number}", Transmission_Weight=1, Base_Color=(0.9, 0.6, 0.4, 1))
            shader = next(n for n in made.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
            for name, value in values.items():
                if name in shader.inputs:
                    shader.inputs[name].default_value = value
            bpy.context.object.data.materials.append(made)
        bpy.ops.mesh.primitive_plane_add(size=1, location=(-2, 1.5, 0), rotation=(1.57, 0, 0))
        ours, theirs = ([p["ViewLayer.Combined"].astype(float) for p in found] for found in self.both())
        blocks = lambda pictures: (sum(pictures) / 2).reshape(8, 4, 12, 4, 4).mean((1, 3))
        a, b = blocks(ours), blocks(theirs)
        for name, channels in (("colours", slice(0, 3)), ("alpha", slice(3, 4))):
            a_, b_ = a[..., channels], b[..., channels]
            off, error = a_.mean() / b_.mean() - 1, ((a_ - b_) ** 2 / (b_**2 + 0.01)).mean()
            print(f"{name}: mean {off:+.3%}, relMSE of blocks {error:.1e}", flush=True)
            self.assertLess(abs(off), 0.01, name)
            self.assertLess(error, 1e-3, name)
        # Something is seen through, and something is not.
        self.assertLess(b[..., 3].min(), 0.5)


class ShadowTerminators(EngineTest):
    """The Shading Offset of the shadow terminator."""

    def test_light_that_grazes_counts_less(self):
        scene = self.for_both((48, 32), 256)
        cube, floor = bpy.data.objects["Cube"], bpy.data.objects["Floor"]
        cube.shadow_terminator_shading_offset, floor.shadow_terminator_shading_offset = 1.0, 0.3
        bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8, radius=0.7, location=(1.6, 0, -0.3))
        ball = bpy.context.object
        bpy.ops.object.shade_smooth()
        ball.shadow_terminator_shading_offset = 0.6
        ball.data.materials.append(kit.material("shiny", Base_Color=(0.7, 0.3, 0.2, 1), Roughness=0.3, Coat_Weight=0.5))
        ours, theirs = (sum(p["ViewLayer.Combined"].astype(float) for p in found) / 2 for found in self.both())
        blocks = [picture[..., :3].reshape(8, 4, 12, 4, 3).mean((1, 3)) for picture in (ours, theirs)]
        off = blocks[0].mean() / blocks[1].mean() - 1
        error = ((blocks[0] - blocks[1]) ** 2 / (blocks[1] ** 2 + 0.01)).mean()
        print(f"shading offsets: mean {off:+.3%}, relMSE of blocks {error:.1e}", flush=True)
        self.assertLess(abs(off), 0.005)
        self.assertLess(error, 1e-3)
        found = kit.in_render(lambda depsgraph: kit.export.write_scene(depsgraph, depsgraph.scene, self.folder, self.folder))
        self.assertFalse([v for v in found.verdicts if v["verdict"] != "exact"])


if __name__ == "__main__":
    unittest.main()
