# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "Compare with Cycles" in the render properties."""

import json
import os
import shutil
import tempfile

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, PointerProperty

from ..process import ProgramError
from . import child, settings, table

POLL = 0.1
# The images in Blender -> files in the folder.
IMAGES = {"Sundog": "sundog.exr", "Cycles": "cycles.exr", "Difference": "difference.png"}


class _State:
    """What the panel shows; one comparison at a time."""

    child = None
    found = None
    folder = None
    message = ""


class SundogCompareSettings(bpy.types.PropertyGroup):
    """How the comparison is made."""

    own_samples: BoolProperty(
        name="Samples", default=False, description="Other samples than Sundog's settings say"
    )
    samples: IntProperty(name="Samples", default=64, min=1, max=1 << 20, description="Samples of each pixel, of both")
    percentage: IntProperty(
        name="Resolution", default=50, min=1, max=100, subtype="PERCENTAGE", description="Of the picture's resolution"
    )
    cycles_defaults: BoolProperty(
        name="Cycles as It Is", default=False,
        description="Leave Cycles' own settings: samples, noise threshold, denoising, clamping, device",
    )


def options(scene):
    """What the panel asks for."""
    given = scene.sundog_compare
    percentage = max(scene.render.resolution_percentage * given.percentage // 100, 1)
    return settings.Options(given.samples if given.own_samples else None, given.cycles_defaults, percentage)


class SUNDOG_OT_compare(bpy.types.Operator):
    """Render this frame with Sundog and with Cycles, in a Blender of its own, and show both and the difference"""

    bl_idname = "sundog.compare"
    bl_label = "Compare with Cycles"

    @classmethod
    def poll(cls, context):
        """One at a time, and only with a camera."""
        return context.scene.camera is not None and _State.child is None

    def invoke(self, context, _event):
        """Starts, and lets the window go on."""
        if not self._start(context):
            return {"CANCELLED"}
        manager = context.window_manager
        manager.progress_begin(0, 100)
        self._timer = manager.event_timer_add(POLL, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        """Without a window: waits for the end."""
        if not self._start(context):
            return {"CANCELLED"}
        running = _State.child
        while not running.ended():
            running.wait(POLL)
        return self._finish(context)

    def modal(self, context, event):
        """Progress; Esc stops."""
        if event.type == "ESC":
            _State.child.stop()
            self._close(context)
            shutil.rmtree(self._folder, ignore_errors=True)
            _State.message = "Stopped"
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        context.window_manager.progress_update(100 * _State.child.fraction)
        context.workspace.status_text_set(f"Comparing with Cycles: {_State.child.text} (Esc stops)")
        _redraw(context)
        if not _State.child.ended():
            return {"RUNNING_MODAL"}
        return self._finish(context)

    def cancel(self, _context):
        """Blender ends it: another file is opened, or the window is closed."""
        if _State.child is not None:
            _State.child.stop()
            _State.child = None
        shutil.rmtree(self._folder, ignore_errors=True)

    def _start(self, context):
        dirty = [image.name for image in bpy.data.images if image.is_dirty and image.source in {"FILE", "GENERATED"}]
        if dirty:
            self.report({"WARNING"}, f"Painted but not saved, so the comparison shows them as they were: {', '.join(dirty)}")
        # Blender removes its folder when it ends.
        folder = tempfile.mkdtemp(prefix="sundog-compare-", dir=bpy.app.tempdir)
        try:
            blend = os.path.join(folder, "scene.blend")
            bpy.ops.wm.save_as_mainfile(filepath=blend, copy=True, compress=False)
            _State.child = child.Child(blend, folder, options(context.scene), os.path.join(folder, "order.json"))
        except (ProgramError, OSError, RuntimeError) as error:
            shutil.rmtree(folder, ignore_errors=True)
            self.report({"ERROR"}, f"Sundog: {error}")
            return False
        self._folder = folder
        _State.message = ""
        return True

    def _finish(self, context):
        error = _State.child.error
        self._close(context)
        if error is None:
            try:
                with open(os.path.join(self._folder, "comparison.json"), encoding="utf-8") as file:
                    found = json.load(file)
            except (OSError, ValueError) as failure:
                error = f"the comparison has left no numbers: {failure}"
        if error is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            _State.message = error
            self.report({"ERROR"}, f"Sundog: {error}")
            return {"CANCELLED"}
        forget()
        _State.found, _State.folder = found, self._folder
        load_images(self._folder)
        if not bpy.app.background:
            # A new window inside of a running operator confuses Blender: it calls the operator again.
            bpy.app.timers.register(_show_first, first_interval=0.0)
        self.report({"INFO"}, f"Compared: {', '.join(' '.join(line) for line in table.differences(found)[:2])}")
        return {"FINISHED"}

    def _close(self, context):
        timer = getattr(self, "_timer", None)
        if timer is not None:
            context.window_manager.event_timer_remove(timer)
            context.window_manager.progress_end()
            context.workspace.status_text_set(None)
            _redraw(context)
        if _State.child.ended() is False:
            _State.child.stop()
        _State.child = None


def forget():
    """Removes the last comparison's folder."""
    if _State.folder is not None:
        shutil.rmtree(_State.folder, ignore_errors=True)
    _State.found = _State.folder = None


def _show_first():
    show_image(bpy.context, "Sundog")


def load_images(folder):
    """The pictures as images of Blender, held in memory: the folder may go."""
    for name, file in IMAGES.items():
        old = bpy.data.images.get(name)
        image = bpy.data.images.load(os.path.join(folder, file))
        image.pack()
        # The light through the scene's view; the map as it is.
        image.use_view_as_render = file.endswith(".exr")
        if old is not None and old.get("sundog_compare"):
            old.user_remap(image)
            bpy.data.images.remove(old)
        image.name = name
        image["sundog_compare"] = True


def _find(name):
    return next((image for image in bpy.data.images if image.get("sundog_compare") and image.name.split(".")[0] == name), None)


def show_image(context, name):
    """Shows one of the pictures in an image editor, in a new window if there is none."""
    image = _find(name)
    windows = context.window_manager.windows
    if image is None or not windows or bpy.app.background:
        return
    editors = [(window, area) for window in windows for area in window.screen.areas if area.ui_type == "IMAGE_EDITOR"]
    if not editors:
        with context.temp_override(window=windows[0]):
            bpy.ops.wm.window_new()
        area = windows[-1].screen.areas[0]
        area.ui_type = "IMAGE_EDITOR"
        editors = [(windows[-1], area)]
    window, area = editors[0]
    area.spaces.active.image = image
    region = next(region for region in area.regions if region.type == "WINDOW")
    with context.temp_override(window=window, area=area, region=region):
        if bpy.ops.image.view_all.poll():
            bpy.ops.image.view_all(fit_view=True)


def _redraw(context):
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


class SUNDOG_OT_compare_show(bpy.types.Operator):
    """Show this picture in the image editor"""

    bl_idname = "sundog.compare_show"
    bl_label = "Show"

    image: EnumProperty(items=[(name, name, "") for name in IMAGES])

    def execute(self, context):
        """Shows it."""
        show_image(context, self.image)
        return {"FINISHED"}


class SUNDOG_RENDER_PT_compare(bpy.types.Panel):
    bl_label = "Compare with Cycles"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {"SUNDOG", "CYCLES"}

    @classmethod
    def poll(cls, context):
        """For both engines."""
        return context.engine in cls.COMPAT_ENGINES and hasattr(context.scene, "cycles")

    def draw(self, context):
        """Settings, the button, the last result."""
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        given = context.scene.sundog_compare
        row = layout.row(heading="Samples")
        row.prop(given, "own_samples", text="")
        value = row.row()
        value.enabled = given.own_samples
        value.prop(given, "samples", text="")
        layout.prop(given, "percentage", slider=True)
        layout.prop(given, "cycles_defaults")
        running = _State.child
        if running is not None:
            if hasattr(layout, "progress"):
                layout.progress(factor=running.fraction, text=running.text)
            layout.label(text="Esc stops")
        else:
            layout.operator(SUNDOG_OT_compare.bl_idname, icon="IMAGE_RGB_ALPHA")
        if _State.message:
            box = layout.box()
            box.alert = True
            box.label(text=_State.message)
        if _State.found is not None:
            self._results(layout, _State.found)

    def _results(self, layout, found):
        grid = layout.grid_flow(row_major=True, columns=3, even_columns=True, align=True)
        for line in (("", "Sundog", "Cycles"), *table.rows(found)):
            for text in line:
                grid.label(text=text)
        column = layout.column(align=True)
        for label, value in table.differences(found):
            split = column.split(factor=0.66)
            split.label(text=label)
            split.label(text=value)
        row = layout.row(align=True)
        for name in IMAGES:
            row.operator(SUNDOG_OT_compare_show.bl_idname, text=name).image = name


_CLASSES = (SundogCompareSettings, SUNDOG_OT_compare, SUNDOG_OT_compare_show, SUNDOG_RENDER_PT_compare)


def register():
    """Adds the panel."""
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.sundog_compare = PointerProperty(type=SundogCompareSettings)


def unregister():
    """Takes it away, and ends what is under way."""
    if _State.child is not None:
        _State.child.stop()
        _State.child = None
    forget()
    del bpy.types.Scene.sundog_compare
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
