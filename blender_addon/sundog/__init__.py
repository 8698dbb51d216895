# SPDX-License-Identifier: GPL-3.0-or-later
"""Sundog as a render engine of Blender. The program that renders is another process; see docs/blender.md."""

bl_info = {
    "name": "Sundog",
    "author": "The Sundog authors",
    "version": (0, 1, 0),
    "blender": (4, 2, 0),
    "category": "Render",
    "description": "A path tracer that stands beside Cycles",
}

import atexit
import importlib
import sys

import bpy

# The order of registering.
_NAMES = ("preferences", "properties", "engine", "scene_check", "ui", "effects", "compare", "export.hook")
_modules = []

# Blender reloads only this file when an add-on was updated: the others shall be read anew as well.
for _name in [name for name in sys.modules if name.startswith(f"{__name__}.")]:
    del sys.modules[_name]

# Blender's glTF exporter looks for these two here.
from .export.hook import draw_export, glTF2ExportUserExtension  # noqa: E402, F401


def register():
    """Called by Blender when the add-on is enabled; a second call does nothing."""
    if _modules:
        return
    for name in _NAMES:
        module = importlib.import_module(f".{name}", __package__)
        try:
            module.register()
        except BaseException:
            unregister()
            raise
        _modules.append(module)
    if not bpy.app.binary_path:
        # Blender as a Python module crashes or hangs at its end while a render engine written in Python is registered.
        atexit.register(unregister)


def unregister():
    """Called by Blender when the add-on is disabled; a second call does nothing."""
    while _modules:
        _modules.pop().unregister()
