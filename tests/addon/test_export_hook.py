# SPDX-License-Identifier: GPL-3.0-or-later
"""File > Export > glTF 2.0 with the add-on enabled: its file says what the add-on's own export says."""

import json
import os
import struct
import unittest

import bpy
import export_kit as kit
import numpy
import addon_utils
import schema_check
import sundog
from mathutils import Matrix, Quaternion
from sundog.export import images


class Hook(kit.ExportTest):
    """The extensions in files of Blender's exporter."""

    def setUp(self):
        super().setUp()
        # Otherwise it is taken for one that was edited meanwhile, and read again.
        sundog.__time__ = os.path.getmtime(sundog.__file__)
        addon_utils.enable("sundog", default_set=True)
        bpy.context.window_manager.sundog_gltf_export.enabled = True

    def tearDown(self):
        addon_utils.disable("sundog", default_set=True)

    def stock(self, name="stock.glb", **options):
        """The document that File > Export writes."""
        path = os.path.join(self.folder, name)
        kind = "GLB" if name.endswith("glb") else "GLTF_SEPARATE"
        options = {"export_lights": True, "export_cameras": True, **options}
        with kit.quiet():
            bpy.ops.export_scene.gltf(filepath=path, export_format=kind, **options)
        with open(path, "rb") as file:
            data = file.read()
        text = data[20 : 20 + struct.unpack_from("<I", data, 12)[0]] if kind == "GLB" else data
        root = json.loads(text)
        self.assertEqual(list(schema_check.errors(root, kit.SCHEMA)), [])
        self.path = path
        return root

    def world_matrices(self, root):
        """Matrices of all nodes by name."""
        found = {}

        def visit(index, above):
            node = root["nodes"][index]
            x, y, z, w = node.get("rotation", (0, 0, 0, 1))
            local = Matrix.LocRotScale(node.get("translation", (0, 0, 0)), Quaternion((w, x, y, z)), node.get("scale", (1, 1, 1)))
            found[node["name"]] = above @ numpy.array(local)
            for child in node.get("children", ()):
                visit(child, found[node["name"]])

        for index in root["scenes"][0]["nodes"]:
            visit(index, numpy.eye(4))
        return found

    def lights_of(self, root):
        """SUNDOG_light by node."""
        result = {}
        for node in root["nodes"]:
            extensions = node.get("extensions", {})
            if "SUNDOG_light" in extensions:
                result[node["name"]] = extensions["SUNDOG_light"]
            elif "KHR_lights_punctual" in extensions:
                light = root["extensions"]["KHR_lights_punctual"]["lights"][extensions["KHR_lights_punctual"]["light"]]
                result[node["name"]] = light["extensions"]["SUNDOG_light"]
        return result

    def assert_same(self, got, expected, place="$"):
        """Equal, but for whole numbers that the exporter writes without point."""
        if isinstance(expected, dict):
            self.assertEqual(set(got), set(expected), place)
            for key in expected:
                self.assert_same(got[key], expected[key], f"{place}.{key}")
        elif isinstance(expected, list):
            self.assertEqual(len(got), len(expected), place)
            for index, pair in enumerate(zip(got, expected)):
                self.assert_same(*pair, f"{place}[{index}]")
        elif isinstance(expected, float):
            self.assertAlmostEqual(got, expected, 6, place)
        else:
            self.assertEqual(got, expected, place)

    def lit(self):
        """Lights of all kinds, one of them hanging on a turned and mirrored parent."""
        parent = self.link("parent", None, location=(1, 2, 3), rotation_euler=(0.3, 0.2, 0.1), scale=(1, -2, 1))
        for number, kind in enumerate(("POINT", "SPOT", "SUN", "AREA")):
            data = bpy.data.lights.new(kind, kind)
            made = self.link(kind, data, location=(number, 1, 2), rotation_euler=(0.5, 0.4, number))
            if kind == "AREA":
                data.shape, data.size, data.size_y = "RECTANGLE", 2, 0.5
                made.parent = parent

    def test_lights(self):
        self.lit()
        shared = self.link("second point", bpy.data.lights["POINT"], visible_glossy=False)
        ours = self.export()
        for options in ({"export_yup": False}, {}):
            root = self.stock(**options)
            got = self.lights_of(root)
            self.assertEqual(set(got), {"POINT", "SPOT", "SUN", "AREA", "second point"})
            for name, light in got.items():
                self.assert_same(light, ours.light(name), name)
        self.assertFalse(got[shared.name]["visibility"]["glossy"])
        self.assertNotIn("glossy", got["POINT"].get("visibility", {}))
        self.assertIn("SUNDOG_light", root["extensionsUsed"])
        self.assertNotIn("SUNDOG_light", root.get("extensionsRequired", ()))

    def test_places(self):
        self.lit()
        cube = self.link("cube", kit.cube(), location=(4, 5, 6))
        bpy.context.view_layer.update()
        for up in (True, False):
            places = self.world_matrices(self.stock(export_yup=up))
            turn = numpy.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]]) if up else numpy.eye(4)
            for name in ("AREA", "SUN", "SPOT", "camera"):
                shown = bpy.data.objects[name]
                # A light and a camera look along -Z in the file whatever its axes are.
                self.near(places[name], turn @ numpy.array(shown.matrix_world), 1e-5, f"{name} {up}")
            self.near(places["cube"][:3, 3], (turn @ numpy.array(cube.matrix_world))[:3, 3], 1e-6)

    def test_no_lights_wanted(self):
        self.lit()
        self.assertEqual(self.lights_of(self.stock(export_lights=False)), {})

    def test_switched_off(self):
        self.lit()
        bpy.context.window_manager.sundog_gltf_export.enabled = False
        root = self.stock()
        self.assertFalse([name for name in root.get("extensionsUsed", ()) if name.startswith("SUNDOG")])

    def test_objects(self):
        self.link("cube", kit.cube(), visible_camera=False, is_holdout=True)
        self.link("plain", kit.cube())
        root = self.stock()
        nodes = {node["name"]: node for node in root["nodes"]}
        self.assertEqual(nodes["cube"]["extensions"]["SUNDOG_object"], {"visibility": {"camera": False}, "holdout": True})
        self.assertNotIn("extensions", nodes["plain"])

    def test_camera_and_scene(self):
        data = self.camera.data
        data.dof.use_dof, data.dof.focus_object, data.shift_x = True, self.link("target", None), 0.25
        self.scene.world = bpy.data.worlds.new("world")
        self.scene.view_settings.exposure = 1.5
        self.scene.world = bpy.data.worlds.new("world")
        self.scene.cycles.use_fast_gi = self.scene.render.use_simplify = True
        self.scene.cycles.texture_limit_render = "512"
        ours, root = self.export(), self.stock()
        self.assertEqual(ours.scene()["texture_limit"], {"size": 512})
        self.assertEqual(ours.scene()["fast_gi"]["method"], "replace")
        camera = root["cameras"][0]["extensions"]["SUNDOG_camera"]
        self.assert_same(camera, ours["cameras"][0]["extensions"]["SUNDOG_camera"])
        self.assert_same(root["scenes"][0]["extensions"]["SUNDOG_scene"], ours.scene())

    def test_material(self):
        cube = self.link("cube", kit.cube())
        cube.data.materials.append(kit.material("m", Coat_Weight=0.5, Transmission_Weight=1.0))
        got = next(m for m in self.stock()["materials"] if m["name"] == "m")["extensions"]["SUNDOG_material"]
        self.assertFalse(got["thin_walled"])
        self.assertAlmostEqual(got["coat"]["weight"], 0.5)

    def test_world_image_lies_beside_the_file(self):
        path = os.path.join(self.folder, "elsewhere", "sky with blanks.exr")
        os.makedirs(os.path.dirname(path))
        images.write_exr(path, numpy.random.default_rng(1).random((8, 16, 3)))
        world = self.scene.world = bpy.data.worlds.new("world")
        world.use_nodes = True
        tree = world.node_tree
        picture = tree.nodes.new("ShaderNodeTexEnvironment")
        picture.image = bpy.data.images.load(path)
        tree.links.new(picture.outputs[0], tree.nodes["Background"].inputs["Color"])
        for name in ("a scene.glb", "another.gltf"):
            root = self.stock(name)
            got = root["scenes"][0]["extensions"]["SUNDOG_scene"]["world"]
            stem = name.rpartition(".")[0]
            self.assertEqual(got["image"], f"{stem}-world.exr".replace(" ", "%20"))
            self.near(kit.exr_pixels(os.path.join(self.folder, f"{stem}-world.exr")), kit.exr_pixels(path))
            self.assertNotIn("rotation", got)
        # Without "+Y Up" the reader's turn is taken back: direction (x, y, z) of the file is Blender's own.
        root = self.stock(export_yup=False)
        rotation = numpy.array(root["scenes"][0]["extensions"]["SUNDOG_scene"]["world"]["rotation"]).reshape(3, 3)
        for toward in ((1, 0, 0), (0, 1, 0), (0, 0, 1)):
            x, y, z = toward
            self.near(rotation @ numpy.array([x, -z, y]), toward)

    def test_the_program_reads_it(self):
        self.lit()
        self.link("cube", kit.cube()).data.materials.append(kit.material("m"))
        self.stock()
        self.assertEqual(kit.info(self.path)["meshes"], 1)

    def test_the_add_on_is_found_by_its_top_module(self):
        self.assertTrue(callable(sundog.glTF2ExportUserExtension))
        self.assertTrue(callable(sundog.draw_export))


if __name__ == "__main__":
    unittest.main()
