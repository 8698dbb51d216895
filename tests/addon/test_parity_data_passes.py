# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes of data beside Cycles': mist, indices, Cryptomatte; and Blender's own Cryptomatte node on Sundog's file."""

import json
import math
import os
import subprocess
import unittest

import bpy
import numpy

import exr
import export_kit as kit
from engine_kit import EngineTest

WIDTH, HEIGHT, SAMPLES = 64, 48, 128
KINDS = ("Object", "Material", "Asset")
FIVE = bpy.app.version >= (5, 0, 0)
INDICES = ("Object Index", "Material Index") if FIVE else ("IndexOB", "IndexMA")


def coverage(passes, kind):
    """How much of each pixel is each number's, as a dictionary of pictures by the numbers' bits."""
    found = {}
    for part in range(3):
        layer = passes[f"ViewLayer.Crypto{kind}0{part}"]
        for first in (0, 2):
            ids, shares = layer[..., first].view(numpy.uint32), layer[..., first + 1]
            for number in numpy.unique(ids[shares > 0]):
                picture = found.setdefault(int(number), numpy.zeros(ids.shape))
                picture += numpy.where(ids == number, shares, 0)
    return found


def add_fog(density):
    """A box of it around all that is there."""
    bpy.ops.mesh.primitive_cube_add(size=7.6, location=(0, 0, 2.9))
    fog = bpy.data.materials.new("fog")
    fog.use_nodes = True
    tree = fog.node_tree
    tree.nodes.clear()
    scatter, out = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeOutputMaterial")
    scatter.inputs["Density"].default_value = density
    tree.links.new(scatter.outputs[0], out.inputs["Volume"])
    bpy.context.object.data.materials.append(fog)


