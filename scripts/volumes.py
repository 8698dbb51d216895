# SPDX-License-Identifier: MIT OR Apache-2.0
"""Measures time x relMSE of volumes and of light below surfaces beside Cycles', in one run.

    PYTHON_WITH_BPY scripts/volumes.py [SCENE]... [--samples 64] [--seeds 4] [--pixels 14080] [--out FILE]

Each scene is made here and rendered by Blender's operator, through Sundog's add-on or by Cycles, with one thread, in turn. Times are
processor seconds of Blender's and of Sundog's process, without those of a picture of one sample: export and set-up do not count.

relMSE is the variance between seeds over the square of the mean of all pictures plus 0.01, so that it needs no reference. Nothing is
clamped, and no filter makes glossy surfaces wider. `trimmed` leaves out the hundredth of the pixels that err most.
"""

import argparse
import math
import os
import statistics
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path[:0] = [os.path.join(ROOT, place) for place in ("scripts", "blender_addon", os.path.join("tests", "addon"))]

import bpy  # noqa: E402
import export_kit as kit  # noqa: E402
import numpy  # noqa: E402
from denoised import ENGINES, conditions, geometric, processor_seconds, tell  # noqa: E402
from sundog.compare.settings import linear_exr  # noqa: E402

LAMPS = {"area": ("AREA", (2, -1, 4), 300), "point": ("POINT", (-2, -2, 2), 100)}
ALL_LAMPS = {**LAMPS, "sun": ("SUN", (0, 0, 8), 3)}


def stage(lamps, bounces):
    """A floor below lamps and a grey world, seen by a camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.volume_bounces = bounces
    bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -1.2))
    bpy.context.object.data.materials.append(kit.material("floor"))
    for name in lamps:
        kind, place, energy = ALL_LAMPS[name]
        bpy.ops.object.light_add(type=kind, location=place)
        bpy.context.object.data.energy = energy
    kit.even_world(scene, 0.1)
    bpy.ops.object.camera_add(location=(0, -7, 1.5), rotation=(math.radians(80), 0, 0))
    scene.camera = bpy.context.object


def filled(kind, **sockets):
    """The material tree of the object that was made last: a volume of one shader."""
    material = kit.material("filled")
    bpy.context.object.data.materials.append(material)
    tree = material.node_tree
    for node in [node for node in tree.nodes if node.type != "OUTPUT_MATERIAL"]:
        tree.nodes.remove(node)
    shader = tree.nodes.new(kind)
    for name, value in sockets.items():
        shader.inputs[name].default_value = value
    tree.links.new(shader.outputs[0], tree.nodes[0].inputs["Volume"])
    return tree, shader


def fog(lamps, density=1.0, bounces=4, size=2.0):
    """A cube of even fog."""
    stage(lamps, bounces)
    bpy.ops.mesh.primitive_cube_add(size=size)
    filled("ShaderNodeVolumeScatter", Color=(0.9, 0.8, 0.7, 1), Density=density, Anisotropy=0.3)


def by_noise(tree, shader, scale, *steps):
    """Makes the density of a volume a noise, after some operations."""
    place, noise = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value = scale
    tree.links.new(place.outputs["Object"], noise.inputs["Vector"])
    density = noise.outputs[0]
    for operation, value in steps:
        math_node = tree.nodes.new("ShaderNodeMath")
        math_node.operation, math_node.use_clamp = operation, operation == "SUBTRACT"
        math_node.inputs[1].default_value = value
        tree.links.new(density, math_node.inputs[0])
        density = math_node.outputs[0]
    tree.links.new(density, shader.inputs["Density"])


def uneven_fog(lamps):
    """A camera within a large cube of fog by a noise, nowhere empty."""
    stage(lamps, 2)
    bpy.ops.mesh.primitive_cube_add(size=30)
    tree, shader = filled("ShaderNodeVolumeScatter", Color=(0.9, 0.8, 0.7, 1))
    by_noise(tree, shader, 0.5, ("MULTIPLY", 0.1))


def cloud(lamps):
    """A cube whose density is a noise, less its mean: empty space and dense wisps."""
    stage(lamps, 4)
    bpy.ops.mesh.primitive_cube_add(size=2)
    tree, shader = filled("ShaderNodeVolumePrincipled", Color=(0.9, 0.8, 0.7, 1), Anisotropy=0.3)
    by_noise(tree, shader, 2.0, ("SUBTRACT", 0.45), ("MULTIPLY", 20.0))


def head(radius, color):
    """Blender's monkey with light below its surface."""
    stage(LAMPS, 4)
    bpy.ops.mesh.primitive_monkey_add(size=2.4, rotation=(0, 0, 0))
    monkey = bpy.context.object
    monkey.modifiers.new("smooth", "SUBSURF").levels = 2
    bpy.ops.object.shade_smooth()
    sockets = {"Base Color": color, "Subsurface Weight": 1.0, "Subsurface Radius": (1.0, 0.4, 0.2), "Subsurface Scale": radius}
    monkey.data.materials.append(kit.material("skin", **sockets))


