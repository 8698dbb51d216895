# SPDX-License-Identifier: MIT OR Apache-2.0
"""Compares Sundog's pictures of the project's scenes with Cycles'.

    PYTHON_WITH_BPY tests/pictures/compare.py [SCENE...] [--sundog PATH] [--more FACTOR] [--keep FOLDER]

Builds the scenes, renders each four times with Cycles and four times with Sundog (all seeds different), and asks two
questions whose answers do not depend on how noisy the pictures are, only their standard errors do:

relMSE, the mean over pixels and channels of (x - r)^2 / (r^2 + 0.01) for converged x (Sundog) and r (Cycles). With
    independent pictures x_i and r_i, the product (x_i - r_i)(x_j - r_j) for i != j has the expectation (x - r)^2: the
    noise cancels. Its weight 1 / (r^2 + 0.01) is taken from the two Cycles pictures that are neither i nor j, so that it
    is independent of the product. All six pairs are averaged (a U-statistic). The pixels' noise is independent, so the
    standard error is that of a mean over pixels. Rule: estimate + 2 standard errors <= bound.

luminance, the ratio of the mean luminances. Rule: |ratio - 1| + 2 standard errors <= bound.

So a noisy comparison fails rather than passes: too few samples widen the standard error. The scenes of the gallery are
rendered twice more, with light sampling alone and with BSDF sampling alone: their mean luminances may differ from that of
both together by at most three standard errors of the difference. Cycles' pictures are kept in
~/.cache/sundog/references under a hash of the scene, the scripts, bpy's version and the settings.
"""

import argparse
import ast
import hashlib
import json
import math
import os
import shutil
import subprocess
import sys
import time

import bpy
import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPTS = os.path.join(ROOT, "scenes")
REPLICATES = 4
RELATIVE_ERROR_BOUND = 1e-3
LUMINANCE_BOUND = 0.01
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

# Width, height (in the exact ratio of the scene's picture), and samples a pixel of one replicate: Cycles', Sundog's. Enough
# for the standard errors that the rules want, and no more; see `--more` for a closer look. (For a given number of samples in
# all the standard error of relMSE grows with the root of the number of pixels, so the pictures are tiny.)
SETTINGS = {
    "cornell": (64, 64, 160, 160),
    "three-objects": (64, 36, 768, 2048),
    "window-room": (72, 48, 256, 256),
    "many-lights": (48, 27, 512, 512),
    "glass": (80, 45, 256, 256),
    "material-wall": (80, 50, 160, 160),
    "foliage": (80, 45, 96, 96),
}
# Not compared unless asked for: its luminance is that of a few bright discs, and to know it to a percent would take more samples than all
# other scenes together. (48 x 27 pixels, 4 x 1024 samples: luminance 0.990 +- 0.010, relMSE 1.2e-4 +- 3e-4.)
TOO_NOISY = ("shallow-focus",)
TECHNIQUES = ("nee", "bsdf")
# Told, but not judged: light sampling alone meets the narrow lobes of rough glass with weights so far apart that standard errors say nothing. Of 12
# pictures of 96 x 54 pixels and 64 samples eleven have 0.951 to 1.024 of the light and one 1.787 (mean 1.05 +- 0.07); four of 1024 samples 0.993.
WITHOUT_BOUND = (("glass", "nee"),)
GALLERY = tuple(SETTINGS)
PROBE_SAMPLES = (64, 64)
SETTINGS["probe-normal-map"] = (96, 72, 192, 192)
SETTINGS["probe-terminator"] = (64, 48, 192, 192)

# Differences that are understood: scene -> (bound on relMSE, bound on |luminance ratio - 1|, why).
#
# Rough glass: a white ball before a white world returns 1.03 at roughness 0.5 and 1.12 at 1 in Cycles, whose tables of its
# albedo are coarse (docs/cycles.md), and 1 in Sundog. The means of these probes are 0.989 and 0.972 of Cycles'. At roughness 1
# tinted glass has 0.925 of Cycles' light and white glass 0.917, since the light of further scatterings is tinted, too.
COARSE_GLASS = "Cycles' rough glass gains energy"
EXCEPTIONS = {
    "probe-furnace": (1.2e-3, 0.014, COARSE_GLASS),
    "probe-glass": (4.0e-3, 0.030, COARSE_GLASS),
}


