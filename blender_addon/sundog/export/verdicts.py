# SPDX-License-Identifier: GPL-3.0-or-later
"""What became of each material, light, world, object and camera of a scene."""

EXACT, APPROXIMATED, LOST = "exact", "approximated", "lost"
_RANK = {EXACT: 0, APPROXIMATED: 1, LOST: 2}


class Verdicts:
    """Collects verdicts, one for each thing; the worst of a thing's findings is its verdict."""

    def __init__(self):
        self._found = {}

    def add(self, kind, name, verdict=EXACT, detail=""):
        """`kind` is material, light, world, object or camera; `detail` says what is used instead."""
        entry = self._found.setdefault((kind, name), [EXACT, []])
        if _RANK[verdict] > _RANK[entry[0]]:
            entry[0] = verdict
        if detail and detail not in entry[1]:
            entry[1].append(detail)

    def extend(self, kind, name, findings, untouched=True):
        """Adds many (verdict, detail) of one thing, and the thing itself where there is none (unless told not to)."""
        if untouched:
            self.add(kind, name)
        for verdict, detail in findings:
            self.add(kind, name, verdict, detail)

    def as_list(self):
        """Dictionaries with kind, name, verdict and detail, the worst first."""
        entries = [
            {"kind": kind, "name": name, "verdict": verdict, "detail": "; ".join(details)}
            for (kind, name), (verdict, details) in self._found.items()
        ]
        return sorted(entries, key=lambda e: (-_RANK[e["verdict"]], e["kind"], e["name"]))
