# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders with both engines, measures, writes the files."""

import json
import os
import time

import bpy

from .. import engine, preferences, program
from ..process import ProgramError
from . import exr_header, settings, table

ENGINES = (("Sundog", "SUNDOG"), ("Cycles", "CYCLES"))
# Comparing two pictures of the largest size takes minutes (FLIP).
_PATIENCE = 3600


class CompareError(Exception):
    """Why there is no comparison, in one sentence."""


def run(filepath, folder, options=None, report=None, **named):
    """Compares the engines on the current scene, or on that of a .blend file, which is opened then.

    `options` (or its fields as named arguments) are `Options`. `report(fraction, text)` is told what happens. Writes
    sundog.exr, cycles.exr (linear), sundog.png, cycles.png (through the scene's view), difference.png (of the linear
    pictures), difference-view.png (of the others), comparison.json and comparison.md to the folder; returns what is in
    comparison.json. All settings are put back. Raises CompareError.
    """
    options = options or settings.Options(**named)
    report = report or (lambda fraction, text: None)
    if filepath is not None:
        open_file(filepath)
    scene = bpy.context.scene
    check(scene)
    folder = make_folder(folder)
    try:
        found = _compare(scene, folder, options, report)
        _write(folder, found)
    except ProgramError as error:
        raise CompareError(str(error)) from error
    except OSError as error:
        raise CompareError(f"{error.filename or folder}: {error.strerror or error}") from error
    report(1.0, "Done")
    return found


def make_folder(folder):
    """The folder, absolute; made if it is not there."""
    folder = os.path.abspath(bpy.path.abspath(folder))
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise CompareError(f"the folder {folder} cannot be made: {error.strerror}") from error
    return folder


def open_file(filepath):
    """Opens a .blend file."""
    if not os.path.isfile(filepath):
        raise CompareError(f"there is no file {filepath}")
    try:
        bpy.ops.wm.open_mainfile(filepath=os.path.abspath(filepath), load_ui=False)
    except RuntimeError as error:
        raise CompareError(f"{filepath} cannot be opened: {str(error).strip()}") from error


def check(scene):
    """Whether there is something to render with."""
    if scene.camera is None:
        raise CompareError(f"the scene \"{scene.name}\" has no camera: add one, or make one active with Ctrl+Numpad 0")
    if not hasattr(scene, "cycles"):
        raise CompareError("Cycles is not enabled: enable the add-on \"Cycles Render Engine\" in the preferences")


def _compare(scene, folder, options, report):
    with settings.Kept() as kept:
        settings.same_for_both(kept, scene, options)
        frame, subframe = scene.frame_current, scene.frame_subframe
        if options.frame is not None and options.frame != frame:
            scene.frame_set(options.frame)
        if not options.cycles_defaults:
            settings.as_sundog(kept, scene)
        try:
            sides = {}
            for index, (name, identifier) in enumerate(ENGINES):
                report(0.05 + 0.4 * index, f"Rendering with {name}")
                sides[name] = _render(scene, identifier, os.path.join(folder, name.lower()))
            report(0.85, "Measuring")
            return _found(scene, folder, options, sides)
        finally:
            if scene.frame_current != frame:
                scene.frame_set(frame, subframe=subframe)


def _render(scene, identifier, stem):
    """Renders to stem.exr and stem.png; returns the times."""
    if os.path.exists(stem + ".png"):
        os.remove(stem + ".png")
    told = render_linear(scene, identifier, stem + ".exr")
    _show(scene, stem)
    return {"exr": stem + ".exr", "png": stem + ".png", **told}


def render_linear(scene, identifier, path):
    """Renders linear light to an EXR file; returns the times."""
    if os.path.exists(path):
        os.remove(path)
    scene.render.engine = identifier
    scene.render.filepath = path
    settings.linear_exr(scene.render.image_settings)
    begun = time.perf_counter()
    try:
        bpy.ops.render.render(write_still=True, scene=scene.name)
    except RuntimeError as error:
        raise CompareError(str(error).strip().removeprefix("Error: ")) from error
    whole = time.perf_counter() - begun
    sundog = identifier == "SUNDOG"
    told = _told_by_sundog() if sundog else {}
    if not os.path.isfile(path):
        raise CompareError(f"{'Sundog' if sundog else 'Cycles'} has rendered nothing to {path}")
    return {"whole_call": whole, **(told or _told_by_cycles(path))}


