# SPDX-License-Identifier: GPL-3.0-or-later
"""Random node trees, by Sundog through the add-on and by the Cycles of the same bpy: what the matrix of single nodes leaves out.

    PYTHON_WITH_BPY tests/addon/parity_random.py sheet|ball|shader|volume|displacement [--first N] [--count N] [--samples N] [--folder FOLDER]

Each number is one tree, the same at each call in one Blender. Trees of values are shown on sheets (parity.py), those that look at
the place on balls, shaders and volumes on balls with noise. Writes FOLDER/KIND-N.txt of each tree that misses: nodes and pictures.
"""

import argparse
import functools
import os
import random
import sys

import bpy
import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, HERE)

import parity  # noqa: E402
import parity_tiles as tiles  # noqa: E402

# Nodes that are left out: those that need more than a tree, and those that make rounding visible or have noise of their own.
LEFT_OUT = {
    *tiles.NOT_SHOWN, *tiles.OF_RAYS, "BsdfHair", "BsdfHairPrincipled", "BsdfToon", "HairInfo", "LightFalloff", "ParticleInfo", "PointInfo",
    "Raycast", "TexIES", "TexPointDensity", "TexSky", "VolumeInfo",
}  # fmt: skip

# Chaotic ones: what they take comes from the points alone.
CHAOTIC = {"TexWhiteNoise", "TexGabor"}

# Within what people set them: Cycles does not bound all, and what is beyond is not defined.
BOUNDS = {
    "Abbe Number": (10, 80), "Anisotropy": (0, 0.9), "Angle": (0, 6), "Blackbody Intensity": (0, 0), "Brick Width": (0.2, 1), "Coat IOR": (1, 3),
    "Density": (0.1, 2), "Detail": (0, 5), "Distance": (0.02, 0.5), "Distortion": (0, 2), "Emission Strength": (0, 1), "Exponent": (0.5, 3),
    "Filter Width": (0.1, 1), "Frequency": (0.5, 4), "Gain": (0.2, 2), "Gamma": (0.4, 2.2), "IOR": (1, 3), "Lacunarity": (0.5, 3),
    "Mortar Size": (0, 0.1), "Row Height": (0.2, 1), "Saturation": (0, 2), "Scale": (0.5, 5), "Sides": (3, 8), "Steps": (1, 6),
    "Strength": (0, 1), "Subsurface Scale": (0.02, 0.3), "Temperature": (1000, 9000), "Thin Film Thickness": (0, 800), "Value": (0, 2),
    "Wavelength": (400, 700),
}  # fmt: skip

# What makes nothing defined where it is 0.
NEVER_LINKED = {"Brick Width", "Row Height", "Sides", "Roundness", "Thin Wall"}

NUMBERS = {"VALUE", "RGBA", "VECTOR", "INT", "BOOLEAN", "ROTATION"}
# Channels of a texel may differ by so much of the tree's mean and of themselves, in this share of texels: edges are seen from both sides.
CLOSE, EDGES = 1e-3, {"sheet": 0.1}


def kinds(kind):
    """(nodes that give numbers, nodes that give what a tree of this kind ends with)."""
    material = bpy.data.materials.new("scratch")
    material.use_nodes = True
    numbers, ends = [], []
    for name in tiles.kinds():
        node = None if name in LEFT_OUT else tiles.of_kind(material.node_tree, name)
        outputs = {s.type for s in tiles.shown(node.outputs)} if node else set()
        if "SHADER" in outputs:
            # Sums of shaders make light, and portals may meet themselves: such balls are noise for all others.
            makes_light = kind == "shader" and name in {"AddShader", "BsdfRayPortal"}
            if not makes_light and (name.startswith("Volume") == (kind == "volume") or name in {"MixShader", "AddShader"}):
                ends.append(name)
        elif outputs & NUMBERS and name not in {"Displacement", "VectorDisplacement"} and not (kind == "sheet" and name in tiles.OF_PLACES):
            numbers.append(name)
    bpy.data.materials.remove(material)
    return numbers, ends


