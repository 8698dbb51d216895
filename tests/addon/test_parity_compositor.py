# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's compositor: a tree that uses every pass gives from Sundog's render result and file what it gives from Cycles'."""

import math
import os
import subprocess
import unittest

import bpy
import numpy

import export_kit as kit
from engine_kit import EngineTest

from sundog import command, passes, program

WIDTH, HEIGHT, SAMPLES = 32, 24, 1024
FIVE = bpy.app.version >= (5, 0, 0)
# Passes that are no light, and by what they are brought to about 1.
SCALES = {"Depth": 0.05, "Position": 0.1, "Vector": 0.2, "IndexOB": 0.1, "Object Index": 0.1, "IndexMA": 0.1, "Material Index": 0.1, "Normal": 0.5}
# The program's own names.
NAMES = {p.program: p.name for p in passes.PASSES}
# Numbers for each pixel by chance: they are for Cryptomatte nodes.
BY_CHANCE = ("Crypto",)
# What the first tree leaves to the second.
NOT_ALIKE = (*BY_CHANCE, "Denoising", "Debug", "Noisy")
# relMSE of small pictures that two denoisers have seen from opposite ends: corners of an even sky are up to a quarter off by both.
DENOISED = 3e-3
# What Cycles 5.2 has and Sundog tells that it leaves out.
# The depth of 5.3 begins at the camera, and ends at its clip plane.
LEFT_OUT = ("Denoising Roughness", "Denoising Specular Albedo", *(["Denoising Depth"] if bpy.app.version >= (5, 3, 0) else []))
# Passes that only Cycles' own switches ask for.
OWN_SWITCHES = ("use_pass_volume_direct", "use_pass_volume_indirect", "denoising_store_passes", "pass_debug_sample_count")


