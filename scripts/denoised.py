# SPDX-License-Identifier: MIT OR Apache-2.0
"""Measures finished frames, denoised by both, against Cycles': time of the whole call and FLIP against the converged picture.

    PYTHON_WITH_BPY scripts/denoised.py [SCENE|FILE.blend]... [--out FILE] [--pixels 14400] [--most 1024] [--seconds 120]

Each picture is made by Blender's render operator in a process of its own, through Sundog's add-on or by Cycles on the processor: at a noise
threshold of 0.01 and with 16, 64 and 256 samples, denoised by Open Image Denoise with accurate prefiltering, in turn. Scenes of the
gallery have Cycles' own defaults (indirect clamp 10, filter glossy 1), files have what they were saved with; Sundog's settings are copied
from Cycles'.

Time is that of the operator: export, rendering, denoising and the file that is written; without starting Blender and opening the
file. Processor seconds are those of all threads and of Sundog's process, too: what others do on the machine changes them little.

FLIP is LDR-FLIP by the scene's view. The converged picture is the mean of Sundog's and Cycles' with `--reference` samples and the
same settings, not denoised, so that it favours neither. `--again` measures what the folder has results of already. With `--seeds`
above 1 FLIP is the mean of so many pictures, with its standard error; times are of the first.

With `--denoising` the time of denoising alone: pictures of 2 samples, with and without; `--pixels 2073600` is 1920 x 1080.
"""

import argparse
import hashlib
import json
import math
import os
import resource
import statistics
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path[:0] = [os.path.join(ROOT, place) for place in ("scripts", "blender_addon", os.path.join("tests", "addon"))]

ENGINES = ("SUNDOG", "CYCLES")
GALLERY = ("cornell", "three-objects", "window-room", "many-lights", "glass", "material-wall", "foliage", "shallow-focus")
COUNTS = (16, 64, 256)
THRESHOLD = "threshold"
REFERENCE = "reference"
# The same samples, denoised and not.
WITH, WITHOUT = "2", "2-noisy"


def parser():
    """The command line."""
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("files", nargs="*", default=list(GALLERY), help="scenes of the gallery, and .blend files")
    made.add_argument("--out", help="where the tables go; standard output without it")
    made.add_argument("--folder", default=os.path.join(ROOT, "target", "denoised"))
    made.add_argument("--sundog", default=os.path.join(ROOT, "target", "release", "sundog"))
    made.add_argument("--pixels", type=int, default=14400, help="about so many pixels a picture")
    made.add_argument("--most", type=int, default=1024, help="samples a pixel at the most, at the noise threshold")
    made.add_argument("--reference", type=int, default=1024, help="samples of each engine's converged picture")
    made.add_argument("--threshold", type=float, default=0.01)
    made.add_argument("--seconds", type=float, default=120, help="a file is left out once a picture takes longer")
    made.add_argument("--ways", nargs="+", default=[THRESHOLD, *map(str, COUNTS)])
    made.add_argument("--denoising", action="store_true", help="measure how long denoising takes")
    made.add_argument("--seeds", type=int, default=1, help="pictures of each engine and way, each with a seed of its own")
    made.add_argument("--seed", type=int, default=0, help=argparse.SUPPRESS)
    made.add_argument("--again", action="store_true")
    made.add_argument("--one", nargs=3, metavar=("ENGINE", "WAY", "PICTURE"), help=argparse.SUPPRESS)
    return made


# In a process of its own: one picture


def one(given):
    """Renders a file and prints what it took."""
    import bpy
    import export_kit as kit

    engine, way, picture = given.one
    with kit.quiet():
        bpy.ops.wm.open_mainfile(filepath=os.path.abspath(given.files[0]), load_ui=False, use_scripts=False)
    scene = bpy.context.scene
    if scene.camera is None or scene.render.engine != "CYCLES":
        raise SystemExit("no camera, or not made with Cycles")
    set_up(scene, way, given)
    scene.render.engine = engine
    scene.render.filepath = picture
    before, begun = processor_seconds(), time.perf_counter()
    with kit.quiet():
        bpy.ops.render.render(write_still=True)
    wall = time.perf_counter() - begun
    view = scene.view_settings
    told = {"wall": wall, "cpu": processor_seconds() - before, "view": view.view_transform, "exposure": view.exposure, "look": view.look}
    print(json.dumps({**told, "size": [scene.render.resolution_x, scene.render.resolution_y]}), flush=True)


def processor_seconds():
    """Of this process and of those that it has waited for."""
    uses = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(use.ru_utime + use.ru_stime for use in uses)