SCENES = {
    "point lamp in fog": lambda: fog(("point",)),
    "area lamp in fog": lambda: fog(("area",)),
    "both lamps in fog": lambda: fog(LAMPS),
    "fog of 20 mean free paths": lambda: fog(LAMPS, density=10.0, bounces=12),
    "camera inside a thin fog": lambda: fog(LAMPS, density=0.05, size=30.0),
    "camera inside an uneven fog": lambda: uneven_fog(("sun",)),
    "cloud": lambda: cloud(LAMPS),
    "cloud below an area lamp": lambda: cloud(("area",)),
    "head, deep": lambda: head(0.3, (0.8, 0.5, 0.4, 1)),
    "head, shallow": lambda: head(0.03, (0.8, 0.5, 0.4, 1)),
}


def set_up(scene, pixels):
    """One thread, so many pixels, no bias of Cycles'."""
    side = math.sqrt(pixels / (20 * 11))
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = round(20 * side), round(11 * side), 100
    render.threads_mode, render.threads = "FIXED", 1
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    kit.unbiased(cycles)
    linear_exr(render.image_settings)


def rendered(scene, engine, samples, seed, path):
    """A picture and the processor seconds that it took."""
    from sundog import properties

    scene.cycles.samples, scene.cycles.seed = samples, seed
    properties.copy_from_cycles(scene)
    scene.render.engine, scene.render.filepath = engine, path
    before = processor_seconds()
    with kit.quiet():
        bpy.ops.render.render(write_still=True)
    took = processor_seconds() - before
    return kit.exr_pixels(path)[..., :3], took


def measure(build, given):
    """For each engine: seconds of its samples, relMSE, trimmed relMSE, mean."""
    build()
    scene = bpy.context.scene
    set_up(scene, given.pixels)
    pictures, seconds = ({engine: [] for engine in ENGINES} for _ in range(2))
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "picture.exr")
        for seed in range(given.seeds):
            for engine in ENGINES:
                _, before = rendered(scene, engine, 1, seed, path)
                picture, took = rendered(scene, engine, given.samples, seed, path)
                pictures[engine].append(picture)
                seconds[engine].append(took - before)
    mean = numpy.mean([picture for of in pictures.values() for picture in of], axis=0)
    told = {}
    for engine, of in pictures.items():
        errors = (numpy.var(of, axis=0, ddof=1) / (mean**2 + 0.01)).mean(axis=-1).ravel()
        errors.sort()
        trimmed = errors[: -max(len(errors) // 100, 1)]
        told[engine] = (statistics.median(seconds[engine]), errors.mean(), trimmed.mean(), numpy.mean(of))
    return told


def main():
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("scenes", nargs="*", help=f"of: {', '.join(SCENES)}; beginnings of names do")
    made.add_argument("--samples", type=int, default=64)
    made.add_argument("--seeds", type=int, default=4)
    made.add_argument("--pixels", type=int, default=14080)
    made.add_argument("--sundog", default=os.path.join(ROOT, "target", "release", "sundog"))
    made.add_argument("--out", help="where the table goes; standard output without it")
    given = made.parse_args()
    os.environ["SUNDOG_PROGRAM"] = given.sundog
    import sundog

    sundog.register()
    lines = [conditions(), "", "| scene | time / Cycles' | relMSE / Cycles' | product | trimmed product | mean / Cycles' |", "| --- " * 6 + "|"]
    products = []
    for name, build in SCENES.items():
        if given.scenes and not any(name.startswith(wanted) for wanted in given.scenes):
            continue
        ours, theirs = measure(build, given).values()
        time, error, trimmed, mean = (mine / other for mine, other in zip(ours, theirs))
        products.append(time * error)
        lines.append(f"| {name} | {time:.2f} | {error:.2f} | {time * error:.2f} | {time * trimmed:.2f} | {mean:.4f} |")
        print(lines[-1], f"{ours[0]:.1f} s and {theirs[0]:.1f} s", file=sys.stderr, flush=True)
    if not products:
        sys.exit("no scene has such a name")
    lines.append(f"| geometric mean | | | {geometric(products):.2f} | | |")
    tell("\n".join([*lines, ""]), given.out)


if __name__ == "__main__":
    main()
