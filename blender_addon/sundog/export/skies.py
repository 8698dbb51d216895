# SPDX-License-Identifier: GPL-3.0-or-later
"""Sky textures: a table of what Blender's models give, and the disc of the sun, asked of Cycles itself in a child."""

import hashlib
import json
import math
import os
import tempfile

import bpy
import numpy

from . import baker, colorspace, gltf, images

# Columns and rows: those of Cycles' own table, and for the older models, which it computes for each direction, enough that
# their brightest places are smooth.
TABULATED, COMPUTED = (512, 256), (1024, 512)
OLD = {"PREETHAM", "HOSEK_WILKIE"}
# Half of the widest disc that a camera sees; Blender's own limit is 90°.
_WIDEST = math.radians(80)
# Cycles shows no smaller disc.
_LEAST_SIZE = 0.0005
# The radius of Cycles' Earth, kilometres.
_EARTH = 6371.0
# Before Blender 5 the disc stands before the sky, and since then its light is added.
_COVERS = bpy.app.version < (5, 0, 0)
_SEEKS_EVERY_SUN = bpy.app.version >= (5, 0, 0)
# What decides on a table beside the sun's disc.
_PROPERTIES = (
    "sky_type", "turbidity", "ground_albedo", "sun_elevation", "sun_rotation", "altitude", "air_density", "dust_density",
    "aerosol_density", "ozone_density",
)  # fmt: skip


def table(node, cache, report=None):
    """(file, the rest of the property `sky`) of a Sky Texture. Takes a child process and some seconds, once for each sky."""
    plan = Plan(node)
    path, described = _table(plan, cache, report)
    return path, {**described, "sought": plan.sought} if plan.sought else described


def _table(plan, cache, report):
    path, beside = plan.files(cache)
    if os.path.isfile(path) and os.path.isfile(beside):
        with open(beside, encoding="utf-8") as file:
            described = json.load(file)
        os.utime(beside)
        return path, described
    sky, sun = _asked(plan, report)
    width, height = plan.size
    values = numpy.nan_to_num(sky.reshape(height, width, 3), posinf=0.0, neginf=0.0)
    images.write_exr(path, numpy.maximum(values, 0.0), full=True)
    described = {"start": plan.start}
    if sun:
        described["sun"] = sun
    gltf.write_whole(beside, json.dumps(described).encode())
    return path, described


class Plan:
    """What is asked about a sky, and under which name it is kept."""

    def __init__(self, node):
        values = {n: getattr(node, n) for n in _PROPERTIES if hasattr(node, n)}
        self.is_old = node.sky_type in OLD
        if self.is_old:
            values["sun_direction"] = [float(v) for v in node.sun_direction]
        elevation, rotation = _wrapped(float(node.sun_elevation), float(node.sun_rotation))
        self.size = COMPUTED if self.is_old else TABULATED
        # Columns begin where Cycles' own do, seen from the sun.
        if self.is_old:
            x, y, _ = values["sun_direction"]
            self.start = -math.atan2(y, x) - math.pi
        else:
            self.start = math.pi / 2 + rotation
        self.values = values
        # The sun's disc; None where there is none.
        self.sun = None
        self.elevation, self.azimuth, self.half_angle = elevation, math.pi / 2 - rotation, 0.0
        size = max(float(node.sun_size), _LEAST_SIZE)
        half_angle = min(size / 2, _WIDEST)
        if not self.is_old and node.sun_disc:
            self.sun = {"sun_size": size, "sun_intensity": float(node.sun_intensity)}
            self.half_angle = half_angle
        # The older models have no disc. Since Blender 5 most samples of their light go where one would be, as the switch is on.
        self.sought = None
        if self.is_old and node.sun_disc and _SEEKS_EVERY_SUN:
            toward = [float(v) for v in _directions(self.azimuth, self.elevation)[0]]
            self.sought = {"direction": toward, "half_angle": half_angle}
        # Below it the sun is hidden.
        self.horizon = _horizon(float(getattr(node, "altitude", 0.0)))
        description = [self.values, self.sun, self.size, list(bpy.app.version), colorspace.working_space(), 4]
        self.name = hashlib.sha1(json.dumps(description, sort_keys=True).encode()).hexdigest()

    def files(self, cache):
        """The table, and what is told beside it."""
        return os.path.join(cache, f"sky-table-{self.name}.exr"), os.path.join(cache, f"sky-table-{self.name}.json")

    def is_known(self, cache):
        """Whether it need not be asked for."""
        return all(os.path.isfile(path) for path in self.files(cache))

    def directions(self):
        """Of the table's texels, the upper row first."""
        width, height = self.size
        azimuth = -2 * math.pi * (numpy.arange(width) + 0.5) / width - self.start
        half = 1 - 2 * (numpy.arange(height) + 0.5) / height
        elevation = numpy.copysign(half**2, half) * (math.pi / 2)
        return _directions(*numpy.meshgrid(azimuth, elevation))


