# SPDX-License-Identifier: MIT OR Apache-2.0
"""Measures Sundog against Cycles, in one run, and writes docs/notes/benchmarks.md.

    PYTHON_WITH_BPY scripts/benchmark.py [SCENE...] [--out FILE] [--repeats 3] [--samples 64] [--pixels 40000]

For each scene of the gallery, alternately and `--repeats` times: Cycles with its defaults, Sundog with the same biased
settings (indirect light clamped at 10, filter glossy 1), Cycles without what biases it, Sundog as it is; the same size,
samples a pixel, bounces and filter, seeds all different. So each is set beside a peer that pays the same error for speed.

Time is that of path tracing alone (no loading, no building of structures), median of the repeats, on all cores. Each
program says it itself: Sundog in its last event, Cycles in its log from the first sample to the end.

The error is relMSE = mean of (x - r)^2 / (r^2 + 0.01). The reference r is made of both: a = Cycles without bias, b =
Sundog, each with four times the samples. (x - a)(x - b) has the expectation (x - r)^2 because the noise of a and b is
independent, so the reference need not be free of noise.
"""

import argparse
import json
import math
import os
import platform
import shutil
import statistics
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "tests", "pictures"))

import numpy as np  # noqa: E402

import bpy  # noqa: E402
import compare  # noqa: E402

REFERENCE_FACTOR = 4
# What Cycles' defaults do to the light, in Sundog's words. (Its light threshold of 0.01 has no counterpart here.)
CYCLES_DEFAULTS = ("--clamp-indirect=10", "--filter-glossy=1")
WAYS = ("Cycles, defaults", "Sundog, same settings", "Cycles, unbiased", "Sundog, unbiased")
SCENES = ["cornell", "three-objects", "window-room", "many-lights", "glass", "material-wall", "foliage"]


def cycles(name, folder, path, size, samples, seed, *more):
    """Renders with Cycles; gives its path tracing seconds and the CPU seconds of the whole render call."""
    said = compare.run(
        [sys.executable, os.path.join(ROOT, "scenes", "render_cycles.py"), os.path.join(folder, f"{name}.blend"), path, "--samples",
         str(samples), "--seed", str(seed), "--width", str(size[0]), "--height", str(size[1]), *more], f"Cycles' picture of {name}")
    told = json.loads(said.strip().splitlines()[-1])
    if told["seconds"] is None:
        raise compare.Failure(f"Cycles' log of {name} does not say when it began and ended")
    return told["seconds"]


def seconds_of(duration):
    """A duration as the program writes it: seconds, or {"secs", "nanos"}."""
    if isinstance(duration, dict):
        return duration["secs"] + duration["nanos"] * 1e-9
    return float(duration)


def sundog(name, folder, path, size, samples, seed, program, *more):
    """Renders with Sundog; gives its path tracing seconds."""
    command = compare.sundog_command(program, folder, name, path, size, samples, seed) + ["--json", *more]
    said = compare.run(command, f"Sundog's picture of {name}")
    for line in reversed(said.splitlines()):
        event = json.loads(line)
        if event.get("event") == "finished":
            return seconds_of(event["statistics"]["trace"])
    raise compare.Failure(f"Sundog did not say that {name} is finished")


def relative_error(x, a, b):
    """relMSE of one picture against the reference's two independent halves."""
    r = (a + b) / 2.0
    return float(((x - a) * (x - b) / (r * r + 0.01)).mean())


def measure(name, given, folder):
    with open(os.path.join(folder, f"{name}.json")) as file:
        settings = json.load(file)
    # The exact ratio of the sides: Blender and Sundog fit a camera differently into another one.
    common = math.gcd(settings["width"], settings["height"])
    across, down = settings["width"] // common, settings["height"] // common
    times = max(1, round(math.sqrt(given.pixels / (across * down))))
    size = (across * times, down * times)
    out = lambda word: os.path.join(folder, f"{name}-benchmark-{word}.exr")
    cycles(name, folder, out("a"), size, given.samples * REFERENCE_FACTOR, 900)
    sundog(name, folder, out("b"), size, given.samples * REFERENCE_FACTOR, 901, given.sundog)
    a, b = compare.read_exr(out("a")), compare.read_exr(out("b"))
    renders = (
        lambda path, seed: cycles(name, folder, path, size, given.samples, seed, "--defaults"),
        lambda path, seed: sundog(name, folder, path, size, given.samples, seed, given.sundog, *CYCLES_DEFAULTS),
        lambda path, seed: cycles(name, folder, path, size, given.samples, seed),
        lambda path, seed: sundog(name, folder, path, size, given.samples, seed, given.sundog),
    )
    ways = dict(zip(WAYS, renders))
    seconds, errors = {way: [] for way in ways}, {way: [] for way in ways}
    for repeat in range(given.repeats):
        for index, (way, render) in enumerate(ways.items()):
            path = out("x")
            seconds[way].append(render(path, 1000 + 10 * repeat + index))
            errors[way].append(relative_error(compare.read_exr(path), a, b))
    whole = size[0] * size[1] * given.samples
    return size, {
        way: {
            "ns": statistics.median(seconds[way]) / whole * 1e9,
            "spread": (max(seconds[way]) - min(seconds[way])) / statistics.median(seconds[way]),
            "error": statistics.mean(errors[way]),
            "cost": statistics.median(seconds[way]) * statistics.mean(errors[way]),
        }
        for way in ways
    }


