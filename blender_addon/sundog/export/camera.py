# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera: SUNDOG_camera, and the nearest that glTF itself can say."""

import math
import types

import bpy
import numpy

from .verdicts import APPROXIMATED, LOST


def picture_size(render):
    """Width and height of the picture in pixels: in integers, as Blender computes them."""
    scale = render.resolution_percentage
    return max(render.resolution_x * scale // 100, 1), max(render.resolution_y * scale // 100, 1)


def settings_of(shown, findings):
    """The camera that the scene looks through: an object's own, or what Cycles takes where the object is none.

    Measured in Cycles 4.5 to 5.2: 50 mm on a sensor of 36 mm, and 35 mm in 5.3; clip planes at 1e-5 m and 1e5 m. Through a lamp the
    picture is as wide as a spot of its cone, by Blender's rule for such views: 16 mm / tan(half of the cone).
    """
    if shown.type == "CAMERA":
        return shown.data
    lens = 35.0 if bpy.app.version >= (5, 3, 0) else 50.0
    if shown.type == "LIGHT":
        # Blender keeps a cone for every lamp, but shows only that of spots: 45° unless it was one before.
        cone = shown.data.spot_size if shown.data.type == "SPOT" else math.radians(45)
        lens = 16.0 / math.tan(cone / 2)
        if not lens > 0:
            lens = 50.0
        if shown.data.type != "SPOT":
            findings.append((APPROXIMATED, "as the camera it sees 45°, as wide as Cycles if it never was a spot light"))
    return types.SimpleNamespace(
        type="PERSP", lens=lens, sensor_fit="AUTO", sensor_width=36.0, sensor_height=24.0, shift_x=0.0, shift_y=0.0,
        clip_start=1e-5, clip_end=1e5, dof=types.SimpleNamespace(use_dof=False),
    )  # fmt: skip


def window(camera, render):
    """[left, right, bottom, top]: tangents, or metres for an orthographic camera."""
    horizontal, sensor, ratio = _fit(camera, render)
    if camera.type == "ORTHO":
        extent = camera.ortho_scale
    else:
        extent = sensor / camera.lens
    half = [extent / 2, extent / 2 / ratio] if horizontal else [extent / 2 * ratio, extent / 2]
    # Shift counts in the fitted side of the sensor, in both directions.
    dx, dy = camera.shift_x * extent, camera.shift_y * extent
    return [dx - half[0], dx + half[0], dy - half[1], dy + half[1]]


def without_scale(matrix):
    """The 4×4 matrix with columns of length 1, as Cycles places cameras."""
    result = numpy.array(matrix, float)
    for column in range(3):
        length = numpy.linalg.norm(result[:3, column])
        if length > 0:
            result[:3, column] /= length
    return result


def _focus_distance(camera, matrix, find):
    dof = camera.dof
    if dof.focus_object is None:
        return float(dof.focus_distance)
    target = find(dof.focus_object)
    place = numpy.array(target.matrix_world, float)
    bone = target.pose.bones.get(dof.focus_subtarget) if target.pose and dof.focus_subtarget else None
    if bone is not None:
        place = place @ numpy.array(bone.matrix, float)
    return float(abs((matrix[:3, 3] - place[:3, 3]) @ matrix[:3, 2]))


_PANORAMAS = {
    "FISHEYE_EQUIDISTANT": "fisheye_equidistant", "FISHEYE_EQUISOLID": "fisheye_equisolid", "FISHEYE_LENS_POLYNOMIAL": "fisheye_polynomial",
    "MIRRORBALL": "mirror_ball", "EQUIANGULAR_CUBEMAP_FACE": "cube_face", "CENTRAL_CYLINDRICAL": "central_cylindrical",
}  # fmt: skip


def _panorama(settings, camera, render):
    """What SUNDOG_camera says of a panorama; None of one that is not known."""
    kind = settings.panorama_type

    def span(name, scale=1.0, shift=0.0):
        low, high = (float(getattr(settings, f"{name}_{end}")) / scale for end in ("min", "max"))
        return [low + (high - low) * shift, high + (high - low) * shift]

    if kind == "EQUIRECTANGULAR":
        return {"type": "equirectangular", "longitude": span("longitude", shift=camera.shift_x), "latitude": span("latitude", shift=camera.shift_y)}
    if kind not in _PANORAMAS:
        return None
    result = {"type": _PANORAMAS[kind]}
    if camera.shift_x or camera.shift_y:
        result["shift"] = [float(camera.shift_x), float(camera.shift_y)]
    if kind.startswith("FISHEYE"):
        result["fov"] = float(settings.fisheye_fov)
    if kind == "FISHEYE_EQUISOLID":
        result["lens"] = float(settings.fisheye_lens)
    if kind == "FISHEYE_LENS_POLYNOMIAL":
        result["coefficients"] = [float(getattr(settings, f"fisheye_polynomial_k{n}")) for n in range(5)]
    if kind in {"FISHEYE_EQUISOLID", "FISHEYE_LENS_POLYNOMIAL"}:
        horizontal, sensor, ratio = _fit(camera, render)
        result["sensor"] = [sensor, sensor / ratio] if horizontal else [sensor * ratio, sensor]
    if kind == "CENTRAL_CYLINDRICAL":
        result["longitude"] = span("central_cylindrical_range_u")
        result["height"] = span("central_cylindrical_range_v", settings.central_cylindrical_radius)
    return result


def _fit(camera, render):
    """Whether the sensor's size is that of the picture's width, the size, and the picture's width over its height."""
    width, height = picture_size(render)
    x, y = width * render.pixel_aspect_x, height * render.pixel_aspect_y
    horizontal = camera.sensor_fit == "HORIZONTAL" or (camera.sensor_fit == "AUTO" and x > y)
    return horizontal, camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width, x / y


def describe(camera, matrix, render, findings, find=lambda o: o):
    """(SUNDOG_camera, glTF camera) of a camera whose unscaled world matrix is `matrix`.

    `find` gives the evaluated object of one that the camera focuses on.
    """
    view = window(camera, render)
    result = {"window": [float(v) for v in view], "clip": [float(camera.clip_start), float(camera.clip_end)]}
    if camera.dof.use_dof:
        stop = max(camera.dof.aperture_fstop, 1e-5)
        # Cycles: an orthographic camera has no focal length; its aperture is that of 1 m.
        length = 1.0 if camera.type == "ORTHO" else camera.lens * 1e-3
        result["aperture"] = {
            "radius": float(length / (2 * stop)),
            "blades": int(camera.dof.aperture_blades),
            "rotation": float(camera.dof.aperture_rotation),
            "ratio": float(camera.dof.aperture_ratio),
            # As in Cycles.
            "focus_distance": max(_focus_distance(camera, matrix, find), 1e-5),
        }
    if camera.type == "PANO":
        settings = camera if hasattr(camera, "panorama_type") else camera.cycles
        panorama = _panorama(settings, camera, render)
        if panorama is None:
            findings.append((LOST, f"the panorama {settings.panorama_type.lower()} is rendered as a perspective camera"))
        else:
            result["panorama"] = panorama
    elif camera.type not in {"PERSP", "ORTHO"}:
        findings.append((LOST, f"a camera of type {camera.type.lower()} is rendered as a perspective camera"))
    half_width, half_height = (view[1] - view[0]) / 2, (view[3] - view[2]) / 2
    near, far = result["clip"]
    if camera.type == "ORTHO":
        plain = {
            "type": "orthographic",
            "orthographic": {"xmag": half_width, "ymag": half_height, "znear": max(near, 0.0), "zfar": far},
        }
    else:
        plain = {
            "type": "perspective",
            "perspective": {
                "yfov": 2 * math.atan(half_height),
                "aspectRatio": half_width / half_height,
                "znear": max(near, 1e-6),
                "zfar": far,
            },
        }
    return result, plain
