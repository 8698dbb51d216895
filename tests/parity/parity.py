# SPDX-License-Identifier: GPL-3.0-or-later
"""Sundog through the add-on against Cycles, on scenes that nobody here made: writes docs/notes/cycles-parity.md.

    PYTHON_WITH_BPY tests/parity/parity.py FOLDER_OF_SCENES [NAME...] [--out FILE] [--keep FOLDER] [--fresh]

FOLDER_OF_SCENES holds glTF and USD files in folders (the glTF Sample Assets, Pixar's and OpenUSD's test scenes), with .hdr
pictures in `hdri-open` for those that bring no light. The scenes of traps.py are added. Each is rendered twice by each
program with different seeds, so that the noise cancels from relMSE:

relMSE: mean of (x1 - r1) (x2 - r2) / (r² + 0.01), x Sundog's, r Cycles'; its expectation is that of converged pictures, but
    for the weight, which takes r = (r1 + r2) / 2. With its standard error over the pixels.
luminance: the ratio of the mean luminances, with its standard error from the differences between the two seeds' pixels.
FLIP: of the means of both, as `sundog compare` has it; noise counts here.

A result that lies in FOLDER (--keep) already is taken from there, unless --fresh is given.
"""

import argparse
import glob
import json
import math
import os
import subprocess
import sys
import time

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
sys.path.insert(0, HERE)
sys.path.insert(0, os.path.join(ROOT, "tests", "pictures"))

import bpy  # noqa: E402
import compare  # noqa: E402
import reasons  # noqa: E402
import traps  # noqa: E402

ENVIRONMENT = "hdri-open/studio_small_05_1k.hdr"
LIMIT = 600


def files(folder):
    """(name, path) of every scene file of a folder; of glTF folders the one the index names."""
    with open(os.path.join(folder, "index.json")) as file:
        index = json.load(file)
    for entry in index:
        place = os.path.join(folder, entry["name"])
        main = os.path.join(place, entry["main"]) if entry.get("main") else ""
        if entry["format"] == "gltf" or entry["main"].endswith((".gltf", ".glb")):
            yield entry["name"], main
            continue
        found = sorted(glob.glob(os.path.join(glob.escape(place), "**", "*.usd*"), recursive=True))
        wanted = [main] if entry["name"] in {"usd-teapot", "usd-roughness-usdz"} else [p for p in found if "/baseline/" not in p]
        for path in wanted:
            inner = os.path.relpath(path, place)
            yield (entry["name"] if len(wanted) == 1 else f"{entry['name']}/{inner}"), path


def measure(name, path, given):
    folder = os.path.join(given.keep, name.replace("/", "_"))
    result = os.path.join(folder, "result.json")
    if os.path.exists(result) and not given.fresh:
        with open(result) as file:
            return json.load(file)
    os.makedirs(folder, exist_ok=True)
    own = os.path.join(os.path.dirname(path), "env.exr")
    environment = own if os.path.exists(own) else os.path.join(given.scenes, ENVIRONMENT)
    command = [sys.executable, os.path.join(HERE, "one.py"), path, folder, "--samples", str(given.samples), "--pixels", str(given.pixels),
               "--environment", environment]
    if name.startswith(("lit-", "trap-")):
        command.append("--own-camera")
    variables = dict(os.environ, SUNDOG_PROGRAM=given.sundog)
    with open(os.path.join(folder, "log.txt"), "w") as log:
        try:
            done = subprocess.run(command, stdout=log, stderr=log, timeout=LIMIT, env=variables, check=False)
        except subprocess.TimeoutExpired:
            return {"problem": f"no picture within {LIMIT} s"}
    if done.returncode != 0:
        with open(log.name) as file:
            said = [line for line in file.read().splitlines() if line.strip()]
        return {"problem": "failed: " + (said[-1] if said else f"ended with {done.returncode}")}
    with open(os.path.join(folder, "told.json")) as file:
        told = json.load(file)
    if told["problem"] is None:
        told.update(figures(folder, given.sundog))
        with open(result, "w") as file:
            json.dump(told, file)
    return told


