# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's USD exporter makes of the nodes of materials. Measured on files of 4.5.15 and 5.2.3 (tests/addon/parity_usd.py)."""

import bpy

from . import images
from .verdicts import APPROXIMATED, LOST

# Nodes whose outputs the exporter replaces by a constant.
CONSTANT = {
    "AMBIENT_OCCLUSION", "ATTRIBUTE", "BACKGROUND", "BEVEL", "CAMERA", "DISPLACEMENT", "FRESNEL", "HAIR_INFO", "LAYER_WEIGHT",
    "LIGHT_FALLOFF", "LIGHT_PATH", "PARTICLE_INFO", "POINT_INFO", "RAYCAST", "MATERIAL_RAYCAST", "SCRIPT", "SHADERTORGB", "SQUEEZE",
    "TEX_BRICK", "TEX_GABOR", "TEX_IES", "TEX_MAGIC", "TEX_POINTDENSITY", "TEX_SKY", "TEX_VORONOI", "UVALONGSTROKE",
    "VECTOR_DISPLACEMENT", "VERTEX_COLOR", "VOLUME_INFO", "WAVELENGTH", "WIREFRAME", "RADIAL_TILING", "ShaderNodeRadialTiling",
    "BUMP", "VALTORGB", "MIX_RGB", "BSDF_HAIR", "BSDF_HAIR_PRINCIPLED", "BSDF_TOON", "BSDF_RAY_PORTAL", "EEVEE_SPECULAR", "HOLDOUT",
    "VOLUME_ABSORPTION", "VOLUME_COEFFICIENTS", "PRINCIPLED_VOLUME", "VOLUME_SCATTER",
}  # fmt: skip
# And those of which some outputs are.
_OUTPUTS = {
    "NEW_GEOMETRY": {"True Normal", "Incoming", "Parametric", "Backfacing", "Pointiness", "Random Per Island"},
    "OBJECT_INFO": {"Color", "Alpha", "Object Index", "Material Index"},
    "TEX_COORD": {"Generated", "Camera", "Window", "Reflection"},
}
# Old nodes of colours came with 5.x.
_NOT_IN_4 = {"COMBHSV", "COMBRGB", "SEPHSV", "SEPRGB"}

# Outputs that hold something else.
_ELSE = {
    ("NEW_GEOMETRY", "Tangent"): "is that of the UV map",
    ("OBJECT_INFO", "Location"): "is the place on the surface",
    ("OBJECT_INFO", "Random"): "has other numbers",
    ("TEX_COORD", "Normal"): "is that of the world, not of the object",
    ("NORMAL", "Dot"): "is not that of unit vectors",
}
# Nodes that are always something else.
_ALWAYS = {
    "CURVE_FLOAT": "its curve is left out",
    "CURVE_RGB": "its curves are left out",
    "CURVE_VEC": "its curves are left out",
    "TANGENT": "it is that of the UV map",
    "TEX_ENVIRONMENT": "it is a flat image",
    "TEX_NOISE": "its pattern is another, and does not follow its vector",
    "TEX_WHITE_NOISE": "its pattern is another",
    "VECTOR_ROTATE": "it turns otherwise",
}
# What nodes give that hold no numbers below 0 or above 1.
_WITHIN = {"CLAMP", "TEX_CHECKER", "TEX_GRADIENT", "TEX_IMAGE", "TEX_NOISE", "TEX_WAVE", "TEX_WHITE_NOISE"}
# Textures that without a link look at generated coordinates, which the exporter has none for.
_GENERATED = {"TEX_CHECKER", "TEX_GRADIENT", "TEX_WAVE"}


def differs(node, output):
    """(verdict, words) of each way in which an output of a node is another one in the file."""
    name, kind = node.bl_label, node.type
    if output.name in _OUTPUTS.get(kind, ()):
        yield LOST, f"{name} ({output.name}) is a constant there, or left out"
    if kind in CONSTANT or (bpy.app.version < (5, 0) and kind in _NOT_IN_4):
        yield LOST, f"{name} is a constant there, or left out"
        return
    if (kind, output.name) in _ELSE:
        yield LOST, f"{name} ({output.name}) {_ELSE[kind, output.name]}"
    if kind in _ALWAYS:
        yield LOST, f"of {name}, {_ALWAYS[kind]}"
    if getattr(node, "from_instancer", False):
        yield LOST, f"{name} is that of the object, not of its instancer"
    if kind in _GENERATED and not node.inputs["Vector"].is_linked:
        yield LOST, f"{name} has other coordinates, as generated ones are lacking"
    for verdict, words in _OF.get(kind, lambda *_: ())(node, output):
        yield verdict, f"of {name}, {words}"


def _linked(node, *names):
    return any(socket.is_linked for socket in node.inputs if not names or socket.name in names)


def _outside(node):
    """Whether numbers below 0 or above 1 may come in."""
    for socket in node.inputs:
        if any(link.from_node.type not in _WITHIN for link in socket.links):
            return True
    return False


