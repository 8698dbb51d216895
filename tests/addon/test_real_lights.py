# SPDX-License-Identifier: GPL-3.0-or-later
"""Which light is drawn how often: what made clamped files of others look different from Cycles, in small scenes."""

import bpy
import export_kit as kit
import mathutils


class Clamped(kit.ExportTest):
    """Both programs' pictures of scenes that clamp."""

    def setUp(self):
        super().setUp()
        self.write_graphs(True)
        kit.unbiased(self.scene.cycles)
        kit.even_world(self.scene, 1)
        self.camera.data.type, self.camera.data.ortho_scale, self.camera.location = "ORTHO", 4, (0, 0, 2.5)

    def emission(self, strength):
        """A material that emits alone."""
        made = bpy.data.materials.new("sign")
        made.use_nodes = True
        tree = made.node_tree
        tree.nodes.clear()
        glow, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Emission", "OutputMaterial"))
        glow.inputs["Strength"].default_value = strength
        tree.links.new(glow.outputs[0], output.inputs["Surface"])
        return made

    def lamp(self, kind, energy, location=(0, 0, 0), **values):
        """A lamp that looks down."""
        lamp = bpy.data.lights.new(kind, kind)
        lamp.energy = energy
        for name, value in values.items():
            setattr(lamp, name, value)
        return self.link(kind, lamp, location=location)

    def room(self):
        """A floor below a panel, a lamp and a sun."""
        self.link("floor", kit.plane(size=8)).data.materials.append(kit.material("floor", Base_Color=(0.8, 0.8, 0.8, 1), Roughness=1))
        self.link("panel", kit.plane(size=3), location=(1, 0, 4), rotation_euler=(3.1416, 0, 0)).data.materials.append(self.emission(10))
        self.lamp("POINT", 150, (-2, 0, 3), shadow_soft_size=0.1)
        self.lamp("SUN", 0.5)
        self.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.05

    def clamped(self, clamp, flag, samples=512):
        """(Sundog's with a flag, Cycles', Sundog's without it) means."""
        cycles = self.scene.cycles
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = clamp
        theirs = kit.cycles_pixels(16, 16, samples).mean()
        found = self.export()
        clamps = ("--clamp-direct", str(clamp), "--clamp-indirect", str(clamp))
        ours, by_place = (kit.rendered(found.path, 16, 16, samples, *clamps, *more).mean() for more in ([flag], []))
        print(f"{self.id().split('.')[-1]}: {ours:.5f} {theirs:.5f} {ours / theirs - 1:+.2%}, by places {by_place / theirs - 1:+.2%}")
        return ours, theirs, by_place

    def test_clamps_without_the_light_tree(self):
        """Clamping takes more from lights that are drawn more seldom: files of before Blender 3.5 have no light tree."""
        self.room()
        self.scene.cycles.use_light_tree = False
        ours, theirs, by_place = self.clamped(0.7, "--even-lights")
        self.near(ours, theirs, 0.01)
        self.assertGreater(abs(by_place / theirs - 1), 0.02)

    def test_clamps_of_two_triangles(self):
        """A panel to the side: the nearer one of its triangles fills more of the view, and is drawn as often as the other one."""
        self.link("floor", kit.plane(size=8)).data.materials.append(kit.material("floor", Base_Color=(0.8, 0.8, 0.8, 1), Roughness=1))
        self.link("panel", kit.plane(size=10), location=(6, 6, 5), rotation_euler=(2.3, 0, 0)).data.materials.append(self.emission(3))
        kit.even_world(self.scene, 0)
        self.scene.cycles.use_light_tree = False
        ours, theirs, by_place = self.clamped(0.7, "--even-lights")
        self.near(ours, theirs, 0.003)
        self.assertGreater(abs(by_place / theirs - 1), 0.005)

    def test_light_below_smooth_normals(self):
        """Light samples alone bring what coarse smooth meshes get from below their triangles: how much of it hangs on the choice of lights."""
        bpy.ops.mesh.primitive_cube_add(size=2, rotation=(0.2, 0.3, 0.1))
        bpy.context.object.data.shade_smooth()
        bpy.context.object.data.materials.append(kit.material("gloss", Base_Color=(0, 0, 0, 1), Roughness=0.4))
        for x, turn in ((-4, 1.5708), (4, 1.4)):
            panel = self.link("panel", kit.plane(size=3), location=(x, 0.5, -0.5), rotation_euler=(0, turn, 0))
            panel.data.materials.append(self.emission(10))
        kit.even_world(self.scene, 0)
        ours, theirs = [], []
        for flag in ("--even-lights", "--tree-lights"):
            self.scene.cycles.use_light_tree = flag == "--tree-lights"
            theirs.append(kit.cycles_pixels(16, 16, 1024).mean())
            ours.append(kit.rendered(self.export().path, 16, 16, 1024, flag).mean())
            print(f"below smooth normals, {flag}: {ours[-1]:.5f} {theirs[-1]:.5f} {ours[-1] / theirs[-1] - 1:+.2%}")
            # A cube stands for a sphere here, from which rays leave elsewhere in each program.
            self.near(ours[-1], theirs[-1], 0.02)
        self.near(ours[1] / ours[0], theirs[1] / theirs[0], 0.005)

    def test_clamps_with_the_light_tree(self):
        """The same by Cycles' estimates for each place, of a panel, a lamp and a sun."""
        self.room()
        ours, theirs, _ = self.clamped(0.7, "--tree-lights")
        self.near(ours, theirs, 0.01)

    def test_clamps_of_many_lights(self):
        """Lamps of all kinds that make a tree of some turns, a world and a sphere that shines."""
        self.room()
        self.lamp("AREA", 60, (1.5, 1.5, 1.5), shape="DISK", size=0.6)
        self.lamp("AREA", 40, (-1.5, 1.5, 1), shape="RECTANGLE", size=0.5, size_y=1, spread=1.5)
        for i in range(9):
            self.lamp("POINT" if i % 2 else "SPOT", 10 + 4 * i, (i % 3 - 1.2, i // 3 - 1, 0.8 + 0.2 * i), shadow_soft_size=0.05 * (i % 3))
        bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=6, radius=0.4, location=(0, -1.4, 1))
        bpy.context.object.data.materials.append(self.emission(6))
        world = self.scene.world.node_tree
        noise = world.nodes.new("ShaderNodeTexNoise")
        world.links.new(noise.outputs[0], world.nodes["Background"].inputs["Color"])
        world.nodes["Background"].inputs["Strength"].default_value = 1
        ours, theirs, by_place = self.clamped(0.7, "--tree-lights")
        self.near(ours, theirs, 0.01)
        self.assertGreater(abs(by_place / theirs - 1), 0.02)

    def test_clamps_behind_rough_glass(self):
        """Lamps of different kinds on both sides of what lets light through."""
        self.room()
        made = bpy.data.materials.new("glass")
        made.use_nodes = True
        tree = made.node_tree
        tree.nodes.clear()
        shader, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("BsdfGlass", "OutputMaterial"))
        shader.inputs["Roughness"].default_value = 0.5
        tree.links.new(shader.outputs[0], output.inputs["Surface"])
        self.link("pane", kit.plane(size=3), location=(0, 0, 1)).data.materials.append(made)
        self.lamp("POINT", 20, (0, 0, 0.5), shadow_soft_size=0)
        ours, theirs, _ = self.clamped(1, "--tree-lights", 2048)
        self.near(ours, theirs, 0.01)

    def test_clamps_of_a_sky_with_a_sun(self):
        """Cycles gives four fifths of a sky's samples to its sun."""
        self.link("floor", kit.plane(size=8)).data.materials.append(kit.material("floor", Base_Color=(0.8, 0.8, 0.8, 1), Roughness=1))
        world = self.scene.world.node_tree
        sky = world.nodes.new("ShaderNodeTexSky")
        sky.sun_intensity, sky.sun_elevation = 0.1, 0.4
        world.links.new(sky.outputs[0], world.nodes["Background"].inputs["Color"])
        ours, theirs, by_place = self.clamped(1, "--tree-lights")
        self.near(ours, theirs, 0.01)
        self.assertGreater(abs(by_place / theirs - 1), 0.02)

    def pictures(self, samples):
        """(Sundog's, Cycles') means, not clamped."""
        ours, theirs = kit.rendered(self.export().path, 16, 16, samples).mean(), kit.cycles_pixels(16, 16, samples).mean()
        print(f"{self.id().split('.')[-1]}: {ours:.5f} {theirs:.5f} {ours / theirs - 1:+.2%}")
        return ours, theirs

    def test_area_lights_in_one_plane(self):
        """A ray of Cycles finds the first of them alone; which is first, and by how much, is a matter of rounding."""
        self.link("floor", kit.plane(size=20)).data.materials.append(kit.material("floor", Base_Color=(0.8, 0.8, 0.8, 1), Roughness=1))
        self.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
        self.camera.location = (0, 0, 1)
        for turn in ((0, 0, 0), (0.3, 0, 0)):
            matrix = mathutils.Euler(turn).to_matrix()
            for energies in ((500, 100), (100, 500)):
                with self.subTest(turn=turn, energies=energies):
                    lamps = [
                        self.lamp("AREA", energy, mathutils.Vector((0, 0, 3)) + matrix @ mathutils.Vector(place), size=6)
                        for energy, place in zip(energies, ((0, 0, 0), (2, 1, 0)))
                    ]
                    for lamp in lamps:
                        lamp.rotation_euler = turn
                    ours, theirs = self.pictures(256)
                    for lamp in lamps:
                        bpy.data.objects.remove(lamp)
                    self.near(ours, theirs, 0.01)

    def test_lamps_without_shadows(self):
        """Rays find them only where nothing is in between, and have their share there: what is behind a panel gets the others' alone."""
        floor = self.link("floor", kit.plane(size=20))
        floor.data.materials.append(kit.material("floor", Base_Color=(0.8, 0.8, 0.8, 1), Roughness=0.4))
        panel = self.link("panel", kit.plane(size=4), location=(0, 0, 1))
        panel.data.materials.append(kit.material("panel", Base_Color=(0, 0, 0, 1), Roughness=1, Specular_IOR_Level=0))
        panel.visible_camera = False
        self.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
        for kind, energy, values in (("SUN", 3, {"angle": 0.9}), ("AREA", 300, {"size": 4})):
            with self.subTest(kind=kind):
                lamp = self.lamp(kind, energy, (0, 0, 3), **values)
                lamp.data.use_shadow = False
                beside = self.lamp("POINT", 50, (3, 0, 2))
                ours, theirs = self.pictures(1024)
                self.near(ours, theirs, 0.005)
                for each in (lamp, beside):
                    bpy.data.objects.remove(each)

    def test_clamps_without_roulette(self):
        """Paths that end by chance carry more where they go on, and more of it is clamped."""
        bpy.ops.mesh.primitive_cube_add(size=6)
        bpy.context.object.data.materials.append(kit.material("room", Base_Color=(0.3, 0.3, 0.3, 1), Roughness=1, Specular_IOR_Level=0))
        self.lamp("POINT", 300, (2, 2, -2), shadow_soft_size=0.1)
        self.scene.cycles.min_light_bounces = 8
        ours, theirs, with_roulette = self.clamped(0.3, "--roulette=10")
        self.near(ours, theirs, 0.005)
        self.assertGreater(abs(with_roulette / theirs - 1), 0.01)

    def test_who_asks_for_shares(self):
        """Settings with a clamp, and those without the light tree."""
        from sundog import command, program, properties

        # Other tests of the same Blender may have left the add-on switched on.
        if not hasattr(bpy.types.Scene, "sundog"):
            properties.register()
            self.addCleanup(properties.unregister)
        scene, layer = self.scene, self.scene.view_layers[0]
        for tree, clamp, expected in ((True, 1, {"--tree-lights"}), (False, 1, {"--even-lights"}), (False, 0, {"--even-lights"}), (True, 0, set())):
            scene.cycles.use_light_tree, scene.sundog.sample_clamp_indirect = tree, clamp
            flags = command.arguments(scene, layer, program.abilities(kit.program()), self.fail)
            self.assertEqual({"--even-lights", "--tree-lights"}.intersection(flags), expected, (tree, clamp))
