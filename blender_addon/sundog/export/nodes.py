# SPDX-License-Identifier: GPL-3.0-or-later
"""Walks Blender's shader node trees and says what sockets amount to, as expressions."""

import hashlib
import math
import re

import bpy
import numpy

from . import blackbody, expressions, images, inlining
from .expressions import (
    SAMPLES,
    Attribute,
    Const,
    Image,
    Unknown,
    as_color,
    as_scalar,
    component,
    mix,
    multiply,
    operation,
)


class Place:
    """A socket inside nested groups: the groups' nodes from the outermost inwards."""

    def __init__(self, socket, groups=()):
        self.socket, self.groups = socket, groups

    @property
    def node(self):
        """The socket's node."""
        return self.socket.node

    def input(self, name):
        """Another input of the same node, or None."""
        found = self.node.inputs.get(name)
        return None if found is None else Place(found, self.groups)

    def identified(self, identifier):
        """An input of the same node by identifier, or None."""
        for socket in self.node.inputs:
            if socket.identifier == identifier:
                return Place(socket, self.groups)
        return None


# From 5.0 on Blender makes one tree of all groups before Cycles reads it: what links through them lead to alone converts.
INLINED = bpy.app.version >= (5, 0, 0)
# From 5.3 on links into sockets for true and false say whether a value is above 0.
TRUTHS = bpy.app.version >= (5, 3, 0)


# What the walker stops at only where nothing comes out.
HOLLOW = {"GROUP", "GROUP_INPUT", "REROUTE"}

# Nodes that Cycles does not have: what is linked to them takes its own value. In words for findings.
ABSENT = {
    "SHADERTORGB": "Shader to RGB is a node of EEVEE's",
    "EEVEE_SPECULAR": "Specular BSDF is a node of EEVEE's",
    "LIGHT_ACCUMULATION": "Light Accumulation is a node of EEVEE's",
    "LIGHT_EVALUATION": "Light Evaluation is a node of EEVEE's",
    "LIGHT_INFO": "Light Info is a node of EEVEE's",
    "SHADOW_RAYCAST": "Shadow Raycast is a node of EEVEE's",
    "SCRIPT": "Script is a node of Open Shading Language, which is off",
}


class SceneWide:
    """What the scene that is exported says of all nodes: whether it has Open Shading Language, and how far in metres an Ambient
    Occlusion without a distance of its own looks."""

    scripts, reach = False, 10.0
    # While a scene is exported: the trees that Blender makes of those with zones, menus and the like, by what they belong to, with
    # None where there is no need.
    inlined = None

    @classmethod
    def of(cls, scene):
        """That of a scene, which is exported from now on."""
        cls.inlined = {}
        cls.scripts = bool(getattr(getattr(scene, "cycles", None), "shading_system", False))
        cls.reach = scene.world.light_settings.distance if scene.world else 10.0


def _is_absent(node):
    return node.type in ABSENT and not node.mute and not (node.type == "SCRIPT" and SceneWide.scripts)


# Shaders of volumes, which are nothing on surfaces; and what counts in volumes, where all other shaders are nothing.
VOLUMES = {"VOLUME_ABSORPTION", "VOLUME_SCATTER", "PRINCIPLED_VOLUME", "VOLUME_COEFFICIENTS"}
FILLING = {*VOLUMES, "EMISSION", "MIX_SHADER", "ADD_SHADER"}

# A tree of nested groups may stand for more nodes than there is time for.
MOST_NODES = 30_000


