# SPDX-License-Identifier: GPL-3.0-or-later
"""A small layer over the file that Blender's exporter writes: what USD can say, and the exporter leaves out."""

import os

import bpy

from . import camera as cameras

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


def strength_of_image(world):
    """The strength beside the one image of a world; None where there is none, or where it varies."""
    tree = world and world.node_tree
    output = tree and tree.get_output_node("CYCLES")
    links = output.inputs["Surface"].links if output else ()
    node = links[0].from_node if links else None
    if node is None or node.type != "BACKGROUND" or not node.inputs["Color"].is_linked or node.inputs["Strength"].is_linked:
        return None
    return float(node.inputs["Strength"].default_value)


def _dome(world):
    """Blender 5.2 writes the strength of a colour alone."""
    strength = strength_of_image(world)
    if strength is None:
        return []
    return [f'over "{_WORLD}"', "{", f"    float inputs:intensity = {strength!r}", "}"]


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
