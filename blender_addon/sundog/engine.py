# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine: exports what the depsgraph shows, lets the program render it, and shows the picture as it grows."""

import contextlib
import math
import os
import threading
import time
import traceback

import bpy
import numpy

from . import cache, command, denoise, export, passes, preferences, program, records
from .export import usd, views
from .process import PATIENCE, Folder, ProgramError, Run

# Seconds between two looks at Esc.
POLL = 0.03
# Seconds between two words on the progress: Blender draws the picture anew for each of them.
TELL_EVERY = 1.0
# Bytes of a last frame that are taken after Esc; of a larger one the picture alone, so that it ends in time.
MOST_AFTER_ESC = 256 << 20

_one_at_a_time = threading.Lock()


class _Stopped(Exception):
    """The user has pressed Esc before there was anything to keep."""


def last_verdicts():
    """What became of each thing in the last render or scene check: dictionaries with kind, name, verdict, detail and effects."""
    return records.last_verdicts()


def last_statistics():
    """Export timings, seconds of preparing, the program's statistics and settings of the last render, as a dictionary."""
    return records.last_statistics()


class SundogRenderEngine(bpy.types.RenderEngine):
    """Blender's side of a render."""

    bl_idname = "SUNDOG"
    bl_label = "Sundog"
    bl_use_preview = False
    bl_use_eevee_viewport = True
    bl_use_exclude_layers = True
    bl_use_postprocess = True
    bl_use_shading_nodes_custom = False
    bl_use_stereo_viewport = False
    bl_use_spherical_stereo = True

    def update_render_passes(self, scene, renderlayer):
        """Tells the compositor which passes there are."""
        for wanted in passes.wanted(scene, renderlayer):
            self.register_pass(scene, renderlayer, wanted.name, len(wanted.channels), wanted.channels, wanted.kind)

    def render(self, depsgraph):
        """Called for each view layer of each frame, in a thread of its own if there is a window."""
        if self.is_preview:
            return
        screen = _Screen(self, depsgraph.scene.render, passes.wanted(depsgraph.scene, depsgraph.view_layer), depsgraph.view_layer.name)
        try:
            self._render(depsgraph, screen)
        finally:
            screen.close()

    def stopped(self):
        """Whether the user has pressed Esc."""
        return self.test_break()

    def _render(self, depsgraph, screen):
        while not _one_at_a_time.acquire(timeout=POLL):
            if self.stopped():
                return
        try:
            _LayerRender(self, depsgraph, screen).run()
        except _Stopped:
            pass
        except (ProgramError, export.ExportError) as error:
            self._fail(str(error))
        except OSError as error:
            self._fail(f"{error.filename or 'a file'}: {error.strerror or error}")
        except MemoryError:
            self._fail("there is not enough memory to export the scene")
        except Exception as error:  # Whatever it is, Blender shall say so and live on.
            traceback.print_exc()
            self._fail(f"a mistake in the add-on, please report it: {type(error).__name__}: {error}")
        finally:
            _one_at_a_time.release()

    def _fail(self, message):
        records.fail(message)
        # The report ends an animation and keeps the picture from being saved; the other one stands above the picture.
        self.report({"ERROR"}, f"Sundog: {message}")
        if not bpy.app.background:
            self.error_set(f"Sundog: {message}")


class _Kept:
    """A folder that keeps the scenes that are exported."""

    folder = None


def keep_scenes_in(folder):
    """From now on each render also exports its scene to this folder, with all that belongs to it; None for not."""
    _Kept.folder = folder


