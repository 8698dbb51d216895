# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: a colour, an environment image, its node tree, or what cannot be evaluated baked by Cycles."""

import hashlib
import json
import math
import os
import tempfile

import bpy
import numpy

from . import baker, colorspace, evaluated, expressions, gltf, graph, graph_write, images, nodes, skies, volumes
from .expressions import Const, Image, as_color, multiply
from .shaders import Reader, TextureSpec
from .verdicts import APPROXIMATED, EXACT, LOST, Finding

# Width of a baked picture in texels, and samples in each: two million in both, which take a second or less.
SMOOTH_BAKE = (1024, 4)
DETAILED_BAKE = (2048, 1)
# Nodes whose values change slowly with the direction, or as their inputs do. All others may show detail.
SMOOTH = {
    "BACKGROUND", "BLACKBODY", "BRIGHTCONTRAST", "COMBINE_COLOR", "COMBXYZ", "CURVE_RGB", "EMISSION", "GAMMA", "GROUP", "GROUP_INPUT",
    "GROUP_OUTPUT", "HUE_SAT", "INVERT", "LIGHT_PATH", "MAPPING", "MAP_RANGE", "MATH", "MIX", "MIX_RGB", "MIX_SHADER", "ADD_SHADER",
    "NEW_GEOMETRY", "NORMAL", "OUTPUT_WORLD", "REROUTE", "FRAME", "RGB", "RGBTOBW", "SEPARATE_COLOR", "SEPXYZ", "TEX_COORD",
    "TEX_GRADIENT", "TEX_SKY", "VALTORGB", "VALUE", "VECT_MATH", "VECTOR_ROTATE", "CLAMP",
}  # fmt: skip
# Radians up to which a sun's disc becomes a light of one radiance; greater ones are seen by many texels.
MOST_SUN = 0.1


class _Environments(nodes.Evaluator):
    """Finds environment textures; `needs_bake` is why the tree goes beyond one, or None."""

    def __init__(self, walker):
        super().__init__(walker, self._never)
        self.needs_bake = self.missing = None
        # A texture is not interpolated linearly, as plain pictures are.
        self.is_not_linear = False

    def _never(self, node, place):
        self.needs_bake = self.needs_bake or f"{node.bl_label} node"

    def _unknown(self, source):
        self.needs_bake = self.needs_bake or f"{source.node.bl_label} node"
        return super()._unknown(source)

    def _node_tex_environment(self, source, node):
        if node.image is None:
            self.missing = "its environment texture has no image: pink, as in Cycles"
            return Const(images.MISSING)
        if images.is_missing(node.image):
            self.missing = f"the image \"{node.image.name}\" is missing or broken ({node.image.filepath_raw}): pink, as in Cycles"
            return Const(images.MISSING)
        rotation, reason = _rotation(self.walker, self, source.input("Vector"))
        if node.projection != "EQUIRECTANGULAR":
            reason = "mirror ball"
        elif node.image.source not in {"FILE", "GENERATED"} or not images.is_exactly_known(node.image):
            reason = f"image \"{node.image.name}\""
        if reason:
            self.needs_bake = self.needs_bake or reason
        self.is_not_linear |= node.interpolation != "Linear"
        # The rotation stands in the place of the transform, so that one image turned in two ways is two.
        return Image(TextureSpec(node.image, None, rotation.reshape(-1).tolist(), (10497, 10497), node.interpolation == "Closest"))


