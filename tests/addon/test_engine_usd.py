# SPDX-License-Identifier: GPL-3.0-or-later
"""The engine that gets its scene by USD: the same picture, and what it loses by name."""

import math
import os
import threading

import bpy
import numpy

from engine_kit import EngineTest, engine
from sundog.export import usd

WIDTH, HEIGHT = 96, 64


class ByUsd(EngineTest):
    """Renders with the exchange set to USD."""

    def setUp(self):
        super().setUp()
        self.scene.render.resolution_x, self.scene.render.resolution_y = WIDTH, HEIGHT
        self.scene.sundog.samples = 64
        self.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.77

    def pictures(self):
        """Combined by glTF and by USD."""
        found = []
        for exchange in ("GLTF", "USD"):
            self.scene.sundog.exchange = exchange
            found.append(self.render(exchange)["ViewLayer.Combined"][..., :3].astype(float))
        return found

    def assert_same(self, bound=1e-4):
        """relMSE of both pictures."""
        reference, other = self.pictures()
        self.assertGreater(reference.mean(), 1e-3)
        found = float(((other - reference) ** 2 / (reference**2 + 1e-2 * (reference**2).mean())).mean())
        print(f"{self.id().rpartition('.')[2]}: relMSE of USD to glTF {found:.3g}", flush=True)
        self.assertLess(found, bound)

    def lost(self):
        """What the last render lost: details by name."""
        return {v["name"]: v["detail"] for v in engine.last_verdicts() if v["verdict"] == "lost"}

    def test_the_picture_is_that_by_gltf(self):
        lamp = next(o for o in bpy.data.objects if o.type == "LIGHT").data
        lamp.use_soft_falloff = False
        self.assert_same()
        self.assertEqual(self.lost(), {})
        command = engine.last_statistics()["command"]
        self.assertTrue(command[2].endswith("scene.usda"), command)
        self.assertEqual(command[command.index("--camera") + 1], "Camera")

    def test_modifiers_and_instances_are_those_of_the_render(self):
        lamp = next(o for o in bpy.data.objects if o.type == "LIGHT").data
        lamp.use_soft_falloff = False
        cube = bpy.data.objects["Cube"]
        divided = cube.modifiers.new("divided", "SUBSURF")
        divided.levels, divided.render_levels = 0, 2
        # One that is not rendered, and an instancer.
        bpy.ops.mesh.primitive_cube_add(location=(0, 0, 2))
        bpy.context.object.hide_render = True
        collection = bpy.data.collections.new("balls")
        ball = bpy.data.objects.new("ball", cube.data)
        ball.scale = (0.3, 0.3, 0.3)
        collection.objects.link(ball)
        for place in ((2, 0, 0), (0, 2, 0.5)):
            placed = bpy.data.objects.new("placed", None)
            placed.instance_type, placed.instance_collection = "COLLECTION", collection
            placed.location = place
            self.scene.collection.objects.link(placed)
        self.assert_same()

    def test_the_scenes_camera_is_the_one(self):
        data = bpy.data.cameras.new("other")
        other = bpy.data.objects.new("A camera of its own", data)
        other.matrix_world = self.scene.camera.matrix_world
        self.scene.collection.objects.link(other)
        data.lens, data.shift_x = 80.0, 0.1
        bpy.context.view_layer.update()
        self.scene.camera = other
        next(o for o in bpy.data.objects if o.type == "LIGHT").data.use_soft_falloff = False
        self.assert_same()

    def test_what_usd_lacks_is_named(self):
        lamp = next(o for o in bpy.data.objects if o.type == "LIGHT")
        lamp.data.use_soft_falloff = True
        lamp.visible_glossy = False
        cube = bpy.data.objects["Cube"]
        cube.is_shadow_catcher = True
        cube.visible_diffuse = False
        tree = cube.material_slots[0].material.node_tree
        surface = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
        group = bpy.data.node_groups.new("inner", "ShaderNodeTree")
        group.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
        voronoi, end = group.nodes.new("ShaderNodeTexVoronoi"), group.nodes.new("NodeGroupOutput")
        group.links.new(voronoi.outputs["Color"], end.inputs[0])
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        tree.links.new(node.outputs[0], surface.inputs["Base Color"])
        output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
        tree.links.new(tree.nodes.new("ShaderNodeDisplacement").outputs[0], output.inputs["Displacement"])
        self.scene.render.use_motion_blur = True
        floor = bpy.data.objects["Floor"]
        floor.data.materials.append(bpy.data.materials["Material"])
        floor.material_slots[0].link = "OBJECT"
        self.scene.sundog.exchange = "USD"
        self.scene.sundog.samples = 1
        self.render()
        lost = self.lost()
        for name, words in (
            ("Light", "soft falloff"), ("Light", "glossy"), ("Cube", "shadow catcher"), ("Cube", "diffuse"),
            ("Material", "Voronoi Texture"), ("Material", "displacement"), ("Scene", "motion blur"), ("Floor", "slots of its own"),
        ):  # fmt: skip
            self.assertIn(words, lost.get(name, ""), lost)

    def test_shaders_that_usd_lacks_are_told(self):
        """The exporter writes a Principled BSDF alone, which is grey where there is none."""
        tree = bpy.data.materials["Material"].node_tree
        output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
        self.scene.sundog.exchange = "USD"
        for kind in ("BsdfGlass", "BsdfDiffuse", "Emission", "MixShader"):
            node = tree.nodes.new(f"ShaderNode{kind}")
            tree.links.new(node.outputs[0], output.inputs["Surface"])
            bpy.ops.sundog.check_scene()
            self.assertIn(node.bl_label, self.lost().get("Material", ""))

    def test_cameras_that_usd_lacks_are_refused(self):
        self.scene.sundog.exchange = "USD"
        self.scene.camera.data.type = "PANO"
        self.fails("panorama", "glTF")

    def test_other_cameras_and_strong_images_come_along(self):
        """Blender's exporter leaves orthographic cameras and lamps that are looked through out, and 5.2 the strength beside an image."""
        image = bpy.data.images.new("sky", 8, 4, float_buffer=True)
        pixels = numpy.full((4, 8, 4), 0.2, numpy.float32)
        pixels[2:, :3, 0] = 2.0
        image.pixels.foreach_set(pixels.ravel())
        path = os.path.join(self.folder, "sky.hdr")
        image.filepath_raw, image.file_format = path, "HDR"
        image.save()
        tree = self.scene.world.node_tree
        sky, background = tree.nodes.new("ShaderNodeTexEnvironment"), next(n for n in tree.nodes if n.type == "BACKGROUND")
        sky.image = bpy.data.images.load(path)
        tree.links.new(sky.outputs["Color"], background.inputs["Color"])
        background.inputs["Strength"].default_value = 0.7
        lamp = next(o for o in bpy.data.objects if o.type == "LIGHT")
        lamp.data.use_soft_falloff = False
        camera = self.scene.camera.data
        camera.type, camera.ortho_scale, camera.shift_x = "ORTHO", 9.0, 0.1
        self.assert_same()
        self.assertEqual(self.lost(), {})
        self.scene.camera = lamp
        self.assert_same()

    def test_the_scene_check_says_the_same(self):
        next(o for o in bpy.data.objects if o.type == "LIGHT").data.use_soft_falloff = True
        self.scene.sundog.exchange = "USD"
        bpy.ops.sundog.check_scene()
        self.assertIn("soft falloff", self.lost().get("Light", ""))


