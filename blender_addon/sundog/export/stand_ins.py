# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes of SUNDOG_shader_graph that stand for others: what makes them, as entries with numbers."""

import functools
import math

import numpy

from . import blackbody, colorspace, wavelength

# Of a black body, over π, as Cycles scales it: W·m⁻²·K⁻⁴.
STEFAN_BOLTZMANN = 5.670373e-8 * 1e-6 / math.pi

# As Cycles tabulates ramps and curves (from 4.4 on): so many entries, the last one at the end of the range.
TABLE_SIZE = 257
# Entries of the black body's colours, so that lines between them are within 2e-5 of its curves.
BLACKBODY_SIZE = 2049


def in_other_words(use, inputs, grids=None):
    """Of a node that others stand for: what makes these, given the number of the first, and the output of the last; or None."""
    kind = use.node.bl_idname
    if kind == "ShaderNodeVolumePrincipled":
        return lambda first: (_principled_volume(use, inputs, grids, first), "Volume")
    if kind == "ShaderNodeBlackbody":
        return lambda first: (_blackbody(inputs["Temperature"], first), "Color")
    if kind == "ShaderNodeWavelength":
        return lambda first: (_wavelength(inputs["Wavelength"], first), "Result_Color")
    if kind == "ShaderNodeNormal":
        return lambda first: (_product(use.node, inputs, first), "Value")
    return None


def _maths(operation, first, second):
    return {"type": "ShaderNodeMath", "properties": {"operation": operation}, "inputs": {"Value": first, "Value_001": second}}


def _ramp_of(colors, factor):
    ramp = {"interpolation": "LINEAR", "table": table([[*c, 1.0] for c in colors])}
    return {"type": "ShaderNodeValToRGB", "properties": {"color_ramp": ramp}, "inputs": {"Fac": factor}}


def _blackbody(temperature, first):
    """A ramp of the temperature's reciprocal, between those of its ends."""
    cold, hot = 1 / blackbody.COLDEST, 1 / blackbody.HOTTEST
    least = 0.5 * blackbody.COLDEST
    out = [{"node": first + i, "output": "Value"} for i in range(4)]
    return [
        _maths("MAXIMUM", temperature, least),
        _maths("DIVIDE", 1.0, out[0]),
        _maths("SUBTRACT", out[1], hot),
        _maths("DIVIDE", out[2], cold - hot),
        _ramp_of(_blackbody_colors(colorspace.working_space()), out[3]),
    ]


@functools.cache
def _blackbody_colors(_space):
    """Evenly spread in the temperature's reciprocal, in a working space; the last one is that of all that is colder."""
    steps = numpy.linspace(1 / blackbody.HOTTEST, 1 / blackbody.COLDEST, BLACKBODY_SIZE)
    return [blackbody.color(1 / t) for t in steps[:-1]] + [blackbody.color(0.0)]


def _wavelength(nanometres, first):
    out = [{"node": first + i, "output": "Value"} for i in range(2)]
    ramp = {"node": first + 2, "output": "Color"}
    seen = {"node": first + 3, "output": "Value"}
    black = [0.0, 0.0, 0.0, 1.0]
    lighter = {
        "type": "ShaderNodeMix",
        "properties": {"data_type": "RGBA", "blend_type": "LIGHTEN", "clamp_factor": True, "clamp_result": False},
        "inputs": {"Factor_Float": seen, "A_Color": black, "B_Color": ramp},
    }
    span = wavelength.LAST - wavelength.FIRST
    return [
        _maths("SUBTRACT", nanometres, wavelength.FIRST),
        _maths("DIVIDE", out[0], span),
        _ramp_of(wavelength.colors(), out[1]),
        # What is shorter is black; what is longer has the last colour, which is.
        _maths("GREATER_THAN", nanometres, wavelength.FIRST - wavelength.STEP),
        lighter,
    ]


def _vector_maths(operation, **inputs):
    return {"type": "ShaderNodeVectorMath", "properties": {"operation": operation}, "inputs": inputs}