class Walker:
    """Finds what is linked to what; reads links once (a socket's own `links` searches all)."""

    def __init__(self):
        self._links = {}
        # Whether a link was asked for that Blender calls invalid, as those of circles are.
        self.met_invalid = False
        # The labels of nodes that were asked for and that Cycles does not have.
        self.met_absent = set()

    def _link(self, socket):
        tree = socket.id_data
        key = tree.as_pointer()
        if key not in self._links:
            # The trees are kept, so that no other tree gets the same address meanwhile.
            table, invalid, absent = {}, set(), {}
            for link in tree.links:
                # `is_hidden` is not asked for: Blender 4.5 crashes on it in evaluated trees.
                if link.is_muted:
                    continue
                name = (link.to_node.name, link.to_socket.identifier)
                if _is_absent(link.from_node):
                    absent[name] = ABSENT[link.from_node.type]
                elif link.is_valid:
                    table[name] = link
                elif link.from_socket.enabled and link.to_socket.enabled:
                    # Sockets that a node's settings switch off are in no circle.
                    invalid.add(name)
            self._links[key] = (tree, table, invalid, absent)
        name = (socket.node.name, socket.identifier)
        _, table, invalid, absent = self._links[key]
        self.met_invalid |= name in invalid
        if name in absent:
            self.met_absent.add(absent[name])
        return table.get(name)

    def is_only_filled(self, output):
        """Whether a volume is all that a material's output is linked to: rays pass through its surface."""
        if "Volume" not in output.inputs:
            return False
        surface, volume = (self.source(Place(output.inputs[name])).socket for name in ("Surface", "Volume"))
        return is_fed(volume) and not is_fed(surface)

    def source(self, place, passed=None):
        """The output socket that feeds an input, through reroutes, groups and muted nodes.

        Returns a Place of an output socket, or of an unlinked input whose own value counts. The list `passed` gets
        the types of the sockets on the way, that of the result last.
        """
        passed = [] if passed is None else passed
        # The last input that takes its own value where its link leads nowhere, as in Cycles, and how far it was there.
        own = place, 0
        for count in range(10_000):
            socket, groups = place.socket, place.groups
            node = socket.node
            # Before 5.0 what a muted node stands for has the type of its output alone, and gives zero where nothing is linked to it.
            is_passing = node.mute and not INLINED
            if count and (socket.is_output or not is_passing):
                passed.append(socket.type)
            if socket.is_output:
                if node.mute:
                    inner = next((l.from_socket for l in node.internal_links if l.to_socket == socket), None)
                    if inner is None:
                        return self._fallen_back(own, place, passed)
                    muted, place = place, Place(inner, groups)
                elif node.type == "REROUTE":
                    place = Place(node.inputs[0], groups)
                elif node.type == "GROUP" and node.node_tree is not None:
                    output = next(
                        (n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output), None
                    )
                    inner = output and next(
                        (s for s in output.inputs if s.identifier == socket.identifier), None
                    )
                    if inner is None:
                        return place
                    place = Place(inner, (*groups, node))
                elif node.type == "GROUP_INPUT" and groups:
                    outer = next((s for s in groups[-1].inputs if s.identifier == socket.identifier), None)
                    if outer is None:
                        return place
                    place = Place(outer, groups[:-1])
                else:
                    return place
            else:
                is_passing &= count > 0
                if is_passing or (node.type == "REROUTE" and not INLINED):
                    # Before 5.0 a reroute that nothing feeds gives zero.
                    own = None
                elif node.type != "REROUTE":
                    own = place, len(passed)
                link = self._link(socket)
                if link is None and is_passing:
                    return muted
                if link is None:
                    return place if node.type != "REROUTE" else self._fallen_back(own, place, passed)
                place = Place(link.from_socket, groups)
        raise RecursionError("the node tree has a circle")

    @staticmethod
    def _fallen_back(own, place, passed):
        if own is None:
            return place
        place, length = own
        del passed[length:]
        return place


def tree_of(data):
    """The node tree that a material, light or world is shown by; None if its plain settings count."""
    # From 5.0 on materials and worlds always use their nodes, and asking warns.
    always = INLINED and not isinstance(data, bpy.types.Light)
    if not (always or data.use_nodes):
        return None
    if not INLINED or SceneWide.inlined is None:
        return data.node_tree
    key = data.as_pointer(), data.name_full
    if key not in SceneWide.inlined:
        SceneWide.inlined[key] = inlining.inlined(data)
    found = SceneWide.inlined[key]
    return data.node_tree if found is None else found.node_tree


# Outputs that Cycles renders from 5.0 on, by whose tree it is: a later one where there is none of those before it.
_OUTPUTS = (
    (bpy.types.Material, ("ShaderNodeOutputMaterial", "ShaderNodeOutputLight")),
    (bpy.types.World, ("ShaderNodeOutputWorld",)),
    (bpy.types.Light, ("ShaderNodeOutputLight",)),
)


def output_of(data):
    """The output node of a material, light or world that Cycles renders; None without one, or without nodes."""
    tree = tree_of(data)
    if tree is None:
        return None
    if not INLINED:
        found = tree.get_output_node("CYCLES")
        # Before 5.0 one that is muted is none.
        return None if found is None or found.mute else found
    for idname in next(kinds for owner, kinds in _OUTPUTS if isinstance(data, owner)):
        found = [node for node in tree.nodes if node.bl_idname == idname and node.target in {"ALL", "CYCLES"}]
        if found:
            # The first of those that come first.
            return max(found, key=lambda node: (node.target == "CYCLES", node.is_active_output))
    return None


