# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes of the parity tests by both of the add-on's exchanges: one line for each picture that a test asks for.

    PYTHON_WITH_BPY tests/addon/parity_usd_scenes.py test_parity_hair [test_parity_motion …]

The tests run as they are, but each picture of Sundog's is made by glTF and by USD, twice each, and Cycles' is not made at all:
the tests get Sundog's in its place, and what they say of it does not count. Diffuse BSDFs and Emissions are Principled BSDFs in
both pictures, as USD has no others.
"""

import os
import sys
import unittest

import bpy
import numpy

import engine_kit
import export_kit as kit
from sundog import engine, export
from sundog.export import usd

BAR = 1e-4
# Samples of a picture at most, and as many standard errors of the noise that is left in the difference.
SAMPLES, ERRORS = 64, 3.0


def difference(gltf, other):
    """(relMSE without noise, its standard error) of two pictures by each exchange."""
    if gltf[0].shape != other[0].shape:
        return float("inf"), 0.0

    def blocks(picture):
        height, width = picture.shape[0] // 2 * 2, picture.shape[1] // 2 * 2
        picture = numpy.nan_to_num(picture[:height, :width, :3].astype(float))
        return picture.reshape(height // 2, 2, width // 2, 2, 3).mean(axis=(1, 3))

    a, b = [blocks(p) for p in gltf], [blocks(p) for p in other]
    mean = (a[0] + a[1]) / 2
    product = (a[0] - b[0]) * (a[1] - b[1]) / (mean**2 + 1e-2 * (mean**2).mean() + 1e-12)
    return float(product.mean()), float(product.std() / product.size**0.5)


def principled():
    """Makes shaders that are diffuse or shine alone Principled ones, which USD has: they would hide all else that differs."""
    for material in bpy.data.materials:
        tree = material.node_tree
        ends = [n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"] if tree else []
        for end in ends:
            link = next(iter(end.inputs["Surface"].links), None)
            node = link.from_node if link else None
            if node is None or node.type not in {"BSDF_DIFFUSE", "EMISSION"}:
                continue
            made = tree.nodes.new("ShaderNodeBsdfPrincipled")
            made.inputs["Specular IOR Level"].default_value = 0
            pairs = {"Color": "Base Color"} if node.type == "BSDF_DIFFUSE" else {"Color": "Emission Color", "Strength": "Emission Strength"}
            if node.type == "EMISSION":
                made.inputs["Base Color"].default_value = (0, 0, 0, 1)
            for old, new in pairs.items():
                made.inputs[new].default_value = node.inputs[old].default_value
                for source in node.inputs[old].links:
                    tree.links.new(source.from_socket, made.inputs[new])
            tree.links.new(made.outputs[0], end.inputs["Surface"])


class Scenes:
    """Stands between the tests and what they ask for."""

    def __init__(self):
        self.test, self.other, self.last = "", {}, None
        self.kept = kit.rendered, export.write_scene, engine_kit.EngineTest.render

    def say(self, found, verdicts, messages=()):
        error, noise = found
        lost = [f"{v['name']}: {v['detail']}" for v in verdicts if v["verdict"] != "exact"]
        lost += [f"{m['feature']}: {m['instead']}" for m in messages if m["verdict"] != "exact"]
        result = "same" if error < BAR else "named" if lost else "same, noise" if error < ERRORS * noise else "NOT NAMED"
        print(f"{result} {self.test}: relMSE {error:.1e} ± {noise:.0e}; {' | '.join(lost)[:300]}", flush=True)

    def write(self, depsgraph, scene, folder, cache, **options):
        """`export.write_scene`, by both where a test calls it."""
        ours = scene.render.engine == kit.Engine.bl_idname
        if ours:
            principled()
            depsgraph.update()
        found = self.kept[1](depsgraph, scene, folder, cache, **options)
        if ours:
            beside = os.path.join(folder, "usd")
            os.makedirs(beside, exist_ok=True)
            try:
                self.other[found.path] = usd.write_scene(depsgraph, beside)
            except export.ExportError as error:
                self.other[found.path] = error
        return found

    def rendered(self, path, width, height, samples, *more):
        """`export_kit.rendered`, by both."""
        few = min(samples, SAMPLES)
        other = self.other.get(path)
        if isinstance(other, export.ExportError):
            print(f"refused {self.test}: {other}", flush=True)
        elif other is not None:
            seeds = [("--seed", "1"), ("--seed", "2")]
            more = [word for word in more]
            if "--seed" in more:
                del more[more.index("--seed") : more.index("--seed") + 2]
            gltf = [self.kept[0](path, width, height, few, *more, *seed) for seed in seeds]
            by_usd = [self.kept[0](other.path, width, height, few, *more, *seed) for seed in seeds]
            self.say(difference(gltf, by_usd), other.verdicts, kit.info(other.path)["diagnostics"])
            self.last = gltf[0]
            return gltf[0]
        self.last = self.kept[0](path, width, height, few, *more)
        return self.last

    def cycles(self, width=8, height=8, *_more, **_settings):
        """In the place of Cycles' picture: the last one of Sundog's, or grey."""
        if self.last is not None and self.last.shape[:2] == (height, width):
            return self.last
        return numpy.full((height, width, 3), 0.5, numpy.float32)

    def render(self, test, name="picture", **options):
        """`EngineTest.render`, by both."""
        scene = test.scene
        principled()
        scene.render.engine = "SUNDOG"
        scene.sundog.samples = min(scene.sundog.samples, SAMPLES)
        pictures, verdicts = {}, []
        for exchange in ("GLTF", "USD"):
            scene.sundog.exchange = exchange
            pictures[exchange] = []
            for seed in (1, 2):
                scene.sundog.seed = seed
                try:
                    pictures[exchange].append(self.kept[2](test, f"{name}{exchange}{seed}", **options))
                except RuntimeError as error:
                    print(f"refused {self.test} by {exchange}: {error}", flush=True)
                    scene.sundog.exchange = "GLTF"
                    return pictures["GLTF"][0]
            verdicts = engine.last_verdicts()
        scene.sundog.exchange = "GLTF"
        if pictures["USD"][0] is not None:
            layer = next(key for key in pictures["USD"][0] if key.endswith("Combined"))
            self.say(difference(*([p[layer] for p in pictures[e]] for e in ("GLTF", "USD"))), verdicts)
        return pictures["GLTF"][0]


class Result(unittest.TestResult):
    """Tells the scenes which test runs."""

    scenes = None

    def startTest(self, test):
        super().startTest(test)
        self.scenes.test = test.id()


def main(names):
    scenes = Result.scenes = Scenes()
    kit.rendered, kit.cycles_pixels = scenes.rendered, scenes.cycles
    export.write_scene = scenes.write
    engine_kit.EngineTest.render = lambda test, name="picture", **options: scenes.render(test, name, **options)
    for name in names:
        unittest.defaultTestLoader.loadTestsFromName(name).run(Result())


if __name__ == "__main__":
    main(sys.argv[1:])
    sys.stdout.flush()
    # Blender's own teardown takes long and has nothing to say.
    os._exit(0)
