# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender shows is what the program renders, bit for bit."""

import os
import unittest

import bpy
import numpy

from engine_kit import HEIGHT, SAMPLES, WIDTH, EngineTest, engine, quiet, same_bits
from sundog import command, passes


class Pictures(EngineTest):
    """Whole pictures, regions, sizes, passes, frames, view layers."""

    def test_the_picture_is_the_command_lines(self):
        shown = self.render()["ViewLayer.Combined"]
        self.assertTrue(same_bits(shown, self.by_command_line()[""]))

    def test_settings_reach_the_program(self):
        settings = self.scene.sundog
        settings.samples, settings.max_bounces, settings.seed = 3, 1, 7
        settings.pixel_filter_type, settings.filter_width = "GAUSSIAN", 2.5
        settings.sample_clamp_indirect, settings.blur_glossy, settings.min_light_bounces = 0.25, 0.5, 3
        self.scene.render.threads_mode, self.scene.render.threads = "FIXED", 1
        shown = self.render()["ViewLayer.Combined"]
        flags = "--samples 3 --bounces 1 --seed 7 --filter gauss:2.5 --clamp-indirect 0.25 --filter-glossy 0.5 --roulette 5".split()
        self.assertTrue(same_bits(shown, self.by_command_line(*flags)[""]))
        told = engine.last_statistics()
        self.assertEqual(told["settings"]["threads"], 1)
        self.assertEqual(told["statistics"]["samples"], 3)
        self.assertGreater(told["export"]["total"], 0)
        self.assertGreater(told["prepared"], 0)

    def test_resolution_percentage(self):
        self.scene.render.resolution_x, self.scene.render.resolution_y = 107, 61
        self.scene.render.resolution_percentage = 29
        shown = self.render()["ViewLayer.Combined"]
        # Integers, rounded down as Blender does.
        self.assertEqual(shown.shape, (61 * 29 // 100, 107 * 29 // 100, 4))
        expected = self.by_command_line("--width", "31", "--height", "17")[""]
        self.assertTrue(same_bits(shown, expected))

    def test_every_percentage_and_border_has_blenders_size(self):
        render = self.scene.render
        self.stand_in(
            "w, h = (int(sys.argv[sys.argv.index(f) + 1]) for f in ('--width', '--height'))\n"
            "region = [0, 0, w, h]\n"
            "if '--region' in sys.argv: region = [int(v) for v in sys.argv[sys.argv.index('--region') + 1].split(',')]\n"
            "folder = sys.argv[sys.argv.index('--frames') + 1]\n"
            "size = (region[2] - region[0]) * (region[3] - region[1]) * 16\n"
            "open(os.path.join(folder, 'f.raw'), 'wb').write(b'\\0\\0\\x80\\x3f' * (size // 4))\n"
            "tell(event='frame', file='f.raw', width=w, height=h, region=region, samples=1, final=True,\n"
            "     passes=[dict(name='Combined', channels='RGBA', offset=0)])\n"
        )
        render.resolution_x, render.resolution_y = 101, 67
        for percentage, borders in ((29, None), (57, (0.1, 0.2, 0.7, 0.9)), (100, (0.305, 0.5, 0.31, 0.52))):
            render.resolution_percentage = percentage
            render.use_border = render.use_crop_to_border = borders is not None
            if borders:
                render.border_min_x, render.border_min_y, render.border_max_x, render.border_max_y = borders
            shown = self.render()["ViewLayer.Combined"]
            # A part that was not written would be black: the sizes agree.
            self.assertTrue((shown == 1).all(), (percentage, shown.shape))
            x0, y0, x1, y1 = command.border(render)
            self.assertEqual(shown.shape[:2], (y1 - y0, x1 - x0))

    def test_a_region_is_a_part_of_the_picture(self):
        whole = self.render("whole")["ViewLayer.Combined"]
        render = self.scene.render
        render.use_border = True
        render.border_min_x, render.border_max_x = 0.25, 0.75
        render.border_min_y, render.border_max_y = 0.125, 0.5
        # From the top: rows 16 to 28 of 32.
        part = whole[16:28, 12:36]
        inside = self.render("inside")["ViewLayer.Combined"]
        self.assertTrue(same_bits(inside[16:28, 12:36], part))
        inside[16:28, 12:36] = 0
        self.assertFalse(inside.any())
        render.use_crop_to_border = True
        self.assertTrue(same_bits(self.render("cropped")["ViewLayer.Combined"], part))

    def test_passes_that_are_switched_on_and_no_others(self):
        layer = self.scene.view_layers[0]
        layer.use_pass_z = layer.sundog.use_pass_sample_count = True
        shown = self.render()
        names = {"Combined", "Depth", "Debug Sample Count"}
        self.assertEqual({name.removeprefix("ViewLayer.") for name in shown}, names)
        self.assertEqual(shown["ViewLayer.Debug Sample Count"].max(), SAMPLES)

    def test_every_pass_is_the_command_lines(self):
        layer = self.scene.view_layers[0]
        for p in passes.PASSES:
            *owner, name = p.switch.split()[0].split(".")
            setattr(getattr(layer, owner[0]) if owner else layer, name, True)
        shown = self.render()
        expected = self.by_command_line("--passes", "all")
        for p in passes.PASSES:
            # Times are other ones each time.
            if p.program not in passes.UNITS:
                self.assertTrue(same_bits(shown[f"ViewLayer.{p.name}"], expected[p.program]), p.name)
        # The same light with and without its parts; these take it apart to the accuracy of the floats.
        self.assertTrue(same_bits(shown["ViewLayer.Combined"], expected[""]))
        told = [f'there is no pass "{name}": it is left out' for name in passes.STORED]
        self.assertEqual(engine.last_statistics()["warnings"], told)

    def test_a_pass_that_there_is_not_is_named(self):
        layer = self.scene.view_layers[0]
        layer.use_pass_shadow = True
        names = ["Shadow"]
        for kind in ("Scatter", "Transmit", "Majorant"):
            if hasattr(layer.cycles, f"use_pass_volume_{kind.lower()}"):
                setattr(layer.cycles, f"use_pass_volume_{kind.lower()}", True)
                names.append(f"Volume {kind}")
        self.render()
        warnings = " ".join(engine.last_statistics()["warnings"])
        for name in names:
            self.assertIn(f'"{name}"', warnings)

    def test_a_pass_that_the_program_does_not_write_is_named(self):
        self.scene.view_layers[0].use_pass_normal = True
        self.stand_in(
            f"size = {WIDTH * HEIGHT * 16}\n"
            "folder = sys.argv[sys.argv.index('--frames') + 1]\n"
            "open(os.path.join(folder, 'f.raw'), 'wb').write(bytes(size))\n"
            f"tell(event='frame', file='f.raw', width={WIDTH}, height={HEIGHT}, region=[0, 0, {WIDTH}, {HEIGHT}], samples=1,\n"
            "     final=True, passes=[dict(name='Combined', channels='RGBA', offset=0)])\n"
        )
        self.assertFalse(self.render()["ViewLayer.Normal"].any())
        self.assertIn('"Normal"', " ".join(engine.last_statistics()["warnings"]))

    def test_film_exposure_and_caustics(self):
        self.scene.view_layers[0].use_pass_diffuse_color = True
        plain = self.render()
        self.scene.sundog.film_exposure = 0.5
        exposed = self.render()
        for name, values in exposed.items():
            if name == "ViewLayer.Combined":
                self.assertTrue(same_bits(values[..., :3], plain[name][..., :3] * 0.5))
                self.assertTrue(same_bits(values[..., 3], plain[name][..., 3]))
            else:
                self.assertTrue(same_bits(values, plain[name]), name)
        self.scene.sundog.caustics_refractive = False
        self.assertTrue(same_bits(self.render()["ViewLayer.Combined"], self.by_command_line("--caustics", "reflective", "--film-exposure", "0.5")[""]))
        self.scene.sundog.caustics_reflective = False
        self.render()
        told = engine.last_statistics()["settings"]
        self.assertEqual((told["caustics"], told["film_exposure"]), ({"reflective": False, "refractive": False}, 0.5))

    def test_transparent_film(self):
        self.scene.render.film_transparent = True
        self.scene.camera.rotation_euler.x = 1.4
        shown = self.render()["ViewLayer.Combined"]
        self.assertTrue(same_bits(shown, self.by_command_line("--transparent")[""]))
        # The sky above, the floor below.
        self.assertEqual(shown[0, 0].tolist(), [0, 0, 0, 0])
        self.assertEqual(shown[..., 3].max(), 1)

    def test_frames_of_an_animation(self):
        scene = self.scene
        cube = bpy.data.objects["Cube"]
        for frame, x in ((1, 0.0), (3, 2.0)):
            cube.location.x = x
            cube.keyframe_insert("location", frame=frame)
        scene.frame_start, scene.frame_end = 2, 3
        scene.sundog.use_animated_seed = True
        scene.render.filepath = os.path.join(self.folder, "frame_####")
        with quiet():
            bpy.ops.render.render(animation=True)
        pictures = {}
        for frame in (2, 3):
            scene.frame_set(frame)
            pictures[frame] = self.read(f"frame_{frame:04}")["ViewLayer.Combined"]
            expected = self.by_command_line("--seed", str(command.seed(scene)))[""]
            self.assertTrue(same_bits(pictures[frame], expected), frame)
        self.assertFalse(same_bits(pictures[2], pictures[3]))

    def test_a_subframe(self):
        cube = bpy.data.objects["Cube"]
        for frame, x in ((1, -1.0), (2, 1.0)):
            cube.location.x = x
            cube.keyframe_insert("location", frame=frame)
        self.scene.frame_set(1, subframe=0.25)
        between = self.render("between")["ViewLayer.Combined"]
        self.assertTrue(same_bits(between, self.by_command_line()[""]))
        self.scene.frame_set(1)
        self.assertFalse(same_bits(between, self.render("before")["ViewLayer.Combined"]))

    def test_each_view_layer_shows_its_own(self):
        layer = self.scene.view_layers.new("Without Cube")
        for child in layer.layer_collection.children:
            child.exclude = True
        keep = bpy.data.collections.new("Eye")
        self.scene.collection.children.link(keep)
        keep.objects.link(self.scene.camera)
        self.scene.view_layers[0].use_pass_z = True
        unused = self.scene.view_layers.new("Unused")
        unused.use = False
        shown = self.render()
        self.assertEqual(
            set(shown), {"ViewLayer.Combined", "ViewLayer.Depth", "Without Cube.Combined"}, "an unused layer is not rendered"
        )
        self.assertTrue(same_bits(shown["ViewLayer.Combined"], self.by_command_line(layer="ViewLayer")[""]))
        self.assertTrue(same_bits(shown["Without Cube.Combined"], self.by_command_line(layer="Without Cube")[""]))
        self.assertFalse(same_bits(shown["ViewLayer.Combined"], shown["Without Cube.Combined"]))
        self.assertEqual([told["layer"] for told in engine.last_statistics()["layers"]], ["ViewLayer", "Without Cube"])

    def test_overrides_of_a_view_layer(self):
        layer = self.scene.view_layers[0]
        plain = self.render("plain")["ViewLayer.Combined"]
        layer.samples = SAMPLES + 1
        layer.material_override = bpy.data.materials.new("Shining")
        layer.material_override.use_nodes = True
        shader = layer.material_override.node_tree.nodes["Principled BSDF"]
        shader.inputs["Emission Color"].default_value, shader.inputs["Emission Strength"].default_value = (1, 0, 0, 1), 100
        layer.world_override = bpy.data.worlds.new("Black")
        layer.world_override.use_nodes = True
        layer.world_override.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
        shown = self.render("overridden")["ViewLayer.Combined"]
        self.assertEqual(engine.last_statistics()["statistics"]["samples"], SAMPLES + 1)
        self.assertEqual({v["name"] for v in engine.last_verdicts() if v["kind"] == "material"}, {"Shining"})
        self.assertLess(plain[..., 0].max(), 50)
        self.assertGreater(shown[..., 0].max(), 50)
        self.assertEqual({v["name"] for v in engine.last_verdicts() if v["kind"] == "world"}, {"Black"})

    def test_data_at_pixel_centres(self):
        """No normal is a mean of two surfaces, and the picture stays what it is."""
        layer = self.scene.view_layers[0]
        layer.use_pass_normal = True
        plain = self.render("filtered")
        layer.sundog.use_centre_passes = True
        found = self.render("centres")
        lengths = numpy.linalg.norm(found["ViewLayer.Normal"], axis=-1)
        self.assertLess(numpy.minimum(abs(lengths - 1), lengths).max(), 1e-5)
        self.assertTrue((lengths > 0.5).any())
        filtered = numpy.linalg.norm(plain["ViewLayer.Normal"], axis=-1)
        self.assertGreater(numpy.minimum(abs(filtered - 1), filtered).max(), 0.01)
        self.assertTrue(same_bits(plain["ViewLayer.Combined"], found["ViewLayer.Combined"]))

    def test_the_compositor_gets_the_passes(self):
        layer = self.scene.view_layers[0]
        layer.use_pass_normal = True
        if bpy.app.version >= (5, 0, 0):
            tree = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
            self.scene.compositing_node_group = tree
        else:
            self.scene.use_nodes = True
            tree = self.scene.node_tree
        node = tree.nodes.new("CompositorNodeRLayers")
        self.assertTrue(node.outputs["Normal"].enabled)
        sockets = {socket.name for socket in node.outputs if socket.enabled}
        self.assertNotIn("Depth", sockets)

    def test_time_limit_alone_ends_the_render(self):
        self.scene.sundog.samples, self.scene.sundog.time_limit = 1 << 20, 0.2
        self.render()
        told = engine.last_statistics()["statistics"]
        self.assertEqual(told["stop"], "time")
        self.assertLess(told["samples"], 1 << 20)

    def test_error_target_ends_the_render(self):
        self.scene.sundog.samples, self.scene.sundog.error_target = 1 << 20, 0.25
        self.render()
        told = engine.last_statistics()["statistics"]
        self.assertEqual(told["stop"], "error")
        self.assertLessEqual(told["error"]["error"], 0.25)


if __name__ == "__main__":
    unittest.main()