class DataPasses(EngineTest):
    """One scene by both engines."""

    def setUp(self):
        super().setUp()
        scene = self.for_both((WIDTH, HEIGHT), SAMPLES)
        layer = scene.view_layers[0]
        for name in ("mist", "object_index", "material_index", *(f"cryptomatte_{kind.lower()}" for kind in KINDS)):
            setattr(layer, f"use_pass_{name}", True)
        cube, floor = bpy.data.objects["Cube"], bpy.data.objects["Floor"]
        cube.pass_index, cube.active_material.pass_index = 7, 3
        top = bpy.data.objects.new("top of all", None)
        scene.collection.objects.link(top)
        floor.parent = top
        # Two materials that differ in their names alone, on one mesh; and one that is half transparent.
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=0.8, location=(2, 1, 0))
        ball = self.ball = bpy.context.object
        ball.name, ball.pass_index, ball.parent = "ball", 12, cube
        ball.matrix_parent_inverse = cube.matrix_world.inverted()
        for name, index in (("one", 0), ("two", 5)):
            ball.data.materials.append(kit.material(name, Base_Color=(0.5, 0.2, 0.1, 1)))
            ball.data.materials[-1].pass_index = index
        for number, face in enumerate(ball.data.polygons):
            face.material_index = number % 2
        bpy.ops.mesh.primitive_plane_add(size=2, location=(-1.5, -2, 0.5), rotation=(math.radians(70), 0, 0.6))
        bpy.context.object.name = "veil"
        bpy.context.object.data.materials.append(kit.material("half", Alpha=0.5))
        mist = scene.world.mist_settings
        mist.start, mist.depth = 4, 9

    def both(self):
        """The passes of Sundog's file and of Cycles'."""
        found = []
        for engine in ("SUNDOG", "CYCLES"):
            self.scene.render.engine = engine
            found.append(self.render(engine))
        return found

    def near(self, name, ours, theirs, off=0.01, error=1e-3):
        ours, theirs = ours.astype(float), theirs.astype(float)
        mean = ours.mean() / theirs.mean() - 1 if theirs.any() else abs(ours).max()
        relative = ((ours - theirs) ** 2 / (theirs**2 + 0.01)).mean()
        print(f"{name}: mean {mean:+.3%}, relMSE {relative:.1e}", flush=True)
        self.assertLess(abs(mean), off, name)
        self.assertLess(relative, error, name)

    def test_mist_and_indices(self):
        for falloff in ("QUADRATIC", "LINEAR", "INVERSE_QUADRATIC"):
            self.scene.world.mist_settings.falloff = falloff
            ours, theirs = self.both()
            self.near(f"mist {falloff}", ours["ViewLayer.Mist"], theirs["ViewLayer.Mist"])
            if falloff == "LINEAR":
                for name in INDICES:
                    a, b = (passes[f"ViewLayer.{name}"][..., 0] for passes in (ours, theirs))
                    print(f"{name}: {(a != b).mean():.3%} of the pixels differ; {sorted(set(b.ravel()))}", flush=True)
                    self.assertEqual(sorted(set(a.ravel())), sorted(set(b.ravel())))
                    self.assertLess((a != b).mean(), 0.005, name)

    def test_ambient_occlusion(self):
        self.scene.view_layers[0].use_pass_ambient_occlusion = True
        name = "ViewLayer.Ambient Occlusion" if FIVE else "ViewLayer.AO"
        for distance in (10, 0.7):
            self.scene.world.light_settings.distance = distance
            ours, theirs = self.both()
            self.near(f"ambient occlusion within {distance}", ours[name], theirs[name], error=0.01)
            blocks = [passes[name].astype(float).reshape(HEIGHT // 8, 8, WIDTH // 8, 8, 3).mean(axis=(1, 3)) for passes in (ours, theirs)]
            self.near(f"the same, blocks within {distance}", *blocks)

    def test_a_view_layers_world_says_how_far_occlusion_looks(self):
        """And not what mist there is."""
        layer = self.scene.view_layers[0]
        layer.use_pass_ambient_occlusion = True
        name = "ViewLayer.Ambient Occlusion" if FIVE else "ViewLayer.AO"
        layer.world_override = bpy.data.worlds.new("other")
        layer.world_override.light_settings.distance, layer.world_override.mist_settings.start = 0.5, 8
        self.near_open(name, "by the view layer's world")
        layer.world_override = None
        self.scene.world = None
        self.near_open(name, "without a world")

    def near_open(self, name, words):
        ours, theirs = self.both()
        self.near(f"ambient occlusion {words}", ours[name], theirs[name], error=0.02)
        self.near(f"mist {words}", ours["ViewLayer.Mist"], theirs["ViewLayer.Mist"])

    def test_times(self):
        if not hasattr(self.scene.view_layers[0].cycles, "pass_render_time"):
            self.skipTest("Cycles has no such pass")
        self.scene.view_layers[0].cycles.pass_render_time = True
        found = self.both()
        means = [passes["ViewLayer.Render Time"].astype(float).mean() for passes in found]
        print(f"milliseconds a pixel: {means}", flush=True)
        for mean in means:
            # Of 128 samples, in milliseconds.
            self.assertTrue(0.01 < mean < 100, mean)

    def test_fog_hides_data_by_chance(self):
        """What the ray through a pixel's middle tells is told where no fog scatters it: a share of the pixels."""
        layer = self.scene.view_layers[0]
        layer.use_pass_z = layer.use_pass_ambient_occlusion = True
        add_fog(0.1)
        ours, theirs = self.both()
        depth, index = "ViewLayer.Depth", f"ViewLayer.{INDICES[0]}"
        shares = [[(passes[depth] < 1e9).mean(), (passes[index] == 7).mean()] for passes in (ours, theirs)]
        print(f"shares of pixels with a depth, and with the cube's index: {shares}", flush=True)
        for a, b in zip(*shares):
            self.assertGreater(b, 0.01)
            # By as many draws as there are pixels.
            self.assertLess(abs(a - b), 5 * math.sqrt(2 * b / (WIDTH * HEIGHT)))
        name = "ViewLayer.Ambient Occlusion" if FIVE else "ViewLayer.AO"
        self.near("ambient occlusion in fog", ours[name], theirs[name], error=0.02)

    def test_denoising_depth_begins_at_the_clip_plane_and_goes_on_behind_what_bounds_a_volume(self):
        """There was the rest of the way behind bounds alone: 0.1 of the depth. In Cycles paths that a fog has scattered write on."""
        layer = self.scene.view_layers[0]
        layer.cycles.denoising_store_passes = True
        self.scene.camera.data.clip_start = 2.0
        # Cycles has another share of what is behind what lets half through.
        bpy.data.objects.remove(bpy.data.objects["veil"])
        plain, theirs = (passes["ViewLayer.Denoising Depth"].astype(float) for passes in self.both())
        add_fog(1e-4)
        behind = self.both()[0]["ViewLayer.Denoising Depth"].astype(float)
        for words, depth, of in (("Cycles", plain, theirs), ("without the volume", behind, plain)):
            met = (depth < 1e9) & (of < 1e9)
            print(f"denoising depth: {depth[met].mean():.3f}, {words} {of[met].mean():.3f}", flush=True)
            self.assertGreater(met.mean(), 0.5)
            self.assertLess(((depth < 1e9) != (of < 1e9)).mean(), 0.02)
            self.assertLess(abs(depth[met].mean() / of[met].mean() - 1), 0.003)

    def test_an_orthographic_camera_has_mist_by_depth(self):
        self.scene.camera.data.type, self.scene.camera.data.ortho_scale = "ORTHO", 8
        ours, theirs = self.both()
        self.near("orthographic mist", ours["ViewLayer.Mist"], theirs["ViewLayer.Mist"])

    def test_cryptomatte_has_cycles_numbers_and_shares(self):
        ours, theirs = self.both()
        for kind in KINDS:
            a, b = coverage(ours, kind), coverage(theirs, kind)
            self.assertEqual(set(a), set(b), kind)
            for number in b:
                # A share has a deviation of 1/22 at the most, of 128 samples.
                off = numpy.abs(a[number] - b[number])
                print(f"{kind} {number:08x}: mean {a[number].mean() / b[number].mean() - 1:+.2%}, rms {math.sqrt((off**2).mean()):.4f}, most {off.max():.3f}")
                self.assertLess(abs(a[number].mean() - b[number].mean()), 0.01 * b[number].mean() + 1e-4)
                self.assertLess((off**2).mean(), 1e-3)
                self.assertLess(off.max(), 0.25)

    def test_blenders_node_picks_mattes_of_the_files(self):
        """The Cryptomatte node on a file of the command line, against the one on Cycles' file."""
        self.scene.render.engine = "CYCLES"
        self.render("cycles")
        theirs = os.path.join(self.folder, "cycles.exr")
        self.scene.render.engine = "SUNDOG"
        ours = os.path.join(self.folder, "sundog.exr")
        found = kit.in_render(lambda depsgraph: kit.export.write_scene(depsgraph, depsgraph.scene, self.folder, self.folder))
        names = ",".join(f"Crypto{kind}" for kind in KINDS)
        command = [self.program, "render", found.path, "-o", ours, "--allow-outside", "--quiet", "--passes", f"Combined,{names}"]
        command += ["--width", str(WIDTH), "--height", str(HEIGHT), "--samples", str(SAMPLES), "--exr-compression", "none"]
        subprocess.run(command, check=True)
        attributes = exr._header(open(ours, "rb").read(), 8)[0]
        manifests = {v["name"]: json.loads(v["manifest"]) for v in self.cryptomattes(attributes).values()}
        self.assertEqual(manifests["CryptoObject"]["Cube"], "a8fce865")
        self.assertEqual(set(manifests["CryptoMaterial"]), {"Material", "default_surface", "one", "two", "half"})
        self.assertEqual(set(manifests["CryptoAsset"]), {"Cube", "top of all", "veil"})
        for kind, name in (("Object", "ball"), ("Material", "two"), ("Material", "default_surface"), ("Asset", "Cube"), ("Object", "veil")):
            a, b = self.picked(ours, f"Crypto{kind}", name), self.picked(theirs, f"ViewLayer.Crypto{kind}", name)
            off = numpy.abs(a - b)
            print(f"{kind} {name}: mean {a.mean():.5f} and {b.mean():.5f}, most {off.max():.3f}", flush=True)
            self.assertGreater(b.mean(), 1e-3)
            self.assertLess(abs(a.mean() / b.mean() - 1), 0.01)
            self.assertLess(off.max(), 0.25)

    @staticmethod
    def cryptomattes(attributes):
        """What a file says of its mattes, by their keys."""
        found = {}
        for name, value in attributes.items():
            if name.startswith("cryptomatte/"):
                _, key, what = name.split("/")
                found.setdefault(key, {})[what] = value.decode()
        return found

    def picked(self, path, layer, name):
        """The matte that Blender's node makes of a file."""
        scene = bpy.data.scenes.new("compositor")
        scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH, HEIGHT, 100
        scene.view_settings.view_transform = "Raw"
        if FIVE:
            tree = scene.compositing_node_group = bpy.data.node_groups.new("picked", "CompositorNodeTree")
            tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
            end = tree.nodes.new("NodeGroupOutput")
        else:
            scene.use_nodes = True
            tree = scene.node_tree
            tree.nodes.clear()
            end = tree.nodes.new("CompositorNodeComposite")
        node = tree.nodes.new("CompositorNodeCryptomatteV2")
        node.source = "IMAGE"
        node.image = bpy.data.images.load(path)
        node.layer_name = layer
        node.matte_id = name
        tree.links.new(node.outputs["Matte"], end.inputs[0])
        scene.render.use_sequencer = False
        image = scene.render.image_settings
        if hasattr(image, "media_type"):
            image.media_type = "IMAGE"
        image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"
        camera = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
        scene.collection.objects.link(camera)
        scene.camera = camera
        scene.render.engine = "CYCLES"
        scene.cycles.samples = 1
        scene.render.filepath = os.path.join(self.folder, "matte.exr")
        with kit.quiet():
            bpy.ops.render.render(write_still=True, scene=scene.name)
        values = kit.exr_pixels(scene.render.filepath)[..., 0].astype(float)
        bpy.data.scenes.remove(scene)
        return values


def shader(tree, kind, color=None):
    node = tree.nodes.new(f"ShaderNode{kind}")
    if color:
        node.inputs["Color"].default_value = (*color, 1)
    return node


def mixed(tree, factor, first, second):
    node = tree.nodes.new("ShaderNodeMixShader")
    node.inputs[0].default_value = factor
    for socket, side in zip(node.inputs[1:], (first, second)):
        tree.links.new(side.outputs[0], socket)
    return node


def matte(tree):
    return shader(tree, "BsdfDiffuse", (0.3, 0.6, 0.8))


def clear(tree, color=(1, 1, 1)):
    return shader(tree, "BsdfTransparent", color)


TINT, BLACK = (0.9, 0.5, 0.25), (0, 0, 0)
#: What surfaces are there in part: by name their shaders, and whether the object is a holdout.
PATCHES = {
    "tinted": (lambda t: mixed(t, 0.4, clear(t, TINT), matte(t)), False),
    "faint": (lambda t: mixed(t, 0.2, clear(t), matte(t)), False),
    "black": (lambda t: clear(t, BLACK), False),
    "half black": (lambda t: mixed(t, 0.5, clear(t, BLACK), matte(t)), False),
    "filter": (lambda t: clear(t, (0.5, 0.3, 0.1)), False),
    "half a light": (lambda t: mixed(t, 0.5, clear(t), shader(t, "Emission")), False),
    "holdout": (lambda t: shader(t, "Holdout"), False),
    "half a holdout": (lambda t: mixed(t, 0.5, shader(t, "Holdout"), matte(t)), False),
    "clear holdout": (lambda t: mixed(t, 0.3, clear(t), shader(t, "Holdout")), False),
    "three": (lambda t: mixed(t, 0.5, mixed(t, 0.4, clear(t, TINT), shader(t, "Holdout")), matte(t)), False),
    "held": (lambda t: mixed(t, 0.4, clear(t, TINT), matte(t)), True),
    "held light": (lambda t: shader(t, "Emission"), True),
}
#: What these tell of a faint surface hangs on how often paths stop there, which each engine chooses.
BY_CHANCE = ("Depth", "Index", "IndexOB", "Normal", "UV")
STEP = 8


class InPart(EngineTest):
    """Surfaces of which some is there, and what the camera sees behind them."""

    def test_what_is_there_in_part_counts_by_that(self):
        scene = self.for_both((STEP * len(PATCHES), 2 * STEP), 64)
        bpy.data.objects.remove(bpy.data.objects["Cube"])
        camera = scene.camera
        camera.location, camera.rotation_euler = (0, 0, 10), (0, 0, 0)
        camera.data.type, camera.data.ortho_scale = "ORTHO", len(PATCHES)
        scene.render.film_transparent = True
        scene.world.mist_settings.start, scene.world.mist_settings.depth, scene.world.mist_settings.falloff = 2, 20, "LINEAR"
        layer = scene.view_layers[0]
        for name in ("ambient_occlusion", "mist", "uv", "z", "normal", "object_index", "diffuse_color", "emit", "cryptomatte_object"):
            setattr(layer, f"use_pass_{name}", True)
        bpy.data.objects["Floor"].hide_render = True
        for number, (name, (build, is_held)) in enumerate(PATCHES.items()):
            bpy.ops.mesh.primitive_plane_add(size=1, location=(number - len(PATCHES) / 2 + 0.5, 0, 0))
            patch = bpy.context.object
            patch.scale.y = 2
            patch.name, patch.is_holdout, patch.pass_index = name, is_held, number + 1
            material = bpy.data.materials.new(name)
            material.use_nodes = True
            tree = material.node_tree
            tree.nodes.clear()
            end = tree.nodes.new("ShaderNodeOutputMaterial")
            tree.links.new(build(tree).outputs[0], end.inputs["Surface"])
            patch.data.materials.append(material)
        # Two rows: there is something behind the lower one.
        bpy.ops.mesh.primitive_plane_add(size=1, location=(0, -0.5, -3))
        bpy.context.object.name, bpy.context.object.scale = "behind", (len(PATCHES), 1, 1)
        found = []
        for engine in ("SUNDOG", "CYCLES"):
            scene.render.engine = engine
            found.append(self.render(engine))
        self.assertEqual(set(found[0]), set(found[1]))
        # Shares of objects stand where the mattes were.
        shares = [coverage(passes, "Object") for passes in found]
        self.assertEqual(set(shares[0]), set(shares[1]))
        kept = {name for name in found[0] if "Crypto" not in name}
        ours, theirs = ({name: passes[name] for name in kept} | {f"share {n:08x}": v for n, v in share.items()} for passes, share in zip(found, shares))
        for name in sorted(ours):
            for number, patch in enumerate(PATCHES):
                for below, first in ((False, 0), (True, STEP)):
                    cell = (slice(first + 1, first + STEP - 1), slice(number * STEP + 1, number * STEP + STEP - 1))
                    a, b = ours[name][cell].astype(float), theirs[name][cell].astype(float)
                    if patch == "faint" and name.endswith(BY_CHANCE):
                        continue
                    with self.subTest(name=name, patch=patch, below=below):
                        # Each pixel has 64 samples in order: five standard deviations of the difference of two means of coins.
                        numpy.testing.assert_allclose(a.mean((0, 1)), b.mean((0, 1)), atol=0.05)


if __name__ == "__main__":
    unittest.main()
