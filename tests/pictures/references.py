# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures by Cycles of scenes that a test makes itself, kept in ~/.cache/sundog/references: they change only with what made them.

That is the test's program, the kit that it makes scenes with, and Blender's version; of the programs the syntax trees, so that comments may change.
"""

import ast
import functools
import hashlib
import os

import bpy
import numpy

HERE = os.path.dirname(os.path.abspath(__file__))
KIT = os.path.join(os.path.dirname(HERE), "addon", "export_kit.py")


# Parsing takes a tenth of a second, for each of hundreds of pictures.
@functools.cache
def _folder(program):
    state = hashlib.sha256(bpy.app.version_string.encode())
    for path in (program, KIT):
        with open(path, encoding="utf-8") as file:
            text = ast.dump(ast.parse(file.read())).encode()
        state.update(str(len(text)).encode() + b":" + text)
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    name = os.path.splitext(os.path.basename(program))[0]
    return os.path.join(cache, "sundog", "references", f"{name}-{state.hexdigest()[:24]}")


def kept(program, name, make):
    """The arrays by name that `make` returned for `name` when `program` was this one; made if they are not there yet."""
    folder = _folder(program)
    path = os.path.join(folder, hashlib.sha256(name.encode()).hexdigest()[:24] + ".npz")
    if os.path.exists(path):
        with numpy.load(path) as file:
            return dict(file)
    arrays = make()
    os.makedirs(folder, exist_ok=True)
    # Two runs at once each write their own.
    fresh = f"{path}.{os.getpid()}.npz"
    numpy.savez_compressed(fresh, **arrays)
    os.replace(fresh, path)
    return arrays
