# SPDX-License-Identifier: GPL-3.0-or-later
"""What became of each material, light, world, object and camera of a scene."""

import typing

EXACT, APPROXIMATED, LOST = "exact", "approximated", "lost"
_RANK = {EXACT: 0, APPROXIMATED: 1, LOST: 2}


class Finding(typing.NamedTuple):
    """What became of a part of a thing; `effect` is the id of the program's effect that it is about, if it is about one."""

    verdict: str
    detail: str
    effect: str | None = None


class Verdicts:
    """Collects verdicts, one for each thing; the worst of a thing's findings is its verdict."""

    def __init__(self):
        self._found = {}

    def add(self, kind, name, verdict=EXACT, detail="", effect=None):
        """`kind` is material, light, world, object or camera; `detail` says what is used instead; `effect` as in Finding."""
        entry = self._found.setdefault((kind, name), {"verdict": EXACT, "details": [], "effects": []})
        if _RANK[verdict] > _RANK[entry["verdict"]]:
            entry["verdict"] = verdict
        if detail and detail not in entry["details"]:
            entry["details"].append(detail)
        if effect and effect not in entry["effects"]:
            entry["effects"].append(effect)

    def extend(self, kind, name, findings, untouched=True):
        """Adds many findings of one thing, and the thing itself where there is none (unless told not to)."""
        if untouched:
            self.add(kind, name)
        for finding in findings:
            self.add(kind, name, *finding)

    def as_list(self):
        """Dictionaries with kind, name, verdict, detail and ids of effects, the worst first."""
        entries = [
            {"kind": kind, "name": name, "verdict": found["verdict"], "detail": "; ".join(found["details"]), "effects": found["effects"]}
            for (kind, name), found in self._found.items()
        ]
        return sorted(entries, key=lambda e: (-_RANK[e["verdict"]], e["kind"], e["name"]))
