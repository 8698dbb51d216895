# SPDX-License-Identifier: GPL-3.0-or-later
"""A small layer over the file that Blender's exporter writes: what USD can say, and the exporter leaves out."""

import os

import bpy

from . import camera as cameras
from . import nodes

# Where the exporter puts all that it writes, and the world.
ROOT, _WORLD = "root", "env_light"
_CAMERA = "sundog_camera"
# Tenths of a unit, which lengths of cameras are in.
_TENTHS = 10.0


def write(folder, below, scene):
    """Writes `scene.usda` over the file `below`, which lies beside it; returns its path."""
    parts = [*_dome(scene.world), *_camera_prim(scene)]
    head = [
        "#usda 1.0", "(",
        f"    subLayers = [@./{os.path.basename(below)}@]", f'    defaultPrim = "{ROOT}"',
        # Readers undo units of Blender's by this word.
        f'    doc = "Blender v{bpy.app.version_string}"', "    metersPerUnit = 1", '    upAxis = "Z"', ")",
        f'over "{ROOT}"', "{",
    ]  # fmt: skip
    path = os.path.join(folder, "scene.usda")
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join([*head, *(f"    {line}" for line in parts), "}", ""]))
    return path


def shine_of(world):
    """(colour, strength) of a world; the colour is None where it is linked, the strength where it is, both where it is no background."""
    if world is None or nodes.tree_of(world) is None:
        return (tuple(world.color), 1.0) if world else ((0.0, 0.0, 0.0), 0.0)
    output = nodes.output_of(world)
    links = output.inputs["Surface"].links if output else ()
    node = links[0].from_node if links else None
    if node is None or node.type != "BACKGROUND":
        return None, None
    color, strength = node.inputs["Color"], node.inputs["Strength"]
    return (None if color.is_linked else tuple(color.default_value[:3])), (None if strength.is_linked else float(strength.default_value))


def _dome(world):
    """Beside an image, Blender 5.2 writes no strength; 4.5 writes a colour as an image with eight bits of it."""
    color, strength = shine_of(world)
    if world is None or strength is None:
        return []
    lines = [f"    float inputs:intensity = {strength!r}"]
    if color is None:
        return [f'over "{_WORLD}"', "{", *lines, "}"]
    numbers = ", ".join(repr(float(v)) for v in color)
    lines += [f"    color3f inputs:color = ({numbers})", "    asset inputs:texture:file = None"]
    return [f'def DomeLight "{_WORLD}"', "{", *lines, "}"]


def needs_camera(camera):
    """Whether the exporter leaves the camera out: what is no camera, and orthographic ones."""
    return camera.type != "CAMERA" or camera.data.type == "ORTHO"


def _camera_prim(scene):
    shown = scene.camera
    if not needs_camera(shown):
        return []
    settings = cameras.settings_of(shown, [])
    left, right, bottom, top = cameras.window(settings, scene.render)
    orthographic = settings.type == "ORTHO"
    # Of perspective ones the window is a plane at a distance of 1.
    rows = cameras.without_scale(shown.matrix_world).T
    matrix = ", ".join("(" + ", ".join(repr(float(v)) for v in row) + ")" for row in rows)
    name = shown.name.replace("\\", "\\\\").replace('"', '\\"')
    lines = [
        f'token projection = "{"orthographic" if orthographic else "perspective"}"',
        f"float focalLength = {_TENTHS!r}",
        f"float horizontalAperture = {(right - left) * _TENTHS!r}",
        f"float verticalAperture = {(top - bottom) * _TENTHS!r}",
        f"float horizontalApertureOffset = {(right + left) / 2 * _TENTHS!r}",
        f"float verticalApertureOffset = {(top + bottom) / 2 * _TENTHS!r}",
        f"float2 clippingRange = ({settings.clip_start!r}, {settings.clip_end!r})",
        f'custom string userProperties:blender:object_name = "{name}"',
        f"matrix4d xformOp:transform = ({matrix})",
        'uniform token[] xformOpOrder = ["xformOp:transform"]',
    ]
    return [f'def Camera "{_CAMERA}"', "{", *(f"    {line}" for line in lines), "}"]
