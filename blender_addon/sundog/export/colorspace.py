# SPDX-License-Identifier: GPL-3.0-or-later
"""The working space: the linear space that the numbers of a .blend are in, and in which Cycles renders."""

import os
import re

import bpy
import numpy

REC709 = "Linear Rec.709"

_D65 = (0.3127, 0.3290)
# CIE 1931 chromaticities of red, green, blue and white: ITU-R BT.709 and BT.2020, and AP1 of S-2014-004.
_PRIMARIES = {
    REC709: ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06), _D65),
    "Linear Rec.2020": ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046), _D65),
    "ACEScg": ((0.713, 0.293), (0.165, 0.830), (0.128, 0.044), (0.32168, 0.33767)),
}
# The names that the Color Interop Forum gave them.
_INTEROP = {"lin_rec709_scene": REC709, "lin_rec2020_scene": "Linear Rec.2020", "lin_ap1_scene": "ACEScg"}
# What configurations that are not Blender's own call them.
_OTHER_NAMES = {
    **_INTEROP, "linear bt.709": REC709, "linear rec.709 (srgb)": REC709, "lin_rec709": REC709, "lin_srgb": REC709, "linear": REC709,
    "utility - linear - srgb": REC709, "utility - linear - rec.709": REC709, "linear bt.2020": "Linear Rec.2020",
    "lin_rec2020": "Linear Rec.2020", "utility - linear - rec.2020": "Linear Rec.2020", "aces - acescg": "ACEScg", "lin_ap1": "ACEScg",
    "acescg": "ACEScg", "linear rec.709": REC709, "linear rec.2020": "Linear Rec.2020",
}  # fmt: skip
# The cone responses of Bradford's adaptation, which brings ACEScg to D65 in Blender's configuration.
_BRADFORD = numpy.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])


def _to_xyz(name):
    """CIE XYZ of an amount of each primary, adapted to D65."""
    *primaries, white = [numpy.array([x / y, 1, (1 - x - y) / y]) for x, y in _PRIMARIES[name]]
    columns = numpy.stack(primaries, axis=1)
    own = columns * numpy.linalg.solve(columns, white)
    d65 = numpy.array([_D65[0] / _D65[1], 1, (1 - sum(_D65)) / _D65[1]])
    ratio = (_BRADFORD @ d65) / (_BRADFORD @ white)
    return numpy.linalg.solve(_BRADFORD, ratio[:, None] * _BRADFORD) @ own


_XYZ = {name: _to_xyz(name) for name in _PRIMARIES}

# What a configuration that $OCIO names calls its scene_linear space, by the file and its time.
_roles = {}


def _own_name():
    """(what Blender calls the working space, the name by which it is known or None)."""
    data = getattr(bpy.data, "colorspace", None)
    if data is not None:
        name = data.working_space
        interop = getattr(data, "working_space_interop_id", "")
        return name, _INTEROP.get(interop) or _OTHER_NAMES.get(name.lower())
    config = os.environ.get("OCIO")
    if not config or not os.path.isfile(config):
        return REC709, REC709
    key = (config, os.stat(config).st_mtime_ns)
    if key not in _roles:
        with open(config, encoding="utf-8", errors="replace") as file:
            found = re.search(r"^\s+scene_linear:\s*(.+?)\s*$", file.read(), re.MULTILINE)
        _roles[key] = found.group(1).strip("\"'") if found else REC709
    return _roles[key], _OTHER_NAMES.get(_roles[key].lower())


def working_space():
    """The name of the working space as SUNDOG_scene has it. One that is not known is taken for linear Rec.709."""
    return _own_name()[1] or REC709


def unknown():
    """The name of a working space that is not known, or None."""
    name, known = _own_name()
    return None if known else name


def from_rec709(values):
    """Linear Rec.709 in the last axis as numbers of the working space."""
    return convert(values, REC709)


def convert(values, name):
    """Numbers of the linear space of that name, one of `LINEAR`, as those of the working space."""
    here = working_space()
    if here == name:
        return values
    return (values @ numpy.linalg.solve(_XYZ[here], _XYZ[name]).T).astype(numpy.asarray(values).dtype)


# The linear spaces that `convert` knows.
LINEAR = set(_PRIMARIES)


def luminance():
    """The weights of the working space's numbers in luminance, as Cycles has them."""
    return _XYZ[working_space()][1]


def from_xyz(values):
    """CIE XYZ in the last axis as numbers of the working space."""
    return values @ numpy.linalg.inv(_XYZ[working_space()]).T
