# SPDX-License-Identifier: MIT OR Apache-2.0
"""Values of Blender's procedural texture nodes as Cycles computes them, for tests/unit/nodes/mod.rs.

    PYTHON_WITH_BPY tests/python/texture_values.py FOLDER [--nodes Noise,Wave] [--points 1024]

Writes FOLDER/points.json, and FOLDER/NODE.json: for each variant of the node its settings, the numbers in its sockets, and
Cycles' outputs at some of the points. tests/nodes has the files of bpy 5.2.3: 128 points, of which a variant takes 32;
and, named so, those of bpy 4.5.15 where they differ.
With 1024 points every variant takes all of them.

A sheet of squares carries the points as attributes of its faces, so that the coordinates are known to the bit. Shader AOVs
take the outputs to a file of 32-bit floats, with one sample for each pixel; the middle pixel of each face is read.
"""

import argparse
import json
import os
import random
import sys

import bpy
import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(HERE), "addon"))

import exr  # noqa: E402

COLUMNS = 32
PIXELS = 3
AOVS = 24
TAKEN = 32
DIMENSIONS = ("1D", "2D", "3D", "4D")


def float32(number):
    """The decimal number of fewest digits that is this 32-bit float."""
    return float(str(numpy.float32(number)))


def points(count):
    """Coordinates of many sizes, whole numbers among them; each 16 in a row have every kind."""
    dice = random.Random(19)

    def coordinate(kind, axis):
        if kind < 6:
            return dice.uniform(-3, 3)
        if kind < 9:
            return dice.uniform(0, 1)
        if kind < 11:
            return dice.uniform(-100, 100)
        if kind == 11 or (kind == 12 and axis % 2 == 0):
            return dice.randint(-3, 3)
        if kind == 13:
            return dice.choice((-1, 1)) * 10 ** dice.uniform(2, 4)
        if kind == 14:
            return dice.choice((-1, 1)) * 10 ** dice.uniform(4, 7)
        return dice.uniform(-1, 1) * 10 ** dice.uniform(-6, 0)

    return [[float32(coordinate(index % 16, axis)) for axis in range(4)] for index in range(count)]


def noise():
    for number, dimensions in enumerate(DIMENSIONS):
        for noise_type in ("FBM", "MULTIFRACTAL", "HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HETERO_TERRAIN"):
            settings = {"noise_dimensions": dimensions, "noise_type": noise_type}
            yield settings, {"Scale": 1.0, "Detail": 0.0, "Offset": 1.0}
            yield settings, {"Detail": 2.7, "Roughness": 0.6, "Lacunarity": 2.3, "Offset": 0.7, "Gain": 1.4}
            if noise_type == "FBM":
                settings = {**settings, "normalize": False}
                yield settings, {"Detail": 15.0, "Scale": 2.5, "Roughness": 0.45}
            if (number + len(noise_type)) % 2:
                yield settings, {"Detail": 3.0, "Distortion": 1.3, "Offset": 0.3, "Gain": 2.0}


def voronoi():
    metrics = ("EUCLIDEAN", "MANHATTAN", "CHEBYCHEV", "MINKOWSKI")
    for number, dimensions in enumerate(DIMENSIONS):
        for feature in ("F1", "F2", "SMOOTH_F1"):
            for metric in metrics if dimensions != "1D" else metrics[:1]:
                settings = {"voronoi_dimensions": dimensions, "feature": feature, "distance": metric}
                yield settings, {"Scale": 3.0, "Randomness": 0.9, "Smoothness": 0.7, "Exponent": 1.5}
            settings = {"voronoi_dimensions": dimensions, "feature": feature, "normalize": True}
            settings["distance"] = metrics[number]
            yield settings, {"Detail": 2.6, "Roughness": 0.7, "Lacunarity": 2.2, "Smoothness": 1.0, "Exponent": 3.0}
            # Of points on a lattice many are equally near, and the order of the cells decides.
            settings = {"voronoi_dimensions": dimensions, "feature": feature, "distance": metrics[-1 - number]}
            yield settings, {"Scale": 1.0, "Randomness": 0.0, "Smoothness": 0.0, "Exponent": 0.5}
        for normalize in (False, True):
            settings = {"voronoi_dimensions": dimensions, "feature": "DISTANCE_TO_EDGE", "normalize": normalize}
            yield settings, {"Scale": 2.0, "Detail": 1.6 if normalize else 0.0, "Randomness": 0.8}
        yield {"voronoi_dimensions": dimensions, "feature": "N_SPHERE_RADIUS"}, {"Scale": 2.0}


