# SPDX-License-Identifier: GPL-3.0-or-later
"""The tiles of the parity matrix by both of the add-on's exchanges: the same picture, or a difference that is named.

    PYTHON_WITH_BPY tests/addon/parity_usd.py [--filter NODE[,NODE…]] [--out FILE.json] [--quick]

Values are shown by the emission of a Principled BSDF, and the points' numbers are UV maps: other shaders and attributes do not
come through USD, so that each tile would tell of these alone. All else is as in parity.py, with glTF in the place of Cycles.
A difference is named by the add-on's losses of the material, or by a message of the program's that is about it.
"""

import argparse
import collections
import json
import os
import sys
import tempfile

import bpy
import numpy
import parity
import parity_tiles

import export_kit as kit
from sundog import export
from sundog.export import usd

# Greatest relMSE of one exchange to the other.
BAR = 1e-4
SAMPLES, MORE = 64, 1024
# A message of the program's names so many objects.
NAMED = 4
# The layers of UV that hold what parity.py has as attributes: two numbers each.
LAYERS = {"place": ("place", "rest"), "unit": ("unit", "more"), "other": ("other", "more"), "fourth": ("rest", "rest"), "one": ("one", "one")}


def layers(mesh):
    """The points' numbers as UV maps: a mesh has eight of these at most."""
    loops = len(mesh.loops)
    kept = {}
    for name in ("place", "fourth", "unit", "other", "one"):
        data = mesh.attributes.get(name)
        if data is None:
            kept[name] = numpy.ones((loops, 3), numpy.float32)
            continue
        values = numpy.empty(len(data.data) * 3, numpy.float32)
        data.data.foreach_get("vector", values)
        values = values.reshape(-1, 3)
        if data.domain == "FACE":
            kept[name] = numpy.repeat(values, loops // len(values), axis=0)
        else:
            corners = numpy.empty(loops, numpy.int32)
            mesh.loops.foreach_get("vertex_index", corners)
            kept[name] = values[corners]
    pairs = {
        "place": kept["place"][:, :2], "unit": kept["unit"][:, :2], "other": kept["other"][:, :2], "one": kept["one"][:, :2],
        "rest": numpy.stack([kept["place"][:, 2], kept["fourth"][:, 0]], axis=-1),
        "more": numpy.stack([kept["unit"][:, 2], kept["other"][:, 2]], axis=-1),
    }  # fmt: skip
    for name, pair in pairs.items():
        mesh.uv_layers.new(name=f"pair_{name}").data.foreach_set("uv", numpy.ascontiguousarray(pair, numpy.float32).ravel())


class Tree(parity_tiles.Tree):
    """The material of a tile, shown and fed by what USD has."""

    def _pair(self, name):
        split = self._new("SeparateXYZ")
        self._link(self._new("UVMap", uv_map=f"pair_{name}").outputs[0], split.inputs[0])
        return split.outputs

    def _texture(self, socket):
        if self.tile.kind != "sheet":
            return super()._texture(socket)
        before = set(self.tree.nodes)
        super()._texture(socket)
        for node in set(self.tree.nodes) - before:
            if node.type == "ATTRIBUTE":
                first, last = LAYERS[node.attribute_name]
                pair, third = self._pair(first), self._pair(last)
                whole = self._new("CombineXYZ")
                self._link(pair[1 if node.attribute_name == "fourth" else 0], whole.inputs[0])
                self._link(pair[1], whole.inputs[1])
                self._link(third[1 if node.attribute_name in {"other", "fourth"} else 0], whole.inputs[2])
                for link in list(node.outputs["Vector"].links):
                    self._link(whole.outputs[0], link.to_socket)
                self.tree.nodes.remove(node)
        return None

    def _show(self, node):
        super()._show(node)
        shown = self.end.inputs["Surface"].links
        emission = shown[0].from_node if shown else None
        if emission is None or emission.type != "EMISSION" or emission == node:
            return
        strength = emission.inputs["Strength"].links[0].from_node
        one = strength.inputs[0].links[0].from_node
        self._link(self._pair("one")[0], strength.inputs[0])
        surface = self._new("BsdfPrincipled")
        surface.inputs["Base Color"].default_value = (0, 0, 0, 1)
        level = surface.inputs.get("Specular IOR Level") or surface.inputs["Specular"]
        level.default_value = 0
        self._link(emission.inputs["Color"].links[0].from_socket, surface.inputs.get("Emission Color") or surface.inputs["Emission"])
        self._link(strength.outputs[0], surface.inputs["Emission Strength"])
        self._link(surface.outputs[0], self.end.inputs["Surface"])
        for gone in (emission, one):
            self.tree.nodes.remove(gone)


def written(folder):
    """(what glTF, what USD makes of the scene)."""
    def task(depsgraph):
        by_gltf = export.write_scene(depsgraph, depsgraph.scene, os.path.join(folder, "gltf"), os.path.join(folder, "cache"))
        os.makedirs(os.path.join(folder, "usd"))
        return by_gltf, usd.write_scene(depsgraph, os.path.join(folder, "usd"))

    return kit.in_render(task)


def named(result, names):
    """(what is told of each material, whether the program has more to tell than it names)."""
    told = collections.defaultdict(list)
    for verdict in result.verdicts:
        if verdict["kind"] == "material" and verdict["verdict"] != "exact":
            told[verdict["name"]].append(verdict["detail"])
    more = False
    for message in kit.info(result.path)["diagnostics"]:
        for name in names:
            if any(f'"{name}"' in str(thing) or str(thing) == name for thing in message["objects"]):
                told[name].append(f"{message['feature']}: {message['instead']}")
        more |= message["count"] > len(message["objects"])
    return told, more


def scene_of(tiles):
    """As parity.py's, with the numbers as UV maps."""
    found = parity.scene_of(tiles, Tree)
    for mesh in bpy.data.meshes:
        layers(mesh)
    return found


def told_of_few(tiles):
    """What is told of each of so few tiles that the program names all of them."""
    names, *_ = scene_of(tiles)
    with tempfile.TemporaryDirectory(prefix="sundog-parity-") as folder, kit.quiet():
        told, _ = named(written(folder)[1], names)
    return [told[name] for name in names]


def measure(tiles, samples):
    """Rows of tiles of one kind."""
    names, columns, rows = scene_of(tiles)
    kind = tiles[0].kind
    size = parity.SIZES.get(kind, parity.SIZE)
    side = max(columns, rows) * size
    noisy = samples > parity.ONCE
    render = bpy.context.scene.render
    render.resolution_x = render.resolution_y = side
    render.resolution_percentage = 100
    filter_width = 0.01 if kind in parity.PLACES else None
    seeds = (1, 2) if noisy else (0,)
    with tempfile.TemporaryDirectory(prefix="sundog-parity-") as folder:
        with kit.quiet():
            results = written(folder)
        told, more = named(results[1], names)
        gltf, other = ([parity.by_sundog(r.path, side, side, samples, seed, filter_width) for seed in seeds] for r in results)
    left, low = (side - columns * size) // 2, (side - rows * size) // 2
    for number, (tile, name) in enumerate(zip(tiles, names)):
        column, row = number % columns, number // columns
        part = numpy.s_[low + row * size : low + (row + 1) * size, left + column * size : left + (column + 1) * size]
        found = parity.row_of(tile, [p[part] for p in other], [p[part] for p in gltf], "")
        same = found["relmse"] < BAR
        yield {
            "node": tile.node, "words": tile.words, "kind": kind, "relmse": found["relmse"], "usd": found["mean"], "gltf": found["cycles"],
            "told": "; ".join(told[name]), "more": more, "samples": samples, "result": "same" if same else "named" if told[name] else "unnamed",
        }  # fmt: skip


def run(tiles, say=print):
    """Rows of many tiles. Those that differ without a word are looked at with more samples, then asked for by fours."""
    found = [None] * len(tiles)
    kinds = collections.defaultdict(list)
    for number, tile in enumerate(tiles):
        kinds[tile.kind, parity.shines(tile)].append(number)
    for (kind, _), numbers in sorted(kinds.items()):
        few, many = {"sheet": (parity.ONCE, parity.ONCE), "ball": (parity.ONCE, parity.OFTEN)}.get(kind, (SAMPLES, MORE))
        for start in range(0, len(numbers), parity.MOST):
            _some(numbers[start : start + parity.MOST], tiles, few, found, say)
        again = [n for n in numbers if found[n]["result"] == "unnamed"]
        if again and many > few:
            _some(again, tiles, many, found, say)
        # The program's messages name the first few materials alone.
        again = [n for n in again if found[n]["result"] == "unnamed" and found[n]["more"]]
        for start in range(0, len(again), NAMED):
            part = again[start : start + NAMED]
            for n, told in zip(part, told_of_few([tiles[n] for n in part])):
                found[n]["told"], found[n]["result"] = "; ".join(told), "named" if told else "unnamed"
    return found


def _some(numbers, tiles, samples, found, say):
    for number, row in zip(numbers, measure([tiles[n] for n in numbers], samples)):
        found[number] = row
    counts = collections.Counter(found[n]["result"] for n in numbers)
    say(f"{len(numbers)} of {tiles[numbers[0]].kind}, {samples} samples: {dict(counts)}", flush=True)


def table(rows):
    """Lines: counts of each kind of node."""
    for node in sorted({row["node"] for row in rows}):
        of_node = [row for row in rows if row["node"] == node]
        counts = collections.Counter(row["result"] for row in of_node)
        needless = sum(row["result"] == "same" and bool(row["told"]) for row in of_node)
        yield f"| {node} | {len(of_node)} | {counts['same']} | {counts['named']} | {counts['unnamed']} | {needless} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--filter", default="", help="parts of nodes' names, with commas between them")
    parser.add_argument("--out", default="out/parity-usd.json")
    parser.add_argument("--quick", action="store_true", help="the default of each node alone")
    given = parser.parse_args()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    parity.picture()
    tiles = [tile for kind in parity.selected(given.filter) for tile in parity_tiles.tiles(kind)]
    if given.quick:
        tiles = [tile for tile in tiles if not tile.settings and not tile.inputs]
    rows = run(tiles)
    os.makedirs(os.path.dirname(os.path.abspath(given.out)), exist_ok=True)
    with open(given.out, "w", encoding="utf-8") as file:
        json.dump(rows, file, indent=0)
    print("| node | rows | same | named | not named | named and the same |\n| --- | --- | --- | --- | --- | --- |")
    print("\n".join(table(rows)))
    for row in rows:
        if row["result"] == "unnamed":
            print(f"NOT NAMED {row['words']}: mean {row['usd']:.4f} by USD, {row['gltf']:.4f} by glTF, relMSE {row['relmse']:.1e}")
    print(bpy.app.version_string, collections.Counter(row["result"] for row in rows))


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    # Blender's own teardown takes long and has nothing to say.
    os._exit(0)