def _rotation(walker, evaluator, place):
    """(3×3 matrix from the world's directions to the image's, why it is more than a rotation)."""
    source = walker.source(place)
    matrix = numpy.eye(3)
    if source.socket.is_output and source.node.type == "MAPPING":
        values = [evaluator.color(source.input(n)) for n in ("Rotation", "Scale")]
        location = source.input("Location")
        values.append(evaluator.color(location) if location else Const(numpy.zeros(3)))
        if not all(isinstance(v, Const) for v in values):
            return matrix, "Mapping node with varying inputs"
        rotation, scale, shift = (v.value for v in values)
        kind = source.node.vector_type
        if kind in {"POINT", "TEXTURE"} and shift.any():
            return matrix, "Mapping node with a location"
        if numpy.ptp(scale) > 1e-6 or scale[0] <= 0:
            return matrix, "Mapping node with a scale"
        matrix = _euler(rotation)
        if kind == "TEXTURE":
            matrix = matrix.T
        source = walker.source(source.input("Vector"))
        if not source.socket.is_output:
            return matrix, "Mapping node without coordinates"
    if source.socket.is_output and not (source.node.type == "TEX_COORD" and source.socket.name == "Generated"):
        return matrix, f"coordinates by {source.node.bl_label}"
    return matrix, None


def _euler(angles):
    """Rotation by Euler angles, first about X, then Y, then Z."""
    (cx, cy, cz), (sx, sy, sz) = numpy.cos(angles), numpy.sin(angles)
    x = numpy.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    y = numpy.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    z = numpy.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return z @ y @ x


def _visibility(world):
    settings = getattr(world, "cycles_visibility", None)
    names = {"camera": "camera", "diffuse": "diffuse", "glossy": "glossy", "transmission": "transmission", "volume": "scatter"}
    return {kind: False for kind, name in names.items() if not getattr(settings, name, True)}


def describe(world, cache, document, findings, report=None, pixel=None, as_tree=True, layer=None):
    """The `world` object of SUNDOG_scene.

    Images become the document's; findings get what is not exact. Baking takes a child process and
    some seconds, once for each tree; `pixel` is the radians that a pixel of the picture sees. A document that
    holds no node trees (`as_tree` is false) needs nothing but `uri`. `layer` has the view layer's attributes.
    """
    if world is None:
        return {"color": [0.0, 0.0, 0.0]}
    result = {"color": [float(v) for v in world.color]}
    seen = _visibility(world)
    if seen:
        result["visibility"] = seen
    tree = nodes.tree_of(world)
    if tree is None:
        return result
    output = nodes.output_of(world)
    if output is None:
        result["color"] = [0.0, 0.0, 0.0]
        return result
    walker = nodes.Walker()
    reader = Reader(walker)
    # Before 5.0 another kind of output may stand for the world's, which has a surface alone.
    volume = volumes.read(reader, nodes.Place(output.inputs["Volume"])) if "Volume" in output.inputs else None
    if isinstance(volume, volumes.Varying):
        volume, _ = volume.described(world, reader, (document, cache, []))
    findings.extend(reader.findings)
    if volume is not None:
        result["volume"] = volume
    source = walker.source(nodes.Place(output.inputs["Surface"]))
    if not nodes.is_fed(source.socket):
        result["color"] = [0.0, 0.0, 0.0]
        return result
    evaluator = _Environments(walker)
    radiance, reason = None, None
    if source.node.type in {"BACKGROUND", "EMISSION"}:
        radiance = multiply(evaluator.scalar(source.input("Strength")), evaluator.color(source.input("Color")))
        reason = evaluator.needs_bake
        if evaluator.missing:
            findings.append((EXACT, evaluator.missing))
    else:
        reason = f"{source.node.bl_label} node"
    found = None if reason else expressions.factors(as_color(radiance))
    if found and not found[2] and len(found[1]) <= 1 and not any(i.alpha for i in found[1]):
        factor, used, _ = found
        result["color"] = [float(v) for v in numpy.broadcast_to(factor, 3)]
        if not used:
            if evaluator.missing:
                # A colour would get no light samples: Cycles takes them of all that has a texture.
                result["image"] = document.uri(_white(cache))
            return result
        is_coded = _is_coded(used[0].texture.image) or evaluator.is_not_linear
        written = _coded(world, (document, cache, report, layer)) if as_tree and is_coded else None
        if written is not None:
            return {**result, "color": [1.0, 1.0, 1.0], **written}
        path = environment_file(used[0].texture.image, cache)
        result["image"] = document.uri(path)
        rotation = used[0].texture.transform
        if rotation != numpy.eye(3).reshape(-1).tolist():
            result["rotation"] = rotation
        return result
    written, why_not = None, None
    if as_tree and graph.ENABLED:
        written, why_not = graph_write.emitting(world, evaluated.WORLD, document, cache, findings, report, layer)
    if written is not None:
        return {**result, **_as_tree(world, written)}
    if why_not:
        findings.append((EXACT, f"its nodes are not evaluated as they are because of: {why_not}"))
    try:
        path, sun, note = bake(world, tree, cache, report, pixel)
    except baker.BakeError as error:
        findings.append((LOST, f"the world's nodes could not be baked ({error}): its mean colour is used"))
        if radiance is not None and not any(isinstance(leaf, Image) for leaf in radiance.leaves()):
            result["color"] = [float(v) for v in expressions.mean(as_color(radiance)).value]
        return result
    findings.append((APPROXIMATED, note))
    result["color"] = [1.0, 1.0, 1.0]
    result["image"] = document.uri(path)
    if sun:
        result["sun"] = sun
    return result


