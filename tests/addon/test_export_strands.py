# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair of particles, hair curves and point clouds as they are written."""

import unittest
from types import SimpleNamespace

import bpy
import export_kit as kit
import numpy
import strand_kit
from mathutils import Matrix, Vector
from sundog.export import object_info, strands


class Strands(kit.ExportTest):
    """Ways to read what was written."""

    def primitives(self, found, name):
        """The primitives of strands and points that nodes of a name show."""
        meshes = {node["mesh"] for node in found.nodes(name)}
        every = [p for mesh in sorted(meshes) for p in found["meshes"][mesh]["primitives"]]
        return [p for p in every if "strands" in p.get("extensions", {}).get("SUNDOG_mesh", {})]

    def only(self, found, name):
        """The only one of them."""
        (primitive,) = self.primitives(found, name)
        return primitive

    def arrays(self, found, primitive):
        """Its attributes by name."""
        return {name: found.array(index) for name, index in primitive["attributes"].items()}

    def pairs(self, found, primitive):
        """Its lines."""
        return found.array(primitive["indices"]).reshape(-1, 2)


class Particles(Strands):
    """Hair of particle systems."""

    def told(self, name, number=0):
        """Places of all particles and children as co_hair tells them, in the object's space: strands × keys × 3."""
        def task(depsgraph):
            shown = bpy.data.objects[name].evaluated_get(depsgraph)
            system = shown.particle_systems[number]
            total, children = len(system.particles), len(system.child_particles)
            keys = 2**system.settings.render_step + 1
            inverse = numpy.array(shown.matrix_world.inverted(), float)
            places = [[system.co_hair(shown, particle_no=n, step=k) for k in range(keys)] for n in range(total + children)]
            return total, numpy.array(places, float) @ inverse[:3, :3].T + inverse[:3, 3]

        return kit.in_render(task)

    def test_strands_without_children(self):
        shown = strand_kit.hairy(count=12)
        shown.location, shown.rotation_euler, shown.scale = (1, 2, 3), (0.3, 0.2, 0.1), (2, 1, 0.5)
        found = self.export()
        primitive = self.only(found, "ball")
        _, places = self.told("ball")
        arrays = self.arrays(found, primitive)
        self.assertEqual(set(arrays), {"POSITION", "_RADIUS"})
        self.near(arrays["POSITION"], places.reshape(-1, 3), 1e-6)
        self.assertEqual(primitive["mode"], 1)
        expected = [[9 * n + k, 9 * n + k + 1] for n in range(12) for k in range(8)]
        self.assertEqual(self.pairs(found, primitive).tolist(), expected)
        self.assertEqual(primitive["extensions"]["SUNDOG_mesh"]["strands"], {"shape": "ribbon", "radius": "_RADIUS", "steps": 5})
        # Beside the ball, in its place.
        ball, hair = found.nodes("ball")
        self.assertEqual(ball["matrix"], hair["matrix"])
        self.assertEqual([v["verdict"] for v in found.result.verdicts], ["exact"])

    def test_children_take_the_place_of_parents(self):
        for kind in ("SIMPLE", "INTERPOLATED"):
            shown = strand_kit.hairy(count=5, child_type=kind, rendered_child_count=4)
            found = self.export()
            total, places = self.told("ball")
            self.assertEqual(len(places) - total, 20)
            self.near(self.arrays(found, self.only(found, "ball"))["POSITION"], places[total:].reshape(-1, 3), 1e-6)
            bpy.data.objects.remove(shown)

    def test_steps_and_spirals(self):
        strand_kit.hairy(count=2, render_step=4, kink="SPIRAL", kink_extra_steps=5)
        found = self.export()
        self.assertEqual(len(self.pairs(found, self.only(found, "ball"))), 2 * (16 + 5))

    def test_radius(self):
        shown = strand_kit.hairy(count=4, radius_scale=0.2, root_radius=0.5, tip_radius=0.1, use_close_tip=False)
        settings = shown.particle_systems[0].settings
        _, places = self.told("ball")
        way = numpy.concatenate([numpy.zeros((4, 1)), numpy.cumsum(numpy.linalg.norm(numpy.diff(places, axis=1), axis=2), axis=1)], axis=1)
        rest = 1 - way / way[:, -1:]
        for shape, power in ((0.0, 1.0), (-0.75, 0.25), (0.5, 2.0)):
            settings.shape = shape
            found = self.export()
            # Half of 0.2 · 0.5 at the root, half of 0.2 · 0.1 at the tip.
            radii = self.arrays(found, self.only(found, "ball"))["_RADIUS"].reshape(4, 9)
            self.near(radii, 0.04 * rest.clip(0) ** power + 0.01, 1e-4)
            self.near(radii[:, [0, -1]], [[0.05, 0.01]] * 4, 1e-4 if power > 0.5 else 3e-2)
        settings.use_close_tip = True
        found = self.export()
        radii = self.arrays(found, self.only(found, "ball"))["_RADIUS"].reshape(4, 9)
        self.assertEqual(radii[:, -1].tolist(), [0] * 4)
        self.assertGreater(radii[:, -2].min(), 0.01)

    def test_normals_for_elliptic_fibres(self):
        shown = strand_kit.hairy(count=5)
        shown.data.materials.append(strand_kit.elliptic(0.5))
        found = self.export()
        arrays = self.arrays(found, self.only(found, "ball"))
        if strands.HAS_UPWARD_NORMALS:
            self.near(arrays["NORMAL"], numpy.tile((0, 0, 1), (45, 1)), 0)
        else:
            self.assertNotIn("NORMAL", arrays)

    def test_materials_by_slot(self):
        shown = strand_kit.hairy(count=3, material=2)
        for number in range(3):
            shown.data.materials.append(kit.material(f"material {number}", Roughness=0.2 * number))
        strand_kit.add_hair(shown, "more", count=4, material=9)
        found = self.export()
        names = [found["materials"][p["material"]]["name"] for p in self.primitives(found, "ball")]
        # The last slot where there are not as many.
        self.assertEqual(names, ["material 1", "material 2"])
        self.assertEqual([len(self.pairs(found, p)) for p in self.primitives(found, "ball")], [3 * 8, 4 * 8])

    def test_coordinates_and_colors_at_roots(self):
        shown = strand_kit.hairy(count=6)
        shown.data.materials.append(self.mixed(("ShaderNodeTexCoord", "UV", {}), ("ShaderNodeVertexColor", "Color", {"layer_name": "painted"})))
        strand_kit.paint(shown.data, "painted")

        def task(depsgraph):
            thing = bpy.data.objects["ball"].evaluated_get(depsgraph)
            system, modifier = thing.particle_systems[0], thing.modifiers[0]
            return [
                (tuple(system.uv_on_emitter(modifier, particle=p, particle_no=n, uv_no=0)),
                 tuple(system.mcol_on_emitter(modifier, particle=p, particle_no=n, vcol_no=0)))
                for n, p in enumerate(system.particles)
            ]  # fmt: skip

        told = kit.in_render(task)
        found = self.export()
        arrays = self.arrays(found, self.only(found, "ball"))
        self.near(arrays["TEXCOORD_0"], numpy.repeat([(u, 1 - v) for (u, v), _ in told], 9, axis=0))
        codes = numpy.repeat([color for _, color in told], 9, axis=0)
        linear = numpy.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
        colors = arrays.get("COLOR_0", arrays.get("_SUNDOG_0"))
        self.near(colors[:, :3], linear, 1e-5)

    def mixed(self, *told):
        """A material that shines with the sum of what nodes tell."""
        made = strand_kit.telling(*told[0][:2], **told[0][2])
        tree = made.node_tree
        moved = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeVectorMath")
        for kind, output, properties in told[1:]:
            node, plus = tree.nodes.new(kind), tree.nodes.new("ShaderNodeVectorMath")
            for key, value in properties.items():
                setattr(node, key, value)
            tree.links.new(moved.inputs[0].links[0].from_socket, plus.inputs[0])
            tree.links.new(node.outputs[output], plus.inputs[1])
            tree.links.new(plus.outputs[0], moved.inputs[0])
        return made

    def test_what_nodes_tell(self):
        shown = strand_kit.hairy(count=3)
        strand_kit.add_hair(shown, "more", count=2, child_type="SIMPLE", rendered_child_count=2)
        outputs = [o for o in ("Is Strand", "Intercept", "Length", "Thickness", "Tangent Normal", "Random") if o in strand_kit.outputs_of("ShaderNodeHairInfo")]
        shown.data.materials.append(self.mixed(*[("ShaderNodeHairInfo", output, {}) for output in outputs]))
        found = self.export()
        graph = found["materials"][0]["extensions"]["SUNDOG_shader_graph"]
        nodes = [n for n in graph["nodes"] if n["type"] == "ShaderNodeHairInfo"]
        values = {output: at["attribute"] for node in nodes for output, at in node.get("properties", {}).get("values", {}).items()}
        self.assertEqual(set(values), {"Intercept", "Length", "Random"} & set(outputs))
        first, second = (self.arrays(found, p) for p in self.primitives(found, "ball"))
        (total, places), (parents, more) = self.told("ball"), self.told("ball", 1)
        self.assertEqual((total, parents), (3, 2))
        for arrays, strand in ((first, places), (second, more[2:])):
            steps = numpy.linalg.norm(numpy.diff(strand, axis=1), axis=2)
            way = numpy.concatenate([numpy.zeros((len(strand), 1)), numpy.cumsum(steps, axis=1)], axis=1)
            self.near(arrays[values["Intercept"]][:, 0], (way / way[:, -1:]).reshape(-1), 1e-5)
            if "Length" in values:
                self.near(arrays[values["Length"]], numpy.repeat(way[:, -1:], 27, axis=1).reshape(-1, 3), 1e-5)
        # The systems of an object are counted together.
        random = [object_info.random_number(object_info._mixed(n, 0)) for n in range(7)]
        self.near(numpy.concatenate([first[values["Random"]], second[values["Random"]]])[::9, 0], random)
        # Of the ball itself it is zero.
        ball = next(p for m in found["meshes"] for p in m["primitives"] if p.get("mode") is None)
        self.assertFalse(found.array(ball["attributes"][values["Random"]]).any())
        self.assertEqual([v["verdict"] for v in found.result.verdicts if v["kind"] == "material"], ["exact"])

    def test_generated_coordinates_are_those_of_roots(self):
        shown = strand_kit.hairy(count=3)
        shown.data.materials.append(strand_kit.telling("ShaderNodeTexCoord", "Generated"))
        found = self.export()
        primitive = self.only(found, "ball")
        arrays = self.arrays(found, primitive)
        # The ball has a radius of 1.
        roots = arrays["POSITION"].reshape(3, 9, 3)[:, :1]
        self.near(arrays["_GENERATED"].reshape(3, 9, 3), numpy.repeat((roots + 1) / 2, 9, axis=1), 1e-5)
        self.assertEqual(primitive["extensions"]["SUNDOG_mesh"]["generated"], "_GENERATED")

    def test_shapes_of_the_scene(self):
        strand_kit.hairy(count=2)
        curves = self.scene.cycles_curves
        curves.subdivisions = 3
        names = {"RIBBONS": {"shape": "ribbon", "radius": "_RADIUS", "steps": 9}, "THICK": {"shape": "round", "radius": "_RADIUS"}}
        names["THICK_LINEAR"] = {"shape": "round-linear", "radius": "_RADIUS"}
        for shape in curves.bl_rna.properties["shape"].enum_items.keys():
            curves.shape = shape
            found = self.export()
            self.assertEqual(self.only(found, "ball")["extensions"]["SUNDOG_mesh"]["strands"], names[shape])

    def test_where_there_is_none(self):
        shown = strand_kit.hairy(count=3)
        settings = shown.particle_systems[0].settings
        layer = self.scene.view_layers[0]
        shown.show_instancer_for_render = False
        # The object is not shown, but its hair is.
        self.assertEqual(self.export().names(), ["ball"])
        for thing, name, value in ((layer, "use_strand", False), (settings, "render_type", "NONE"), (shown.modifiers[0], "show_render", False)):
            before = getattr(thing, name)
            setattr(thing, name, value)
            self.assertEqual(self.export().names(), [], name)
            setattr(thing, name, before)

    def test_instances(self):
        shown = strand_kit.hairy(count=3)
        group = bpy.data.collections.new("group")
        shown.users_collection[0].objects.unlink(shown)
        group.objects.link(shown)
        places = [Matrix.Translation((x, 1, 2)) @ Matrix.Rotation(x, 4, "Y") for x in (1, 2, 3)]
        for place in places:
            self.link("copy", None, instance_type="COLLECTION", instance_collection=group).matrix_world = place
        found = self.export()
        nodes = [n for n in found.nodes("ball") if found["meshes"][n["mesh"]]["primitives"][0].get("mode") == 1]
        self.assertEqual(len(nodes), 3)
        self.assertEqual(len({n["mesh"] for n in nodes}), 1)
        turn = numpy.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
        got = sorted((turn.T @ found.matrix(n))[0, 3] for n in nodes)
        self.near(got, [1, 2, 3])

    def test_files_are_taken_again(self):
        strand_kit.hairy(count=3)
        self.export()
        before = self.export()
        uris = {b["uri"] for b in before["buffers"]}
        self.assertEqual(uris, {b["uri"] for b in self.export()["buffers"]})
        bpy.data.objects["ball"].particle_systems[0].settings.radius_scale = 0.5
        self.assertEqual(len(uris & {b["uri"] for b in self.export()["buffers"]}), 1)

    def test_strands_that_are_cut_end_there(self):
        strand_kit.hairy(count=5, child_type="INTERPOLATED", rendered_child_count=20, child_length=0.7, child_length_threshold=0.5)
        bpy.data.objects["ball"].location = (3, 0, 0)
        found = self.export()
        places = self.arrays(found, self.only(found, "ball"))["POSITION"].reshape(-1, 9, 3)
        _, told = self.told("ball")
        # Some of these go to the world's origin.
        nowhere = numpy.abs(told[5:] - [-3, 0, 0]).max(axis=2) < 1e-6
        self.assertTrue(nowhere.any())
        self.near(places[~nowhere], told[5:][~nowhere], 1e-6)
        for place, beyond in zip(places, nowhere):
            last = numpy.flatnonzero(~beyond)[-1]
            self.assertTrue((place[beyond] == place[last]).all())

    def test_a_key_at_the_origin_is_there(self):
        # The second of three keys is at the origin, and the second strand ends there.
        local = {0: [(0, 0, 0), (0, 0, 1), (0, 0, 2)], 1: [(1, 0, 0), (0, 0, 1)]}

        def co_hair(through, particle_no, step):
            keys = local[particle_no]
            return through.matrix_world @ Vector(keys[step]) if step < len(keys) else Vector((0, 0, 0))

        shown, camera = (SimpleNamespace(matrix_world=Matrix.Translation(place)) for place in ((0, 0, -1), (0, 5, 0)))
        system, depsgraph = SimpleNamespace(co_hair=co_hair), SimpleNamespace(objects=[shown, camera])
        places = strands._places(shown, system, (numpy.arange(2), 3), depsgraph)
        self.assertEqual(places.tolist(), [[[0, 0, -1], [0, 0, 0], [0, 0, 1]], [[1, 0, -1], [0, 0, 0], [0, 0, 0]]])

    def test_motion(self):
        shown = strand_kit.hairy(count=3)
        kit.stretches(shown, 2.0, ((0, 0.0), (2, 1.0)))
        self.scene.frame_set(1)
        self.scene.render.use_motion_blur = True
        found = self.export()
        primitive = self.only(found, "ball")
        steps = primitive["extensions"]["SUNDOG_mesh"]["motion"]
        self.assertEqual([s["position"] for s in steps], ["_POSITION_0", "POSITION", "_POSITION_2"])
        self.assertEqual(self.scene.frame_current, 1)
        arrays = self.arrays(found, primitive)
        # The shutter is open for half a frame: from 0.75 to 1.25.
        for step, name in ((0.75, "_POSITION_0"), (1.0, "POSITION"), (1.25, "_POSITION_2")):
            self.scene.frame_set(int(step), subframe=step - int(step))
            _, places = self.told("ball")
            self.near(arrays[name], places.reshape(-1, 3), 1e-5)

    def test_a_number_that_changes_is_not_blurred(self):
        shown = strand_kit.hairy(count=3, child_type="SIMPLE")
        settings = shown.particle_systems[0].settings
        for frame, count in ((0, 3), (1, 3), (2, 5)):
            settings.rendered_child_count = count
            settings.keyframe_insert("rendered_child_count", frame=frame)
        self.scene.frame_set(1)
        self.scene.render.use_motion_blur, self.scene.render.motion_blur_shutter = True, 2.0
        found = self.export()
        self.assertNotIn("motion", self.only(found, "ball")["extensions"]["SUNDOG_mesh"])
        self.assertIn("its strands are not blurred", found.verdict("object", "ball")["detail"])


