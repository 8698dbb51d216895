# SPDX-License-Identifier: GPL-3.0-or-later
"""One scene for parity.py, in a process of its own: imports it into Blender, lights and frames it where it brings neither,
and renders it with Cycles and, through the add-on, with Sundog.

    PYTHON_WITH_BPY tests/parity/one.py SCENE FOLDER --samples N --pixels N [--environment FILE.hdr]

SCENE is a .gltf, .glb, .usd*, .blend file, or the name of a scene of traps.py. Leaves FOLDER/{cycles,sundog}-{0,1}.exr and
FOLDER/told.json.
"""

import argparse
import json
import math
import os
import sys
import time

import bpy
import mathutils

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
sys.path.insert(0, os.path.join(ROOT, "blender_addon"))
sys.path.insert(0, HERE)

import sundog  # noqa: E402
import traps  # noqa: E402

BOUNCES = 8
TRANSPARENT_BOUNCES = 64


def bring(given):
    """Fills the empty session with the scene."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    sundog.register()
    if given.scene in traps.SCENES:
        traps.SCENES[given.scene](given.folder)
        return
    ending = os.path.splitext(given.scene)[1].lower()
    if ending in {".gltf", ".glb"}:
        bpy.ops.import_scene.gltf(filepath=given.scene)
    elif ending.startswith(".usd"):
        bpy.ops.wm.usd_import(filepath=given.scene)
    else:
        bpy.ops.wm.open_mainfile(filepath=given.scene)


def corners():
    """World-space corners of the boxes of all that is rendered."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for instance in depsgraph.object_instances:
        shown = instance.object
        if instance.show_self and shown.type in {"MESH", "CURVE", "FONT", "SURFACE", "META"}:
            for corner in shown.bound_box:
                yield instance.matrix_world @ mathutils.Vector(corner)


def frame():
    """A camera that looks at everything from the front, a little from above and the right."""
    points = [p for p in corners() if all(map(math.isfinite, p))]
    if not points:
        return False
    low = mathutils.Vector([min(p[i] for p in points) for i in range(3)])
    high = mathutils.Vector([max(p[i] for p in points) for i in range(3)])
    middle, radius = (low + high) / 2, max((high - low).length / 2, 1e-3)
    data = bpy.data.cameras.new("framed")
    data.lens = 50
    # The ball about the middle fills the shorter side of the picture.
    distance = radius / math.sin(math.atan(0.5 * data.sensor_width * 0.75 / data.lens))
    data.clip_start, data.clip_end = distance * 1e-3, distance * 100
    camera = bpy.data.objects.new("framed", data)
    direction = mathutils.Vector((0.45, -1.0, 0.4)).normalized()
    camera.location = middle + direction * distance
    camera.rotation_euler = (-direction).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    return True


def is_lit():
    """Whether the scene brings light of its own: lamps, or a picture around it. (Surfaces that glow seldom light a scene.)"""
    world = bpy.context.scene.world
    around = world is not None and world.use_nodes and any(n.type == "TEX_ENVIRONMENT" for n in world.node_tree.nodes)
    return around or any(o.type == "LIGHT" for o in bpy.context.scene.objects)


def light(picture):
    """The world from an environment picture."""
    world = bpy.data.worlds.new("environment")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    texture, background = nodes.new("ShaderNodeTexEnvironment"), nodes.new("ShaderNodeBackground")
    output = nodes.new("ShaderNodeOutputWorld")
    texture.image = bpy.data.images.load(picture)
    links.new(texture.outputs["Color"], background.inputs["Color"])
    links.new(background.outputs["Background"], output.inputs["Surface"])


def set_up(given):
    scene = bpy.context.scene
    render, cycles, ours = scene.render, scene.cycles, scene.sundog
    height = max(round(math.sqrt(given.pixels * 0.75)), 8)
    render.resolution_x, render.resolution_y, render.resolution_percentage = height * 4 // 3, height, 100
    render.use_motion_blur = render.film_transparent = render.use_border = False
    render.use_compositing = render.use_sequencer = False
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode, render.image_settings.color_depth = "RGBA", "32"
    cycles.device, cycles.samples = "CPU", given.samples
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_auto_tile = False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = BOUNCES
    cycles.transparent_max_bounces = TRANSPARENT_BOUNCES
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = cycles.light_sampling_threshold = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.use_fast_gi = cycles.use_guiding = False
    render.engine = "CYCLES"
    bpy.ops.sundog.copy_settings_from_cycles()
    ours.samples = given.samples


def render(engine, path, seed):
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.cycles.seed = scene.sundog.seed = seed
    scene.render.filepath = path
    begun = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    return time.perf_counter() - begun


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scene")
    parser.add_argument("folder")
    parser.add_argument("--samples", type=int, required=True)
    parser.add_argument("--pixels", type=int, required=True)
    parser.add_argument("--environment")
    parser.add_argument("--own-camera", action="store_true")
    given = parser.parse_args()
    os.makedirs(given.folder, exist_ok=True)
    told = {"problem": None}
    try:
        bring(given)
    except RuntimeError as error:
        # Blender's importer raises a report, a traceback with it, and then where it was called.
        lines = [line for line in str(error).splitlines() if line.strip() and not line.startswith((" ", "Location:"))]
        told["problem"] = "Blender cannot import it: " + next((line for line in reversed(lines) if "Error" in line), lines[-1] if lines else "no reason told")
    if told["problem"] is None:
        if not (given.own_camera and bpy.context.scene.camera) and not frame():
            told["problem"] = "Blender's import of it has no geometry"
    if told["problem"] is None:
        # The rooms and boxes with a camera of their own are lit by their surfaces, or bring a picture.
        own = given.own_camera and not os.path.exists(os.path.join(os.path.dirname(given.scene), "env.exr"))
        if given.scene not in traps.SCENES and not own and not is_lit():
            light(given.environment)
        set_up(given)
        seconds = {"CYCLES": [], "SUNDOG": []}
        for index in range(2):
            for engine in seconds:
                path = os.path.join(given.folder, f"{engine.lower()}-{index}.exr")
                seconds[engine].append(render(engine, path, 11 + 7 * index + (100 if engine == "SUNDOG" else 0)))
        told["seconds"] = seconds
        told["verdicts"] = sundog.engine.last_verdicts()
    with open(os.path.join(given.folder, "told.json"), "w") as file:
        json.dump(told, file)


if __name__ == "__main__":
    main()
