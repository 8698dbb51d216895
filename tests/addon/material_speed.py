# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sample of a material takes in Sundog and in Cycles, nanoseconds of one processor.

    SUNDOG_PROGRAM=PROGRAM PYTHON_WITH_BPY tests/addon/material_speed.py [NAME ...]

A plane with the material fills the picture. What one sample takes is taken off, so that starting and loading do not count.
Without names: all of them. Prints a table in Markdown; the columns with + are what the nodes add to a plane that only shines.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)
sys.path.insert(0, os.path.join(HERE, "..", "..", "blender_addon"))

import bpy  # noqa: E402
import export_kit as kit  # noqa: E402
import numpy  # noqa: E402
from sundog import export  # noqa: E402

SIZE, SAMPLES, TRIES = 128, 257, 3


class Tree:
    """The nodes of the material, added one by one."""

    def __init__(self, tree, folder):
        self.tree, self.folder = tree, folder
        tree.nodes.clear()

    def add(self, kind, *links, **sockets):
        """A node with links (socket, output of another node), and values of sockets by name."""
        node = self.tree.nodes.new("ShaderNode" + kind)
        for socket, output in links:
            self.tree.links.new(output, node.inputs[socket])
        for name, value in sockets.items():
            node.inputs[name.replace("_", " ")].default_value = value
        return node

    def chain(self, kind, socket, value, count=8, output=0, **settings):
        """Nodes of a kind, each of which takes what the one before gives."""
        for _ in range(count):
            node = self.add(kind)
            for name, setting in settings.items():
                setattr(node, name, setting)
            self.tree.links.new(value, node.inputs[socket])
            value = node.outputs[output]
        return value

    def image(self, name, colorspace):
        """An image texture of its own."""
        size = 1024
        texels = numpy.random.default_rng(len(name)).random((size, size, 4), dtype="f4")
        texels[..., 3] = 1.0
        if name == "normal":
            texels[..., :2] = 0.45 + 0.1 * texels[..., :2]
            texels[..., 2] = 1.0
        made = bpy.data.images.new(name, size, size)
        made.colorspace_settings.name = colorspace
        made.pixels.foreach_set(texels.ravel())
        made.filepath_raw, made.file_format = os.path.join(self.folder, name + ".png"), "PNG"
        made.save()
        node = self.add("TexImage")
        node.image = bpy.data.images.load(made.filepath_raw)
        node.image.colorspace_settings.name = colorspace
        return node.outputs[0]

    def mix(self, a, b, factor):
        """A blend of two colours."""
        node = self.add("Mix")
        node.data_type = "RGBA"
        for socket, output in (("Factor_Float", factor), ("A_Color", a), ("B_Color", b)):
            found = next(i for i in node.inputs if i.identifier == socket)
            self.tree.links.new(output, found)
        return next(o for o in node.outputs if o.identifier == "Result_Color")


def plain(tree, vector):
    """A Principled BSDF with nothing linked."""
    return tree.add("BsdfPrincipled").outputs[0]


def images(tree, vector):
    """A Principled BSDF with five images."""
    normal = tree.add("NormalMap", ("Color", tree.image("normal", "Non-Color"))).outputs[0]
    links = [("Base Color", tree.image("color", "sRGB")), ("Normal", normal)]
    for socket in ("Roughness", "Metallic", "Specular IOR Level"):
        links.append((socket, tree.image(socket.split()[0].lower(), "Non-Color")))
    return tree.add("BsdfPrincipled", *links).outputs[0]


def procedural(tree, vector):
    """A Principled BSDF with twenty nodes, most of them procedural textures."""
    at = ("Vector", tree.add("Mapping", (0, vector)).outputs[0])
    clouds = tree.add("TexNoise", at, Detail=6.0)
    grain = tree.add("TexNoise", at, Scale=20.0)
    bent = tree.add("TexNoise", at, Detail=4.0, Distortion=1.0)
    cells, small = tree.add("TexVoronoi", at), tree.add("TexVoronoi", at, Scale=12.0)
    wave, magic = tree.add("TexWave", at), tree.add("TexMagic", at)
    ramps = [tree.add("ValToRGB", (0, texture.outputs[0])).outputs[0] for texture in (clouds, cells, wave)]
    color = tree.mix(ramps[0], ramps[1], grain.outputs[0])
    color = tree.mix(color, magic.outputs[0], small.outputs[0])
    color = tree.mix(color, ramps[2], bent.outputs[0])
    color = tree.add("HueSaturation", ("Color", color)).outputs[0]
    power = tree.add("Math", (0, small.outputs[0]))
    power.operation = "POWER"
    return tree.add(
        "BsdfPrincipled",
        ("Base Color", color),
        ("Roughness", tree.add("MapRange", (0, grain.outputs[0])).outputs[0]),
        ("Metallic", power.outputs[0]),
        ("Normal", tree.add("Bump", ("Height", bent.outputs[0])).outputs[0]),
    ).outputs[0]


