# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene of Blender as USD, by Blender's own exporter.

The exporter is an operator, with a depsgraph of its own: it may run in the main thread alone.
"""

import os
import threading
import time

import bpy

from . import usd_layer, usd_losses
from .scene import ExportError
from .verdicts import Verdicts

# Seconds between two looks at Esc.
_POLL = 0.03

# What the render shows, with all that the program reads.
_OPTIONS = {
    "evaluation_mode": "RENDER",
    # Meshes as the render has them: the program would divide by levels of its own.
    "export_subdivision": "TESSELLATE",
    "use_instancing": True,
    "export_hair": True,
    # Poses are baked into the meshes: there is one frame.
    "export_armatures": False,
    "export_shapekeys": False,
    "generate_preview_surface": True,
    "generate_materialx_network": True,
    "export_textures_mode": "NEW",
    "relative_paths": True,
    "convert_world_material": True,
    "root_prim_path": f"/{usd_layer.ROOT}",
}


class UsdResult:
    """`path` of the file; `camera`, its name in the file; `verdicts` and `timings` as of the other exchange."""

    changed_geometry = ()

    def __init__(self, path, camera, verdicts, timings):
        self.path, self.camera, self.verdicts, self.timings = path, camera, verdicts, timings


def write_scene(depsgraph, folder, *, stopped=lambda: False):
    """Writes `scene.usda` to `folder`, and what it needs: the scene and the view layer of a depsgraph, at its frame.

    `stopped()` says whether not to wait any longer. Raises ExportError.
    """
    started = time.perf_counter()
    scene = depsgraph.scene.original
    layer = scene.view_layers[depsgraph.view_layer.name]
    camera = scene.camera
    if camera is None:
        raise ExportError(f"the scene \"{scene.name}\" has no camera: add one, or make one active with Ctrl+Numpad 0")
    reason = usd_losses.why_no_camera(camera)
    if reason:
        raise ExportError(f"the camera \"{camera.name}\" cannot be exchanged by USD ({reason}): choose glTF as the exchange")
    path = os.path.join(folder, "blender.usdc")

    def work():
        known = bpy.ops.wm.usd_export.get_rna_type().properties
        options = {name: value for name, value in _OPTIONS.items() if name in known}
        with bpy.context.temp_override(scene=scene, view_layer=layer):
            return bpy.ops.wm.usd_export(filepath=path, check_existing=False, **options)

    try:
        done = in_main_thread(work, stopped)
    except RuntimeError as error:
        raise ExportError(f"Blender's USD exporter failed: {str(error).strip()}") from error
    if done != {"FINISHED"} or not os.path.isfile(path):
        raise ExportError("Blender's USD exporter wrote no file")
    path = usd_layer.write(folder, path, depsgraph.scene)
    exported = time.perf_counter()
    verdicts = Verdicts()
    usd_losses.tell(depsgraph, layer, verdicts)
    ended = time.perf_counter()
    timings = {"usd": exported - started, "losses": ended - exported, "total": ended - started}
    return UsdResult(path, camera.name, verdicts.as_list(), timings)


def in_main_thread(work, stopped=lambda: False):
    """What `work()` returns, called in the main thread. A render with a window has a thread of its own."""
    if threading.current_thread() is threading.main_thread():
        return work()
    job = _Job(work)
    bpy.app.timers.register(job.run)
    while not job.ended.wait(_POLL):
        if stopped() and job.cancel():
            raise ExportError("the render was stopped before the export")
    if job.error is not None:
        raise job.error
    return job.result


class _Job:
    """Something for the main thread, which may be called off until it begins."""

    def __init__(self, work):
        self.work, self.result, self.error = work, None, None
        self.ended = threading.Event()
        self._begun = threading.Lock()

    def run(self):
        """Called by Blender's timer; what it returns says that it is not to be called again."""
        if not self._begun.acquire(blocking=False):
            return
        try:
            self.result = self.work()
        except Exception as error:  # It belongs to the thread that waits.
            self.error = error
        finally:
            self.ended.set()

    def cancel(self):
        """Whether it will not run."""
        return self._begun.acquire(blocking=False)
