# SPDX-License-Identifier: GPL-3.0-or-later
"""What the export tests share: an export from the render depsgraph, as F12 has it, and ways to read what it wrote."""

import contextlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import bpy
import numpy
import schema_check

PROJECT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(PROJECT, "blender_addon"))

from sundog import export  # noqa: E402
from sundog.export import graph  # noqa: E402

SCHEMA = schema_check.schema()


# Of tests that take too long for each change: scripts/test-long.sh runs them.
long = unittest.skipUnless(os.environ.get("SUNDOG_LONG_TESTS"), "long: `make test-long` runs it")


class Engine(bpy.types.RenderEngine):
    """Only exports: the one way to a depsgraph in render mode without a render of its own."""

    bl_idname = "SUNDOG_EXPORT_TEST"
    bl_label = "Export"

    # Set by `exported`: what to call with the depsgraph, and what came of it.
    task = layer = None
    # The engine that renders now.
    current = None
    result = error = None

    def render(self, depsgraph):
        """Called by Blender for each view layer."""
        if depsgraph.view_layer.name != Engine.layer:
            return
        Engine.current = self
        try:
            Engine.result = Engine.task(depsgraph)
        except BaseException as error:
            Engine.error = error


def in_render(task, layer=""):
    """What `task(depsgraph)` returns when called in a render of that view layer, or of the first one."""
    scene = bpy.context.scene
    bpy.utils.register_class(Engine)
    before = scene.render.engine, scene.render.use_compositing, scene.render.use_sequencer
    scene.render.engine = Engine.bl_idname
    scene.render.use_compositing = scene.render.use_sequencer = False
    Engine.task, Engine.layer = task, layer or scene.view_layers[0].name
    Engine.result = Engine.error = None
    try:
        with quiet():
            bpy.ops.render.render(scene=scene.name)
    finally:
        scene.render.engine, scene.render.use_compositing, scene.render.use_sequencer = before
        bpy.utils.unregister_class(Engine)
    if Engine.error is not None:
        raise Engine.error
    return Engine.result


@contextlib.contextmanager
def quiet():
    """Sends Blender's chatter on standard output to nowhere."""
    sys.stdout.flush()
    keep, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(keep, 1)
        os.close(keep)
        os.close(nowhere)


def program():
    """The sundog program: SUNDOG_PROGRAM, or what cargo built last."""
    given = os.environ.get("SUNDOG_PROGRAM")
    if given:
        return given
    built = [os.path.join(PROJECT, "target", profile, "sundog") for profile in ("release", "debug")]
    built = [path for path in built if os.path.isfile(path)]
    if not built:
        raise unittest.SkipTest("there is no sundog program: build it, or set SUNDOG_PROGRAM")
    return max(built, key=os.path.getmtime)


def info(path):
    """`sundog info --json` of a scene."""
    done = subprocess.run([program(), "info", path, "--json", "--allow-outside"], capture_output=True, text=True, check=False)
    if done.returncode:
        raise AssertionError(done.stderr)
    return json.loads(done.stdout)


def sun_and_grey_world(scene, angle=0.1):
    """A sun and a grey world, as surfaces beside Cycles are lit."""
    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy, sun.angle = 3, angle
    made = bpy.data.objects.new("sun", sun)
    made.rotation_euler = (0.5, 0.7, 0)
    scene.collection.objects.link(made)
    even_world(scene, 0.3)


