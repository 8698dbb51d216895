# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera against Blender's own projection matrix, and colour management."""

import math
import unittest

import bpy
import export_kit as kit
import numpy
from mathutils import Matrix


class Camera(kit.ExportTest):
    """SUNDOG_camera."""

    def written(self):
        self.found = self.export()
        node = self.found.node("camera")
        self.plain = self.found["cameras"][node["camera"]]
        return self.plain["extensions"]["SUNDOG_camera"]

    def blenders_window(self):
        """The window by the projection matrix that Blender itself shows the viewport with."""
        render = self.scene.render
        m = numpy.array(
            self.camera.calc_matrix_camera(
                bpy.context.evaluated_depsgraph_get(),
                x=int(render.resolution_x * render.resolution_percentage / 100),
                y=int(render.resolution_y * render.resolution_percentage / 100),
                scale_x=render.pixel_aspect_x,
                scale_y=render.pixel_aspect_y,
            )
        )
        result = []
        for row in (0, 1):
            for edge in (-1, 1):
                if self.camera.data.type == "ORTHO":
                    result.append((edge - m[row, 3]) / m[row, row])
                else:
                    # x / -z with clip x = m00 x + m02 z and w = -z.
                    result.append((edge + m[row, 2]) / m[row, row])
        return result

    def test_sensor_fit_shift_and_aspect(self):
        data, render = self.camera.data, self.scene.render
        for kind in ("PERSP", "ORTHO"):
            for fit in ("AUTO", "HORIZONTAL", "VERTICAL"):
                for size in ((160, 90), (90, 160), (100, 100)):
                    for aspect in ((1, 1), (2, 1), (1, 1.5)):
                        data.type, data.sensor_fit = kind, fit
                        data.lens, data.sensor_width, data.sensor_height, data.ortho_scale = 40, 32, 18, 7
                        data.shift_x, data.shift_y = 0.2, -0.1
                        render.resolution_x, render.resolution_y = size
                        render.pixel_aspect_x, render.pixel_aspect_y = aspect
                        with self.subTest(kind=kind, fit=fit, size=size, aspect=aspect):
                            self.near(self.written()["window"], self.blenders_window(), 1e-5)

    def test_resolution_percentage(self):
        render = self.scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = 101, 57, 50
        # 50 × 28 pixels: not the aspect of 101 × 57.
        self.near(self.written()["window"], self.blenders_window(), 1e-5)

    def test_plain_gltf_camera(self):
        self.scene.render.resolution_x, self.scene.render.resolution_y = 200, 100
        self.camera.data.lens, self.camera.data.sensor_width = 18, 36
        self.written()
        self.near(self.plain["perspective"]["yfov"], 2 * math.atan(0.5))
        self.near(self.plain["perspective"]["aspectRatio"], 2)
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 6
        self.written()
        self.near([self.plain["orthographic"][k] for k in ("xmag", "ymag")], [3, 1.5])

    def test_place_without_scale(self):
        self.camera.matrix_world = Matrix.LocRotScale((1, 2, 3), Matrix.Rotation(0.5, 3, "Y"), (2, 3, -4))
        bpy.context.view_layer.update()
        self.written()
        got = self.found.matrix(self.found.node("camera"))
        self.near(got[:3, 3], [1, 3, -2])
        self.near(numpy.linalg.norm(got[:3, :3], axis=0), [1, 1, 1])

    def test_clip(self):
        self.camera.data.clip_start, self.camera.data.clip_end = 0.25, 64
        self.near(self.written()["clip"], [0.25, 64])

    def test_depth_of_field(self):
        data = self.camera.data
        self.assertNotIn("aperture", self.written())
        data.dof.use_dof = True
        data.lens, data.dof.aperture_fstop, data.dof.focus_distance = 50, 2, 3.5
        data.dof.aperture_blades, data.dof.aperture_rotation, data.dof.aperture_ratio = 6, 0.3, 2
        got = self.written()["aperture"]
        # The diameter is the focal length by the f-stop.
        self.near(got["radius"], 0.050 / 2 / 2)
        self.near([got["blades"], got["rotation"], got["ratio"], got["focus_distance"]], [6, 0.3, 2, 3.5])
        data.type = "ORTHO"
        self.near(self.written()["aperture"]["radius"], 1 / 2 / 2)

    def test_focus_object(self):
        target = self.link("target", None, location=(5, 1, 4))
        data = self.camera.data
        data.dof.use_dof, data.dof.focus_object = True, target
        # The camera at (0, 0, 10) looks down: the distance is along its axis.
        self.near(self.written()["aperture"]["focus_distance"], 6)
        target.location.z = 8
        self.near(self.written()["aperture"]["focus_distance"], 2)

    def test_focus_bone(self):
        bones = bpy.data.armatures.new("bones")
        rig = self.link("rig", bones, location=(0, 0, 1))
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        bone = bones.edit_bones.new("bone")
        bone.head, bone.tail = (0, 0, 2), (0, 1, 2)
        bpy.ops.object.mode_set(mode="OBJECT")
        dof = self.camera.data.dof
        dof.use_dof, dof.focus_object, dof.focus_subtarget = True, rig, "bone"
        self.near(self.written()["aperture"]["focus_distance"], 10 - 3)

    def test_panorama(self):
        data = self.camera.data
        data.type = "PANO"
        settings = data if hasattr(data, "panorama_type") else data.cycles
        settings.panorama_type = "EQUIRECTANGULAR"
        settings.longitude_min, settings.longitude_max = -1, 2
        settings.latitude_min, settings.latitude_max = -0.5, 1.25
        got = self.written()["panorama"]
        self.assertEqual(got["type"], "equirectangular")
        self.near(got["longitude"], [-1, 2])
        self.near(got["latitude"], [-0.5, 1.25])
        settings.panorama_type, settings.fisheye_fov, data.shift_x = "FISHEYE_EQUIDISTANT", 2.5, 0.25
        got = self.written()["panorama"]
        self.assertEqual((got["type"], got["fov"], got["shift"]), ("fisheye_equidistant", 2.5, [0.25, 0.0]))

    def test_camera_with_unit_scale_does_not_move(self):
        self.scene.unit_settings.scale_length = 0.01
        self.written()
        self.near(self.found.matrix(self.found.node("camera"))[:3, 3], [0, 10, 0])

    def test_camera_by_marker(self):
        other = self.link("other", bpy.data.cameras.new("other"))
        self.scene.timeline_markers.new("m", frame=1).camera = other
        self.scene.frame_set(1)
        found = self.export()
        self.assertEqual([n["name"] for n in found["nodes"] if "camera" in n], ["other"])

    def test_hidden_camera(self):
        self.camera.hide_render = True
        self.assertIn("window", self.written())