class Curves(Strands):
    """Objects of hair curves."""

    def test_curves(self):
        data = strand_kit.curves(count=6)
        self.link("curves", data)
        found = self.export()
        primitive = self.only(found, "curves")
        arrays = self.arrays(found, primitive)
        places, radii = numpy.empty(len(data.points) * 3, numpy.float32), numpy.empty(len(data.points), numpy.float32)
        data.attributes["position"].data.foreach_get("vector", places)
        data.attributes["radius"].data.foreach_get("value", radii)
        self.assertEqual(arrays["POSITION"].reshape(-1).tolist(), places.tolist())
        self.assertEqual(arrays["_RADIUS"].tolist(), radii.tolist())
        pairs = self.pairs(found, primitive)
        self.assertEqual(len(pairs), len(data.points) - 6)
        starts = [c.first_point_index for c in data.curves]
        self.assertEqual([a for (a, _), (_, b) in zip(pairs[1:].tolist(), pairs.tolist()) if a != b], starts[1:])

    def test_normals_for_elliptic_fibres(self):
        shown = self.link("curves", strand_kit.curves(count=6))
        for aspect in (1.0, 0.5):
            shown.data.materials.clear()
            shown.data.materials.append(strand_kit.elliptic(aspect))
            found = self.export()
            arrays = self.arrays(found, self.only(found, "curves"))
            self.assertEqual("NORMAL" in arrays, aspect != 1.0)
        # Across the strand and of unit length.
        normals, places = arrays["NORMAL"], arrays["POSITION"]
        self.near((normals**2).sum(axis=1), numpy.ones(len(normals)), 1e-5)
        # The first curve has three keys; at its middle one the tangent is the mean of both segments' directions.
        ways = [way / numpy.linalg.norm(way) for way in numpy.diff(places[:3], axis=0)]
        self.assertLess(abs(normals[1] @ (ways[0] + ways[1])), 1e-5)

    def test_single_keys_and_no_radius(self):
        data = bpy.data.hair_curves.new("curves")
        data.add_curves([1, 3, 1, 2])
        places = numpy.arange(21, dtype=numpy.float32)
        data.attributes["position"].data.foreach_set("vector", places)
        if "radius" in data.attributes:
            data.attributes.remove(data.attributes["radius"])
        data.materials.append(strand_kit.telling("ShaderNodeHairInfo", "Random"))
        self.link("curves", data)
        found = self.export()
        primitive = self.only(found, "curves")
        arrays = self.arrays(found, primitive)
        self.assertEqual(arrays["POSITION"].reshape(-1).tolist(), [*places[3:12], *places[15:21]])
        self.assertEqual(self.pairs(found, primitive).tolist(), [[0, 1], [1, 2], [3, 4]])
        self.near(arrays["_RADIUS"], [0.005] * 5)
        # The curves are the second and the fourth.
        random = [object_info.random_number(object_info._mixed(n, 0)) for n in (1, 1, 1, 3, 3)]
        self.near(arrays["_SUNDOG_0"][:, 0], random)

    def test_attributes(self):
        data = strand_kit.curves(count=6)
        strand_kit.give_attributes(data)
        sizes = [c.points_length for c in data.curves]
        pairs = numpy.empty(12, numpy.float32)
        data.attributes["pair_a"].data.foreach_get("vector", pairs)
        data.materials.append(strand_kit.telling("ShaderNodeTexCoord", "UV"))
        self.link("curves", data)
        found = self.export()
        # The first pair of numbers of curves.
        uv = pairs.reshape(-1, 2) * [1, -1] + [0, 1]
        self.near(self.arrays(found, self.only(found, "curves"))["TEXCOORD_0"], numpy.repeat(uv, sizes, axis=0), 1e-6)
        numbers = numpy.empty(6, numpy.float32)
        data.attributes["number"].data.foreach_get("value", numbers)
        data.materials[0] = strand_kit.telling("ShaderNodeAttribute", "Color", attribute_name="number")
        found = self.export()
        arrays = self.arrays(found, self.only(found, "curves"))
        rows = numpy.repeat(numpy.repeat(numbers[:, None], 3, axis=1), sizes, axis=0)
        self.near(arrays.get("_SUNDOG_0", arrays.get("COLOR_0"))[:, :3], rows, 1e-6)

    def test_generated_coordinates_are_places(self):
        data = strand_kit.curves(count=2)
        data.materials.append(strand_kit.telling("ShaderNodeTexCoord", "Generated"))
        self.link("curves", data)
        described = self.only(self.export(), "curves")["extensions"]["SUNDOG_mesh"]
        self.assertEqual(described["texture_space"], {"location": [0.5] * 3, "size": [0.5] * 3})

    @unittest.skipUnless(strand_kit.HAS_TYPES, "this Blender's Python cannot change types of curves")
    def test_poly_curves(self):
        self.link("curves", strand_kit.curves("POLY", count=2))
        shape = self.only(self.export(), "curves")["extensions"]["SUNDOG_mesh"]["strands"]["shape"]
        self.assertEqual(shape, "round-linear" if bpy.app.version >= (5, 0, 0) else "ribbon")

    def test_velocities(self):
        data = strand_kit.curves(count=2)
        keys = len(data.points)
        given = numpy.linspace(0, 1, keys * 3, dtype=numpy.float32)
        data.attributes.new("velocity", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", given)
        self.link("curves", data)
        self.assertNotIn("motion", self.only(self.export(), "curves")["extensions"]["SUNDOG_mesh"])
        self.scene.render.use_motion_blur, self.scene.render.fps = True, 24
        found = self.export()
        primitive = self.only(found, "curves")
        self.assertEqual(len(primitive["extensions"]["SUNDOG_mesh"]["motion"]), 3)
        arrays = self.arrays(found, primitive)
        # Half a frame is 1/48 s, half of it lies after the middle.
        self.near(arrays["_POSITION_2"] - arrays["POSITION"], given.reshape(-1, 3) / 96, 1e-4)
        self.near(arrays["POSITION"] - arrays["_POSITION_0"], given.reshape(-1, 3) / 96, 1e-4)

    def test_keys_that_are_no_places(self):
        data = strand_kit.curves(count=2)
        data.attributes["position"].data[3].vector = (float("nan"), 0, 0)
        self.link("curves", data)
        for blurs in (False, True):
            self.scene.render.use_motion_blur = blurs
            found = self.export()
            self.assertEqual(found.names(), [])
            self.assertIn("it is left out", found.verdict("object", "curves")["detail"])


class Points(Strands):
    """Point clouds."""

    def test_points(self):
        material = strand_kit.telling("ShaderNodePointInfo", "Random")
        shown = strand_kit.points(self.scene, material, 30)
        mesh = shown.data
        found = self.export()
        primitive = self.only(found, "points")
        arrays = self.arrays(found, primitive)
        places, sizes = numpy.empty(90, numpy.float32), numpy.empty(30, numpy.float32)
        mesh.vertices.foreach_get("co", places)
        mesh.attributes["size"].data.foreach_get("value", sizes)
        self.assertEqual(primitive["mode"], 0)
        self.assertEqual(primitive["extensions"]["SUNDOG_mesh"]["strands"], {"shape": "points", "radius": "_RADIUS"})
        self.assertEqual(arrays["POSITION"].reshape(-1).tolist(), places.tolist())
        self.near(arrays["_RADIUS"], sizes)
        self.assertEqual(found.array(primitive["indices"]).tolist(), list(range(30)))
        random = [object_info.random_number(object_info._mixed(n, 0)) for n in range(30)]
        self.near(arrays["_SUNDOG_0"][:, 0], random)

    def test_attributes(self):
        shown = strand_kit.points(self.scene, strand_kit.telling("ShaderNodeAttribute", "Color", attribute_name="shade"), 30)
        found = self.export()
        arrays = self.arrays(found, self.only(found, "points"))
        shade = numpy.empty(120, numpy.float32)
        shown.data.attributes["shade"].data.foreach_get("color", shade)
        self.near(arrays.get("_SUNDOG_0", arrays.get("COLOR_0"))[:, :3], shade.reshape(-1, 4)[:, :3])

    @unittest.skipUnless("type" in bpy.types.PointCloud.bl_rna.properties, "this Blender has no Gaussian splats")
    def test_gaussian_splats_are_told(self):
        data = bpy.data.pointclouds.new("splats")
        data.resize(3)
        data.type = "GAUSSIAN_SPLAT"
        self.link("splats", data)
        found = self.export()
        self.assertEqual(found.names(), [])
        self.assertIn("Gaussian splats", found.verdict("object", "splats")["detail"])

    def test_hair_switched_off_leaves_points(self):
        strand_kit.points(self.scene, None, 5)
        self.link("curves", strand_kit.curves(count=2))
        self.scene.view_layers[0].use_strand = False
        self.assertEqual(self.export().names(), ["points"])


if __name__ == "__main__":
    unittest.main()
