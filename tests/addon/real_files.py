# SPDX-License-Identifier: GPL-3.0-or-later
"""What becomes of .blend files that somebody else made with Cycles: the reasons of what is not exact, and pictures of both engines.

    PYTHON_WITH_BPY tests/addon/real_files.py FOLDER_OR_LIST -o OUT [--render] [--samples N] [--pixels N] [--seconds N] [--again]

FOLDER_OR_LIST is a folder that is searched for .blend files, or a text file with a path a line. Each file is opened in a
process of its own, as a file may end it or take for ever. Writes a JSON file for each of them to OUT, and table.txt; files
that have one already are left alone without --again. Files that were saved with another engine than Cycles are left out.
"""

import argparse
import collections
import hashlib
import json
import os
import re
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))

# Two pictures agree where the means differ by no more, and no more of the blocks of so many pixels differ by more as shown.
MEAN, BLOCKS, BLOCK, SHOWN = 0.01, 0.02, 8, 0.05
# What a mean of nothing may be off by.
DARK = 1e-4
# What later releases render: not counted with --apart.
LATER = re.compile(r"subsurface|volum|\bhair\b|motion blur|media\b|particle strands", re.IGNORECASE)


def parser():
    """The command line."""
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("files", help="a folder, a list, or with --one a .blend file")
    made.add_argument("-o", "--output", required=True, help="folder of the results")
    made.add_argument("--render", action="store_true", help="render with both engines and compare")
    made.add_argument("--samples", type=int, default=128)
    made.add_argument("--pixels", type=int, default=14400, help="about so many pixels a picture")
    made.add_argument("--seconds", type=float, default=300, help="the longest that a file may take")
    made.add_argument("--again", action="store_true", help="also files that have a result")
    made.add_argument("--only", default="", help="only files whose path has this in it")
    made.add_argument("--keep", action="store_true", help="keep exported scenes and pictures")
    made.add_argument("--table", action="store_true", help="only the table of what is there")
    made.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    return made


def key(path):
    """Name of a file's result."""
    parts = os.path.normpath(path).split(os.sep)
    words = re.sub(r"[^A-Za-z0-9]+", "-", "-".join(parts[-3:]))[-60:].strip("-")
    return f"{words}-{hashlib.md5(path.encode()).hexdigest()[:6]}"


# In a process of its own: one file


def one(options):
    """Opens, exports and renders a file; writes its result whenever there is more of it."""
    sys.path.insert(0, HERE)
    import bpy
    import export_kit as kit

    result = {"file": options.files}
    path, place = os.path.abspath(options.files), os.path.join(options.output, key(options.files))
    os.makedirs(place, exist_ok=True)
    if "SUNDOG_PROGRAM" in os.environ:
        os.environ["SUNDOG_PROGRAM"] = os.path.abspath(os.environ["SUNDOG_PROGRAM"])
    # Blender's fluids leave a table of 25 MB where they are run.
    os.chdir(place)

    def keep(**more):
        result.update(more)
        with open(place + ".json.new", "w", encoding="utf-8") as file:
            json.dump(result, file, indent=1)
        os.replace(place + ".json.new", place + ".json")

    keep(state="opening")
    begun = time.perf_counter()
    with kit.quiet():
        # Files of strangers: their scripts do not run.
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=False)
    scene = bpy.context.scene
    keep(version=list(bpy.data.version), engine=scene.render.engine, opened=time.perf_counter() - begun)
    if scene.render.engine != "CYCLES":
        keep(state="other engine")
        return
    if scene.camera is None:
        keep(state="no camera")
        return
    keep(state="exporting")
    missing = [i.name for i in bpy.data.images if i.source == "FILE" and not i.packed_file and i.filepath and not os.path.isfile(bpy.path.abspath(i.filepath, library=i.library))]
    keep(missing=missing, objects=len(scene.objects))
    prepare(scene, options)
    begun = time.perf_counter()
    from sundog import export

    layer = next((layer.name for layer in scene.view_layers if layer.use), None)
    if layer is None:
        keep(state="no view layer")
        return
    done = kit.in_render(lambda depsgraph: export.write_scene(depsgraph, depsgraph.scene, place, os.path.join(place, "cache")), layer)
    keep(state="exported", exported=time.perf_counter() - begun, verdicts=[v for v in done.verdicts if v["verdict"] != "exact"])
    told = kit.info(done.path)
    keep(diagnostics=told.get("diagnostics", []), triangles=told.get("triangles"))
    if options.render:
        keep(state="rendering")
        pictures(scene, done.path, place, options, keep)
    keep(state="done")


def prepare(scene, options):
    """The settings of the file, small and with the same samples everywhere."""
    from sundog import properties
    from sundog.compare import settings

    properties.register()
    properties.copy_from_cycles(scene)
    render = scene.render
    for layer in [layer for layer in scene.view_layers if layer.use][1:]:
        layer.use = False
    width, height = render.resolution_x, render.resolution_y
    share = (options.pixels / (width * height)) ** 0.5
    # Whole blocks.
    render.resolution_x = max(round(width * share / BLOCK), 2) * BLOCK
    render.resolution_y = max(round(height * share / BLOCK), 2) * BLOCK
    render.resolution_percentage = 100
    render.use_border = False
    # Blender burns the frame's number into what Cycles has rendered alone.
    render.use_stamp = False
    kept = settings.Kept()
    settings.same_for_both(kept, scene, settings.Options(samples=options.samples))
    settings.as_sundog(kept, scene)


