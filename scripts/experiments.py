# SPDX-License-Identifier: MIT OR Apache-2.0
"""Measures what accuracy costs in time, and writes docs/notes/cost-of-accuracy.md's tables, plots and pictures.

    PYTHON_WITH_BPY scripts/experiments.py [--only EXPERIMENT]... [--quick] [--out FOLDER]

    objects         three objects under an HDR picture of the sky at 1280 x 720: BSDF sampling alone, with light sampling, with
                    adaptive sampling, and Cycles; also as a page of its own, FOLDER/objects.html
    directions      directions drawn uniformly, by the BSDF, to the lights, and by both
    light-samples   1, 4, 16 and 64 light samples at the surface that the camera sees
    bounces         0 to 5 and 100 bounces
    roulette        when paths may end by chance
    samples         1 to 1024 samples a pixel
    adaptive        tolerances of adaptive sampling against numbers of uniform samples

Errors are the root of relMSE = mean over pixels and channels of (x - r)^2 / (r^2 + 0.01), with the noise of the reference taken
out (experiment_kit.error_map). Times are processor seconds of all threads together, without those of loading and preparing
(a picture of one pixel takes them too), medians over the seeds: a machine that does other things as well changes them little.
References are kept in
~/.cache/sundog/references under a hash of the scene, the settings and the program's sources. `--quick` makes tiny pictures
with few samples, to see that everything works, and leaves the documentation alone.
"""

import argparse
import html
import json
import os
import shutil
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import experiment_kit as kit  # noqa: E402
from benchmark import commit, processor  # noqa: E402
from experiment_kit import Row, compare, np  # noqa: E402

ROOT = kit.ROOT
PAGE = os.path.join(ROOT, "docs", "notes", "cost-of-accuracy.md")
PICTURES = os.path.join(ROOT, "docs", "pictures", "accuracy")
ENOUGH_BOUNCES = "--bounces=100"


class Study:
    """What an experiment makes: tables, and pictures beside the page."""

    def __init__(self, bench, name, pictures):
        self.bench, self.name, self.pictures = bench, name, pictures
        self.parts, self.rows = [], {}
        self.seeds = range(1, 2 if bench.quick else 3)

    def few(self, many, quick):
        return quick if self.bench.quick else many

    def rows_of(self, scene, size, ways, references):
        """A row for each (label, samples, flags); seed by seed in turn, so that a slow minute meets all."""
        renders = {label: [] for label, _, _ in ways}
        for seed in self.seeds:
            for label, samples, flags in ways:
                renders[label].append(self.bench.sundog(scene, size, samples, seed, *flags))
        rows = [Row(label, renders[label], references, size, samples, self.bench.overhead("sundog", scene)) for label, samples, _ in ways]
        self.rows[f"{scene} {len(self.rows)}"] = [row.numbers() for row in rows]
        return rows

    def say(self, text):
        self.parts.append(text)

    def show(self, name, alt, pixels, **view):
        file = f"{self.name}{name}.jpg"
        kit.write_jpeg(self.bench, os.path.join(self.pictures, file), pixels, **view)
        self.say(f"![{alt}](../pictures/accuracy/{file})")

    def draw(self, title, x_name, y_name, series):
        file = f"{self.name}.svg"
        os.makedirs(self.pictures, exist_ok=True)
        with open(os.path.join(self.pictures, file), "w") as out:
            out.write(kit.plot(title, x_name, y_name, series))
        self.say(f"![{title}: {y_name} against {x_name}](../pictures/accuracy/{file})")

    def text(self):
        return "\n\n".join(self.parts)


def view_of(bench, scene):
    settings = bench.settings(scene)
    return {"view": settings["view"], "exposure": settings["exposure"]}


def labels(rows):
    return ", ".join(row.label for row in rows)


# ---- The experiments ----