def texture(kind, **sockets):
    """A texture that shines."""
    return lambda tree, vector: tree.add("Tex" + kind, ("Vector", vector), **sockets).outputs[0]


def chain(kind, socket=0, **settings):
    """Eight nodes of a kind, the last of which shines."""
    return lambda tree, vector: tree.chain(kind, socket, vector, **settings)


def bump(tree, vector):
    """A Bump over a noise, whose normal shines."""
    height = texture("Noise")(tree, vector)
    return tree.add("Bump", ("Height", height)).outputs[0]


SURFACES = {"plain": plain, "images": images, "procedural": procedural}
NODES = {
    "coordinates": lambda tree, vector: vector,
    "Noise": texture("Noise"),
    "Noise, detail 6": texture("Noise", Detail=6.0),
    "Noise, distorted": texture("Noise", Detail=4.0, Distortion=1.0),
    "Voronoi": texture("Voronoi"),
    "Wave": texture("Wave"),
    "Magic": texture("Magic"),
    "Brick": texture("Brick"),
    "8 Color Ramp": chain("ValToRGB"),
    "8 Hue/Saturation": chain("HueSaturation", "Color"),
    "8 Map Range": chain("MapRange"),
    "8 RGB Curves": chain("RGBCurve", 1),
    "8 Math, Add": chain("Math", operation="ADD"),
    "8 Math, Power": chain("Math", operation="POWER"),
    "8 Mapping": chain("Mapping"),
    "Bump over Noise": bump,
}


def build(make, shines, folder):
    """A plane that fills the picture, under a sun unless it shines."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    bpy.ops.mesh.primitive_plane_add(size=4)
    plane = bpy.context.object
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.data.type, camera.data.ortho_scale = (0, 0, 3), "ORTHO", 3.5
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("world")
    if not shines:
        sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
        sun.rotation_euler, sun.data.angle = (0.5, 0.3, 0), 0.1
        scene.collection.objects.link(sun)
    material = bpy.data.materials.new("material")
    material.use_nodes = True
    material.cycles.emission_sampling = "NONE"
    plane.data.materials.append(material)
    tree = Tree(material.node_tree, folder)
    output = tree.add("OutputMaterial")
    made = make(tree, tree.add("TexCoord").outputs["Object"])
    if shines:
        made = tree.add("Emission", (0, made)).outputs[0]
    material.node_tree.links.new(made, output.inputs[0])
    scene.cycles.max_bounces = 0
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.render.threads_mode, scene.render.threads = "FIXED", 1


def cycles(samples):
    """Processor seconds of a render by Cycles."""
    start = time.process_time()
    kit.cycles_pixels(SIZE, SIZE, samples)
    return time.process_time() - start


def sundog(path, folder, samples):
    """Processor seconds of a render by Sundog."""
    command = [os.environ["SUNDOG_PROGRAM"], "render", path, "-o", os.path.join(folder, "picture.exr"), "--quiet"]
    command += ["--width", str(SIZE), "--height", str(SIZE), "--threads", "1", "--samples", str(samples)]
    command += ["--filter", "box", "--bounces", "0", "--exr-layers", "combined", "--allow-outside"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measured(make, shines):
    """Nanoseconds a sample of Cycles and Sundog: the least of some tries, as others can only make it longer."""
    with tempfile.TemporaryDirectory() as folder:
        build(make, shines, folder)
        path = kit.in_render(lambda graph: export.write_scene(graph, graph.scene, folder, folder + "/cache")).path
        cycles(1)
        engines = (cycles, lambda samples: sundog(path, folder, samples))
        times = [min(run(SAMPLES) for _ in range(TRIES)) - min(run(1) for _ in range(TRIES)) for run in engines]
    return [1e9 * seconds / ((SAMPLES - 1) * SIZE * SIZE) for seconds in times]


def main():
    """The tables."""
    names = sys.argv[1:] or [*SURFACES, *NODES]
    unknown = [name for name in names if name not in {**SURFACES, **NODES}]
    if unknown:
        sys.exit(f"no material is called {unknown[0]}; there are {', '.join([*SURFACES, *NODES])}.")
    print("| material | Cycles, ns | Sundog, ns | Sundog / Cycles |\n| --- | --- | --- | --- |")
    for name in [name for name in names if name in SURFACES]:
        of_cycles, ours = measured(SURFACES[name], False)
        print(f"| {name} | {of_cycles:.0f} | {ours:.0f} | {ours / of_cycles:.2f} |", flush=True)
    nodes = [name for name in names if name in NODES]
    if not nodes:
        return
    print("\n| node | Cycles, + ns | Sundog, + ns |\n| --- | --- | --- |")
    without = measured(NODES["coordinates"], True)
    for name in nodes:
        times = without if name == "coordinates" else measured(NODES[name], True)
        added = [time - base for time, base in zip(times, without)]
        print(f"| {name} | {added[0]:.0f} | {added[1]:.0f} |", flush=True)


if __name__ == "__main__":
    main()