class Failure(Exception):
    """Something that keeps the comparison from being made; its text is one sentence for the reader."""


def run(command, what):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        said = (done.stderr.strip() or done.stdout.strip()).splitlines()
        raise Failure(f"{what}: {' '.join(command[:3])}… ended with {done.returncode}: {' / '.join(said[-3:])}")
    return done.stdout


def build_scenes(names, folder):
    run([sys.executable, os.path.join(SCRIPTS, "build.py"), *names, folder], "building the scenes")


def digest(*parts):
    state = hashlib.sha256()
    for part in parts:
        state.update(str(len(part)).encode() + b":" + part)
    return state.hexdigest()[:24]


def inputs(name, folder):
    """The bytes that Cycles' picture of a built scene depends on: what was exported, and the scripts that set the rest.

    Not the .blend itself: it holds dates and paths. What glTF does not carry is set in kit.py and build.py alone. Of the
    scripts the syntax trees, so that comments may change.
    """
    with open(os.path.join(folder, f"{name}.json")) as file:
        environment = json.load(file)["environment"]
    paths = [os.path.join(folder, f"{name}.glb"), os.path.join(folder, f"{name}.json")]
    paths += [os.path.join(folder, environment)] if environment else []
    for path in paths:
        with open(path, "rb") as file:
            yield file.read()
    for script in ("kit.py", "build.py", "render_cycles.py"):
        with open(os.path.join(SCRIPTS, script)) as file:
            yield ast.dump(ast.parse(file.read())).encode()


def cycles_pictures(name, folder, size, samples):
    """Paths of the replicates by Cycles; rendered unless the cache has them."""
    width, height = size
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    about = f"{name} {width}x{height} {samples} {bpy.app.version_string} {REPLICATES}"
    kept = os.path.join(cache, "sundog", "references", digest(about.encode(), *inputs(name, folder)))
    paths = [os.path.join(kept, f"{name}-{index}.exr") for index in range(REPLICATES)]
    if not all(os.path.exists(path) for path in paths):
        fresh = f"{kept}.{os.getpid()}"
        os.makedirs(fresh, exist_ok=True)
        try:
            outs = [os.path.join(fresh, f"{name}-{index}.exr") for index in range(REPLICATES)]
            command = [sys.executable, os.path.join(SCRIPTS, "render_cycles.py"), os.path.join(folder, f"{name}.blend"), outs[0],
                       "--seed", "101", "--samples", str(samples), "--width", str(width), "--height", str(height)]
            for index in range(1, REPLICATES):
                command += ["--more", f"{outs[index]}:{101 + index}"]
            run(command, f"Cycles' picture of {name}")
            shutil.rmtree(kept, ignore_errors=True)
            os.rename(fresh, kept)
        finally:
            shutil.rmtree(fresh, ignore_errors=True)
    return paths


def sundog_command(program, folder, name, path, size, samples, seed, technique="mis"):
    """How Sundog is called for a picture of one of the scenes in `folder`."""
    with open(os.path.join(folder, f"{name}.json")) as file:
        settings = json.load(file)
    # With "=", so that a negative number is not taken for a flag.
    command = [program, "render", os.path.join(folder, settings["scene"]), f"--output={path}", f"--width={size[0]}",
               f"--height={size[1]}", f"--samples={samples}", f"--bounces={settings['bounces']}", f"--seed={seed}",
               f"--filter={settings['filter']}", f"--light-sampling={technique}", "--exr-layers=combined"]
    if settings["environment"]:
        command += [f"--environment={os.path.join(folder, settings['environment'])}",
                    f"--environment-strength={settings['environment_strength']}",
                    f"--environment-rotation={settings['environment_rotation']}"]
    return command


def sundog_pictures(name, folder, size, samples, program, technique="mis"):
    """Paths of the replicates by Sundog; each technique has seeds of its own."""
    paths = [os.path.join(folder, f"{name}-sundog-{technique}-{index}.exr") for index in range(REPLICATES)]
    seed = {"mis": 201, "nee": 301, "bsdf": 401}[technique]
    for index, path in enumerate(paths):
        run(sundog_command(program, folder, name, path, size, samples, seed + index, technique) + ["--quiet"],
            f"Sundog's picture of {name}")
    return paths


