# SPDX-License-Identifier: GPL-3.0-or-later
"""The glTF document under construction, and the files beside it."""

import json
import os
from urllib.parse import quote

FLOAT, UNSIGNED_INT = 5126, 5125


class Document:
    """JSON parts of one scene. Buffers and images are files of their own, named by relative URIs."""

    def __init__(self, folder, generator):
        # Real paths: "../" must not lead through a symbolic link to somewhere else.
        self.folder = os.path.realpath(folder)
        self.root = {
            "asset": {"version": "2.0", "generator": generator},
            "scene": 0,
            "scenes": [{"nodes": []}],
        }
        self._shared = {}
        self._extensions = set()
        self._places = {}

    def add(self, table, item):
        """Appends to a table such as "meshes" and returns the item's index."""
        items = self.root.setdefault(table, [])
        items.append(item)
        return len(items) - 1

    def shared(self, table, item):
        """As `add`, but equal items are one."""
        key = (table, json.dumps(item, sort_keys=True))
        if key not in self._shared:
            self._shared[key] = self.add(table, item)
        return self._shared[key]

    def add_node(self, node):
        """Adds a node at the top of the scene."""
        index = self.add("nodes", node)
        self.root["scenes"][0]["nodes"].append(index)
        return index

    def uses(self, extension):
        """Notes an extension for `extensionsUsed`, and returns its name."""
        self._extensions.add(extension)
        return extension

    def uri(self, path):
        """A file's URI relative to the document."""
        place, name = os.path.split(path)
        if place not in self._places:
            self._places[place] = os.path.relpath(os.path.realpath(place), self.folder)
        # A file that is itself a symbolic link is read through it.
        relative = os.path.normpath(os.path.join(self._places[place], name))
        return quote(relative.replace(os.sep, "/"), safe="/~!$&'()*+,;=@")

    def add_buffer(self, path, layout):
        """Adds a file of accessors as `write_arrays` describes it; returns the accessors' indices."""
        buffer = self.add("buffers", {"uri": self.uri(path), "byteLength": layout["bytes"]})
        indices = []
        for accessor in layout["accessors"]:
            accessor = dict(accessor)
            offset, length = accessor.pop("offset"), accessor.pop("length")
            view = {"buffer": buffer, "byteOffset": offset, "byteLength": length}
            if accessor.pop("index", False):
                view["target"] = 34963
            accessor["bufferView"] = self.add("bufferViews", view)
            indices.append(self.add("accessors", accessor))
        return indices

    def write(self, path):
        """Writes the document beside its place and then renames it."""
        if self._extensions:
            self.root["extensionsUsed"] = sorted(self._extensions)
        write_whole(path, json.dumps(self.root, separators=(",", ":"), allow_nan=False).encode())


def write_whole(path, data):
    """Writes a file beside and renames it, so that a name never stands for half a file."""
    beside = f"{path}.{os.getpid()}.part"
    try:
        with open(beside, "wb") as file:
            for part in data if isinstance(data, (list, tuple)) else (data,):
                file.write(part)
        os.replace(beside, path)
    except BaseException:
        if os.path.exists(beside):
            os.remove(beside)
        raise


def describe_arrays(arrays):
    """Lays numpy arrays out behind one another: bytes to write, and the accessors' description.

    Each array is (values, kind, options): f32 or u32 of shape (count, width) or (count,). The
    option `bounds` adds minimum and maximum, `index` marks triangle corners.
    """
    parts, accessors, offset = [], [], 0
    for values, options in arrays:
        width = 1 if values.ndim == 1 else values.shape[1]
        accessor = {
            "offset": offset,
            "length": values.nbytes,
            "componentType": FLOAT if values.dtype.kind == "f" else UNSIGNED_INT,
            "count": len(values),
            "type": {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[width],
        }
        if "bounds" in options:
            accessor["min"] = [float(v) for v in values.min(axis=0)]
            accessor["max"] = [float(v) for v in values.max(axis=0)]
        if "index" in options:
            accessor["index"] = True
        accessors.append(accessor)
        parts.append(values.data if values.flags.c_contiguous else values.tobytes())
        offset += values.nbytes
    return parts, {"bytes": offset, "accessors": accessors}
