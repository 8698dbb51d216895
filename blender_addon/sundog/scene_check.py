# SPDX-License-Identifier: GPL-3.0-or-later
"""Scene check: what Sundog makes of the scene, as a list; without rendering, or after each render."""

import json
import os
import textwrap

import bpy
from bpy.props import StringProperty

from . import cache, export, preferences, program, records
from .export import usd
from .process import Folder, ProgramError

# Groups of verdicts that the panel shows; the console and the JSON have all.
MOST_SHOWN = 40
_ICONS = {"lost": "ERROR", "approximated": "INFO", "exact": "CHECKMARK"}
# Seconds that the program may take to look at the scene.
_LOOK = 300


def check(context):
    """Exports the scene as the viewport's depsgraph has it, asks the program what it makes of it, and keeps the verdicts."""
    depsgraph = context.evaluated_depsgraph_get()
    scene = depsgraph.scene
    path, _ = preferences.find_program()
    place = preferences.cache_folder()
    os.makedirs(place, exist_ok=True)
    with Folder(bpy.app.tempdir) as folder:
        if scene.sundog.exchange == "USD":
            done = usd.write_scene(depsgraph, folder.path)
        else:
            done = export.write_scene(depsgraph, scene, folder.path, place, stand_ins=False)
            cache.mark_used(cache.used_by(done.path, done.document), place)
        # The cache and the images lie where they lie.
        outside = ["--allow-outside"] if program.abilities(path).has("allow-outside", "info") else []
        told = json.loads(program.ask(path, "info", done.path, "--json", *outside, seconds=_LOOK))
    record = records.begin_alone(scene, depsgraph.view_layer)
    record.update(verdicts=done.verdicts, export=done.timings, diagnostics=told.get("diagnostics", []))
    record.update(called_for=told.get("effects", []))
    return record


class SUNDOG_OT_check_scene(bpy.types.Operator):
    """Export the scene without rendering it, and list what is exact, approximated or lost. Modifiers and visibility are
    those of the viewport; F12 makes the list anew with those of the render"""

    bl_idname = "sundog.check_scene"
    bl_label = "Check Scene"

    @classmethod
    def poll(cls, context):
        """Everywhere."""
        return context.scene is not None

    def execute(self, context):
        """Exports; reports how many verdicts there are of each kind."""
        window = context.window
        if window is not None:
            window.cursor_set("WAIT")
        try:
            check(context)
        except (ProgramError, export.ExportError, OSError, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            if window is not None:
                window.cursor_set("DEFAULT")
        self.report({"INFO"}, counted(records.last_verdicts()))
        return {"FINISHED"}


def counted(verdicts):
    """How many of each, as a sentence."""
    count = {name: sum(v["verdict"] == name for v in verdicts) for name in ("lost", "approximated", "exact")}
    return ", ".join(f"{number} {name}" for name, number in count.items())


def users_of(kind, name, view_layer):
    """The objects of a view layer that a verdict is about."""
    if kind == "material":
        return [o for o in view_layer.objects if any(s.material and s.material.name_full == name for s in o.material_slots)]
    if kind in {"object", "light", "camera"}:
        return [o for o in view_layer.objects if o.name == name]
    return []


class SUNDOG_OT_select_users(bpy.types.Operator):
    """Select the objects that this is about"""

    bl_idname = "sundog.select_users"
    bl_label = "Select"
    bl_options = {"REGISTER", "UNDO"}

    kind: StringProperty(options={"HIDDEN"})
    # Several names, one a line.
    names: StringProperty(options={"HIDDEN"})

    def execute(self, context):
        """Selects them, and nothing else."""
        layer = context.view_layer
        users = [o for name in self.names.split("\n") for o in users_of(self.kind, name, layer)]
        shown = [o for o in users if o.visible_get(view_layer=layer)]
        if not shown:
            self.report({"WARNING"}, f"No visible object of this view layer uses {self.names.replace(chr(10), ', ')}")
            return {"CANCELLED"}
        if context.mode != "OBJECT":
            self.report({"WARNING"}, "Leave the edit mode first")
            return {"CANCELLED"}
        for found in layer.objects:
            found.select_set(found in shown)
        layer.objects.active = shown[0]
        return {"FINISHED"}


class RenderPanel:
    """Stands among the render properties, for this engine."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {"SUNDOG"}

    @classmethod
    def poll(cls, context):
        """For this engine."""
        return context.engine in cls.COMPAT_ENGINES


class SUNDOG_RENDER_PT_scene_check(RenderPanel, bpy.types.Panel):
    """The list."""

    bl_label = "Scene Check"

    def draw(self, context):
        """A button, what the last render took, and the verdicts in groups."""
        layout = self.layout
        layout.operator(SUNDOG_OT_check_scene.bl_idname, icon="VIEWZOOM")
        record = records.last_statistics()
        if not record:
            layout.label(text="Nothing rendered or checked yet")
            return
        width = width_of(context)
        verdicts = records.last_verdicts()
        column = layout.column(align=True)
        for line in textwrap.wrap(records.summary(record), width):
            column.label(text=line)
        layout.label(text=counted(verdicts))
        for warning in record["warnings"]:
            lines(layout.box(), warning, "ERROR", width)
        groups = records.groups(verdicts)
        for group in groups[:MOST_SHOWN]:
            self._group(layout, group, width)
        if len(groups) > MOST_SHOWN:
            layout.label(text=f"… and {len(groups) - MOST_SHOWN} more: see the console")

    def _group(self, layout, group, width):
        verdict, kind, detail, names = group
        row = layout.box().row()
        lines(row.column(align=True), f"{records.listed(names)}: {detail}", _ICONS.get(verdict, "ERROR"), width - 4)
        if kind in {"material", "object", "light", "camera"}:
            button = row.operator(SUNDOG_OT_select_users.bl_idname, text="", icon="RESTRICT_SELECT_OFF")
            button.kind, button.names = kind, "\n".join(names)


def width_of(context):
    """Letters of a line of a panel: about seven pixels each at a scale of one."""
    return max(int(context.region.width / (7 * (context.preferences.system.ui_scale or 1))) - 8, 20)


def lines(layout, text, icon, width):
    """A text over several lines, the first with an icon."""
    column = layout.column(align=True)
    for number, line in enumerate(textwrap.wrap(text, width)):
        column.label(text=line, icon=icon if number == 0 else "BLANK1")


_CLASSES = (SUNDOG_OT_check_scene, SUNDOG_OT_select_users)

register, unregister = bpy.utils.register_classes_factory(_CLASSES)
