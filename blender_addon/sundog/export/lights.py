# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights, in Blender's watts: KHR_lights_punctual with SUNDOG_light, and area lights on nodes."""

import math

import numpy

from . import evaluated, expressions, graph, graph_write, ies, images, nodes, visibility
from .expressions import Const, multiply
from .verdicts import APPROXIMATED, EXACT, LOST

# The exporter's lumens for a watt, for readers that do not know SUNDOG_light.
LUMENS_PER_WATT = 683.0


def _color(light):
    """Linear colour of a light without its energy and its nodes."""
    color = numpy.array(list(light.color), float)
    if getattr(light, "use_temperature", False):
        color = color * numpy.array(list(light.temperature_color), float)
    return color


def _with_nodes(light, findings, document, cache, lamp):
    """(what the light's node tree multiplies its strength with, None); or (1, the tree) where it varies and is evaluated."""
    if nodes.tree_of(light) is None:
        return numpy.ones(3), None
    own = []
    factor = _node_factor(light, own)
    if all(verdict == EXACT for verdict, _ in own) or document is None or not graph.ENABLED:
        findings += own
        return factor, None
    written, why_not = graph_write.emitting(light, evaluated.LIGHT, document, cache, findings, lamp=lamp)
    if written is not None:
        return numpy.ones(3), written
    findings += own
    if why_not:
        findings.append((EXACT, f"its nodes are not evaluated as they are because of: {why_not}"))
    return factor, None


def _node_factor(light, findings):
    """What the light's node tree multiplies its strength with; its mean where it varies."""
    output = nodes.output_of(light)
    walker = nodes.Walker()
    source = output and walker.source(nodes.Place(output.inputs["Surface"]))
    if not output or not nodes.is_fed(source.socket):
        return numpy.zeros(3)
    if source.node.type != "EMISSION":
        findings.append((LOST, f"its {source.node.bl_label} node is left out: the light shines by its own settings"))
        return numpy.ones(3)
    evaluator = _LightEvaluator(walker, light)
    color, strength = evaluator.color(source.input("Color")), evaluator.scalar(source.input("Strength"))
    for value, what in ((color, "colour"), (strength, "strength")):
        if not isinstance(value, Const):
            varying = ", ".join(sorted({leaf.what for leaf in value.leaves() if hasattr(leaf, "what")}))
            findings.append((APPROXIMATED, f"the {what} of its nodes varies ({varying}): the mean is used"))
    findings += [(APPROXIMATED, note) for note in sorted(evaluator.notes)] + [(EXACT, note) for note in sorted(evaluator.told)]
    return expressions.mean(color).value * float(expressions.mean(strength).value)


