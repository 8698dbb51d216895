# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects are exported, how often, and where: everything the render depsgraph shows, and nothing else."""

import math
import os
import unittest

import bpy
import export_kit as kit
import numpy
from mathutils import Euler, Matrix, Quaternion
from sundog.export import decomposed


class Shown(kit.ExportTest):
    """Visibility of objects and collections."""

    def collection(self, name, parent=None):
        made = bpy.data.collections.new(name)
        (parent or self.scene.collection).children.link(made)
        return made

    def put(self, name, collection):
        made = bpy.data.objects.new(name, kit.cube(name))
        collection.objects.link(made)
        return made

    def layer(self, name):
        return bpy.context.view_layer.layer_collection.children[name]

    def test_hidden_objects(self):
        self.link("shown", kit.cube())
        self.link("off in renders", kit.cube(), hide_render=True)
        # The eye in the outliner and the monitor are the viewport's alone.
        self.link("off in the viewport", kit.cube(), hide_viewport=True)
        self.link("eye", kit.cube()).hide_set(True)
        found = self.export()
        self.assertEqual(found.names(), ["eye", "off in the viewport", "shown"])

    def test_hidden_and_excluded_collections(self):
        names = ["plain", "no render", "excluded", "no viewport"]
        for name in names:
            self.put(name, self.collection(name))
        bpy.data.collections["no render"].hide_render = True
        bpy.data.collections["no viewport"].hide_viewport = True
        self.layer("excluded").exclude = True
        self.assertEqual(self.export().names(), ["no viewport", "plain"])

    def test_a_view_layer_without_surfaces(self):
        """As in Cycles: lamps and the world stay. Curves and volumes that it leaves out are not lost."""
        self.link("cube", kit.cube())
        self.link("lamp", bpy.data.lights.new("lamp", "POINT"))
        self.link("smoke", bpy.data.volumes.new("smoke")).data.filepath = "/nowhere/smoke.vdb"
        layer = bpy.context.view_layer
        layer.use_solid, layer.use_volumes = False, False
        found = self.export()
        self.assertEqual(found.names(), [])
        self.assertIn("KHR_lights_punctual", found.node("lamp")["extensions"])
        self.assertEqual([v["name"] for v in found.result.verdicts if v["verdict"] != "exact"], [])
        layer.use_solid, layer.use_volumes = True, True
        found = self.export()
        self.assertIn("cube", found.names())
        self.assertEqual(found.verdict("object", "smoke")["verdict"], "lost")

    def test_holdout_and_indirect_only_collections(self):
        for name in ("held out", "indirect", "plain"):
            self.put(name, self.collection(name))
        self.layer("held out").holdout = True
        self.layer("indirect").indirect_only = True
        found = self.export()
        self.assertEqual(found.node("held out")["extensions"]["SUNDOG_object"], {"holdout": True})
        self.assertEqual(found.node("indirect")["extensions"]["SUNDOG_object"], {"visibility": {"camera": False}})
        self.assertNotIn("extensions", found.node("plain"))

    def test_what_shows_an_instance_says_whether_it_is_held_out(self):
        """As in Cycles (tried with instances of collections and on vertices): the collection that the object is in has no say."""
        inside = self.collection("inside")
        self.put("thing", inside).is_holdout = True
        self.layer("inside").indirect_only = True
        for name in ("plain", "held out", "indirect"):
            shower = bpy.data.objects.new(name, None)
            shower.instance_type, shower.instance_collection = "COLLECTION", inside
            self.collection(f"of {name}").objects.link(shower)
        self.layer("of held out").holdout = True
        self.layer("of indirect").indirect_only = True
        bpy.data.objects["thing"].location.x = 9
        found = self.export()
        said = [n.get("extensions", {}).get("SUNDOG_object") for n in found.nodes("thing")]
        own = {"visibility": {"camera": False}, "holdout": True}
        self.assertCountEqual(said, [own, None, {"holdout": True}, {"visibility": {"camera": False}}])

    def test_ray_visibility(self):
        for attribute, name in (
            ("visible_camera", "camera"),
            ("visible_diffuse", "diffuse"),
            ("visible_glossy", "glossy"),
            ("visible_transmission", "transmission"),
            ("visible_volume_scatter", "volume"),
            ("visible_shadow", "shadow"),
        ):
            self.link(name, kit.cube(), **{attribute: False})
        self.link("held", kit.cube(), is_holdout=True)
        self.link("catcher", kit.cube(), is_shadow_catcher=True)
        self.camera.name = "eye"
        bpy.data.objects["camera.001"].name = "camera"
        found = self.export()
        for name in ("camera", "diffuse", "glossy", "transmission", "volume", "shadow"):
            self.assertEqual(found.node(name)["extensions"]["SUNDOG_object"], {"visibility": {name: False}})
        self.assertEqual(found.node("held")["extensions"]["SUNDOG_object"], {"holdout": True})
        self.assertEqual(found.node("catcher")["extensions"]["SUNDOG_object"], {"shadow_catcher": True})

    def test_visibility_of_an_instancer_counts_for_what_it_shows(self):
        inside = bpy.data.collections.new("inside")
        self.put("thing", inside)
        shower = self.link("shower", None, instance_type="COLLECTION", instance_collection=inside)
        shower.visible_glossy = False
        found = self.export()
        self.assertEqual(found.node("thing")["extensions"]["SUNDOG_object"], {"visibility": {"glossy": False}})

    def test_view_layers(self):
        self.put("everywhere", self.collection("a"))
        self.put("second only", self.collection("b"))
        self.layer("b").exclude = True
        second = self.scene.view_layers.new("second")
        second.layer_collection.children["b"].exclude = False
        self.assertEqual(self.export().names(), ["everywhere"])
        self.assertEqual(self.export("second").names(), ["everywhere", "second only"])


