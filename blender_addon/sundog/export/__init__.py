# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene of Blender as a .gltf file with Sundog's extensions: what the render depsgraph would render, and nothing else.

Callable from a render thread: calls no operator and changes no data of the user.
"""

import os
import time

from . import nodes
from . import scene as scenes
from .scene import ExportError
from .verdicts import Verdicts


class ExportResult:
    """`path` of the .gltf; what is in it as `document`; `verdicts` as a list of dictionaries; `timings` in seconds by step;
    `changed_geometry`: the meshes that were written anew."""

    def __init__(self, path, document, verdicts, timings, changed_geometry):
        self.path, self.document, self.verdicts = path, document, verdicts
        self.timings, self.changed_geometry = timings, changed_geometry


def write_scene(depsgraph, scene, folder, cache, *, report=None, move=None, views=(), stand_ins=True):
    """Writes `scene.gltf` to `folder`, with meshes and images in the folder `cache`.

    `depsgraph` is the render's, evaluated at the frame; `scene` its scene (evaluated or not);
    `report(text)` is told what happens; `move(frame, subframe)` brings the depsgraph to another time; without it
    nothing is blurred by motion; `views`: those of stereo, whose cameras the file then has; `stand_ins`: whether materials whose
    node tree is written show their images to programs that do not read it. Raises ExportError, and OSError where a folder cannot be
    written.
    """
    started = time.perf_counter()
    os.makedirs(folder, exist_ok=True)
    os.makedirs(cache, exist_ok=True)
    verdicts = Verdicts()
    timings = {}
    exporter = scenes.Exporter(depsgraph, scene, folder, cache, verdicts, report or (lambda text: None), move, views)
    exporter.materials.stand_ins = stand_ins

    def timed(name, step):
        begun = time.perf_counter()
        step()
        timings[name] = time.perf_counter() - begun

    if scene.camera is None:
        raise ExportError(f"the scene \"{scene.name}\" has no camera: add one, or make one active with Ctrl+Numpad 0")
    try:
        try:
            timed("objects", exporter.objects)
            timed("camera", exporter.camera)
        finally:
            exporter.restore()
        timed("world", exporter.world)
        timed("file", exporter.finish)
    finally:
        # What Blender made of trees is kept no longer.
        nodes.SceneWide.inlined = None
    timings["total"] = time.perf_counter() - started
    listed = verdicts.as_list()
    return ExportResult(exporter.path, exporter.document.root, listed, timings, exporter.changed_geometry)