class _LightEvaluator(nodes.Evaluator):
    """What a lamp's nodes are on its axis, one metre away. `notes`: what is not so everywhere; `told`: what is odd, but exact."""

    def __init__(self, walker, light):
        super().__init__(walker, lambda node, place: None)
        self.light, self.notes, self.told = light, set(), set()

    def _taken(self, node, what="its value on the lamp's axis one metre away is used"):
        self.notes.add(f"the {node.bl_label} node varies: {what}")

    def _node_light_falloff(self, source, node):
        # "Quadratic" is the physical one, and passes the strength on unless it is smoothed.
        smooth, strength = self.scalar(source.input("Smooth")), self.scalar(source.input("Strength"))
        if not isinstance(smooth, Const):
            return None
        if smooth.value != 0 or source.socket.name != "Quadratic":
            self._taken(node)
        # Cycles: r² / (smooth + r²), and times r or r² for the linear and the constant one.
        return multiply(strength, Const(1 / (1 + max(float(smooth.value), 0.0))))

    def _node_tex_ies(self, source, node):
        text = ies.text_of(node)
        profile = ies.parse(text) if text else None
        if profile is None:
            self.told.add(ies.broken(node))
            return multiply(Const(ies.OF_NO_FILE), self.scalar(source.input("Strength")))
        kind = self.light.type
        half, where = {
            "POINT": (math.pi, "all directions"),
            "SPOT": (min(float(getattr(self.light, "spot_size", 0.0)) / 2, math.pi), "its cone"),
            "AREA": (math.pi / 2, "the side to which it shines"),
        }.get(kind, (0.0, "its axis"))
        self._taken(node, f"its mean over {where} is used")
        return multiply(Const(ies.within(profile, half)), self.scalar(source.input("Strength")))

    def _node_light_path(self, source, node):
        if source.socket.name != "Ray Length":
            return None
        self._taken(node)
        return Const(1.0)

    def _node_tex_coord(self, source, node):
        if source.socket.name != "Normal":
            return None
        self._taken(node)
        return Const([0.0, 0.0, -1.0])

    def _node_vect_math(self, source, node):
        found = super()._node_vect_math(source, node)
        if found is not None:
            return found
        a, b = self.color(source.identified("Vector")), self.color(source.identified("Vector_001"))
        if not (isinstance(a, Const) and isinstance(b, Const)):
            return None
        a, b = a.value, b.value
        length = float(numpy.linalg.norm(a))
        known = {
            "DOT_PRODUCT": lambda: float(a @ b),
            "CROSS_PRODUCT": lambda: numpy.cross(a, b),
            "LENGTH": lambda: length,
            "DISTANCE": lambda: float(numpy.linalg.norm(a - b)),
            "NORMALIZE": lambda: a / length if length > 0 else a,
        }
        return Const(known[node.operation]()) if node.operation in known else None


def energy(light):
    """Watts (suns: W/m²), with the exposure of 4.5 and later."""
    return float(light.energy) * 2.0 ** float(getattr(light, "exposure", 0.0))


def is_portal(light):
    """Whether it shines with nothing of its own: an opening through which the world is looked for."""
    cycles = getattr(light, "cycles", None)
    return light.type == "AREA" and bool(getattr(cycles, "is_portal", False))


def describe_portal(light, name):
    """The SUNDOG_light object of a portal, which changes the noise alone."""
    return {"type": "portal", "name": name, **_outline(light)}


def _outline(light):
    """Shape and size of an area light."""
    square = light.shape in {"SQUARE", "DISK"}
    return {
        "shape": "ellipse" if light.shape in {"DISK", "ELLIPSE"} else "rectangle",
        "size": [float(light.size), float(light.size if square else light.size_y)],
    }


def casts_shadow(light):
    """Blender's Shadow switch of lights."""
    cycles = getattr(light, "cycles", None)
    return bool(getattr(cycles, "cast_shadow", True)) and bool(getattr(light, "use_shadow", True))


def describe(light, findings, document=None, cache=None, lamp=None):
    """The SUNDOG_light object of a light, without visibility; see docs/gltf-extensions.md. Images of its nodes become the
    document's; without one the nodes' means count. `lamp`: the object_info.Lamp of its object."""
    factor, tree = _with_nodes(light, findings, document, cache, lamp)
    color, watts = _color(light) * factor, energy(light)
    normalized = bool(getattr(light, "normalize", True))
    result = {}
    if tree is not None:
        result["shader_graph"] = tree
    if light.type in {"POINT", "SPOT"}:
        radius = float(light.shadow_soft_size)
        # Cycles: radiance P / (4 π² r²), and P / π where the light is not normalised.
        if normalized:
            intensity = watts / (4 * math.pi)
        else:
            intensity = watts * radius**2 if radius > 0 else watts / math.pi
        result["strength"] = _list(color * intensity)
        result["radius"] = radius
        result["soft_falloff"] = bool(getattr(light, "use_soft_falloff", False))
        if light.type == "SPOT":
            result["blend"] = float(light.spot_blend)
            result["half_angle"] = float(light.spot_size) / 2
    elif light.type == "SUN":
        angle = float(light.angle)
        irradiance = watts
        if not normalized and angle > 0:
            irradiance *= math.pi * math.sin(angle / 2) ** 2
        result["strength"] = _list(color * irradiance)
        result["angle"] = angle
    else:
        result["type"] = "area"
        result["strength"] = _list(color)
        result["power"] = watts
        result["normalize"] = normalized
        result.update(_outline(light))
        result["spread"] = float(getattr(light, "spread", math.pi))
    cycles = getattr(light, "cycles", None)
    if cycles is not None:
        result["max_bounces"] = int(getattr(cycles, "max_bounces", 1024))
        result["mis"] = bool(getattr(cycles, "use_multiple_importance_sampling", True))
    return result