def figures(folder, program):
    pictures = {engine: [compare.read_exr(os.path.join(folder, f"{engine}-{i}.exr")) for i in range(2)] for engine in ("cycles", "sundog")}
    x, r = pictures["sundog"], pictures["cycles"]
    weight = 1 / (((r[0] + r[1]) / 2) ** 2 + 0.01)
    product = ((x[0] - r[0]) * (x[1] - r[1]) * weight).mean(axis=2).ravel()
    (ours, our_error), (theirs, their_error) = compare.mean_and_error(x), compare.mean_and_error(r)
    flip = flip_of_means(folder, pictures, program)
    ratio = ours / theirs if theirs > 0 else math.nan
    return {
        "relmse": product.mean(), "relmse_error": product.std(ddof=1) / math.sqrt(product.size),
        "luminance": ratio, "luminance_error": ratio * math.hypot(our_error / max(ours, 1e-30), their_error / max(theirs, 1e-30)),
        "flip": flip, "black": bool(theirs == 0),
    }


def flip_of_means(folder, pictures, program):
    paths = []
    for engine, both in pictures.items():
        mean = (both[0] + both[1]) / 2
        height, width, _ = mean.shape
        image = bpy.data.images.new(engine, width, height, float_buffer=True)
        image.colorspace_settings.name = "Non-Color"
        pixels = np.ones((height, width, 4), np.float32)
        pixels[:, :, :3] = mean[::-1]
        image.pixels.foreach_set(pixels.ravel())
        image.file_format = "OPEN_EXR"
        image.filepath_raw = os.path.join(folder, f"{engine}-mean.exr")
        image.save()
        paths.append(image.filepath_raw)
        bpy.data.images.remove(image)
        subprocess.run([program, "color", "apply", paths[-1], paths[-1].replace(".exr", ".png"), "--view", "Standard"], check=True,
                       capture_output=True)
    told = compare.run([program, "compare", paths[1], paths[0], "--json"], "the comparison")
    return json.loads(told)["flip"]


def row(name, told):
    if told.get("problem"):
        return f"| {name} | | | | | {told['problem']} |"
    counts = {v: sum(1 for entry in told["verdicts"] if entry["verdict"] == v) for v in ("exact", "approximated", "lost")}
    verdicts = " / ".join(str(counts[v]) for v in counts)
    luminance = f"{told['luminance']:.4f} ± {told['luminance_error']:.4f}"
    relmse = f"{told['relmse']:.2e} ± {told['relmse_error']:.0e}"
    return f"| {name} | {verdicts} | {luminance} | {relmse} | {told['flip']:.3f} | {reasons.of(name, told)} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes")
    parser.add_argument("names", nargs="*")
    parser.add_argument("--out", default=os.path.join(ROOT, "docs", "notes", "cycles-parity.md"))
    parser.add_argument("--keep", default=os.path.join(ROOT, "target", "parity"))
    parser.add_argument("--sundog", default=os.path.join(ROOT, "target", "release", "sundog"))
    parser.add_argument("--samples", type=int, default=256)
    parser.add_argument("--pixels", type=int, default=9600)
    parser.add_argument("--fresh", action="store_true")
    given = parser.parse_args()
    everything = [(name, name) for name in traps.SCENES] + list(files(given.scenes))
    chosen = [(n, p) for n, p in everything if not given.names or any(n.startswith(w) for w in given.names)]
    rows = []
    for name, path in chosen:
        begun = time.time()
        rows.append((name, measure(name, path, given)))
        print(row(*rows[-1]), f"[{time.time() - begun:.0f} s]", flush=True)
    if given.names:
        return
    text = reasons.page([row(*r) for r in rows], [told for _, told in rows], given, bpy.app.version_string)
    with open(given.out + ".new", "w") as file:
        file.write(text)
    os.replace(given.out + ".new", given.out)


if __name__ == "__main__":
    main()