def pictures(scene, path, place, options, keep):
    """Renders with both engines and measures."""
    import bpy
    import export_kit as kit
    import numpy
    from sundog import command, program

    warnings = []
    layer = next(layer for layer in scene.view_layers if layer.use)
    flags = command.arguments(scene, layer, program.abilities(kit.program()), warnings.append)
    ours = os.path.join(place, "sundog.exr")
    begun = time.perf_counter()
    line = [kit.program(), "render", path, "-o", ours, "--quiet", "--exr-layers", "combined", *flags]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    if done.returncode:
        keep(error=done.stderr.strip()[-500:])
        return
    keep(warnings=warnings, sundog_seconds=time.perf_counter() - begun, command=line)
    theirs = os.path.join(place, "cycles.exr")
    scene.render.engine, scene.render.filepath = "CYCLES", theirs
    from sundog.compare import settings

    settings.linear_exr(scene.render.image_settings)
    begun = time.perf_counter()
    with kit.quiet():
        bpy.ops.render.render(write_still=True, scene=scene.name)
    keep(cycles_seconds=time.perf_counter() - begun)
    linear, shown = zip(*(read(scene, name) for name in (ours, theirs)))
    if linear[0].shape != linear[1].shape:
        keep(error=f"the pictures have the sizes {linear[0].shape} and {linear[1].shape}")
        return
    means = [float(p[..., :3].mean()) for p in linear]
    keep(means=means, off=abs(means[0] - means[1]) / max(means[1], DARK), **blocks(numpy, *shown))


def read(scene, path):
    """(linear, as shown) of an EXR file, both with alpha."""
    import bpy
    import numpy
    from sundog.compare import settings

    def values(image):
        got = numpy.empty(image.size[0] * image.size[1] * image.channels, numpy.float32)
        image.pixels.foreach_get(got)
        got = got.reshape(image.size[1], image.size[0], -1)
        return got if got.shape[2] == 4 else numpy.concatenate([got[..., :3], numpy.ones_like(got[..., :1])], axis=2)

    image = bpy.data.images.load(path)
    png = path[:-4] + ".png"
    settings.display_png(scene.render.image_settings, scene.render.film_transparent)
    scene.render.image_settings.color_depth = "16"
    image.save_render(png, scene=scene)
    image.colorspace_settings.name = "Non-Color"
    linear = values(image)
    picture = bpy.data.images.load(png)
    picture.colorspace_settings.name = "Non-Color"
    shown = values(picture)
    # Over black: colours of what is not there do not count.
    shown[..., :3] *= shown[..., 3:]
    return linear, shown


