# SPDX-License-Identifier: MIT OR Apache-2.0
"""Measures memory and time to the first sample of Sundog and of Cycles on the same scenes, into docs/notes/effects.md.

    PYTHON_WITH_BPY scripts/preparation.py [SCENE...] [--folder FOLDER] [--sundog PROGRAM] [--repeats 3] [--write]

Each program runs in a process of its own, for a picture of 64 pixels across with one sample, on all processors:

memory      The most that the whole process has had resident (VmHWM). What Blender as a Python module has without any scene is
            told too, and what is left of Cycles' figure without it: Blender's own copy of the scene, and Cycles'. For Sundog
            nothing is taken off. "Cycles' own count" is what Cycles' log says that its scene and pictures take at most.
first       Seconds to the first sample. Whole processes: from the start of either, Blender as a Python module, which has no window and
sample      loads no preferences. With reading the file: Sundog from the start of its process as well, Cycles from the call that opens the
            .blend in a Blender that has been started. Without: what Sundog says that making the scene ready takes; Cycles from the call
            of the render operator. Cycles' first sample is the line "Sample 0" of its log.

The gallery's scenes, and two plain ones: `triangles`, a ball of 249 000 triangles without a texture, and `texels`, a sheet
with an image of 2048 x 2048 pixels of 8 bits. Of those, what they take beyond the same with next to nothing in it, for each
triangle and for each texel.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PAGE = os.path.join(ROOT, "docs", "notes", "effects.md")
BEGIN, END = "<!-- preparation: made by scripts/preparation.py -->", "<!-- end of preparation -->"
GALLERY = ["cornell", "three-objects", "window-room", "many-lights", "glass", "material-wall", "foliage"]
# Name, what is counted, how many of it, the same with next to nothing.
PLAIN = [("triangles", "triangle", 2 * 500 * 249, "few-triangles"), ("texels", "texel", 2048 * 2048, "few-texels")]
ACROSS = 64


def most_resident(process="self"):
    """Bytes: the most that a process has had resident; 0 if it has ended."""
    try:
        with open(f"/proc/{process}/status") as status:
            return next((int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM")), 0)
    except OSError:
        return 0


def make_plain(name, folder):
    """Builds one of the plain scenes; runs with bpy."""
    import bpy
    import numpy as np

    bpy.ops.wm.read_factory_settings(use_empty=True)
    material = bpy.data.materials.new("Grey")
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    if name.endswith("triangles"):
        segments = 500 if name == "triangles" else 8
        # A ball of n segments and r rings has 2 n (r - 1) triangles.
        bpy.ops.mesh.primitive_uv_sphere_add(segments=segments, ring_count=segments // 2)
        bpy.ops.object.shade_smooth()
        while bpy.context.object.data.uv_layers:
            bpy.context.object.data.uv_layers.remove(bpy.context.object.data.uv_layers[0])
    else:
        bpy.ops.mesh.primitive_plane_add(size=2.0)
        size = 2048 if name == "texels" else 4
        image = bpy.data.images.new("Noise", size, size)
        random = np.random.default_rng(1).integers(0, 256, (size // 4, size // 4, 4), dtype=np.uint8).repeat(4, 0).repeat(4, 1)
        random[..., 3] = 255
        image.pixels.foreach_set((random.astype(np.float32) / 255.0).ravel())
        image.filepath_raw = os.path.join(folder, f"{name}.png")
        image.file_format = "PNG"
        image.save()
        # As if it had been opened: Blender keeps 8 bits of a file.
        bpy.data.images.remove(image)
        node = material.node_tree.nodes.new("ShaderNodeTexImage")
        node.image = bpy.data.images.load(os.path.join(folder, f"{name}.png"))
        material.node_tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
    bpy.context.object.data.materials.append(material)
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    lamp.location = (2.0, -2.0, 4.0)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (0.0, 0.0, 5.0)
    for thing in (lamp, camera):
        bpy.context.collection.objects.link(thing)
    bpy.context.scene.camera = camera
    path = os.path.join(folder, name)
    bpy.ops.wm.save_as_mainfile(filepath=path + ".blend")
    bpy.ops.export_scene.gltf(filepath=path + ".glb", export_cameras=True, export_lights=True, export_texcoords=True)
    with open(path + ".json", "w") as file:
        json.dump({"scene": f"{name}.glb", "environment": None, "width": 64, "height": 64, "bounces": 8,
                   "filter": "blackman-harris"}, file)


def cycles_here(blend, folder, started):
    """Renders with Cycles in this process, started at a time, and prints what it took; without a .blend, what Blender takes alone."""
    import bpy

    begun = time.time()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    # What only the figure of memory needs does not count.
    emptying = time.time() - begun
    told = {"alone": most_resident()}
    if blend:
        sys.path.insert(0, os.path.join(ROOT, "scenes"))
        import render_cycles

        with open(os.path.splitext(blend)[0] + ".json") as file:
            settings = json.load(file)
        begun = time.perf_counter()
        with render_cycles.cycles_log():
            bpy.ops.wm.open_mainfile(filepath=blend)
        opening = time.perf_counter() - begun
        told["opened"] = most_resident()
        given = argparse.Namespace(width=ACROSS, height=height_of(settings), samples=1, threads=None, adaptive=None, defaults=True)
        render_cycles.set_up(settings, given)
        before = time.time() - started - emptying
        _, _, log = render_cycles.render(os.path.join(folder, "preparation-cycles.exr"), 0)
        told["peak"] = most_resident()
        told["prepare"], told["own"] = read_log(log)
        told["first"] = opening + told["prepare"]
        told["whole"] = before + told["prepare"]
    print(json.dumps(told), flush=True)


def read_log(log):
    """Seconds to the first sample and Cycles' own peak in bytes, by its log."""
    import re

    first, own = None, 0.0
    for line in log:
        peak = re.search(r"\| Mem:[\d.]+M, Peak:([\d.]+)M", line)
        if peak:
            own = max(own, float(peak[1]) * 2**20)
        begun = re.search(r"Time:(\d+):(\d+\.\d+) .*\| Sample 0/", line)
        if begun and first is None:
            first = int(begun[1]) * 60 + float(begun[2])
    return first, own


