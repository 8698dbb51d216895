# SPDX-License-Identifier: GPL-3.0-or-later
"""What fills meshes and space: what is the same everywhere as coefficients by metre, the rest as node trees. Cycles' formulas:
docs/cycles.md."""

import numpy

from . import blackbody, evaluated, graph_write, nodes, stand_ins
from .expressions import Const
from .verdicts import LOST

# Cycles' limit of a mean cosine.
MOST_ANISOTROPY = 0.999


# Inputs of a Volume Scatter that count, by the property of its phase function.
SOCKETS_OF_PHASES = {
    "HENYEY_GREENSTEIN": ("Anisotropy",),
    "RAYLEIGH": (),
    "DRAINE": ("Anisotropy", "Alpha"),
    "FOURNIER_FORAND": ("IOR", "Backscatter"),
    "MIE": ("Diameter",),
}


class _Varies(Exception):
    """Something is not the same everywhere, or has no counterpart."""


class Varying:
    """A volume that is told by its node tree; `label` is its shader's."""

    def __init__(self, label, why):
        self.label, self.why = label, why

    def described(self, owner, reader, place, layer=None):
        """(the `volume` of SUNDOG_material, its graph_write.Written); None for both, with a finding, where it is left out.
        `place`: the document, the cache, and what objects are asked for."""
        document, cache, values = place
        table = evaluated.VOLUME if layer is not None else evaluated.VOLUME_OF_WORLD
        if reader.grids is not None:
            table = evaluated.VOLUME_OF_GRIDS
        written, why = graph_write.filling(owner, table, document, cache, (values, reader.grids), layer)
        if written is None:
            reader.note_lasting(LOST, f"the volume ({self.label}) is left out: {why or self.why}", "media")
            return None, None
        for finding in written.findings:
            reader.note_lasting(*finding)
        return {"graph": written.extension}, written


def read(reader, place):
    """The `volume` of SUNDOG_material; a Varying for what is told by its node tree; None for none."""
    source = reader.walker.source(place)
    if not nodes.is_fed(source.socket):
        return None
    if reader.grids is not None:
        return Varying(source.node.bl_label, "it cannot be told with its grids")
    before = list(reader.findings), list(reader.lasting)
    try:
        found = _Sum(reader)
        found.add(source, 1.0)
    except _Varies as why:
        # They are of what its numbers would have been.
        reader.findings, reader.lasting = before
        return Varying(source.node.bl_label, str(why))
    return found.described()


class _Sum:
    """The sum of all shaders of a volume."""

    def __init__(self, reader):
        self.reader = reader
        self.absorption, self.emission = numpy.zeros(3), numpy.zeros(3)
        self.scatterers = []

    def described(self):
        """The extension; None where there is nothing."""
        described = {}
        # Light may be less than nothing, in Cycles too.
        for name, value in (("absorption", numpy.maximum(self.absorption, 0)), ("emission", self.emission)):
            if value.any():
                described[name] = [float(v) for v in value]
        if self.scatterers:
            described["scatterers"] = self.scatterers
        return described or None

    def add(self, source, weight):
        """Adds the shader at an output."""
        if weight == 0 or not nodes.is_fed(source.socket):
            return
        node = source.node
        if source.socket.type != "SHADER":
            self.emission += weight * self._constant(self.reader.evaluator.color(source))
            return
        if node.type not in nodes.FILLING:
            return
        getattr(self, f"_{node.type.lower()}")(source, weight)

    @staticmethod
    def _constant(value):
        if not isinstance(value, Const):
            raise _Varies("it is not the same everywhere")
        return numpy.asarray(value.value, float)

    def _color(self, source, name):
        return self._constant(self.reader._color(source, name))[..., :3] * numpy.ones(3)

    def _number(self, source, name, otherwise=0.0):
        return float(self._constant(self.reader._scalar(source, name, Const(otherwise))))

    def _density(self, source, weight):
        return max(self._number(source, "Density"), 0.0) * weight

    def _scatter(self, source, coefficient, phase="HENYEY_GREENSTEIN"):
        coefficient = [max(float(v), 0.0) for v in coefficient]
        if not any(coefficient):
            return
        described = {"coefficient": coefficient}
        if phase != "HENYEY_GREENSTEIN":
            described["phase"] = phase.lower().replace("_", "-")
        for name in SOCKETS_OF_PHASES[phase]:
            described[name.lower()] = self._number(source, name)
        if "anisotropy" in described:
            described["anisotropy"] = min(max(described["anisotropy"], -MOST_ANISOTROPY), MOST_ANISOTROPY)
        self.scatterers.append(described)

    def _linked(self, source, socket):
        return self.reader.walker.source(nodes.Place(socket, source.groups))

    def _mix_shader(self, source, weight):
        share = min(max(float(self._constant(self.reader.evaluator.scalar(nodes.Place(source.node.inputs[0], source.groups)))), 0.0), 1.0)
        self.add(self._linked(source, source.node.inputs[1]), weight * (1 - share))
        self.add(self._linked(source, source.node.inputs[2]), weight * share)

    def _add_shader(self, source, weight):
        for socket in source.node.inputs:
            self.add(self._linked(source, socket), weight)

    def _emission(self, source, weight):
        self.emission += weight * self._color(source, "Color") * self._number(source, "Strength")

    def _volume_absorption(self, source, weight):
        self.absorption += (1 - self._color(source, "Color")) * self._density(source, weight)

    def _volume_scatter(self, source, weight):
        phase = getattr(source.node, "phase", "HENYEY_GREENSTEIN")
        self._scatter(source, self._color(source, "Color") * self._density(source, weight), phase)

    def _volume_coefficients(self, source, weight):
        self.absorption += weight * self._color(source, "Absorption Coefficients")
        self.emission += weight * self._color(source, "Emission Coefficients")
        self._scatter(source, weight * self._color(source, "Scatter Coefficients"), source.node.phase)

    def _principled_volume(self, source, weight):
        density = self._density(source, weight)
        color = numpy.maximum(self._color(source, "Color"), 0)
        clear = numpy.sqrt(numpy.maximum(self._color(source, "Absorption Color"), 0))
        self.absorption += numpy.maximum(1 - color, 0) * numpy.maximum(1 - clear, 0) * density
        self._scatter(source, color * density)
        share = self._number(source, "Blackbody Intensity")
        if share > 0:
            temperature = max(self._number(source, "Temperature", 1000.0), 0.0)
            strength = stand_ins.STEFAN_BOLTZMANN * (1 - share + share * temperature**4)
            self.emission += weight * strength * self._color(source, "Blackbody Tint") * numpy.asarray(blackbody.color(temperature))[:3]
        # Here alone Cycles leaves out what is below nothing.
        self.emission += weight * self._color(source, "Emission Color") * max(self._number(source, "Emission Strength"), 0.0)