def processor():
    try:
        with open("/proc/cpuinfo") as file:
            return next(line.split(":", 1)[1].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or "unknown"


def commit():
    """The commit that is measured; "unknown" in an unpacked archive, whose parent folder may be another project's."""
    if not os.path.exists(os.path.join(ROOT, ".git")) or shutil.which("git") is None:
        return "unknown"
    done = subprocess.run(["git", "-C", ROOT, "describe", "--always", "--dirty"], capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"


def table(title, value, form, rows):
    """A table of one figure of all ways, with the ratio of the two programs in each pair."""
    lines = [title, "", "| scene | size | " + " | ".join(WAYS) + " | Sundog / Cycles, same settings | Sundog / Cycles, unbiased |",
             "| --- " * (len(WAYS) + 4) + "|"]
    for name, (size, ways) in rows.items():
        figures = [ways[way][value] for way in WAYS]
        lines.append(f"| {name} | {size[0]} x {size[1]} | " + " | ".join(form.format(figure) for figure in figures)
                     + f" | {figures[1] / figures[0]:.2f} | {figures[3] / figures[2]:.2f} |")
    return lines


def page(rows, given, begun):
    spread = max(way["spread"] for _, ways in rows.values() for way in ways.values())
    typical = statistics.median(way["spread"] for _, ways in rows.values() for way in ways.values())
    lines = [
        "# Benchmarks",
        "",
        "Made by `scripts/benchmark.py` in one run; nothing in this part is typed by hand.",
        "",
        f"- {time.strftime('%Y-%m-%d %H:%M', time.gmtime(begun))} UTC, Sundog {commit()}, Cycles of Blender {bpy.app.version_string} on the CPU.",
        f"- {processor()}, {os.cpu_count()} logical processors, load {os.getloadavg()[0]:.1f} at the end (about {os.cpu_count()} is this run alone).",
        f"- {given.samples} samples a pixel, about {given.pixels} pixels, {given.repeats} repeats taken in turn; times are medians of the path",
        f"  tracing alone, on all processors; (longest - shortest) / median of a time is {typical:.0%} typically, {spread:.0%} at most.",
        "- \"Cycles, defaults\" is with its defaults (light tree, tabulated Sobol, indirect clamp 10, filter glossy 1, light threshold",
        "  0.01) but with adaptive sampling and denoising off, so that samples can be counted, and with the scene's number of bounces.",
        f"  \"Sundog, same settings\" is with `{' '.join(CYCLES_DEFAULTS)}`. \"Unbiased\" is without any of these: for Sundog its own",
        "  defaults. Cycles' log gives times to a hundredth of a second.",
        f"- relMSE = mean of (x - r)^2 / (r^2 + 0.01), r from both unbiased programs with {REFERENCE_FACTOR} times the samples, mean of the repeats;",
        "  the reference's noise is taken out as the script says. The bias of the defaults counts as error.",
        "",
    ]
    lines += table("ns per pixel sample (lower is better):", "ns", "{:.0f}", rows) + [""]
    lines += table("relMSE at these samples:", "error", "{:.4f}", rows) + [""]
    lines += table("Time x relMSE in seconds (lower is better):", "cost", "{:.4f}", rows)
    lines += ["", f"The run took {(time.time() - begun) / 60:.0f} minutes.", ""]
    return "\n".join(lines)


def other_parts(path):
    """The sections of the page that are not of this script (the time of the export, how to read it)."""
    if not os.path.exists(path):
        return ""
    with open(path) as file:
        text = file.read()
    return text[text.index("\n## "):] if "\n## " in text else ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--out", default=os.path.join(ROOT, "docs", "notes", "benchmarks.md"))
    parser.add_argument("--sundog", default=os.path.join(ROOT, "target", "release", "sundog"))
    parser.add_argument("--folder", default=os.path.join(ROOT, "target", "benchmark"))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--pixels", type=int, default=40_000)
    given = parser.parse_args()
    begun = time.time()
    os.makedirs(given.folder, exist_ok=True)
    compare.build_scenes(given.scenes, given.folder)
    rows = {}
    for name in given.scenes:
        rows[name] = measure(name, given, given.folder)
        print(name, json.dumps(rows[name]), flush=True)
    text = page(rows, given, begun) + other_parts(given.out)
    beside = given.out + ".new"
    with open(beside, "w") as file:
        file.write(text)
    os.replace(beside, given.out)
    print(text)


if __name__ == "__main__":
    main()