def set_up(scene, way, given):
    """Cycles' settings by the way, and Sundog's that are copied from them."""
    import sundog
    from sundog import properties

    sundog.register()
    render, cycles = scene.render, scene.cycles
    share = math.sqrt(given.pixels / (render.resolution_x * render.resolution_y))
    render.resolution_x, render.resolution_y = (max(round(side * share), 8) for side in (render.resolution_x, render.resolution_y))
    render.resolution_percentage = 100
    render.use_border = render.use_compositing = render.use_sequencer = False
    for layer in [layer for layer in scene.view_layers if layer.use][1:]:
        layer.use = False
    image = render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"
    cycles.device = "CPU"
    cycles.time_limit = 0
    cycles.use_adaptive_sampling = way == THRESHOLD
    cycles.adaptive_threshold, cycles.adaptive_min_samples = given.threshold, 0
    denoised = way not in {REFERENCE, WITHOUT}
    cycles.samples = {THRESHOLD: given.most, REFERENCE: given.reference, WITHOUT: int(WITH)}.get(way) or int(way)
    cycles.seed = 1000 if way == REFERENCE else given.seed
    cycles.use_denoising = denoised
    cycles.denoiser, cycles.denoising_use_gpu = "OPENIMAGEDENOISE", False
    cycles.denoising_prefilter, cycles.denoising_quality, cycles.denoising_input_passes = "ACCURATE", "HIGH", "RGB_ALBEDO_NORMAL"
    for layer in scene.view_layers:
        layer.cycles.use_denoising = denoised
    properties.copy_from_cycles(scene)


# All of them


class Failed(Exception):
    """A file that is left out, and why."""


class Bench:
    """Makes pictures, and keeps what they took in a folder."""

    def __init__(self, given):
        self.given = given
        os.makedirs(given.folder, exist_ok=True)
        self.environment = {**os.environ, "SUNDOG_PROGRAM": given.sundog}

    def blend(self, name):
        """The file of a scene; built if it is one of the gallery."""
        if name.endswith(".blend"):
            return name
        path = os.path.join(self.given.folder, f"{name}.blend")
        if not os.path.exists(path):
            script = os.path.join(ROOT, "scenes", "build.py")
            subprocess.run([sys.executable, script, name, self.given.folder], check=True, capture_output=True)
        return path

    def picture(self, name, engine, way, seed=0):
        """What a picture took, and its path."""
        given = self.given
        about = f"{name} {engine} {way} {seed} {given.pixels} {given.most} {given.reference} {given.threshold}"
        base = os.path.splitext(os.path.basename(name))[0]
        place = os.path.join(given.folder, f"{base}-{engine}-{way}-{hashlib.sha256(about.encode()).hexdigest()[:8]}")
        picture = place + ".exr"
        if os.path.exists(place + ".json") and not (given.again and way != REFERENCE):
            with open(place + ".json", encoding="utf-8") as file:
                return {**json.load(file), "path": picture}
        command = [sys.executable, os.path.abspath(__file__), self.blend(name), "--one", engine, way, picture, "--seed", str(seed)]
        for flag in ("pixels", "most", "reference", "threshold"):
            command += [f"--{flag}", str(getattr(given, flag))]
        seconds = given.seconds * (10 if way == REFERENCE else 1)
        try:
            done = subprocess.run(command, capture_output=True, text=True, env=self.environment, timeout=seconds + 30, check=False)
        except subprocess.TimeoutExpired as error:
            raise Failed(f"{engine} took more than {seconds:.0f} s ({way})") from error
        if done.returncode != 0 or not os.path.exists(picture):
            raise Failed(f"{engine}, {way}: {(done.stderr or done.stdout).strip()[-300:]}")
        # Blender may say something more when it ends.
        told = json.loads(next(line for line in reversed(done.stdout.splitlines()) if line.startswith("{")))
        with open(place + ".json", "w", encoding="utf-8") as file:
            json.dump(told, file)
        return {**told, "path": picture}

    def flip(self, picture, reference):
        """LDR-FLIP of a picture by its view, and its mean luminance over the reference's."""
        command = [self.given.sundog, "compare", picture["path"], reference, "--json", "--view", picture["view"], "--exposure", str(picture["exposure"])]
        if picture["look"] not in ("", "None"):
            command += ["--look", picture["look"]]
        told = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        return told["flip"], told["luminance_ratio"]

    def reference(self, name):
        """The mean of both engines' converged pictures, and how far they are apart: luminances, FLIP."""
        both = [self.picture(name, engine, REFERENCE) for engine in ENGINES]
        path = both[0]["path"][:-4] + "-mean.exr"
        if not os.path.exists(path):
            write_mean([each["path"] for each in both], path)
        flip, ratio = self.flip(both[0], both[1]["path"])
        return path, flip, ratio

    def measure(self, name):
        """The rows of a file: the figures of both engines for each way."""
        seeds = range(self.given.seeds)
        rows = {way: {engine: [self.picture(name, engine, way, seed) for seed in seeds] for engine in ENGINES} for way in self.given.ways}
        path, apart, ratio = self.reference(name)
        for way, row in rows.items():
            for engine, pictures in row.items():
                flips, lights = zip(*(self.flip(picture, path) for picture in pictures))
                spread = statistics.stdev(flips) / math.sqrt(len(flips)) if len(flips) > 1 else None
                row[engine] = {**pictures[0], "flip": statistics.mean(flips), "spread": spread, "light": statistics.mean(lights)}
        return {"rows": rows, "apart": apart, "ratio": ratio}


    def denoising(self, name):
        """Seconds and processor seconds that both engines take for denoising, and the size."""
        ways = {engine: [self.picture(name, engine, way) for way in (WITH, WITHOUT)] for engine in ENGINES}
        return {engine: [of[0][key] - of[1][key] for key in ("wall", "cpu")] for engine, of in ways.items()}, ways["SUNDOG"][0]["size"]


