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
    """What each vertex was made for, 0 where no face has it. Blender's first vertex of each piece is one of the mesh that it divides."""
    # Three sides join the corners of a quad.
    sides = (numpy.concatenate([faces[:, corner + step] for corner in (0, 1, 2)]) for step in (0, 1))
    diagonals = (numpy.concatenate([faces[:, corner + step] for corner in (0, 1)]) for step in (0, 2))
    # Along a side what was made for an edge changes with what was not, along a diagonal vertices of before with those of faces.
    of_edge, of_face = (_odd(*(end.astype(numpy.int32) for end in ends), count) for ends in (sides, diagonals))
    kinds = numpy.where(of_edge, _EDGE, numpy.where(of_face, _FACE, _BEFORE)).astype(numpy.int8)
    kinds[numpy.bincount(faces.reshape(-1), minlength=count) == 0] = 0
    return kinds


def _odd(starts, ends, count):
    """Whether vertices are an odd number of lines away from the first one of what the lines from starts to ends join. (Where lines make odd
    circles some of them are odd and some are not.)"""
    first, odd = numpy.arange(count, dtype=numpy.int32), numpy.zeros(count, bool)
    while True:
        apart = first[starts] != first[ends]
        if not apart.any():
            return odd
        starts, ends = starts[apart], ends[apart]
        # The first of one piece hangs below that of the other, the lower one stays: both writes keep the same line of several.
        pair = first[starts], first[ends]
        low, high = numpy.minimum(*pair), numpy.maximum(*pair)
        first[high], odd[high] = low, ~(odd[starts] ^ odd[ends])
        while True:
            above = first[first]
            if (above == first).all():
                break
            odd ^= odd[first]
            first = above
