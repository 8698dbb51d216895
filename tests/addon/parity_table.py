# SPDX-License-Identifier: GPL-3.0-or-later
"""The parity matrix as a page, and runs of some nodes put into a run of all.

    PYTHON tests/addon/parity_table.py VERSION.json [VERSION.json…] > docs/parity.md
    PYTHON tests/addon/parity_table.py --merge WHOLE.json PART.json [PART.json…] > NEW.json
"""

import json
import sys
from collections import Counter

# Why rows miss, by node, and where that is not enough by a part of the row's words: what no verdict of the add-on says.
REASONS = {
    ("TexSky", ""): "a table asked of Cycles, read between its texels; at places that are no directions, which the rows show, also the sun's disc",
    ("Bevel", "Radius high"): "Cycles' points lie otherwise: with its setting Tabulated Sobol in the place of Blue-Noise these rows agree (0.6 %)",
    ("BsdfPrincipled", "Coat"): "noise of the sun's highlight in a coat",
    ("BsdfPrincipled", "Subsurface"): "Cycles' walks lose light away from the origin; at it both agree within 0.1 %",
    ("BsdfHairPrincipled", "Aspect Ratio low"): "a ratio below 0",
    ("BsdfHairPrincipled", "IOR low"): "an index below 0",
    ("BsdfHairPrincipled", "Roughness low"): "a roughness below 0",
    ("BsdfHairPrincipled", "Offset high"): "an Offset of 2.3 radians",
    ("BsdfHairPrincipled", "Coat"): "Cycles draws the first reflection by the roughness of the others, and loses light of a Coat near 1",
    ("BsdfHairPrincipled", "Absorption Coefficient low"): "Cycles has values without bounds where nothing is absorbed",
    ("BsdfHairPrincipled", "Melanin low"): "Cycles has values without bounds where nothing is absorbed",
    ("SubsurfaceScattering", ""): "Cycles' walks lose light away from the origin; at it both agree within 0.4 %",
}

PAGE = """# Parity with Cycles, node by node

Made by `make parity` (tests/addon/parity.py) and tests/addon/parity_table.py. Rows are made by introspection: of every kind of
shader node every choice of its menus, every socket at a low, middle and high value and textured, every output; pairs of
menus; pairs of the Principled BSDF's sockets. Sundog renders what the add-on exports, Cycles is that of the same Blender.

Bars: the mean within 1 %, relMSE below 1e-3, of textures below 1e-5. Values are shown by an emission, at points known to the
bit; nodes that look at the place on balls; shaders on balls (of hair: on strands) below a grey world and a sun, with the noise cancelled
(the product of the differences of two independent pairs of pictures). Rows that miss are looked at with more samples.
What the add-on flattens counts as a miss; what it tells of trees that are evaluated does not, and stands as "told".

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


def merged(whole, parts):
    """A run of all nodes in which the rows of some kinds are those of later runs. Each row keeps who made it."""
    kinds = {}
    for report in (whole, *parts):
        if report["blender"] != whole["blender"]:
            raise SystemExit(f"runs of Blender {whole['blender']} and of {report['blender']} are no run")
        if not report.get("whole_kinds", report is whole):
            raise SystemExit("a run of the defaults alone takes no others' place")
        made_by = report.get("made_by", "unknown")
        found = {}
        for row in report["rows"]:
            found.setdefault(row["node"], []).append({"made_by": made_by, **row})
        kinds.update(found)
    skipped = {kind: why for report in (whole, *parts) for kind, why in report["not_shown"].items()}
    rows = [row for kind in sorted(kinds) if kind not in skipped for row in kinds[kind]]
    return {"blender": whole["blender"], "made_by": "several", "whole_kinds": True, "not_shown": skipped, "rows": rows}


def makers(report):
    """Who made how many rows, in words."""
    found = Counter(row.get("made_by", report.get("made_by", "unknown")) for row in report["rows"])
    return "; ".join(f"{count} by {who}" for who, count in found.most_common())


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
    yield f"Rows: {makers(report)}."
    yield ""
    yield "| node | rows | miss | worst row | mean differs by | relMSE | verdict | reason |"
    yield "| --- | --- | --- | --- | --- | --- | --- | --- |"
    for node, found in by_node.items():
        misses = [row for row in found if not row["ok"]]
        worst = max(misses or found, key=badness)
        verdict = "exact" if not any(row["flattened"] for row in found) else "flattened" if all(row["flattened"] for row in found) else "in part"
        told = {f"told: {row['told']}" for row in found if row.get("told")}
        reasons = "; ".join(sorted({reason(row) for row in misses} | told))
        mean = f"{100 * worst['mean_difference']:.2g} %" if worst["mean_difference"] < 10 else "more than tenfold"
        cells = [node, len(found), len(misses), words(worst), mean, f"{abs(worst['relmse']):.1e}", verdict, reasons.replace("|", "/")[:300]]
        yield f"| {' | '.join(map(str, cells))} |"
    yield ""
    for node, why in report["not_shown"].items():
        yield f"- {node}: no rows ({why})."
    yield ""


def read(path):
    """A run's report."""
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def main():
    if sys.argv[1:2] == ["--merge"]:
        whole, *parts = map(read, sys.argv[2:])
        report = merged(whole, parts)
        rows = ",\n".join(json.dumps(row) for row in report.pop("rows"))
        print(json.dumps(report)[:-1] + f',\n"rows": [\n{rows}\n]}}')
        return
    print(PAGE, end="")
    for path in sys.argv[1:]:
        print("\n".join(table(read(path))))


if __name__ == "__main__":
    main()