class Others(kit.ExportTest):
    """A scene that looks through an object that is no camera."""

    def through(self, data):
        """The SUNDOG_camera of an object with that data as the scene's camera."""
        made = self.link("eye", data, location=(0, 0, 10))
        self.scene.camera = made
        found = self.export()
        node = next(node for node in found.nodes("eye") if "camera" in node)
        bpy.data.objects.remove(made)
        return found, found["cameras"][node["camera"]]["extensions"]["SUNDOG_camera"]

    def test_a_mesh_an_empty_and_lamps(self):
        render = self.scene.render
        render.resolution_x, render.resolution_y = 80, 40
        spot = bpy.data.lights.new("spot", "SPOT")
        spot.spot_size = 1.0
        own = 35 if bpy.app.version >= (5, 3, 0) else 50
        for data, lens in (
            (None, own),
            (bpy.data.meshes.new("mesh"), own),
            (bpy.data.curves.new("curve", "CURVE"), own),
            (spot, 16 / math.tan(0.5)),
            (bpy.data.lights.new("point", "POINT"), 16 / math.tan(math.radians(22.5))),
        ):
            with self.subTest(data=data):
                half = 18 / lens
                found, got = self.through(data)
                self.near(got["window"], [-half, half, -half / 2, half / 2], 1e-6)
                self.near(got["clip"], [1e-5, 1e5])
                verdict = found.verdict("camera", "eye")
                is_point = data is not None and data.name == "point"
                self.assertEqual(verdict["verdict"], "approximated" if is_point else "exact", verdict)

    def test_cycles_sees_the_same(self):
        glow = kit.material("glow", Base_Color=(0, 0, 0, 1), Emission_Color=(1, 1, 1, 1), Emission_Strength=1)
        mesh = kit.plane("plane", 3)
        mesh.materials.append(glow)
        self.link("plane", mesh)
        spot = bpy.data.lights.new("spot", "SPOT")
        spot.energy, spot.spot_size = 0, 0.8
        for data in (bpy.data.meshes.new("mesh"), spot):
            made = self.link("eye", data, location=(0, 0, 6), scale=(2, 2, 2))
            self.scene.camera = made
            expected = kit.cycles_pixels(32, 32, 16)
            got = kit.rendered(self.export().path, 32, 32, 16)
            self.assertGreater(expected.mean(), 0.1)
            self.near(got.mean(), expected.mean(), 0.01)
            bpy.data.objects.remove(made)


class Colours(kit.ExportTest):
    """The scene's view transform, and its render settings."""

    def test_view(self):
        view = self.scene.view_settings
        self.scene.display_settings.display_device = "sRGB"
        view.view_transform = "Filmic"
        view.look = "High Contrast"
        view.exposure, view.gamma = 1.5, 0.75
        got = self.export().scene()["color_management"]
        self.assertEqual((got["display"], got["view"]), ("sRGB", "Filmic"))
        self.assertIn("High Contrast", got["look"])
        self.near([got["exposure"], got["gamma"]], [1.5, 0.75])
        self.assertTrue(got["config"].endswith("config.ocio"))

    def test_render(self):
        render = self.scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = 200, 100, 50
        render.film_transparent = True
        render.filter_size = 1.5
        self.scene.cycles.filter_width = 2.0
        got = self.export().scene()["render"]
        self.assertEqual((got["width"], got["height"], got["transparent"]), (100, 50, True))
        self.near(got["filter_width"], 2.0)


if __name__ == "__main__":
    unittest.main()
