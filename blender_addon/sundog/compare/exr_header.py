# SPDX-License-Identifier: GPL-3.0-or-later
"""The text attributes of an EXR file's header: what Cycles says there of its render.

Format: https://openexr.com/en/latest/OpenEXRFileLayout.html (magic number, version, then attributes of name, type, size and
value until an empty name).
"""

import struct

MAGIC = b"\x76\x2f\x31\x01"
# No header of Blender's is larger; a broken file is not read further.
_MOST = 1 << 20


def text_attributes(path):
    """name -> text, of the first header. Raises ValueError where the file is no EXR."""
    with open(path, "rb") as file:
        data = file.read(_MOST)
    if data[:4] != MAGIC:
        raise ValueError(f"{path} is no EXR file")
    found, at = {}, 8
    try:
        while data[at]:
            name, at = _word(data, at)
            kind, at = _word(data, at)
            (size,) = struct.unpack_from("<i", data, at)
            at += 4
            if kind == "string":
                found[name] = data[at : at + size].decode("utf-8", "replace")
            at += max(size, 0)
    except (IndexError, struct.error, ValueError) as error:
        raise ValueError(f"the header of {path} is broken") from error
    return found


def _word(data, at):
    end = data.index(0, at)
    return data[at:end].decode("utf-8", "replace"), end + 1


def seconds(text):
    """Cycles' [days:][hours:]minutes:seconds.hundredths."""
    result = 0.0
    for part, factor in zip(reversed(text.split(":")), (1, 60, 3600, 86400)):
        result += float(part) * factor
    return result
