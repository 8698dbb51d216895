# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights: the numbers of the contract against closed forms, and those against what Cycles shows."""

import math
import unittest

import bpy
import export_kit as kit
import numpy
from mathutils import Matrix


class Numbers(kit.ExportTest):
    """SUNDOG_light of every kind of light."""

    def setUp(self):
        super().setUp()
        # What is here of nodes is what is done where a tree cannot be evaluated; test_parity_worlds has the others.
        self.write_graphs(False)

    def light(self, kind, name="light", **settings):
        data = bpy.data.lights.new(name, kind)
        for key, value in settings.items():
            setattr(data, key, value)
        self.link(name, data)
        return data

    def written(self, kind, **settings):
        self.light(kind, **settings)
        found = self.export()
        self.found = found
        return found.light("light")

    def test_point(self):
        got = self.written("POINT", energy=100, color=(1, 0.5, 0.25), shadow_soft_size=0.2)
        self.near(got["strength"], numpy.array([1, 0.5, 0.25]) * 100 / (4 * math.pi))
        self.assertAlmostEqual(got["radius"], 0.2, 6)
        self.assertEqual(got["max_bounces"], 1024)
        self.assertTrue(got["mis"])
        # Other readers get the exporter's lumens.
        plain = self.found.root["extensions"]["KHR_lights_punctual"]["lights"][0]
        self.assertEqual(plain["type"], "point")
        self.near(plain["intensity"], 683 * 100 / (4 * math.pi))
        self.near(plain["color"], [1, 0.5, 0.25])

    def test_the_size_of_a_point_is_not_scaled(self):
        self.light("POINT", shadow_soft_size=0.5)
        bpy.data.objects["light"].scale = (3, 3, 3)
        self.assertAlmostEqual(self.export().light("light")["radius"], 0.5)

    def test_spot(self):
        got = self.written("SPOT", energy=100, spot_size=1.2, spot_blend=0.25, shadow_soft_size=0)
        # A spot is cut from the point of the same power.
        self.near(got["strength"], [100 / (4 * math.pi)] * 3)
        self.assertAlmostEqual(got["half_angle"], 0.6, 6)
        self.assertAlmostEqual(got["blend"], 0.25)
        self.assertEqual(got["radius"], 0)
        plain = self.found.root["extensions"]["KHR_lights_punctual"]["lights"][0]["spot"]
        self.near([plain["outerConeAngle"], plain["innerConeAngle"]], [0.6, 0.45])

    def test_widest_spot(self):
        got = self.written("SPOT", spot_size=math.pi, spot_blend=0)
        self.assertAlmostEqual(got["half_angle"], math.pi / 2, 6)
        plain = self.found.root["extensions"]["KHR_lights_punctual"]["lights"][0]["spot"]
        self.assertLessEqual(plain["outerConeAngle"], math.pi / 2)
        self.assertLess(plain["innerConeAngle"], plain["outerConeAngle"])

    def test_sun(self):
        got = self.written("SUN", energy=3, color=(1, 0.5, 0.25), angle=0.05)
        self.near(got["strength"], [3, 1.5, 0.75])
        self.assertAlmostEqual(got["angle"], 0.05, 6)
        self.near(self.found.root["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"], 683 * 3)

    def test_area(self):
        shapes = {
            "SQUARE": ("rectangle", [2, 2]),
            "RECTANGLE": ("rectangle", [2, 0.5]),
            "DISK": ("ellipse", [2, 2]),
            "ELLIPSE": ("ellipse", [2, 0.5]),
        }
        for shape in shapes:
            self.light("AREA", shape, energy=50, color=(0.5, 1, 1), shape=shape, size=2, size_y=0.5, spread=1.25)
        found = self.export()
        for shape, (name, size) in shapes.items():
            got = found.light(shape)
            self.assertEqual((got["type"], got["shape"], got["normalize"]), ("area", name, True))
            self.near(got["size"], size)
            self.near(got["strength"], [0.5, 1, 1])
            self.assertAlmostEqual(got["power"], 50)
            self.assertAlmostEqual(got["spread"], 1.25, 6)
            # It has no place among the punctual lights.
            self.assertNotIn("KHR_lights_punctual", found.node(shape)["extensions"])

    def test_an_area_light_keeps_its_matrix(self):
        self.light("AREA")
        matrix = Matrix.Translation((1, 2, 3)) @ Matrix.Rotation(0.4, 4, "X") @ Matrix.Diagonal((2, -3, 1, 1))
        bpy.data.objects["light"].matrix_world = matrix
        bpy.context.view_layer.update()
        # glTF's light looks along -Z as Blender's does: no turn but that of the world.
        turn = numpy.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
        found = self.export()
        self.near(found.matrix(found.node("light")), turn @ numpy.array(bpy.data.objects["light"].matrix_world))

    def test_a_sheared_area_light_is_told(self):
        self.light("AREA")
        parent = self.link("parent", None, scale=(2, 1, 1))
        light = bpy.data.objects["light"]
        light.parent = parent
        self.assertEqual(self.export().verdict("light", "light")["verdict"], "exact")
        light.rotation_euler = (0, 0, 0.5)
        bpy.context.view_layer.update()
        got = self.export().verdict("light", "light")
        self.assertEqual(got["verdict"], "approximated")
        self.assertIn("shear", got["detail"])

    def test_portal(self):
        data = self.light("AREA")
        data.cycles.is_portal = True
        data.shape, data.size, data.size_y, data.energy = "RECTANGLE", 2.0, 3.0, 500.0
        found = self.export()
        (node,) = found.nodes("light")
        self.assertEqual(
            node["extensions"]["SUNDOG_light"], {"type": "portal", "name": "light", "shape": "rectangle", "size": [2.0, 3.0]}
        )
        self.assertEqual(found.verdict("light", "light")["verdict"], "exact")

    def test_temperature_and_exposure(self):
        if bpy.app.version < (4, 5, 0):
            self.skipTest("lights have these from Blender 4.5 on")
        got = self.written("POINT", energy=10, exposure=2, use_temperature=True, temperature=3000, color=(1, 1, 0.5))
        self.assertTrue(got["strength"][0] > got["strength"][1] > got["strength"][2])
        data = bpy.data.lights["light"]
        expected = numpy.array(list(data.temperature_color)) * [1, 1, 0.5] * 40 / (4 * math.pi)
        self.near(got["strength"], expected)

    def test_not_normalized(self):
        if bpy.app.version < (4, 5, 0):
            self.skipTest("lights have this from Blender 4.5 on")
        self.light("POINT", "point", normalize=False, energy=7, shadow_soft_size=0.5)
        self.light("SUN", "sun", normalize=False, energy=7, angle=0.5)
        self.light("AREA", "area", normalize=False, energy=7)
        found = self.export()
        # Radiance 7/pi of a disc of radius 1/2; radiance 7 within the sun's solid angle, by its cosine.
        self.near(found.light("point")["strength"], [7 / math.pi * math.pi * 0.25] * 3)
        self.near(found.light("sun")["strength"], [7 * math.pi * math.sin(0.25) ** 2] * 3)
        self.assertFalse(found.light("area")["normalize"])

    def test_visibility(self):
        self.light("POINT")
        shown = bpy.data.objects["light"]
        # Blender's new lights are not seen by the camera.
        self.assertEqual(self.export().light("light")["visibility"], {"camera": False})
        shown.visible_glossy = False
        self.assertEqual(self.export().light("light")["visibility"], {"camera": False, "glossy": False})

    def test_shadow_switch(self):
        data = self.light("POINT")
        data.use_shadow = False
        if hasattr(data.cycles, "cast_shadow"):
            data.cycles.cast_shadow = False
        self.assertEqual(self.export().light("light")["visibility"], {"camera": False, "shadow": False})

    def test_bounces_and_mis(self):
        data = self.light("POINT")
        data.cycles.max_bounces = 3
        data.cycles.use_multiple_importance_sampling = False
        got = self.export().light("light")
        self.assertEqual((got["max_bounces"], got["mis"]), (3, False))

    def test_shadow_caustics_are_told(self):
        data = self.light("POINT")
        ball = self.link("ball", kit.cube("ball"))
        data.cycles.is_caustics_light = True
        self.assertEqual(self.export().verdict("light", "light")["verdict"], "exact")
        ball.cycles.is_caustics_caster = ball.cycles.is_caustics_receiver = True
        found = self.export().verdict("light", "light")
        self.assertEqual(found["verdict"], "approximated")
        self.assertIn("caustics", found["detail"])

    def test_hidden_light(self):
        self.light("POINT")
        bpy.data.objects["light"].hide_render = True
        self.assertEqual(self.export().nodes("light"), [])

    def test_instanced_lights(self):
        inside = bpy.data.collections.new("inside")
        data = bpy.data.lights.new("bulb", "POINT")
        inside.objects.link(bpy.data.objects.new("bulb", data))
        for x in range(3):
            self.link(f"place {x}", None, instance_type="COLLECTION", instance_collection=inside, location=(x, 0, 0))
        found = self.export()
        self.assertEqual(sorted(found.matrix(n)[0, 3] for n in found.nodes("bulb")), [0, 1, 2])
        # Equal lights stand once in the file.
        self.assertEqual(len(found.root["extensions"]["KHR_lights_punctual"]["lights"]), 1)

    def nodes(self, data):
        data.use_nodes = True
        tree = data.node_tree
        return tree, next(n for n in tree.nodes if n.type == "EMISSION")

    def test_emission_node(self):
        data = self.light("POINT", energy=4 * math.pi)
        tree, emission = self.nodes(data)
        emission.inputs["Color"].default_value = (0.5, 1, 0.25, 1)
        emission.inputs["Strength"].default_value = 3
        found = self.export()
        self.near(found.light("light")["strength"], [1.5, 3, 0.75])
        self.assertEqual(found.verdict("light", "light")["verdict"], "exact")

    def test_falloff_and_blackbody_nodes(self):
        data = self.light("POINT", energy=4 * math.pi)
        tree, emission = self.nodes(data)
        falloff = tree.nodes.new("ShaderNodeLightFalloff")
        falloff.inputs["Strength"].default_value = 2
        tree.links.new(falloff.outputs["Quadratic"], emission.inputs["Strength"])
        body = tree.nodes.new("ShaderNodeBlackbody")
        body.inputs[0].default_value = 6500
        tree.links.new(body.outputs[0], emission.inputs["Color"])
        found = self.export()
        self.assertEqual(found.verdict("light", "light")["verdict"], "exact")
        luminance = numpy.array(found.light("light")["strength"]) @ [0.2126, 0.7152, 0.0722]
        self.near(luminance, 2, 2e-3)
        tree.links.new(falloff.outputs["Linear"], emission.inputs["Strength"])
        self.assertEqual(self.export().verdict("light", "light")["verdict"], "approximated")

    def profile(self, candela):
        """A text in the form of LM-63, of candela at each 10 degrees from the axis."""
        angles = " ".join(str(10 * i) for i in range(len(candela)))
        values = " ".join(str(v) for v in candela)
        text = bpy.data.texts.new("profile")
        text.write(f"IESNA:LM-63-1995\n[TEST] made up\nTILT=NONE\n1 1000 2.0 {len(candela)} 1 1 2 0 0 0\n1 1 10\n{angles}\n0\n{values}\n")
        return text

    def brightness(self):
        """(mean of the program's picture, of Cycles') of a floor two metres wide under the light, one metre away."""
        floor = kit.plane("floor", 2)
        floor.materials.append(kit.material("floor", Base_Color=(0.5, 0.5, 0.5, 1), Specular_IOR_Level=0.0))
        self.link("floor", floor)
        bpy.data.objects["light"].location = (0, 0, 1)
        data = self.camera.data
        data.type, data.ortho_scale = "ORTHO", 2
        self.scene.render.resolution_x = self.scene.render.resolution_y = 16
        found = self.export()
        return found, kit.rendered(found.path, 16, 16, 64).mean(), kit.cycles_pixels(16, 16, 64).mean()

    def test_ies(self):
        falling = [1000, 950, 800, 600, 400, 200, 100, 50, 20, 0]
        for kind, settings in (("SPOT", {"spot_size": 1.2, "spot_blend": 0.2}), ("POINT", {})):
            with self.subTest(kind=kind):
                self.setUp()
                data = self.light(kind, energy=10, shadow_soft_size=0.05, **settings)
                tree, emission = self.nodes(data)
                node = tree.nodes.new("ShaderNodeTexIES")
                node.ies = self.profile(falling)
                tree.links.new(node.outputs[0], emission.inputs["Strength"])
                found, got, seen = self.brightness()
                # A point's light is spread over all directions, where the profile has it on one side.
                self.assertLess(max(got / seen, seen / got), 1.25 if kind == "SPOT" else 6)
                verdict = found.verdict("light", "light")
                self.assertEqual(verdict["verdict"], "approximated")
                self.assertIn("its cone" if kind == "SPOT" else "all directions", verdict["detail"])

    def test_the_axis_of_an_ies_profile_is_that_of_cycles(self):
        data = self.light("SUN", energy=1)
        tree, emission = self.nodes(data)
        node = tree.nodes.new("ShaderNodeTexIES")
        node.ies = self.profile([1000] * 19)
        tree.links.new(node.outputs[0], emission.inputs["Strength"])
        _, got, seen = self.brightness()
        # Cycles 4.5 shows 1.083 times as much as 5.0, whose number is taken.
        self.near(got, seen, 0.01 if bpy.app.version >= (5, 0, 0) else 0.08)

    def test_ies_that_is_no_profile(self):
        for words in ("", "TILT=NONE\n1 1 1 1000000 1000000", "TILT=NONE\nno numbers", "TILT=INCLUDE\n1 99999999 1"):
            with self.subTest(words=words):
                self.setUp()
                data = self.light("POINT", energy=1)
                tree, emission = self.nodes(data)
                node = tree.nodes.new("ShaderNodeTexIES")
                tree.links.new(node.outputs[0], emission.inputs["Strength"])
                node.ies = bpy.data.texts.new("broken")
                node.ies.write(words)
                found, got, seen = self.brightness()
                self.near(got, seen, 0.01)
                verdict = found.verdict("light", "light")
                self.assertEqual(verdict["verdict"], "exact")
                self.assertIn("missing or broken: 100 in all directions", verdict["detail"])

    def test_light_falloff(self):
        for name, smooth in (("Quadratic", 1.0), ("Linear", 0.0), ("Constant", 0.5)):
            with self.subTest(name=name):
                self.setUp()
                data = self.light("POINT", energy=50, shadow_soft_size=0.05)
                tree, emission = self.nodes(data)
                falloff = tree.nodes.new("ShaderNodeLightFalloff")
                falloff.inputs["Strength"].default_value, falloff.inputs["Smooth"].default_value = 3, smooth
                tree.links.new(falloff.outputs[name], emission.inputs["Strength"])
                found, got, seen = self.brightness()
                # The floor is up to 1.7 m away.
                self.assertLess(max(got / seen, seen / got), 2, (got, seen))
                self.assertIn("one metre", found.verdict("light", "light")["detail"])

    def test_vectors_of_a_light(self):
        # The direction from the lamp in its own space, squared by a dot product: 1 everywhere.
        data = self.light("POINT", energy=10, shadow_soft_size=0.05)
        tree, emission = self.nodes(data)
        place = tree.nodes.new("ShaderNodeTexCoord")
        dot = tree.nodes.new("ShaderNodeVectorMath")
        dot.operation = "DOT_PRODUCT"
        for socket in dot.inputs[:2]:
            tree.links.new(place.outputs["Normal"], socket)
        tree.links.new(dot.outputs["Value"], emission.inputs["Strength"])
        found, got, seen = self.brightness()
        self.near(got, seen, 0.03)
        self.assertEqual(found.verdict("light", "light")["verdict"], "approximated")

    def test_procedural_light(self):
        data = self.light("AREA")
        tree, emission = self.nodes(data)
        noise = tree.nodes.new("ShaderNodeTexNoise")
        tree.links.new(noise.outputs["Color"], emission.inputs["Color"])
        got = self.export().verdict("light", "light")
        self.assertEqual(got["verdict"], "approximated")
        self.assertIn("Noise Texture", got["detail"])

    def test_light_without_emission(self):
        data = self.light("POINT")
        tree, emission = self.nodes(data)
        tree.nodes.remove(emission)
        self.near(self.export().light("light")["strength"], [0, 0, 0])

    def test_driven_strength(self):
        data = self.light("POINT")
        tree, emission = self.nodes(data)
        driver = emission.inputs["Strength"].driver_add("default_value").driver
        driver.expression = "2.5"
        data.energy = 4 * math.pi
        bpy.context.view_layer.update()
        self.near(self.export().light("light")["strength"], [2.5] * 3)

    def test_negative_light(self):
        got = self.written("POINT", energy=-4 * math.pi)
        self.near(got["strength"], [-1, -1, -1])