def read_exr(path):
    """The picture's colours as height x width x 3 in float64, top row first, with no colour transform."""
    image = bpy.data.images.load(path, check_existing=False)
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    if width == 0 or height == 0:
        raise Failure(f"{path} cannot be read as a picture")
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)[::-1, :, :3].astype(np.float64)


def relative_error(ours, theirs):
    """The unbiased estimate of relMSE and its standard error; see the module's text."""
    count = len(ours)
    total, pairs = 0.0, 0
    for i in range(count):
        for j in range(i + 1, count):
            others = [theirs[k] for k in range(count) if k not in (i, j)]
            weight = 1.0 / (np.mean(others, axis=0) ** 2 + 0.01)
            total = total + (ours[i] - theirs[i]) * (ours[j] - theirs[j]) * weight
            pairs += 1
    per_pixel = (total / pairs).mean(axis=2).ravel()
    return per_pixel.mean(), per_pixel.std(ddof=1) / math.sqrt(per_pixel.size)


def noise(pictures):
    """The relative noise of one replicate: the root of the mean variance over (mean^2 + 0.01)."""
    stack = np.stack(pictures)
    return math.sqrt((stack.var(axis=0, ddof=1) / (stack.mean(axis=0) ** 2 + 0.01)).mean())


def mean_and_error(pictures, weights=LUMINANCE):
    """The mean luminance over pictures and pixels, and its standard error from the spread between the replicates."""
    bright = np.stack([picture @ weights for picture in pictures])
    error = math.sqrt((bright.var(axis=0, ddof=1) / len(pictures)).sum()) / bright[0].size
    return bright.mean(), error


def luminance_ratio(ours, theirs):
    """Ours / theirs of the mean luminance, and its standard error (first order)."""
    (x, x_error), (r, r_error) = mean_and_error(ours), mean_and_error(theirs)
    if r <= 0.0:
        raise Failure("the reference is black")
    return x / r, math.hypot(x_error / r, x * r_error / (r * r))


def techniques_agree(name, folder, size, samples, program, ours):
    """For light sampling alone and BSDF sampling alone: the ratio of the mean luminance to that of both, and the difference in
    its standard errors."""
    both, both_error = mean_and_error(ours)
    found = {}
    for technique in TECHNIQUES:
        alone, error = mean_and_error([read_exr(path) for path in sundog_pictures(name, folder, size, samples, program, technique)])
        found[technique] = {"ratio": alone / both, "sigmas": (alone - both) / max(math.hypot(error, both_error), 1e-300)}
    return found


def compare(name, ours, theirs):
    ratio, ratio_error = luminance_ratio(ours, theirs)
    error, error_error = relative_error(ours, theirs)
    bound, light_bound, why = EXCEPTIONS.get(name, (RELATIVE_ERROR_BOUND, LUMINANCE_BOUND, None))
    passed = error + 2 * error_error <= bound and abs(ratio - 1) + 2 * ratio_error <= light_bound
    return {
        "scene": name, "luminance ratio": ratio, "ratio error": ratio_error, "relMSE": error, "relMSE error": error_error,
        "noise": noise(ours), "noise Cycles": noise(theirs), "passed": bool(passed), "why": why,
    }


def cells(settings, ours, theirs):
    """For a grid probe: each cell's luminance ratio and its standard error, row by row."""
    columns, rows = settings["grid"]
    height, width, _ = ours[0].shape
    table = []
    for row in range(rows):
        line = []
        for column in range(columns):
            top, bottom = row * height // rows, (row + 1) * height // rows
            left, right = column * width // columns, (column + 1) * width // columns
            part = lambda pictures: [picture[top:bottom, left:right] for picture in pictures]
            line.append(luminance_ratio(part(ours), part(theirs)))
        table.append(line)
    return table


