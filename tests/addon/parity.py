# SPDX-License-Identifier: GPL-3.0-or-later
"""The parity matrix: every shader node of a Blender, by Sundog through the add-on and by the Cycles of the same bpy.

    PYTHON_WITH_BPY tests/addon/parity.py [--filter NODE[,NODE…]] [--folder FOLDER] [--quick]

Writes FOLDER/VERSION.json with all rows and FOLDER/VERSION/NODE.png, contact sheets: of each row what Sundog shows, what
Cycles shows, and four times the difference. tests/addon/parity_table.py makes docs/parity.md of the JSON files.

Nodes of values are shown by an emission on sheets of 8 × 8 faces that carry their numbers as attributes, one sample a face,
so that both programs compute with the same bits. Nodes that look at the place are shown so on balls, by rays through the
pixels' middles. Shaders are balls (those of hair: bent strands) below a grey world and a sun, far apart in depth, so that no light goes from one to another:
two pictures of independent noise by each program, of whose differences the product is the squared difference without noise.
"""

import argparse
import hashlib
import json
import os
import struct
import subprocess
import sys
import tempfile
import time
import zlib

import bpy
import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)

import export_kit as kit  # noqa: E402
import parity_tiles  # noqa: E402
from sundog import export  # noqa: E402

# Greatest difference of means, and relMSE: of patterns, and of all others.
MEAN, PATTERN, OTHER = 0.01, 1e-5, 1e-3
# Pixels of a tile's side: of sheets one for each point.
SIZES = {"sheet": 8}
SIZE = 16
# Tiles that show the place, by rays through the pixels' middles.
PLACES = {"ball", "rays"}
# Samples of a pixel, and of rows that miss.
SAMPLES, MORE = 256, 2048
# The same of balls that show the place. The narrowest filter is a hundredth of a pixel wide: of an edge that passes a pixel's middle
# as near as that, one sample of each program may see either side.
ONCE, OFTEN = 1, 1024
# The sun's angle. Rays alone find it through glass and in sharp highlights, each time with a radiance that goes with its inverse
# square: of an angle of 0.1 the noise of two programs with 2048 samples was up to 4 % of a ball's light.
SUN = 0.6
# Tiles in one picture. Fibres that absorb nothing have values without bounds in Cycles (of either sign), which light
# carries on to all others.
MOST, ALONE = 400, {"strands"}
# Depth between two balls next to each other: the farther from the origin, the fewer bits a walk below the surface has in Cycles.
# Those that shine are farther apart: not to light each other, nor darken, as light of less than nothing does in Cycles.
STEP, FAR_STEP, STEPS = 0.25, 30.0, 64


def layout(count):
    """Columns and rows of so many tiles."""
    columns = max(1, int(numpy.ceil(numpy.sqrt(count))))
    return columns, -(-count // columns)


def points(name):
    """Numbers of the 64 faces of a sheet: coordinates of some sizes, or colours."""
    dice = numpy.random.default_rng(sum(map(ord, name)))
    found = dice.uniform(0, 1, (64, 3))
    if name in {"place", "fourth"}:
        found = dice.uniform(-3, 3, (64, 3))
        found[40:48] = dice.uniform(-30, 30, (8, 3))
        found[48:52] = numpy.round(found[48:52])
    elif name == "one":
        found[:] = 1
    elif name == "other":
        found = dice.uniform(-1, 2, (64, 3))
    # No negative zeros: their bits do not come through interpolation.
    return found.astype(numpy.float32) + numpy.float32(0)


def attribute(mesh, name, domain, values):
    """A vector attribute of a mesh."""
    made = mesh.attributes.new(name, "FLOAT_VECTOR", domain)
    made.data.foreach_set("vector", numpy.ascontiguousarray(values, numpy.float32).ravel())


def sheets(materials):
    """One mesh of sheets, a material for each."""
    columns, rows = layout(len(materials))
    side = SIZES["sheet"]
    corners, faces = [], []
    for tile in range(len(materials)):
        for face in range(side * side):
            x, y = tile % columns * side + face % side, tile // columns * side + face // side
            faces.append([len(corners) + i for i in range(4)])
            corners += [(x, y, 0), (x + 1, y, 0), (x + 1, y + 1, 0), (x, y + 1, 0)]
    mesh = bpy.data.meshes.new("sheets")
    mesh.from_pydata(corners, [], faces)
    mesh.uv_layers.new(name="UVMap")
    for name in ("place", "fourth", "unit", "other", "one"):
        attribute(mesh, name, "FACE", numpy.tile(points(name), (len(materials), 1)))
    for material in materials:
        mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", numpy.repeat(numpy.arange(len(materials), dtype=numpy.int32), side * side))
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("sheets", mesh))
    return columns, rows, side