def not_in_cycles(label):
    """What is told of nodes that Cycles does not have."""
    return f"{label}: what is linked to it has its own value, as in Cycles"


def is_fed(socket):
    """Whether where a shader's link begins gives something: an output, or the value of a group's socket, which shines in Cycles."""
    return socket.is_output or socket.type != "SHADER"


def attribute_read(node):
    """The name of the attribute of meshes that an Attribute node reads; empty for the active colour, which is Cycles' own name's."""
    return "" if node.attribute_name == "vertex_color" else node.attribute_name


def is_cycles_own(name):
    """Whether an attribute is one that Cycles makes of meshes by itself, in spaces that differ by version."""
    return name in {"P", "N", "tangent", "undisplaced"} or name.endswith((".tangent", ".tangent_sign", ".undisplaced_tangent"))


# What is told of links that Blender calls invalid.
CUT = "links that run in a circle are cut"


def name_of(node):
    """A node's name in its own tree: in those that Blender makes a number stands before it."""
    is_inlined = getattr(node, "id_data", None) is not None and node.id_data.name.endswith(" Inlined")
    return re.sub(r"^\d+_", "", node.name) if is_inlined else node.name


def not_finite(socket):
    """What is told of a socket whose value is not finite."""
    return f"\"{socket.name}\" of the node {name_of(socket.node)} is not a number: 0 is used"


def default_value(socket):
    """An unlinked socket's own value."""
    value = getattr(socket, "default_value", None)
    if value is None:
        return Const(0.0)
    if hasattr(value, "__len__") and not isinstance(value, str):
        return Const([float(v) for v in list(value)[:3]])
    if isinstance(value, (int, float)):
        return Const(float(value))
    return Const(0.0)


def _safe_divide(a, b):
    a, b = numpy.broadcast_arrays(numpy.asarray(a, float), numpy.asarray(b, float))
    return numpy.divide(a, b, out=numpy.zeros(a.shape), where=b != 0)


def _safe_power(a, b):
    with numpy.errstate(all="ignore"):
        result = numpy.power(a, b)
    return numpy.nan_to_num(result, nan=0.0, posinf=0.0, neginf=0.0)


def _smoothstep(low, high, x):
    t = numpy.clip(_safe_divide(x - low, high - low), 0, 1)
    return t * t * (3 - 2 * t)


def _wrap(value, high, low):
    span = numpy.asarray(high, float) - low
    return numpy.where(span == 0, low, value - span * numpy.floor(_safe_divide(value - low, span)))


def _ping_pong(value, scale):
    part = _safe_divide(value - scale, 2 * scale)
    return numpy.where(scale == 0, 0, numpy.abs((part - numpy.floor(part)) * 2 * scale - scale))


def _logarithm(value, base):
    with numpy.errstate(all="ignore"):
        return numpy.where((value > 0) & (base > 0), _safe_divide(numpy.log(value), numpy.log(base)), 0)


def _smooth_minimum(a, b, width):
    # A parabola of third degree in the place of the corner, where the two are nearer than `width`.
    near = numpy.maximum(numpy.where(width == 0, 0, width - numpy.abs(a - b)), 0)
    return numpy.minimum(a, b) - _safe_divide(near**3, width**2) / 6


