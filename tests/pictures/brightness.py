# SPDX-License-Identifier: GPL-3.0-or-later
"""Brightness of every kind of light against Cycles: the same scene, made here, rendered by both. Cycles' pictures are kept (references.py).

    python brightness.py --sundog PROGRAM [--only PART] [--every N] [--samples COUNT] [--json FILE]

Each scene is a floor with two boxes on it, seen from above, with one light: every kind of light, under every kind of transform, lights and
objects that some rays do not see, and worlds. It goes through the add-on's export. The mean luminance of the two pictures must agree within 1 %; the standard error of the
comparison, from two seeds each, must be below 0.2 %.
"""

import argparse
import itertools
import json
import math
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(HERE), "addon"))

import bpy  # noqa: E402
import export_kit as kit  # noqa: E402
import numpy  # noqa: E402
import references  # noqa: E402
from mathutils import Euler, Matrix  # noqa: E402
from sundog import export  # noqa: E402

WIDTH, HEIGHT = 48, 36
LIMIT = 0.01
MOST_ERROR = 0.002
# Where the error is larger: four times as many samples, up to this number.
MOST_SAMPLES = 4096
LUMINANCE = numpy.array([0.2126, 0.7152, 0.0722])

# Kind and settings of each light.
LIGHTS = {
    "point": ("POINT", {"shadow_soft_size": 0.3, "use_soft_falloff": False}),
    "point, soft falloff": ("POINT", {"shadow_soft_size": 0.3, "use_soft_falloff": True}),
    "point of no size": ("POINT", {"shadow_soft_size": 0.0}),
    "spot": ("SPOT", {"shadow_soft_size": 0.2, "use_soft_falloff": False, "spot_size": 1.3, "spot_blend": 0.3}),
    "spot, soft falloff": ("SPOT", {"shadow_soft_size": 0.2, "use_soft_falloff": True, "spot_size": 1.3, "spot_blend": 0.3}),
    "sun": ("SUN", {"angle": 0.2}),
    "square": ("AREA", {"shape": "SQUARE", "size": 0.8}),
    "rectangle": ("AREA", {"shape": "RECTANGLE", "size": 1.2, "size_y": 0.4}),
    "disk": ("AREA", {"shape": "DISK", "size": 0.8}),
    "ellipse": ("AREA", {"shape": "ELLIPSE", "size": 1.2, "size_y": 0.4}),
    "square, spread": ("AREA", {"shape": "SQUARE", "size": 0.8, "spread": 1.6}),
    "rectangle, narrow spread": ("AREA", {"shape": "RECTANGLE", "size": 1.2, "size_y": 0.4, "spread": 0.4}),
    "disk, spread": ("AREA", {"shape": "DISK", "size": 0.8, "spread": 1.6}),
    "ellipse, spread": ("AREA", {"shape": "ELLIPSE", "size": 1.2, "size_y": 0.4, "spread": 1.0}),
    "square, no spread": ("AREA", {"shape": "SQUARE", "size": 1.5, "spread": 0.0}),
}

PLACE = Matrix.Translation((0.3, -0.2, 2.4)) @ Euler((0.25, 0.2, 0.4)).to_matrix().to_4x4()


def _scale(x, y, z):
    return Matrix.Diagonal((x, y, z, 1))


# The world matrix of the light, or (that of its parent, its own below it).
TRANSFORMS = {
    "plain": PLACE,
    "scaled": PLACE @ _scale(1.7, 1.7, 1.7),
    "non-uniform": PLACE @ _scale(1.5, 0.6, 2.2),
    "mirrored": PLACE @ _scale(-1, 1, 1),
    "negative": PLACE @ _scale(-1.2, -0.7, 1.4),
    "parent": (PLACE @ _scale(1.6, 1.6, 1.6), Euler((0.1, -0.2, 0.6)).to_matrix().to_4x4()),
    "sheared by its parent": (PLACE @ _scale(1.5, 0.8, 1.0), Euler((0, 0, 0.5)).to_matrix().to_4x4()),
}

# About sheared area lights Cycles does not agree with itself: its samples take the edges for upright, its rays the projections on the
# edges. Only its samples of whole ellipses lie on the true outline; the others are shown, not judged.
SHEARED = "sheared by its parent"
# Whatever the transform does, it is nothing to these but their place and direction.
ROUND = {"POINT", "SUN"}
OF_ROUND = {"plain", "non-uniform", "negative", SHEARED}