def blocks(numpy, first, second):
    """The share of blocks that are off, and the worst of them with its place (from the top left)."""
    height, width = (n // BLOCK for n in first.shape[:2])
    cut = lambda p: p[: height * BLOCK, : width * BLOCK].reshape(height, BLOCK, width, BLOCK, -1).mean(axis=(1, 3))  # noqa: E731
    off = numpy.abs(cut(first) - cut(second)).max(axis=2)
    row, column = numpy.unravel_index(off.argmax(), off.shape)
    return {"blocks": float((off > SHOWN).mean()), "worst": float(off.max()), "worst_at": [int(column) * BLOCK, int(height - 1 - row) * BLOCK]}


# The table


def words(detail):
    """A reason without the names and numbers of the file."""
    return re.sub(r"\d+(\.\d+)?", "n", re.sub(r"\"[^\"]*\"|\(/[^)]*\)", "…", detail))


# Where nodes are not evaluated, that is the reason of all that is done instead.
NODES = "its nodes are not evaluated as they are because of: "


def reasons(result):
    """What is not exact in a file, without names."""
    found = set()
    for verdict in result.get("verdicts", ()):
        parts = verdict["detail"].split("; ")
        of_nodes = [part.removeprefix(NODES) for part in parts if part.startswith(NODES)]
        found |= {f"{verdict['kind']}: node {node}" for part in of_nodes for node in part.split(", ")}
        if not of_nodes:
            found |= {f"{verdict['kind']}: {words(part)}" for part in parts}
    return found


def agrees(result):
    """Whether the pictures do."""
    near = result["off"] <= MEAN or abs(result["means"][0] - result["means"][1]) <= DARK
    return near and result["blocks"] <= BLOCKS


def table(results):
    """Text on all of them."""
    counted = [r for r in results if r["state"] not in ("other engine", "no camera", "no view layer")]
    whole = [r for r in counted if "verdicts" in r]
    exact = [r for r in whole if not r["verdicts"]]
    apart = [r for r in whole if all(LATER.search(reason) for reason in reasons(r))]
    total = max(len(counted), 1)
    lines = [
        f"{len(counted)} files that were saved with Cycles, of {len({repository(r['file']) for r in counted})} repositories",
        f"{len(whole)} exported ({len(whole) / total:.0%})",
        f"{len(exact)} wholly exact ({len(exact) / total:.0%})",
        f"{len(apart)} wholly exact apart from subsurface, volumes, hair and motion blur ({len(apart) / total:.0%})",
    ]
    for name, some in (("wholly exact", exact), ("exact apart from those", apart), ("all", whole)):
        rendered = [r for r in some if "blocks" in r]
        good = sum(map(agrees, rendered))
        lines.append(f"of {len(rendered)} rendered by both engines and {name}, {good} agree ({good / max(len(rendered), 1):.0%})")
    lines += ["", "Reasons, by files that have them (and files that have no other):"]
    found, alone = collections.Counter(), collections.Counter()
    for r in whole:
        now = [reason for reason in reasons(r) if not LATER.search(reason)]
        found.update(reasons(r))
        if len(now) == 1:
            alone.update(now)
    lines += [f"{n:4} {n / total:5.0%} {alone[reason]:4}  {reason}" for reason, n in found.most_common()]
    lines += ["", "Files that did not come to an end:"]
    lines += [f"  {r['state']}: {r['file']} {r.get('error', '')}" for r in counted if r["state"] != "done" or "error" in r]
    lines += ["", "Pictures that disagree (X: without a verdict; mean Sundog, Cycles, off; share of blocks, worst, where):"]
    wrong = sorted((r for r in whole if "blocks" in r and not agrees(r)), key=lambda r: (r not in apart, -r["blocks"]))
    for r in wrong:
        mark = "X" if r in exact else "x" if r in apart else " "
        lines.append(f"{mark} {r['means'][0]:.4g} {r['means'][1]:.4g} {r['off']:.1%}; {r['blocks']:.1%} {r['worst']:.2f} {r['worst_at']} {key(r['file'])}  {r['file']}")
    lines += ["", "Files by their reasons:"]
    for r in whole:
        for v in r["verdicts"]:
            lines.append(f"  {key(r['file'])}: {v['kind']} {v['name']}: {v['verdict']}: {v['detail']}")
    return "\n".join(lines) + "\n"


def repository(path):
    """The folder that stands for where a file comes from, as far as one can tell."""
    parts = path.split(os.sep)
    return parts[parts.index("blends") + 1] if "blends" in parts else os.path.dirname(path)


# All of them


def listed(options):
    """Paths of the files."""
    if os.path.isfile(options.files):
        with open(options.files, encoding="utf-8") as file:
            paths = file.read().split("\n")
    else:
        paths = sorted(os.path.join(folder, name) for folder, _, names in os.walk(options.files) for name in names if name.endswith(".blend"))
    return [path for path in paths if path and options.only in path]


def run(path, options):
    """The result of one file."""
    line = [sys.executable, os.path.abspath(__file__), path, "--one", "-o", options.output]
    line += ["--samples", str(options.samples), "--pixels", str(options.pixels)] + ["--render"] * options.render
    written = os.path.join(options.output, key(path) + ".json")
    end, why = None, ""
    try:
        done = subprocess.run(line, capture_output=True, text=True, errors="replace", timeout=options.seconds, check=False)
        end = done.returncode
        why = (done.stderr.strip() or done.stdout.strip())[-1500:]
    except subprocess.TimeoutExpired:
        why = f"not within {options.seconds:.0f} s"
    result = read_result(written) or {"file": path, "state": "starting"}
    if end != 0:
        result["error"] = why
        with open(written, "w", encoding="utf-8") as file:
            json.dump(result, file, indent=1)
    return result


def read_result(path):
    """A file's result, or None."""
    if not os.path.isfile(path):
        return None
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def main():
    """Goes over all files."""
    options = parser().parse_args()
    options.output = os.path.abspath(options.output)
    os.makedirs(options.output, exist_ok=True)
    if options.one:
        one(options)
        sys.stdout.flush()
        # Blender's own teardown has nothing to say on it.
        os._exit(0)
    results = []
    for path in listed(options):
        before = read_result(os.path.join(options.output, key(path) + ".json"))
        if before is not None and (options.table or not options.again):
            results.append(before)
            continue
        if options.table:
            continue
        result = run(path, options)
        results.append(result)
        said = f"{result['off']:.2%} {result['blocks']:.1%}" if "blocks" in result else ""
        print(f"{result['state']}: {len(result.get('verdicts', ()))} not exact {said} {path} {result.get('error', '')[-200:]}", flush=True)
        if not options.keep:
            import shutil

            place = os.path.join(options.output, key(path))
            for name in os.listdir(place) if os.path.isdir(place) else ():
                if not name.endswith((".exr", ".png")):
                    whole = os.path.join(place, name)
                    shutil.rmtree(whole) if os.path.isdir(whole) else os.remove(whole)
    with open(os.path.join(options.output, "table.txt"), "w", encoding="utf-8") as file:
        file.write(table(results))


if __name__ == "__main__":
    main()
