# SPDX-License-Identifier: GPL-3.0-or-later
"""Panoramas beside Cycles': pictures, and passes of data, of pictures that are not square; with a lens, and while things move."""

import math
import unittest

import bpy
import numpy

import export_kit as kit
from engine_kit import EngineTest

WIDTH, HEIGHT, SAMPLES = 48, 32, 256
FIVE = bpy.app.version >= (5, 0, 0)
DATA = ("Depth", "Normal", "Mist", "Position")


class Panoramas(EngineTest):
    """One scene by both engines."""

    def setUp(self):
        super().setUp()
        scene = self.for_both((WIDTH, HEIGHT), SAMPLES)
        scene.cycles.max_bounces = scene.sundog.max_bounces = 0
        layer = scene.view_layers[0]
        layer.use_pass_z = layer.use_pass_normal = layer.use_pass_mist = layer.use_pass_position = True
        scene.world.mist_settings.start, scene.world.mist_settings.depth = 1, 12
        lamp = bpy.data.objects["Light"]
        lamp.data.shadow_soft_size = 0
        # About the camera, so that each direction meets something else.
        for place, (x, y, z) in enumerate([(6, 0, 2), (-5, 2, 0), (1, -6, 3), (0, 7, 1), (2, 2, 6)]):
            bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=1.2, location=(x, y, z))
            tint = [(0.9, 0.1, 0.1), (0.1, 0.8, 0.2), (0.2, 0.3, 0.9), (0.9, 0.8, 0.1), (0.7, 0.2, 0.8)][place]
            bpy.context.object.data.materials.append(kit.material(f"ball {place}", Base_Color=(*tint, 1), Emission_Color=(*tint, 1), Emission_Strength=1.0))
        camera = scene.camera
        camera.location, camera.rotation_euler = (0.5, -1, 2.0), (math.radians(80), math.radians(10), math.radians(20))
        camera.data.type = "PANO"
        self.settings = camera.data if hasattr(camera.data, "panorama_type") else camera.data.cycles

    def compare(self, name, error=1e-3, layers=("Combined", *DATA)):
        found = []
        for engine in ("SUNDOG", "CYCLES"):
            self.scene.render.engine = engine
            found.append(self.render(engine))
        for layer in layers:
            ours, theirs = (passes[f"ViewLayer.{layer}"].astype(float) for passes in found)
            if layer == "Depth":
                # Of nothing there is none.
                self.assertLess(((ours > 1e9) != (theirs > 1e9)).mean(), 0.002, name)
                ours, theirs = (numpy.where(values > 1e9, 0, values) for values in (ours, theirs))
            mean = abs(ours.mean() - theirs.mean()) / numpy.abs(theirs).mean()
            relative = ((ours - theirs) ** 2 / (theirs**2 + 0.01)).mean()
            print(f"{name}, {layer}: mean {mean:.3%}, relMSE {relative:.1e}", flush=True)
            self.assertLess(mean, 0.01, f"{name} {layer}")
            # Rays through the middle alone: a pixel at an edge may see the one or the other.
            self.assertLess(relative, 0.01 if layer in {"Depth", "Position"} else error, f"{name} {layer}")

    def kind(self, kind, **settings):
        self.settings.panorama_type = kind
        for name, value in settings.items():
            setattr(self.settings, name, value)

    def test_fisheye_equisolid(self):
        self.kind("FISHEYE_EQUISOLID", fisheye_lens=9.0, fisheye_fov=2.6)
        self.compare("equisolid")

    def test_mirror_ball_with_a_lens(self):
        self.kind("MIRRORBALL")
        dof = self.scene.camera.data.dof
        dof.use_dof, dof.focus_distance, dof.aperture_fstop = True, 4, 0.4
        # Depths and places are of one ray, through a random point of the lens.
        self.compare("mirror ball", 3e-3, ("Combined", "Normal", "Mist"))

    @kit.long
    def test_all_kinds(self):
        kinds = {
            "FISHEYE_EQUIDISTANT": {"fisheye_fov": 4.0},
            "FISHEYE_EQUISOLID": {"fisheye_lens": 8.0, "fisheye_fov": 3.1},
            "FISHEYE_LENS_POLYNOMIAL": {"fisheye_fov": 2.8},
            "MIRRORBALL": {},
            "EQUIANGULAR_CUBEMAP_FACE": {},
            "EQUIRECTANGULAR": {"longitude_min": -2.0, "longitude_max": 1.5, "latitude_min": -0.6, "latitude_max": 1.2},
        }
        if bpy.app.version >= (5, 0, 0):
            kinds["CENTRAL_CYLINDRICAL"] = {
                "central_cylindrical_range_u_min": -1.2, "central_cylindrical_range_u_max": 2.0,
                "central_cylindrical_range_v_min": -1.5, "central_cylindrical_range_v_max": 1.0, "central_cylindrical_radius": 1.5,
            }  # fmt: skip
        for kind, settings in kinds.items():
            for shift in ((0, 0), (0.1, -0.06)):
                self.scene.camera.data.shift_x, self.scene.camera.data.shift_y = shift
                self.kind(kind, **settings)
                with self.subTest(kind=kind, shift=shift):
                    self.compare(f"{kind.lower()} shifted by {shift}")

    @kit.long
    def test_a_film_that_is_transparent_and_things_that_move(self):
        self.scene.render.film_transparent = True
        self.scene.sundog.samples = self.scene.cycles.samples = 2048
        self.scene.render.use_motion_blur = True
        camera = self.scene.camera
        for frame, turn in ((0, 0.2), (2, 0.5)):
            camera.rotation_euler[2] = turn
            camera.keyframe_insert("rotation_euler", frame=frame)
        self.scene.frame_set(1)
        self.kind("FISHEYE_EQUIDISTANT", fisheye_fov=3.0)
        self.compare("moving fisheye", 1e-3, ("Combined", "Normal", "Mist"))


if __name__ == "__main__":
    unittest.main()