def balls(materials, step):
    """A ball for each material, as far apart in depth."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.46)
    first = bpy.context.object
    first.data.shade_smooth()
    count = len(first.data.vertices)
    unit = numpy.empty(count * 3, numpy.float32)
    first.data.vertices.foreach_get("co", unit)
    attribute(first.data, "unit", "POINT", unit.reshape(-1, 3) + 0.5)
    attribute(first.data, "one", "POINT", numpy.ones((count, 3)))
    tint = first.data.color_attributes.new("tint", "FLOAT_COLOR", "POINT")
    colors = numpy.concatenate([unit.reshape(-1, 3) + 0.5, numpy.full((count, 1), 0.6)], axis=1)
    tint.data.foreach_set("color", colors.astype(numpy.float32).ravel())
    return placed(first, materials, step)


def strands(materials, step):
    """Bent strands for each material, as far apart in depth."""
    count, keys = 9, 6
    along = numpy.linspace(0, 1, keys)
    x = numpy.linspace(-0.38, 0.38, count)[:, None] + 0.02 * numpy.sin(7 * along)
    y, z = numpy.broadcast_to(0.9 * along - 0.45, x.shape), 0.1 * numpy.sin(5 * along + numpy.arange(count)[:, None])
    data = bpy.data.hair_curves.new("strands")
    data.add_curves([keys] * count)
    data.attributes["position"].data.foreach_set("vector", numpy.stack([x, y, z], axis=-1).astype(numpy.float32).ravel())
    radius = data.attributes.get("radius") or data.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", numpy.full(count * keys, 0.04, numpy.float32))
    first = bpy.data.objects.new("strands", data)
    bpy.context.scene.collection.objects.link(first)
    bpy.context.scene.cycles_curves.shape = "THICK"
    return placed(first, materials, step)


def placed(first, materials, step):
    """An object and others of its data, each with a material, in columns and rows."""
    columns, rows = layout(len(materials))
    first.data.materials.append(None)
    for number, material in enumerate(materials):
        made = first if number == 0 else bpy.data.objects.new(f"{first.name} {number}", first.data)
        if number:
            bpy.context.scene.collection.objects.link(made)
        # No two neighbours are at similar depths, where light could go from one to another.
        depth = (number * 37 % STEPS - STEPS / 2) * step
        made.location = (number % columns + 0.5, number // columns + 0.5, depth)
        made.rotation_euler, made.scale = (0.5, 0.3, 0.2), (1.0, 0.9, 0.8)
        made.pass_index, made.color = number % 7, (0.2, 0.5, 0.7, 1)
        made.material_slots[0].link = "OBJECT"
        made.material_slots[0].material = material
    return columns, rows, 1


def scene_of(tiles, tree):
    """An empty file with these tiles: (names of materials, columns, rows)."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    picture()
    kind = tiles[0].kind
    names = [f"t{number}" for number in range(len(tiles))]
    materials = [tree(tile, name).material for tile, name in zip(tiles, names)]
    apart = 0.0 if kind in PLACES else FAR_STEP if shines(tiles[0]) else STEP
    if kind == "sheet":
        columns, rows, step = sheets(materials)
    else:
        columns, rows, step = (strands if kind == "strands" else balls)(materials, apart)
    scene = bpy.context.scene
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", max(columns, rows) * step
    camera.clip_end = 1e5
    shown = bpy.data.objects.new("camera", camera)
    shown.location = (columns * step / 2, rows * step / 2, 10 + apart * STEPS / 2)
    scene.collection.objects.link(shown)
    scene.camera = shown
    if kind not in {"sheet", *PLACES}:
        kit.sun_and_grey_world(scene, SUN)
    return names, columns, rows


