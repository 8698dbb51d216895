# SPDX-License-Identifier: GPL-3.0-or-later
"""Grids of what fills objects: OpenVDB files of volumes, and arrays of simulated smoke; and the boxes that hold them."""

import hashlib
import os

import bpy
import numpy

from . import geometry, gltf
from .verdicts import APPROXIMATED, LOST

# Arrays of a domain of smoke, by the names that Cycles has for them; of some the resolution is always the low one.
OF_SMOKE = {"density": 1, "color": 4, "flame": 1, "heat": 1, "temperature": 1, "velocity": 3}
LOW = {"heat", "velocity"}
# Points beyond the set ones in which cubic interpolation still finds something.
MARGIN = 2
# Of a box, outwards by the order of their corners.
SIDES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
# The same for the eye: words for what has no meaning here.
STEPS = "its step size has no meaning here: nothing is marched"


class Filled:
    """The grids of an object: `names`; `box` around them in the object's space; whether densities hold in that space; `space` of
    generated coordinates; `described(document, numbers)` for SUNDOG_mesh."""

    def __init__(self, name, names, box, by_object, space, entries):
        self.name, self.names, self.box, self.by_object, self.space, self.entries = name, names, box, by_object, space, entries

    def described(self, document, numbers):
        """What SUNDOG_mesh has of those grids that node trees read, by the trees' numbers."""
        found = []
        for name, make in self.entries.items():
            if name in numbers:
                found.append({"number": numbers.index(name), "name": name, **make(document)})
        return {"grids": found, **({"density_by_object": True} if self.by_object else {})}


def domain_of(shown):
    """The settings of an object that is a domain of smoke, or None."""
    for modifier in shown.modifiers:
        if modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN" and modifier.show_render:
            settings = modifier.domain_settings
            if settings is not None and settings.domain_type == "GAS":
                return settings
    return None


def of_volume(shown, cache, findings):
    """The Filled of an evaluated Volume object; None, with a finding, if there is nothing to render."""
    data = shown.data
    grids = data.grids
    if not grids.load():
        findings.append((LOST, f"it is left out: {grids.error_message or 'its file cannot be read'}"))
        return None
    if not len(grids):
        return None
    if data.render.step_size > 0:
        findings.append((APPROXIMATED, STEPS))
    path = _file(shown, grids, cache)
    if path is None:
        findings.append((LOST, "it is left out: its grids cannot be saved"))
        return None
    corners = numpy.array([tuple(c) for c in shown.bound_box], float)
    low, high = corners.min(0), corners.max(0)
    # What generated coordinates are relative to.
    middle, half = (low + high) / 2, (high - low) / 2
    margin = numpy.zeros(3)
    for grid in grids:
        margin = numpy.maximum(margin, numpy.abs(numpy.array(grid.matrix_object, float)[:3, :3]).sum(1))
    box = (low - MARGIN * margin, high + MARGIN * margin)
    space = {"location": middle.tolist(), "size": half.tolist()}
    names = [grid.name for grid in grids]
    entries = {name: lambda document: {"uri": document.uri(path)} for name in names}
    return Filled(data.name, names, box, data.render.space == "OBJECT", space, entries)


def _file(shown, grids, cache):
    """The file that holds the grids of a volume: its own, or one that is written where modifiers have changed them."""
    own = grids.frame_filepath
    if own and os.path.isfile(own) and not shown.modifiers and shown.original.type == "VOLUME" and not _is_made(shown.data):
        return own
    path = os.path.join(cache, f"volume-{os.getpid()}.vdb")
    try:
        if not grids.save(filepath=path):
            return None
        with open(path, "rb") as file:
            digest = hashlib.file_digest(file, "blake2b").hexdigest()[:32]
        kept = os.path.join(cache, f"volume-{digest}.vdb")
        os.replace(path, kept)
    except (OSError, RuntimeError):
        return None
    return kept


def _is_made(data):
    return bool(getattr(data, "is_runtime_data", False)) and not data.filepath


def of_domain(shown, settings, mesh, scene, cache):
    """The Filled of a domain of smoke at the frame; None where nothing is simulated."""
    if not settings.cache_frame_start <= scene.frame_current <= settings.cache_frame_end:
        return None
    resolution = numpy.array(settings.domain_resolution, int)
    space = geometry.texture_space(mesh)
    middle, half = (numpy.array(space[k], float) for k in ("location", "size"))
    entries = {}
    for name, channels in OF_SMOKE.items():
        times = settings.noise_scale if settings.use_noise and name not in LOW else 1
        size = resolution * times
        values = getattr(settings, f"{name}_grid")
        if len(values) != size.prod() * channels or not len(values):
            continue
        entries[name] = _array(values, size, middle, half, cache)
    if not entries:
        return None
    margin = MARGIN * 2 * half / numpy.maximum(resolution, 1)
    box = (middle - half - margin, middle + half + margin)
    return Filled(shown.name, list(entries), box, False, space, entries)


def _array(values, size, middle, half, cache):
    def make(document):
        array = numpy.empty(len(values), numpy.float32)
        values.foreach_get(array)
        path = os.path.join(cache, f"grid-{hashlib.blake2b(array.tobytes(), digest_size=16).hexdigest()}.bin")
        parts, layout = gltf.describe_arrays([(array, ())])
        if not os.path.isfile(path) or os.path.getsize(path) != layout["bytes"]:
            gltf.write_whole(path, parts)
        (accessor,) = document.add_buffer(path, layout)
        # Its numbers stand in the middle of cells.
        step = 2 * half / size
        matrix = numpy.column_stack([numpy.diag(step), middle - half + 0.5 * step])
        return {"accessor": accessor, "size": size.tolist(), "matrix": matrix.reshape(-1).tolist()}

    return make


def box_mesh(filled):
    """A new mesh: the box that holds the grids, in Blender's data; to be removed again."""
    low, high = filled.box
    corners = [[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)]
    mesh = bpy.data.meshes.new(f"{filled.name} (box)")
    mesh.from_pydata(corners, [], SIDES)
    return mesh