def write_mean(paths, out):
    """The mean of two pictures of light."""
    import experiment_kit
    from experiment_kit import compare

    pictures = [compare.read_exr(path) for path in paths]
    experiment_kit.write_exr(out, sum(pictures) / len(pictures))


def geometric(values):
    """The geometric mean."""
    return math.exp(statistics.mean(math.log(value) for value in values))


def conditions():
    """When, what and where."""
    import bpy
    from benchmark import commit, processor

    day, load = time.strftime("%Y-%m-%d"), os.getloadavg()[0]
    return f"{day}, Sundog {commit()}, Cycles of Blender {bpy.app.version_string}; {processor()}, {os.cpu_count()} logical processors, load {load:.1f}."


def denoising_table(bench, names):
    """The time of denoising, as Markdown."""
    lines = [conditions(), "", "| scene | size | Sundog, s | Cycles, s | ratio | Sundog, processor s | Cycles, processor s | ratio |", "| --- " * 8 + "|"]
    for name in names:
        took, (width, height) = bench.denoising(name)
        cells = [f"{ours:.1f} | {theirs:.1f} | {ours / theirs:.2f}" for ours, theirs in zip(*(took[engine] for engine in ENGINES))]
        lines.append(f"| {title_of(name)} | {width} × {height} | " + " | ".join(cells) + " |")
    return "\n".join([*lines, ""])


def tables(found, left_out, given):
    """All that was measured, as Markdown."""
    lines = [conditions(), ""]
    for way in given.ways:
        title = f"Noise threshold {given.threshold:g}, {given.most} samples at the most" if way == THRESHOLD else f"{way} samples"
        heads = [f"{engine}, {what}" if engine else "ratio" for what in ("s", "processor s", "FLIP") for engine in ("Sundog", "Cycles", "")]
        lines += [f"{title}:", "", "| scene | size | " + " | ".join(heads) + " |", "| --- " * 11 + "|"]
        ratios = {key: [] for key in ("wall", "cpu", "flip")}
        for name, of in found.items():
            row = of["rows"][way]
            ours, theirs = (row[engine] for engine in ENGINES)
            cells = []
            for key, form in (("wall", ".1f"), ("cpu", ".1f"), ("flip", ".4f")):
                ratios[key].append(ours[key] / theirs[key])
                both = [format(of[key], form) for of in (ours, theirs)]
                if key == "flip" and ours["spread"] is not None:
                    both = [f"{value} ± {of['spread']:.4f}" for value, of in zip(both, (ours, theirs))]
                cells += [*both, f"{ratios[key][-1]:.2f}"]
            width, height = ours["size"]
            lines.append(f"| {title_of(name)} | {width} × {height} | " + " | ".join(cells) + " |")
        means = [f"| | | {geometric(values):.2f} " for values in ratios.values()]
        lines += ["| geometric mean | " + "".join(means) + "|", ""]
    lines += ["Converged pictures of both engines: FLIP between them, and Sundog's mean over Cycles': "
              + "; ".join(f"{title_of(name)} {of['apart']:.4f}, {of['ratio']:.4f}" for name, of in found.items()) + ".", ""]
    if left_out:
        lines += ["Left out: " + "; ".join(f"{title_of(name)} ({why})" for name, why in left_out.items()) + ".", ""]
    return "\n".join(lines)


def tell(text, out):
    """Prints a table, and writes it to a file if one is named."""
    if out:
        with open(out, "w", encoding="utf-8") as file:
            file.write(text)
    print(text)


def title_of(name):
    """A file's name without its folder."""
    return os.path.splitext(os.path.basename(name))[0]


def main():
    given = parser().parse_args()
    if given.one:
        one(given)
        return
    bench = Bench(given)
    if given.denoising:
        print(denoising_table(bench, given.files))
        return
    found, left_out = {}, {}
    for name in given.files:
        try:
            found[name] = bench.measure(name)
        except Failed as why:
            left_out[name] = str(why)
        print(name, json.dumps(found.get(name) or left_out[name]), file=sys.stderr, flush=True)
    if not found:
        sys.exit("no file was measured: " + "; ".join(f"{title_of(name)} ({why})" for name, why in left_out.items()))
    tell(tables(found, left_out, given), given.out)


if __name__ == "__main__":
    main()
