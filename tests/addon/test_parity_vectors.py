# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion vectors beside Cycles': objects, vertices, the camera and the world, in perspective, parallel and of a panorama."""

import math
import unittest

import bpy
import numpy

import export_kit as kit
from engine_kit import EngineTest

# From 5.3 on the world counts as nothing: few samples say what edges have.
OBJECTS_ALONE = bpy.app.version >= (5, 3, 0)
WIDTH, HEIGHT, SAMPLES = 48, 32, 2048 if OBJECTS_ALONE else 256


@unittest.skipUnless(bpy.app.version >= (5, 2, 0), "Cycles 4.5 leaves the world out: pixels at edges have the motion of what is before it")
class Vectors(EngineTest):
    """One scene by both engines."""

    def setUp(self):
        super().setUp()
        scene = self.for_both((WIDTH, HEIGHT), SAMPLES)
        scene.cycles.max_bounces = scene.sundog.max_bounces = 0
        scene.view_layers[0].use_pass_vector = True
        cube = bpy.data.objects["Cube"]
        self.key(cube, "location", (-1, 0, 0), (-0.6, 0.1, 0.2), (0, 0.3, 0.1))
        self.key(cube, "rotation_euler", (0, 0, 0), (0, 0.2, 0.1), (0.1, 0.3, 0.4))
        # One whose vertices move; and a veil that is passed.
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.9, location=(2, 1, 0))
        kit.stretches(bpy.context.object, 1.8, ((0, 0.0), (1, 0.3), (2, 1.0)))
        for place, alpha in enumerate((0.3, 0.8)):
            bpy.ops.mesh.primitive_plane_add(size=1.3, location=(2.3 - place, -2.6 - place, 0.9), rotation=(math.radians(70), 0, 0.6))
            veil = bpy.context.object
            veil.data.materials.append(kit.material(f"veil {place}", Alpha=alpha))
            self.key(veil, "location", tuple(veil.location), tuple(veil.location), (veil.location.x, veil.location.y, 0.6))
        scene.frame_set(1)

    @staticmethod
    def key(thing, path, *values):
        for frame, value in enumerate(values):
            setattr(thing, path, value)
            thing.keyframe_insert(path, frame=frame)

    def move_camera(self):
        camera = self.scene.camera
        turn, place = tuple(camera.rotation_euler), tuple(camera.location)
        self.key(camera, "rotation_euler", turn, (turn[0], turn[1], turn[2] + 0.02), (turn[0] + 0.03, turn[1], turn[2] + 0.05))
        self.key(camera, "location", place, (place[0], place[1] + 0.1, place[2]), (place[0] + 0.2, place[1], place[2]))
        self.scene.frame_set(1)

    def compare(self, name):
        found = []
        for engine in ("SUNDOG", "CYCLES"):
            self.scene.render.engine = engine
            found.append(self.render(engine))
        ours, theirs = (passes["ViewLayer.Vector"].astype(float) for passes in found)
        self.assertEqual(ours.shape, theirs.shape)
        # At the edge of a fisheye's circle few samples see anything, or none.
        has_edges = self.scene.camera.data.type == "PANO" or OBJECTS_ALONE
        self.assertLess(has_edges * (ours.any(axis=-1) != theirs.any(axis=-1)).mean(), 0.02 if OBJECTS_ALONE else 0.01, name)
        seen = (ours.any(axis=-1) & theirs.any(axis=-1)) if has_edges else numpy.ones(ours.shape[:2], bool)
        ours, theirs = ours[seen], theirs[seen]
        mean = numpy.abs(ours.mean(axis=0) - theirs.mean(axis=0)).max() / numpy.abs(theirs).mean()
        relative = ((ours - theirs) ** 2 / (theirs**2 + 0.01)).mean()
        print(f"{name}: mean {mean:.3%}, relMSE {relative:.1e}, pixels {numpy.abs(theirs).mean():.2f}", flush=True)
        self.assertGreater(numpy.abs(theirs).mean(), 0.05)
        self.assertLess(mean, 0.01, name)
        self.assertLess(relative, 1e-3, name)

    def test_objects_and_vertices(self):
        self.compare("objects and vertices")

    def test_a_camera_that_moves_and_zooms(self):
        self.move_camera()
        camera = self.scene.camera.data
        self.key(camera, "lens", 48, 50, 53)
        self.scene.frame_set(1)
        self.compare("camera")

    def test_parallel_rays_and_panoramas(self):
        self.move_camera()
        camera = self.scene.camera.data
        camera.type, camera.ortho_scale = "ORTHO", 8
        self.compare("orthographic")
        camera.type = "PANO"
        settings = camera if hasattr(camera, "panorama_type") else camera.cycles
        settings.panorama_type = "FISHEYE_EQUISOLID"
        self.compare("fisheye")


if __name__ == "__main__":
    unittest.main()
