# SPDX-License-Identifier: GPL-3.0-or-later
"""Stereo: the views of a picture, and the camera of each, as Blender tells engines."""

import numpy


class View:
    """What one view is seen through."""

    def __init__(self, name, shown, matrix, shift_x, spherical):
        # `shown`: the object that is the camera; `spherical`: whether each of a panorama's rays has an eye of its own.
        self.name, self.shown, self.matrix, self.shift_x, self.spherical = name, shown, matrix, shift_x, spherical


def names(render):
    """Names of the views that Blender renders; one without a name where there is no stereo."""
    if not render.use_multiview:
        return [""]
    stereo = render.views_format == "STEREO_3D"
    return [view.name for view in render.views if view.use and (not stereo or view.name in {"left", "right"})] or [""]


def of_engine(engine, depsgraph, name):
    """A view, by the engine that renders it."""
    engine.active_view_set(name)
    camera = engine.camera_override or depsgraph.scene.camera
    shown = camera.original.evaluated_get(depsgraph)
    spherical = engine.use_spherical_stereo(camera)
    matrix = engine.camera_model_matrix(camera, use_spherical_stereo=spherical)
    shift = engine.camera_shift_x(camera, use_spherical_stereo=spherical)
    return View(name, shown, numpy.array(matrix, float), float(shift), bool(spherical))


def eye(view, camera, findings):
    """`stereo` of SUNDOG_camera's panorama; None where the view has none."""
    side = {"left": -0.5, "right": 0.5}.get(view.name)
    if not view.spherical or side is None:
        return None
    stereo = camera.stereo
    result = {"offset": side * float(stereo.interocular_distance)}
    if stereo.convergence_mode != "PARALLEL":
        result["convergence"] = float(stereo.convergence_distance)
    if stereo.use_pole_merge:
        result["pole_merge"] = [float(stereo.pole_merge_angle_from), float(stereo.pole_merge_angle_to)]
    return result


class Shifted:
    """A camera with the shift of a view."""

    def __init__(self, camera, shift_x):
        self._camera, self.shift_x = camera, shift_x

    def __getattr__(self, name):
        return getattr(self._camera, name)