def _as_tree(world, written):
    """What SUNDOG_scene's world says of a node tree."""
    resolution = _resolution(world)
    return {"shader_graph": written, **({"sampling": {"resolution": resolution}} if resolution else {})}


def _is_coded(image):
    """Whether a picture is of coded numbers, between which Cycles takes the mean before it decodes it, or of such that its plain file
    does not hold: floats of spaces that are not linear or times their alpha, and integers of 16 bits."""
    space = image.colorspace_settings.name
    if not images.holds_floats(image):
        return space == "sRGB"
    is_linear = space in images.DATA_SPACES | images.LINEAR_SPACES | colorspace.LINEAR
    return not is_linear or images.kind_of(images.start_of(image) or b"") == ".png" or images.multiplies(image)


def _coded(world, place):
    """The tree of a world that is a picture, where that is not what its plain picture shows. None where that cannot be written."""
    if not graph.ENABLED:
        return None
    document, cache, report, layer = place
    findings = []
    written, _ = graph_write.emitting(world, evaluated.WORLD, document, cache, findings, report, layer)
    return None if written is None or findings else _as_tree(world, written)


def _resolution(world):
    """Columns of the table by which Cycles samples the world; 0 if it takes them from the tree."""
    settings = getattr(world, "cycles", None)
    if getattr(settings, "sampling_method", "AUTOMATIC") != "MANUAL":
        return 0
    return int(settings.sample_map_resolution)


def _white(cache):
    """A picture of one colour, for environment textures without an image."""
    path = os.path.join(cache, "white.hdr")
    if not os.path.isfile(path):
        os.makedirs(cache, exist_ok=True)
        gltf.write_whole(path, b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + bytes([128, 128, 128, 129] * 2))
    return path


def environment_file(image, cache):
    """The image as a file that the program reads as Cycles does."""
    # No node asks for the alpha (the tree is baked where one does), so that colours are those times alpha.
    multiplied = images.multiplies(image)
    path = images.original(image, cache, as_data=False) if multiplied == images.is_associated(image) else None
    if path:
        return path
    name = hashlib.sha1(json.dumps(images.identity(image)).encode()).hexdigest()
    path = os.path.join(cache, f"sky-{name}.exr")
    if not os.path.isfile(path):
        images.write_exr(path, images.linear_pixels(image, multiplied)[::-1, :, :3])
    return path