def even_world(scene, grey):
    """A world of one grey."""
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    background = next(n for n in scene.world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (grey, grey, grey, 1)


def rendered(path, width, height, samples, *more):
    """The program's picture of a scene, as `cycles_pixels` gives Cycles': with the bounces that the scene asks Cycles for."""
    picture = path + ".exr"
    cycles = bpy.context.scene.cycles
    bounces = {
        "": cycles.max_bounces, "-diffuse": cycles.diffuse_bounces, "-glossy": cycles.glossy_bounces,
        "-transmission": cycles.transmission_bounces, "-volume": cycles.volume_bounces,
        "-transparent": cycles.transparent_max_bounces,
    }  # fmt: skip
    command = [program(), "render", path, "-o", picture, "--width", str(width), "--height", str(height), "--quiet", "--allow-outside"]
    command += ["--samples", str(samples), "--filter", "box", "--exr-layers", "combined", *more]
    command += [word for kind, most in bounces.items() for word in (f"--bounces{kind}", str(most))]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise AssertionError(done.stderr)
    return exr_pixels(picture)


class Exported:
    """A written scene, read back."""

    def __init__(self, result):
        self.result, self.path = result, result.path
        with open(result.path, encoding="utf-8") as file:
            self.root = json.load(file)

    def __getitem__(self, table):
        return self.root.get(table, [])

    def array(self, index):
        """An accessor's numbers."""
        accessor = self.root["accessors"][index]
        view = self.root["bufferViews"][accessor["bufferView"]]
        buffer = os.path.join(os.path.dirname(self.path), self.root["buffers"][view["buffer"]]["uri"])
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        dtype = {5126: numpy.float32, 5125: numpy.uint32}[accessor["componentType"]]
        count = accessor["count"] * width
        values = numpy.fromfile(buffer, dtype, count, offset=view["byteOffset"] + accessor.get("byteOffset", 0))
        return values if width == 1 else values.reshape(-1, width)

    def nodes(self, name):
        """All nodes of that name."""
        return [node for node in self["nodes"] if node.get("name") == name]

    def node(self, name):
        """The one node of that name."""
        found = self.nodes(name)
        assert len(found) == 1, f"{len(found)} nodes are called {name}: {[n.get('name') for n in self['nodes']]}"
        return found[0]

    def names(self):
        """Names of all nodes with a mesh."""
        return sorted(node["name"] for node in self["nodes"] if "mesh" in node)

    def matrix(self, node):
        """A node's matrix (4 × 4)."""
        return numpy.array(node["matrix"]).reshape(4, 4).T

    def triangles(self, node):
        """Corners of the triangles of a node's mesh in Blender's axes: triangles × 3 × 3."""
        parts = []
        for primitive in self.root["meshes"][node["mesh"]]["primitives"]:
            points = self.array(primitive["attributes"]["POSITION"]).astype(float)
            parts.append(points[self.array(primitive["indices"])].reshape(-1, 3, 3))
        turned = numpy.concatenate(parts) @ self.matrix(node)[:3, :3].T + self.matrix(node)[:3, 3]
        return numpy.stack([turned[..., 0], -turned[..., 2], turned[..., 1]], axis=-1)

    def material(self, name):
        """The material of that name."""
        return next(m for m in self["materials"] if m["name"] == name)

    def light(self, name):
        """The SUNDOG_light of the light object of that name."""
        extensions = self.node(name)["extensions"]
        if "SUNDOG_light" in extensions:
            return extensions["SUNDOG_light"]
        index = extensions["KHR_lights_punctual"]["light"]
        return self.root["extensions"]["KHR_lights_punctual"]["lights"][index]["extensions"]["SUNDOG_light"]

    def scene(self):
        """The SUNDOG_scene."""
        return self.root["scenes"][0]["extensions"]["SUNDOG_scene"]

    def verdict(self, kind, name):
        """The verdict's dictionary of one thing."""
        return next(v for v in self.result.verdicts if (v["kind"], v["name"]) == (kind, name))

    def info(self):
        """What the program reads of it."""
        return info(self.path)


class ExportTest(unittest.TestCase):
    """A test with an empty file, a camera, and a folder of its own."""

    def setUp(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.folder = tempfile.mkdtemp(prefix="sundog-export-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.scene = bpy.context.scene
        camera = bpy.data.cameras.new("camera")
        self.camera = bpy.data.objects.new("camera", camera)
        self.camera.location = (0, 0, 10)
        self.scene.collection.objects.link(self.camera)
        self.scene.camera = self.camera

    def write_graphs(self, on):
        """Whether node trees are written as they are, for this test; without them the flattened materials' verdicts count."""
        before, graph.ENABLED = graph.ENABLED, on
        self.addCleanup(setattr, graph, "ENABLED", before)

    def export(self, layer=""):
        """Exports in a render."""
        def task(depsgraph):
            cache = os.path.join(self.folder, "cache")
            scene = os.path.join(self.folder, "scene")
            return export.write_scene(depsgraph, depsgraph.scene, scene, cache, move=Engine.current.frame_set)

        found = Exported(in_render(task, layer))
        self.assertEqual(list(schema_check.errors(found.root, SCHEMA)), [])
        return found

    def link(self, name, data, **settings):
        """A new object of that name in the scene."""
        made = bpy.data.objects.new(name, data)
        for key, value in settings.items():
            setattr(made, key, value)
        self.scene.collection.objects.link(made)
        return made

    def near(self, got, expected, tolerance=1e-6, message=None):
        """Equal to a relative tolerance (of the largest expected value)."""
        got, expected = numpy.asarray(got, float), numpy.asarray(expected, float)
        self.assertEqual(got.shape, expected.shape, message)
        scale = max(float(numpy.abs(expected).max(initial=0)), 1e-30)
        worst = float(numpy.abs(got - expected).max(initial=0))
        self.assertLessEqual(worst, tolerance * scale, message or f"{got} is not {expected}")


def plane(name="plane", size=2.0):
    """A square mesh in the XY plane with one UV map."""
    half = size / 2
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], [], [(0, 1, 2, 3)])
    uv = mesh.uv_layers.new(name="UVMap")
    for corner, value in zip(uv.data, [(0, 0), (1, 0), (1, 1), (0, 1)]):
        corner.uv = value
    return mesh


def cube(name="cube", size=2.0):
    """A cube about the origin, without UV map."""
    h = size / 2
    corners = [(x, y, z) for z in (-h, h) for y in (-h, h) for x in (-h, h)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], faces)
    return mesh