class Tree:
    """Makes the material of a random tree."""

    def __init__(self, known, tile, name):
        self.kind, self.dice = tile.kind, random.Random(f"{tile.kind} {tile.node}")
        self.numbers, self.ends = known
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        self.end = self.tree.nodes.new("ShaderNodeOutputMaterial")
        self.left, self.made = self.dice.choice((1, 2, 4, 8, 12)), []
        if self.kind in {"shader", "volume"}:
            self.tree.links.new(self._shader(0), self.end.inputs["Volume" if self.kind == "volume" else "Surface"])
            return
        if self.kind == "displacement":
            return self._displaced()
        emission = self.tree.nodes.new("ShaderNodeEmission")
        self.tree.links.new(self._number(0), emission.inputs["Color"])
        self.tree.links.new(self._attribute("one", "Fac"), emission.inputs["Strength"])
        self.tree.links.new(emission.outputs[0], self.end.inputs["Surface"])

    def _displaced(self):
        """Matte, and displaced or bumped by the tree."""
        matte = self.tree.nodes.new("ShaderNodeBsdfDiffuse")
        self.tree.links.new(matte.outputs[0], self.end.inputs["Surface"])
        kind = self.dice.choice(("Displacement", "Displacement", "VectorDisplacement"))
        node = self._node(kind)
        self._fill(node, kind, 0)
        height = node.inputs["Height" if kind == "Displacement" else "Vector"]
        if not height.is_linked:
            self.tree.links.new(self._number(1), height)
        # The balls stay apart.
        node.inputs["Scale"].default_value = 0.08
        for link in list(node.inputs["Scale"].links):
            self.tree.links.remove(link)
        self.tree.links.new(node.outputs[0], self.end.inputs["Displacement"])
        self.material.displacement_method = self.dice.choice(("BUMP", "DISPLACEMENT", "BOTH"))

    def _attribute(self, name, output):
        node = self.tree.nodes.new("ShaderNodeAttribute")
        node.attribute_name = name
        return node.outputs[output]

    def _source(self):
        name = self.dice.choice(("unit", "place", "other") if self.kind == "sheet" else ("unit",))
        return self._attribute(name, self.dice.choice(("Color", "Vector", "Fac")))

    def _node(self, kind):
        node = tiles.of_kind(self.tree, kind)
        if node is not None:
            tiles.prepare(node, kind)
            for path, values, _ in list(tiles.menus(node)):
                if self.dice.random() < 0.5:
                    tiles.apply(node, ((path, self.dice.choice(values)),))
        return node

    def _number(self, depth):
        if self.made and self.dice.random() < 0.15:
            return self.dice.choice(self.made)
        if self.left <= 0 or depth > 5:
            return self._source()
        self.left -= 1
        while True:
            kind = self.dice.choice(self.numbers)
            node = self._node(kind)
            outputs = [s for s in tiles.shown(node.outputs) if s.type in NUMBERS] if node else []
            if outputs:
                break
        self._fill(node, kind, depth)
        self.made.append(self.dice.choice(outputs))
        return self.made[-1]

    def _shader(self, depth):
        common = "VolumePrincipled" if self.kind == "volume" else "BsdfPrincipled"
        while True:
            kind = self.dice.choice(self.ends) if self.dice.random() < 0.7 else self.dice.choice(("MixShader", common))
            if depth >= 3 and kind in {"MixShader", "AddShader"}:
                continue
            node = self._node(kind)
            if node is not None:
                break
        self._fill(node, kind, depth)
        return node.outputs[0]

    def _fill(self, node, kind, depth):
        dice = self.dice
        # Blender evaluates what is constant itself (5.x), not always as Cycles does: one socket of each varies.
        varies = [s for s in tiles.shown(node.inputs) if tiles.is_swept(s) and s.name not in NEVER_LINKED]
        varies = dice.choice(varies) if varies and self.kind == "sheet" else None
        for socket in tiles.shown(node.inputs):
            if socket.type == "SHADER":
                self.tree.links.new(self._shader(depth + 1), socket)
                continue
            if not tiles.is_swept(socket):
                continue
            leans = socket.hide_value and socket.type == "VECTOR"
            if leans and socket.name != "Vector":
                if socket.name.endswith("Normal") and dice.random() < 0.1:
                    bump = self.tree.nodes.new("ShaderNodeBump")
                    bump.inputs["Strength"].default_value, bump.inputs["Distance"].default_value = dice.random(), 0.1
                    self.tree.links.new(self._number(depth + 1), bump.inputs["Height"])
                    self.tree.links.new(bump.outputs[0], socket)
            elif kind in CHAOTIC and self.kind == "sheet":
                if leans or dice.random() < 0.4:
                    self.tree.links.new(self._attribute(dice.choice(("unit", "place", "other")), "Vector"), socket)
                else:
                    self._set(socket)
            elif socket == varies or (leans and self.kind == "sheet") or (dice.random() < 0.3 and socket.name not in NEVER_LINKED):
                self.tree.links.new(self._number(depth + 1) if dice.random() < 0.7 else self._source(), socket)
            elif dice.random() < 0.6:
                self._set(socket)

    def _set(self, socket):
        dice = self.dice
        was = socket.default_value
        if socket.type == "RGBA":
            socket.default_value = [dice.random() for _ in range(3)] + [1.0]
        elif socket.type in {"VECTOR", "ROTATION"}:
            low = 0 if socket.name in {"Radius", "Subsurface Radius", "Scale"} else -1
            socket.default_value = [dice.uniform(low, 1) for _ in was]
        elif socket.type == "BOOLEAN":
            socket.default_value = dice.random() < 0.2
        else:
            low, high = BOUNDS.get(socket.name, (0, 1))
            socket.default_value = type(was)(dice.uniform(low, high))