class Placed(kit.ExportTest):
    """Matrices and instances."""

    def expect(self, found, name, matrix, mesh):
        """The corners of the node's triangles are the mesh's vertices, placed by `matrix`."""
        points = numpy.array([list(v.co) + [1.0] for v in mesh.vertices]) @ numpy.array(matrix).T
        got = found.triangles(found.node(name)).reshape(-1, 3)
        for point in points[:, :3]:
            self.assertLess(numpy.abs(got - point).max(axis=1).min(), 1e-5 * max(1, numpy.abs(point).max()))

    def test_transforms(self):
        kinds = {
            "moved": Matrix.Translation((1, 2, 3)),
            "turned": Matrix.Rotation(0.7, 4, (1, 2, 3)),
            "mirrored": Matrix.Diagonal((-1, 2, 3, 1)) @ Matrix.Rotation(0.3, 4, "X"),
            "sheared": Matrix(((1, 0.5, 0, 4), (0, 1, 0.25, 5), (0, 0, 1, 6), (0, 0, 0, 1))),
            "far": Matrix.Translation((1e6, -2e6, 0.125)),
        }
        mesh = kit.cube()
        for name, matrix in kinds.items():
            made = self.link(name, mesh)
            made.matrix_world = matrix
            if name == "sheared":
                # An object alone cannot be sheared; a turned child of an unevenly scaled parent is.
                parent = self.link("parent", None)
                parent.scale = (1, 2, 3)
                made.parent = parent
                made.matrix_basis = Matrix.Rotation(0.5, 4, (1, 1, 0))
        bpy.context.view_layer.update()
        worlds = {name: bpy.data.objects[name].matrix_world.copy() for name in kinds}
        found = self.export()
        self.assertEqual(len(found["meshes"]), 1)
        for name, matrix in worlds.items():
            self.expect(found, name, matrix, mesh)
        self.assertEqual(found.info()["placed_triangles"], 12 * len(kinds))

    def test_parented_negative_scale(self):
        mesh = kit.cube()
        parent = self.link("parent", None, location=(1, 2, 3), scale=(-1, 1, 2), rotation_euler=(0.1, 0.2, 0.3))
        child = self.link("child", mesh, location=(3, 0, 1), scale=(1, -2, -1))
        child.parent = parent
        bpy.context.view_layer.update()
        self.expect(self.export(), "child", child.matrix_world, mesh)

    def test_collection_instances_are_no_copies(self):
        inside = bpy.data.collections.new("inside")
        inside.instance_offset = (1, 0, 0)
        for name, x in (("a", 0), ("b", 5)):
            made = bpy.data.objects.new(name, kit.cube(name))
            made.location.x = x
            inside.objects.link(made)
        for number in range(5):
            self.link(f"place {number}", None, instance_type="COLLECTION", instance_collection=inside, location=(0, 3 * number, 0))
        found = self.export()
        self.assertEqual(len(found["meshes"]), 2)
        self.assertEqual(found.names(), ["a"] * 5 + ["b"] * 5)
        places = sorted(found.matrix(n)[:3, 3].tolist() for n in found.nodes("b"))
        # (4, 3n, 0) of Blender is (4, 0, -3n) of glTF.
        self.near(places, sorted([4, 0, -3 * n] for n in range(5)))

    def test_nested_instances(self):
        core, middle = bpy.data.collections.new("core"), bpy.data.collections.new("middle")
        core.objects.link(bpy.data.objects.new("thing", kit.cube()))
        for x in (0, 10):
            empty = bpy.data.objects.new(f"middle {x}", None)
            empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", core, (x, 0, 0)
            middle.objects.link(empty)
        for y in (0, 100):
            self.link(f"outer {y}", None, instance_type="COLLECTION", instance_collection=middle, location=(0, y, 0), scale=(2, 2, 2))
        found = self.export()
        self.assertEqual(len(found["meshes"]), 1)
        places = sorted(found.matrix(n)[:3, 3].tolist() for n in found.nodes("thing"))
        self.near(places, sorted([x, 0, -y] for x in (0, 20) for y in (0, 100)))

    def test_instances_on_faces_and_vertices(self):
        parent = self.link("parent", kit.plane(size=10), instance_type="VERTS", show_instancer_for_render=False)
        child = self.link("child", kit.cube())
        child.parent = parent
        found = self.export()
        self.assertEqual(found.names(), ["child"] * 4)
        parent.show_instancer_for_render = True
        self.assertEqual(self.export().names(), ["child"] * 4 + ["parent"])

    def test_particles(self):
        emitter = self.link("emitter", kit.plane(size=10), show_instancer_for_render=False)
        settings = emitter.modifiers.new("particles", "PARTICLE_SYSTEM").particle_system.settings
        settings.type, settings.count = "HAIR", 12
        settings.render_type, settings.instance_object = "OBJECT", self.link("thing", kit.cube(), hide_render=True)
        found = self.export()
        self.assertEqual(found.names(), ["thing"] * 12)
        self.assertEqual(len(found["meshes"]), 1)
        for node in found.nodes("thing"):
            # Somewhere on the emitter.
            place = found.matrix(node)[:3, 3]
            self.assertLess(numpy.abs(place[[0, 2]]).max(), 5.01)
        emitter.show_instancer_for_render = True
        self.assertEqual(self.export().names(), ["emitter"] + ["thing"] * 12)

    def scatter(self, count):
        """A geometry-nodes modifier that puts cubes on the points of a line, each turned and scaled."""
        group = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
        group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        line = group.nodes.new("GeometryNodeMeshLine")
        line.inputs["Count"].default_value = count
        line.inputs["Offset"].default_value = (3, 0, 0)
        thing = group.nodes.new("GeometryNodeObjectInfo")
        thing.inputs["Object"].default_value = self.link("thing", kit.cube(), hide_render=True)
        spread = group.nodes.new("GeometryNodeInstanceOnPoints")
        index = group.nodes.new("GeometryNodeInputIndex")
        spread.inputs["Scale"].default_value = (1, 2, 0.5)
        group.links.new(line.outputs["Mesh"], spread.inputs["Points"])
        group.links.new(thing.outputs["Geometry"], spread.inputs["Instance"])
        turn = group.nodes.new("ShaderNodeCombineXYZ")
        for socket in turn.inputs:
            group.links.new(index.outputs["Index"], socket)
        group.links.new(turn.outputs["Vector"], spread.inputs["Rotation"])
        output = group.nodes.new("NodeGroupOutput")
        group.links.new(spread.outputs["Instances"], output.inputs[0])
        holder = self.link("scatter", bpy.data.meshes.new("none"), location=(0, 0, 7))
        holder.modifiers.new("nodes", "NODES").node_group = group
        return holder

    def expected_scatter(self, count):
        return [
            Matrix.LocRotScale((3 * i, 0, 7), Euler((i, i, i)), (1, 2, 0.5))
            for i in range(count)
        ]

    def test_geometry_nodes_scatter_as_nodes(self):
        self.scatter(5)
        found = self.export()
        self.assertEqual(len(found["meshes"]), 1)
        placed = [n for n in found["nodes"] if "mesh" in n]
        got = sorted(found.matrix(n).reshape(-1).tolist() for n in placed)
        turn = numpy.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
        self.near(got, sorted((turn @ numpy.array(m)).reshape(-1).tolist() for m in self.expected_scatter(5)), 1e-6)

    def test_geometry_nodes_scatter_as_arrays(self):
        count = 300
        self.scatter(count)
        found = self.export()
        self.assertEqual(len(found["meshes"]), 1)
        node = next(n for n in found["nodes"] if "mesh" in n)
        attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
        place, turn, scale = (found.array(attributes[n]) for n in ("TRANSLATION", "ROTATION", "SCALE"))
        self.assertEqual(len(place), count)
        expected = self.expected_scatter(count)
        order = numpy.argsort(place[:, 0])
        for number in (0, 1, 7, 299):
            at = order[number]
            x, y, z, w = turn[at].tolist()
            got = Matrix.LocRotScale(place[at].tolist(), Quaternion((w, x, y, z)), scale[at].tolist())
            self.near(got, expected[number], 2e-6)
        self.assertEqual(found.info()["instances"], count)

    def unlike_twins(self, collection):
        """Two objects with one mesh, each with a name, a material and rays of its own."""
        mesh = kit.cube()
        mesh.materials.append(None)
        for name in ("a", "b"):
            made = bpy.data.objects.new(name, mesh)
            made.material_slots[0].link = "OBJECT"
            made.material_slots[0].material = kit.material(f"of {name}")
            made.visible_glossy = name == "a"
            collection.objects.link(made)

    def expect_unlike_twins(self, found, count):
        meshes = {name: found["materials"].index(found.material(f"of {name}")) for name in ("a", "b")}
        for name, material in meshes.items():
            nodes = found.nodes(name)
            self.assertEqual(len(nodes), count)
            for node in nodes:
                self.assertEqual(found["meshes"][node["mesh"]]["primitives"][0]["material"], material)
                told = node.get("extensions", {}).get("SUNDOG_object")
                self.assertEqual(told, None if name == "a" else {"visibility": {"glossy": False}})

    def test_instances_of_one_mesh_stay_apart(self):
        inside = bpy.data.collections.new("inside")
        self.unlike_twins(inside)
        for number in range(4):
            self.link(f"place {number}", None, instance_type="COLLECTION", instance_collection=inside, location=(0, 3 * number, 0))
        self.expect_unlike_twins(self.export(), 4)
        # Who shows them has a say, too.
        bpy.data.objects["place 2"].visible_diffuse = False
        told = [node.get("extensions", {}).get("SUNDOG_object") for node in self.export().nodes("a")]
        self.assertEqual(sorted(map(str, told)), ["None"] * 3 + ["{'visibility': {'diffuse': False}}"])

    def test_geometry_nodes_pick_of_a_collection(self):
        inside = bpy.data.collections.new("inside")
        self.unlike_twins(inside)
        group = self.scatter(6).modifiers["nodes"].node_group
        things = group.nodes.new("GeometryNodeCollectionInfo")
        things.inputs["Collection"].default_value = inside
        things.inputs["Separate Children"].default_value = True
        spread = next(node for node in group.nodes if node.bl_idname == "GeometryNodeInstanceOnPoints")
        spread.inputs["Pick Instance"].default_value = True
        group.links.new(things.outputs["Instances"], spread.inputs["Instance"])
        self.expect_unlike_twins(self.export(), 3)

    def test_mirrored_and_sheared_copies(self):
        random = numpy.random.default_rng(3)
        matrices = numpy.tile(numpy.eye(4), (200, 1, 1))
        matrices[:, :3, :3] = numpy.linalg.qr(random.normal(size=(200, 3, 3)))[0]
        matrices[:, :3, :3] *= random.uniform(0.01, 100, (200, 1, 3)) * random.choice([-1, 1], (200, 1, 3))
        translation, rotation, scale, exact = decomposed.decompose(matrices)
        self.assertTrue(exact.all())
        again = decomposed._rotations(rotation.astype(float)) * scale[:, None, :]
        relative = numpy.abs(again - matrices[:, :3, :3]).max(axis=(1, 2)) / numpy.abs(matrices[:, :3, :3]).max(axis=(1, 2))
        self.assertLess(relative.max(), 1e-6)
        matrices[:, 0, 1] += 0.3 * numpy.abs(matrices[:, :3, :3]).max(axis=(1, 2))
        self.assertLess(decomposed.decompose(matrices)[3].mean(), 0.05)

    def test_linked_library(self):
        inside = bpy.data.collections.new("linked")
        made = bpy.data.objects.new("thing", kit.cube("thing"))
        made.data.materials.append(kit.material("stuff", Base_Color=(0.2, 0.4, 0.6, 1)))
        inside.objects.link(made)
        path = os.path.join(self.folder, "library.blend")
        bpy.data.libraries.write(path, {inside})
        bpy.data.objects.remove(made)
        bpy.data.collections.remove(inside)
        # Another material of the same name in the open file.
        own = self.link("own", kit.cube())
        bpy.data.materials.remove(bpy.data.materials["stuff"])
        own.data.materials.append(kit.material("stuff", Base_Color=(1, 0, 0, 1)))
        with bpy.data.libraries.load(path, link=True) as (source, target):
            target.collections = ["linked"]
        for x in (0, 5):
            self.link(f"place {x}", None, instance_type="COLLECTION", instance_collection=bpy.data.collections["linked"], location=(x, 5, 0))
        found = self.export()
        self.assertEqual(found.names(), ["own", "thing", "thing"])
        colors = sorted(m["pbrMetallicRoughness"]["baseColorFactor"][0] for m in found["materials"])
        self.near(colors, [0.2, 1.0])

    def test_library_override(self):
        made = bpy.data.objects.new("thing", kit.cube("thing"))
        path = os.path.join(self.folder, "library.blend")
        bpy.data.libraries.write(path, {made})
        bpy.data.objects.remove(made)
        with bpy.data.libraries.load(path, link=True) as (source, target):
            target.objects = ["thing"]
        linked = target.objects[0]
        self.scene.collection.objects.link(linked)
        own = linked.override_create()
        self.scene.collection.objects.unlink(linked)
        if own.name not in self.scene.collection.objects:
            self.scene.collection.objects.link(own)
        own.location = (1, 2, 3)
        found = self.export()
        self.near(found.matrix(found.node("thing"))[:3, 3], [1, 3, -2])

    def test_frame_and_subframe(self):
        made = self.link("moving", kit.cube())
        made.keyframe_insert("location", frame=1)
        made.location.x = 8
        made.keyframe_insert("location", frame=9)
        curves = kit.curves_of(made.animation_data.action)
        for curve in curves:
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"
        self.scene.frame_set(3, subframe=0.5)
        found = self.export()
        self.near(found.matrix(found.node("moving"))[0, 3], 2.5)