def material(name, **inputs):
    """A material with one Principled BSDF; inputs by name with _ for blanks."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    principled = next(n for n in made.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    for key, value in inputs.items():
        principled.inputs[key.replace("_", " ")].default_value = value
    return made


def stretches(thing, factor, keys):
    """Gives an object a shape that is longer along Z, by so much of it at each frame."""
    thing.shape_key_add(name="Basis")
    shape = thing.shape_key_add(name="long")
    for point in shape.data:
        point.co.z *= factor
    for frame, value in keys:
        shape.value = value
        shape.keyframe_insert("value", frame=frame)


def curves_of(action):
    """The animation curves of an action, whatever the version keeps them in."""
    if hasattr(action, "fcurves"):
        return list(action.fcurves)
    return [curve for layer in action.layers for strip in layer.strips for bag in strip.channelbags for curve in bag.fcurves]


def for_cycles(width=8, height=8, samples=4, exact=True):
    """Asks for a picture by Cycles: sets the scene's render settings."""
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    cycles.device = "CPU"
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = samples, False, False
    if exact:
        cycles.pixel_filter_type = "BOX"
    image = render.image_settings
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"


def unbiased(cycles):
    """Takes from Cycles' settings what changes the mean of its pictures."""
    cycles.blur_glossy = cycles.sample_clamp_indirect = cycles.light_sampling_threshold = 0


def cycles_pixels(width=8, height=8, samples=4, exact=True):
    """What Cycles shows of the scene, as height × width × 3 linear floats with the bottom row first."""
    for_cycles(width, height, samples, exact)
    render = bpy.context.scene.render
    folder = tempfile.mkdtemp(prefix="sundog-cycles-")
    render.filepath = os.path.join(folder, "picture.exr")
    try:
        with quiet():
            bpy.ops.render.render(write_still=True)
        return exr_pixels(render.filepath)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def exr_pixels(path):
    """An EXR's linear floats, height × width × 3, with the bottom row first."""
    image = bpy.data.images.load(path)
    try:
        image.colorspace_settings.name = "Non-Color"
        values = numpy.empty(image.size[0] * image.size[1] * image.channels, numpy.float32)
        image.pixels.foreach_get(values)
        return values.reshape(image.size[1], image.size[0], -1)[..., :3]
    finally:
        bpy.data.images.remove(image)