_MATH = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "DIVIDE": lambda a, b, c: _safe_divide(a, b),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: _safe_power(a, b),
    "SQRT": lambda a, b, c: numpy.sqrt(numpy.maximum(a, 0)),
    "INVERSE_SQRT": lambda a, b, c: _safe_divide(1, numpy.sqrt(numpy.maximum(a, 0))),
    "ABSOLUTE": lambda a, b, c: numpy.abs(a),
    "EXPONENT": lambda a, b, c: numpy.exp(numpy.minimum(a, 700)),
    "MINIMUM": lambda a, b, c: numpy.minimum(a, b),
    "MAXIMUM": lambda a, b, c: numpy.maximum(a, b),
    "LESS_THAN": lambda a, b, c: (a < b) * 1.0,
    "GREATER_THAN": lambda a, b, c: (a > b) * 1.0,
    "SIGN": lambda a, b, c: numpy.sign(a),
    "COMPARE": lambda a, b, c: (numpy.abs(a - b) <= numpy.maximum(c, 1.1920929e-7)) * 1.0,
    "ROUND": lambda a, b, c: numpy.floor(a + 0.5),
    "FLOOR": lambda a, b, c: numpy.floor(a),
    "CEIL": lambda a, b, c: numpy.ceil(a),
    "TRUNC": lambda a, b, c: numpy.trunc(a),
    "FRACT": lambda a, b, c: a - numpy.floor(a),
    "SINE": lambda a, b, c: numpy.sin(a),
    "COSINE": lambda a, b, c: numpy.cos(a),
    "TANGENT": lambda a, b, c: numpy.tan(a),
    "MODULO": lambda a, b, c: numpy.fmod(a, numpy.where(b == 0, 1, b)) * (b != 0),
    "FLOORED_MODULO": lambda a, b, c: numpy.where(b == 0, 0, numpy.mod(a, numpy.where(b == 0, 1, b))),
    "WRAP": lambda a, b, c: _wrap(a, b, c),
    "PINGPONG": lambda a, b, c: _ping_pong(a, b),
    "SNAP": lambda a, b, c: numpy.floor(_safe_divide(a, b)) * b,
    "LOGARITHM": lambda a, b, c: _logarithm(a, b),
    "SMOOTH_MIN": lambda a, b, c: _smooth_minimum(a, b, c),
    "SMOOTH_MAX": lambda a, b, c: -_smooth_minimum(-a, -b, c),
    "ARCSINE": lambda a, b, c: numpy.arcsin(numpy.clip(a, -1, 1)),
    "ARCCOSINE": lambda a, b, c: numpy.arccos(numpy.clip(a, -1, 1)),
    "ARCTANGENT": lambda a, b, c: numpy.arctan(a),
    "ARCTAN2": lambda a, b, c: numpy.arctan2(a, b),
    "SINH": lambda a, b, c: numpy.sinh(numpy.clip(a, -700, 700)),
    "COSH": lambda a, b, c: numpy.cosh(numpy.clip(a, -700, 700)),
    "TANH": lambda a, b, c: numpy.tanh(a),
    "RADIANS": lambda a, b, c: numpy.radians(a),
    "DEGREES": lambda a, b, c: numpy.degrees(a),
}


def _hsv(rgb):
    """Hue, saturation and value, each 0..1, of colours in the last axis."""
    high, low = rgb.max(axis=-1), rgb.min(axis=-1)
    span = high - low
    safe = numpy.where(span == 0, 1, span)
    r, g, b = rgb[..., 0], rgb[..., 1], rgb[..., 2]
    hue = numpy.where(high == r, (g - b) / safe, numpy.where(high == g, 2 + (b - r) / safe, 4 + (r - g) / safe))
    hue = numpy.where(span == 0, 0, hue / 6 % 1.0)
    return hue, numpy.where(high == 0, 0, span / numpy.where(high == 0, 1, high)), high


def _from_hsv(hue, saturation, value):
    k = (numpy.asarray(hue)[..., None] * 6 + numpy.array([5.0, 3.0, 1.0])) % 6
    value, saturation = numpy.asarray(value)[..., None], numpy.asarray(saturation)[..., None]
    return value - value * saturation * numpy.clip(numpy.minimum(k, 4 - k), 0, 1)


def _overlay(a, b):
    return numpy.where(a < 0.5, 2 * a * b, 1 - 2 * (1 - a) * (1 - b))


_BLEND = {
    "MIX": lambda a, b: b,
    "MULTIPLY": lambda a, b: a * b,
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "SCREEN": lambda a, b: 1 - (1 - a) * (1 - b),
    # Where the divisor is zero the channel stays as it is.
    "DIVIDE": lambda a, b: numpy.where(b == 0, a, _safe_divide(a, b)),
    "DIFFERENCE": lambda a, b: numpy.abs(a - b),
    "DARKEN": numpy.minimum,
    "LIGHTEN": numpy.maximum,
    "OVERLAY": _overlay,
    "EXCLUSION": lambda a, b: numpy.maximum(a + b - 2 * a * b, 0),
    "SOFT_LIGHT": lambda a, b: (1 - a) * b * a + a * (1 - (1 - a) * (1 - b)),
    "LINEAR_LIGHT": lambda a, b: a + 2 * b - 1,
}