class _LayerRender:
    """One view layer of one frame."""

    def __init__(self, engine, depsgraph, screen):
        self.engine, self.depsgraph, self.screen = engine, depsgraph, screen
        self.scene, self.layer = depsgraph.scene, depsgraph.view_layer
        self.record = records.begin(self.scene, self.layer)
        layers = [layer.name for layer in self.scene.view_layers if layer.use]
        self.title = f"{self.layer.name} | " if len(layers) > 1 else ""
        self.frames = None
        # When the progress was told last.
        self.told = -math.inf
        self.view = (0, 1)
        self.by_usd = self.scene.sundog.exchange == "USD"
        self.part = (layers.index(self.layer.name), len(layers)) if self.layer.name in layers else (0, 1)

    def run(self):
        """Exports and renders."""
        path, source = preferences.find_program()
        abilities = program.abilities(path)
        self.record.update(program=path, program_source=source, version=abilities.version)
        arguments = command.arguments(self.scene, self.layer, abilities, self.warn)
        for name in passes.left_out(self.layer):
            self.warn(f"there is no pass \"{name}\": it is left out")
        for words in denoise.differences(self.scene, self.layer):
            self.warn(words)
        arguments += denoise.arguments(self.scene, self.layer, abilities, self.warn)
        arguments += command.pass_arguments(self.screen.wanted, abilities, self.layer, self.scene.world)
        names = self.screen.views
        seen = [views.of_engine(self.engine, self.depsgraph, name) for name in names if name]
        with Folder(bpy.app.tempdir) as folder:
            scene_file = self.export_usd(folder.path) if self.by_usd else self.export(folder.path, seen)
            for number, name in enumerate(names):
                self.view = (number, len(names))
                if name:
                    self.screen.look(name)
                    self.engine.active_view_set(name)
                # A run takes its folder with it: the last one that of the scene.
                last = number + 1 == len(names)
                with contextlib.nullcontext(folder) if last else Folder(bpy.app.tempdir) as own:
                    frames = os.path.join(own.path, "frames")
                    os.mkdir(frames)
                    chosen = ["--camera", self.camera_of(number)] if name or self.by_usd else []
                    line = [path, "render", scene_file, "--json", "--frames", frames, *chosen, *arguments]
                    self.record["command"] = line
                    self.watch(line, own, frames)
                if self.engine.stopped():
                    break
        records.finish(self.record, self.engine.is_animation)
        self.tell_loss()

    def tell_loss(self):
        """One line on what is not exact: as a report, and in the picture's header, where it stays."""
        sentence = records.told(self.record, self.engine.is_animation)
        if sentence:
            kind = "WARNING" if " lost" in sentence else "INFO"
            self.engine.report({kind}, f"Sundog: {self.title}{sentence}: see Scene Check")
        # Of all that the engine says only this is still there when the render has ended; it ends or fails nothing.
        whole = records.loss(records.last_verdicts())
        if whole and not bpy.app.background:
            self.engine.error_set(f"{whole}: see Scene Check")

    def warn(self, text):
        """Something that the user should know, once a render."""
        if text not in self.record["warnings"]:
            self.record["warnings"].append(text)
            self.engine.report({"WARNING"}, f"Sundog: {text}")

    def say(self, text):
        """Shown in the picture's header. Stops the export if the user has pressed Esc."""
        self.engine.update_stats("", self.title + text)
        if self.engine.stopped():
            raise _Stopped

    def export(self, folder, seen):
        """Writes the scene; returns the file."""
        self.say("Exporting")
        place = preferences.cache_folder()
        try:
            os.makedirs(place, exist_ok=True)
        except OSError as error:
            raise ProgramError(
                f"the cache folder {place} cannot be made ({error.strerror}): choose another one in the preferences of the add-on"
            ) from error
        if not os.access(place, os.W_OK | os.X_OK):
            raise ProgramError(f"the cache folder {place} cannot be written to: choose another one in the preferences of the add-on")
        done = export.write_scene(
            self.depsgraph, self.scene, folder, place, report=lambda text: self.say(f"Exporting: {text}"), move=self.engine.frame_set, views=seen,
            stand_ins=False,
        )  # fmt: skip
        self.record.update(verdicts=done.verdicts, export=done.timings, changed_geometry=done.changed_geometry)
        if _Kept.folder is not None:
            again = export.write_scene(self.depsgraph, self.scene, _Kept.folder, _Kept.folder, move=self.engine.frame_set, views=seen)
            self.record["kept"] = again.path
        used = cache.used_by(done.path, done.document)
        cache.mark_used(used, place)
        cache.tidy(place, preferences.get().cache_limit * preferences.GIGABYTE, used)
        return done.path

    def export_usd(self, folder):
        """Lets Blender's own exporter write the scene; returns the file."""
        self.say("Exporting by USD")
        done = usd.write_scene(self.depsgraph, folder, stopped=self.engine.stopped)
        self.record.update(verdicts=done.verdicts, export=done.timings, changed_geometry=list(done.changed_geometry))
        if _Kept.folder is not None:
            self.record["kept"] = usd.write_scene(self.depsgraph, _Kept.folder, stopped=self.engine.stopped).path
        return done.path

    def camera_of(self, view):
        """What the program knows the camera of a view by. A file of USD has all cameras, by the names of their objects."""
        return self.scene.camera.name if self.by_usd else str(view)

    def watch(self, line, folder, frames):
        """Lets the program render, until its end or Esc."""
        self.frames = frames
        self.say("Loading")
        with Run(line, folder, environment=denoise.environment()) as run:
            while not run.ended:
                event = run.next(POLL)
                if event is not None:
                    self.handle(event, run)
                if self.engine.stopped():
                    self.stop(run)
                    return
            run.check()
        if not self.screen.shown:
            raise ProgramError("the program ended without a picture")

    def stop(self, run):
        """Takes what there is, quickly."""
        begun = time.perf_counter()
        run.interrupt()
        for event in run.rest(PATIENCE):
            self.handle(event, run)
        run.leave()
        self.record["stopped"] = time.perf_counter() - begun

    def handle(self, event, run):
        """One event of the program."""
        kind = event["event"]
        if kind == "frame":
            self.screen.show(event, self.frames, run.interrupted)
            if event["final"]:
                for name in self.screen.missing(event):
                    self.warn(f"the program has no pass \"{name}\": it stays empty")
            self.engine.update_memory_stats(memory_used=run.memory[0], memory_peak=run.memory[1])
        elif kind == "progress":
            self.progress(event, run)
        elif kind == "scene":
            self.record["settings"] = event.get("settings", {})
            self.engine.update_stats("", self.title + "Preparing")
        elif kind == "effects":
            self.record["called_for"] = event.get("effects", [])
        elif kind == "prepared":
            self.record.update(prepared=event.get("seconds"), effects=event.get("effects"), triangles=event.get("triangles"))
        elif kind == "denoising":
            self.engine.update_stats("", self.title + "Denoising")
        elif kind == "finished":
            self.record.update(statistics=event.get("statistics", {}), denoised=event.get("denoised"))
        elif kind == "warning":
            self.warn(str(event.get("message", "")))
        elif kind == "diagnostic":
            self.record["diagnostics"].append({key: value for key, value in event.items() if key != "event"})

    def progress(self, event, run):
        """Samples, time and error, for the header and the bar."""
        now = time.monotonic()
        if now - self.told < TELL_EVERY and event.get("fraction") != 1:
            return
        self.told = now
        done, layers = self.part
        number, count = self.view
        share = (number + min(max(event.get("fraction") or 0.0, 0.0), 1.0)) / count
        self.engine.update_progress((done + share) / layers)
        words = [f"Sample {event.get('samples', 0)}" + (f"/{event['of']}" if event.get("of") else "")]
        if event.get("remaining") is not None:
            words.append(f"Remaining {clock(event['remaining'])}")
        error = event.get("error")
        if error is not None:
            words.append(f"Error {error['error']:.2%}")
        if run.memory[0]:
            words.append(f"Memory {run.memory[0]:.0f} MB")
        self.engine.update_stats("", self.title + " | ".join(words))


