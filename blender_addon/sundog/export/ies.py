# SPDX-License-Identifier: GPL-3.0-or-later
"""What IES files (ANSI/IES LM-63) say of a lamp: candela by direction."""

import os

import bpy
import numpy

# Cycles takes a luminous efficacy of 177.83 lm/W (that of D65) and a lamp's strength for 4 pi times its intensity.
WATTS_PER_CANDELA = 4 * numpy.pi / 177.83


def text_of(node):
    """The text that an IES Texture node shows, or None."""
    if node.mode == "INTERNAL":
        return node.ies.as_string() if node.ies is not None else None
    path = bpy.path.abspath(node.filepath, library=node.id_data.library)
    if not os.path.isfile(path):
        return None
    with open(path, encoding="latin-1") as file:
        return file.read()


def parse(text):
    """(vertical angles in degrees from the lamp's axis, Cycles' strength at them as a mean about the axis), or None."""
    try:
        head, _, rest = text.partition("TILT=")
        if not head and not rest:
            return None
        line, _, rest = rest.partition("\n")
        words = iter(rest.replace(",", " ").split())

        def numbers(count):
            return numpy.array([float(next(words)) for _ in range(count)])

        if line.strip().upper() == "INCLUDE":
            next(words)
            pairs = int(float(next(words)))
            numbers(2 * pairs)
        _, _, multiplier, vertical, horizontal, _, _, _, _, _ = numbers(10)
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
    # Each horizontal angle counts for half of the way to its neighbours.
    shares = numpy.gradient(about) if horizontal > 1 else numpy.ones(1)
    if horizontal > 1:
        shares[0], shares[-1] = (about[1] - about[0]) / 2, (about[-1] - about[-2]) / 2
    mean = (candela * shares[:, None]).sum(axis=0) / max(shares.sum(), 1e-30)
    return angles, mean * multiplier * ballast * future * WATTS_PER_CANDELA


def within(profile, half_angle):
    """The mean strength over the directions that are nearer to the axis than `half_angle` (radians); 0: on the axis itself."""
    angles, strength = profile
    at = numpy.degrees((numpy.arange(1024) + 0.5) / 1024 * half_angle)
    values = numpy.interp(at, angles, strength, left=0.0, right=0.0)
    if half_angle == 0:
        return float(values[0])
    weight = numpy.sin(numpy.radians(at))
    return float((values * weight).sum() / weight.sum())