def fresh():
    """An empty file with the floor, the boxes and the camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    grey = kit.material("grey", Base_Color=(0.6, 0.6, 0.6, 1), Roughness=1.0)
    principled = grey.node_tree.nodes["Principled BSDF"]
    principled.inputs["Specular IOR Level"].default_value = 0
    for name, mesh, place in (
        ("floor", kit.plane(size=12), Matrix.Identity(4)),
        ("box", kit.cube(size=0.5), Matrix.Translation((0.6, 0.5, 0.25))),
        ("beam", kit.cube(size=0.4), Matrix.Translation((-0.8, -0.3, 0.8)) @ _scale(0.5, 3, 0.5)),
    ):
        mesh.materials.append(grey)
        made = bpy.data.objects.new(name, mesh)
        made.matrix_world = place
        scene.collection.objects.link(made)
    data = bpy.data.cameras.new("camera")
    data.lens = 35
    camera = bpy.data.objects.new("camera", data)
    camera.location = (0, 0, 6)
    scene.collection.objects.link(camera)
    scene.camera = camera
    world = bpy.data.worlds.new("world")
    world.color = (0, 0, 0)
    scene.world = world
    return scene


def add_light(kind, settings, place):
    """A light of 100 W (a sun of 3 W/m²)."""
    data = bpy.data.lights.new("light", kind)
    data.energy = 3 if kind == "SUN" else 100
    data.color = (1, 0.8, 0.5)
    for key, value in settings.items():
        setattr(data, key, value)
    light = bpy.data.objects.new("light", data)
    bpy.context.scene.collection.objects.link(light)
    if isinstance(place, tuple):
        empty = bpy.data.objects.new("parent", None)
        bpy.context.scene.collection.objects.link(empty)
        light.parent = empty
        empty.matrix_world, light.matrix_local = place
    else:
        light.matrix_world = place
    bpy.context.view_layer.update()


def seen_by_some(name, **attributes):
    """A rectangle over a floor that shines a little, and what the attributes of an object say of who sees it."""
    kind, settings = LIGHTS["rectangle"]
    add_light(kind, settings, TRANSFORMS["plain"])
    principled = bpy.data.materials["grey"].node_tree.nodes["Principled BSDF"]
    principled.inputs["Specular IOR Level"].default_value = 1.0
    principled.inputs["Roughness"].default_value = 0.4
    for key, value in attributes.items():
        setattr(bpy.data.objects[name], key, value)
    bpy.context.view_layer.update()


def without_shadows():
    """A rectangle that casts none."""
    seen_by_some("light")
    data = bpy.data.lights["light"]
    data.use_shadow = False
    if hasattr(data.cycles, "cast_shadow"):
        data.cycles.cast_shadow = False


def add_world(image, rotation):
    """A world of one colour, or an image that is turned."""
    world = bpy.context.scene.world
    world.use_nodes = True
    tree = world.node_tree
    background = next(n for n in tree.nodes if n.type == "BACKGROUND")
    background.inputs["Strength"].default_value = 1.5
    if not image:
        background.inputs["Color"].default_value = (0.4, 0.6, 0.8, 1)
        return
    picture = bpy.data.images.new("sky", 64, 32, float_buffer=True)
    values = numpy.full((32, 64, 4), 0.3, numpy.float32)
    values[18:24, 10:20, :3] = (40, 30, 20)
    values[:16, :, 2] = 0.1
    # (From 5.1 on Cycles multiplies an image of floats that is in memory alone by its alpha; this is not about that.)
    values[..., 3] = 1.0
    picture.pixels.foreach_set(values.ravel())
    picture.update()
    environment = tree.nodes.new("ShaderNodeTexEnvironment")
    environment.image = picture
    tree.links.new(environment.outputs["Color"], background.inputs["Color"])
    mapping, coordinates = tree.nodes.new("ShaderNodeMapping"), tree.nodes.new("ShaderNodeTexCoord")
    mapping.inputs["Rotation"].default_value = rotation
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], environment.inputs["Vector"])


def cases():
    """(name, what makes the scene, whether it must agree)."""
    for light, (kind, settings) in LIGHTS.items():
        for transform, place in TRANSFORMS.items():
            if kind not in ROUND or transform in OF_ROUND:
                judged = kind != "AREA" or transform != SHEARED or light in {"disk", "ellipse"}
                yield f"{light}: {transform}", lambda k=kind, s=settings, p=place: add_light(k, s, p), judged
    if bpy.app.version >= (4, 5, 0):
        for light in ("point", "point, soft falloff", "point of no size", "spot", "sun", "rectangle", "ellipse", "disk, spread"):
            kind, settings = LIGHTS[light]
            settings = {**settings, "normalize": False, "energy": 8 if kind != "SUN" else 40}
            for transform in ("plain", "non-uniform"):
                yield f"{light}, not normalised: {transform}", lambda k=kind, s=settings, p=TRANSFORMS[transform]: add_light(k, s, p), True
    yield "seen by all", lambda: seen_by_some("light"), True
    for name in ("light", "beam"):
        for kind in ("camera", "diffuse", "glossy", "shadow"):
            if (name, kind) not in {("light", "camera"), ("light", "shadow")}:
                yield f"{name} not seen by {kind} rays", lambda n=name, k=kind: seen_by_some(n, **{f"visible_{k}": False}), True
    yield "light without shadows", without_shadows, True
    yield "world colour", lambda: add_world(False, (0, 0, 0)), True
    for name, rotation in (("plain", (0, 0, 0)), ("turned about Z", (0, 0, 1.1)), ("turned", (0.7, -0.4, 2.0))):
        yield f"world image: {name}", lambda r=rotation: add_world(True, r), True


def by_cycles(name, samples, seed):
    """Mean luminance."""
    scene = bpy.context.scene
    cycles = scene.cycles
    cycles.max_bounces, cycles.seed = 0, seed
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    scene.render.use_persistent_data = False
    # The export reads the size that is set here.
    kit.for_cycles(WIDTH, HEIGHT, samples)
    made = references.kept(__file__, f"{name} {samples} {seed}", lambda: {"Combined": kit.cycles_pixels(WIDTH, HEIGHT, samples)})
    return float(made["Combined"].mean(axis=(0, 1)) @ LUMINANCE)


def by_sundog(program, folder, samples, seed):
    """Mean luminance."""
    def task(depsgraph):
        return export.write_scene(depsgraph, depsgraph.scene, os.path.join(folder, "scene"), os.path.join(folder, "cache"))

    path = kit.in_render(task).path
    result = os.path.join(folder, "picture.exr")
    arguments = [program, "render", path, "--allow-outside", "-o", result, "--width", WIDTH, "--height", HEIGHT, "--samples", samples, "--seed", seed]
    done = subprocess.run(
        [str(a) for a in arguments] + ["--bounces", "0", "--filter", "box", "--exr-layers", "combined", "--exr-type", "float"],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        sys.exit(f"sundog failed: {done.stderr}")
    return float(kit.exr_pixels(result).mean(axis=(0, 1)) @ LUMINANCE)


def main():
    """Renders, prints the table, and fails if a light differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sundog", required=True)
    parser.add_argument("--only", default="", help="scenes whose names contain this")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="one of so many scenes")
    parser.add_argument("--samples", type=int, default=64, help="samples a pixel, for each of the two seeds")
    parser.add_argument("--sheared", action="store_true", help="show sheared area lights too")
    parser.add_argument("--json", help="where to write the table")
    given = parser.parse_args()
    rows, wrong = [], []
    with tempfile.TemporaryDirectory(prefix="sundog-brightness-") as folder:
        for name, make, judged in itertools.islice(cases(), 0, None, given.every):
            if given.only not in name or not (judged or given.sheared):
                continue
            fresh()
            make()
            samples = given.samples
            while True:
                cycles = [by_cycles(name, samples, seed) for seed in (0, 1)]
                sundog = [by_sundog(given.sundog, folder, samples, seed) for seed in (0, 1)]
                mean = numpy.mean(cycles)
                if mean <= 0:
                    if judged:
                        sys.exit(f"{name}: Cycles' picture is black")
                    ratio = error = math.nan
                    break
                ratio = numpy.mean(sundog) / mean
                # Of the mean of two: half of their difference.
                error = math.hypot(cycles[0] - cycles[1], sundog[0] - sundog[1]) / 2 / mean
                if error <= MOST_ERROR or samples >= MOST_SAMPLES:
                    break
                samples *= 4
            rows.append({"scene": name, "cycles": float(mean), "sundog": float(numpy.mean(sundog)), "ratio": float(ratio), "error": error, "judged": judged})
            verdict = "" if judged else "(not judged)"
            if judged and not abs(ratio - 1) <= LIMIT:
                verdict = "DIFFERS"
            elif judged and error > MOST_ERROR:
                verdict = "NOISY"
            if judged and verdict:
                wrong.append(name)
            print(f"{name:48} {mean:10.5f} {numpy.mean(sundog):10.5f}  {100 * (ratio - 1):+7.3f} %  ± {100 * error:.3f} %  {verdict}", flush=True)
    if given.json:
        with open(given.json, "w", encoding="utf-8") as file:
            json.dump(rows, file, indent=1)
    worst = max((abs(row["ratio"] - 1) for row in rows if row["judged"]), default=0)
    print(f"{len(rows)} scenes, {len(wrong)} wrong, largest difference {100 * worst:.3f} %")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
