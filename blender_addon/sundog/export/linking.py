# SPDX-License-Identifier: GPL-3.0-or-later
"""Light and shadow linking, as Blender evaluates it: objects that the same collections name in the same way are one set."""

from .verdicts import LOST

# The program's, of which Cycles has 64 for both.
MOST = {"receiver": 64, "blocker": 24}

_NAMES = {"receiver": "lit_sets", "blocker": "shadow_sets"}


def _members(collection):
    """(object, whether it is included) of all objects of a linking collection; those of a child are as that is."""
    for member, link in zip(collection.objects, collection.collection_objects):
        yield member, link.light_linking.link_state == "INCLUDE"
    for child, link in zip(collection.children, collection.collection_children):
        for member in child.all_objects:
            yield member, link.light_linking.link_state == "INCLUDE"


class Linking:
    """The links of a scene's objects."""

    def __init__(self, objects):
        self._collections = {kind: {} for kind in MOST}
        # By kind and object: the collections that include it, and those that exclude it.
        told = {kind: {} for kind in MOST}
        for thing in objects:
            settings = getattr(thing, "light_linking", None)
            for kind in MOST:
                collection = getattr(settings, f"{kind}_collection", None)
                if collection is None:
                    continue
                known = self._collections[kind]
                known[thing.name_full] = collection.name_full
                for member, included in _members(collection):
                    pair = told[kind].setdefault(member.name_full, (set(), set()))
                    pair[0 if included else 1].add(collection.name_full)
        self._sets = {kind: [(frozenset(), frozenset())] for kind in MOST}
        self._set_of = {kind: {} for kind in MOST}
        self.findings = {}
        for kind, things in told.items():
            for name, pair in things.items():
                self._set_of[kind][name] = self._number(kind, name, tuple(map(frozenset, pair)))

    def _number(self, kind, name, pair):
        sets = self._sets[kind]
        if pair in sets:
            return sets.index(pair)
        if len(sets) == MOST[kind]:
            words = f"it is in no set of {kind}s for its lights' linking: there are {MOST[kind]} already"
            self.findings.setdefault(name, []).append((LOST, words))
            return 0
        sets.append(pair)
        return len(sets) - 1

    def shining(self, thing):
        """What a lamp or an object that shines says of the objects that it lights and that shade it."""
        result = {}
        for kind, name in _NAMES.items():
            collection = self._collections[kind].get(thing.name_full)
            if collection is None:
                continue
            sets = list(enumerate(self._sets[kind]))
            included = [n for n, pair in sets if collection in pair[0]] or [n for n, _ in sets]
            kept = [n for n in included if collection not in sets[n][1][1]]
            if len(kept) < len(sets):
                result[name] = kept
        return result

    def lit(self, shown, instancer):
        """What an object says of the sets that it is in. As in Cycles an instancer that is in one stands for what it places."""
        names = [thing.name_full for thing in (instancer, shown) if thing is not None]
        numbers = {}
        for kind, known in self._set_of.items():
            number = next((known[name] for name in names if known.get(name)), 0)
            if number:
                numbers[f"{kind}_set"] = number
        return numbers