def directions(study):
    size, samples = study.few((240, 240), (40, 40)), study.few(64, 8)
    references = study.bench.references("cornell", size, study.few(512, 64), ENOUGH_BOUNCES)
    ways = [("uniform hemisphere", "hemisphere"), ("BSDF sampling", "bsdf"), ("light sampling", "nee"), ("both, by MIS", "mis")]
    rows = study.rows_of("cornell", size, [(label, samples, (f"--light-sampling={way}", ENOUGH_BOUNCES)) for label, way in ways], references)
    study.say(kit.table(f"Cornell box, {samples} samples a pixel", rows, ("seconds", "ns", "rays", "error", "gain")))
    study.show("", f"The Cornell box: {labels(rows)}", kit.sheet([row.picture for row in rows], 4), **view_of(study.bench, "cornell"))


def light_samples(study):
    size, samples = study.few((240, 240), (40, 40)), 4
    numbers = study.few((1, 4, 16, 64), (1, 4))
    sheets = []
    for what, bounces in (("direct light alone", "--bounces=0"), ("all light", ENOUGH_BOUNCES)):
        references = study.bench.references("cornell", size, study.few(512, 64), bounces)
        ways = [(f"{n} light samples" if n > 1 else "1 light sample", samples, (f"--light-samples={n}", bounces)) for n in numbers]
        rows = study.rows_of("cornell", size, ways, references)
        study.say(kit.table(f"{what}, {samples} samples a pixel", rows, ("seconds", "rays", "error", "gain")))
        sheets += [row.picture[size[1] // 3:] for row in rows]
    study.show("", f"Floor and blocks of the Cornell box with {', '.join(map(str, numbers))} light samples: above direct light alone, below all light",
               kit.sheet(sheets, len(numbers)), **view_of(study.bench, "cornell"))


def bounces(study):
    size, samples = study.few((240, 160), (48, 32)), study.few(64, 8)
    references = study.bench.references("window-room", size, study.few(512, 64), ENOUGH_BOUNCES)
    ways = [(f"{n} bounces" if n != 1 else "1 bounce", samples, (f"--bounces={n}",)) for n in (*range(6), 100)]
    rows = study.rows_of("window-room", size, ways, references)
    study.say(kit.table(f"room behind a window, {samples} samples a pixel", rows, ("seconds", "rays", "light", "error")))
    study.show("", f"A room behind a window: {labels(rows)}", kit.sheet([row.picture for row in rows], 4), **view_of(study.bench, "window-room"))


def roulette(study):
    size, samples = study.few((240, 160), (48, 32)), study.few(64, 8)
    references = study.bench.references("window-room", size, study.few(512, 64), ENOUGH_BOUNCES)
    ways = [("none", "off"), ("from bounce 1", "1"), ("from bounce 2 (the default)", "2"), ("from bounce 4", "4"), ("from bounce 8", "8")]
    # A few bright dots are most of the error: two seeds are too few.
    study.seeds = range(1, study.few(5, 2))
    rows = study.rows_of("window-room", size, [(label, samples, (f"--roulette={way}", "--bounces=32")) for label, way in ways], references)
    study.say(kit.table(f"roulette, {samples} samples a pixel, up to 32 bounces", rows, ("seconds", "rays", "light", "error", "gain")))


def samples(study):
    size = study.few((120, 120), (40, 40))
    references = study.bench.references("cornell", size, study.few(512, 64), ENOUGH_BOUNCES)
    ways = [(str(1 << k), 1 << k, (ENOUGH_BOUNCES,)) for k in range(study.few(11, 5))]
    study.seeds = range(1, 2)
    rows = study.rows_of("cornell", size, ways, references)
    study.say(kit.table("samples a pixel", rows, ("seconds", "ns", "error", "worst")))
    slope = np.polyfit(np.log([row.samples for row in rows]), np.log([max(row.error, 1e-9) for row in rows]), 1)[0]
    study.say(f"Slope of the error over the samples, both as logarithms: {slope:.2f} (independent samples: -0.50).")
    study.draw("Cornell box, 1 to 1024 samples a pixel", "processor seconds", "error in percent", [("error", [(r.seconds, r.error, r.label) for r in rows])])
    study.show("", f"The Cornell box with {labels(rows)} samples a pixel", kit.sheet([row.picture for row in rows], 6), **view_of(study.bench, "cornell"))


def adaptive(study):
    """Uniform numbers of samples against tolerances of adaptive sampling, where error is uneven and where it is not."""
    # The worst tile of two pictures is mostly chance.
    study.seeds = range(1, study.few(5, 2))
    # Foliage at twice the width as well: neighbourhoods that decide are as many pixels at any width.
    for scene, width in study.few((("foliage", 240), ("foliage", 480), ("glass", 240), ("shallow-focus", 240), ("cornell", 240)), (("glass", 60),)):
        settings = study.bench.settings(scene)
        title, file = (scene, f"-{scene}") if width < 480 else (f"{scene}, {width} pixels wide", f"-{scene}-{width}")
        size = width, width * settings["height"] // settings["width"]
        references = study.bench.references(scene, size, study.few(512, 64))
        numbers = study.few((32, 96, 288), (4, 16))
        uniform = study.rows_of(scene, size, [(f"{n} samples", n, ()) for n in numbers], references)
        # Tolerances from what uniform sampling leaves in the worst tile after as many samples as it begins with, downwards.
        tolerances = sorted({max(1, round(uniform[0].worst * share)) for share in study.few((0.6, 0.4, 0.25), (0.6,))}, reverse=True)
        ways = [(f"tolerance {percent} %", study.few(16384, 64), (f"--pixel-error={percent}%",)) for percent in tolerances]
        by_error = study.rows_of(scene, size, ways, references)
        for row in by_error:
            row.sooner = kit.needed(uniform, "error", row.error) / row.seconds
            row.worst_sooner = kit.needed(uniform, "worst", row.worst) / row.seconds
        study.say(kit.table(title, uniform + by_error, ("samples", "seconds", "error", "worst", "worst-sooner", "sooner")))
        most_error = np.sqrt(max(kit.blurred(uniform[1].map).max(), 1e-9))
        maps = [kit.heat(kit.blurred(row.map), most_error) for row in (uniform[1], by_error[-2 % len(by_error)])]
        study.show(file, f"Where the error is in {title}, {uniform[1].label} and {by_error[-2 % len(by_error)].label}: black is none, white {100 * most_error:.0f} %",
                   kit.sheet(maps, 2), view="Standard")


def objects(study):
    bench, scene = study.bench, "three-objects"
    size, samples = study.few((1280, 720), (96, 54)), study.few(32, 4)
    references = bench.references(scene, size, study.few(64, 32), peer=study.few(32, 16))
    study.seeds = range(1, 2)
    ways = [("BSDF sampling alone", samples, ("--light-sampling=bsdf",)), ("with light sampling (MIS)", samples, ())]
    rows = study.rows_of(scene, size, ways, references)
    if "pixel-error" in bench.flags:
        # Each pixel as good as the picture without it is as a whole.
        ways = [(f"MIS and adaptive, tolerance {rows[1].error:.0f} %", study.few(4096, 64), (f"--pixel-error={rows[1].error:.0f}%",))]
        rows += study.rows_of(scene, size, ways, references)
    cycles = [bench.cycles(scene, size, samples, seed) for seed in study.seeds]
    rows.append(Row(f"Cycles {compare.bpy.app.version_string}", cycles, references, size, samples, bench.overhead("cycles", scene)))
    study.rows["with Cycles"] = [row.numbers() for row in rows]
    columns = ("samples", "wall", "seconds", "ns", "error", "worst", "gain")
    study.say(kit.table(f"{size[0]} x {size[1]}", rows, columns))
    study.draw("Three objects: error against time", "processor seconds", "error in percent", [("", [(r.seconds, r.error, r.label)]) for r in rows])
    part = slice(size[1] * 2 // 5, size[1] * 4 // 5), slice(size[0] // 4, size[0] // 4 + size[0] * 3 // 8)
    study.show("", f"A part of the picture: {labels(rows)}", kit.sheet([row.picture[part][::1, ::1] for row in rows], 2), **view_of(bench, scene))
    most = np.sqrt(max(np.percentile(kit.blurred(rows[1].map), 99.5), 1e-9))
    maps = [kit.heat(kit.blurred(row.map), most)[::4, ::4] for row in rows]
    study.show("-errors", f"Where the error is, in the same order: black is none, white {100 * most:.0f} % or more", kit.sheet(maps, 2), view="Standard")
    objects_page(study, rows, columns)


def objects_page(study, rows, columns):
    """The table, the plot and the pictures as one file."""
    cells = [["", *(kit.COLUMNS[name][0] for name in columns)], *([row.label, *(kit.COLUMNS[name][1](row, rows) for name in columns)] for row in rows)]
    lines = ["".join(f"<{'td' if y else 'th'}>{html.escape(cell)}" for cell in line) for y, line in enumerate(cells)]
    with open(os.path.join(study.pictures, "objects.svg")) as file:
        drawing = file.read()
    images = [f'<img src="{kit.data_url(os.path.join(study.pictures, name), "image/jpeg")}" alt="{alt}">' for name, alt in
              (("objects.jpg", f"A part of the picture: {labels(rows)}"), ("objects-errors.jpg", "Where the error is, in the same order"))]
    page = f"""<!doctype html><html lang="en"><meta charset="utf-8"><title>Three objects under a sky</title>
<style>body {{ font: 15px sans-serif; max-width: 1000px; margin: 2em auto; padding: 0 1em; background: Canvas; color: CanvasText; color-scheme: light dark }}
td, th {{ padding: .3em .8em; text-align: right; border-bottom: 1px solid #8888 }} td:first-child {{ text-align: left }} img, svg {{ max-width: 100% }}</style>
<h1>Three objects under an HDR picture of the sky</h1><p>{html.escape(about(study.bench))}</p>
<table>{"".join(f"<tr>{line}" for line in lines)}</table><p>Error is the root of relMSE, the noise of the reference taken out.</p>
{drawing}<p>In the order of the table, row by row:</p>{"".join(images)}</html>
"""
    with open(study.bench.path("objects.html"), "w") as file:
        file.write(page)


EXPERIMENTS = {
    "objects": (objects, ["three-objects"]),
    "directions": (directions, ["cornell"]),
    "light-samples": (light_samples, ["cornell"]),
    "bounces": (bounces, ["window-room"]),
    "roulette": (roulette, ["window-room"]),
    "samples": (samples, ["cornell"]),
    "adaptive": (adaptive, ["foliage", "glass", "shallow-focus", "cornell"]),
}


def about(bench):
    """Where and when."""
    when = time.strftime("%Y-%m-%d %H:%M", time.gmtime())
    load = f"load {os.getloadavg()[0]:.1f}"
    return f"{when} UTC, Sundog {commit()}, {processor()}, {os.cpu_count()} logical processors, {load}{', quick' if bench.quick else ''}."


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", choices=EXPERIMENTS, metavar="EXPERIMENT", help=", ".join(EXPERIMENTS))
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--sundog", default=os.path.join(ROOT, "target", "release", "sundog"))
    parser.add_argument("--out", default=os.path.join(ROOT, "out", "experiments"), help="where scenes and numbers go")
    given = parser.parse_args()
    bench = kit.Bench(given.sundog, os.path.abspath(given.out), given.quick)
    page, pictures = PAGE, PICTURES
    if given.quick:
        page, pictures = bench.path("cost-of-accuracy.md"), bench.path("pictures")
        shutil.copyfile(PAGE, page)
    for name in given.only or EXPERIMENTS:
        begun = time.time()
        make, scenes = EXPERIMENTS[name]
        bench.build(scenes)
        study = Study(bench, name, pictures)
        where = about(bench)
        make(study)
        study.say(f"*{where} The run took {time.time() - begun:.0f} s.*")
        kit.insert(page, name, study.text())
        with open(bench.path(f"{name}.results.json"), "w") as file:
            json.dump({"about": where, "rows": study.rows}, file, indent=1)
        print(f"{name}: {time.time() - begun:.0f} s\n{study.text()}\n", flush=True)


if __name__ == "__main__":
    try:
        main()
    except compare.Failure as failure:
        sys.exit(f"experiments: {failure}")