def _directions(azimuth, elevation):
    azimuth, elevation = numpy.broadcast_arrays(azimuth, elevation)
    across = numpy.cos(elevation)
    return numpy.stack([across * numpy.cos(azimuth), across * numpy.sin(azimuth), numpy.sin(elevation)], axis=-1).reshape(-1, 3)


def _wrapped(elevation, rotation):
    """Elevation −90° to 90° and rotation of the sun, as Cycles takes them: beyond the zenith it comes down on the other side."""
    elevation = math.fmod(elevation, 2 * math.pi)
    if abs(elevation) >= math.pi:
        elevation -= math.copysign(2 * math.pi, elevation)
    if abs(elevation) >= math.pi / 2:
        elevation = math.copysign(math.pi, elevation) - elevation
        rotation += math.pi
    return elevation, rotation


def _asked(plan, report):
    """(colours of the table's texels, the sun or None)."""
    directions = plan.directions()
    with tempfile.TemporaryDirectory(prefix="sundog-sky-") as folder:
        asked, answered = os.path.join(folder, "asked.npy"), os.path.join(folder, "answered.npy")

        def ask(values, **request):
            baker.ask({"sky": {"answered": answered, "values": values, "space": colorspace.working_space(), **request}}, report)
            return numpy.load(answered).astype(float)

        values = plan.values if plan.is_old else {**plan.values, "sun_disc": False}
        heights = _heights(plan)
        probe = _directions(plan.azimuth, plan.elevation + heights * plan.half_angle)
        numpy.save(asked, numpy.concatenate([directions, probe]).astype(numpy.float32))
        sky = ask(values, asked=asked)
        if plan.sun is None or plan.sun["sun_intensity"] <= 0:
            return sky[: len(directions)], None
        view = {"elevation": plan.elevation, "azimuth": plan.azimuth, "angle": plan.half_angle, "count": _PROBES}
        lit = ask({**plan.values, **plan.sun, "sun_intensity": _BRIGHT, "sun_disc": True}, view=view)
        light = lit if _COVERS else lit - sky[len(directions) :]
        return sky[: len(directions)], _sun(plan, heights, light * (plan.sun["sun_intensity"] / _BRIGHT))


def _horizon(altitude):
    """The elevation at which Cycles lets the Earth begin to hide the sun; with its single precision, which is seen at the ground."""
    if _COVERS:
        return 0.0
    altitude = numpy.float32(max(altitude, 0.0) / 1000)
    ratio = numpy.float32(_EARTH) / (numpy.float32(_EARTH) + altitude)
    return float(numpy.arcsin(ratio) - numpy.float32(math.pi / 2))


# The intensity with which it is asked for: the greatest that Blender allows, beside which the sky is dark.
_BRIGHT = 1000.0
# Directions up the middle of the disc of the sun.
_PROBES = 64
# The part of its radius in which limb darkening changes slowly.
_INNER = 0.6
# Of so many directions the line is drawn at least, if there are as many.
_LEAST_USED = 8
# What is darker than this part of the brightest may be the rounding of the sky.
_DARK = 1e-6


def _heights(plan):
    """Where these lie, from −1 to 1: pixels are as far apart as the tangents of their angles."""
    if plan.sun is None:
        return numpy.zeros(0)
    across = (numpy.arange(_PROBES) + 0.5) / _PROBES * 2 - 1
    return numpy.arctan(across * math.tan(plan.half_angle)) / plan.half_angle


def _sun(plan, heights, light):
    """The property `sun` from how the disc shines along its middle; None where nothing of it is seen."""
    elevation = plan.elevation + heights * plan.half_angle
    seen = elevation > plan.horizon + 1e-4 * plan.half_angle
    # Near the limb a small error of the place is a large one of the light.
    for most in (_INNER, 0.95, 1.0):
        used = seen & (numpy.abs(heights) < most)
        if used.sum() >= _LEAST_USED:
            break
    if used.sum() < 2 or not light[used].max() > 0:
        return None
    darkening = 1 - 0.6 * (1 - numpy.sqrt(1 - heights**2))
    bare = light / darkening[:, None]
    # Cycles goes linearly from the disc's lower edge to its upper one.
    ends = float(elevation[used][0]), float(elevation[used][-1])
    colors = numpy.zeros((2, 3))
    for channel in range(3):
        # Colours that the space lacks are cut off at 0.
        known = used & (bare[:, channel] > _DARK * bare[used].max())
        if known.sum() >= 2:
            slope, first = numpy.polyfit(elevation[known] - ends[0], bare[known, channel], 1)
            colors[:, channel] = first, first + slope * (ends[1] - ends[0])
    return {
        "direction": [float(v) for v in _directions(plan.azimuth, plan.elevation)[0]],
        "half_angle": plan.half_angle,
        "elevations": list(ends),
        "colors": colors.tolist(),
        "horizon": plan.horizon,
        "covers": _COVERS,
    }
