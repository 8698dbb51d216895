# SPDX-License-Identifier: GPL-3.0-or-later
"""Adaptive subdivision: triangles whose edges are as long as Cycles wants them in the picture.

Whether an edge is divided follows from its ends alone, so that triangles beside each other stay without a crack.
"""

import numpy

from . import subdivided

# Triangles of a primitive; beyond this, and beyond twice as many as it has, they are made larger.
MOST = 4_000_000

# An edge is halved from here on, in wanted lengths: its halves are as much too short as it was too long.
_HALVED_FROM = 2.0**0.5

# Where on an edge the picture is asked.
_WHERE = (0.0, 0.5, 1.0)


def modifier_of(shown, scene):
    """The modifier by which Cycles divides the object's faces by their size in the picture; None if there is none."""
    last = shown.modifiers[-1] if len(shown.modifiers) else None
    if last is None or last.type != "SUBSURF" or not last.show_render:
        return None
    if hasattr(last, "use_adaptive_subdivision"):
        return last if last.use_adaptive_subdivision else None
    # Up to 4.5 a setting of Cycles' own.
    cycles = getattr(scene, "cycles", None)
    experimental = getattr(cycles, "feature_set", "") == "EXPERIMENTAL"
    return last if experimental and getattr(shown.cycles, "use_adaptive_subdivision", False) else None


class Dicing:
    """How long the edges of an object's triangles may be."""

    def __init__(self, shown, modifier, scene, size, preview=False):
        """`size`: the picture's width and height in pixels."""
        cycles = scene.cycles
        self.preview = preview
        self.matrix = numpy.array(shown.matrix_world, float)
        rate = cycles.preview_dicing_rate if preview else cycles.dicing_rate
        self.offscreen = max(float(cycles.offscreen_dicing_scale), 1.0)
        self.length = None
        if getattr(modifier, "adaptive_space", "PIXEL") == "OBJECT":
            # Edges of one length in the object, whatever the camera sees.
            self.length = max(modifier.adaptive_object_edge_length * rate, 1e-6)
            self.matrix = numpy.eye(4)
        own = getattr(modifier, "adaptive_pixel_size", None)
        self.pixels = max(0.1, rate * (shown.cycles.dicing_rate if own is None else own))
        camera = getattr(cycles, "dicing_camera", None) or scene.camera
        is_there = camera is not None and camera.type == "CAMERA"
        self.camera = None if not is_there else numpy.linalg.inv(numpy.array(camera.matrix_world.normalized(), float))
        if self.camera is not None:
            self.kind = camera.data.type
            corners = numpy.array([tuple(c) for c in camera.data.view_frame(scene=scene)])
            across, up = abs(corners[0] - corners[2])[:2]
            self.middle = (corners[0] + corners[2])[:2] / 2
            self.half = numpy.array([across, up]) / 2
            self.depth = 1.0 if self.kind == "ORTHO" else abs(float(corners[0][2]))
            self.pixel = across / size[0] if self.kind != "PANO" else 2 * numpy.pi / size[0]
        self.enlarged = 1.0
        self.levels = modifier.levels if preview else modifier.render_levels
        self.flat = modifier.subdivision_type == "SIMPLE"

    def __bool__(self):
        return self.length is not None or self.camera is not None

    def key(self):
        """For hashing."""
        arrays = [self.matrix, self.camera, *([self.middle, self.half] if self.camera is not None else ())]
        numbers = [self.pixels, self.length, self.offscreen, self.levels, self.flat, *([self.kind, self.depth, self.pixel] if self.camera is not None else ())]
        return [None if a is None else a.tolist() for a in arrays] + numbers

    def _wanted(self, points):
        """The length that edges should have at points of the world: longer the further they are from what is seen, as in Cycles."""
        if self.length is not None:
            return numpy.full(len(points), self.length)
        seen = points @ self.camera[:3, :3].T + self.camera[:3, 3]
        away = numpy.linalg.norm(seen, axis=1)
        if self.kind == "ORTHO":
            beyond = numpy.maximum(abs(seen[:, :2] - self.middle) - self.half, 0)
            behind = numpy.maximum(seen[:, 2], 0)
            outside = numpy.sqrt((beyond * beyond).sum(axis=1) + behind * behind) / numpy.sqrt((self.half**2).mean())
            return self.pixel * self.pixels * (1 + outside * (self.offscreen - 1))
        if self.kind == "PANO":
            return self.pixel * self.pixels * away
        # The four planes of what is seen go through the camera.
        low, high = self.middle - self.half, self.middle + self.half
        slopes = numpy.concatenate([high, -low]) / self.depth
        sides = numpy.concatenate([seen[:, :2], -seen[:, :2]], axis=1) + seen[:, 2:] * slopes
        sides /= numpy.sqrt(1 + slopes * slopes)
        outside = numpy.where((sides > 0).all(axis=1), away, numpy.maximum(sides.max(axis=1), 0))
        return self.pixel * self.pixels / self.depth * (away + outside * (self.offscreen - 1))

    def _lengths(self, first, second):
        """Lengths of edges, in wanted ones."""
        along = second - first
        wanted = self._wanted(first)
        for at in _WHERE[1:]:
            numpy.minimum(wanted, self._wanted(first + along * at), out=wanted)
        return numpy.sqrt((along * along).sum(axis=1)) / numpy.maximum(wanted, 1e-30)

    def coarser(self, positions, vertices, starts):
        """The corners of quads in the place of a mesh's faces where the modifier's own levels are finer than what Cycles makes, which
        knows nothing of them: so many levels less that half of the edges are not too long. None where no level is taken back.

        `vertices`: of each corner; `starts`: the first corner of each face.
        """
        if len(vertices) != 4 * len(starts):
            return None
        placed = positions @ self.matrix[:3, :3].T + self.matrix[:3, 3]
        found, quads = None, starts[:, None] + numpy.arange(4)
        for _ in range(self.levels):
            quads = subdivided.joined(quads, vertices)
            if quads is None:
                break
            sides = [placed[vertices[quads[:, at]]] for at in range(4)]
            lengths = [self._lengths(sides[at], sides[at - 1]) for at in range(4)]
            if not self.flat and numpy.median(lengths) > _HALVED_FROM:
                break
            found = quads
        return found

    def divided(self, arrays, curved):
        """The arrays of a primitive with smaller triangles. `curved`: along its normals, which belong to vertices."""
        arrays, curved = dict(arrays), curved and not self.flat
        used, faces = numpy.unique(arrays.pop("indices"), return_inverse=True)
        faces = faces.reshape(-1, 3)
        arrays = {name: values[used] for name, values in arrays.items()}
        arrays = {name: values.astype(float if name in {"POSITION", "_VERTEX"} else numpy.float32) for name, values in arrays.items()}
        # The longest come first: where there would be too many, all are about as much too long.
        most = max(MOST, 2 * len(faces))
        while len(faces):
            size = len(arrays["POSITION"])
            following = numpy.roll(faces, -1, axis=1)
            keys = numpy.minimum(faces, following) * size + numpy.maximum(faces, following)
            keys, edges = numpy.unique(keys, return_inverse=True)
            edges = edges.reshape(-1, 3)
            first, second = keys // size, keys % size
            placed = arrays["POSITION"] @ self.matrix[:3, :3].T + self.matrix[:3, 3]
            lengths = self._lengths(placed[first], placed[second])
            longest = float(lengths.max())
            if longest <= _HALVED_FROM:
                break
            too_long = lengths > max(_HALVED_FROM, longest / 2)
            long = too_long[edges]
            if len(faces) + long.sum() > most:
                self.enlarged = max(self.enlarged, longest / _HALVED_FROM)
                break
            arrays = _with_middles(arrays, first[too_long], second[too_long], curved)
            numbers = size + numpy.cumsum(too_long) - 1
            touched = long.any(axis=1)
            parts = _parts(faces[touched], numpy.where(long, numbers[edges], -1)[touched], long[touched])
            faces = numpy.concatenate([faces[~touched], parts])
        arrays = {name: values.astype(numpy.float32) for name, values in arrays.items()}
        arrays["indices"] = faces.reshape(-1).astype(numpy.uint32)
        return arrays


