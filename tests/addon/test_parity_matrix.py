# SPDX-License-Identifier: GPL-3.0-or-later
"""A part of the parity matrix that takes seconds: the defaults of each node of values, all menus of some
textures, and normals."""

import unittest

import bpy
import numpy
import parity
import parity_random
import parity_table
import parity_tiles

# Known to miss; docs/parity.md has the reasons.
MISS = {"TexSky"}


class Matrix(unittest.TestCase):
    """What the matrix says of it."""

    def setUp(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        parity.picture()

    def test_every_kind_of_node_has_rows_or_a_reason(self):
        rows = {kind: len(parity_tiles.tiles(kind)) for kind in parity_tiles.kinds()}
        self.assertGreater(len(rows), 90)
        self.assertGreater(sum(rows.values()), 5000)
        self.assertEqual([k for k, count in rows.items() if not count and k not in parity_tiles.NOT_SHOWN], [])
        self.assertGreater(rows["TexVoronoi"], 500)
        # Every blend mode in colours, and every pair of Principled's sockets.
        self.assertGreater(rows["Mix"], 100)
        self.assertGreater(rows["BsdfPrincipled"], 300)

    def test_later_runs_take_the_place_of_whole_kinds(self):
        def run(who, values):
            rows = [{"node": node, "settings": {}, "inputs": {}, "output": "o", "ok": True, "flattened": "", "mean_difference": 0.0, "relmse": value, "bar": 1} for node, value in values]
            return {"blender": "5.2.3", "made_by": who, "whole_kinds": True, "not_shown": {"Group": "why"}, "rows": rows}

        whole, part = run("first", [("Math", 1.0), ("Math", 2.0), ("Mix", 3.0)]), run("second", [("Math", 4.0)])
        both = parity_table.merged(whole, [part])
        self.assertEqual([(r["node"], r["relmse"], r["made_by"]) for r in both["rows"]], [("Math", 4.0, "second"), ("Mix", 3.0, "first")])
        again = parity_table.merged(both, [run("third", [("Mix", 5.0)])])
        self.assertEqual([r["made_by"] for r in again["rows"]], ["second", "third"])
        self.assertIn("1 by second", parity_table.makers(again))
        self.assertIn("3 by first", parity_table.makers(whole))
        self.assertIn("Rows: ", "\n".join(parity_table.table(again)))
        for other in ({**part, "blender": "4.5.15"}, {**part, "whole_kinds": False}):
            with self.assertRaises(SystemExit):
                parity_table.merged(whole, [other])

    def test_values_are_those_of_cycles(self):
        tiles = [tile for kind in parity_tiles.kinds() for tile in parity_tiles.tiles(kind)]
        menus = {"TexVoronoi", "TexNoise", "TexMagic", "Math", "MixRGB", "TexGabor"}
        wanted = [t for t in tiles if t.kind == "sheet" and not t.inputs and t.node not in MISS and (not t.settings or t.node in menus)]
        self.agree(wanted, 300)

    def test_values_of_the_place_are_those_of_cycles(self):
        of_the_place = {"Bump", "NormalMap", "TexCoord"}
        tiles = [tile for kind in of_the_place & set(parity_tiles.kinds()) for tile in parity_tiles.tiles(kind)]
        self.agree([tile for tile in tiles if tile.kind == "ball" and not tile.inputs], 15)

    def test_random_trees_of_values_are_those_of_cycles(self):
        # Of these none runs into what is not defined: 0 divided by 0, noise of what is no number.
        rows = list(parity_random.run("sheet", 261, 120, 1))
        self.assertEqual([(number, tree) for number, row, _, misses, tree, _ in rows if misses or row["flattened"] or row["told"]], [])
        self.assertGreater(numpy.mean([numpy.ptp(ours) > 0.1 for *_, (ours, _) in rows]), 0.7)

    def agree(self, wanted, at_least):
        """All these rows agree with Cycles."""
        rows, _ = parity.run(wanted, say=lambda *words, **settings: None)
        # What is flattened is a matter of the nodes that are evaluated, not of their values.
        wrong = [row for row in rows if not row["ok"] and not row["flattened"]]
        told = [f"{r['node']} {parity_table.words(r)}: mean {r['mean']:.5f} against {r['cycles']:.5f}, relMSE {r['relmse']:.1e}" for r in wrong]
        self.assertFalse(told, "\n" + "\n".join(told))
        self.assertGreater(len(rows), at_least)


if __name__ == "__main__":
    unittest.main()
