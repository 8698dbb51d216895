# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoising in Blender: what is copied from Cycles' settings, the passes, and the picture beside Cycles' own."""

import os

import bpy
import numpy

from engine_kit import EngineTest, same_bits

from sundog import denoise, engine, passes, properties


class Abilities:
    """A program that knows flags, or none."""

    version = "0"

    def __init__(self, *flags):
        self.flags = flags

    def has(self, flag):
        return flag in self.flags


def material(name, **values):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    inputs = made.node_tree.nodes["Principled BSDF"].inputs
    for socket, value in values.items():
        inputs[socket.replace("_", " ")].default_value = value
    return made


class Arguments(EngineTest):
    """Flags by the scene's settings for Cycles."""

    def of(self, *flags):
        warnings = []
        layer = self.scene.view_layers[0]
        found = denoise.arguments(self.scene, layer, Abilities(*flags), warnings.append)
        return found, warnings

    def test_the_scene_decides_unless_sundog_does(self):
        scene, layer = self.scene, self.scene.view_layers[0]
        for choice, of_scene, of_layer, expected in (
            ("CYCLES", True, True, True), ("CYCLES", True, False, False), ("CYCLES", False, True, False),
            ("ON", False, False, True), ("OFF", True, True, False),
        ):  # fmt: skip
            scene.sundog.denoising = choice
            scene.cycles.use_denoising, layer.cycles.use_denoising = of_scene, of_layer
            self.assertEqual(denoise.is_on(scene, layer), expected, (choice, of_scene, of_layer))
            self.assertEqual(bool(self.of("denoise")[0]), expected)

    def test_a_new_scene_follows_cycles(self):
        self.assertEqual(bpy.data.scenes.new("New").sundog.denoising, "CYCLES")
        self.scene.sundog.denoising = "OFF"
        properties.copy_from_cycles(self.scene)
        self.assertEqual(self.scene.sundog.denoising, "CYCLES")

    def test_how_is_copied(self):
        self.scene.sundog.denoising = "ON"
        cycles = self.scene.cycles
        for prefilter, guides, quality, words in (
            ("ACCURATE", "RGB_ALBEDO_NORMAL", "HIGH", ("accurate", "albedo-normal", "high")),
            ("FAST", "RGB_ALBEDO", "BALANCED", ("fast", "albedo", "balanced")),
            ("NONE", "RGB", "FAST", ("none", "none", "fast")),
        ):
            cycles.denoising_prefilter, cycles.denoising_input_passes, cycles.denoising_quality = prefilter, guides, quality
            expected = ["--denoise", "--denoise-optional"]
            for flag, word in zip(("prefilter", "guides", "quality"), words):
                expected += [f"--denoise-{flag}", word]
            self.assertEqual(self.of("denoise"), (expected, []))
        self.scene.sundog.denoising_keep_energy = True
        self.assertIn("--denoise-keep-energy", self.of("denoise")[0])

    def test_switches_of_developers_are_told_where_they_count(self):
        layer = self.scene.view_layers[0]
        if not hasattr(layer.cycles, "denoising_pass_follow_reflections"):
            self.skipTest("Cycles has no such switches")
        self.scene.sundog.denoising = "OFF"
        for store, follows, weighs, count in (
            (False, False, False, 0), (True, True, True, 0), (True, False, True, 1), (True, True, False, 1), (True, False, False, 2),
        ):  # fmt: skip
            layer.cycles.denoising_store_passes = store
            layer.cycles.denoising_pass_follow_reflections = follows
            layer.cycles.denoising_pass_use_albedo_roughness_weighting = weighs
            self.assertEqual(len(denoise.differences(self.scene, layer)), count)
        layer.cycles.denoising_store_passes = False
        self.scene.sundog.denoising = "ON"
        self.assertEqual(len(denoise.differences(self.scene, layer)), 2)

    def test_a_program_that_cannot_is_told(self):
        self.scene.sundog.denoising = "ON"
        found, warnings = self.of()
        self.assertEqual((found, len(warnings)), ([], 1))
        self.assertIn("stays noisy", warnings[0])


