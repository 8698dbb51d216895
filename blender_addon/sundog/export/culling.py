# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles' culling of objects by camera and by distance (Simplify): which objects it leaves out of the render."""

import numpy


class Culling:
    """Cycles' rules: they count where Simplify is on, for cameras that are no panoramas, without stereo; and for the
    objects whose own switches say so. An object with both switches must be outside by both."""

    def __init__(self, scene, eye, matrix, view):
        """`eye` has `type` and the clip planes; `matrix` is its unscaled place, `view` its window."""
        settings = getattr(scene, "cycles", None)
        allowed = settings is not None and scene.render.use_simplify and not scene.render.use_multiview and eye.type != "PANO"
        self._by_camera = allowed and settings.use_camera_cull
        # A distance of zero means none.
        self._by_distance = allowed and settings.use_distance_cull and settings.distance_cull_margin > 0
        if not (self._by_camera or self._by_distance):
            return
        self._margin, self._farthest = settings.camera_cull_margin, settings.distance_cull_margin
        self._orthographic, self._window = eye.type == "ORTHO", view
        self._near, self._far = eye.clip_start, eye.clip_end
        self._place, self._inverse = matrix[:3, 3], numpy.linalg.inv(matrix)

    def leaves_out(self, shown, matrix):
        """Whether Cycles leaves out an object at a place."""
        if not (self._by_camera or self._by_distance):
            return False
        own = shown.cycles
        tests = [self._outside] * (self._by_camera and own.use_camera_cull)
        tests += [self._distant] * (self._by_distance and own.use_distance_cull)
        if not tests:
            return False
        box = numpy.array(shown.bound_box, float)
        matrix = numpy.array(matrix, float)
        corners = box @ matrix[:3, :3].T + matrix[:3, 3]
        return all(test(corners) for test in tests)

    def _outside(self, corners):
        """Whether a box is outside of the picture, widened by the margin in widths and heights of the picture."""
        seen = corners @ self._inverse[:3, :3].T + self._inverse[:3, 3]
        depth = -seen[:, 2]
        # The projection's depth before its division: behind the near plane it is negative.
        z = depth - self._near if self._orthographic else self._far * (depth - self._near)
        z /= self._far - self._near
        if (z < -self._margin).all():
            return True
        left, right, bottom, top = self._window
        with numpy.errstate(divide="ignore", invalid="ignore"):
            plane = seen[:, :2] if self._orthographic else seen[:, :2] / depth[:, None]
        place = (plane - [left, bottom]) / [right - left, top - bottom]
        # What lies behind is mirrored by the projection.
        place[z < 0] = 1 - place[z < 0]
        low, high = place.min(axis=0), place.max(axis=0)
        return bool((low >= 1 + self._margin).any() or (high <= -self._margin).any())

    def _distant(self, corners):
        """Whether the box about a box, along the axes, is farther than the distance."""
        nearest = numpy.clip(self._place, corners.min(axis=0), corners.max(axis=0))
        return float(((self._place - nearest) ** 2).sum()) > self._farthest**2
