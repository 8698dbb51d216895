# SPDX-License-Identifier: GPL-3.0-or-later
"""Strands: the hair of particle systems, hair curves and point clouds, as glTF's lines and points with a radius.

Keys, radii and what nodes ask of strands are those that Cycles makes of the same data.
"""

import hashlib
import json
import os

import numpy

from . import geometry, object_info

# What Hair Info and Point Info tell of strands and points that have attributes of their own here: one number each.
COMPUTED = {
    ("ShaderNodeHairInfo", "Intercept"): "@intercept",
    ("ShaderNodeHairInfo", "Length"): "@length",
    ("ShaderNodeHairInfo", "Random"): "@strand_random",
    ("ShaderNodePointInfo", "Random"): "@point_random",
}

# What Cycles takes for the radius of curves and points without one.
RADIUS = 0.005
POINT_RADIUS = 0.01

_SHAPES = {"RIBBONS": "ribbon", "THICK": "round", "THICK_LINEAR": "round-linear"}


def look(scene):
    """What curves look like, as SUNDOG_mesh has it."""
    settings = getattr(scene, "cycles_curves", None)
    shape = _SHAPES.get(getattr(settings, "shape", "RIBBONS"), "ribbon")
    return {"shape": shape, "steps": min(getattr(settings, "subdivisions", 2) + 1, 255)}


class Strands:
    """Curves of keys, or points: arrays in the object's space and in Blender's axes.

    `counts` has the keys of each curve; it is None for points. `slot` is the material's. `uvs(name)` and `named(name, width)`
    give an array of all keys, or None; `generated()` gives coordinates.
    """

    def __init__(self, slot, positions, radii, counts, first=0):
        self.slot, self.positions, self.radii, self.counts = slot, positions, radii, counts
        self._first = first
        self.uvs = lambda name: None
        self.named = lambda name, width: None
        self.generated = lambda: numpy.zeros_like(positions)

    def starts(self):
        """The first key of each curve."""
        return numpy.cumsum(self.counts) - self.counts

    def of_curves(self, values):
        """Values of curves for each of their keys."""
        return numpy.repeat(values, self.counts, axis=0)

    def indices(self):
        """Pairs of keys for each segment; of points one for each."""
        keys = numpy.arange(len(self.positions), dtype=numpy.uint32)
        if self.counts is None:
            return keys
        is_last = numpy.zeros(len(keys), bool)
        is_last[numpy.cumsum(self.counts) - 1] = True
        begins = keys[~is_last]
        return numpy.stack([begins, begins + numpy.uint32(1)], axis=1)

    def _along(self):
        """For each key: the way to it along its curve, and the length of the curve."""
        steps = numpy.zeros(len(self.positions), numpy.float32)
        steps[1:] = numpy.linalg.norm(numpy.diff(self.positions, axis=0), axis=1)
        starts = self.starts()
        steps[starts] = 0
        sums = numpy.cumsum(steps, dtype=float)
        way = sums - self.of_curves(sums[starts])
        return way, self.of_curves(way[starts + self.counts - 1])

    def _computed(self, name):
        if name == "@point_random":
            return hashed_pairs(numpy.arange(len(self.positions))) if self.counts is None else None
        if self.counts is None:
            return None
        if name == "@strand_random":
            return self.of_curves(hashed_pairs(numpy.arange(self._first, self._first + len(self.counts))))
        way, length = self._along()
        return length if name == "@length" else way / numpy.where(length > 0, length, 1)

    def arrays(self, demand):
        """The arrays of a primitive by glTF's names."""
        count = len(self.positions)
        arrays = {"POSITION": self.positions, "_RADIUS": self.radii.astype(numpy.float32)}
        if demand.generated:
            arrays["_GENERATED"] = self.generated().astype(numpy.float32)
        for number, name in enumerate(demand.uvs):
            uv = self.uvs(name)
            uv = numpy.zeros((count, 2), numpy.float32) if uv is None else uv
            arrays[f"TEXCOORD_{number}"] = numpy.stack([uv[:, 0], 1 - uv[:, 1]], axis=1).astype(numpy.float32)
        named = {f"_SUNDOG_{number}": attribute for number, attribute in enumerate(demand.attributes)}
        if demand.color is not None:
            named["COLOR_0"] = (demand.color, demand.color_width)
        for label, (name, width) in named.items():
            if name in COMPUTED.values():
                found = self._computed(name)
                found = None if found is None else numpy.repeat(found[:, None], 3, axis=1)
            else:
                found = self.named(name, width)
            if found is None:
                found = numpy.zeros((count, max(width, 3)), numpy.float32)
            arrays[label] = found.astype(numpy.float32)
        arrays["indices"] = self.indices().reshape(-1)
        return arrays