def words(tree):
    """A tree as lines: nodes, settings, sockets."""
    lines, seen = [], set()

    def walk(node, indent):
        settings = " ".join(f"{path}={was}" for path, _, was in tiles.menus(node))
        lines.append(f"{indent}{node.bl_idname.removeprefix('ShaderNode')} {settings}{' (above)' if node in seen else ''}")
        if node in seen:
            return
        seen.add(node)
        for socket in tiles.shown(node.inputs):
            if socket.is_linked:
                source = socket.links[0].from_socket
                lines.append(f"{indent} .{socket.identifier} <- {source.identifier} ({source.type} to {socket.type})")
                walk(source.node, indent + "    ")
            elif tiles.is_swept(socket):
                value = socket.default_value
                value = tuple(round(v, 4) for v in value) if hasattr(value, "__len__") else round(value, 4)
                lines.append(f"{indent} .{socket.identifier} = {value}")

    walk(next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL"), "")
    return "\n".join(lines)


def run(kind, first, count, samples):
    """(number, row of parity.py, share of texels that differ, whether it misses, the tree in words, both pictures) of each tree."""
    numbers = range(first, first + count)
    wanted = [tiles.Tile(f"tree {n}", (), (), "", kind) for n in numbers]
    rows, shown = parity.measure(wanted, samples, functools.partial(Tree, kinds(kind)))
    for place, (number, row, (ours, theirs)) in enumerate(zip(numbers, rows, shown)):
        a, b = (numpy.nan_to_num(p.astype(float)) for p in (ours, theirs))
        far = (abs(a - b) > CLOSE * (abs(b) + max(abs(b).mean(), 0.01))).any(-1).mean()
        misses = far > EDGES[kind] if kind in EDGES else row["mean_difference"] > parity.MEAN or row["relmse"] > parity.OTHER
        yield number, row, far, bool(misses), words(bpy.data.materials[f"t{place}"].node_tree), (ours, theirs)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("kind", choices=("sheet", "ball", "shader", "volume", "displacement"))
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--samples", type=int, default=0, help="1 of sheets and balls, 1024 of shaders and volumes")
    parser.add_argument("--folder", default="out/parity-random")
    given = parser.parse_args()
    os.makedirs(given.folder, exist_ok=True)
    missed = told = 0
    for number, row, far, misses, tree, (ours, theirs) in run(given.kind, given.first, given.count, given.samples or (1 if given.kind in {"sheet", "ball"} else 1024)):
        said = row["flattened"] or row["told"]
        missed, told = missed + (misses and not said), told + bool(said)
        if misses and not said:
            print(f"MISS {number}: {far:.0%} of the texels; mean {row['mean']:.5g} against {row['cycles']:.5g} ({row['mean_difference']:.2%}), relMSE {row['relmse']:.1e}")
        elif said:
            print(f"{'miss' if misses else 'told'} {number}: ({row['mean_difference']:.2%}, relMSE {row['relmse']:.1e}) {said[:300]}")
        if misses:
            with open(os.path.join(given.folder, f"{given.kind}-{number}.txt"), "w", encoding="utf-8") as file:
                with numpy.printoptions(threshold=10**6, linewidth=200, precision=4):
                    file.write(f"{tree}\n\nSundog\n{ours.mean(-1)}\n\nCycles\n{theirs.mean(-1)}\n")
    print(f"{given.count} trees of {given.kind}: {missed} miss, {told} are told of")


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    # Blender's own teardown takes long and has nothing to say.
    os._exit(0)