def _list(values):
    return [float(v) for v in values]


# Cosine of the angle of an area light's edges from which on it counts as sheared: what f32 matrices leave is far below.
SHEAR = 1e-4


def is_sheared(matrix):
    """Whether a world matrix turns the square of an area light into a parallelogram."""
    x, y = (numpy.array(matrix.col[i][:3], float) for i in (0, 1))
    lengths = numpy.linalg.norm(x) * numpy.linalg.norm(y)
    return bool(lengths > 0 and abs(x @ y) > SHEAR * lengths)


# What planes of lamps may be off each other to be one in f32, as a share of their distances from the origin.
SAME_PLANE = 1e-6


class Planes:
    """Area lights by the planes that they lie in."""

    def __init__(self):
        self._lamps = []

    def add(self, described, matrix):
        """Takes an area light; whether it overlaps one before it in the same plane, and rounding decides which of both rays find."""
        if not described.get("mis", True):
            return False
        place = numpy.array(matrix, float)
        x, y = (0.5 * size * place[:3, axis] for axis, size in enumerate(described["size"]))
        lamp = (place[:3, 3], x, y)
        overlaps = any(_overlap(lamp, other) and _overlap(other, lamp) for other in self._lamps)
        self._lamps.append(lamp)
        # Where the normal has no part along some axis, the program rounds as Cycles does.
        normal = abs(place[:3, 2])
        return overlaps and normal.min() > SAME_PLANE * normal.max()


def _overlap(lamp, other):
    """Whether another lamp lies in a lamp's plane, and its box along the lamp's edges overlaps it."""
    (middle, x, y), (at, *edges) = lamp, other
    normal = numpy.cross(x, y)
    size = numpy.linalg.norm(normal)
    if size == 0:
        return False
    reach = SAME_PLANE * max(abs(middle).max(), abs(at).max(), 1e-3)
    corners = [at + a * edges[0] + b * edges[1] for a in (-1, 1) for b in (-1, 1)]
    if any(abs((corner - middle) @ normal) > reach * size for corner in corners):
        return False
    for edge in (x, y):
        along = [(corner - middle) @ edge / (edge @ edge) for corner in corners]
        if min(along) >= 1 or max(along) <= -1:
            return False
    return True


def ray_visibility(light, instance_objects):
    """The visibility object of a light that these objects place."""
    seen = visibility.of_objects(instance_objects)
    if not casts_shadow(light):
        seen["shadow"] = False
    else:
        seen.pop("shadow", None)
    return seen


def punctual(light, described):
    """The KHR_lights_punctual light that other readers show."""
    strength = described["strength"]
    brightest = max(strength)
    factor = 1 / brightest if brightest > 0 else 0.0
    kind = {"POINT": "point", "SPOT": "spot", "SUN": "directional"}[light.type]
    result = {
        "type": kind,
        "color": [min(max(v * factor, 0.0), 1.0) for v in strength],
        "intensity": max(brightest, 0.0) * LUMENS_PER_WATT,
        "name": light.name,
    }
    if kind == "spot":
        outer = min(described["half_angle"], math.pi / 2)
        result["spot"] = {
            "outerConeAngle": outer,
            "innerConeAngle": min(outer * (1 - described["blend"]), max(outer - 1e-6, 0.0)),
        }
    return result
