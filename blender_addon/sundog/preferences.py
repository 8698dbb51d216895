# SPDX-License-Identifier: GPL-3.0-or-later
"""Preferences: which program renders, and the cache; a button that tests the program."""

import json
import os

import bpy
from bpy.props import IntProperty, StringProperty

from . import cache, program
from .process import Folder, ProgramError, Run

GIGABYTE = 1 << 30

# A triangle in front of a camera, with light from all around.
_TEST_SCENE = {
    "asset": {"version": "2.0"},
    "scene": 0,
    "scenes": [{"nodes": [0]}],
    "nodes": [{"camera": 0}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}],
}
_TEST_SIDE = 16


class SundogPreferences(bpy.types.AddonPreferences):
    """Of the add-on, the same for all files."""

    bl_idname = __package__

    program: StringProperty(
        name="Program", subtype="FILE_PATH", default="",
        description="The sundog program that renders; empty for the one that came with the add-on",
    )
    cache_folder: StringProperty(
        name="Cache", subtype="DIR_PATH", default="",
        description="Folder for exported meshes and images, which the next render takes again; empty for the default",
    )
    cache_limit: IntProperty(
        name="Cache Limit (GB)", default=8, min=1, max=10000,
        description="Files that were not used for longest are removed beyond this",
    )

    def draw(self, _context):
        """Program and cache."""
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "program", placeholder="the add-on's own")
        column = layout.column(align=True)
        try:
            path, source = program.find(self.program)
            column.label(text=f"Version {program.abilities(path).version}, from {source}: {path}")
        except ProgramError as error:
            column.alert = True
            column.label(text=str(error), icon="ERROR")
        layout.operator(SUNDOG_OT_test_program.bl_idname, icon="PLAY")
        layout.prop(self, "cache_folder", placeholder=cache.default_folder())
        layout.prop(self, "cache_limit")


class Defaults:
    """The preferences where the add-on was registered without being enabled."""

    program, cache_folder, cache_limit = "", "", 8


def get():
    """The preferences."""
    addon = bpy.context.preferences.addons.get(__package__)
    return addon.preferences if addon is not None and addon.preferences is not None else Defaults


def cache_folder():
    """Where the cache is."""
    chosen = get().cache_folder
    return bpy.path.abspath(chosen) if chosen else cache.default_folder()


def find_program():
    """(path, where it comes from). Raises ProgramError."""
    chosen = get().program
    return program.find(bpy.path.abspath(chosen) if chosen else "")


def test_program(path):
    """Lets the program render a few pixels; returns what it says of itself. Raises ProgramError."""
    version = " / ".join(program.ask(path, "--version").split("\n")).strip(" /")
    with Folder(bpy.app.tempdir) as place:
        folder = place.path
        scene = os.path.join(folder, "test.gltf")
        with open(scene, "w", encoding="utf-8") as file:
            json.dump(_TEST_SCENE, file)
        side = str(_TEST_SIDE)
        command = [path, "render", scene, "--json", "--frames", folder, "--width", side, "--height", side]
        command += ["--samples", "4", "--environment-color", "1,0.5,0.25"]
        mean = None
        with Run(command) as run:
            while not run.ended:
                event = run.next(0.1)
                if event is not None and event["event"] == "frame" and event["final"]:
                    mean = _mean(os.path.join(folder, event["file"]))
            run.check()
    if mean != (1.0, 0.5, 0.25):
        raise ProgramError(f"the program {path} renders something wrong: {mean} instead of (1.0, 0.5, 0.25)")
    return version


def _mean(path):
    import numpy

    pixels = numpy.fromfile(path, numpy.float32, _TEST_SIDE * _TEST_SIDE * 4).reshape(-1, 4)
    return tuple(round(float(v), 4) for v in pixels[:, :3].mean(axis=0))


class SUNDOG_OT_test_program(bpy.types.Operator):
    """Ask the program for its version and let it render a few pixels"""

    bl_idname = "sundog.test_program"
    bl_label = "Test"

    def execute(self, _context):
        """Reports what the program says, or why it does not work."""
        try:
            path, source = find_program()
            version = test_program(path)
        except ProgramError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except OSError as error:
            self.report({"ERROR"}, f"the test needs a temporary folder: {error}")
            return {"CANCELLED"}
        self.report({"INFO"}, f"The program works: {version} ({path}, from {source})")
        return {"FINISHED"}


_CLASSES = (SUNDOG_OT_test_program, SundogPreferences)

register, unregister = bpy.utils.register_classes_factory(_CLASSES)
