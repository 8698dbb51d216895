# SPDX-License-Identifier: GPL-3.0-or-later
"""Where exported meshes and images are kept, and how the folder stays small."""

import os
import time
from urllib.parse import unquote

import bpy

# What another Blender may be about to read is not removed.
YOUNG = 3600.0


def default_folder():
    """The user's folder for it: the extension's own where this is one, else the system's cache folder."""
    try:
        return bpy.utils.extension_path_user(__package__, path="cache")
    except ValueError:
        base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
        return os.path.join(base, "sundog", "blender")


def used_by(path, document):
    """The files that a .gltf at a path names, absolute."""
    names = [item.get("uri", "") for table in ("buffers", "images") for item in document.get(table, ())]
    for scene in document.get("scenes", ()):
        world = scene.get("extensions", {}).get("SUNDOG_scene", {}).get("world", {})
        names.append(world.get("image", ""))
    folder = os.path.realpath(os.path.dirname(path))
    return {os.path.normpath(os.path.join(folder, unquote(name))) for name in names if name and not name.startswith("data:")}


def mark_used(paths, folder):
    """Notes that files of the cache are in use now."""
    inside = os.path.realpath(folder) + os.sep
    for path in paths:
        if path.startswith(inside):
            try:
                os.utime(path)
            except OSError:
                pass


def tidy(folder, limit, keep=(), now=None):
    """Removes the files that were not used for longest until at most `limit` bytes are there; returns how many went."""
    now = time.time() if now is None else now
    files = []
    for entry in os.scandir(folder):
        if entry.is_file(follow_symlinks=False):
            status = entry.stat(follow_symlinks=False)
            files.append((status.st_mtime, status.st_size, entry.path))
    total = sum(size for _, size, _ in files)
    removed = 0
    for used, size, path in sorted(files):
        if total <= limit or now - used < YOUNG:
            break
        if os.path.realpath(path) in keep:
            continue
        try:
            os.remove(path)
        except OSError:
            continue
        total -= size
        removed += 1
    return removed