def _describe_tree(tree, seen):
    """Everything in a node tree that decides on what it shows, for hashing."""
    if tree.as_pointer() in seen:
        return []
    seen.add(tree.as_pointer())
    result = []
    for node in sorted(tree.nodes, key=lambda n: n.name):
        entry = [node.name, node.bl_idname, node.mute]
        for prop in node.bl_rna.properties:
            if prop.identifier in _LAYOUT_ONLY or prop.type in {"COLLECTION"}:
                continue
            value = getattr(node, prop.identifier)
            if isinstance(value, bpy.types.Image):
                value = images.identity(value)
            elif isinstance(value, bpy.types.NodeTree):
                value = _describe_tree(value, seen)
            elif isinstance(value, bpy.types.ColorRamp):
                value = [[round(v, 6) for v in value.evaluate(i / 255)] for i in range(256)]
            elif prop.type == "POINTER":
                value = getattr(value, "name", None)
            elif hasattr(value, "__len__") and not isinstance(value, str):
                value = [float(v) if isinstance(v, float) else str(v) for v in value]
            entry.append([prop.identifier, value if isinstance(value, (list, str, int, float, bool)) else str(value)])
        for socket in node.inputs:
            if not socket.is_linked and hasattr(socket, "default_value"):
                entry.append([socket.identifier, str(nodes.default_value(socket).value.tolist())])
        result.append(entry)
    links = [(l.from_node.name, l.from_socket.identifier, l.to_node.name, l.to_socket.identifier, l.is_muted) for l in tree.links]
    return [result, sorted(links)]


_LAYOUT_ONLY = {
    "rna_type", "location", "location_absolute", "width", "height", "dimensions", "select", "show_options", "show_preview",
    "show_texture", "hide", "color", "use_custom_color", "parent", "label", "warning_propagation", "is_active_output",
    "bl_icon", "bl_width_default", "bl_height_default",
}


class _Plan:
    """How a tree is baked, and under which name. `pixel`: radians that a pixel of the picture sees of it, or None."""

    def __init__(self, tree, pixel):
        self.kinds, ramps = _kinds(tree, set())
        detailed = bool(self.kinds - SMOOTH) or "CONSTANT" in ramps
        fine = pixel is None or pixel < 2 * math.pi / SMOOTH_BAKE[0]
        self.width, self.samples = DETAILED_BAKE if detailed and fine else SMOOTH_BAKE
        self.sun = None
        suns = list(_suns(tree, set()))
        self.has_sun = bool(suns)
        if len(suns) == 1 and suns[0].sun_size <= MOST_SUN and not any(socket.is_linked for socket in suns[0].inputs):
            elevation, rotation = suns[0].sun_elevation, suns[0].sun_rotation
            across = math.cos(elevation)
            toward = [across * math.sin(rotation), across * math.cos(rotation), math.sin(elevation)]
            self.sun = {"direction": toward, "angle": float(suns[0].sun_size)}
        description = [_describe_tree(tree, set()), self.width, self.samples, list(bpy.app.version), colorspace.working_space(), 2]
        self.name = hashlib.sha1(json.dumps(description, sort_keys=True, default=str).encode()).hexdigest()

    def files(self, cache):
        """The picture and what is told beside it."""
        return os.path.join(cache, f"world-{self.name}.exr"), os.path.join(cache, f"world-{self.name}.json")


def prepare(world, cache, pixel=None):
    """Starts the Blender that will bake the world or a sky in it, if it is clear that it will have to."""
    tree = world and nodes.tree_of(world)
    if not tree:
        return
    try:
        kinds, _ = _kinds(tree, set())
        if not any(kind.startswith("TEX_") and kind != "TEX_ENVIRONMENT" for kind in kinds):
            return
        walk = graph.Walk(nodes.Walker(), evaluated.WORLD)
        walk.read(world)
        if graph.ENABLED and not walk.objections:
            known = [skies.Plan(use.node).is_known(cache) for use in walk.uses if use.node.bl_idname == "ShaderNodeTexSky"]
        else:
            known = [os.path.isfile(path) for path in _Plan(tree, pixel).files(cache)]
        if not all(known):
            baker.start()
    except (baker.BakeError, images.ImageError, RecursionError, KeyError, IndexError, AttributeError, TypeError, ValueError):
        # It is told where the world is written.
        return