def _with_middles(arrays, first, second, curved):
    """The arrays with the middles of edges behind their vertices."""
    found = {}
    for name, values in arrays.items():
        middle = (values[first] + values[second]) / 2
        # Steps of a motion are called alike.
        if name.lstrip("_").startswith("POSITION") and curved:
            # The middle of the cubic along an edge of a curved PN triangle (Vlachos et al. 2001, section 3.1).
            normals, along = arrays[name.replace("POSITION", "NORMAL")], values[second] - values[first]
            rise = [n * (along * n).sum(axis=1, keepdims=True) for n in (normals[first], normals[second])]
            middle -= (rise[0] - rise[1]) / 8
        elif name.lstrip("_").startswith("NORMAL"):
            middle /= numpy.maximum(numpy.linalg.norm(middle, axis=1, keepdims=True), 1e-30)
        elif name == "_VERTEX":
            middle = _named(values, first, second)
        found[name] = numpy.concatenate([values, middle])
    return found


def _named(values, first, second):
    """What tells the middles of edges apart: those between the same two vertices are one."""
    names = (values[:, 0] + 65536.0 * values[:, 1]).astype(numpy.uint64)
    first_name, second_name = names[first], names[second]
    pairs = (numpy.minimum(first_name, second_name) << numpy.uint64(32)) | numpy.maximum(first_name, second_name)
    _, numbers = numpy.unique(pairs, return_inverse=True)
    numbers = numbers.reshape(-1) + int(names.max()) + 1
    return numpy.stack([numbers & 0xFFFF, numbers >> 16, values[first, 2]], axis=1).astype(float)


def _parts(faces, middles, long):
    """Triangles in the place of those with long edges. Edge i goes from corner i to the next one."""
    found, counts = [], long.sum(axis=1)

    def add(*corners):
        found.append(numpy.stack(corners, axis=1))

    whole = counts == 3
    (a, b, c), (d, e, f) = faces[whole].T, middles[whole].T
    for corners in ((a, d, f), (d, b, e), (f, e, c), (d, e, f)):
        add(*corners)
    for first in range(3):
        order = [first, (first + 1) % 3, (first + 2) % 3]
        # Only the first edge.
        of = (counts == 1) & long[:, first]
        (a, b, c), d = faces[of][:, order].T, middles[of][:, first]
        add(a, d, c)
        add(d, b, c)
        # All but the last.
        of = (counts == 2) & ~long[:, order[2]]
        (a, b, c), (d, e, _) = faces[of][:, order].T, middles[of][:, order].T
        add(d, b, e)
        add(a, d, e)
        add(a, e, c)
    return numpy.concatenate(found)