class InTheMainThread(EngineTest):
    """With a window, renders have a thread of their own, and Blender's exporter has to be called in another."""

    def wait(self, work, stopped):
        """What becomes of a job of another thread, while timers stand still."""
        jobs, found = [], []

        def keep(job):
            jobs.append(job)

        def other():
            try:
                found.append(usd.in_main_thread(work, stopped))
            except Exception as error:
                found.append(error)

        timers = type("Timers", (), {"register": staticmethod(keep)})
        app = type("App", (), {"timers": timers})
        kept, usd.bpy = usd.bpy, type("Bpy", (), {"app": app, "ops": bpy.ops, "context": bpy.context})
        self.addCleanup(setattr, usd, "bpy", kept)
        thread = threading.Thread(target=other)
        thread.start()
        while not jobs:
            thread.join(0.01)
        return thread, jobs, found

    def test_it_runs_there(self):
        thread, jobs, found = self.wait(threading.current_thread, lambda: False)
        self.assertIsNone(jobs[0]())
        thread.join()
        self.assertEqual(found, [threading.main_thread()])

    def test_errors_come_back(self):
        thread, jobs, found = self.wait(lambda: math.sqrt(-1.0), lambda: False)
        jobs[0]()
        thread.join()
        self.assertIsInstance(found[0], ValueError)

    def test_it_is_called_off(self):
        done = []
        thread, jobs, found = self.wait(lambda: done.append(1), lambda: True)
        thread.join()
        jobs[0]()
        self.assertIsInstance(found[0], usd.ExportError)
        self.assertEqual(done, [])
