# SPDX-License-Identifier: GPL-3.0-or-later
"""The parity matrix as a page: PYTHON tests/addon/parity_table.py VERSION.json [VERSION.json…] > docs/parity.md"""

import json
import sys

EDGES = "pixels through whose middle an edge of a face goes, or the ball's: the one takes this face, the other that"
# Why rows miss, by node, and where that is not enough by a part of the row's words: what no verdict of the add-on says.
REASONS = {
    ("TexSky", ""): "a table asked of Cycles, read between its texels; at places that are no directions, which the rows show, also the sun's disc",
    ("TexImage", "Closest"): "places on the border of two texels, where rounding decides",
    **dict.fromkeys([(node, "") for node in ("Bump", "Fresnel", "NewGeometry", "NormalMap", "VectorTransform")], EDGES),
    ("Wireframe", ""): "pixels through whose middle the edge of a line goes: a line is black or white, and rounding decides",
    ("BsdfGlass", ""): "noise: few paths find the sun through glass; means differ upwards and downwards",
    ("BsdfRefraction", ""): "noise: few paths find the sun through glass of low roughness",
    **dict.fromkeys([("BsdfAnisotropic", ""), ("BsdfMetallic", "")], "noise of the sun's sharp highlight"),
    ("Raycast", ""): "few of its rays meet anything: the edges of other rows' balls",
    ("Bevel", ""): "its rays lie otherwise, which shows where the radius is that of the ball",
    ("Displacement", ""): "strong bumps are a little darker: both sampling techniques refuse the same directions (docs/sundog-and-cycles.md)",
    **dict.fromkeys(
        [("Emission", "Strength low"), ("BsdfPrincipled", "Emission Strength low")], "negative light, which Cycles shows and Sundog does not"
    ),
    ("BsdfPrincipled", "Coat"): "noise of the sun's highlight in a coat",
    ("BsdfPrincipled", "Subsurface"): "Cycles' walks lose light away from the origin; at it both agree within 0.1 %",
    ("SubsurfaceScattering", ""): "Cycles' walks lose light away from the origin; at it both agree within 0.4 %",
}

PAGE = """# Parity with Cycles, node by node

Made by `make parity` (tests/addon/parity.py) and tests/addon/parity_table.py. Rows are made by introspection: of every kind of
shader node every choice of its menus, every socket at a low, middle and high value and textured, every output; pairs of
menus; pairs of the Principled BSDF's sockets. Sundog renders what the add-on exports, Cycles is that of the same Blender.

Bars: the mean within 1 %, relMSE below 1e-3, of textures below 1e-5. Values are shown by an emission, at points known to the
bit; nodes that look at the place on balls; shaders on balls below a grey world and a sun, with the noise cancelled
(the product of the differences of two independent pairs of pictures). What the add-on flattens counts as a miss.

"""


def words(row):
    """A row in words, but for its node."""
    settings = [f"{name.split('.')[-1]} {value}" for name, value in row["settings"].items()]
    inputs = [f"{name} {level}" for name, level in row["inputs"].items()]
    return ", ".join([*settings, *inputs, f"→ {row['output']}"])


def reason(row):
    """Why a row misses."""
    if row["flattened"]:
        told = row["flattened"]
        _, found, names = told.partition("not evaluated as they are because of: ")
        return f"flattened: {names}" if found else told
    for (node, part), told in REASONS.items():
        if node == row["node"] and part in words(row):
            return told
    return "not looked into"


def badness(row):
    """How far a row is from its bars."""
    return max(row["mean_difference"] / 0.01, abs(row["relmse"]) / row["bar"])


def table(report):
    """The lines of one version."""
    rows = report["rows"]
    missed = [row for row in rows if not row["ok"]]
    flattened = [row for row in missed if row["flattened"]]
    by_node = {}
    for row in rows:
        by_node.setdefault(row["node"], []).append(row)
    clean = sum(all(row["ok"] for row in found) for found in by_node.values())
    yield f"## Blender {report['blender']}"
    yield ""
    yield f"{len(rows)} rows of {len(by_node)} nodes: {len(rows) - len(missed)} agree, {len(missed)} miss, {len(flattened)} of"
    yield f"them because the add-on flattens the tree. {clean} nodes agree in all rows."
    yield ""
    yield "| node | rows | miss | worst row | mean differs by | relMSE | verdict | reason |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- |"
    for node, found in by_node.items():
        misses = [row for row in found if not row["ok"]]
        worst = max(misses or found, key=badness)
        verdict = "exact" if not any(row["flattened"] for row in found) else "flattened" if all(row["flattened"] for row in found) else "in part"
        reasons = "; ".join(sorted({reason(row) for row in misses}))
        mean = f"{100 * worst['mean_difference']:.2g} %" if worst["mean_difference"] < 10 else "more than tenfold"
        cells = [node, len(found), len(misses), words(worst), mean, f"{abs(worst['relmse']):.1e}", verdict, reasons.replace("|", "/")[:300]]
        yield f"| {' | '.join(map(str, cells))} |"
    yield ""
    for node, why in report["not_shown"].items():
        yield f"- {node}: no rows ({why})."
    yield ""


def main():
    print(PAGE, end="")
    for path in sys.argv[1:]:
        with open(path, encoding="utf-8") as file:
            print("\n".join(table(json.load(file))))


if __name__ == "__main__":
    main()
