# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles' error against time, as a folder that `sundog converge --against` reads (docs/converge.md)."""

import json
import os
import shlex

import bpy

from .. import engine
from ..process import ProgramError
from . import job, settings

# The reference has so many times the samples of the longest picture, in each of its two halves …
REFERENCE_FACTOR = 4
# … and seeds so far from those of the pictures.
_REFERENCE_SEED = 1_000_000
# What `sundog converge` decides itself, and what is of passes that it has not.
_OWN = {
    "--samples", "--seed", "--time", "--noise", "--frames", "--json", "--error", "--pixel-error", "--noise-threshold", "--min-samples",
    "--passes", "--mist", "--ao-distance", "--alpha-threshold", "--centre-passes",
}


def doubling(most):
    """1, 2, 4 … up to `most`, which is the last."""
    steps = [1]
    while steps[-1] * 2 < most:
        steps.append(steps[-1] * 2)
    return steps if most == 1 else [*steps, most]


def run(filepath, folder, options=None, seeds=3, report=None, **named):
    """Renders the current scene (or that of a .blend file, which is opened) with Cycles: `seeds` times 1, 2, 4 … samples, and
    two independent references. Writes the pictures, cycles.times.json and the scene as Sundog renders it to the folder; returns
    what the .json holds, its "command" being what measures it. All settings are put back. Raises CompareError.
    """
    options = options or settings.Options(**named)
    report = report or (lambda fraction, text: None)
    if filepath is not None:
        job.open_file(filepath)
    scene = bpy.context.scene
    job.check(scene)
    folder = job.make_folder(folder)
    try:
        found = _converge(scene, folder, options, seeds, report)
        with open(os.path.join(folder, "cycles.times.json"), "w", encoding="utf-8") as file:
            json.dump(found, file, indent=1)
    except ProgramError as error:
        raise job.CompareError(str(error)) from error
    except OSError as error:
        raise job.CompareError(f"{error.filename or folder}: {error.strerror or error}") from error
    report(1.0, "Done")
    return found


def _converge(scene, folder, options, seeds, report):
    most = options.samples or scene.sundog.samples
    steps = doubling(most)
    work = seeds * sum(steps) + 2 * REFERENCE_FACTOR * most
    done = 0
    with settings.Kept() as kept:
        settings.same_for_both(kept, scene, options)
        if not options.samples or options.cycles_defaults:
            for layer in scene.view_layers:
                # Would win over the scene's.
                kept.set(layer, samples=0)
        frame, subframe = scene.frame_current, scene.frame_subframe
        if options.frame is not None and options.frame != frame:
            scene.frame_set(options.frame)
        if options.cycles_defaults:
            # Samples have to be counted, and each picture to be independent of the others.
            kept.set(
                scene.cycles, samples=most, seed=0, use_adaptive_sampling=False, use_denoising=False, time_limit=0.0, use_animated_seed=False,
                use_sample_subset=False, sample_offset=0,
            )  # fmt: skip
        else:
            settings.as_sundog(kept, scene)
        first = scene.sundog.seed
        try:
            command = _keep_scene(scene, folder, report)

            def picture(name, samples, seed):
                nonlocal done
                report(0.05 + 0.95 * done / work, f"Rendering {samples} samples a pixel with Cycles, seed {seed}")
                scene.cycles.samples, scene.cycles.seed = samples, seed
                told = job.render_linear(scene, "CYCLES", os.path.join(folder, name))
                done += samples
                # The log has hundredths of a second: what it rounds to nothing took less than half of one.
                return {"file": name, "samples": samples, "seconds": max(told["render"], 0.005), "seed": seed}

            seeds_of_pictures = range(first, first + seeds)
            pictures = [picture(f"cycles-{seed}-{samples}.exr", samples, seed) for seed in seeds_of_pictures for samples in steps]
            reference = [
                picture(f"cycles-reference-{half}.exr", REFERENCE_FACTOR * most, _REFERENCE_SEED + first + index)["file"]
                for index, half in enumerate("ab")
            ]
        finally:
            if scene.frame_current != frame:
                scene.frame_set(frame, subframe=subframe)
    return {
        "renderer": f"Cycles {bpy.app.version_string}" + (", its own settings" if options.cycles_defaults else ""),
        "pictures": pictures,
        "reference": reference,
        "scene": scene.name,
        "file": bpy.data.filepath,
        "command": shlex.join(
            ["sundog", "converge", *command, "--samples", str(most), "--seeds", str(seeds), "--seed", str(first), "--against", folder]
        ),
    }


def _keep_scene(scene, folder, report):
    """Has the engine render once, which exports the scene, and keeps that; returns it with the flags that belong to it."""
    report(0.0, "Exporting the scene")
    samples = scene.sundog.samples
    scene.sundog.samples = 1
    place = os.path.join(folder, "scene")
    os.makedirs(place, exist_ok=True)
    path = os.path.join(folder, "sundog-1.exr")
    engine.keep_scenes_in(place)
    try:
        job.render_linear(scene, "SUNDOG", path)
    finally:
        engine.keep_scenes_in(None)
        scene.sundog.samples = samples
    if os.path.exists(path):
        os.remove(path)
    layers = engine.last_statistics().get("layers", [])
    if len(layers) != 1:
        raise job.CompareError("error against time is measured of one view layer: leave only one to be rendered")
    return [layers[0]["kept"], *_flags(layers[0]["command"])]


def _flags(line):
    """Those of the picture and of light transport."""
    result, rest = [], list(line[3:])
    while rest:
        flag = rest.pop(0)
        values = []
        while rest and not rest[0].startswith("--"):
            values.append(rest.pop(0))
        if flag not in _OWN and not flag.startswith("--denoise"):
            result += [flag, *values]
    return result