def write_side_by_side(path, ours, theirs):
    """Sundog, Cycles and the relative difference as one EXR, left to right."""
    x, r = np.mean(ours, axis=0), np.mean(theirs, axis=0)
    whole = np.concatenate([x, r, (x - r) / np.sqrt(r * r + 0.01)], axis=1)
    height, width, _ = whole.shape
    image = bpy.data.images.new("side by side", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(np.concatenate([whole[::-1], np.ones((height, width, 1))], axis=2).astype(np.float32).ravel())
    image.filepath_raw = path
    image.file_format = "OPEN_EXR"
    image.save()
    bpy.data.images.remove(image)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", help="scenes of scenes/build.py; without any: the gallery and the probes")
    parser.add_argument("--sundog", default=os.path.join(ROOT, "target", "release", "sundog"), help="the program")
    parser.add_argument("--more", type=float, default=1.0, metavar="FACTOR", help="so many times the samples")
    parser.add_argument("--keep", default=os.path.join(ROOT, "target", "pictures"), metavar="FOLDER", help="where files go")
    parser.add_argument("--references-only", action="store_true", help="only render Cycles' pictures into the cache")
    parser.add_argument("--json", metavar="FILE", help="write the numbers there")
    given = parser.parse_args()
    listed = run([sys.executable, os.path.join(SCRIPTS, "build.py"), "--list"], "listing the scenes").splitlines()
    # From 5.1 on Blender's own messages go to the standard output too, and they have blanks.
    listed = [line for line in listed if line and " " not in line]
    names = given.scenes or [name for name in listed if name not in TOO_NOISY]
    os.makedirs(given.keep, exist_ok=True)
    begun = time.monotonic()
    build_scenes(names, given.keep)
    results, failed = [], False
    print(f"{'scene':<20} {'luminance ratio':>20} {'relMSE':>22}   noise: ours, Cycles'", flush=True)
    for name in names:
        try:
            with open(os.path.join(given.keep, f"{name}.json")) as file:
                settings = json.load(file)
            width, height, theirs_samples, ours_samples = SETTINGS.get(
                name, (settings["width"], settings["height"], *PROBE_SAMPLES))
            scaled = lambda samples: max(1, round(samples * given.more))
            theirs = cycles_pictures(name, given.keep, (width, height), scaled(theirs_samples))
            if given.references_only:
                theirs = [read_exr(path) for path in theirs]
                print(f"{name:<20} {noise(theirs):.3f} {mean_and_error(theirs)}", flush=True)
                continue
            ours = sundog_pictures(name, given.keep, (width, height), scaled(ours_samples), given.sundog)
            ours, theirs = [read_exr(path) for path in ours], [read_exr(path) for path in theirs]
            result = compare(name, ours, theirs)
            if name in GALLERY:
                result["techniques"] = techniques_agree(name, given.keep, (width, height), scaled(ours_samples), given.sundog, ours)
                result["passed"] &= all(
                    abs(found["sigmas"]) <= 3 for technique, found in result["techniques"].items() if (name, technique) not in WITHOUT_BOUND)
            write_side_by_side(os.path.join(given.keep, f"{name}-compared.exr"), ours, theirs)
        except Failure as failure:
            print(f"{name:<20} FAILED: {failure}", flush=True)
            failed = True
            continue
        results.append(result)
        failed |= not result["passed"]
        print(
            f"{name:<20} {result['luminance ratio']:>10.4f} ± {result['ratio error']:.4f}   {result['relMSE']:>11.2e} ± "
            f"{result['relMSE error']:.0e}   {result['noise']:.3f}, {result['noise Cycles']:.3f}   "
            f"{'ok' if result['passed'] else 'DIFFERS'}{' (' + result['why'] + ')' if result['why'] else ''}", flush=True)
        if "techniques" in result:
            print("    " + ", ".join(f"{technique} alone {found['ratio']:.4f} ({found['sigmas']:+.1f} sigma)"
                                     for technique, found in result["techniques"].items()), flush=True)
        if "grid" in settings and not result["passed"]:
            for line in cells(settings, ours, theirs):
                print("    " + "  ".join(f"{ratio:.3f}±{error:.3f}" for ratio, error in line), flush=True)
    if given.json:
        with open(given.json, "w") as file:
            json.dump(results, file, indent=2)
    print(f"{len(results)} scenes in {time.monotonic() - begun:.0f} s; bounds: relMSE {RELATIVE_ERROR_BOUND}, luminance {LUMINANCE_BOUND}, "
          "each with two standard errors")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