def height_of(settings):
    return max(1, round(ACROSS * settings["height"] / settings["width"]))


def last_line(command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} ended with {done.returncode}: {done.stderr.strip()[-2000:]}")
    return json.loads(done.stdout.strip().splitlines()[-1])


def sundog(program, folder, name):
    """Seconds to the first sample and the most resident bytes of a process of Sundog's."""
    with open(os.path.join(folder, f"{name}.json")) as file:
        settings = json.load(file)
    out = os.path.join(folder, "preparation-sundog.exr")
    command = [program, "render", os.path.join(folder, settings["scene"]), f"--output={out}", f"--width={ACROSS}",
               f"--height={height_of(settings)}", "--samples=1", f"--bounces={settings['bounces']}", "--json"]
    if settings["environment"]:
        command += [f"--environment={os.path.join(folder, settings['environment'])}",
                    f"--environment-strength={settings['environment_strength']}",
                    f"--environment-rotation={settings['environment_rotation']}"]
    begun, first, prepare, peak = time.perf_counter(), None, None, 0
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    for line in process.stdout:
        event = json.loads(line)
        if event.get("event") == "prepared":
            first, prepare = time.perf_counter() - begun, event["seconds"]
        # Not by getrusage: its maximum counts what this process had when it was forked.
        peak = max(peak, most_resident(process.pid))
    if process.wait() != 0 or first is None:
        sys.exit(f"{' '.join(command)} ended with {process.returncode}")
    return first, prepare, peak


def measured(given, name):
    """Medians of the figures of one scene; the programs take turns."""
    this = [sys.executable, os.path.abspath(__file__), "--folder", given.folder]
    runs = []
    for _ in range(given.repeats):
        first, prepare, peak = sundog(given.sundog, given.folder, name)
        told = last_line([*this, "--started", repr(time.time()), "--cycles", os.path.join(given.folder, f"{name}.blend")])
        runs.append({"first": first, "prepare": prepare, "peak": peak, "cycles_first": told["first"], "cycles_whole": told["whole"],
                     "cycles_prepare": told["prepare"], "cycles_peak": told["peak"],
                     "cycles_alone": told["alone"], "cycles_own": told["own"]})
    return {key: statistics.median(run[key] for run in runs) for key in runs[0]}