class _Screen:
    """The render result of one view layer."""

    def __init__(self, engine, render, wanted, layer):
        self.engine, self.render, self.wanted, self.layer = engine, render, wanted, layer
        self.names = {p.program: p.name for p in wanted}
        # The views of stereo, of which the first ones are handed over, and the one that is shown.
        self.views, self.over = views.names(render), []
        self.view = self.views[0]
        self.results = []
        # Whether the results have been handed over as they are.
        self.handed_over = False
        self.shown = False

    def _begin(self):
        # Blender makes the passes that `update_render_passes` has registered.
        x0, y0, x1, y1 = command.border(self.render)
        self.results = [self.engine.begin_result(0, 0, x1 - x0, y1 - y0, layer=self.layer, view=self.view)]

    def look(self, view):
        """The frames to come are of this view."""
        if self.results:
            self._end()
        self.view, self.shown = view, False

    def show(self, event, folder, hurried=False):
        """Takes a frame that the program has written, and removes it."""
        path = os.path.join(folder, os.path.basename(event["file"]))
        x0, y0, x1, y1 = event["region"]
        try:
            if not self.results:
                self._begin()
            alone = hurried and os.path.getsize(path) > MOST_AFTER_ESC
            for entry in event["passes"]:
                if entry["name"] == passes.COMBINED.program or (entry["name"] in self.names and not alone):
                    self._copy(path, entry, (x1 - x0) * (y1 - y0))
            os.remove(path)
        except (ValueError, OSError) as error:
            raise ProgramError(f"the program wrote a broken frame: {error}") from error
        for result in self.results:
            self.engine.update_result(result)
        self.shown = self.handed_over = True

    def _copy(self, path, entry, pixels):
        values = numpy.memmap(path, numpy.float32, "r", entry["offset"], (pixels * len(entry["channels"]),))
        for result in self.results:
            for layer in result.layers:
                target = layer.passes.get(self.names[entry["name"]])
                if target is None:
                    continue
                if len(target.rect) != pixels or target.channels != len(entry["channels"]):
                    raise ValueError(f"its pass {entry['name']} has another size than Blender's")
                unit = passes.UNITS.get(entry["name"])
                target.rect.foreach_set(values if unit is None else values * numpy.float32(unit))

    def missing(self, event):
        """Blender's names of the passes that a frame has not."""
        written = {entry["name"] for entry in event["passes"]}
        return [p.name for p in self.wanted if p.program not in written]

    def close(self):
        """Hands the picture over. Always one, be it black: Blender crashes when it writes a layered file of none."""
        if not self.results:
            self._begin()
        self._end()
        for self.view in [view for view in self.views if view not in self.over]:
            self._begin()
            self._end()

    def _end(self):
        self.over.append(self.view)
        for result in self.results:
            # Cancelled, a result is not copied a second time: that takes 0.2 s of a large picture.
            self.engine.end_result(result, cancel=self.handed_over)
        self.results, self.handed_over = [], False


def clock(seconds):
    """Time as Blender shows it."""
    minutes, seconds = divmod(max(seconds, 0.0), 60)
    hours, minutes = divmod(int(minutes), 60)
    return f"{hours:02}:{minutes:02}:{seconds:05.2f}" if hours else f"{minutes:02}:{seconds:05.2f}"


def register():
    """Makes the engine known."""
    bpy.utils.register_class(SundogRenderEngine)
    bpy.types.WindowManager.sundog_record = bpy.props.StringProperty(
        name="Sundog's Last Render", description="Verdicts and statistics of the last render, as JSON", get=records.as_json
    )


def unregister():
    """Takes it away."""
    del bpy.types.WindowManager.sundog_record
    bpy.utils.unregister_class(SundogRenderEngine)