# Mean values in want of better ones; the samples spread over the range that the texture takes.
_NOISE = 0.5 + 0.12 * numpy.array([math.cos(2.399963 * i) * math.sqrt(-2 * math.log((i + 0.5) / SAMPLES)) for i in range(SAMPLES)])
_UNIFORM = (numpy.arange(SAMPLES) + 0.5) / SAMPLES


def _uniform_colors():
    i = numpy.arange(SAMPLES) + 0.5
    return numpy.stack([i * 0.618034 % 1, i * 0.754878 % 1, i * 0.569840 % 1], axis=-1)


class Evaluator:
    """Says what sockets amount to. `texture_of(node, place)` makes the TextureSpec of image nodes."""

    def __init__(self, walker, texture_of):
        self.walker = walker
        self._texture_of = texture_of
        self._known = {}
        # Sentences on sockets whose own values are not finite.
        self.not_finite = []

    def color(self, place):
        """The colour or vector of an input."""
        return as_color(self._arriving(place)[0])

    def scalar(self, place):
        """The number at an input."""
        value, kind = self._arriving(place)
        return as_scalar(value, vector=kind == "VECTOR")

    def _arriving(self, place):
        """What comes to an input, and the type of the socket that it had last."""
        passed = []
        source = self.walker.source(place, passed)
        value, kind = self._value(source), source.socket.type
        for wanted in reversed(passed[:-1]) if not INLINED else ():
            if wanted in {"VALUE", "INT", "BOOLEAN"}:
                value, kind = as_scalar(value, vector=kind == "VECTOR"), wanted
            elif wanted in {"RGBA", "VECTOR"}:
                value, kind = as_color(value), wanted
            if wanted in {"INT", "BOOLEAN"}:
                value = operation("truncated", numpy.trunc, [value], False)
        return value, kind

    def _value(self, source):
        if not source.socket.is_output:
            return self._own_value(source.socket)
        key = (tuple(g.as_pointer() for g in source.groups), source.socket.as_pointer())
        if key not in self._known:
            if len(self._known) >= MOST_NODES:
                raise RecursionError(f"its groups amount to more than {MOST_NODES} nodes")
            self._known[key] = Unknown(numpy.zeros(SAMPLES), "a node tree with a circle")
            found = self._node(source)
            wants_color = source.socket.type in {"RGBA", "VECTOR"}
            self._known[key] = as_color(found) if wants_color else as_scalar(found)
        return self._known[key]

    def _own_value(self, socket):
        value = default_value(socket)
        if numpy.isfinite(value.value).all():
            return value
        words = not_finite(socket)
        if words not in self.not_finite:
            self.not_finite.append(words)
        return Const(numpy.nan_to_num(value.value, nan=0.0, posinf=0.0, neginf=0.0))

    def _unknown(self, source):
        node = source.node
        color = source.socket.type in {"RGBA", "VECTOR"}
        label = f"{node.bl_label} node"
        kind = node.type
        if kind in {"TEX_CHECKER", "TEX_BRICK"} and source.socket.name == "Color":
            first, second = self.color(source.input("Color1")), self.color(source.input("Color2"))
            if isinstance(first, Const) and isinstance(second, Const):
                picks = numpy.stack([first.value, second.value])[numpy.arange(SAMPLES) % 2]
                if kind == "TEX_BRICK":
                    mortar = self.color(source.input("Mortar"))
                    if isinstance(mortar, Const):
                        # The share of mortar of a brick of the node's own size.
                        width, height = self._constant(source, "Brick Width", 0.5), self._constant(source, "Row Height", 0.25)
                        size = self._constant(source, "Mortar Size", 0.02)
                        share = 1 - max(width - 2 * size, 0) * max(height - 2 * size, 0) / max(width * height, 1e-9)
                        picks[: round(SAMPLES * min(max(share, 0), 1))] = mortar.value
                return Unknown(picks, label)
        if kind in {"TEX_NOISE", "TEX_MUSGRAVE"}:
            grey = numpy.clip(_NOISE, 0, 1)
            return Unknown(numpy.repeat(grey[:, None], 3, axis=1) if color else grey, label)
        if kind in {"FRESNEL", "LAYER_WEIGHT"}:
            # Schlick's curve over the directions that a convex object shows: cos² uniform.
            cosine = numpy.sqrt(_UNIFORM)
            ior = self._constant(source, "IOR", 1.45)
            blend = self._constant(source, "Blend", 0.5)
            if kind == "LAYER_WEIGHT":
                ior = 1 / max(1 - blend, 1e-5)
            base = ((ior - 1) / (ior + 1)) ** 2
            curve = base + (1 - base) * (1 - cosine) ** 5
            if kind == "LAYER_WEIGHT" and source.socket.name == "Facing":
                exponent = 2 * blend if blend < 0.5 else 0.5 / max(1 - blend, 1e-5)
                curve = 1 - cosine**exponent if blend != 0.5 else 1 - cosine
            return Unknown(curve, label)
        if kind == "LIGHT_PATH":
            # What the light that falls on things sees; the camera's own view is told in the verdict.
            return Unknown(numpy.zeros(SAMPLES), label)
        return Unknown(_uniform_colors() if color else _UNIFORM, label)

    def _constant(self, source, name, otherwise):
        place = source.input(name)
        if place is None:
            return otherwise
        value = self.scalar(place)
        return float(value.value) if isinstance(value, Const) else otherwise

    def _node(self, source):
        node = source.node
        if node.mute:
            return Const(numpy.zeros(3)) if source.socket.type in {"RGBA", "VECTOR"} else Const(0.0)
        method = getattr(self, f"_node_{node.type.lower()}", None)
        found = method(source, node) if method else None
        return self._unknown(source) if found is None else found

    # Sources

    def _node_rgb(self, source, node):
        return self._own_value(source.socket)

    _node_value = _node_rgb

    def _node_tex_image(self, source, node):
        # Cycles shows a missing image in pink, and that of a node without one.
        texture = images.MISSING if node.image is None else self._texture_of(node, source)
        if texture is images.MISSING:
            return Const(images.MISSING) if source.socket.name == "Color" else Const(1.0)
        if source.socket.name == "Alpha" and node.image.alpha_mode == "NONE":
            return Const(1.0)
        return Image(texture, alpha=source.socket.name == "Alpha") if texture else None

    def _node_vertex_color(self, source, node):
        return Attribute(node.layer_name, alpha=source.socket.name == "Alpha")

    def _node_attribute(self, source, node):
        if node.attribute_type != "GEOMETRY" or not node.attribute_name or is_cycles_own(node.attribute_name):
            return None
        if source.socket.name in {"Color", "Vector"}:
            return Attribute(attribute_read(node))
        if source.socket.name == "Alpha":
            return Attribute(attribute_read(node), alpha=True)
        return as_scalar(Attribute(attribute_read(node)), vector=True)

    def _node_blackbody(self, source, node):
        temperature = self.scalar(source.input("Temperature"))
        return Const(blackbody.color(float(temperature.value))) if isinstance(temperature, Const) else None

    def _node_ambient_occlusion(self, source, node):
        # Taken as open everywhere, which is nearer to the truth than a mean: most of what is seen is.
        label = f"{node.bl_label} node, which is taken as open"
        if source.socket.name != "Color":
            return Unknown(numpy.ones(SAMPLES), label)
        return multiply(self.color(source.input("Color")), Unknown(numpy.ones((SAMPLES, 3)), label))

    # Operations

    def _node_invert(self, source, node):
        color, factor = self.color(source.input("Color")), self.scalar(source.input("Fac") or source.input("Factor"))
        return mix(factor, color, operation("invert", lambda c: 1 - c, [color], True))

    def _node_gamma(self, source, node):
        color, gamma = self.color(source.input("Color")), self.scalar(source.input("Gamma"))
        def power(c, g):
            return numpy.where(c > 0, _safe_power(numpy.maximum(c, 1e-30), numpy.asarray(g)[..., None]), c)
        return operation("gamma", power, [color, gamma], True)

    def _node_brightcontrast(self, source, node):
        color = self.color(source.input("Color"))
        # The sockets were renamed in 5.0.
        bright = self.scalar(source.input("Bright") or source.input("Brightness"))
        contrast = self.scalar(source.input("Contrast"))
        def adjust(c, b, k):
            b, k = numpy.asarray(b)[..., None], numpy.asarray(k)[..., None]
            return numpy.maximum((1 + k) * c + b - 0.5 * k, 0)
        return operation("brightness", adjust, [color, bright, contrast], True)

    def _node_hue_sat(self, source, node):
        inputs = [self.scalar(source.input(n)) for n in ("Hue", "Saturation", "Value")]
        factor = self.scalar(source.input("Fac") or source.input("Factor"))
        color = self.color(source.input("Color"))
        if isinstance(inputs[0], Const) and isinstance(inputs[1], Const):
            if inputs[0].value == 0.5 and inputs[1].value == 1 and isinstance(factor, Const) and factor.value == 1:
                return multiply(inputs[2], color)
        def adjust(h, s, v, c):
            hue, saturation, value = _hsv(c)
            return numpy.maximum(_from_hsv((hue + h + 0.5) % 1, numpy.clip(saturation * s, 0, 1), value * v), 0)
        return mix(factor, color, operation("hue and saturation", adjust, [*inputs, color], True))

    def _node_valtorgb(self, source, node):
        ramp = node.color_ramp
        table = numpy.array([list(ramp.evaluate(i / 1023)) for i in range(1024)])
        factor = self.scalar(source.input("Fac") or source.input("Factor"))
        steps = numpy.linspace(0, 1, 1024)
        label = f"ramp {hashlib.sha1(table.tobytes()).hexdigest()}"
        if source.socket.name == "Alpha":
            return operation(label + " alpha", lambda f: numpy.interp(f, steps, table[:, 3]), [factor], False)
        def look_up(f):
            return numpy.stack([numpy.interp(f, steps, table[:, k]) for k in range(3)], axis=-1)
        return operation(label, look_up, [factor], True)

    def _node_curve_rgb(self, source, node):
        mapping = node.mapping
        mapping.initialize()
        steps = numpy.linspace(0, 1, 257)
        tables = []
        for channel in range(3):
            combined = [mapping.evaluate(mapping.curves[3], float(x)) for x in steps]
            tables.append(numpy.array([mapping.evaluate(mapping.curves[channel], x) for x in combined]))
        color, factor = self.color(source.input("Color")), self.scalar(source.input("Fac") or source.input("Factor"))
        if isinstance(color, Const) and mapping.extend == "EXTRAPOLATED" and not (0 <= color.value.min() and color.value.max() <= 1):
            # The ends go on beyond these tables.
            return None
        def look_up(c):
            return numpy.stack([numpy.interp(c[..., k], steps, tables[k]) for k in range(3)], axis=-1)
        label = f"curves {[round(float(v), 6) for t in tables for v in t[::16]]}"
        return mix(factor, color, operation(label, look_up, [color], True))

    def _node_math(self, source, node):
        a, b, c = ([self.scalar(source.identified(i)) for i in ("Value", "Value_001", "Value_002")])
        kind = node.operation
        if kind == "MULTIPLY":
            result = multiply(a, b)
        elif kind in _MATH:
            result = operation(f"math {kind}", _MATH[kind], [a, b, c], False)
        else:
            return None
        return self._clamped(result) if node.use_clamp else result

    def _clamped(self, value):
        if isinstance(value, Image):
            return value
        return operation("clamp", lambda v: numpy.clip(v, 0, 1), [value], value.is_color)

    def _node_vect_math(self, source, node):
        simple = {
            "ADD": lambda a, b: a + b,
            "SUBTRACT": lambda a, b: a - b,
            "DIVIDE": _safe_divide,
            "MINIMUM": numpy.minimum,
            "MAXIMUM": numpy.maximum,
        }
        of_one = {"ABSOLUTE": numpy.abs, "FLOOR": numpy.floor, "CEIL": numpy.ceil, "FRACTION": lambda a: a - numpy.floor(a)}
        a, b = self.color(source.identified("Vector")), self.color(source.identified("Vector_001"))
        if node.operation in of_one:
            return operation(f"vector {node.operation}", of_one[node.operation], [a], True)
        if node.operation == "MULTIPLY_ADD":
            arguments = [multiply(a, b), self.color(source.identified("Vector_002"))]
            return operation("vector ADD", simple["ADD"], arguments, True)
        if node.operation == "MULTIPLY":
            return multiply(a, b)
        if node.operation == "SCALE":
            return multiply(a, self.scalar(source.input("Scale")))
        if node.operation in simple:
            return operation(f"vector {node.operation}", simple[node.operation], [a, b], True)
        return None

    def _node_mix(self, source, node):
        kind = node.data_type
        if kind == "RGBA":
            a, b = (self.color(source.identified(i)) for i in ("A_Color", "B_Color"))
        elif kind == "VECTOR":
            a, b = (self.color(source.identified(i)) for i in ("A_Vector", "B_Vector"))
        elif kind == "FLOAT":
            a, b = (self.scalar(source.identified(i)) for i in ("A_Float", "B_Float"))
        else:
            return None
        if kind == "VECTOR" and node.factor_mode == "NON_UNIFORM":
            factor = self.color(source.identified("Factor_Vector"))
        else:
            factor = self.scalar(source.identified("Factor_Float"))
        if node.clamp_factor:
            factor = self._clamped(factor)
        blend = node.blend_type if kind == "RGBA" else "MIX"
        result = self._blend(blend, factor, a, b)
        return self._clamped(result) if result is not None and kind == "RGBA" and node.clamp_result else result

    def _node_mix_rgb(self, source, node):
        a, b = self.color(source.input("Color1")), self.color(source.input("Color2"))
        result = self._blend(node.blend_type, self._clamped(self.scalar(source.input("Fac"))), a, b)
        return self._clamped(result) if result is not None and node.use_clamp else result

    def _blend(self, kind, factor, a, b):
        if kind == "MULTIPLY":
            return mix(factor, a, multiply(a, b))
        if kind not in _BLEND:
            return None
        blended = b if kind == "MIX" else operation(f"blend {kind}", _BLEND[kind], [a, b], a.is_color)
        return mix(factor, a, blended)

    def _node_clamp(self, source, node):
        arguments = [self.scalar(source.input(n)) for n in ("Value", "Min", "Max")]
        if node.clamp_type == "RANGE":
            clamp = lambda v, a, b: numpy.clip(v, numpy.minimum(a, b), numpy.maximum(a, b))
        else:
            clamp = lambda v, a, b: numpy.minimum(numpy.maximum(v, a), b)
        return operation(f"clamp {node.clamp_type}", clamp, arguments, False)

    def _node_map_range(self, source, node):
        if node.data_type != "FLOAT" or node.interpolation_type not in {"LINEAR", "SMOOTHSTEP"}:
            return None
        arguments = [self.scalar(source.input(n)) for n in ("Value", "From Min", "From Max", "To Min", "To Max")]
        smooth, limit = node.interpolation_type == "SMOOTHSTEP", node.clamp
        def map_range(v, a, b, c, d):
            if smooth:
                t = _smoothstep(a, b, v)
            else:
                t = _safe_divide(v - a, b - a)
            result = c + t * (d - c)
            return numpy.clip(result, numpy.minimum(c, d), numpy.maximum(c, d)) if limit and not smooth else result
        return operation(f"map range {smooth} {limit}", map_range, arguments, False)

    def _node_rgbtobw(self, source, node):
        return as_scalar(self.color(source.input("Color")))

    def _node_separate_color(self, source, node):
        color = self.color(source.input("Color"))
        index = [s.identifier for s in node.outputs].index(source.socket.identifier)
        if getattr(node, "mode", "RGB") == "RGB":
            return component(color, index)
        if node.mode == "HSV":
            return operation(f"hsv {index}", lambda c: _hsv(c)[index], [color], False)
        return None

    def _node_seprgb(self, source, node):
        index = [s.identifier for s in node.outputs].index(source.socket.identifier)
        return component(self.color(source.input("Image")), index)

    def _node_sepxyz(self, source, node):
        index = [s.identifier for s in node.outputs].index(source.socket.identifier)
        return component(self.color(source.input("Vector")), index)

    def _node_combine_color(self, source, node):
        parts = [self.scalar(Place(s, source.groups)) for s in node.inputs]
        mode = getattr(node, "mode", "RGB")
        if mode == "RGB":
            return self._combined(parts)
        if mode == "HSV":
            return operation("from hsv", _from_hsv, parts, True)
        return None

    def _node_combrgb(self, source, node):
        return self._combined([self.scalar(Place(s, source.groups)) for s in node.inputs])

    _node_combxyz = _node_combrgb

    def _combined(self, parts):
        # Taken apart and put together again: the same colour.
        inner = [p.arguments[0] for p in parts if isinstance(p, expressions.Operation) and p.name.startswith("component")]
        names = [p.name for p in parts if isinstance(p, expressions.Operation)]
        if names == ["component 0", "component 1", "component 2"] and len({i.digest() for i in inner}) == 1:
            return inner[0]
        def stack(r, g, b):
            return numpy.stack(numpy.broadcast_arrays(r, g, b), axis=-1)
        return operation("combine", stack, parts, True)
