# SPDX-License-Identifier: GPL-3.0-or-later
"""How long an export of a million triangles takes, beside Cycles' own synchronisation of the same scene.

    PYTHON_WITH_BPY tests/addon/measure_export.py [TRIANGLES] [REPEATS]

Prints the table of docs/notes/benchmarks.md. Cycles' time is that of its session (synchronisation, preparation, and one sample of
16 × 16 pixels) without Blender's own work around it; Sundog's is the export, and the program from its start to its first
sample.
"""

import json
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bpy
import export_kit as kit
import numpy

MATERIALS = 50


def materials():
    """Fifty different ones."""
    return [kit.material(f"material {i}", Base_Color=(i / MATERIALS, 0.5, 0.2, 1), Roughness=i / MATERIALS) for i in range(MATERIALS)]


def grid(name, triangles, smooth=True):
    """A waving sheet of about that many triangles, as quads, with a UV map."""
    side = max(int((triangles / 2) ** 0.5), 1)
    x, y = numpy.meshgrid(numpy.linspace(-1, 1, side + 1), numpy.linspace(-1, 1, side + 1), indexing="ij")
    points = numpy.stack([x, y, 0.1 * numpy.sin(9 * x) * numpy.cos(7 * y)], axis=-1).reshape(-1, 3).astype(numpy.float32)
    first = (numpy.arange(side)[:, None] * (side + 1) + numpy.arange(side)).reshape(-1)
    corners = numpy.stack([first, first + side + 1, first + side + 2, first + 1], axis=1).astype(numpy.int32)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.reshape(-1))
    mesh.loops.add(corners.size)
    mesh.loops.foreach_set("vertex_index", corners.reshape(-1))
    mesh.polygons.add(len(corners))
    mesh.polygons.foreach_set("loop_start", numpy.arange(0, corners.size, 4, dtype=numpy.int32))
    mesh.update(calc_edges=True)
    mesh.uv_layers.new(name="UVMap").uv.foreach_set("vector", (points[corners.reshape(-1), :2] * 0.5 + 0.5).reshape(-1))
    if smooth:
        mesh.shade_smooth()
    return mesh


def put(name, mesh, x=0.0, y=0.0):
    made = bpy.data.objects.new(name, mesh)
    made.location = (x, y, 0)
    bpy.context.scene.collection.objects.link(made)


def one_big(triangles):
    """One object, whose faces have fifty materials."""
    mesh = grid("big", triangles)
    for made in materials():
        mesh.materials.append(made)
    mesh.polygons.foreach_set("material_index", (numpy.arange(len(mesh.polygons)) * MATERIALS // len(mesh.polygons)).astype(numpy.int32))
    put("big", mesh)


def many_objects(triangles, count=1000):
    """A thousand objects, each with a mesh of its own and one of fifty materials."""
    made = materials()
    for number in range(count):
        mesh = grid(f"sheet {number}", triangles / count)
        # No two alike.
        mesh.vertices[0].co.z = number
        mesh.materials.append(made[number % MATERIALS])
        put(f"sheet {number}", mesh, number % 32 * 2.0, number // 32 * 2.0)


def textured(triangles):
    """One object with an image texture: vertices by corner, because of the UV map."""
    mesh = grid("textured", triangles)
    made = kit.material("textured")
    tree = made.node_tree
    image = tree.nodes.new("ShaderNodeTexImage")
    image.image = bpy.data.images.new("image", 64, 64)
    tree.links.new(image.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    mesh.materials.append(made)
    put("textured", mesh)


def start(make, triangles):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location.z = 60
    scene.collection.objects.link(camera)
    scene.camera = camera
    make(triangles)
    scene.render.resolution_x = scene.render.resolution_y = 16


def export_seconds(folder):
    """(seconds of write_scene in a render, its result)."""
    def task(depsgraph):
        begun = time.perf_counter()
        result = kit.export.write_scene(depsgraph, depsgraph.scene, os.path.join(folder, "scene"), os.path.join(folder, "cache"))
        return time.perf_counter() - begun, result

    return kit.in_render(task)


def preparing_seconds(path):
    """Seconds of the program from its start to the first sample."""
    command = [kit.program(), "render", path, "--json", "--samples", "1", "--width", "16", "--height", "16", "-o", path + ".png", "--allow-outside"]
    begun = time.perf_counter()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            if json.loads(line)["event"] == "prepared":
                prepared = time.perf_counter() - begun
    return prepared


# In a Blender of its own: what Cycles' session takes, call by call.
CYCLES = """
import sys, time
import bpy
import _cycles
bpy.ops.wm.open_mainfile(filepath=sys.argv[1])
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.cycles.device, scene.cycles.samples = "CPU", 1
scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False

def timed(call):
    def measured(*arguments):
        begun = time.perf_counter()
        result = call(*arguments)
        print("CYCLES", time.perf_counter() - begun, file=sys.stderr)
        return result
    return measured

for name in ("create", "reset", "render"):
    setattr(_cycles, name, timed(getattr(_cycles, name)))
bpy.ops.render.render()
"""


def cycles_seconds():
    """Seconds of Cycles' session for the open scene."""
    folder = tempfile.mkdtemp(prefix="sundog-measure-")
    try:
        path = os.path.join(folder, "scene.blend")
        with kit.quiet():
            bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
        done = subprocess.run([sys.executable, "-c", CYCLES, path], capture_output=True, text=True, check=False)
        calls = [float(value) for value in re.findall(r"CYCLES ([\d.e+-]+)", done.stderr)]
        if len(calls) != 3:
            raise SystemExit(done.stderr)
        return sum(calls)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def main():
    triangles = int(float(sys.argv[1])) if len(sys.argv) > 1 else 1_000_000
    repeats = int(sys.argv[2]) if len(sys.argv) > 2 else 3
    print(f"Blender {bpy.app.version_string}, {triangles} triangles, medians of {repeats}, seconds")
    print("| scene | Cycles to its first sample | export | program to its first sample | second export, camera moved | meshes written again |")
    print("| --- | --- | --- | --- | --- | --- |")
    for make in (one_big, many_objects, textured):
        start(make, triangles)
        firsts, seconds, prepared = [], [], []
        for _ in range(repeats):
            folder = tempfile.mkdtemp(prefix="sundog-measure-")
            try:
                first, result = export_seconds(folder)
                firsts.append(first)
                prepared.append(preparing_seconds(result.path))
                bpy.context.scene.camera.location.x += 1
                second, again = export_seconds(folder)
                seconds.append(second)
            finally:
                shutil.rmtree(folder, ignore_errors=True)
        cycles = [cycles_seconds() for _ in range(repeats)]
        row = [statistics.median(cycles), statistics.median(firsts), statistics.median(prepared), statistics.median(seconds)]
        print(f"| {make.__name__.replace('_', ' ')} | " + " | ".join(f"{v:.2f}" for v in row) + f" | {again.changed_geometry} |", flush=True)


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)