def _show(scene, stem):
    """The linear picture through the scene's view, by Blender."""
    settings.display_png(scene.render.image_settings, scene.render.film_transparent)
    image = bpy.data.images.load(stem + ".exr")
    try:
        image.save_render(stem + ".png", scene=scene)
    finally:
        bpy.data.images.remove(image)


def _told_by_sundog():
    """Times of all view layers: the exporter's and the program's own."""
    layers = engine.last_statistics().get("layers", [])
    for layer in layers:
        # An error of the engine makes no exception of bpy.ops.render.render().
        if "error" in layer:
            raise CompareError(layer["error"])
    told = [layer["statistics"] for layer in layers if layer["statistics"]]
    if not told:
        raise CompareError("Sundog has told nothing of its render")
    errors = [one["error"] for one in told]
    return {
        "export": sum(layer["export"].get("total", 0.0) for layer in layers),
        "prepare": sum(layer["prepared"] or 0.0 for layer in layers),
        "render": sum(_seconds(one["trace"]) for one in told),
        "samples": [one["samples"] for one in told],
        # The estimate belongs to the picture of one layer.
        "error": errors[0] if len(errors) == 1 else None,
        "version": layers[-1].get("version"),
        "not_exact": sum(verdict["verdict"] != "exact" for verdict in engine.last_verdicts()),
    }


def _seconds(duration):
    return duration["secs"] + duration["nanos"] * 1e-9


def _told_by_cycles(path):
    """Times of all view layers: what Cycles writes into the header of the picture, to a hundredth of a second."""
    try:
        attributes = exr_header.text_attributes(path)
    except ValueError as error:
        raise CompareError(str(error)) from error
    told = {"synchronization_time": [], "render_time": [], "samples": []}
    for key, value in attributes.items():
        parts = key.split(".")
        if parts[0] == "cycles" and parts[-1] in told:
            told[parts[-1]].append(value)
    if not told["render_time"] or not told["samples"]:
        raise CompareError(f"Cycles does not say in {path} how long it took")
    return {
        "export": sum(map(exr_header.seconds, told["synchronization_time"])),
        "prepare": None,
        "render": sum(map(exr_header.seconds, told["render_time"])),
        "samples": [int(samples) for samples in told["samples"]],
        "error": None,
        "version": bpy.app.version_string,
    }


def _found(scene, folder, options, sides):
    linear = _measure(sides, "exr", os.path.join(folder, "difference.png"))
    shown = _measure(sides, "png", os.path.join(folder, "difference-view.png"))
    x0, y0, x1, y1 = table.rendered_pixels(scene.render)
    for side in sides.values():
        side["ns_per_sample"] = side["render"] * 1e9 / ((x1 - x0) * (y1 - y0) * sum(side["samples"]))
    adaptive = bool(options.cycles_defaults and scene.cycles.use_adaptive_sampling)
    if adaptive:
        # How many samples the pixels got is not told.
        sides["Cycles"]["ns_per_sample"] = None
    return {
        "file": bpy.data.filepath,
        "scene": scene.name,
        "frame": scene.frame_current,
        "size": [linear["width"], linear["height"]],
        "threads": scene.render.threads,
        "matched": not options.cycles_defaults,
        "view": [scene.display_settings.display_device, scene.view_settings.view_transform, scene.view_settings.look],
        "bounces": scene.sundog.max_bounces,
        "seed": scene.sundog.seed,
        "denoised": bool(options.cycles_defaults and scene.cycles.use_denoising),
        "adaptive": adaptive,
        "engines": sides,
        "linear": linear,
        "shown": shown,
        "verdicts": [verdict for verdict in engine.last_verdicts() if verdict["verdict"] != "exact"],
        "files": {"difference": os.path.join(folder, "difference.png"), "difference_view": os.path.join(folder, "difference-view.png")},
    }


def _measure(sides, kind, difference_map):
    """What `sundog compare` says of Sundog's picture against Cycles'."""
    path, _source = preferences.find_program()
    said = program.ask(
        path, "compare", sides["Sundog"][kind], sides["Cycles"][kind], "--difference-map", difference_map, "--json", seconds=_PATIENCE
    )
    try:
        return json.loads(said)
    except ValueError as error:
        raise CompareError(f"{path} compare has answered with what is no JSON") from error


def _write(folder, found):
    for name, text in (("comparison.json", json.dumps(found, indent=1) + "\n"), ("comparison.md", table.markdown(found))):
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(text)
