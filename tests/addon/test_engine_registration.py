# SPDX-License-Identifier: GPL-3.0-or-later
"""Registering and leaving, panels, settings, the scene check."""

import functools
import importlib.util
import json
import os
import sys
import types
import unittest

import bpy

import export_kit
from engine_kit import EngineTest, engine, quiet, sundog
from sundog import command, preferences, properties, records, scene_check, ui

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
            "RENDER_PT_output", "RENDER_PT_color_management", "VIEWLAYER_PT_layer",
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

    def test_the_order_is_that_of_cycles(self):
        def labels(classes):
            return [c.bl_label for c in classes if getattr(c, "bl_context", "") == "render" and not hasattr(c, "bl_parent_id")]

        ours, theirs = labels(ui._CLASSES), labels(sys.modules["cycles.ui"].classes)
        self.assertEqual(ours[:5], ["Sampling", "Light Paths", "Curves", "Simplify", "Film"])
        self.assertEqual([label for label in ours if label in theirs], [label for label in theirs if label in ours])
        # Panels of one order stand as they are registered, Blender's own before all add-ons'.
        above = [p for p in ui.blenders_panels() if getattr(p, "bl_context", "") == "render" and not getattr(p, "bl_parent_id", "") and not getattr(p, "bl_order", 0)]
        self.assertEqual(above, [])
        self.assertLess(sundog._NAMES.index("ui"), sundog._NAMES.index("effects"))

    def test_panels_of_what_is_not_rendered_say_so(self):
        said = {panel.__name__: says for panel, says in ui._says}
        self.assertEqual(set(said), set(ui.NOT_RENDERED))
        for name, says in said.items():
            for engine_name, lines in (("SUNDOG", [ui.NOT_RENDERED[name]]), ("CYCLES", [])):
                panel = type("Fake", (), {"layout": _Layout()})()
                says(panel, type("Context", (), {"engine": engine_name}))
                self.assertEqual(panel.layout.said, lines)
        sundog.unregister()
        self.addCleanup(sundog.register)
        for name, says in said.items():
            self.assertNotIn(says, getattr(getattr(bpy.types, name).draw, "_draw_funcs", []))

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
                if hasattr(panel, "draw_header"):
                    panel.draw_header(_Panel(panel), context)
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
        cycles.min_light_bounces = 4
        cycles.pixel_filter_type, cycles.filter_width, cycles.seed = "GAUSSIAN", 2.0, 11
        cycles.use_animated_seed, cycles.film_exposure = True, 0.5
        cycles.caustics_reflective, cycles.caustics_refractive = False, False
        self.scene.view_layers[0].cycles.denoising_store_passes = True
        with quiet():
            self.assertEqual(bpy.ops.sundog.copy_settings_from_cycles(), {"FINISHED"})
        for name in properties.COPIED:
            self.assertEqual(getattr(self.scene.sundog, name), getattr(cycles, name), name)
        self.assertTrue(self.scene.view_layers[0].sundog.use_pass_albedo)

    def test_the_noise_threshold_is_cycles_own(self):
        cycles, settings = self.scene.cycles, self.scene.sundog
        for on, threshold, samples, expected in (
            (True, 0.02, 4096, "0.02"), (True, 0.0, 500, "0.002"), (True, 0.0, 4096, "0.001"), (False, 0.02, 4096, None),
        ):  # fmt: skip
            cycles.use_adaptive_sampling, cycles.adaptive_threshold, cycles.samples = on, threshold, samples
            cycles.adaptive_min_samples = 48
            settings.pixel_error_target = 0.03
            properties.copy_from_cycles(self.scene)
            self.assertEqual((settings.samples, settings.pixel_error_target), (samples, 0.0))
            settings.pixel_error_target = 0.03
            flags = self.flags()
            self.assertEqual(flags.get("--noise-threshold"), expected)
            self.assertEqual(flags.get("--min-samples"), "48" if on else None)
            # One sequence a pixel, as there.
            self.assertEqual(flags.get("--sequences"), "1")
            settings.sequences = "TWO"
            self.assertNotIn("--sequences", self.flags())
            # One of the two decides.
            self.assertEqual(flags.get("--pixel-error"), None if on else "0.03")

    def test_samples_of_view_layers_count_as_in_cycles(self):
        layer = self.scene.view_layers[0]
        self.scene.sundog.samples = 16
        for counts, own, expected in (
            ("USE", 0, 16), ("USE", 5, 5), ("USE", 30, 30), ("BOUNDED", 0, 16), ("BOUNDED", 5, 5), ("BOUNDED", 30, 16),
            ("IGNORE", 0, 16), ("IGNORE", 5, 16), ("IGNORE", 30, 16),
        ):  # fmt: skip
            self.scene.cycles.use_layer_samples, layer.samples = counts, own
            self.assertEqual(self.flags()["--samples"], str(expected), (counts, own))

    def flags(self):
        """The command line's flags with what follows them."""
        warned = []
        known = types.SimpleNamespace(version="", has=lambda flag: True)
        line = command.arguments(self.scene, self.scene.view_layers[0], known, warned.append)
        self.assertEqual(warned, [])
        return dict(zip(line, line[1:], strict=False))

    def test_what_has_no_place_here_is_told(self):
        cycles = self.scene.cycles
        cycles.use_adaptive_sampling = cycles.use_denoising = False
        self.assertEqual(properties.copy_from_cycles(self.scene), [])
        for name, value, word in (
            ("time_limit", 5.0, "loading"),
            ("use_guiding", True, "guiding"),
        ):  # fmt: skip
            before = getattr(cycles, name)
            setattr(cycles, name, value)
            self.assertIn(word, " ".join(properties.copy_from_cycles(self.scene)))
            setattr(cycles, name, before)

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
        nodes.links.new(nodes.nodes.new("ShaderNodeWireframe").outputs[0], volume.inputs["Density"])
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

    def test_a_render_says_what_it_has_lost(self):
        """One report, and none where all is exact."""
        def said(**options):
            path = os.path.join(self.folder, "said")
            with open(path, "wb") as file, quiet():
                keep = os.dup(1)
                os.dup2(file.fileno(), 1)
                try:
                    bpy.ops.render.render(**options)
                finally:
                    sys.stdout.flush()
                    os.dup2(keep, 1)
                    os.close(keep)
            with open(path, encoding="utf-8") as file:
                return [line.strip() for line in file if "see Scene Check" in line]

        self.assertEqual(said(), [])
        material = bpy.data.objects["Cube"].active_material
        volume = material.node_tree.nodes.new("ShaderNodeVolumePrincipled")
        output = material.node_tree.get_output_node("CYCLES")
        material.node_tree.links.new(volume.outputs[0], output.inputs["Volume"])
        distance = material.node_tree.nodes.new("ShaderNodeWireframe").outputs[0]
        material.node_tree.links.new(distance, volume.inputs["Density"])
        lines = said()
        self.assertEqual(len(lines), 1, lines)
        self.assertIn("Sundog: 1 material lost: see Scene Check", lines[0])
        self.assertIn("Warning", lines[0])
        # In an animation once, not once a frame.
        self.scene.frame_start, self.scene.frame_end = 1, 3
        self.scene.render.filepath = os.path.join(self.folder, "frame_")
        self.assertLessEqual(len(said(animation=True)), 1)

    def test_counts_are_in_words(self):
        def verdict(kind, name, verdict):
            return {"kind": kind, "name": name, "verdict": verdict, "detail": ""}

        self.assertEqual(records.loss([verdict("material", "a", "exact")]), "")
        some = [verdict("object", "a", "lost"), verdict("material", "a", "approximated"), verdict("material", "b", "approximated"),
                verdict("light", "a", "approximated"), verdict("program", "x", "approximated")]  # fmt: skip
        self.assertEqual(records.loss(some), "1 object lost, 1 light, 2 materials and 1 feature approximated")

    def test_after_a_render_the_list_is_the_renders(self):
        self.render()
        kinds = {v["kind"] for v in engine.last_verdicts()}
        self.assertLessEqual({"material", "light", "world", "camera"}, kinds)
        ranks = [("lost", "approximated", "exact").index(v["verdict"]) for v in engine.last_verdicts()]
        self.assertEqual(ranks, sorted(ranks), "the worst first")


if __name__ == "__main__":
    unittest.main()
