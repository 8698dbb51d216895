# SPDX-License-Identifier: GPL-3.0-or-later
"""Stereo beside Cycles': the views of a picture, by every convergence, pivot and kind of camera."""

import math
import unittest

import bpy
import numpy

import export_kit as kit
from engine_kit import EngineTest

from sundog import engine

WIDTH, HEIGHT, SAMPLES = 64, 40, 64


class Stereo(EngineTest):
    def setUp(self):
        super().setUp()
        scene = self.for_both((WIDTH, HEIGHT), SAMPLES)
        scene.cycles.pixel_filter_type = "BOX"
        scene.cycles.sample_clamp_indirect, scene.cycles.blur_glossy = 0, 0
        scene.render.use_multiview, scene.render.views_format = True, "STEREO_3D"
        self.camera = scene.camera
        self.stereo = self.camera.data.stereo
        # A wide base, so that a wrong view is a wrong picture.
        self.stereo.interocular_distance, self.stereo.convergence_distance = 0.8, 6

    def views(self, suffixes):
        """The views of Sundog's files and of Cycles', each by two seeds."""
        found = {}
        for name, seed, _ in self.by_both():
            for suffix in suffixes:
                found[name, seed, suffix] = self.read(f"{name}{seed}{suffix}")["ViewLayer.Combined"][..., :3].astype(float)
        return found

    def compare(self, suffixes=("_L", "_R"), error=1e-3):
        found = self.views(suffixes)
        for suffix in suffixes:
            ours, theirs = ([found[name, seed, suffix] for seed in (1, 2)] for name in ("SUNDOG", "CYCLES"))
            reference = numpy.mean(theirs, axis=0)
            off = numpy.mean(ours) / reference.mean() - 1
            # Without noise: the product of two differences.
            relative = ((ours[0] - theirs[0]) * (ours[1] - theirs[1]) / (reference**2 + 0.01)).mean()
            print(f"{self.id().split('.')[-1]} {suffix}: mean {reference.mean():.4f}, off {off:+.3%}, relMSE {relative:.1e}", flush=True)
            self.assertLess(abs(off), 0.01)
            self.assertLess(relative, error)
        # The views are much less like each other than like Cycles'.
        apart = [found["SUNDOG", seed, suffixes[0]] - found["SUNDOG", seed, suffixes[1]] for seed in (1, 2)]
        apart = (apart[0] * apart[1] / (reference**2 + 0.01)).mean()
        self.assertGreater(apart, 10 * abs(relative))

    def test_off_axis(self):
        self.compare()

    @kit.long
    def test_each_convergence_and_pivot(self):
        for self.stereo.convergence_mode in ("OFFAXIS", "PARALLEL", "TOE"):
            for self.stereo.pivot in ("LEFT", "RIGHT", "CENTER"):
                print(self.stereo.convergence_mode, self.stereo.pivot, flush=True)
                self.compare()

    @kit.long
    def test_an_orthographic_camera(self):
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 8
        self.stereo.convergence_mode = "TOE"
        self.compare()

    def panorama(self, kind):
        self.camera.data.type, self.camera.data.panorama_type = "PANO", kind
        self.camera.location, self.camera.rotation_euler = (3, -3, 1), (math.pi / 2, 0, math.pi / 4)

    def test_a_panorama(self):
        self.panorama("EQUIRECTANGULAR")
        self.compare()

    def test_spherical_stereo(self):
        self.panorama("EQUIRECTANGULAR")
        self.stereo.use_spherical_stereo = True
        self.compare()

    @kit.long
    def test_spherical_stereo_of_other_kinds(self):
        self.stereo.use_spherical_stereo = self.stereo.use_pole_merge = True
        self.stereo.pole_merge_angle_from, self.stereo.pole_merge_angle_to = 0.2, 0.9
        for kind in ("EQUIRECTANGULAR", "FISHEYE_EQUIDISTANT", "MIRRORBALL", "CENTRAL_CYLINDRICAL"):
            self.panorama(kind)
            for self.stereo.convergence_mode in ("OFFAXIS", "PARALLEL"):
                print(kind, self.stereo.convergence_mode, flush=True)
                self.compare()

    @kit.long
    def test_views_by_cameras_of_their_own(self):
        render = self.scene.render
        render.views_format = "MULTIVIEW"
        for suffix, x in (("_L", 0.0), ("_R", 1.0)):
            data = self.camera.data.copy()
            data.lens = 40 + 20 * x
            made = bpy.data.objects.new(f"eye{suffix}", data)
            made.matrix_world = self.camera.matrix_world.copy()
            made.location.x += x
            self.scene.collection.objects.link(made)
        self.scene.camera = bpy.data.objects["eye_L"]
        self.compare()

    @kit.long
    def test_a_camera_that_moves(self):
        """Each view has the camera's motion."""
        self.scene.render.use_motion_blur, self.scene.render.motion_blur_shutter = True, 1
        self.camera.keyframe_insert("location", frame=0)
        self.camera.location.z += 0.6
        self.camera.keyframe_insert("location", frame=2)
        self.scene.frame_set(1)
        self.compare()

    def test_view_layers_and_a_file_of_all_views(self):
        """A layered file holds the views of every layer, by Blender's names."""
        self.scene.view_layers.new("second")
        image = self.scene.render.image_settings
        image.views_format = "MULTIVIEW"
        self.scene.sundog.samples = 4
        self.render("all")
        import exr

        channels = exr.passes(exr.read(f"{self.folder}/all.exr"))
        names = {name for name in channels if "Combined" in name}
        self.assertEqual(len(names), 4, names)
        self.assertEqual(engine.last_statistics()["warnings"], [])


if __name__ == "__main__":
    unittest.main()
