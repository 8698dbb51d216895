# SPDX-License-Identifier: MIT OR Apache-2.0
"""Renders the hard scenes of scenes/hard with Sundog, with Sundog's remedies left out, and with Cycles; writes the tables and the
picture of docs/notes/hard-cases.md.

    PYTHON_WITH_BPY scripts/hard_cases.py [--only peers] [--only answers] [--only prices] [--only failures] [--out FOLDER]

    peers     each hard scene against the same renderer's picture of the scene as it was, at the same seed
    answers   scenes whose answer is known, by Sundog and by Cycles (tests/pictures/hard_answers.py)
    prices    processor time and memory without each remedy, the runs in turn
    failures  small scenes in which one sees what goes wrong without a remedy (naive_scenes.py)

Processor seconds are those of all threads together, without loading and preparing.
"""

import argparse
import os
import statistics
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "scenes", "hard"))

import experiment_kit as kit  # noqa: E402
import naive_scenes  # noqa: E402
from experiments import about  # noqa: E402
import make as hard  # noqa: E402
from experiment_kit import np  # noqa: E402

PAGE = os.path.join(kit.ROOT, "docs", "notes", "hard-cases.md")
PICTURES = os.path.join(kit.ROOT, "docs", "pictures", "hard")
SIZE, SAMPLES = {"cornell": (96, 96), "three-objects": (128, 72)}, 64
NAIVE = ("--naive=offsets", "--naive=edges", "--naive=origin")


def rel_mse(picture, reference):
    return float(((picture - reference) ** 2 / (reference ** 2 + 0.01)).mean())


def shown(value):
    return "0" if value == 0.0 else f"{value:.1e}" if np.isfinite(value) else "not finite"


# ---- Sundog beside itself and Cycles ----


def peers(bench):
    lines = ["| scene | Sundog | without its remedies | Cycles |", "| --- | ---: | ---: | ---: |"]
    sheet = []
    for scene in hard.SCENES:
        renderers = {
            "Sundog": lambda name: bench.sundog(name, SIZE[scene], SAMPLES, 1)["picture"],
            "naive": lambda name: bench.sundog(name, SIZE[scene], SAMPLES, 1, *NAIVE)["picture"],
            "Cycles": lambda name: bench.cycles(name, SIZE[scene], SAMPLES, 1)["picture"],
        }
        references = {who: render(scene) for who, render in renderers.items() if who != "naive"}
        references["naive"] = references["Sundog"]
        for variant in hard.VARIANTS:
            pictures = {who: render(f"{scene}-{variant}") for who, render in renderers.items()}
            errors = [shown(rel_mse(pictures[who], references[who])) for who in renderers]
            lines.append(f"| {scene}, {variant.replace('-', ' ', 1)} | " + " | ".join(errors) + " |")
            if scene == "cornell" and variant in ("moved-1e5", "scaled-1e-3", "scaled-1e6"):
                sheet += [pictures[who] for who in renderers]
    settings = bench.settings("cornell")
    kit.write_jpeg(bench, os.path.join(PICTURES, "peers.jpg"), kit.sheet(sheet, 3), view=settings["view"], exposure=settings["exposure"])
    return "\n".join([*lines, "", "![The Cornell box moved by 1e5 m, scaled by 1e-3 and by 1e6 (from top to bottom), by Sundog, by Sundog without its "
                      "remedies, and by Cycles](../pictures/hard/peers.jpg)"])


def answers(bench):
    script = os.path.join(kit.ROOT, "tests", "pictures", "hard_answers.py")
    return kit.compare.run([sys.executable, script, "--sundog", bench.program], "the scenes whose answer is known").strip()


# ---- What the remedies cost ----

PRICES = {
    "everything": (),
    "without Embree's robust flag": ("--naive=edges",),
    "without recentring in f64": ("--naive=origin",),
    "general kernel": ("--effects=all",),
    "general kernel, without error bounds": ("--effects=all", "--naive=offsets"),
}


def prices(bench):
    scenes, size, samples = ("cornell", "three-objects", "foliage", "many-lights"), (240, 160), 32
    bench.build(scenes)
    lines = ["| processor ns a sample | " + " | ".join(scenes) + " |", "| --- " + "| ---: " * len(scenes) + "|"]
    took = {(what, scene): [] for what in PRICES for scene in scenes}
    for _ in range(3):
        for scene in scenes:
            for what, flags in PRICES.items():
                whole = bench.sundog(scene, size, samples, 1, *flags)["cpu"]
                # The same without the samples: loading, preparing, writing.
                empty = bench.sundog(scene, size, 1, 1, "--region=0,0,1,1", *flags)["cpu"]
                took[what, scene].append((whole - empty) / (size[0] * size[1] * samples) * 1e9)
    middle = {key: statistics.median(times) for key, times in took.items()}
    for what in PRICES:
        base = "general kernel" if what.startswith("general") else "everything"
        cells = [f"{middle[what, scene]:.0f}" + ("" if what == base else f" ({100 * (middle[what, scene] / middle[base, scene] - 1):+.1f} %)") for scene in scenes]
        lines.append(f"| {what} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


# ---- What goes wrong ----


def failures(bench):
    lines = ["| case | without | with | what one sees |", "| --- | --- | --- | --- |"]
    for name, (make, part, samples, case, seen) in naive_scenes.SCENES.items():
        scene, picture = bench.path(f"naive-{name}.gltf"), bench.path("naive.exr")
        make().write(scene)
        cells = []
        for flags, kind in (((f"--naive={part}",), "naive"), ((), "sundog")):
            kit.compare.run([bench.program, "render", scene, "-o", picture, f"--width={naive_scenes.SIZE[0]}", f"--height={naive_scenes.SIZE[1]}",
                             f"--samples={samples}", "--seed=1", f"--bounces={naive_scenes.BOUNCES.get(name, 4)}", "--exr-layers=combined", *flags], f"the picture of {name}")
            file = f"{name}-{kind}.jpg"
            kit.write_jpeg(bench, os.path.join(PICTURES, file), kit.compare.read_exr(picture))
            cells.append(f"![{case}, {'without' if flags else 'with'} the remedy](../pictures/hard/{file})")
        lines.append(f"| `{case}` (`--naive {part}`) | {cells[0]} | {cells[1]} | {seen} |")
    return "\n".join(lines)


PARTS = {"peers": peers, "answers": answers, "prices": prices, "failures": failures}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", choices=PARTS, metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--sundog", default=os.path.join(kit.ROOT, "target", "release", "sundog"))
    parser.add_argument("--out", default=os.path.join(kit.ROOT, "out", "hard"), help="where scenes and pictures go")
    given = parser.parse_args()
    bench = kit.Bench(given.sundog, os.path.abspath(given.out), False)
    for name in given.only or PARTS:
        if name == "peers":
            for scene in hard.SCENES:
                hard.make(scene, bench.folder)
        where = about(bench)
        text = f"{PARTS[name](bench)}\n\n*{where}*"
        kit.insert(PAGE, name, text, "scripts/hard_cases.py")
        print(text, flush=True)


if __name__ == "__main__":
    try:
        main()
    except kit.compare.Failure as failure:
        sys.exit(f"hard_cases: {failure}")