def picture():
    """The image that nodes show."""
    image = bpy.data.images.new("parity", 16, 8, alpha=True)
    across, up = numpy.meshgrid(numpy.arange(16), numpy.arange(8))
    pixels = [across / 15, up / 7, 0.5 + 0.5 * numpy.sin(across + 2.0 * up), 0.2 + 0.8 * up / 7]
    image.pixels.foreach_set(numpy.stack(pixels, axis=-1).astype(numpy.float32).ravel())
    image.pack()


def by_cycles(width, height, samples, seed, filter_width):
    """Cycles' picture."""
    kit.for_cycles(width, height, samples)
    scene = bpy.context.scene
    cycles = scene.cycles
    cycles.seed = seed
    cycles.pixel_filter_type = "BOX" if filter_width is None else "BLACKMAN_HARRIS"
    cycles.filter_width = filter_width or 1.5
    kit.unbiased(cycles)
    for name in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "volume_bounces"):
        setattr(cycles, name, 12)
    cycles.transparent_max_bounces = 256
    cycles.caustics_reflective = cycles.caustics_refractive = True
    with tempfile.TemporaryDirectory(prefix="sundog-parity-") as folder:
        scene.render.filepath = os.path.join(folder, "cycles.exr")
        with kit.quiet():
            bpy.ops.render.render(write_still=True)
        return kit.exr_pixels(scene.render.filepath)


def by_sundog(path, width, height, samples, seed, filter_width):
    """Sundog's picture."""
    out = f"{path}.{seed}.exr"
    shape = "box" if filter_width is None else f"blackman-harris:{filter_width}"
    command = [kit.program(), "render", path, "-o", out, "--width", str(width), "--height", str(height), "--quiet", "--allow-outside"]
    command += ["--samples", str(samples), "--seed", str(seed), "--filter", shape, "--exr-layers", "combined"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=3600)
    if done.returncode:
        raise RuntimeError(done.stderr)
    return kit.exr_pixels(out)


def measure(tiles, samples, tree=parity_tiles.Tree):
    """(rows, pictures of each row) of tiles of one kind, whose materials a tree makes."""
    names, columns, rows = scene_of(tiles, tree)
    kind = tiles[0].kind
    size = SIZES.get(kind, SIZE)
    side = max(columns, rows) * size
    noisy = samples > ONCE
    filter_width = 0.01 if kind in PLACES else None
    bpy.context.scene.render.resolution_x = bpy.context.scene.render.resolution_y = side
    bpy.context.scene.render.resolution_percentage = 100
    with tempfile.TemporaryDirectory(prefix="sundog-parity-") as folder:
        where, cache = os.path.join(folder, "scene"), os.path.join(folder, "cache")
        result = kit.in_render(lambda depsgraph: export.write_scene(depsgraph, depsgraph.scene, where, cache))
        with open(result.path, encoding="utf-8") as file:
            root = json.load(file)
        flattened, told = reasons(root, result, names)
        seeds = (1, 2) if noisy else (0,)
        ours = [by_sundog(result.path, side, side, samples, seed, filter_width) for seed in seeds]
    theirs = [by_cycles(side, side, samples, seed, filter_width) for seed in seeds]
    found, shown = [], []
    # Tiles stand in the middle of a square picture.
    left, low = (side - columns * size) // 2, (side - rows * size) // 2
    for number, (tile, name) in enumerate(zip(tiles, names)):
        column, row = number % columns, number // columns
        part = numpy.s_[low + row * size : low + (row + 1) * size, left + column * size : left + (column + 1) * size]
        a, b = [p[part] for p in ours], [p[part] for p in theirs]
        found.append({**row_of(tile, a, b, flattened[name]), "told": told[name]})
        shown.append((a[0], b[0]))
    return found, shown


