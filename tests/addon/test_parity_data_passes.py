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
                    # The veil is there or not by chance.
                    self.assertLess((a != b)[:, WIDTH // 2 :].mean(), 0.005, name)

    def test_ambient_occlusion(self):
        self.scene.view_layers[0].use_pass_ambient_occlusion = True
        name = "ViewLayer.Ambient Occlusion" if FIVE else "ViewLayer.AO"
        for distance in (10, 0.7):
            self.scene.world.light_settings.distance = distance
            ours, theirs = self.both()
            self.near(f"ambient occlusion within {distance}", ours[name], theirs[name], error=0.01)
            blocks = [passes[name].astype(float).reshape(HEIGHT // 8, 8, WIDTH // 8, 8, 3).mean(axis=(1, 3)) for passes in (ours, theirs)]
            self.near(f"the same, blocks within {distance}", *blocks)

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


if __name__ == "__main__":
    unittest.main()
