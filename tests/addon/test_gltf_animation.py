# SPDX-License-Identifier: GPL-3.0-or-later
"""Animations of files that Blender's own exporter writes: places of what is seen at a frame, beside Cycles'."""

import math
import os
import subprocess
import unittest

import bpy
import numpy

import exr
import export_kit as kit
from engine_kit import EngineTest

WIDTH, HEIGHT = 96, 64
FRAMES = (1, 9.5, 17, 30)


class Animation(EngineTest):
    """A node, a skin and morph targets that move."""

    def setUp(self):
        super().setUp()
        scene = self.scene
        scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
        scene.cycles.samples, scene.cycles.use_denoising = 1, False
        scene.view_layers[0].use_pass_position = True
        scene.frame_start, scene.frame_end = 0, 24
        cube = bpy.data.objects["Cube"]
        for frame, place, turn in ((0, (-2, 0, 0), 0.0), (12, (-1, 0.5, 0.5), 1.5), (24, (-1.5, -1, 0), 2.0)):
            cube.location, cube.rotation_euler = place, (turn / 2, 0, turn)
            cube.scale = (1, 1, 0.6 + frame / 30)
            for path in ("location", "rotation_euler", "scale"):
                cube.keyframe_insert(path, frame=frame)
        self.skinned()
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.8, location=(0.5, -2, 0))
        kit.stretches(bpy.context.object, 2, ((0, 0.0), (10, 1.0), (24, 0.2)))

    def skinned(self):
        """A post that a bone bends."""
        bpy.ops.object.armature_add(location=(2.5, 1, -1))
        rig = bpy.context.object
        bpy.ops.mesh.primitive_cylinder_add(radius=0.4, depth=2, location=(2.5, 1, 0))
        post = bpy.context.object
        post.parent, post.matrix_parent_inverse = rig, rig.matrix_world.inverted()
        post.modifiers.new("rig", "ARMATURE").object = rig
        post.vertex_groups.new(name="Bone").add(range(len(post.data.vertices)), 1.0, "REPLACE")
        bone = rig.pose.bones["Bone"]
        bone.rotation_mode = "QUATERNION"
        for frame, angle in ((0, 0.0), (24, 1.2)):
            bone.rotation_quaternion = (math.cos(angle / 2), math.sin(angle / 2), 0, 0)
            bone.keyframe_insert("rotation_quaternion", frame=frame)

    def test_places_at_frames(self):
        path = os.path.join(self.folder, "moving.glb")
        with kit.quiet():
            bpy.ops.export_scene.gltf(
                filepath=path, export_cameras=True, export_lights=True, export_animation_mode="ACTIVE_ACTIONS", export_force_sampling=True
            )  # fmt: skip
        self.scene.render.engine = "CYCLES"
        still = None
        for frame in FRAMES:
            # After its last key all stays where it is.
            shown = min(frame, 24)
            self.scene.frame_set(int(shown), subframe=shown % 1)
            theirs = self.render(f"cycles-{frame}")["ViewLayer.Position"].astype(float)
            ours = os.path.join(self.folder, f"{frame}.exr")
            command = [self.program, "render", path, "-o", ours, "--quiet", "--passes", "Position", "--samples", "1", "--exr-compression", "none"]
            command += ["--width", str(WIDTH), "--height", str(HEIGHT), "--frame", str(frame)]
            subprocess.run(command, check=True)
            ours = exr.passes(exr.read(ours))["Position"].astype(float)
            off = numpy.abs(ours - theirs).max(axis=-1)
            print(f"frame {frame}: {(off > 0.01).mean():.3%} of the pixels are more than 1 cm off, the median {numpy.median(off):.1e} m", flush=True)
            # What lies at edges may be the one or the other; keys stand at whole frames, between which lines go.
            self.assertLess((off > 0.01).mean(), 0.02 if frame % 1 else 0.005)
            still = ours if still is None else still
        self.assertGreater((numpy.abs(ours - still).max(axis=-1) > 0.05).mean(), 0.05)

    def test_what_there_is_not_is_told(self):
        path = os.path.join(self.folder, "moving.glb")
        with kit.quiet():
            bpy.ops.export_scene.gltf(filepath=path, export_cameras=True)
        failed = subprocess.run([self.program, "render", path, "-o", "x.exr", "--frame", "3", "--animation", "dance"], capture_output=True, text=True)
        self.assertNotEqual(failed.returncode, 0)
        self.assertIn('"dance"', failed.stderr)
        self.assertIn("there are: ", failed.stderr)
        failed = subprocess.run([self.program, "render", path, "-o", "x.exr", "--animation", "dance"], capture_output=True, text=True)
        self.assertIn("--frame", failed.stderr)


if __name__ == "__main__":
    unittest.main()
