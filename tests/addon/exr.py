# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads uncompressed OpenEXR files of scan lines: every channel, bit for bit."""

import struct

import numpy

_TYPES = {0: "<u4", 1: "<f2", 2: "<f4"}


def read(path):
    """Channels by name, each an array of rows from top to bottom."""
    with open(path, "rb") as file:
        data = file.read()
    magic, version = struct.unpack_from("<II", data)
    assert magic == 20000630 and version & 0x1A00 == 0, "not a single part of scan lines"
    attributes, at = _header(data, 8)
    assert attributes["compression"] == b"\0", "compressed"
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = list(_channels(attributes["channels"]))
    offsets = struct.unpack_from(f"<{height}Q", data, at)
    result = {name: numpy.empty((height, width), dtype) for name, dtype in channels}
    for offset in offsets:
        row = struct.unpack_from("<i", data, offset)[0] - y0
        place = offset + 8
        for name, dtype in channels:
            values = numpy.frombuffer(data, dtype, width, place)
            result[name][row] = values
            place += values.nbytes
    return result


def _header(data, at):
    attributes = {}
    while data[at]:
        end = data.index(b"\0", at)
        name = data[at:end].decode()
        end = data.index(b"\0", end + 1)
        (size,) = struct.unpack_from("<i", data, end + 1)
        attributes[name] = data[end + 5 : end + 5 + size]
        at = end + 5 + size
    return attributes, at + 1


def _channels(data):
    at = 0
    while data[at]:
        end = data.index(b"\0", at)
        yield data[at:end].decode(), numpy.dtype(_TYPES[struct.unpack_from("<i", data, end + 1)[0]])
        at = end + 17


def passes(channels):
    """Arrays of height × width × channels by the names of their passes (without the view layer's)."""
    found = {}
    for name, values in channels.items():
        path, _, channel = name.rpartition(".")
        found.setdefault(path, {})[channel] = values
    order = "RGBUVAXYZW"
    return {
        path: numpy.stack([parts[c] for c in sorted(parts, key=lambda c: order.index(c.upper()))], axis=-1) for path, parts in found.items()
    }
