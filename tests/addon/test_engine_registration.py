# SPDX-License-Identifier: GPL-3.0-or-later
"""Registering and leaving, panels, settings, the scene check."""

import functools
import importlib.util
import json
import os
import sys
import unittest

import bpy

import export_kit
from engine_kit import EngineTest, engine, quiet, sundog
from sundog import preferences, properties, scene_check, ui

ADDON = os.path.dirname(sundog.__file__)


class Registration(EngineTest):
    """The add-on comes and goes without a trace."""

    def test_twice(self):
        before = {panel.__name__ for panel in ui.blenders_panels() if "SUNDOG" in panel.COMPAT_ENGINES}
        self.assertIn("DATA_PT_lens", before)
        for _ in range(2):
            sundog.unregister()
            self.assertFalse(hasattr(bpy.types.Scene, "sundog"))
            self.assertFalse([p for p in bpy.types.Panel.__subclasses__() if "SUNDOG" in getattr(p, "COMPAT_ENGINES", ()) and p.__module__.startswith("bl_ui")])
            sundog.unregister()
            sundog.register()
            sundog.register()
        self.assertEqual({p.__name__ for p in ui.blenders_panels() if "SUNDOG" in p.COMPAT_ENGINES}, before)
        self.scene.render.engine = "SUNDOG"
        self.still_renders()

    def test_under_another_name(self):
        """As Blender loads extensions: all imports inside are relative."""
        sundog.unregister()
        name = "bl_ext_test_sundog"
        spec = importlib.util.spec_from_file_location(name, os.path.join(ADDON, "__init__.py"), submodule_search_locations=[ADDON])
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        try:
            spec.loader.exec_module(module)
            module.register()
            self.scene.render.engine = "SUNDOG"
            self.still_renders()
            self.assertTrue(sys.modules[f"{name}.engine"].last_statistics())
        finally:
            module.unregister()
            for loaded in [n for n in sys.modules if n == name or n.startswith(f"{name}.")]:
                del sys.modules[loaded]
            sundog.register()

    def test_settings_are_kept_in_files(self):
        path = os.path.join(self.folder, "kept.blend")
        self.scene.sundog.samples = 77
        self.scene.view_layers[0].sundog.use_pass_albedo = True
        with quiet():
            bpy.ops.wm.save_as_mainfile(filepath=path)
            bpy.ops.wm.read_factory_settings()
            bpy.ops.wm.open_mainfile(filepath=path)
        self.assertEqual(bpy.context.scene.sundog.samples, 77)
        self.assertTrue(bpy.context.scene.view_layers[0].sundog.use_pass_albedo)
        self.assertEqual(bpy.context.scene.render.engine, "SUNDOG")


class Panels(EngineTest):
    """What is seen of Blender's own panels."""

    def test_camera_light_world_material_panels_are_there(self):
        names = {panel.__name__ for panel in bpy.types.Panel.__subclasses__() if "SUNDOG" in getattr(panel, "COMPAT_ENGINES", ())}
        for name in (
            "DATA_PT_lens", "DATA_PT_camera", "DATA_PT_camera_dof", "DATA_PT_camera_dof_aperture", "DATA_PT_context_light",
            "WORLD_PT_context_world", "EEVEE_MATERIAL_PT_context_material", "OBJECT_PT_visibility", "RENDER_PT_format",
            "RENDER_PT_output", "RENDER_PT_color_management", "VIEWLAYER_PT_layer", "RENDER_PT_simplify",
        ):  # fmt: skip
            self.assertIn(name, names)
        self.assertFalse([name for name in names if name in ui.HIDDEN])

    def test_every_panel_draws(self):
        """Each one's `draw`, with the data that it is for, on a layout that only looks whether the properties exist."""
        for kind in ("POINT", "SPOT", "SUN", "AREA"):
            for shape in ("SQUARE", "RECTANGLE", "DISK", "ELLIPSE") if kind == "AREA" else ("",):
                light = bpy.data.lights.new("l", kind)
                if shape:
                    light.shape = shape
                self._draw_all(light=light)
        camera = bpy.data.cameras.new("c")
        camera.type = "PANO"
        settings = camera if hasattr(camera, "panorama_type") else camera.cycles
        for panorama in ("EQUIRECTANGULAR", "FISHEYE_EQUISOLID"):
            settings.panorama_type = panorama
            self._draw_all(camera=camera)
        cube = bpy.data.objects["Cube"]
        self._draw_all(world=self.scene.world, material=cube.active_material, object=cube)
        self.render()
        self._draw_all()

    def test_the_preferences_draw(self):
        cls = preferences.SundogPreferences
        for chosen in ("", "/nowhere/sundog"):
            fake = type("Fake", (), {"program": chosen, "bl_rna": type("Rna", (), {"properties": cls.__annotations__})})()
            fake.layout = _Layout()
            cls.draw(fake, None)
            said = " ".join(fake.layout.said)
            self.assertIn("does not exist" if chosen else "Version", said)

    def _draw_all(self, **data):
        context = _Context(self.scene, data)
        drawn = 0
        for panel in ui._CLASSES:
            if panel.poll(context):
                panel.draw(_Panel(panel), context)
                drawn += 1
        self.assertGreater(drawn, 5)