class AgainstCycles(kit.ExportTest):
    """The closed forms of the contract against pictures by Cycles of lights that the camera looks at."""

    def radiance(self, data, distance=2.0, scale=(1, 1, 1)):
        made = self.link("light", data, scale=scale, rotation_euler=(math.pi, 0, 0), visible_camera=True)
        self.camera.location = (0, 0, distance)
        self.camera.data.lens = 1000
        return kit.cycles_pixels(4, 4, 1).reshape(-1, 3).mean(axis=0), self.export().light("light"), made

    def test_area(self):
        for shape, share in (("SQUARE", 1), ("ELLIPSE", math.pi / 4)):
            for scale in ((1, 1, 1), (2, -3, 1)):
                with self.subTest(shape=shape, scale=scale):
                    data = bpy.data.lights.new("light", "AREA")
                    data.energy, data.shape, data.size, data.size_y = 10, shape, 0.5, 1
                    seen, got, made = self.radiance(data, scale=scale)
                    area = numpy.prod(got["size"]) * share * abs(scale[0] * scale[1])
                    self.near(seen, numpy.array(got["strength"]) * got["power"] / (math.pi * area), 1e-5)
                    bpy.data.objects.remove(made)

    def test_area_not_normalized(self):
        if bpy.app.version < (4, 5, 0):
            self.skipTest("lights have this from Blender 4.5 on")
        data = bpy.data.lights.new("light", "AREA")
        data.energy, data.normalize, data.size = 10, False, 0.5
        seen, got, _ = self.radiance(data, scale=(2, 2, 2))
        self.near(seen, [10 / math.pi] * 3, 1e-5)

    def test_point(self):
        for normalize in (True, False) if bpy.app.version >= (4, 5, 0) else (True,):
            with self.subTest(normalize=normalize):
                data = bpy.data.lights.new("light", "POINT")
                data.energy, data.shadow_soft_size, data.use_soft_falloff = 10, 0.5, False
                if not normalize:
                    data.normalize = False
                seen, got, made = self.radiance(data, scale=(2, 2, 2))
                self.near(seen, numpy.array(got["strength"]) / (math.pi * 0.5**2), 1e-5)
                bpy.data.objects.remove(made)

    def test_sun(self):
        for normalize in (True, False) if bpy.app.version >= (4, 5, 0) else (True,):
            with self.subTest(normalize=normalize):
                data = bpy.data.lights.new("light", "SUN")
                data.energy, data.angle = 3, 0.6
                if not normalize:
                    data.normalize = False
                seen, got, made = self.radiance(data)
                self.near(seen, numpy.array(got["strength"]) / (math.pi * math.sin(0.3) ** 2), 1e-5)
                bpy.data.objects.remove(made)


if __name__ == "__main__":
    unittest.main()
