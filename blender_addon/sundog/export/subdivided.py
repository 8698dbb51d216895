# SPDX-License-Identifier: GPL-3.0-or-later
"""What the Subdivision Surface modifier made of faces, undone level by level: its vertices lie on the limit surface at each of them.

A level puts a vertex on each edge and one in each face: every quad then goes from a vertex of before by one of an edge to one of a face.
"""

import numpy

_BEFORE, _FACE, _EDGE = 1, 2, 3


def joined(corners, vertices):
    """The corners of the quads before a level, from those of the quads after it (n × 4) and the vertex of each corner; None if some
    face before had not four corners, or if the quads look like no such level."""
    faces = vertices[corners]
    kinds = _kinds(faces, len(vertices))
    if kinds is None:
        return None
    of = kinds[faces]
    if not ((of == _BEFORE).sum(axis=1) == 1).all() or not ((of == _FACE).sum(axis=1) == 1).all():
        return None
    # From the vertex of before on.
    turned = (numpy.argmax(of == _BEFORE, axis=1)[:, None] + numpy.arange(4)) % 4
    rows = numpy.arange(len(faces))[:, None]
    faces, corners = faces[rows, turned], corners[rows, turned[:, :1]][:, 0]
    if (kinds[faces[:, 2]] != _FACE).any() or (numpy.bincount(faces[:, 2])[numpy.unique(faces[:, 2])] != 4).any():
        return None
    # About the vertex of a face: the next quad begins at the edge where this one ends.
    size = numpy.int64(len(vertices))
    begins, ends = (faces[:, 2] * size + faces[:, side] for side in (3, 1))
    order = numpy.argsort(begins, kind="stable")
    found = numpy.minimum(numpy.searchsorted(begins[order], ends), len(order) - 1)
    follows = order[found]
    if (begins[follows] != ends).any() or len(numpy.unique(begins)) != len(begins):
        return None
    first = numpy.unique(faces[:, 2], return_index=True)[1]
    around = [first]
    for _ in range(3):
        around.append(follows[around[-1]])
    if (follows[around[3]] != first).any():
        return None
    return numpy.stack([corners[quad] for quad in around], axis=1)


def _kinds(faces, count):
    """What each vertex was made for. Blender's first vertex of each piece is one of the mesh that it divides."""
    faces = faces.astype(numpy.int64)
    at = faces.reshape(-1)
    order = numpy.argsort(at, kind="stable")
    starts = numpy.searchsorted(at[order], numpy.arange(count + 1))
    kinds = numpy.zeros(count, numpy.int8)
    for seed in numpy.unique(at):
        if kinds[seed]:
            continue
        reached, kind = numpy.array([seed]), _BEFORE
        while len(reached):
            kinds[reached] = kind
            lengths = starts[reached + 1] - starts[reached]
            offsets = numpy.arange(lengths.sum()) - numpy.repeat(numpy.cumsum(lengths) - lengths, lengths)
            places = order[numpy.repeat(starts[reached], lengths) + offsets]
            quads, corner = places // 4, places % 4
            beside = numpy.concatenate([faces[quads, (corner + turn) % 4] for turn in (1, 3)])
            opposite = numpy.unique(faces[quads, (corner + 2) % 4])
            kind = _FACE + _BEFORE - kind
            if not numpy.isin(kinds[beside], (0, _EDGE)).all() or not numpy.isin(kinds[opposite], (0, kind)).all():
                return None
            kinds[beside] = _EDGE
            reached = opposite[kinds[opposite] == 0]
    return kinds
