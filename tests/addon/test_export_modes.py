# SPDX-License-Identifier: GPL-3.0-or-later
"""What is rendered while an object is in Edit Mode, or is sculpted or painted: what is rendered in Object Mode."""

import unittest

import bmesh
import bpy
import export_kit as kit
import numpy


class Modes(kit.ExportTest):
    """The same scene exported in two modes."""

    def setUp(self):
        super().setUp()
        self.plain = kit.material("plain", Base_Color=(0.1, 0.2, 0.3, 1))
        self.other = kit.material("other", Base_Color=(0.7, 0.6, 0.5, 1))

    def tearDown(self):
        if bpy.context.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")

    def rich(self, name="rich"):
        """A cube with two materials, an image by a UV map, a colour attribute, and a sharp edge."""
        mesh = kit.cube(name)
        nodes, links = self.plain.node_tree.nodes, self.plain.node_tree.links
        image = bpy.data.images.new("image", 4, 4)
        image.pixels.foreach_set(numpy.linspace(0, 1, 64, dtype=numpy.float32))
        image.pack()
        textured = nodes.new("ShaderNodeTexImage")
        textured.image = image
        painted = nodes.new("ShaderNodeVertexColor")
        painted.layer_name = "paint"
        product = nodes.new("ShaderNodeVectorMath")
        product.operation = "MULTIPLY"
        links.new(textured.outputs["Color"], product.inputs[0])
        links.new(painted.outputs["Color"], product.inputs[1])
        links.new(product.outputs[0], nodes["Principled BSDF"].inputs["Base Color"])
        mesh.materials.append(self.plain)
        mesh.materials.append(self.other)
        for number, face in enumerate(mesh.polygons):
            face.material_index, face.use_smooth = number % 2, number > 2
        layer = mesh.uv_layers.new(name="map")
        layer.data.foreach_set("uv", numpy.linspace(0, 1, 48, dtype=numpy.float32))
        paint = mesh.color_attributes.new("paint", "FLOAT_COLOR", "CORNER")
        paint.data.foreach_set("color", numpy.linspace(0, 1, 96, dtype=numpy.float32))
        mesh.edges[0].use_edge_sharp = True
        return self.link(name, mesh)

    def enter(self, mode, *objects):
        """Changes the mode of these objects, the first of which is active."""
        bpy.ops.object.select_all(action="DESELECT")
        for one in objects:
            one.select_set(True)
        bpy.context.view_layer.objects.active = objects[0]
        bpy.ops.object.mode_set(mode=mode)

    def contents(self, found):
        """What a scene holds of geometry, whatever its files and meshes are called."""
        result = []
        for node in found["nodes"]:
            if "mesh" not in node:
                continue
            for primitive in found["meshes"][node["mesh"]]["primitives"]:
                arrays = {name: found.array(index) for name, index in primitive["attributes"].items()}
                arrays["indices"] = found.array(primitive["indices"])
                material = found["materials"][primitive["material"]]["name"]
                result.append((node["name"], material, node["matrix"], arrays))
        return result

    def same(self, mode, *objects):
        """Exports in Object Mode and in the other mode: the same geometry, and the mode stays as it is."""
        before = self.contents(self.export())
        self.enter(mode, *objects)
        found = self.export()
        self.assertEqual([one.mode for one in objects], [mode] * len(objects))
        after = self.contents(found)
        self.assertEqual([entry[:3] for entry in after], [entry[:3] for entry in before])
        for (name, _, _, got), (_, _, _, expected) in zip(after, before):
            self.assertEqual(sorted(got), sorted(expected), name)
            for key, values in expected.items():
                numpy.testing.assert_array_equal(got[key], values, f"{name}: {key}")
        return found

    def test_mesh(self):
        found = self.same("EDIT", self.rich())
        primitives = found["meshes"][0]["primitives"]
        self.assertEqual([len(p["attributes"]) for p in primitives], [4, 2])

    def test_mesh_with_modifiers(self):
        made = self.rich()
        made.modifiers.new("array", "ARRAY").count = 3
        solid = made.modifiers.new("subdivision", "SUBSURF")
        solid.subdivision_type, solid.render_levels = "SIMPLE", 1
        self.assertEqual(sum(len(e[3]["indices"]) for e in self.contents(self.same("EDIT", made))), 3 * 6 * 4 * 2 * 3)

    def test_what_is_edited_is_rendered(self):
        made = self.rich()
        self.enter("EDIT", made)
        edited = bmesh.from_edit_mesh(made.data)
        edited.verts.ensure_lookup_table()
        for vertex in edited.verts:
            vertex.co.z += 5
        bmesh.update_edit_mesh(made.data)
        first, *_ = self.contents(self.export())
        self.assertEqual(first[3]["POSITION"][:, 2].min(), 4)
        # Nothing of the edit is lost by the render.
        self.assertEqual(min(v.co.z for v in bmesh.from_edit_mesh(made.data).verts), 4)

    def test_shared_data_and_several_objects(self):
        made = self.rich()
        twin = self.link("twin", made.data, location=(3, 0, 0))
        twin.modifiers.new("array", "ARRAY").count = 2
        other = self.link("third", kit.cube("third"), location=(0, 3, 0))
        self.same("EDIT", made, other)

    def test_custom_normals_and_shape_keys(self):
        made = self.rich()
        made.data.normals_split_custom_set([(0, 0.6, 0.8)] * len(made.data.loops))
        self.same("EDIT", made)
        bpy.ops.object.mode_set(mode="OBJECT")
        keyed = self.link("keyed", kit.cube("keyed"))
        keyed.shape_key_add(name="Basis")
        key = keyed.shape_key_add(name="wide")
        key.data[0].co.x -= 2
        key.value = 1
        # Edit Mode shows the key that is edited: here the last one, at its whole strength.
        keyed.active_shape_key_index = 1
        self.same("EDIT", keyed)

    def nodes(self, target, build):
        """A modifier with a group that `build` makes of (group, input node, output node)."""
        group = bpy.data.node_groups.new("group", "GeometryNodeTree")
        for way in ("INPUT", "OUTPUT"):
            group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
        build(group, group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput"))
        target.modifiers.new("nodes", "NODES").node_group = group

    def test_attributes_of_geometry_nodes(self):
        def build(group, first, last):
            stored = group.nodes.new("GeometryNodeStoreNamedAttribute")
            stored.data_type, stored.domain = "FLOAT_VECTOR", "POINT"
            stored.inputs["Name"].default_value = "paint"
            position = group.nodes.new("GeometryNodeInputPosition")
            group.links.new(first.outputs[0], stored.inputs[0])
            group.links.new(position.outputs[0], next(s for s in stored.inputs if s.name == "Value" and s.enabled))
            group.links.new(stored.outputs[0], last.inputs[0])

        made = self.rich()
        self.nodes(made, build)
        found = self.contents(self.same("EDIT", made))
        self.assertEqual(found[0][3]["COLOR_0"].min(), -1)

    def test_instances_of_what_is_edited(self):
        made = self.rich()

        def build(group, first, last):
            each = group.nodes.new("GeometryNodeInstanceOnPoints")
            shown = group.nodes.new("GeometryNodeObjectInfo")
            shown.inputs["Object"].default_value = made
            shown.inputs["As Instance"].default_value = True
            group.links.new(first.outputs[0], each.inputs["Points"])
            group.links.new(shown.outputs["Geometry"], each.inputs["Instance"])
            group.links.new(each.outputs[0], last.inputs[0])

        points = bpy.data.meshes.new("points")
        points.from_pydata([(0, 0, 3), (0, 0, 6)], [], [])
        self.nodes(self.link("points", points), build)
        collection = bpy.data.collections.new("shown")
        collection.objects.link(made)
        self.link("empty", None, instance_type="COLLECTION", instance_collection=collection, location=(9, 0, 0))
        self.assertEqual(len(self.contents(self.same("EDIT", made))), 4 * 2)

    def test_curves_texts_and_metaballs(self):
        bpy.ops.curve.primitive_bezier_circle_add()
        bpy.context.object.data.bevel_depth = 0.1
        self.same("EDIT", bpy.context.object)
        bpy.ops.object.mode_set(mode="OBJECT")
        for add in (bpy.ops.object.text_add, bpy.ops.object.metaball_add, bpy.ops.surface.primitive_nurbs_surface_sphere_add):
            add()
            self.same("EDIT", bpy.context.object)
            bpy.ops.object.mode_set(mode="OBJECT")

    def test_sculpting_and_painting(self):
        made = self.rich()
        for mode in ("SCULPT", "VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT"):
            with self.subTest(mode):
                self.same(mode, made)
                bpy.ops.object.mode_set(mode="OBJECT")
        made.modifiers.new("multires", "MULTIRES")
        bpy.ops.object.multires_subdivide(modifier="multires")
        self.same("SCULPT", made)

    def test_an_edited_mesh_without_faces(self):
        made = self.rich()
        self.enter("EDIT", made)
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.mesh.delete(type="ONLY_FACE")
        self.assertEqual(self.contents(self.export()), [])

    def test_cycles_shows_the_same(self):
        made = self.rich()
        made.modifiers.new("array", "ARRAY").relative_offset_displace = (0, 1.5, 0)
        self.camera.location = (0, 1.5, 9)
        self.link("lamp", bpy.data.lights.new("lamp", "SUN"))
        self.scene.world = bpy.data.worlds.new("world")
        self.enter("EDIT", made)
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.transform.translate(value=(1, 0, 0))
        found = self.export()
        expected = kit.cycles_pixels(16, 16, 64)
        got = kit.rendered(found.path, 16, 16, 64)
        self.assertGreater(expected.mean(), 0.02)
        self.near(got.mean(axis=(0, 1)), expected.mean(axis=(0, 1)), 0.03)


if __name__ == "__main__":
    unittest.main()