def wave():
    for kind, menu in (("BANDS", "bands_direction"), ("RINGS", "rings_direction")):
        for direction in ("X", "Y", "Z", "DIAGONAL" if kind == "BANDS" else "SPHERICAL"):
            for profile in ("SIN", "SAW", "TRI"):
                settings = {"wave_type": kind, menu: direction, "wave_profile": profile}
                yield settings, {"Scale": 1.0, "Phase Offset": 0.4}
        settings = {"wave_type": kind}
        yield settings, {"Distortion": 2.5, "Detail": 3.4, "Detail Scale": 1.7, "Detail Roughness": 0.6}


def magic():
    for depth in range(11):
        # Each turn makes more of the rounding of the sines before it, by as much as the distortion is above 1.
        yield {"turbulence_depth": depth}, {"Scale": 1.3, "Distortion": min(0.4 + 0.2 * depth, 1.2)}
    yield {"turbulence_depth": 0}, {"Distortion": 0.0}


def brick():
    colors = {"Color1": (0.9, 0.2, 0.1), "Color2": (0.3, 0.5, 0.8), "Mortar": (0.1, 0.2, 0.3)}
    yield {}, {}
    yield {}, {**colors, "Scale": 1.7, "Mortar Size": 0.05, "Mortar Smooth": 0.0}
    yield {"offset": 0.3, "offset_frequency": 3}, {**colors, "Mortar Size": 0.1, "Mortar Smooth": 1.0, "Bias": -0.3}
    yield {"squash": 1.6, "squash_frequency": 3}, {**colors, "Bias": 0.4, "Brick Width": 0.8, "Row Height": 0.4}
    yield {"offset": 0.7, "squash": 0.5, "offset_frequency": 1}, {**colors, "Scale": 2.0, "Mortar Size": 0.03}


def checker():
    colors = {"Color1": (0.9, 0.2, 0.1), "Color2": (0.3, 0.5, 0.8)}
    yield {}, colors
    yield {}, {**colors, "Scale": 1.0}
    yield {}, {**colors, "Scale": 13.7}


def gradient():
    for kind in ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL"):
        yield {"gradient_type": kind}, {}


def white_noise():
    for dimensions in DIMENSIONS:
        yield {"noise_dimensions": dimensions}, {}


def gabor():
    for anisotropy in (1.0, 0.4, 0.0):
        yield {"gabor_type": "2D"}, {"Scale": 2.0, "Anisotropy": anisotropy, "Orientation 2D": 0.6}
        sockets = {"Scale": 2.0, "Anisotropy": anisotropy, "Orientation 3D": (0.3, -0.5, 0.8)}
        yield {"gabor_type": "3D"}, {**sockets, "Frequency": 1.4}
    yield {"gabor_type": "2D"}, {}
    yield {"gabor_type": "3D"}, {}


NODES = {
    "Noise": noise,
    "Voronoi": voronoi,
    "Wave": wave,
    "Magic": magic,
    "Brick": brick,
    "Checker": checker,
    "Gradient": gradient,
    "WhiteNoise": white_noise,
    "Gabor": gabor,
}