class _Panel:
    """Stands for an instance of a panel's class, which Blender alone can make."""

    def __init__(self, panel):
        self.panel, self.layout = panel, _Layout()

    def __getattr__(self, name):
        return functools.partial(getattr(self.panel, name), self)


class _Layout:
    """Takes what is drawn."""

    def __init__(self):
        self.said = []

    def row(self, **_):
        return self

    column = box = row

    def prop(self, data, name, **_):
        if name not in data.bl_rna.properties:
            raise AssertionError(f"{data} has no {name}")

    def label(self, text="", **_):
        self.said.append(text)

    template_node_view = separator = lambda self, *_: None

    def operator(self, name, **_):
        group, _, word = name.partition(".")
        getattr(getattr(bpy.ops, group), word).get_rna_type()
        return self


class _Context:
    def __init__(self, scene, data):
        self.scene, self.engine, self.view_layer = scene, "SUNDOG", scene.view_layers[0]
        self.light = self.camera = self.world = self.material = self.object = None
        self.preferences = bpy.context.preferences
        self.region = type("Region", (), {"width": 400})
        self.__dict__.update(data)


class Settings(EngineTest):
    """Names and values as in Cycles."""

    def test_every_setting_copied_is_cycles_own(self):
        cycles = self.scene.cycles
        cycles.samples, cycles.time_limit, cycles.max_bounces, cycles.diffuse_bounces = 99, 5.0, 7, 3
        cycles.sample_clamp_direct, cycles.sample_clamp_indirect, cycles.blur_glossy = 1.5, 2.5, 0.75
        cycles.pixel_filter_type, cycles.filter_width, cycles.seed = "GAUSSIAN", 2.0, 11
        cycles.use_animated_seed = True
        self.scene.view_layers[0].cycles.denoising_store_passes = True
        with quiet():
            self.assertEqual(bpy.ops.sundog.copy_settings_from_cycles(), {"FINISHED"})
        for name in properties.COPIED:
            self.assertEqual(getattr(self.scene.sundog, name), getattr(cycles, name), name)
        self.assertTrue(self.scene.view_layers[0].sundog.use_pass_albedo)

    def test_nothing_is_clamped_by_default(self):
        settings = self.scene.sundog
        self.assertEqual((settings.sample_clamp_direct, settings.sample_clamp_indirect, settings.blur_glossy), (0, 0, 0))


class SceneCheck(EngineTest):
    """The list of what is not exact."""

    def test_lists_what_is_lost_and_selects_it(self):
        material = bpy.data.objects["Cube"].active_material
        nodes = material.node_tree
        output = nodes.get_output_node("CYCLES")
        volume = nodes.nodes.new("ShaderNodeVolumePrincipled")
        nodes.links.new(volume.outputs[0], output.inputs["Volume"])
        with quiet():
            self.assertEqual(bpy.ops.sundog.check_scene(), {"FINISHED"})
        lost = [v for v in engine.last_verdicts() if v["verdict"] == "lost" and v["kind"] == "material"]
        self.assertEqual([v["name"] for v in lost], ["Material"])
        told = json.loads(bpy.context.window_manager.sundog_record)
        self.assertEqual(told["verdicts"], engine.last_verdicts())
        with quiet():
            self.assertEqual(bpy.ops.sundog.select_users(kind="material", names="Material"), {"FINISHED"})
        self.assertEqual([o.name for o in bpy.context.selected_objects], ["Cube"])
        self.assertEqual(scene_check.users_of("light", "Light", bpy.context.view_layer), [bpy.data.objects["Light"]])

    def test_without_a_camera(self):
        self.scene.camera = None
        with quiet(), self.assertRaisesRegex(RuntimeError, "camera"):
            bpy.ops.sundog.check_scene()

    def test_after_a_render_the_list_is_the_renders(self):
        self.render()
        kinds = {v["kind"] for v in engine.last_verdicts()}
        self.assertLessEqual({"material", "light", "world", "camera"}, kinds)
        ranks = [("lost", "approximated", "exact").index(v["verdict"]) for v in engine.last_verdicts()]
        self.assertEqual(ranks, sorted(ranks), "the worst first")


if __name__ == "__main__":
    unittest.main()
