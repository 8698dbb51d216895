# SPDX-License-Identifier: GPL-3.0-or-later
"""What the last render (or scene check) found and took: for the panel, the console and other programs."""

import copy
import json

from . import denoise

_RANK = {"lost": 0, "approximated": 1, "exact": 2}

# What verdicts of some kinds are counted as.
_NOUNS = {"program": "feature"}
# By view layer, what was said last.
_told = {}
# One dictionary for each view layer of the last frame.
_layers = []
_printed = None


def begin(scene, layer):
    """A new record. View layers of one frame stay together."""
    global _layers
    record = _new(scene, layer)
    last = _layers[-1] if _layers else None
    together = last and all(last[key] == record[key] for key in ("scene", "frame"))
    known = {earlier["layer"] for earlier in _layers}
    _layers = [*_layers, record] if together and record["layer"] not in known else [record]
    return record


def begin_alone(scene, layer):
    """A new record that takes the place of all others."""
    global _layers
    record = _new(scene, layer)
    _layers = [record]
    return record


def _new(scene, layer):
    return {
        "scene": scene.name,
        "frame": scene.frame_current + scene.frame_subframe,
        "layer": layer.name,
        "verdicts": [],
        "diagnostics": [],
        "called_for": [],
        "warnings": [],
        "export": {},
        "prepared": None,
        "settings": {},
        "statistics": {},
        "denoised": None,
    }


def fail(message):
    """Why the render that was begun last has failed."""
    if _layers:
        _layers[-1]["error"] = message


def last_verdicts():
    """Verdicts of all view layers, the worst first, each once; what the program itself could not carry over has the kind
    "program"."""
    found, seen = [], set()
    for record in _layers:
        for verdict in verdicts_of(record):
            key = tuple(verdict[k] for k in ("kind", "name", "verdict", "detail"))
            if key not in seen:
                seen.add(key)
                found.append(dict(verdict))
    return sorted(found, key=lambda v: (_RANK.get(v["verdict"], 0), v["kind"], v["name"]))


def _is_told(diagnostic, verdicts):
    """Whether the export has already said of each material what the program says of all: that it does not render an effect."""
    effect = diagnostic.get("effect")
    return effect is not None and any(v["kind"] == "material" and effect in v.get("effects", ()) for v in verdicts)


def verdicts_of(record):
    """Those of one view layer, the program's own included."""
    own = record["verdicts"]
    return [*own, *(_of_program(d) for d in record["diagnostics"] if not _is_told(d, own))]


def _of_program(diagnostic):
    objects = diagnostic.get("objects") or []
    effect = diagnostic.get("effect")
    shown = ", ".join(map(str, objects[:5])) + (f" and {len(objects) - 5} more" if len(objects) > 5 else "")
    return {
        "kind": "program",
        "name": str(diagnostic.get("feature", "")),
        "verdict": str(diagnostic.get("verdict", "lost")),
        "detail": f"{diagnostic.get('instead', '')}{f' ({shown})' if shown else ''}",
        "effects": [effect] if effect else [],
    }


def last_statistics():
    """The record of the last view layer; `layers` has those of all."""
    if not _layers:
        return {}
    layers = copy.deepcopy(_layers)
    return {**layers[-1], "layers": layers}


def as_json(_owner=None):
    """All of it as text."""
    return json.dumps({"verdicts": last_verdicts(), "statistics": last_statistics()}, default=str)


def finish(record, animation):
    """Prints a record, the worst first; in an animation only where the verdicts differ from the frame's before."""
    global _printed
    words = summary(record)
    lines = list(verdict_lines(last_verdicts() if len(_layers) == 1 else record["verdicts"]))
    if animation and lines == _printed:
        lines = []
    else:
        _printed = lines
    print("\n".join([f"Sundog: {words}", *(f"    {line}" for line in lines)]), flush=True)


def summary(record):
    """What was rendered and what it took, in one line."""
    statistics = record["statistics"]
    words = [f"{record['scene']}, {record['layer']}, frame {record['frame']:g}"]
    if record["export"]:
        words.append(f"exported in {record['export'].get('total', 0):.2f} s")
    if record["prepared"] is not None:
        words.append(f"prepared in {record['prepared']:.2f} s")
    if "trace" in statistics:
        trace = statistics["trace"]
        words.append(f"{statistics.get('samples', '?')} samples in {trace['secs'] + trace['nanos'] * 1e-9:.2f} s")
    shift = denoise.words(record["denoised"])
    if shift:
        words.append(f"denoised: {shift}")
    error = denoise.error_words(record["denoised"])
    if error:
        words.append(error)
    if "stopped" in record:
        words.append("stopped by the user")
    return ", ".join(words)


def findings():
    """Effects of the last view layer, each with what calls for it or why nothing does; empty where nothing was looked at."""
    return _layers[-1]["called_for"] if _layers else []


def listed(names, most=5, unnamed=0):
    """Names for a line of text; `unnamed` have none."""
    more = max(len(names) - most, 0) + unnamed
    return ", ".join(names[:most]) + (f" and {more} more" if more else "")


def loss(verdicts):
    """How many things of each kind are not exact: "1 object lost, 2 materials and 1 light approximated"; "" where all are."""
    parts = []
    for verdict in ("lost", "approximated"):
        found = {}
        for kind, name in sorted({(v["kind"], v["name"]) for v in verdicts if v["verdict"] == verdict}):
            found.setdefault(_NOUNS.get(kind, kind), []).append(name)
        words = [f"{len(names)} {noun}{'s' if len(names) > 1 else ''}" for noun, names in found.items()]
        if words:
            parts.append(" and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words) + f" {verdict}")
    return ", ".join(parts)


def told(record, animation):
    """The sentence on what was lost of a view layer, to be reported; "" if there is none, or it was the same in the frame
    before of an animation."""
    layer = (record["scene"], record["layer"])
    sentence = loss(verdicts_of(record))
    again = animation and _told.get(layer) == sentence
    _told[layer] = sentence
    return "" if again else sentence


def groups(verdicts):
    """What is not exact or is to be told nevertheless, the worst first: (verdict, kind, detail, names of those that it befell)."""
    found = {}
    for verdict in verdicts:
        if verdict["verdict"] != "exact" or verdict["detail"]:
            found.setdefault((verdict["verdict"], verdict["kind"], verdict["detail"]), []).append(verdict["name"])
    ordered = sorted(found.items(), key=lambda item: (_RANK.get(item[0][0], 0), item[0][1:]))
    return [(*key, names) for key, names in ordered]


def verdict_lines(verdicts):
    """The groups as lines of text."""
    for verdict, kind, detail, names in groups(verdicts):
        yield f"{verdict}: {kind} {listed(names)}: {detail}"
