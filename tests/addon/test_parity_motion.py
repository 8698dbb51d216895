# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur beside Cycles', and what the add-on writes of it."""

import math
import os

import bpy
import export_kit as kit
import numpy

WIDTH = HEIGHT = 48
SAMPLES = 128
# Greatest difference of means, and relMSE.
MEAN, RELATIVE = 0.01, 1e-3


def keyed(thing, path, *places):
    """Keys (frame, value) that are joined by lines."""
    for frame, value in places:
        setattr(thing, path, value)
        thing.keyframe_insert(path, frame=frame)
    for curve in kit.curves_of(thing.id_data.animation_data.action):
        curve.extrapolation = "LINEAR"
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"


class Motion(kit.ExportTest):
    """Things that move while the shutter is open."""

    def setUp(self):
        super().setUp()
        kit.sun_and_grey_world(self.scene)
        self.scene.render.engine = "CYCLES"
        self.scene.render.resolution_x = self.scene.render.resolution_y = WIDTH
        self.scene.render.resolution_percentage = 100
        self.camera.location = (0, 0, 6)
        self.scene.render.use_motion_blur = True
        self.scene.render.motion_blur_shutter = 0.8
        floor = kit.plane("floor", 40)
        floor.materials.append(kit.material("grey", Base_Color=(0.5, 0.45, 0.4, 1), Roughness=1.0))
        self.link("floor", floor, location=(0, 0, -1.5))
        self.scene.frame_set(5)

    def shown(self, name="thing", mesh=None):
        """An object with a colour of its own."""
        mesh = mesh or kit.cube(size=1.4)
        mesh.materials.append(kit.material(name, Base_Color=(0.8, 0.2, 0.1, 1), Roughness=0.6))
        return self.link(name, mesh)

    def compare(self, name, samples=SAMPLES):
        """By both: two pictures each by other seeds, so that the product of two differences is without noise."""
        self.scene.frame_set(5)
        found = self.export()
        self.assertEqual(self.scene.frame_current + self.scene.frame_subframe, 5)
        mine, theirs = [], []
        for seed in (1, 2):
            self.scene.cycles.seed = seed
            theirs.append(kit.cycles_pixels(WIDTH, HEIGHT, samples))
            mine.append(kit.rendered(found.path, WIDTH, HEIGHT, samples, "--seed", str(seed)))
        reference = numpy.mean(theirs, axis=0)
        product = (mine[0] - theirs[0]) * (mine[1] - theirs[1])
        error = (product / (reference**2 + 0.01)).mean()
        mean = abs(numpy.mean(mine) / numpy.mean(theirs) - 1)
        if os.environ.get("KEEP"):
            numpy.save(os.path.join(os.environ["KEEP"], f"{name}.npy"), numpy.stack([*mine, *theirs]))
        print(f"{name}: mean {mean:.3%}, relMSE {error:.2e}", flush=True)
        lost = [v for v in found.result.verdicts if v["verdict"] == "lost"]
        self.assertFalse(lost)
        self.assertLess(mean, MEAN, name)
        self.assertLess(abs(error), RELATIVE, name)
        return found

    def test_objects(self):
        thing = self.shown()
        keyed(thing, "location", (4, (-1.2, -0.3, 0)), (5, (0, 0.2, 0.2)), (6, (1.4, 0.1, 0)))
        found = self.compare("translation")
        steps = found.node("thing")["extensions"]["SUNDOG_object"]["motion"]
        self.assertEqual(len(steps), 3)
        # A shutter of 0.8 about the frame: 0.4 of the way to either side.
        self.near([steps[0][12], steps[1][12], steps[2][12]], [-0.48, 0, 0.56], 1e-5)
        self.assertNotIn("motion", str(found.node("floor")))
        for position, ends in (("START", (0, 1.12)), ("END", (-0.96, 0))):
            holder = self.scene.render if hasattr(self.scene.render, "motion_blur_position") else self.scene.cycles
            holder.motion_blur_position = position
            found = self.compare(f"position {position}")
            steps = found.node("thing")["extensions"]["SUNDOG_object"]["motion"]
            self.near([steps[0][12], steps[2][12]], ends, 1e-5)
        thing.cycles.use_motion_blur = False
        self.assertNotIn("motion", str(self.compare("switched off").node("thing")))

    def test_rotation_and_scale(self):
        thing = self.shown()
        thing.cycles.motion_steps = 3
        keyed(thing, "rotation_euler", (4, (0, 0, 0)), (6, (1.0, 2.0, 3.0)))
        found = self.compare("rotation")
        self.assertEqual(len(found.node("thing")["extensions"]["SUNDOG_object"]["motion"]), 9)
        keyed(thing, "scale", (4, (0.4, 1.5, 1)), (6, (1.8, -0.5, 1)))
        self.compare("rotation and scale")

    def test_cameras(self):
        self.shown()
        keyed(self.camera, "location", (4, (-1, 0, 6)), (6, (1, 0.6, 5)))
        keyed(self.camera, "rotation_euler", (4, (0, 0.1, -0.3)), (6, (0.1, -0.1, 0.4)))
        found = self.compare("camera")
        self.assertEqual(len(found["cameras"][0]["extensions"]["SUNDOG_camera"]["motion"]["matrices"]), 3)
        keyed(self.camera.data, "lens", (4, 40.0), (6, 80.0))
        found = self.compare("camera and lens")
        self.assertIn("zoom", found["cameras"][0]["extensions"]["SUNDOG_camera"]["motion"])
        self.camera.data.dof.use_dof, self.camera.data.dof.aperture_fstop, self.camera.data.dof.focus_distance = True, 0.1, 4.0
        self.compare("camera with a lens")

    def test_deformation(self):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.9)
        ball = bpy.context.object
        ball.data.shade_smooth()
        ball.data.materials.append(kit.material("ball", Base_Color=(0.2, 0.6, 0.3, 1), Roughness=0.5))
        ball.shape_key_add(name="Basis")
        bent = ball.shape_key_add(name="bent")
        for point in bent.data:
            x, y, z = point.co
            point.co = (x * 1.6 + 0.5 * y, y * 0.7, z * 0.8)
        keyed(bent, "value", (4, 0.0), (5, 0.5), (6, 1.0))
        found = self.compare("shape keys")
        mesh = found["meshes"][found.node(ball.name)["mesh"]]
        self.assertEqual(len(mesh["primitives"][0]["extensions"]["SUNDOG_mesh"]["motion"]), 3)
        keyed(ball, "location", (4, (-1, 0, 0)), (6, (1, 0.4, 0)))
        self.compare("shape keys of an object that moves")
        ball.cycles.use_deform_motion = False
        found = self.compare("shape keys, switched off")
        self.assertNotIn("_POSITION_0", str(found["meshes"]))

    def test_shutters(self):
        thing = self.shown()
        keyed(thing, "location", (4, (-1.8, 0, 0)), (6, (1.8, 0, 0)))
        curve = self.scene.render.motion_blur_shutter_curve
        points = curve.curves[0].points
        points[0].location, points[-1].location = (0, 0), (1, 1)
        curve.update()
        found = self.compare("curve")
        self.assertEqual(len(found.scene()["shutter"]["curve"]), 256)
        self.scene.cycles.rolling_shutter_type, self.scene.cycles.rolling_shutter_duration = "TOP", 0.2
        self.compare("curve and rolling shutter")
        points[0].location, points[-1].location = (0, 1), (1, 1)
        curve.update()
        found = self.compare("rolling shutter")
        self.assertEqual(found.scene()["shutter"], {"rolling": self.near_float(0.2, found.scene()["shutter"]["rolling"])})
        self.scene.cycles.rolling_shutter_duration = 0.0
        self.compare("rolling shutter at once")

    def near_float(self, expected, found):
        """The number found, if it is about what is expected."""
        self.assertAlmostEqual(expected, found, 6)
        return found

    def test_lights(self):
        """Lamps stand still, emissive meshes move; both light the floor."""
        lamp = bpy.data.lights.new("lamp", "AREA")
        lamp.energy, lamp.size = 100, 0.5
        made = self.link("lamp", lamp)
        keyed(made, "location", (4, (-2, 0, 1)), (6, (2, 0, 1)))
        self.compare("lamp")
        panel = kit.plane("panel", 0.8)
        shine = kit.material("shine", Emission_Strength=12.0, Emission_Color=(1, 0.8, 0.5, 1))
        panel.materials.append(shine)
        panel = self.link("panel", panel)
        keyed(panel, "location", (4, (-2, 1, 0)), (6, (2, -1, 0)))
        keyed(panel, "rotation_euler", (4, (math.pi, 0.5, 0)), (6, (math.pi, -0.5, 2)))
        self.compare("emissive mesh")

    def test_instances(self):
        """Copies of a collection that moves as a whole, one of which is turned."""
        thing = self.shown(mesh=kit.cube(size=0.6))
        group = bpy.data.collections.new("group")
        group.objects.link(thing)
        self.scene.collection.objects.unlink(thing)
        keyed(thing, "rotation_euler", (4, (0, 0, 0)), (6, (0, 0.5, 1.5)))
        for number in range(3):
            holder = self.link(f"holder {number}", None, instance_type="COLLECTION", instance_collection=group)
            keyed(holder, "location", (4, (number - 1.5, -0.5, 0)), (6, (number - 0.5, 0.5 * number, 0)))
        found = self.compare("copies of a collection")
        self.assertEqual(len(found.nodes("thing")), 3)

    def test_an_armature(self):
        mesh = kit.cube(size=1.2)
        thing = self.shown(mesh=mesh)
        bones = bpy.data.armatures.new("bones")
        rig = self.link("rig", bones)
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        bone = bones.edit_bones.new("bone")
        bone.head, bone.tail = (0, 0, -0.6), (0, 0, 0.6)
        bpy.ops.object.mode_set(mode="OBJECT")
        thing.vertex_groups.new(name="bone").add([v.index for v in mesh.vertices if v.co.z > 0], 1.0, "REPLACE")
        thing.modifiers.new("bones", "ARMATURE").object = rig
        pose = rig.pose.bones["bone"]
        pose.rotation_mode = "XYZ"
        for frame, angle in ((4, -0.6), (6, 0.8)):
            pose.rotation_euler = (angle, 0, angle)
            pose.keyframe_insert("rotation_euler", frame=frame)
        thing.cycles.motion_steps = 2
        self.compare("armature")

    def test_a_mesh_that_changes_stands_still(self):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24)
        thing = bpy.context.object
        modifier = thing.modifiers.new("build", "BUILD")
        modifier.frame_start, modifier.frame_duration = 1, 10
        thing.shape_key_add(name="Basis")
        moved = thing.shape_key_add(name="moved")
        for point in moved.data:
            point.co.x += 1
        keyed(moved, "value", (4, 0.0), (6, 1.0))
        self.scene.frame_set(5)
        found = self.export()
        told = found.verdict("object", thing.name)
        self.assertIn("their number changes", told["detail"])