def reasons(root, result, names):
    """Why materials are flattened, and what is told of those whose trees are evaluated, by their names; "" where there is nothing."""
    graphs = {m["name"]: "SUNDOG_shader_graph" in m.get("extensions", {}) for m in root.get("materials", [])}
    verdicts = {v["name"]: v for v in result.verdicts if v["kind"] == "material"}
    flattened, told = dict.fromkeys(names, ""), dict.fromkeys(names, "")
    for name in names:
        verdict = verdicts.get(name, {"verdict": "exact", "detail": ""})
        whole = "not evaluated" not in verdict["detail"]
        if verdict["verdict"] != "exact" or not whole:
            where = told if whole and graphs.get(name) else flattened
            where[name] = verdict["detail"] or verdict["verdict"]
    return flattened, told


def made_by():
    """Which program and which tree of the project make the rows."""
    with open(kit.program(), "rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()[:8]
    command = ["git", "-C", kit.PROJECT, "describe", "--always", "--dirty"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return f"program {digest}, tree {done.stdout.strip() or 'unknown'}, {time.strftime('%Y-%m-%d')}"


def blocks(p):
    """Means of 2 × 2 pixels, of which noise and edges make less."""
    return p.reshape(p.shape[0] // 2, 2, p.shape[1] // 2, 2, 3).mean(axis=(1, 3))


def row_of(tile, ours, theirs, flattened):
    """What both pictures of a tile say."""
    ours, theirs = [numpy.nan_to_num(p.astype(float)) for p in ours], [numpy.nan_to_num(p.astype(float)) for p in theirs]
    if len(ours) == 2:
        ours, theirs = [blocks(p) for p in ours], [blocks(p) for p in theirs]
    a, b = sum(ours) / len(ours), sum(theirs) / len(theirs)
    product = (ours[0] - theirs[0]) * (ours[-1] - theirs[-1])
    error = float((product / (b**2 + 0.01)).mean())
    # Of numbers of both signs the mean says nothing.
    by_mean = float(abs(a.mean() - b.mean()) / max(abs(b).mean(), 1e-3))
    bar = PATTERN if tile.is_pattern else OTHER
    return {
        "node": tile.node,
        "settings": dict(tile.settings),
        "inputs": dict(tile.inputs),
        "output": tile.output,
        "kind": tile.kind,
        "mean": float(a.mean()),
        "cycles": float(b.mean()),
        "mean_difference": by_mean,
        "relmse": error,
        "bar": bar,
        "flattened": flattened,
        "ok": bool(by_mean <= MEAN and error <= bar and not flattened),
    }


def run(tiles, samples=SAMPLES, more=MORE, say=print):
    """(rows, pictures) of many tiles; noisy ones that miss are looked at with more samples."""
    found, shown = [None] * len(tiles), [None] * len(tiles)
    kinds = {}
    for number, tile in enumerate(tiles):
        kinds.setdefault((tile.kind, shines(tile)), []).append(number)
    for (kind, _), numbers in sorted(kinds.items()):
        most = 1 if kind in ALONE else MOST
        for start in range(0, len(numbers), most):
            part = numbers[start : start + most]
            few, many = {"sheet": (ONCE, ONCE), "ball": (ONCE, OFTEN)}.get(kind, (samples, more))
            _some(part, tiles, few, found, shown, say)
            again = [n for n in part if not found[n]["ok"] and not found[n]["flattened"]]
            if many > few and again:
                _some(again, tiles, many, found, shown, say)
    return found, shown


def _some(numbers, tiles, samples, found, shown, say):
    begun = time.monotonic()
    rows, pictures = measure([tiles[n] for n in numbers], samples)
    for number, row, picture_ in zip(numbers, rows, pictures):
        found[number], shown[number] = row, picture_
    misses = sum(not row["ok"] for row in rows)
    # Of one that agrees nothing need be said.
    if misses or len(rows) > 1:
        say(f"{len(rows)} of {tiles[numbers[0]].kind}, {misses} miss, {time.monotonic() - begun:.0f} s", flush=True)


def shines(tile):
    """Whether a shader gives light, of which others would see something."""
    return tile.kind == "shader" and ("Emission" in tile.node or any("Emission" in name for name, _ in tile.inputs))


def contact_sheet(path, shown):
    """A PNG with rows of three tiles side by side, as sRGB."""
    size = shown[0][0].shape[0]
    columns = 8
    rows = -(-len(shown) // columns)
    sheet = numpy.full((rows * (size + 2), columns * (3 * size + 6), 3), 0.05)
    for number, (ours, theirs) in enumerate(shown):
        y, x = number // columns * (size + 2), number % columns * (3 * size + 6)
        for place, part in enumerate((ours, theirs, 4 * abs(ours - theirs))):
            left = x + place * (size + 1)
            sheet[y : y + size, left : left + size] = part[::-1]
    encoded = numpy.clip(numpy.nan_to_num(sheet), 0, 1)
    encoded = numpy.where(encoded <= 0.0031308, encoded * 12.92, 1.055 * encoded ** (1 / 2.4) - 0.055)
    pixels = numpy.repeat(numpy.repeat((encoded * 255 + 0.5).astype(numpy.uint8), 2, axis=0), 2, axis=1)
    rows_of_bytes = b"".join(b"\0" + row.tobytes() for row in pixels)

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">2I5B", pixels.shape[1], pixels.shape[0], 8, 2, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows_of_bytes)) + chunk(b"IEND", b""))


def selected(names):
    """Kinds of nodes of a filter's names; all of none."""
    known = list(parity_tiles.kinds())
    wanted = [n for n in names.split(",") if n]
    return [k for k in known if not wanted or any(w.lower() in k.lower() for w in wanted)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--filter", default="", help="parts of nodes' names, with commas between them")
    parser.add_argument("--folder", default="out/parity")
    parser.add_argument("--samples", type=int, default=SAMPLES)
    parser.add_argument("--quick", action="store_true", help="the default of each node alone")
    given = parser.parse_args()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    picture()
    kinds = selected(given.filter)
    tiles = [tile for kind in kinds for tile in parity_tiles.tiles(kind)]
    if given.quick:
        tiles = [tile for tile in tiles if not tile.settings and not tile.inputs]
    found, shown = run(tiles, given.samples)
    version = ".".join(map(str, bpy.app.version))
    folder = os.path.join(given.folder, version)
    os.makedirs(folder, exist_ok=True)
    for kind in kinds:
        of_kind = [picture_ for tile, picture_ in zip(tiles, shown) if tile.node == kind]
        if of_kind:
            contact_sheet(os.path.join(folder, f"{kind}.png"), of_kind)
    with open(f"{folder}.json", "w", encoding="utf-8") as file:
        rows = ",\n".join(json.dumps(row) for row in found)
        skipped = {kind: parity_tiles.NOT_SHOWN[kind] for kind in kinds if kind in parity_tiles.NOT_SHOWN}
        # Runs of whole kinds of nodes can take the place of those in an older one (parity_table.py).
        head = {"blender": version, "made_by": made_by(), "whole_kinds": not given.quick, "not_shown": skipped}
        file.write(json.dumps(head)[:-1] + f',\n"rows": [\n{rows}\n]}}\n')
    for row, tile in zip(found, tiles):
        if not row["ok"]:
            print(f"MISS {tile.words}: mean {row['mean']:.4f} against {row['cycles']:.4f} ({row['mean_difference']:.2%}), relMSE {row['relmse']:.1e}", row["flattened"])
    misses = sum(not row["ok"] for row in found)
    print(f"Blender {version}: {len(found)} rows, {misses} miss, {sum(bool(row['flattened']) for row in found)} of them flattened")


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    # Blender's own teardown takes long and has nothing to say.
    os._exit(0)