def hashed_pairs(numbers):
    """Cycles' number from 0 to 1 for each number together with zero: Bob Jenkins' lookup3, as object_info has it for one."""
    start = numpy.uint32((0xDEADBEEF + (2 << 2) + 13) % 0x100000000)
    with numpy.errstate(over="ignore"):
        words = [numbers.astype(numpy.uint32) + start, numpy.full(len(numbers), start), numpy.full(len(numbers), start)]
        object_info.finish(words)
    return words[2].astype(numpy.float32) * numpy.float32(1 / 0x100000000)


def store(parts, demands, cache):
    """Writes strands to the cache folder unless they are there, a primitive for each; None if there are none. `parts`: by slot.
    Raises geometry.GeometryError."""
    digest = hashlib.blake2b(digest_size=16)
    primitives = []
    for part in parts:
        named = part.arrays(demands[part.slot])
        digest.update(json.dumps([part.slot, part.counts is None, demands[part.slot].key()]).encode())
        for name, values in named.items():
            digest.update(name.encode())
            digest.update(numpy.ascontiguousarray(values).tobytes())
        primitives.append((part.slot, named))
    path = os.path.join(cache, f"mesh-{digest.hexdigest()}.bin")
    return geometry.stored(path, lambda: primitives)


# Hair of particles


def may_bend(shown, steps):
    """Whether an object's hair may bend while the shutter is open, of a mesh that moves by these steps or not."""
    return steps is not None or any(getattr(system, "use_hair_dynamics", False) for system in shown.particle_systems)


def systems_of(shown, is_final):
    """Particle systems of an evaluated object whose hair Cycles draws, with their modifiers."""
    for modifier in shown.modifiers:
        if modifier.type != "PARTICLE_SYSTEM" or not (modifier.show_render if is_final else modifier.show_viewport):
            continue
        system = modifier.particle_system
        if system is not None and system.settings.render_type == "PATH" and system.settings.type == "HAIR":
            yield modifier, system


def of_particles(shown, slots, is_final):
    """The Strands of an evaluated object's hair, one for each particle system. `slots`: how many materials it has."""
    found, first = [], 0
    inverse = numpy.array(shown.matrix_world.inverted_safe(), float)
    for modifier, system in systems_of(shown, is_final):
        numbers, keys = _drawn(system, is_final)
        if not len(numbers) or keys < 2:
            continue
        places = _places(shown, system, numbers, keys) @ inverse[:3, :3].T + inverse[:3, 3]
        places = places.astype(numpy.float32).reshape(len(numbers), keys, 3)
        steps = numpy.linalg.norm(numpy.diff(places, axis=1), axis=2)
        kept = steps.sum(axis=1) > 0
        numbers, places, steps = numbers[kept], places[kept], steps[kept]
        if not len(numbers):
            continue
        counts = numpy.full(len(numbers), keys)
        slot = min(max(system.settings.material - 1, 0), max(slots - 1, 0))
        strands = Strands(slot, places.reshape(-1, 3), _radii(system.settings, steps).reshape(-1), counts, first)
        first += len(numbers)
        _read_emitter(strands, shown, (modifier, system), numbers)
        found.append(strands)
    return found


def _drawn(system, is_final):
    """The numbers of the particles and children that are drawn, and the keys of each."""
    settings = system.settings
    total, children = len(system.particles), len(system.child_particles)
    if not is_final:
        children = int(children * settings.display_percentage / 100)
    first = total if settings.child_type != "NONE" and children else 0
    keys = (1 << (settings.render_step if is_final else settings.display_step)) + 1
    if settings.kink == "SPIRAL":
        keys += settings.kink_extra_steps
    return numpy.arange(first, total + children), keys


def _places(shown, system, numbers, keys):
    """World places of all keys."""
    flat, place, steps = [], system.co_hair, range(keys)
    for number in numbers.tolist():
        for step in steps:
            flat.extend(place(shown, particle_no=number, step=step))
    return numpy.array(flat, float).reshape(-1, 3)


def _radii(settings, steps):
    """Radius of each key by the lengths of the segments."""
    way = numpy.concatenate([numpy.zeros((len(steps), 1)), numpy.cumsum(steps, axis=1, dtype=float)], axis=1)
    rest = numpy.clip(1 - way / way[:, -1:], 0, 1)
    shape = settings.shape
    if shape != 0:
        rest = rest ** (1 + shape if shape < 0 else 1 / max(1 - shape, 1e-6))
    scale = 0.5 * settings.radius_scale
    root, tip = settings.root_radius * scale, settings.tip_radius * scale
    radii = rest * (root - tip) + tip
    if settings.use_close_tip:
        radii[:, -1] = 0
    return radii


