"""Files of others as Sundog reads them, beside Cycles' picture of Blender's import of the same file.

    BPY/bin/python scripts/gltf_sheet.py SCENES OUT.png [--usd] [--program target/release/sundog] [--only NAME ...]

SCENES is a folder with a folder for each scene, and hdri-open/studio_small_05_1k.hdr, which lights the files without light.
With --usd every file of USD in the folders whose names begin with "usd" is one, in the place of the glTF file of each folder.
OUT.png has two pictures a scene, Sundog's left; OUT.md names them row by row, with the means of both and how long each program
took to import the file and to make its picture (with the start of its process, for Sundog).
"""

import argparse
import json
import math
import subprocess
import tempfile
import time
from pathlib import Path

import bpy
import numpy
from mathutils import Vector

WIDTH, HEIGHT, COLUMNS = 160, 120, 3


def described(program, path):
    out = subprocess.run([program, "info", path, "--json"], capture_output=True, text=True)
    return json.loads(out.stdout) if out.returncode == 0 else None


def has_light(told):
    return bool(told["lights"] or told["environment"])


def with_sundog(program, path, out, light, samples):
    command = [program, "render", path, "-o", out, "--width", str(WIDTH), "--height", str(HEIGHT), "--samples", str(samples),
               "--view", "Standard", "--quiet"]
    begun = time.monotonic()
    done = subprocess.run(command + (["--environment", light] if light else []), capture_output=True, text=True)
    return time.monotonic() - begun, done.stderr.strip()


def imported(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    begun = time.monotonic()
    if ".usd" in path.suffix:
        bpy.ops.wm.usd_import(filepath=str(path), apply_unit_conversion_scale=True)
    else:
        bpy.ops.import_scene.gltf(filepath=str(path))
    return time.monotonic() - begun


def framed(told):
    """The camera that Sundog places, or the file's first one."""
    scene = bpy.context.scene
    cameras = sorted((o for o in scene.objects if o.type == "CAMERA"), key=lambda o: o.name)
    camera = told["cameras"][0]
    if cameras and camera["name"] != "all":
        named = [o for o in cameras if o.name == camera["name"]]
        scene.camera = (named or cameras)[0]
        return
    low, high = (Vector(corner) for corner in (told["bounds"]["low"], told["bounds"]["high"]))
    data = bpy.data.cameras.new("all")
    data.sensor_fit, data.angle = "VERTICAL", math.radians(camera["field_of_view"])
    data.clip_start, data.clip_end = 1e-3 * (high - low).length, 1e3 * (high - low).length
    x, y, z = camera["position"]
    place, middle = Vector((x, -z, y)), (low + high) / 2
    toward = Vector((middle.x, -middle.z, middle.y)) - place
    thing = bpy.data.objects.new("all", data)
    thing.location, thing.rotation_euler = place, toward.to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(thing)
    scene.camera = thing


def with_cycles(out, light, samples):
    scene = bpy.context.scene
    # A dome light of USD has become one.
    if light or scene.world is None:
        scene.world = bpy.data.worlds.new("world")
        scene.world.use_nodes = True
        nodes = scene.world.node_tree.nodes
        background = nodes["Background"]
        background.inputs["Color"].default_value = (0, 0, 0, 1)
    if light:
        picture = nodes.new("ShaderNodeTexEnvironment")
        picture.image = bpy.data.images.load(str(light))
        scene.world.node_tree.links.new(background.inputs["Color"], picture.outputs["Color"])
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = samples, False, False
    scene.cycles.sample_clamp_indirect, scene.cycles.blur_glossy = 0, 0
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = scene.cycles.transmission_bounces = 64
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH, HEIGHT, 100
    scene.view_settings.view_transform = "Standard"
    scene.render.filepath, scene.render.image_settings.file_format = str(out), "PNG"
    begun = time.monotonic()
    bpy.ops.render.render(write_still=True)
    return time.monotonic() - begun


def pixels(path):
    if not Path(path).exists():
        return numpy.zeros((HEIGHT, WIDTH, 4), numpy.float32) + numpy.array([1, 0, 1, 1], numpy.float32)
    picture = bpy.data.images.load(str(path))
    values = numpy.empty(picture.size[0] * picture.size[1] * 4, numpy.float32)
    picture.pixels.foreach_get(values)
    return values.reshape(picture.size[1], picture.size[0], 4)[:HEIGHT, :WIDTH]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--program", default="target/release/sundog")
    parser.add_argument("--usd", action="store_true")
    parser.add_argument("--only", nargs="*")
    parser.add_argument("--samples", type=int, default=24)
    options = parser.parse_args()
    hdr = options.scenes / "hdri-open" / "studio_small_05_1k.hdr"
    files = []
    folders = sorted(p for p in options.scenes.iterdir() if p.is_dir())
    for folder in folders if options.usd else []:
        found = sorted(folder.rglob("*.usd*")) if folder.name.startswith("usd") else []
        files += [(str(path.relative_to(options.scenes)), path) for path in found]
    if options.only and options.usd:
        files = [file for file in files if file[0] in options.only]
    for folder in [] if options.usd else folders:
        found = sorted(folder.glob("*.gltf")) or sorted(folder.glob("*.glb"))
        if found and (not options.only or folder.name in options.only):
            files.append((folder.name, found[0]))
    tiles, lines = [], []
    with tempfile.TemporaryDirectory() as scratch:
        for number, (name, path) in enumerate(files):
            told = described(options.program, path)
            ours, theirs = (Path(scratch) / f"{number}-{who}.png" for who in ("sundog", "cycles"))
            row, what = [], "Sundog refuses it"
            if told is not None:
                light = None if has_light(told) else hdr
                took, errors = with_sundog(options.program, path, ours, light, options.samples)
                what = errors.splitlines()[-1] if errors and not ours.exists() else ""
                row.append(f"{took:.1f}")
                try:
                    row.append(f"{imported(path):.1f}")
                    framed(told)
                    row.append(f"{with_cycles(theirs, light, options.samples):.1f}")
                except RuntimeError as error:
                    what = " ".join(str(error).split())[:120]
            both = [pixels(ours), pixels(theirs)]
            means = [f"{p[..., :3].mean():.3f}" for p in both]
            difference = numpy.abs(both[0] - both[1])[..., :3].mean()
            row += [""] * (3 - len(row))
            lines.append(f"| {number + 1} | {name} | {' | '.join(row)} | {means[0]} | {means[1]} | {difference:.3f} | {what} |")
            print(lines[-1], flush=True)
            tiles.append(numpy.concatenate(both, axis=1))
    while len(tiles) % COLUMNS:
        tiles.append(numpy.zeros_like(tiles[0]))
    rows = [numpy.concatenate(tiles[i:i + COLUMNS], axis=1) for i in range(0, len(tiles), COLUMNS)]
    # Blender's pictures begin at the lowest row.
    sheet = numpy.concatenate(rows[::-1], axis=0)
    picture = bpy.data.images.new("sheet", sheet.shape[1], sheet.shape[0])
    picture.pixels.foreach_set(numpy.ascontiguousarray(sheet).ravel())
    picture.filepath_raw, picture.file_format = str(options.out), "PNG"
    picture.save()
    head = "| | scene | Sundog, s | Blender's import, s | Cycles, s | Sundog's mean | Cycles' mean | mean difference | |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n"
    options.out.with_suffix(".md").write_text(head + "\n".join(lines) + "\n")


main()
