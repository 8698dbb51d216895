# SPDX-License-Identifier: GPL-3.0-or-later
"""Geometry: what the modifiers make, corner by corner, and when it is written."""

import math
import os
import unittest

import bpy
import export_kit as kit
import numpy
from sundog.export import geometry


class Kinds(kit.ExportTest):
    """Every kind of object that has faces."""

    def only(self, found):
        """Triangles of the one object."""
        self.assertEqual(len(found.names()), 1, found.names())
        return found.triangles(found.node(found.names()[0]))

    def area(self, triangles):
        a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
        return numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1).sum() / 2

    def test_cube(self):
        self.link("cube", kit.cube())
        triangles = self.only(self.export())
        self.assertEqual(len(triangles), 12)
        self.near(self.area(triangles), 24)
        # Counter-clockwise from outside.
        normals = numpy.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        self.assertTrue(((normals * triangles.mean(axis=1)).sum(axis=1) > 0).all())

    def test_modifiers(self):
        made = self.link("row", kit.plane())
        array = made.modifiers.new("array", "ARRAY")
        array.count = 3
        array.relative_offset_displace = (2, 0, 0)
        thick = made.modifiers.new("solid", "SOLIDIFY")
        thick.thickness, thick.offset = 0.5, 0
        off = made.modifiers.new("off", "ARRAY")
        off.show_render = False
        triangles = self.only(self.export())
        self.assertEqual(len(triangles), 3 * 12)
        self.near(self.area(triangles), 3 * (2 * 4 + 4 * 2 * 0.5), 1e-5)

    def test_subdivision_has_the_levels_of_renders(self):
        made = self.link("plane", kit.plane())
        modifier = made.modifiers.new("subdivision", "SUBSURF")
        modifier.subdivision_type = "SIMPLE"
        modifier.levels, modifier.render_levels = 1, 3
        self.assertEqual(len(self.only(self.export())), 2 * 4**3)
        self.assertEqual(modifier.levels, 1)

    def test_text(self):
        text = bpy.data.curves.new("text", "FONT")
        text.body = "II"
        text.extrude = 0.1
        self.link("text", text)
        triangles = self.only(self.export())
        self.assertGreater(len(triangles), 20)
        self.near(numpy.ptp(triangles[..., 2]), 0.2, 1e-5)

    def test_curve_with_bevel(self):
        curve = bpy.data.curves.new("curve", "CURVE")
        curve.dimensions = "3D"
        spline = curve.splines.new("POLY")
        spline.points.add(1)
        spline.points[0].co, spline.points[1].co = (0, 0, 0, 1), (0, 0, 5, 1)
        curve.bevel_depth, curve.bevel_resolution = 0.5, 14
        self.link("curve", curve)
        triangles = self.only(self.export())
        # A polygon of 2 · (14 + 2) · 2 sides is less than a thousandth shorter than the circle.
        self.near(self.area(triangles), 2 * math.pi * 0.5 * 5, 5e-3)

    def test_curve_without_faces(self):
        curve = bpy.data.curves.new("curve", "CURVE")
        curve.splines.new("POLY").points.add(2)
        self.link("curve", curve)
        self.assertEqual(self.export().names(), [])

    def test_nurbs_surface(self):
        surface = bpy.data.curves.new("surface", "SURFACE")
        for row in range(4):
            spline = surface.splines.new("NURBS")
            spline.points.add(3)
            for column, point in enumerate(spline.points):
                point.co = (row, column, 0, 1)
        for spline in surface.splines:
            for point in spline.points:
                point.select = True
        made = self.link("surface", surface)
        bpy.context.view_layer.objects.active = made
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.curve.make_segment()
        bpy.ops.object.mode_set(mode="OBJECT")
        for spline in surface.splines:
            spline.use_endpoint_u = spline.use_endpoint_v = True
        self.near(self.area(self.only(self.export())), 9, 1e-5)

    def test_metaballs(self):
        ball = bpy.data.metaballs.new("ball")
        ball.elements.new().co = (0, 0, 0)
        ball.render_resolution, ball.resolution = 0.1, 0.5
        self.link("ball", ball)
        second = bpy.data.metaballs.new("ball")
        second.elements.new().co = (1.2, 0, 0)
        # Of a family ("ball", "ball.001") the first shows all.
        self.link("ball.001", second)
        found = self.export()
        triangles = self.only(found)
        self.assertGreater(len(triangles), 200)
        self.assertGreater(numpy.ptp(triangles[..., 0]), numpy.ptp(triangles[..., 1]) + 0.5)

    def test_shape_keys(self):
        made = self.link("plane", kit.plane())
        made.shape_key_add(name="Basis")
        key = made.shape_key_add(name="up")
        for point in key.data:
            point.co.z += 4
        key.value = 0.25
        self.near(self.only(self.export())[..., 2], numpy.ones((2, 3)))

    def test_armature(self):
        bones = bpy.data.armatures.new("bones")
        rig = self.link("rig", bones)
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        bone = bones.edit_bones.new("bone")
        bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
        bpy.ops.object.mode_set(mode="OBJECT")
        made = self.link("skin", kit.plane())
        made.vertex_groups.new(name="bone").add([0, 1, 2, 3], 1.0, "REPLACE")
        made.modifiers.new("armature", "ARMATURE").object = rig
        # A bone's own Y is its length: here the world's Z.
        rig.pose.bones["bone"].location = (0, 3, 0)
        self.near(self.only(self.export())[..., 2], numpy.full((2, 3), 3.0))

    def test_empty_mesh(self):
        self.link("empty", bpy.data.meshes.new("empty"))
        points = bpy.data.meshes.new("points")
        points.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
        self.link("points", points)
        self.assertEqual(self.export().names(), [])

    def test_polygons_with_many_corners(self):
        count = 500
        angles = numpy.arange(count) * 2 * math.pi / count
        mesh = bpy.data.meshes.new("disc")
        mesh.from_pydata([(math.cos(a), math.sin(a), 0) for a in angles], [], [tuple(range(count))])
        self.link("disc", mesh)
        self.near(self.area(self.only(self.export())), count / 2 * math.sin(2 * math.pi / count), 1e-5)

    def test_huge_mesh(self):
        self.link("huge", kit.cube())
        self.addCleanup(setattr, geometry, "MOST_CORNERS", geometry.MOST_CORNERS)
        geometry.MOST_CORNERS = 23
        found = self.export()
        self.assertEqual(found.names(), [])
        self.assertIn("24 face corners", found.verdict("object", "huge")["detail"])

    def test_vertices_that_are_no_numbers(self):
        mesh = kit.cube()
        mesh.vertices[3].co.x = math.nan
        self.link("broken", mesh)
        self.link("whole", kit.cube())
        found = self.export()
        self.assertEqual(found.names(), ["whole"])
        verdict = found.verdict("object", "broken")
        self.assertEqual(verdict["verdict"], "lost")
        self.assertIn("not a number", verdict["detail"])

    def test_faces_of_vertices_that_do_not_exist(self):
        mesh = kit.cube()
        mesh.loops[5].vertex_index = 77
        self.link("broken", mesh)
        found = self.export()
        self.assertEqual(found.names(), [])
        self.assertIn("do not exist", found.verdict("object", "broken")["detail"])