@unittest.skipUnless(FIVE, "names of passes and trees are those of Blender 5")
class Compositor(EngineTest):
    """One scene, one tree, and both engines."""

    def setUp(self):
        super().setUp()
        scene = self.for_both((WIDTH, HEIGHT), SAMPLES)
        scene.cycles.sample_clamp_indirect = scene.cycles.blur_glossy = 0
        for settings in (scene.cycles, scene.sundog):
            settings.caustics_reflective = settings.caustics_refractive = False
        scene.sundog.sample_clamp_indirect = scene.sundog.blur_glossy = 0
        layer = scene.view_layers[0]
        for p in passes.PASSES:
            for switch in (p.switch or "").split():
                if "." not in switch and hasattr(layer, switch):
                    setattr(layer, switch, True)
        aov = layer.aovs.add()
        aov.name = "mine"
        cube = bpy.data.objects["Cube"]
        cube.pass_index, cube.active_material.pass_index = 4, 7
        teller = cube.active_material.node_tree.nodes.new("ShaderNodeOutputAOV")
        teller.aov_name = "mine"
        teller.inputs["Color"].default_value = (0.7, 0.2, 0.4, 1)
        for frame, place in ((0, -0.4), (2, 0.5)):
            cube.location.x = place
            cube.keyframe_insert("location", frame=frame)
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.7, location=(1.5, -1.5, 0))
        glass = kit.material("glass", Transmission_Weight=1.0, Roughness=0.3)
        bpy.context.object.data.materials.append(glass)
        bpy.ops.mesh.primitive_plane_add(size=1, location=(-2, -1, 0.5), rotation=(math.radians(70), 0, 0.6))
        bpy.context.object.data.materials.append(kit.material("lamp", Emission_Color=(1, 0.6, 0.2, 1), Emission_Strength=2.0))
        scene.frame_set(1)

    def tree(self, scene):
        """An empty tree, and the node whose first input is the picture."""
        if FIVE:
            tree = scene.compositing_node_group = bpy.data.node_groups.new("all", "CompositorNodeTree")
            tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
            return tree, tree.nodes.new("NodeGroupOutput")
        scene.use_nodes = True
        scene.node_tree.nodes.clear()
        return scene.node_tree, scene.node_tree.nodes.new("CompositorNodeComposite")

    def sum_of(self, tree, sockets, end, scales=None, mattes=()):
        """The picture is the sum of all passes: light times its colour, and of some a scaled part; and of some mattes."""
        total = None
        scales = {**SCALES, **(scales or {})}
        by_name = {NAMES.get(s.name, s.name): s for s in sockets}
        for socket in sockets:
            name = NAMES.get(socket.name, socket.name)
            mix = tree.nodes.new("ShaderNodeMix")
            mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
            value = scales.get(name, 1.0)
            of = {s.identifier: s for s in mix.inputs}
            of["Factor_Float"].default_value = 1.0
            of["B_Color"].default_value = (value, value, value, 1)
            source = socket
            if name in {"Depth", "Denoising Depth"}:
                # Nothing is 1e10 away.
                least = tree.nodes.new("ShaderNodeMath")
                least.operation = "MINIMUM"
                least.inputs[1].default_value = 20.0
                tree.links.new(socket, least.inputs[0])
                source = least.outputs[0]
            tree.links.new(source, of["A_Color"])
            kind, _, part = name.rpartition(" ")
            if part in {"Direct", "Indirect"} and f"{kind} Color" in by_name:
                # Light times colour, as compositors take them.
                tree.links.new(by_name[f"{kind} Color"], of["B_Color"])
            scaled = next(s for s in mix.outputs if s.identifier == "Result_Color")
            total = scaled if total is None else self.added(tree, total, scaled)
        for layer, name in mattes:
            node = tree.nodes.new("CompositorNodeCryptomatteV2")
            node.source, node.scene = "RENDER", self.scene
            node.layer_name, node.matte_id = layer, name
            total = self.added(tree, total, node.outputs["Matte"])
        tree.links.new(total, end.inputs[0])

    @staticmethod
    def added(tree, total, socket):
        """The sum of two sockets."""
        add = tree.nodes.new("ShaderNodeMix")
        add.data_type, add.blend_type = "RGBA", "ADD"
        of = {s.identifier: s for s in add.inputs}
        of["Factor_Float"].default_value = 1.0
        tree.links.new(total, of["A_Color"])
        tree.links.new(socket, of["B_Color"])
        return next(s for s in add.outputs if s.identifier == "Result_Color")

    @staticmethod
    def used(node, but=NOT_ALIKE):
        """The sockets of a node's passes that both engines have alike, by name."""
        found = [s for s in node.outputs if s.enabled and s.name != "Alpha" and not s.name.startswith(but)]
        return sorted(found, key=lambda s: s.name)

    def composited(self, scene, name):
        image = scene.render.image_settings
        if hasattr(image, "media_type"):
            image.media_type = "IMAGE"
        image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGB", "32", "NONE"
        scene.view_settings.view_transform = "Raw"
        scene.render.filepath = os.path.join(self.folder, f"{name}.exr")
        with kit.quiet():
            bpy.ops.render.render(write_still=True, scene=scene.name)
        return kit.exr_pixels(scene.render.filepath)[..., :3].astype(float)

    def near(self, name, ours, theirs, error=1e-3):
        mean = abs(ours.mean() / theirs.mean() - 1)
        relative = ((ours - theirs) ** 2 / (theirs**2 + 0.01)).mean()
        print(f"{name}: mean {mean:.3%}, relMSE {relative:.1e}", flush=True)
        self.assertLess(mean, 0.01, name)
        self.assertLess(relative, error, name)

    def by_both_in_one_tree(self, least, but=NOT_ALIKE, scales=lambda engine: {}, mattes=(), error=1e-3):
        """The same tree of all passes but some for both engines: names of passes, and pictures near each other."""
        tree, end = self.tree(self.scene)
        node = tree.nodes.new("CompositorNodeRLayers")
        node.scene = self.scene
        found = {}
        for engine in ("SUNDOG", "CYCLES"):
            self.scene.render.engine = engine
            # Passes become sockets when the engine says which there are.
            self.scene.view_layers[0].update_render_passes()
            sockets = self.used(node, but)
            names = [s.name for s in sockets]
            self.assertGreaterEqual(len(names), least, names)
            self.sum_of(tree, sockets, end, scales(engine), mattes)
            found[engine] = (names, self.composited(self.scene, engine))
            for other in [n for n in tree.nodes if n not in (node, end)]:
                tree.nodes.remove(other)
        self.assertEqual(found["SUNDOG"][0], found["CYCLES"][0])
        print(f"{len(names)} passes and {len(mattes)} mattes:", ", ".join(found["SUNDOG"][0]), flush=True)
        self.near("the render result", found["SUNDOG"][1], found["CYCLES"][1], error)

    def test_every_pass_in_one_tree(self):
        self.by_both_in_one_tree(19)

    def test_passes_of_denoising_volumes_groups_and_mattes(self):
        """With all that the first tree leaves out: what Cycles' own switches ask for, denoised."""
        layer, scene = self.scene.view_layers[0], self.scene
        for name in OWN_SWITCHES:
            setattr(layer.cycles, name, True)
        layer.sundog.use_pass_sample_count = True
        scene.cycles.use_denoising = layer.cycles.use_denoising = True
        scene.sundog.denoising = "CYCLES"
        for name in ("key", "sky"):
            layer.lightgroups.add(name=name)
        bpy.data.objects["Light"].lightgroup, scene.world.lightgroup = "key", "sky"
        bpy.ops.mesh.primitive_cube_add(size=1.5, location=(-1.5, 1.5, 0.5))
        fog = bpy.data.materials.new("fog")
        if bpy.app.version < (5, 0, 0):
            fog.use_nodes = True
        tree = fog.node_tree
        tree.nodes.clear()
        scatter, out = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeOutputMaterial")
        scatter.inputs["Density"].default_value = 0.7
        tree.links.new(scatter.outputs[0], out.inputs["Volume"])
        bpy.context.object.data.materials.append(fog)
        scene.cycles.volume_bounces = scene.sundog.volume_bounces = 2
        mattes = [("ViewLayer.CryptoObject", "Cube"), ("ViewLayer.CryptoMaterial", "glass"), ("ViewLayer.CryptoAsset", "Plane")]
        # Cycles' count is a share of the most that a pixel has, Sundog's a number.
        scales = {"SUNDOG": {"Debug Sample Count": 1 / SAMPLES}, "CYCLES": {}}
        self.by_both_in_one_tree(29, (*BY_CHANCE, *LEFT_OUT), scales.get, mattes, DENOISED)

    def test_shadow_catchers_in_the_tree(self):
        """The pass of shadows, denoised, with the noisy ones beside it."""
        layer, scene = self.scene.view_layers[0], self.scene
        layer.cycles.use_pass_shadow_catcher = layer.cycles.denoising_store_passes = True
        scene.cycles.use_denoising = layer.cycles.use_denoising = True
        scene.sundog.denoising = "CYCLES"
        bpy.data.objects["Floor"].is_shadow_catcher = True
        # A part of them alone: what is behind catchers is otherwise than in Cycles (docs/cycles.md).
        for p in passes.PASSES:
            for switch in (p.switch or "").split():
                if "." not in switch and hasattr(layer, switch):
                    setattr(layer, switch, False)
        self.by_both_in_one_tree(4, (*BY_CHANCE, "Denoising", "mine"), error=DENOISED)

    @kit.long
    def test_every_pass_of_the_files(self):
        self.scene.render.engine = "CYCLES"
        self.render("cycles")
        self.scene.render.engine = "SUNDOG"
        ours = os.path.join(self.folder, "sundog.exr")
        with kit.quiet():
            found = kit.in_render(lambda depsgraph: kit.export.write_scene(depsgraph, depsgraph.scene, self.folder, self.folder))
        layer, abilities = self.scene.view_layers[0], program.abilities(self.program)
        line = [self.program, "render", found.path, "-o", ours, "--quiet", *command.arguments(self.scene, layer, abilities, self.fail)]
        line += command.pass_arguments(passes.wanted(self.scene, layer), abilities, layer, self.scene.world)
        subprocess.run(line, check=True)
        # The program's names are those of Blender 4.
        names = {p.program: p.name for p in passes.PASSES} | {"Combined": "Combined"}
        results = []
        for path, renamed in ((ours, names), (os.path.join(self.folder, "cycles.exr"), {})):
            scene = bpy.data.scenes.new("compositor")
            scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH, HEIGHT, 100
            scene.render.use_sequencer = False
            tree, end = self.tree(scene)
            node = tree.nodes.new("CompositorNodeImage")
            node.image = bpy.data.images.load(path)
            sockets = {renamed.get(s.name, s.name): s for s in self.used(node)}
            self.sum_of(tree, [sockets[name] for name in sorted(sockets)], end)
            camera = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
            scene.collection.objects.link(camera)
            scene.camera, scene.render.engine, scene.cycles.samples = camera, "CYCLES", 1
            results.append((sorted(sockets), self.composited(scene, f"of-{len(results)}")))
            bpy.data.scenes.remove(scene)
        self.assertEqual(results[0][0], results[1][0])
        self.near("the files", results[0][1], results[1][1])


if __name__ == "__main__":
    unittest.main()
