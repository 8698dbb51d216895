# SPDX-License-Identifier: GPL-3.0-or-later
"""What IES files (ANSI/IES LM-63) say of a lamp: candela by direction."""

import os

import bpy
import numpy

# Cycles takes a luminous efficacy of 177.83 lm/W (that of D65) and a lamp's strength for 4 pi times its intensity.
WATTS_PER_CANDELA = 4 * numpy.pi / 177.83


# What Cycles gives in all directions where there is no file, or one that it cannot read.
OF_NO_FILE = 100.0


def broken(node):
    """That a node has no file, in words."""
    return f"the file of the {node.bl_label} node is missing or broken: {OF_NO_FILE:g} in all directions, as in Cycles"


def text_of(node):
    """The text that an IES Texture node shows, or None."""
    if node.mode == "INTERNAL":
        return node.ies.as_string() if node.ies is not None else None
    path = bpy.path.abspath(node.filepath, library=node.id_data.library)
    if not os.path.isfile(path):
        return None
    with open(path, encoding="latin-1") as file:
        return file.read()


def _read(text):
    """(photometric type 1 to 3, vertical angles, horizontal angles, Cycles' strength by horizontal and vertical), or None."""
    try:
        _, _, rest = text.partition("\nTILT=")
        if not rest:
            return None
        line, _, rest = rest.partition("\n")
        words = iter(rest.replace(",", " ").split())

        def numbers(count):
            return numpy.array([float(next(words)) for _ in range(count)])

        if line.strip().upper() == "INCLUDE":
            next(words)
            pairs = int(float(next(words)))
            numbers(2 * pairs)
        _, _, multiplier, vertical, horizontal, kind, _, _, _, _ = numbers(10)
        vertical, horizontal = int(vertical), int(horizontal)
        if not (0 < vertical <= 10_000 and 0 < horizontal <= 10_000):
            return None
        ballast, future, _ = numbers(3)
        angles, about = numbers(vertical), numbers(horizontal)
        candela = numbers(vertical * horizontal).reshape(horizontal, vertical)
    except (StopIteration, RuntimeError, ValueError):
        return None
    if (numpy.diff(angles) < 0).any() or not numpy.isfinite(candela).all():
        return None
    return int(kind), angles, about, candela * (multiplier * ballast * future * WATTS_PER_CANDELA)


def parse(text):
    """(vertical angles in degrees from the lamp's axis, Cycles' strength at them as a mean about the axis), or None."""
    found = _read(text)
    if found is None:
        return None
    _, angles, about, strength = found
    # Each horizontal angle counts for half of the way to its neighbours.
    shares = numpy.gradient(about) if len(about) > 1 else numpy.ones(1)
    if len(about) > 1:
        shares[0], shares[-1] = (about[1] - about[0]) / 2, (about[-1] - about[-2]) / 2
    return angles, (strength * shares[:, None]).sum(axis=0) / max(shares.sum(), 1e-30)


# Photometric types of IES files.
TYPE_C, TYPE_B, TYPE_A = 1, 2, 3


def table(node):
    """The property `ies` of an IES Texture: strengths by the angles about the axis and from it, in radians, as Cycles brings all
    types to one. None for a file that cannot be read.

    Raises ValueError for one of too few angles.
    """
    text = text_of(node)
    found = _read(text) if text else None
    if found is None or found[0] not in (TYPE_A, TYPE_B, TYPE_C):
        return None
    kind, down, around, strength = found
    if kind == TYPE_C:
        around, strength = _whole_turn(around, strength)
    elif kind == TYPE_B:
        # The polar axis lies across: the angles change places.
        across = around
        around, strength = _from_the_middle(down, strength.T)
        down, strength = _from_the_middle(across, strength.T)
        strength = strength.T
    else:
        down = down + 90
        strength = numpy.concatenate([strength[::-1], strength[1:]] if _is(around[0], 0) else [strength[::-1]])
        around = numpy.concatenate([180 - around[::-1], 180 + around[1:]] if _is(around[0], 0) else [180 - around[::-1]])
    if len(around) < 2 or len(down) < 2:
        raise ValueError(f"the file of the {node.bl_label} node has too few angles")
    return {
        "around": [float(v) for v in numpy.radians(around)],
        "down": [float(v) for v in numpy.radians(down)],
        "strengths": [float(v) for v in strength.ravel()],
    }


def _is(angle, other):
    return abs(angle - other) < 1e-4


def _from_the_middle(angles, rows):
    """Angles about 0, or from there on, as 0° to 180°, with what stands at them."""
    if not _is(angles[0], 0):
        return angles + 90, rows
    return numpy.concatenate([90 - angles[:0:-1], 90 + angles]), numpy.concatenate([rows[:0:-1], rows])


def _whole_turn(around, rows):
    """Angles about the axis from 0° to 360°: files leave out what is the same by symmetry."""
    if _is(around[0], 90):
        around = around - 90
    if len(around) == 1:
        return numpy.array([0.0, 360.0]), numpy.concatenate([rows, rows])
    for half in (180.0, 360.0):
        if _is(around[-1], half / 2):
            around = numpy.concatenate([around, half - around[-2::-1]])
            rows = numpy.concatenate([rows, rows[-2::-1]])
    if _is(around[0], 0) and not _is(around[-1], 360):
        gap = 360 - around[-1]
        if _is(around[-1] - around[-2], gap) or _is(around[1] - around[0], gap):
            around, rows = numpy.append(around, 360.0), numpy.concatenate([rows, rows[:1]])
    return around, rows


def within(profile, half_angle):
    """The mean strength over the directions that are nearer to the axis than `half_angle` (radians); 0: on the axis itself."""
    angles, strength = profile
    at = numpy.degrees((numpy.arange(1024) + 0.5) / 1024 * half_angle)
    values = numpy.interp(at, angles, strength, left=0.0, right=0.0)
    if half_angle == 0:
        return float(values[0])
    weight = numpy.sin(numpy.radians(at))
    return float((values * weight).sum() / weight.sum())