def table(given, figures):
    mega = lambda size: f"{size / 1e6:.1f}"
    lines = [
        f"{time.strftime('%Y-%m-%d %H:%M', time.gmtime())} UTC, Cycles of Blender {given.blender} on the CPU, {os.cpu_count()} processors, load "
        f"{os.getloadavg()[0]:.1f} at the end; medians of {given.repeats}, taken in turn. Megabytes are 10^6 bytes.",
        "",
        "| scene | Sundog, whole process (MB) | Blender with Cycles, whole process (MB) | of that beyond Blender without a scene (MB) | Cycles' own"
        " count (MB) | Sundog, first sample from the start of the process (s) | Blender with Cycles, the same (s) | Cycles in a Blender that"
        " has been started, with reading the file (s) | Sundog, without reading (s) | Cycles, the same (s) |",
        "| --- " * 10 + "|",
    ]
    for name, f in figures.items():
        lines.append(f"| {name} | {mega(f['peak'])} | {mega(f['cycles_peak'])} | {mega(f['cycles_peak'] - f['cycles_alone'])} | "
                     f"{mega(f['cycles_own'])} | {f['first']:.3f} | {f['cycles_whole']:.2f} | {f['cycles_first']:.3f} | {f['prepare']:.3f} | {f['cycles_prepare']:.2f} |")
    rows = [row for row in PLAIN if row[0] in figures and row[3] in figures]
    if rows:
        lines += ["", "| bytes for each | Sundog | Blender with Cycles | Cycles' own count |", "| --- | --- | --- | --- |"]
    for name, word, count, few in rows:
        each = lambda key: (figures[name][key] - figures[few][key]) / count
        lines.append(f"| {word} | {each('peak'):.1f} | {each('cycles_peak'):.1f} | {each('cycles_own'):.1f} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--folder", default=os.path.join(ROOT, "out", "preparation"), help="where the scenes are, or go")
    parser.add_argument("--sundog", default=os.path.join(ROOT, "target", "release", "sundog"))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--write", action="store_true", help="put the table into docs/notes/effects.md")
    parser.add_argument("--make", help=argparse.SUPPRESS)
    parser.add_argument("--cycles", help=argparse.SUPPRESS)
    parser.add_argument("--started", type=float, default=time.time(), help=argparse.SUPPRESS)
    given = parser.parse_args()
    given.folder = os.path.abspath(given.folder)
    os.makedirs(given.folder, exist_ok=True)
    if given.make:
        return make_plain(given.make, given.folder)
    if given.cycles is not None:
        return cycles_here(given.cycles, given.folder, given.started)

    import bpy

    given.blender = bpy.app.version_string
    plain = [name for row in PLAIN for name in (row[3], row[0])]
    names = given.scenes or GALLERY + plain
    there = lambda name: os.path.exists(os.path.join(given.folder, f"{name}.json"))
    for name in (name for name in names if not there(name)):
        how = [os.path.abspath(__file__), "--folder", given.folder, "--make", name] if name in plain else [
            os.path.join(ROOT, "scenes", "build.py"), name, given.folder]
        subprocess.run([sys.executable, *how], check=True, stdout=subprocess.DEVNULL)
    figures = {}
    for name in names:
        figures[name] = measured(given, name)
        print(name, json.dumps(figures[name]), flush=True)
    lines = table(given, figures)
    print("\n".join(lines))
    if given.write:
        with open(PAGE) as file:
            text = file.read()
        before, rest = text.split(BEGIN)
        with open(PAGE, "w") as file:
            file.write(before + BEGIN + "\n\n" + "\n".join(lines) + "\n\n" + END + rest.split(END)[1])


if __name__ == "__main__":
    main()
