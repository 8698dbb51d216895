# SPDX-License-Identifier: MIT OR Apache-2.0
"""Renders a .blend of build.py with Cycles on the CPU, as the reference for Sundog.

    PYTHON_WITH_BPY scenes/render_cycles.py NAME.blend OUT.exr --samples N [--seed S] [--width W --height H] ...

Writes the scene-linear combined picture as a 32-bit EXR and prints one line of JSON with the seconds that path tracing
took. Unless `--defaults` is given, all that would bias the picture is off: clamping, filter glossy, adaptive sampling,
denoising, the light threshold. Several pictures of one scene: repeat OUT.exr and --seed as `--more OUT.exr:SEED`.
"""

import argparse
import contextlib
import json
import os
import re
import sys
import tempfile
import time

import bpy


def set_up(settings, given):
    """Sets Cycles to a plain, unbiased path tracer with the limits of `settings` (NAME.json)."""
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    cycles.device = "CPU"
    render.resolution_x = given.width or settings["width"]
    render.resolution_y = given.height or settings["height"]
    render.resolution_percentage = 100
    render.use_motion_blur = False
    render.film_transparent = False
    render.use_compositing = False
    render.use_sequencer = False
    render.use_persistent_data = True
    if given.threads:
        render.threads_mode = "FIXED"
        render.threads = given.threads
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode = "RGBA"
    render.image_settings.color_depth = "32"
    render.image_settings.exr_codec = "ZIP"

    cycles.samples = given.samples
    cycles.use_adaptive_sampling = given.adaptive is not None
    if given.adaptive is not None:
        cycles.adaptive_threshold = given.adaptive
    cycles.use_denoising = False
    cycles.time_limit = 0.0
    cycles.film_exposure = 1.0
    cycles.use_auto_tile = False

    bounces = settings["bounces"]
    cycles.max_bounces = bounces
    cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
    cycles.transparent_max_bounces = 256

    # The pixel filter: the width is the whole width in pixels, as in Sundog.
    cycles.pixel_filter_type = {"blackman-harris": "BLACKMAN_HARRIS", "gauss": "GAUSSIAN", "box": "BOX"}[settings["filter"]]
    cycles.filter_width = 1.5

    if not given.defaults:
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
        cycles.blur_glossy = 0.0
        cycles.caustics_reflective = cycles.caustics_refractive = True
        cycles.light_sampling_threshold = 0.0
        cycles.use_fast_gi = False
        cycles.use_guiding = False


def render(path, seed):
    """Renders and saves one picture; gives the seconds of it all, of the path tracing alone, and what Blender said."""
    scene = bpy.context.scene
    scene.cycles.seed = seed
    scene.render.filepath = path
    with cycles_log() as log:
        begun = time.perf_counter()
        bpy.ops.render.render(write_still=True)
        whole = time.perf_counter() - begun
    return whole, path_tracing_seconds(log), log


def path_tracing_seconds(log):
    """Seconds between Cycles' lines "Sample 0/N" and "Finished", to a hundredth; None if they are missing."""
    begun = done = None
    for line in log:
        found = re.search(r"Time:(\d+):(\d+\.\d+) .*\| (Sample 0/|Finished)", line)
        if found:
            seconds = int(found[1]) * 60 + float(found[2])
            begun, done = (seconds, done) if found[3] == "Sample 0/" else (begun, seconds)
    return None if begun is None or done is None else round(done - begun, 2)


@contextlib.contextmanager
def cycles_log():
    """Collects what Blender says on standard output while a picture is rendered."""
    lines = []
    sys.stdout.flush()
    with tempfile.TemporaryFile() as file:
        keep = os.dup(1)
        os.dup2(file.fileno(), 1)
        try:
            yield lines
        finally:
            sys.stdout.flush()
            os.dup2(keep, 1)
            os.close(keep)
            file.seek(0)
            lines += file.read().decode(errors="replace").splitlines()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("blend")
    parser.add_argument("out")
    parser.add_argument("--samples", type=int, required=True)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--more", action="append", default=[], metavar="OUT.exr:SEED", help="another picture, other seed")
    parser.add_argument("--width", type=int)
    parser.add_argument("--height", type=int)
    parser.add_argument("--bounces", type=int)
    parser.add_argument("--threads", type=int)
    parser.add_argument("--adaptive", type=float, metavar="THRESHOLD", help="adaptive sampling (0: Cycles' own choice)")
    parser.add_argument("--defaults", action="store_true", help="keep Cycles' default clamping, filter glossy and thresholds")
    given = parser.parse_args()

    with open(os.path.splitext(given.blend)[0] + ".json") as file:
        settings = json.load(file)
    if given.bounces is not None:
        settings["bounces"] = given.bounces
    with cycles_log():
        bpy.ops.wm.open_mainfile(filepath=os.path.abspath(given.blend))
    set_up(settings, given)
    wanted = [(given.out, given.seed)]
    for more in given.more:
        path, seed = more.rsplit(":", 1)
        wanted.append((path, int(seed)))
    for path, seed in wanted:
        whole, tracing, log = render(os.path.abspath(path), seed)
        if os.environ.get("SUNDOG_CYCLES_LOG"):
            print("\n".join(log), file=sys.stderr)
        told = {"picture": path, "seed": seed, "samples": given.samples, "seconds": tracing}
        print(json.dumps({**told, "whole_seconds": round(whole, 3)}), flush=True)


if __name__ == "__main__":
    main()