def sheet(coordinates):
    """A mesh of squares below an orthographic camera, and the scene's settings."""
    scene = bpy.context.scene
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    rows = -(-len(coordinates) // COLUMNS)
    corners, faces = [], []
    for index in range(len(coordinates)):
        x, y = index % COLUMNS, -(index // COLUMNS)
        faces.append([len(corners) + corner for corner in range(4)])
        corners += [(x, y - 1, 0), (x + 1, y - 1, 0), (x + 1, y, 0), (x, y, 0)]
    mesh = bpy.data.meshes.new("sheet")
    mesh.from_pydata(corners, [], faces)
    flat = [number for point in coordinates for number in point[:3]]
    mesh.attributes.new("place", "FLOAT_VECTOR", "FACE").data.foreach_set("vector", flat)
    # A vector, too: through the attribute's factor numbers come rounded.
    flat = [number for point in coordinates for number in (point[3], 0.0, 0.0)]
    mesh.attributes.new("fourth", "FLOAT_VECTOR", "FACE").data.foreach_set("vector", flat)
    shown = bpy.data.objects.new("sheet", mesh)
    scene.collection.objects.link(shown)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = max(COLUMNS, rows)
    camera.location = (COLUMNS / 2, -rows / 2, 1)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = COLUMNS * PIXELS, rows * PIXELS
    scene.render.resolution_percentage = 100
    scene.cycles.samples = 1
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "MULTI_LAYER_IMAGE"
    image.file_format, image.color_depth, image.exr_codec = "OPEN_EXR_MULTILAYER", "32", "NONE"
    if hasattr(image, "use_exr_interleave"):
        image.use_exr_interleave = True
    return shown


def material(variants):
    """A material with a node for each variant, and an AOV for each of its outputs: (variant, output, AOV)."""
    layer = bpy.context.view_layer
    while layer.aovs:
        layer.aovs.remove(layer.aovs[0])
    made = bpy.data.materials.new("textures")
    if not made.node_tree:
        made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    emission = tree.nodes.new("ShaderNodeEmission")
    surface = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(emission.outputs[0], surface.inputs[0])
    place, fourth = tree.nodes.new("ShaderNodeAttribute"), tree.nodes.new("ShaderNodeAttribute")
    place.attribute_name, fourth.attribute_name = "place", "fourth"
    separate = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(fourth.outputs["Vector"], separate.inputs[0])
    aovs = []
    for variant in variants:
        node = tree.nodes.new("ShaderNodeTex" + variant["node"])
        for name, choice in variant["settings"].items():
            setattr(node, name, choice)
        by_identifier = {socket.identifier: socket for socket in node.inputs}
        for name, number in variant["inputs"].items():
            socket = by_identifier[name]
            socket.default_value = (*number, 1.0) if socket.type == "RGBA" else number
        for name, socket in by_identifier.items():
            if name == "Vector":
                tree.links.new(place.outputs["Vector"], socket)
            elif name == "W":
                tree.links.new(separate.outputs["X"], socket)
            elif socket.type == "VALUE":
                variant["inputs"][name] = float32(socket.default_value)
            else:
                variant["inputs"][name] = [float32(number) for number in socket.default_value][:3]
        for output in node.outputs:
            if not output.enabled:
                continue
            aov = layer.aovs.add()
            aov.name = f"aov{len(aovs)}"
            aov.type = "VALUE" if output.type == "VALUE" else "COLOR"
            end = tree.nodes.new("ShaderNodeOutputAOV")
            end.aov_name = aov.name
            tree.links.new(output, end.inputs["Value" if output.type == "VALUE" else "Color"])
            aovs.append((variant, output.identifier, aov.name))
    return made, aovs


def render(shown, variants, folder, count):
    """Renders some variants and puts their outputs into them."""
    made, aovs = material(variants)
    shown.data.materials.clear()
    shown.data.materials.append(made)
    path = os.path.join(folder, "textures.exr")
    bpy.context.scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    channels = exr.passes(exr.read(path))
    os.remove(path)
    for variant, output, aov in aovs:
        (values,) = (values for name, values in channels.items() if name.endswith("." + aov) or name == aov)
        middle = values[PIXELS // 2 :: PIXELS, PIXELS // 2 :: PIXELS, :3].astype(">f4")
        taken = middle.reshape(-1, middle.shape[2])[:count][variant["first"] : variant["first"] + variant["count"]]
        assert numpy.unique(taken).size > 1 or not numpy.any(taken), (variant, output)
        variant["outputs"][output] = taken.tobytes().hex()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--nodes", default=",".join(NODES))
    parser.add_argument("--points", type=int, default=128)
    given = parser.parse_args()
    coordinates = points(given.points)
    shown = sheet(coordinates)
    with open(os.path.join(given.folder, "points.json"), "w", encoding="utf-8") as file:
        file.write("[\n" + ",\n".join(json.dumps(point) for point in coordinates) + "\n]\n")
    for node in given.nodes.split(","):
        variants = []
        for number, (settings, inputs) in enumerate(NODES[node]()):
            first, count = 0, given.points
            if given.points < 1024:
                first, count = number * TAKEN % given.points, TAKEN
            variant = {"node": node, "settings": settings, "inputs": inputs}
            variants.append({**variant, "first": first, "count": count, "outputs": {}})
        step = AOVS // 3
        for start in range(0, len(variants), step):
            render(shown, variants[start : start + step], given.folder, given.points)
        about = "made by tests/python/texture_values.py; outputs are the bits of 32-bit floats in hexadecimal"
        head = {"about": about, "blender": bpy.app.version_string}
        with open(os.path.join(given.folder, node + ".json"), "w", encoding="utf-8") as file:
            lines = ",\n".join(json.dumps(variant) for variant in variants)
            file.write(json.dumps(head)[:-1] + f',\n"variants": [\n{lines}\n]}}\n')


main()
