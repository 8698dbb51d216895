# SPDX-License-Identifier: GPL-3.0-or-later
"""The Ray Portal BSDF beside Cycles': another place in a wall, mixtures, depths, shadows, limits."""

import unittest

import bpy
import export_kit as kit

MEAN, ERROR = 0.01, 1e-3
FAR = 50.0


class RayPortals(kit.ExportTest):
    """Both programs' pictures of a wall with a portal, and of a room that is far from it."""

    def setUp(self):
        super().setUp()
        self.write_graphs(True)
        kit.unbiased(self.scene.cycles)
        kit.even_world(self.scene, 0.2)
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 3.6
        self.camera.location, self.camera.rotation_euler = (0, -6, 1.2), (1.45, 0, 0)
        self.grey = kit.material("grey", Base_Color=(0.7, 0.6, 0.5, 1), Roughness=0.6)
        self.add("floor", kit.plane(size=8), self.grey)
        lamp = bpy.data.lights.new("lamp", "AREA")
        lamp.energy, lamp.size = 120, 1.5
        self.link("lamp", lamp, location=(0, -1, 3.5))
        # A room elsewhere, with something that shines.
        self.add("there", kit.cube(size=2), self.shines(0.8, 0.2, 0.1), location=(FAR + 0.6, 1.5, 0.8), rotation_euler=(0.3, 0.2, 0.7))
        self.add("ground", kit.plane(size=8), self.grey, location=(FAR, 0, -0.2))

    def add(self, name, mesh, material, **settings):
        """An object with a material."""
        self.link(name, mesh, **settings).data.materials.append(material)

    def tree(self, name):
        """(material, its nodes, links, the surface's socket)."""
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        tree = made.node_tree
        tree.nodes.clear()
        return made, tree, tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]

    def shines(self, *color):
        """A material that emits."""
        made, tree, surface = self.tree("shines")
        glow = tree.nodes.new("ShaderNodeEmission")
        glow.inputs["Color"].default_value = (*color, 1)
        tree.links.new(glow.outputs[0], surface)
        return made

    def elsewhere(self, tree, color=(1, 1, 1, 1), moves=True):
        """A portal whose rays go on from as far along X."""
        portal = tree.nodes.new("ShaderNodeBsdfRayPortal")
        portal.inputs["Color"].default_value = color
        if moves:
            place, sum_ = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeVectorMath")
            sum_.inputs[1].default_value = (FAR, 0, 0)
            tree.links.new(place.outputs["Position"], sum_.inputs[0])
            tree.links.new(sum_.outputs[0], portal.inputs["Position"])
        return portal

    def mix(self, tree, first, second, factor):
        """A mix of two shaders."""
        made = tree.nodes.new("ShaderNodeMixShader")
        made.inputs[0].default_value = factor
        tree.links.new(first.outputs[0], made.inputs[1])
        tree.links.new(second.outputs[0], made.inputs[2])
        return made

    def wall(self, build, **place):
        """A wall in the middle, of what `build` makes of a tree."""
        made, tree, surface = self.tree("portal")
        tree.links.new(build(tree).outputs[0], surface)
        place = place or {"location": (0, 0, 1), "rotation_euler": (1.5708, 0, 0)}
        self.add("wall", kit.plane(size=1.9), made, **place)

    def agrees(self, samples=512, *more):
        """Both pictures are alike."""
        found = self.export()
        self.assertEqual({v["verdict"] for v in found.result.verdicts if v["kind"] == "material"}, {"exact"})
        # Of both programs two pictures of their own noise: the product of the differences has none.
        cycles = self.scene.cycles
        ours = [kit.rendered(found.path, 40, 30, samples, "--seed", str(seed), *more) for seed in (1, 2)]
        theirs = []
        for cycles.seed in (1, 2):
            theirs.append(kit.cycles_pixels(40, 30, samples))
        a, b = sum(ours) / 2, sum(theirs) / 2
        error = float(((ours[0] - theirs[0]) * (ours[1] - theirs[1]) / (b**2 + 0.01)).mean())
        print(f"{self.id().split('.')[-1]}: {a.mean():.5f} {b.mean():.5f} {a.mean() / b.mean() - 1:+.2%}, relMSE {error:.1e}")
        self.near(a.mean(), b.mean(), MEAN)
        self.assertLess(error, ERROR)
        return a

    def test_another_place_in_a_wall(self):
        self.wall(lambda tree: self.elsewhere(tree, (0.9, 0.8, 0.7, 1)))
        self.agrees()

    def test_straight_on_from_its_own_place(self):
        self.wall(lambda tree: self.elsewhere(tree, (0.9, 0.8, 0.7, 1), moves=False))
        self.agrees()

    def test_a_direction_of_its_own(self):
        def build(tree):
            portal = self.elsewhere(tree, moves=False)
            noise = tree.nodes.new("ShaderNodeTexNoise")
            lean = tree.nodes.new("ShaderNodeVectorMath")
            lean.operation, lean.inputs[1].default_value = "SUBTRACT", (0.5, 0.4, 0.6)
            # Cycles 4.5 shows other pictures for directions of other lengths.
            unit = tree.nodes.new("ShaderNodeVectorMath")
            unit.operation = "NORMALIZE"
            tree.links.new(noise.outputs["Color"], lean.inputs[0])
            tree.links.new(lean.outputs[0], unit.inputs[0])
            tree.links.new(unit.outputs[0], portal.inputs["Direction"])
            return portal

        self.wall(build)
        self.agrees()

    def test_a_mix_with_diffuse(self):
        self.wall(lambda tree: self.mix(tree, tree.nodes.new("ShaderNodeBsdfDiffuse"), self.elsewhere(tree), 0.4))
        self.agrees()

    def test_a_mix_with_a_transparent_principled(self):
        def build(tree):
            other = tree.nodes.new("ShaderNodeBsdfPrincipled")
            other.inputs["Alpha"].default_value, other.inputs["Metallic"].default_value = 0.5, 0.6
            return self.mix(tree, other, self.elsewhere(tree), 0.3)

        self.wall(build)
        self.agrees()

    def test_light_beside_a_portal(self):
        """A roof that is half transparent and half a portal: no light sample passes it."""
        def build(tree):
            return self.mix(tree, tree.nodes.new("ShaderNodeBsdfTransparent"), self.elsewhere(tree, moves=False), 0.5)

        self.wall(build, location=(0, -0.5, 2), scale=(2, 2, 2))
        self.agrees(1024)

    def test_depths_behind_a_portal(self):
        """What Light Path tells of a ray that has gone through one."""
        made, tree, surface = self.tree("depths")
        glow, path, sum_ = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("Emission", "LightPath", "CombineXYZ"))
        for number, (name, scale) in enumerate((("Portal Depth", 0.3), ("Transparent Depth", 0.2), ("Ray Length", 0.05))):
            if name not in path.outputs:
                name, scale = "Ray Depth", 1
            scaled = tree.nodes.new("ShaderNodeMath")
            scaled.operation, scaled.inputs[1].default_value = "MULTIPLY", scale
            tree.links.new(path.outputs[name], scaled.inputs[0])
            tree.links.new(scaled.outputs[0], sum_.inputs[number])
        tree.links.new(sum_.outputs[0], glow.inputs["Color"])
        tree.links.new(glow.outputs[0], surface)
        self.add("depths", kit.plane(size=5), made, location=(FAR, 0.4, 1), rotation_euler=(1.5708, 0, 0))
        self.wall(lambda tree: self.mix(tree, tree.nodes.new("ShaderNodeBsdfTransparent"), self.elsewhere(tree), 0.5))
        self.agrees()

    def test_limits(self):
        """A portal behind a portal, and no more than so many surfaces that are passed."""
        self.wall(lambda tree: self.elsewhere(tree))
        self.add("second", kit.plane(size=1.2), bpy.data.materials["portal"], location=(FAR, 0.3, 1), rotation_euler=(1.5708, 0, 0))
        self.add("beyond", kit.plane(size=6), self.shines(0.2, 0.9, 0.4), location=(2 * FAR, 3, 1), rotation_euler=(1.5708, 0, 0))
        whole = None
        # Cycles 4.5 lets rays pass one more.
        for limit in (8, 2, 1) if bpy.app.version >= (5, 0, 0) else (8, 2):
            self.scene.cycles.transparent_max_bounces = limit
            with self.subTest(limit=limit):
                mean = self.agrees().mean()
                whole = whole or mean
        if limit == 1:
            self.assertLess(mean, 0.9 * whole)

    def test_a_transparent_film(self):
        """Behind a portal there is no world, either."""
        self.wall(lambda tree: self.elsewhere(tree))
        self.scene.render.film_transparent = True
        self.agrees(512, "--transparent")