class Corners(kit.ExportTest):
    """Normals, UV maps, colours and materials by corner."""

    def primitive(self, found, number=0):
        return found["meshes"][0]["primitives"][number]

    def attribute(self, found, name, number=0):
        return found.array(self.primitive(found, number)["attributes"][name])

    def with_uv(self, name=None):
        """A material with an image texture by that UV map."""
        made = kit.material("textured")
        tree = made.node_tree
        image = tree.nodes.new("ShaderNodeTexImage")
        image.image = bpy.data.images.new("image", 4, 4)
        if name:
            node = tree.nodes.new("ShaderNodeUVMap")
            node.uv_map = name
            tree.links.new(node.outputs[0], image.inputs[0])
        tree.links.new(image.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
        return made

    def test_flat_smooth_and_sharp(self):
        mesh = kit.cube()
        self.link("cube", mesh)
        self.assertNotIn("NORMAL", self.primitive(self.export())["attributes"])
        mesh.shade_smooth()
        found = self.export()
        normals, points = self.attribute(found, "NORMAL"), self.attribute(found, "POSITION")
        self.assertEqual(len(points), 8)
        self.near(normals, points / math.sqrt(3), 1e-6)
        mesh.polygons[1].use_smooth = False
        found = self.export()
        self.assertEqual(len(self.attribute(found, "POSITION")), 24)
        normals = self.attribute(found, "NORMAL")
        top = (self.attribute(found, "POSITION")[:, 2] > 0) & (normals[:, 2] > 0.99)
        self.assertEqual(top.sum(), 4)

    def test_custom_normals(self):
        mesh = kit.plane()
        mesh.shade_smooth()
        tilted = numpy.array([0.6, 0, 0.8])
        mesh.normals_split_custom_set([tilted] * 4)
        self.link("plane", mesh)
        # Blender keeps custom normals as two 16-bit angles.
        self.near(self.attribute(self.export(), "NORMAL"), [tilted] * 4, 1e-4)

    def test_uv_maps_by_name(self):
        mesh = kit.plane()
        other = mesh.uv_layers.new(name="other")
        for corner in other.data:
            corner.uv = (0.25, 0.125)
        made = self.link("plane", mesh)
        mesh.materials.append(self.with_uv())
        plain = self.export()
        # glTF's v runs downwards.
        order = numpy.lexsort(self.attribute(plain, "TEXCOORD_0").T)
        self.near(self.attribute(plain, "TEXCOORD_0")[order], [(0, 0), (1, 0), (0, 1), (1, 1)])
        points = self.attribute(plain, "POSITION")
        self.near(self.attribute(plain, "TEXCOORD_0"), numpy.stack([points[:, 0] + 1, 1 - points[:, 1]], 1) / 2)
        mesh.materials[0] = self.with_uv("other")
        self.near(self.attribute(self.export(), "TEXCOORD_0"), [(0.25, 0.875)] * 4)
        # The active one in the viewport does not matter, that of renders does.
        mesh.materials[0] = self.with_uv()
        mesh.uv_layers.active = other
        self.assertEqual(len(numpy.unique(self.attribute(self.export(), "TEXCOORD_0"), axis=0)), 4)
        other.active_render = True
        self.near(self.attribute(self.export(), "TEXCOORD_0"), [(0.25, 0.875)] * 4)
        # Cycles reads a map that is not there as zero.
        mesh.materials[0] = self.with_uv("nothing")
        found = self.export()
        self.near(self.attribute(found, "TEXCOORD_0"), [(0, 1)] * 4)
        self.assertEqual(self.primitive(found)["extensions"]["SUNDOG_mesh"]["absent_uvs"], [0])
        self.assertEqual(made.data.uv_layers.active.name, "other")

    def test_no_uv_map_where_no_texture_is(self):
        mesh = kit.plane()
        self.link("plane", mesh)
        self.assertNotIn("TEXCOORD_0", self.primitive(self.export())["attributes"])

    def test_vertex_colors(self):
        for domain, kind, count in (("POINT", "FLOAT_COLOR", 4), ("CORNER", "BYTE_COLOR", 4), ("CORNER", "FLOAT_COLOR", 4), ("POINT", "BYTE_COLOR", 4)):
            with self.subTest(domain=domain, kind=kind):
                mesh = kit.plane()
                layer = mesh.color_attributes.new("paint", kind, domain)
                for index, value in enumerate(layer.data):
                    value.color = (index / 3, 0.5, 0.25, 1)
                painted = kit.material("painted")
                tree = painted.node_tree
                node = tree.nodes.new("ShaderNodeVertexColor")
                node.layer_name = "paint"
                tree.links.new(node.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
                mesh.materials.append(painted)
                made = self.link("plane", mesh)
                found = self.export()
                colors = self.attribute(found, "COLOR_0")
                order = numpy.argsort(colors[:, 0])
                # Bytes are kept as sRGB: a step of 1/255 there is at most 2.2/255 here.
                near = 1e-6 if kind == "FLOAT_COLOR" else 2.3 / 255
                self.near(colors[order, :3], [(i / 3, 0.5, 0.25) for i in range(4)], near)
                self.assertEqual(found.verdict("material", painted.name)["verdict"], "exact")
                bpy.data.objects.remove(made)

    def test_material_slots(self):
        mesh = kit.cube()
        made = self.link("cube", mesh)
        for color in (0.1, 0.2, 0.3):
            mesh.materials.append(kit.material(f"m{color}", Base_Color=(color, color, color, 1)))
        for index, polygon in enumerate(mesh.polygons):
            # The last index is beyond the slots: Cycles takes the last slot.
            polygon.material_index = (0, 0, 2, 2, 2, 9)[index]
        found = self.export()
        counts = {}
        for primitive in found["meshes"][0]["primitives"]:
            name = found["materials"][primitive["material"]]["name"]
            counts[name] = len(found.array(primitive["indices"])) // 3
            indices = found.array(primitive["indices"])
            self.assertLess(indices.max(), found.root["accessors"][primitive["attributes"]["POSITION"]]["count"])
        self.assertEqual(counts, {"m0.1": 4, "m0.3": 8})
        self.assertAlmostEqual(sum(found.root["accessors"][p["attributes"]["POSITION"]]["count"] for p in found["meshes"][0]["primitives"]), 16, delta=2)
        # A slot of the object wins over the mesh's.
        made.material_slots[0].link = "OBJECT"
        made.material_slots[0].material = kit.material("own")
        names = {found["materials"][p["material"]]["name"] for found in [self.export()] for p in found["meshes"][0]["primitives"]}
        self.assertEqual(names, {"own", "m0.3"})

    def test_one_mesh_with_two_materials_by_object(self):
        mesh = kit.cube()
        mesh.materials.append(None)
        for name in ("a", "b"):
            made = self.link(name, mesh)
            made.material_slots[0].link = "OBJECT"
            made.material_slots[0].material = kit.material(name)
        found = self.export()
        self.assertEqual(len(found["meshes"]), 2)
        # But its vertices are stored once.
        self.assertEqual(len(found["buffers"]), 1)

    def test_no_material(self):
        self.link("cube", kit.cube())
        found = self.export()
        made = found.material("(no material)")
        self.near(made["pbrMetallicRoughness"]["baseColorFactor"], [0.8, 0.8, 0.8, 1])
        index = made["extensions"].get("KHR_materials_ior", {}).get("ior", 1.5)
        self.assertEqual(index, 1.0 if bpy.app.version < (5, 0) else 1.5)

    def test_same_content_is_one_file(self):
        for name in ("a", "b"):
            self.link(name, kit.cube(name))
        self.assertEqual(len(self.export()["buffers"]), 1)


class Cached(kit.ExportTest):
    """What is written again, and what is not."""

    def test_nothing_changed(self):
        self.link("cube", kit.cube())
        self.assertEqual(self.export().result.changed_geometry, 1)
        self.assertEqual(self.export().result.changed_geometry, 0)

    def test_moved_camera_and_object(self):
        made = self.link("cube", kit.cube())
        first = self.export()
        self.camera.location.x, made.location.x = 3, 7
        second = self.export()
        self.assertEqual(second.result.changed_geometry, 0)
        self.assertNotEqual(first.node("cube"), second.node("cube"))
        self.near(second.matrix(second.node("camera"))[:3, 3], [3, 10, 0])

    def test_changed_vertex(self):
        mesh = kit.cube()
        self.link("cube", mesh)
        self.export()
        mesh.vertices[0].co.x -= 1e-3
        mesh.update()
        found = self.export()
        self.assertEqual(found.result.changed_geometry, 1)
        self.near(found.triangles(found.node("cube"))[..., 0].min(), -1.001)

    def test_changed_material_index(self):
        mesh = kit.cube()
        self.link("cube", mesh)
        for name in "ab":
            mesh.materials.append(kit.material(name))
        self.assertEqual(len(self.export()["meshes"][0]["primitives"]), 1)
        mesh.polygons[0].material_index = 1
        self.assertEqual(len(self.export()["meshes"][0]["primitives"]), 2)

    def test_changed_subdivision(self):
        made = self.link("plane", kit.plane())
        modifier = made.modifiers.new("subdivision", "SUBSURF")
        modifier.subdivision_type = "SIMPLE"
        for levels in (1, 2, 1):
            modifier.render_levels = levels
            found = self.export()
            self.assertEqual(len(found.triangles(found.node("plane"))), 2 * 4**levels)
        self.assertEqual(found.result.changed_geometry, 0)

    def test_damaged_cache(self):
        self.link("cube", kit.cube())
        first = self.export()
        for name in os.listdir(os.path.join(self.folder, "cache")):
            path = os.path.join(self.folder, "cache", name)
            with open(path, "r+b") as file:
                file.truncate(10)
        second = self.export()
        self.assertEqual(second.result.changed_geometry, 1)
        self.near(second.triangles(second.node("cube")), first.triangles(first.node("cube")))

    def test_a_mesh_of_another_file_at_the_same_place_in_memory(self):
        for size in (1.0, 2.0, 3.0):
            bpy.ops.wm.read_factory_settings(use_empty=True)
            self.scene = bpy.context.scene
            camera = self.link("camera", bpy.data.cameras.new("camera"))
            self.scene.camera = camera
            self.link("cube", kit.cube(size=size))
            found = self.export()
            self.near(found.triangles(found.node("cube")).max(), size / 2)

    def test_users_data_stays(self):
        made = self.link("cube", kit.cube())
        made.data.materials.append(kit.material("m"))
        self.export()
        before = {name: len(getattr(bpy.data, name)) for name in ("images", "meshes", "materials", "objects", "node_groups", "worlds", "scenes")}
        self.export()
        self.assertEqual(before, {name: len(getattr(bpy.data, name)) for name in before})


if __name__ == "__main__":
    unittest.main()
