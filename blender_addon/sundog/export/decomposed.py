# SPDX-License-Identifier: GPL-3.0-or-later
"""Matrices as translations, rotations and scales, for instances that are written as arrays."""

import numpy

# Relative to the largest entry of a matrix, how far the f32 translation, rotation and scale may be from it.
ERROR = 1e-6


def decompose(matrices):
    """(translation, rotation quaternion xyzw, scale, which of them give back the matrix in f32)."""
    translation = matrices[:, :3, 3].astype(numpy.float32)
    linear = matrices[:, :3, :3]
    scale = numpy.linalg.norm(linear, axis=1)
    safe = numpy.where(scale > 0, scale, 1)
    turned = linear / safe[:, None, :]
    mirrored = numpy.linalg.det(turned) < 0
    scale = numpy.where(mirrored[:, None], -scale, scale).astype(numpy.float32)
    turned = numpy.where(mirrored[:, None, None], -turned, turned)
    rotation = _quaternions(turned).astype(numpy.float32)
    again = _rotations(rotation.astype(float)) * scale[:, None, :].astype(float)
    error = numpy.abs(again - linear).max(axis=(1, 2))
    exact = error <= ERROR * numpy.maximum(numpy.abs(linear).max(axis=(1, 2)), 1e-30)
    return translation, rotation, scale, exact


def _quaternions(m):
    """Unit quaternions (x, y, z, w) of rotation matrices, by the largest component for exactness."""
    trace = m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2]
    squares = numpy.stack(
        [1 + 2 * m[:, 0, 0] - trace, 1 + 2 * m[:, 1, 1] - trace, 1 + 2 * m[:, 2, 2] - trace, 1 + trace], axis=1
    )
    largest = squares.argmax(axis=1)
    candidates = numpy.empty((len(m), 4, 4))
    xy, xz, yz = m[:, 0, 1] + m[:, 1, 0], m[:, 0, 2] + m[:, 2, 0], m[:, 1, 2] + m[:, 2, 1]
    zw, yw, xw = m[:, 1, 0] - m[:, 0, 1], m[:, 0, 2] - m[:, 2, 0], m[:, 2, 1] - m[:, 1, 2]
    candidates[:, 0] = numpy.stack([squares[:, 0], xy, xz, xw], axis=1)
    candidates[:, 1] = numpy.stack([xy, squares[:, 1], yz, yw], axis=1)
    candidates[:, 2] = numpy.stack([xz, yz, squares[:, 2], zw], axis=1)
    candidates[:, 3] = numpy.stack([xw, yw, zw, squares[:, 3]], axis=1)
    chosen = candidates[numpy.arange(len(m)), largest]
    return chosen / numpy.linalg.norm(chosen, axis=1, keepdims=True)


def _rotations(q):
    q = q / numpy.linalg.norm(q, axis=1, keepdims=True)
    x, y, z, w = q.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return numpy.array(rows).transpose(2, 0, 1)