def _number(node, name):
    """Values of a socket, the one that is in use of those of the same name."""
    for socket in node.inputs:
        if socket.name == name and socket.enabled and not socket.is_unavailable:
            value = socket.default_value
            return tuple(value) if hasattr(value, "__len__") else (value,)
    return ()


def _checker(node, _output):
    links = node.inputs["Vector"].links
    flat = links and (links[0].from_node.type == "UVMAP" or (links[0].from_node.type == "TEX_COORD" and links[0].from_socket.name == "UV"))
    if not flat:
        yield LOST, "the third axis is left out"


def _gradient(node, _output):
    if node.gradient_type in {"LINEAR", "QUADRATIC", "DIAGONAL"}:
        yield APPROXIMATED, "what is below 0 or above 1 is kept"


def _wave(node, _output):
    if _linked(node, "Distortion") or node.inputs["Distortion"].default_value != 0:
        yield LOST, "the distortion has another pattern"


def _image(node, output):
    if node.projection != "FLAT":
        yield LOST, f"the {node.projection.lower()} projection is left out"
    alpha = node.outputs.get("Alpha")
    if output.name == "Color" and node.image is not None and not (alpha and alpha.is_linked) and images.multiplies(node.image):
        yield LOST, "colours are not multiplied by the image's alpha"


def _blackbody(node, _output):
    if _linked(node):
        yield APPROXIMATED, "temperatures below 1667 K and above 25000 K have other colours"


def _map_range(node, _output):
    ends = ("From Min", "From Max", "To Min", "To Max")
    low, high, least, most = (_number(node, name) for name in ends)
    turned = any(a >= b for a, b in zip(low, high)) or any(a > b for a, b in zip(least, most))
    if node.interpolation_type == "SMOOTHERSTEP":
        yield LOST, "it is no smoother step"
    if _linked(node, *ends, "Steps") or turned:
        yield APPROXIMATED, "ranges that run backwards, or vary, have other values"


def _math(node, _output):
    if node.operation in {"COMPARE", "SMOOTH_MAX"}:
        yield LOST, f"{node.operation.replace('_', ' ').lower()} has other values"
    if node.operation in {"MODULO", "LOGARITHM"} and _outside(node):
        yield APPROXIMATED, "numbers below 0 have other values"


def _vector_math(node, _output):
    if node.operation in {"REFLECT", "REFRACT", "POWER"}:
        yield LOST, f"{node.operation.lower()} has other values"
    if node.operation in {"SIGN", "FRACTION", "MODULO"} and _outside(node):
        yield APPROXIMATED, "numbers below 0 have other values"


def _mapping(node, _output):
    turned = _linked(node, "Rotation", "Scale") or any(_number(node, "Rotation"))
    if node.vector_type in {"TEXTURE", "VECTOR"} and turned:
        yield LOST, f"as a {node.vector_type.lower()} it turns and scales in another order"


def _transform(node, _output):
    if "CAMERA" in {node.convert_from, node.convert_to}:
        yield LOST, "the camera's space is left out"


def _normal_map(node, _output):
    if node.space != "TANGENT":
        yield LOST, "its space is taken as that of tangents"
    if getattr(node, "convention", "OPENGL") != "OPENGL":
        yield LOST, "its convention is taken as that of OpenGL"
    if getattr(node, "base", "DISPLACED") != "DISPLACED":
        yield LOST, "its base is the displaced surface"
    if node.uv_map:
        yield APPROXIMATED, "tangents are those of the first UV map"


def _of_hsl(node, _output):
    if node.mode == "HSL":
        yield LOST, "HSL is taken as HSV"


def _colors(node, _output):
    if _outside(node):
        yield APPROXIMATED, "colours below 0 and above 1 have other values"


def _mix(node, output):
    if node.data_type == "RGBA" and node.blend_type != "MIX":
        yield from _colors(node, output)


def _principled(node, _output):
    if node.distribution == "GGX":
        yield APPROXIMATED, "light that is scattered between facets is added"
    below = node.inputs.get("Subsurface Weight")
    if below is not None and (below.is_linked or below.default_value > 0) and node.subsurface_method != "RANDOM_WALK":
        yield LOST, "the method of its subsurface is Random Walk"


_OF = {
    "BLACKBODY": _blackbody, "BSDF_PRINCIPLED": _principled, "COMBINE_COLOR": _of_hsl, "GAMMA": _colors, "HUE_SAT": _colors, "MAPPING": _mapping,
    "MAP_RANGE": _map_range, "MATH": _math, "MIX": _mix, "NORMAL_MAP": _normal_map, "SEPARATE_COLOR": _of_hsl, "TEX_CHECKER": _checker,
    "TEX_GRADIENT": _gradient, "TEX_IMAGE": _image, "TEX_WAVE": _wave, "VECT_MATH": _vector_math, "VECT_TRANSFORM": _transform,
}  # fmt: skip