def bake(world, tree, cache, report=None, pixel=None):
    """(file, the sun's disc or None, what was done): the world as an equirectangular picture, rendered by Cycles in a child."""
    plan = _Plan(tree, pixel)
    path, beside = plan.files(cache)
    if os.path.isfile(path) and os.path.isfile(beside):
        with open(beside, encoding="utf-8") as file:
            answer = json.load(file)
        os.utime(beside)
    else:
        original = world.original
        with tempfile.TemporaryDirectory(prefix="sundog-world-") as folder:
            blend, picture = os.path.join(folder, "world.blend"), os.path.join(folder, "world.exr")
            bpy.data.libraries.write(blend, {original}, path_remap="ABSOLUTE", fake_user=True)
            request = {
                "blend": blend,
                "name": original.name,
                "out": picture,
                "width": plan.width,
                "samples": plan.samples,
                "space": colorspace.working_space(),
                "values": _values(tree, {}),
                "sun": plan.sun,
            }
            answer = baker.ask(request, report)
            with open(picture, "rb") as source:
                gltf.write_whole(path, source.read())
        gltf.write_whole(beside, json.dumps(answer).encode())
    note = f"its nodes are baked to a picture of {plan.width} × {plan.width // 2} pixels"
    sun = answer.get("sun")
    if sun:
        note += ", without the sky's sun disc, which is a light of one radiance"
    elif plan.has_sun:
        note += ", the sky's sun disc with them"
    if "LIGHT_PATH" in plan.kinds:
        note += "; what a Light Path node shows the camera alone is not seen: the light's side is baked"
    return path, sun, note


def _suns(tree, seen):
    """The sky textures that show a sun."""
    if tree.as_pointer() in seen:
        return
    seen.add(tree.as_pointer())
    for node in tree.nodes:
        if node.type == "TEX_SKY" and getattr(node, "sun_disc", False) and node.sky_type not in {"PREETHAM", "HOSEK_WILKIE"}:
            yield node
        if node.type == "GROUP" and node.node_tree is not None:
            yield from _suns(node.node_tree, seen)


def _values(tree, found, name=""):
    """What animation and drivers have made of a tree and its groups; see bake_world."""
    if name in found:
        return found
    found[name] = {}
    for node in tree.nodes:
        properties, sockets = {}, {}
        for prop in node.bl_rna.properties:
            if prop.identifier in _LAYOUT_ONLY or prop.is_readonly or prop.type not in {"FLOAT", "INT", "ENUM", "BOOLEAN"}:
                continue
            value = getattr(node, prop.identifier)
            if isinstance(value, (bool, int, float, str)):
                properties[prop.identifier] = value
            elif prop.type != "ENUM":
                properties[prop.identifier] = [float(v) for v in value]
        for socket in (*node.inputs, *node.outputs):
            value = getattr(socket, "default_value", None)
            if isinstance(value, (bool, int, float)):
                sockets[socket.identifier] = value
            elif value is not None and not isinstance(value, str) and hasattr(value, "__len__"):
                sockets[socket.identifier] = [float(v) for v in value]
        ramp = getattr(node, "color_ramp", None)
        stops = [[stop.position, list(stop.color)] for stop in ramp.elements] if ramp is not None else []
        found[name][node.name] = {"properties": properties, "sockets": sockets, "stops": stops}
        if node.type == "GROUP" and node.node_tree is not None:
            _values(node.node_tree, found, node.node_tree.name)
    return found


def _kinds(tree, seen):
    """(kinds of the nodes in a tree and its groups, interpolations of its colour ramps)."""
    if tree.as_pointer() in seen:
        return set(), set()
    seen.add(tree.as_pointer())
    kinds, ramps = set(), set()
    for node in tree.nodes:
        kinds.add(node.type)
        if node.type == "VALTORGB":
            ramps.add(node.color_ramp.interpolation)
        if node.type == "GROUP" and node.node_tree is not None:
            inner = _kinds(node.node_tree, seen)
            kinds |= inner[0]
            ramps |= inner[1]
    return kinds, ramps