def _read_emitter(strands, shown, drawn, numbers):
    """Lets strands read what their mesh has at their roots."""
    modifier, system = drawn
    mesh, particles = shown.data, system.particles
    last = len(particles) - 1

    def at_roots(read, width):
        values = [tuple(read(modifier, particle=particles[min(n, last)], particle_no=n)) for n in numbers.tolist()]
        return strands.of_curves(numpy.array(values, numpy.float32).reshape(-1, width))

    def uvs(name):
        layers = list(getattr(mesh, "uv_layers", ()))
        at = next((i for i, layer in enumerate(layers) if (layer.name == name if name else layer.active_render)), None)
        if at is None or last < 0:
            return None
        return at_roots(lambda *a, **k: system.uv_on_emitter(*a, **k, uv_no=at), 2)

    def named(name, width):
        colors = getattr(mesh, "color_attributes", None)
        if colors is None or last < 0:
            return None
        if not name:
            active = colors.render_color_index
            name = colors[active].name if 0 <= active < len(colors) else ""
        corners = [c.name for c in colors if c.data_type == "BYTE_COLOR" and c.domain == "CORNER"]
        if name not in corners:
            return None
        at = corners.index(name)
        read = at_roots(lambda *a, **k: system.mcol_on_emitter(*a, **k, vcol_no=at), 3)
        return _to_width(read, width)

    def generated():
        roots = strands.positions[strands.starts()]
        space = geometry.texture_space(mesh)
        return strands.of_curves(_in_space(roots, space))

    strands.uvs, strands.named, strands.generated = uvs, named, generated


def _in_space(places, space):
    """Places as coordinates of a texture space."""
    size = numpy.array([s if s != 0 else 1 for s in space["size"]], numpy.float32)
    return (places - numpy.array(space["location"], numpy.float32)) / (2 * size) + 0.5


def _to_width(values, width):
    """Numbers of an attribute as so many as are asked for: one stands three times."""
    components = values.shape[1]
    if width == 1:
        number = values[:, :1] if components < 3 else values[:, :3].mean(axis=1, keepdims=True)
        return numpy.repeat(number, 3, axis=1)
    if components == 1:
        values, components = numpy.repeat(values, 3, axis=1), 3
    missing = [numpy.zeros(len(values)), numpy.zeros(len(values)), numpy.zeros(len(values)), numpy.ones(len(values))]
    columns = [*values.T, *missing[components:]]
    return numpy.stack(columns[: max(width, 3)], axis=1)


# Curves and points


def of_curves(shown):
    """The Strands of an evaluated object of hair curves."""
    data = shown.data
    offsets = geometry.read(data.curve_offset_data, "value", numpy.int32)
    counts = numpy.diff(offsets)
    positions = geometry.read(data.points, "position", numpy.float32, 3)
    radii = _numbers(data, "radius")
    radii = numpy.full(len(positions), RADIUS, numpy.float32) if radii is None else radii
    # A curve of one key has no segment.
    kept = numpy.repeat(counts > 1, counts)
    positions, radii = positions[kept], radii[kept]
    if not len(positions):
        return []
    strands = Strands(0, positions, radii, counts[counts > 1])
    _read_attributes(strands, data, kept, counts > 1)
    return [strands]


def of_points(shown):
    """The Strands of an evaluated point cloud."""
    data = shown.data
    positions = geometry.read(data.points, "co", numpy.float32, 3)
    if not len(positions):
        return []
    radii = _numbers(data, "radius")
    radii = numpy.full(len(positions), POINT_RADIUS, numpy.float32) if radii is None else radii
    strands = Strands(0, positions, radii, None)
    _read_attributes(strands, data, numpy.ones(len(positions), bool), None)
    return [strands]


def _numbers(data, name):
    attribute = data.attributes.get(name)
    if attribute is None or attribute.data_type != "FLOAT":
        return None
    return geometry.read(attribute.data, "value", numpy.float32)


def _read_attributes(strands, data, kept, kept_curves):
    """Lets strands read attributes of their keys and curves."""

    def values_of(name):
        attribute = data.attributes.get(name)
        if attribute is None or attribute.data_type not in geometry.FIELDS:
            return None
        field, components = geometry.FIELDS[attribute.data_type]
        kind = {"INT": numpy.int32, "INT8": numpy.int32, "BOOLEAN": bool}.get(attribute.data_type, numpy.float32)
        values = geometry.read(attribute.data, field, kind, components).reshape(-1, components).astype(numpy.float32)
        if attribute.domain == "CURVE":
            return strands.of_curves(values[kept_curves])
        return values[kept] if attribute.domain == "POINT" else None

    def uvs(name):
        names = [name] if name else ["surface_uv_coordinate", *(a.name for a in data.attributes if a.data_type == "FLOAT2")]
        found = (values_of(n) for n in names)
        return next((values for values in found if values is not None and values.shape[1] == 2), None)

    def named(name, width):
        values = values_of(name) if name else None
        return None if values is None else _to_width(values, width)

    def generated():
        places = strands.positions
        low, high = places.min(axis=0), places.max(axis=0)
        space = {"location": (low + high) / 2, "size": (high - low) / 2}
        if strands.counts is None:
            return _in_space(places, space)
        return strands.of_curves(_in_space(places[strands.starts()], space))

    strands.uvs, strands.named, strands.generated = uvs, named, generated
