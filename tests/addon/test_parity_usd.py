# SPDX-License-Identifier: GPL-3.0-or-later
"""A part of the parity tiles by both exchanges that takes seconds: each is the same, or named (tests/addon/parity_usd.py)."""

import unittest

import bpy
import parity
import parity_tiles
import parity_usd


class ByUsd(unittest.TestCase):
    """What the exchange by USD says of tiles."""

    def setUp(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        parity.picture()

    def rows(self, *nodes):
        """Rows of the defaults of these kinds of nodes; of none of all that show values."""
        tiles = [tile for kind in nodes or parity_tiles.kinds() for tile in parity_tiles.tiles(kind)]
        tiles = [tile for tile in tiles if not tile.settings and not tile.inputs and tile.kind in {"sheet", "ball"}]
        return parity_usd.run(tiles, say=lambda *words, **settings: None)

    def test_defaults_of_all_nodes_are_the_same_or_named(self):
        rows = self.rows()
        self.assertEqual([row["words"] for row in rows if row["result"] == "unnamed"], [])
        same = {row["node"] for row in rows if row["result"] == "same"}
        self.assertLessEqual({"Math", "Mix", "Mapping", "Clamp", "CombineXYZ", "UVMap", "VectorMath"}, same)
        told = {row["node"]: row["told"] for row in rows if row["result"] == "named"}
        for node, words in (
            ("ValToRGB", "Color Ramp is a constant"), ("MixRGB", "is a constant"), ("TexNoise", "pattern is another"), ("RGBCurve", "curves are left out"),
            ("TexEnvironment", "flat image"), ("TexChecker", "third axis"), ("Tangent", "UV map"), ("VectorRotate", "turns otherwise"),
        ):  # fmt: skip
            self.assertIn(words, told.get(node, ""))

    def test_nodes_that_come_through_are_not_told(self):
        told = [row for row in self.rows("Math", "Clamp", "Mapping", "SeparateXYZ", "Invert", "UVMap") if row["told"]]
        self.assertEqual(told, [])


if __name__ == "__main__":
    unittest.main()