def _principled_volume(use, inputs, grids, first):
    """A Principled Volume: its density, colour and temperature multiplied with the object's grids, and light of a temperature
    (Cycles' svm_node_principled_volume) among its emission."""
    node, nodes, inputs = use.node, [], dict(inputs)

    def add(entry, output="Value"):
        nodes.append(entry)
        return {"node": first + len(nodes) - 1, "output": output}

    def grid(name, output, kind, drawn=False):
        value = grids.value(name, kind, 1.0, drawn)
        return add({"type": "ShaderNodeAttribute", "properties": {"values": {output: value}}}, output)

    def is_there(name):
        return grids is not None and name in grids.names

    names = {socket.identifier: socket.default_value for socket in node.inputs if socket.type == "STRING"}
    density, color, temperature = (names.get(f"{what} Attribute", "") for what in ("Density", "Color", "Temperature"))
    if is_there(density):
        inputs["Density"] = add(_maths("MULTIPLY", inputs.get("Density", 1.0), grid(density, "Fac", "vector")))
    if is_there(color):
        plain = _plain_color(inputs.get("Color", [0.5, 0.5, 0.5]))
        inputs["Color"] = add(_vector_maths("MULTIPLY", Vector=plain, Vector_001=grid(color, "Vector", "vector")), "Vector")
    share = inputs.get("Blackbody Intensity", 0.0)
    if isinstance(share, dict) or share > 0:
        heat = inputs.get("Temperature", 1000.0)
        if is_there(temperature):
            found = add(_maths("MAXIMUM", grid(temperature, "Fac", "vector", drawn=True), 0.0))
            heat = add(_maths("MULTIPLY", heat, found))
        heat = add(_maths("MAXIMUM", heat, 0.0))
        square = add(_maths("MULTIPLY", heat, heat))
        fourth = add(_maths("MULTIPLY", square, square))
        more = add(_maths("MULTIPLY", add(_maths("SUBTRACT", fourth, 1.0)), share))
        strength = add(_maths("MULTIPLY", add(_maths("ADD", more, 1.0)), STEFAN_BOLTZMANN))
        nodes += _blackbody(heat, first + len(nodes))
        glow = {"node": first + len(nodes) - 1, "output": "Color"}
        tinted = add(_vector_maths("MULTIPLY", Vector=glow, Vector_001=_plain_color(inputs.get("Blackbody Tint", [1.0, 1.0, 1.0]))), "Vector")
        light = add(_vector_maths("SCALE", Vector=tinted, Scale=strength), "Vector")
        own = _plain_color(inputs.get("Emission Color", [1.0, 1.0, 1.0]))
        emitted = add(_vector_maths("SCALE", Vector=own, Scale=inputs.get("Emission Strength", 0.0)), "Vector")
        inputs["Emission Color"] = add(_vector_maths("ADD", Vector=emitted, Vector_001=light), "Vector")
        inputs["Emission Strength"] = 1.0
    left = {"Blackbody Intensity", "Blackbody Tint", "Temperature", *names}
    kept = {name: v for name, v in inputs.items() if name not in left}
    entry = {"type": node.bl_idname, "inputs": kept}
    if node.name:
        entry["name"] = node.name
    nodes.append(entry)
    return nodes


def _plain_color(value):
    """Without the alpha."""
    return value[:3] if isinstance(value, list) else value


def _product(node, inputs, first):
    """The Normal node's Dot."""
    direction = numpy.array(node.outputs["Normal"].default_value)
    direction = direction / max(numpy.linalg.norm(direction), 1e-30)
    vector = inputs.get("Normal", [0.0, 0.0, 0.0])
    unit = {"type": "ShaderNodeVectorMath", "properties": {"operation": "NORMALIZE"}, "inputs": {"Vector": vector}}
    both = {"Vector": {"node": first, "output": "Vector"}, "Vector_001": short(tuple(map(float, direction)))}
    return [unit, {"type": "ShaderNodeVectorMath", "properties": {"operation": "DOT_PRODUCT"}, "inputs": both}]


def table(rows):
    values = numpy.nan_to_num(numpy.array([list(r) for r in rows], numpy.float32))
    return [[float(str(v)) for v in row] for row in values]


def short(value):
    """Numbers with as many digits as tell them apart from other floats of 32 bits."""
    if isinstance(value, tuple):
        return [short(v) for v in value]
    number = float(str(numpy.float32(value)))
    return int(number) if number.is_integer() and abs(number) < 1e9 else number
