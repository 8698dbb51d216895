# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces in one plane that lie on each other, and lamps in the plane of a face, beside Cycles'."""

import export_kit as kit
import bpy
import mathutils
import numpy

SIZE = 32


class Coincident(kit.ExportTest):
    """What takes the light from what."""

    def setUp(self):
        super().setUp()
        self.scene.render.engine = "CYCLES"
        self.scene.render.resolution_x = self.scene.render.resolution_y = SIZE
        self.scene.render.resolution_percentage = 100
        kit.sun_and_grey_world(self.scene)
        self.camera.location, self.camera.rotation_euler = (0, -4, 5), (0.7, 0, 0)

    def plane(self, size, height, turn=(0, 0, 0), cuts=0):
        bpy.ops.mesh.primitive_grid_add(
            x_subdivisions=cuts + 1, y_subdivisions=cuts + 1, size=size, location=(0.1, 0, height), rotation=turn
        )
        shown = bpy.context.object
        shown.data.materials.append(kit.material("grey", Base_Color=(0.8, 0.8, 0.8, 1), Roughness=0.9))
        return shown

    def means(self, samples=64):
        found = self.export()
        cycles = kit.cycles_pixels(SIZE, SIZE, samples).mean()
        return kit.rendered(found.path, SIZE, SIZE, samples).mean(), cycles, found

    def test_faces_across_an_axis_are_dark(self):
        for height in (0.0, 0.7):
            self.plane(4, height)
            alone, cycles_alone, found = self.means()
            lid = self.plane(3, height, cuts=4)
            both, cycles_both, found = self.means()
            print(f"at {height}: {both / alone:.4f}, Cycles {cycles_both / cycles_alone:.4f}", flush=True)
            self.assertLess(abs(both / cycles_both - 1), 0.01)
            self.assertLess(both, 0.9 * alone)
            self.assertIn("coincident-faces", str(found.info()["effects"]))
            for shown in list(bpy.data.meshes):
                bpy.data.meshes.remove(shown)

    def test_of_a_shared_mesh_rounding_decides_across_an_axis_too(self):
        """But at heights that no product rounds: there the twins are black."""
        for height, is_dark in ((0.0, True), (-0.5, True), (-1.2, False), (3.7, False)):
            twins = [self.plane(8, height) for _ in range(2)]
            self.camera.location[2] = height + 5
            alone = bpy.data.objects.new("alone", twins[0].data)
            alone.location = (0, 0, -100)
            self.scene.collection.objects.link(alone)
            twins[1].data = twins[0].data
            twins[1].hide_render = True
            one, cycles_one, _ = self.means()
            twins[1].hide_render = False
            both, cycles_both, _ = self.means()
            print(f"shared, at {height}: {both / one:.4f}, Cycles {cycles_both / cycles_one:.4f}", flush=True)
            for share in (both / one, cycles_both / cycles_one):
                (self.assertLess if is_dark else self.assertGreater)(share, 0.2)
            for shown in list(bpy.data.meshes):
                bpy.data.meshes.remove(shown)

    def test_equal_meshes_of_modified_objects_are_not_shared_in_cycles(self):
        """A third object has an equal mesh: at this height rounding would decide, if all of them shared one."""
        for x in (0, 0, 100):
            shown = self.plane(8, -1.2)
            shown.location[0] += x
            shown.data = bpy.data.meshes.get("all") or shown.data
            shown.data.name = "all"
            shown.modifiers.new("array", "ARRAY").count = 2
        ours, cycles, found = self.means()
        objects = [node for node in found.root["nodes"] if "mesh" in node]
        self.assertEqual([node["extensions"]["SUNDOG_object"]["own_mesh"] for node in objects], [True] * 3)
        self.assertEqual(len({node["mesh"] for node in objects}), 1)
        print(f"{ours:.4f}, Cycles {cycles:.4f}", flush=True)
        self.assertLess(abs(ours / cycles - 1), 0.01)

    def test_what_is_pressed_flat_is_seen_where_cycles_applies_the_transform(self):
        floor = self.plane(8, -0.5)
        floor.data.materials[0] = kit.material("floor", Base_Color=(0.1, 0.3, 0.1, 1))
        bare = self.means()
        flat = self.plane(2, 0.2)
        flat.rotation_euler, flat.scale = (0, 0.5, 0), (1, 0, 1)
        flat.data.transform(mathutils.Matrix.Rotation(1.8, 4, "X"))
        alone = self.means()
        other = bpy.data.objects.new("other", flat.data)
        other.location = (0, 0, -100)
        self.scene.collection.objects.link(other)
        shared = self.means()
        for (ours, cycles, _), is_seen in ((alone, True), (shared, False)):
            print(f"{ours / bare[0]:.4f}, Cycles {cycles / bare[1]:.4f}", flush=True)
            self.assertLess(abs(ours / cycles - 1), 0.01)
            self.assertEqual(abs(cycles / bare[1] - 1) > 0.01, is_seen)

    def test_of_two_in_one_place_the_later_is_seen(self):
        def ball(name, color, shines):
            bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=1.5, rotation=(0.2, 0.1, 0))
            shine = {"Emission_Color": color, "Emission_Strength": 1.0} if shines else {"Base_Color": color}
            bpy.context.object.data.materials.append(kit.material(name, Roughness=0.9, **shine))

        red, green = (0.8, 0.1, 0.1, 1), (0.1, 0.8, 0.1, 1)
        for shines, colors in ((False, (red, green)), (False, (green, red)), (True, (red, green)), (True, (green, red))):
            for number, color in enumerate(colors):
                ball(f"ball {number}", color, shines)
            found = self.export()
            cycles = kit.cycles_pixels(SIZE, SIZE, 64).mean(axis=(0, 1))
            ours = kit.rendered(found.path, SIZE, SIZE, 64).mean(axis=(0, 1))
            print(f"the later one: {ours}, Cycles {cycles}", flush=True)
            self.assertEqual(ours.argmax(), numpy.argmax(colors[1][:3]))
            if not shines:
                self.assertLess(abs(ours / cycles - 1).max(), 0.02)
            for shown in list(bpy.data.meshes):
                bpy.data.meshes.remove(shown)

    def test_of_turned_faces_half_the_rays(self):
        turn = (0.2, 0.1, 0.3)
        self.plane(4, 0.3, turn)
        alone, cycles_alone, _ = self.means()
        self.plane(4, 0.3, turn)
        both, cycles_both, _ = self.means()
        print(f"turned: {both / alone:.4f}, Cycles {cycles_both / cycles_alone:.4f}", flush=True)
        # By rounding in Cycles, by chance here: half of the rays.
        self.assertLess(both, 0.85 * alone)
        self.assertLess(cycles_both, 0.85 * cycles_alone)

    def test_twins_of_twins_take_no_more(self):
        turn = (0.2, 0.1, 0.3)
        for _ in range(2):
            self.plane(4, 0.3, turn)
        two, cycles_two, _ = self.means()
        self.plane(4, 0.3, turn)
        three, cycles_three, _ = self.means()
        self.assertEqual(cycles_two, cycles_three)
        # The noise of a mean.
        self.assertLess(abs(three / two - 1), 0.01)

    def test_what_shines_inside_of_twins_comes_out(self):
        """A face that is met at the place of another one is met from inside."""
        self.scene.world = None
        for lamp in [shown for shown in bpy.data.objects if shown.type == "LIGHT"]:
            bpy.data.objects.remove(lamp)
        bpy.ops.object.light_add(type="POINT", radius=0.2)
        bpy.context.object.data.energy = 300
        kit.unbiased(self.scene.cycles)
        grey = kit.material("grey", Base_Color=(0.8, 0.8, 0.8, 1), Roughness=0.9)
        for number in range(2):
            bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=1, rotation=(0.3, 0.5, 0.7))
            bpy.context.object.data.materials.append(grey)
            got, seen, _ = self.means(128)
            print(f"{number + 1}: {got:.4f}, Cycles {seen:.4f}", flush=True)
            if number:
                # By rounding in Cycles, by chance here.
                self.assertLess(abs(got / seen - 1), 0.15)
            else:
                self.assertEqual((got, seen), (0.0, 0.0))

    @kit.long
    def test_solids_of_glass(self):
        """Of solids that stand twice, all refract twice or more often by rounding; of faces across an axis each lies on the other, so that
        nothing comes through."""
        bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -2))
        self.scene.camera.data.angle = 0.35
        glass = bpy.data.materials.new("glass")
        glass.use_nodes = True
        tree = glass.node_tree
        tree.nodes.clear()
        shader, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfGlass", "OutputMaterial"))
        shader.inputs["Roughness"].default_value = 0.2
        tree.links.new(shader.outputs[0], output.inputs["Surface"])
        kit.unbiased(self.scene.cycles)

        def cube(turn, at=(0, 0, 0)):
            bpy.ops.mesh.primitive_cube_add(size=2, rotation=turn, location=at)
            bpy.context.object.data.materials.append(glass)

        # The share of rays that meet the other one is another in each turned plane in Cycles.
        for name, turns, tolerance in (
            ("turned", [(0.3, 0.5, 0.7)] * 2, 0.15), ("across axes", [(0, 0, 0)] * 2, 0.01), ("side by side", [(0, 0, 0)] * 2, 0.05)
        ):  # fmt: skip
            with self.subTest(name):
                for made in [shown for shown in bpy.data.objects if shown.name.startswith("Cube")]:
                    bpy.data.objects.remove(made)
                for number, turn in enumerate(turns):
                    cube(turn, (2.0 * number, 0, 0) if name == "side by side" else (0, 0, 0))
                ours, cycles, _ = self.means(256)
                print(f"glass twice, {name}: {ours:.4f} {cycles:.4f} {ours / cycles - 1:+.2%}", flush=True)
                self.assertLess(abs(ours / cycles - 1), tolerance)

    def test_lamps_in_a_ceiling(self):
        self.scene.world = None
        for light in list(bpy.data.lights):
            bpy.data.lights.remove(light)
        # Rounding decides, and hangs on the numbers: from a floor at 0 more of the light is left than from others.
        for floor_height in (-0.3, 0):
            floor = self.plane(20, floor_height)
            for shape in ("SQUARE", "DISK"):
                for height in (2.5, 7.4205):
                    light = bpy.data.lights.new("lamp", "AREA")
                    light.energy, light.shape, light.size = 500, shape, 1
                    lamp = self.link("lamp", light)
                    lamp.location = (0, 0, height)
                    alone, cycles_alone, _ = self.means(128)
                    ceiling = self.plane(4, height)
                    both, cycles_both, _ = self.means(128)
                    ours, theirs = both / alone, cycles_both / cycles_alone
                    print(f"{shape} at {height}, floor at {floor_height}: {ours:.4f}, Cycles {theirs:.4f}", flush=True)
                    # What is left between them is how processors estimate reciprocals.
                    self.assertLess(abs(ours - theirs), 0.02)
                    self.assertGreater(ours, 0)
                    bpy.data.objects.remove(ceiling)
                    bpy.data.lights.remove(light)
            bpy.data.objects.remove(floor)

    def test_lamps_in_one_plane_are_told(self):
        def lamp(place, turn=(0.3, 0.2, 0), **settings):
            light = bpy.data.lights.new("lamp", "AREA")
            light.shape, light.size = "SQUARE", 2
            made = self.link("lamp", light)
            made.rotation_euler = turn
            bpy.context.view_layer.update()
            made.location = made.matrix_world.to_3x3() @ mathutils.Vector(place)
            return made

        lamps = [lamp(place) for place in ((0, 0, 3), (1.5, 0, 3), (0, 2.5, 3), (0, 0, 3.01))]
        lamps.append(lamp((1.5, 0, 3), (0.3, 0.3, 0)))
        # What is turned about one axis alone is rounded as in Cycles.
        lamps += [lamp(place, (0.3, 0, 0)) for place in ((0, 0, 6), (1.5, 0, 6))]
        found = self.export()
        told = [shown for shown in lamps if "overlaps" in found.verdict("light", shown.name)["detail"]]
        self.assertEqual(told, [lamps[1]])