class Pictures(EngineTest):
    """What comes back."""

    def test_the_noisy_picture_is_that_of_a_render_without(self):
        noisy = self.render("noisy")["ViewLayer.Combined"]
        self.scene.sundog.denoising = "ON"
        self.scene.view_layers[0].cycles.denoising_store_passes = True
        found = self.render("denoised")
        self.assertTrue(same_bits(found["ViewLayer.Noisy Image"], noisy))
        self.assertFalse(same_bits(found["ViewLayer.Combined"], noisy))
        # Alpha is no noise.
        self.assertTrue(same_bits(found["ViewLayer.Combined"][..., 3], noisy[..., 3]))
        for name, channels in (("Albedo", 3), ("Normal", 3), ("Depth", 1)):
            shape = found[f"ViewLayer.Denoising {name}"].shape
            self.assertEqual(shape[2] if len(shape) > 2 else 1, channels, name)
        statistics = engine.last_statistics()
        self.assertEqual(statistics["warnings"], [f'there is no pass "{name}": it is left out' for name in passes.STORED])
        self.assertIn("brightness shift ", denoise.words(statistics["denoised"]))

    def test_without_the_library_the_picture_is_noisy_and_one_warning_says_so(self):
        noisy = self.render("noisy")["ViewLayer.Combined"]
        self.scene.sundog.denoising = "ON"
        before = os.environ.get(denoise.VARIABLE)
        os.environ[denoise.VARIABLE] = self.folder
        try:
            found = self.render("without")
        finally:
            del os.environ[denoise.VARIABLE]
            if before is not None:
                os.environ[denoise.VARIABLE] = before
        self.assertTrue(same_bits(found["ViewLayer.Combined"], noisy))
        self.assertTrue(same_bits(found["ViewLayer.Noisy Image"], noisy))
        warnings = engine.last_statistics()["warnings"]
        self.assertEqual(len(warnings), 1, warnings)
        self.assertIn("the picture stays noisy: OIDN_DIR is ", warnings[0])

    def test_blenders_own_library_is_taken(self):
        folder = denoise.blenders_library()
        self.assertTrue(os.path.isfile(os.path.join(folder, denoise.LIBRARY)))


class BesideCycles(EngineTest):
    """The same scene, with a mirror and a ball of glass, denoised by both."""

    def setUp(self):
        super().setUp()
        scene = self.scene
        scene.render.resolution_x, scene.render.resolution_y = 160, 120
        bpy.data.objects["Cube"].active_material = material("Red", Base_Color=(0.7, 0.1, 0.1, 1), Roughness=0.8)
        bpy.data.objects["Floor"].active_material = material("Grey", Base_Color=(0.5, 0.6, 0.4, 1), Roughness=1.0)
        bpy.ops.mesh.primitive_plane_add(size=4, location=(-2.5, -0.5, 0.5), rotation=(1.2, 0, 0.9))
        bpy.context.object.active_material = material("Mirror", Base_Color=(0.9, 0.9, 0.9, 1), Metallic=1.0, Roughness=0.0)
        bpy.ops.mesh.primitive_uv_sphere_add(radius=0.8, location=(2.2, -1.2, -0.2))
        bpy.ops.object.shade_smooth()
        bpy.context.object.active_material = material(
            "Glass", Base_Color=(1, 1, 1, 1), Roughness=0.0, Transmission_Weight=1.0, IOR=1.45
        )
        cycles, sundog = scene.cycles, scene.sundog
        cycles.device, cycles.samples, cycles.use_adaptive_sampling = "CPU", 64, False
        cycles.use_denoising, cycles.sample_clamp_indirect, cycles.blur_glossy = True, 0.0, 0.0
        cycles.light_sampling_threshold = 0.0
        scene.view_layers[0].cycles.denoising_store_passes = True
        properties.copy_from_cycles(scene)
        sundog.pixel_error_target = 0.0

    def test_pictures_and_features_agree(self):
        ours = self.render("sundog")
        self.scene.render.engine = "CYCLES"
        theirs = self.render("cycles")
        self.scene.render.engine = "SUNDOG"
        keep = os.environ.get("SUNDOG_TEST_KEEP")
        if keep:
            numpy.savez(keep, **{f"{who}.{name}": values for who, found in (("ours", ours), ("theirs", theirs)) for name, values in found.items()})

        def pair(name):
            a, b = (found[f"ViewLayer.{name}"][..., :3].astype(float) for found in (ours, theirs))
            self.assertEqual(a.shape, b.shape, name)
            return a, b

        a, b = pair("Combined")
        self.assertLess(abs(a.mean() / b.mean() - 1), 0.01)
        error = ((a - b) ** 2 / (b**2 + 0.01)).mean()
        noisy_a, noisy_b = pair("Noisy Image")
        noise = ((noisy_a - noisy_b) ** 2 / (noisy_b**2 + 0.01)).mean()
        self.assertLess(error, noise / 2)
        for name, tolerance in (("Denoising Albedo", 0.01), ("Denoising Normal", 0.01)):
            a, b = pair(name)
            self.assertLess(numpy.abs(a.mean(axis=(0, 1)) - b.mean(axis=(0, 1))).max(), tolerance, name)
            # Noise of 64 samples, and edges, are left.
            self.assertLess(numpy.abs(a - b).mean(), 2 * tolerance, name)