class Left(kit.ExportTest):
    """What is left out is told."""

    def test_object_that_is_nowhere(self):
        made = self.link("nowhere", kit.cube())
        made.location.x = math.nan
        self.link("somewhere", kit.cube())
        found = self.export()
        self.assertEqual(found.names(), ["somewhere"])
        self.assertEqual(found.verdict("object", "nowhere")["verdict"], "lost")

    def test_volumes_without_grids(self):
        self.link("cloud", bpy.data.volumes.new("cloud")).data.filepath = "/nowhere/cloud.vdb"
        self.link("nothing", bpy.data.volumes.new("nothing"))
        self.link("fur", bpy.data.hair_curves.new("fur"))
        self.link("thing", kit.cube())
        found = self.export()
        self.assertEqual(found.names(), ["thing"])
        self.assertIn("it is left out", found.verdict("object", "cloud")["detail"])
        self.assertEqual(found.verdict("object", "cloud")["effects"], ["media"])

    def test_light_linking(self):
        lamp = self.link("lamp", bpy.data.lights.new("lamp", "POINT"))
        lit = lamp.light_linking.receiver_collection = bpy.data.collections.new("lit")
        glowing = self.link("glowing", kit.cube())
        blocking = glowing.light_linking.blocker_collection = bpy.data.collections.new("blocking")
        # Empty ones say nothing.
        found = self.export()
        self.assertNotIn("_set", str(found.root))
        for name in ("one", "two", "three"):
            self.link(name, kit.cube(name))
        inner = bpy.data.collections.new("inner")
        lit.objects.link(bpy.data.objects["one"])
        lit.children.link(inner)
        inner.objects.link(bpy.data.objects["two"])
        inner.objects.link(bpy.data.objects["one"])
        lit.collection_children[0].light_linking.link_state = "EXCLUDE"
        blocking.objects.link(bpy.data.objects["three"])
        blocking.collection_objects[0].light_linking.link_state = "EXCLUDE"
        found = self.export()
        (light,) = found.root["extensions"]["KHR_lights_punctual"]["lights"]
        of = {name: found.node(name).get("extensions", {}).get("SUNDOG_object", {}) for name in ("glowing", "one", "two", "three")}
        # Who is included and excluded is excluded.
        self.assertEqual((of["one"], of["two"], of["three"]), ({"receiver_set": 1}, {"receiver_set": 2}, {"blocker_set": 1}))
        self.assertEqual(light["extensions"]["SUNDOG_light"]["lit_sets"], [])
        self.assertEqual(of["glowing"], {"shadow_sets": [0]})

    def test_motion_blur(self):
        self.scene.render.use_motion_blur = True
        thing = self.link("thing", kit.cube())
        found = self.export()
        self.assertNotIn("motion", str(found.root))
        self.assertNotIn("motion", str(found.result.verdicts))
        thing.location.x = 1
        thing.keyframe_insert("location", frame=1)
        thing.location.x = 2
        thing.keyframe_insert("location", frame=2)
        self.scene.frame_set(1)
        self.assertEqual(len(self.export().node("thing")["extensions"]["SUNDOG_object"]["motion"]), 3)

    def test_nothing_but_a_camera(self):
        found = self.export()
        self.assertEqual(found.names(), [])
        self.assertEqual(found.info()["triangles"], 0)

    def test_names_of_all_kinds(self):
        for name in ("Würfel", "a/b\\c", '"quoted"', "tab\tand\nline", "🌞"):
            self.link(name, kit.cube())
        found = self.export()
        self.assertEqual(len(found.names()), 5)
        found.info()


if __name__ == "__main__":
    unittest.main()
