# SPDX-License-Identifier: GPL-3.0-or-later
"""As much of JSON Schema 2020-12 as docs/gltf-extensions.schema.json uses; a word that it does not know is an error."""

import json
import os

FILE = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "docs", "gltf-extensions.schema.json")
TELLING = {"$schema", "$id", "$defs", "title", "description"}
TYPES = {"object": dict, "array": list, "string": str, "boolean": bool}


def schema():
    """The schema of Sundog's extensions."""
    with open(FILE, encoding="utf-8") as file:
        return json.load(file)


def _is_type(value, name):
    if name in {"number", "integer"}:
        whole = isinstance(value, int) or (isinstance(value, float) and value.is_integer())
        return isinstance(value, (int, float)) and not isinstance(value, bool) and (name == "number" or whole)
    return isinstance(value, TYPES[name])


def errors(value, rule, root=None, place="$"):
    """What is wrong with a value, each with its place."""
    root = rule if root is None else root
    for word, said in rule.items():
        if word in TELLING:
            continue
        if word == "$ref":
            target = root
            for part in said.removeprefix("#/").split("/"):
                target = target[part]
            yield from errors(value, target, root, place)
        elif word == "type":
            if not _is_type(value, said):
                yield f"{place}: {value!r} is no {said}"
                return
        elif word == "properties":
            for name, inner in said.items():
                if isinstance(value, dict) and name in value:
                    yield from errors(value[name], inner, root, f"{place}.{name}")
        elif word == "additionalProperties" and said is False:
            for name in set(value) - set(rule["properties"]):
                yield f"{place}: {name} is not known"
        elif word == "additionalProperties":
            for name in set(value) - set(rule.get("properties", ())):
                yield from errors(value[name], said, root, f"{place}.{name}")
        elif word == "anyOf":
            found = [list(errors(value, one, root, place)) for one in said]
            if all(found):
                yield f"{place}: {value!r} is nothing of what it may be"
        elif word == "required":
            for name in said:
                if name not in value:
                    yield f"{place}: {name} is missing"
        elif word == "items":
            for index, item in enumerate(value):
                yield from errors(item, said, root, f"{place}[{index}]")
        else:
            yield from _simple(word, said, value, place)


def _simple(word, said, value, place):
    fine = {
        "const": lambda: value == said,
        "enum": lambda: value in said,
        "minimum": lambda: value >= said,
        "maximum": lambda: value <= said,
        "exclusiveMinimum": lambda: value > said,
        "minItems": lambda: len(value) >= said,
        "maxItems": lambda: len(value) <= said,
    }
    if word not in fine:
        raise ValueError(f"the schema's word {word} is not checked: teach it to {__file__}")
    if not fine[word]():
        yield f"{place}: {value!r} is against {word} {said!r}"