class Written(kit.ExportTest):
    """What stands in the file."""

    def nodes(self, build):
        """The nodes of a written material by their types, of a tree whose surface `build` returns."""
        self.write_graphs(True)
        made = bpy.data.materials.new("m")
        made.use_nodes = True
        tree = made.node_tree
        tree.nodes.clear()
        tree.links.new(build(tree), tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
        mesh = kit.plane()
        mesh.materials.append(made)
        self.link(made.name, mesh)
        found = self.export()
        self.assertEqual(found.verdict("material", made.name)["verdict"], "exact")
        graph = found.material(made.name)["extensions"].get("SUNDOG_shader_graph", {"nodes": []})
        return {node["type"]: node.get("inputs", {}) for node in graph["nodes"]}

    def test_places_are_written_where_they_are_linked(self):
        """An unlinked Position is where a ray has met the portal, whatever its numbers; those of Direction count."""
        for linked in (False, True):
            def build(tree, linked=linked):
                portal, place = tree.nodes.new("ShaderNodeBsdfRayPortal"), tree.nodes.new("ShaderNodeCombineXYZ")
                portal.inputs["Position"].default_value, portal.inputs["Direction"].default_value = (1, 2, 3), (0, 0, 2)
                place.inputs["Z"].default_value = 7
                if linked:
                    tree.links.new(place.outputs[0], portal.inputs["Position"])
                return portal.outputs[0]

            with self.subTest(linked=linked):
                portal = self.nodes(build)["ShaderNodeBsdfRayPortal"]
                self.assertEqual("Position" in portal, linked)
                self.assertEqual(portal["Direction"], [0, 0, 2])

    @unittest.skipIf(bpy.app.version >= (5, 0, 0), "Point Density is gone since Blender 5.0")
    def test_a_point_density_without_an_object_is_nothing(self):
        def build(tree):
            density, glow = tree.nodes.new("ShaderNodeTexPointDensity"), tree.nodes.new("ShaderNodeEmission")
            tree.links.new(density.outputs["Color"], glow.inputs["Color"])
            tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs[0], glow.inputs["Strength"])
            return glow.outputs[0]

        self.assertNotIn("ShaderNodeTexPointDensity", self.nodes(build))


if __name__ == "__main__":
    unittest.main()
