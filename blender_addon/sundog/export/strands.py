# SPDX-License-Identifier: GPL-3.0-or-later
"""Strands: the hair of particle systems, hair curves and point clouds, as glTF's lines and points with a radius.

Keys, radii and what nodes ask of strands are those that Cycles makes of the same data.
"""

import functools
import hashlib
import itertools
import json
import os

import bpy
import numpy

from . import geometry, images, object_info

# What Hair Info and Point Info tell of strands and points that have attributes of their own here: one number each.
COMPUTED = {
    ("ShaderNodeHairInfo", "Intercept"): "@intercept",
    ("ShaderNodeHairInfo", "Length"): "@length",
    ("ShaderNodeHairInfo", "Random"): "@strand_random",
    ("ShaderNodePointInfo", "Random"): "@point_random",
}

# What Cycles takes for the radius of curves and points without one, metres.
RADIUS = 0.005
POINT_RADIUS = 0.01

# How far some key must be elsewhere before Cycles takes strands for moving: they go through world space and back.
MOVES_FROM = 1e-5

# The attribute with the radius of each key.
RADII = "_RADIUS"

# Whether Cycles draws curves of the type Poly with straight segments whatever the scene's shape.
HAS_POLY = bpy.app.version >= (5, 0, 0)
# Whether Cycles takes normals of particles' hair for upward. It has none, and none has become that since they are packed.
HAS_UPWARD_NORMALS = bpy.app.version >= (5, 1, 0)
_SHAPES = {"RIBBONS": "ribbon", "THICK": "round", "THICK_LINEAR": "round-linear"}
_POLY = 1


def look(scene):
    """What curves look like, as `strands` of SUNDOG_mesh has it."""
    settings = getattr(scene, "cycles_curves", None)
    shape = _SHAPES.get(getattr(settings, "shape", "RIBBONS"), "ribbon")
    if shape != "ribbon":
        return {"shape": shape, "radius": RADII}
    # By how far Cycles' pictures of bent ribbons are from Sundog's (5.2.3, 4.2.23): 2, 3, 5, 9 and 17 pieces.
    return {"shape": shape, "radius": RADII, "steps": min(1 << getattr(settings, "subdivisions", 2), 16) + 1}


class Strands:
    """Curves of keys, or points, in the object's space and in Blender's axes.

    `positions` (keys × 3) and `radii` (keys), metres. `counts` has the keys of each curve; it is None for points. `numbers` are
    those that Cycles knows the curves by. `slot` is the material's. `uvs(name)` and `named(name, width)` give rows for all keys,
    or None where there is nothing of that name; `velocity()` metres a second, `normals()` those of curves (keys × 3). `roots` has the texture space of the generated coordinates that each curve has
    from its first key; None where they are places in the object's space. `look` stands for the scene's, where it is not None.
    """

    def __init__(self, slot, positions, radii, counts, numbers=None):
        self.slot, self.positions, self.radii, self.counts = slot, positions, radii.astype(numpy.float32), counts
        self.numbers = numbers
        if numbers is None:
            self.numbers = numpy.arange(len(positions) if counts is None else len(counts))
        self.velocity = self.normals = lambda: None
        self.uvs = lambda name: None
        self.named = lambda name, width: None
        self.roots = self.look = None
        # Positions at steps of time, as geometry.Raw has them.
        self.steps = []
        if not (numpy.isfinite(positions).all() and numpy.isfinite(self.radii).all()):
            raise geometry.GeometryError("some of its strands or points are at infinity or not a number")

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
        steps = numpy.zeros(len(self.positions))
        steps[1:] = numpy.linalg.norm(numpy.diff(self.positions, axis=0), axis=1)
        starts = self.starts()
        steps[starts] = 0
        sums = numpy.cumsum(steps)
        way = sums - self.of_curves(sums[starts])
        return way, self.of_curves(way[starts + self.counts - 1])

    def _computed(self, name):
        if name == "@point_random":
            return hashed_pairs(self.numbers) if self.counts is None else None
        if self.counts is None:
            return None
        if name == "@strand_random":
            return self.of_curves(hashed_pairs(self.numbers))
        way, length = self._along()
        return length if name == "@length" else way / numpy.where(length > 0, length, 1)

    def _generated(self):
        space = self.roots
        size = numpy.array([s if s != 0 else 1 for s in space["size"]], numpy.float32)
        roots = self.positions[self.starts()]
        return self.of_curves((roots - numpy.array(space["location"], numpy.float32) + size) / (2 * size))

    def described(self, look, generated):
        """SUNDOG_mesh of the primitive. `look`: the scene's; `generated`: whether something reads generated coordinates."""
        described = {"strands": {"shape": "points", "radius": RADII} if self.counts is None else self.look or look}
        if generated and self.roots is not None:
            described["generated"] = "_GENERATED"
        elif generated:
            # As Cycles, which has none of such objects: places in the object's space.
            described["texture_space"] = {"location": [0.5] * 3, "size": [0.5] * 3}
        return described

    def arrays(self, demand):
        """The arrays of a primitive by glTF's names."""
        count = len(self.positions)
        arrays = {"POSITION": self.positions, RADII: self.radii}
        for number, step in enumerate(self.steps):
            if step is not None:
                arrays[f"_POSITION_{number}"] = step
        if demand.curve_normals and (normals := self.normals()) is not None:
            arrays["NORMAL"] = normals
        if demand.generated and self.roots is not None:
            arrays["_GENERATED"] = self._generated()
        for number, name in enumerate(demand.uvs):
            # What is not there is zero in Cycles.
            uv = self.uvs(name)
            uv = numpy.zeros((count, 2), numpy.float32) if uv is None else uv
            arrays[f"TEXCOORD_{number}"] = numpy.stack([uv[:, 0], 1 - uv[:, 1]], axis=1)
        named = {f"_SUNDOG_{number}": attribute for number, attribute in enumerate(demand.attributes)}
        if demand.color is not None:
            named["COLOR_0"] = (demand.color, demand.color_width)
        for label, (name, width) in named.items():
            if name in COMPUTED.values():
                found = self._computed(name)
                found = None if found is None else numpy.repeat(found[:, None], 3, axis=1)
            else:
                found = self.named(name, width)
            arrays[label] = numpy.zeros((count, max(width, 3))) if found is None else found
        arrays = {name: values.astype(numpy.float32, copy=False) for name, values in arrays.items()}
        arrays["indices"] = self.indices().reshape(-1)
        return arrays


def hashed_pairs(numbers):
    """Cycles' number from 0 to 1 for each number together with zero: Bob Jenkins' lookup3, as object_info has it for one."""
    start = numpy.uint32((0xDEADBEEF + (2 << 2) + 13) % 0x100000000)
    words = [numbers.astype(numpy.uint32) + start, numpy.full(len(numbers), start), numpy.full(len(numbers), start)]
    object_info.finish(words)
    return words[2].astype(numpy.float32) * numpy.float32(1 / 0x100000000)


def store(parts, demands, cache):
    """Writes strands to the cache folder unless they are there, a primitive for each of `parts` (Strands); `demands` by slot.

    Raises geometry.GeometryError.
    """
    digest = hashlib.blake2b(digest_size=16)
    primitives = []
    for part in parts:
        named = part.arrays(demands[part.slot])
        digest.update(json.dumps([geometry.LAYOUT, part.slot, part.counts is None, demands[part.slot].key()]).encode())
        for name, values in named.items():
            digest.update(f"{name} {values.shape}".encode())
            digest.update(numpy.ascontiguousarray(values).data.cast("B"))
        primitives.append((part.slot, named))
    path = os.path.join(cache, f"mesh-{digest.hexdigest()}.bin")
    return geometry.stored(path, lambda: primitives)


def of_object(shown, kind, slots, depsgraph):
    """The Strands of an evaluated object: of its "HAIR" (particles), or of what it is ("CURVES", "POINTCLOUD"). `slots`: how many
    materials it has. Raises geometry.GeometryError."""
    if kind == "HAIR":
        return of_particles(shown, slots, depsgraph)
    return (of_points if kind == "POINTCLOUD" else of_curves)(shown.data)


def keys_of(shown, kind, depsgraph):
    """Positions of all keys of an object's strands or points as it is now, keys × 3, for its motion."""
    parts = of_object(shown, kind, 1, depsgraph)
    return numpy.concatenate([part.positions for part in parts]) if parts else numpy.empty((0, 3), numpy.float32)


# Hair of particles


def systems_of(shown, depsgraph):
    """Particle systems of an evaluated object whose hair Cycles draws, with their modifiers."""
    if shown.mode in {"EDIT", "PARTICLE_EDIT"}:
        return
    is_on = "show_render" if depsgraph.mode == "RENDER" else "show_viewport"
    for modifier in shown.modifiers:
        if modifier.type != "PARTICLE_SYSTEM" or not getattr(modifier, is_on):
            continue
        system = modifier.particle_system
        if system is not None and system.settings.render_type == "PATH" and system.settings.type == "HAIR":
            yield modifier, system


def are_in(depsgraph):
    """Whether some object has particles, and may have hair: what there are many instances of is not asked each."""
    return any(isinstance(thing, bpy.types.Object) and len(thing.particle_systems) for thing in depsgraph.ids)


def hairy(instance, depsgraph):
    """The evaluated object whose particles' hair an instance shows; None if it shows none."""
    real = instance.instance_object if instance.is_instance else instance.object
    # What geometry nodes make of an object has no hair of its own.
    if not instance.show_particles or real is None or real.type != "MESH" or real.data != instance.object.data:
        return None
    return real if any(True for _ in systems_of(real, depsgraph)) else None


def of_particles(shown, slots, depsgraph):
    """The Strands of an evaluated object's hair, one for each particle system that has some."""
    # All systems of an object are counted as one.
    found, first = [], 0
    inverse = numpy.array(shown.matrix_world.inverted_safe(), float)
    for modifier, system in systems_of(shown, depsgraph):
        numbers, keys = _drawn(system, depsgraph.mode == "RENDER")
        if not len(numbers) or not _is_thick(system.settings):
            first += len(numbers)
            continue
        places = _moved(_places(shown, system, (numbers, keys), depsgraph), inverse)
        radii = _radii(system.settings, places)
        slot = min(max(system.settings.material - 1, 0), max(slots - 1, 0))
        counts = numpy.full(len(numbers), keys)
        strands = Strands(slot, places.reshape(-1, 3), radii.reshape(-1), counts, numpy.arange(first, first + len(numbers)))
        first += len(numbers)
        strands.roots = geometry.texture_space(shown.data)
        if HAS_UPWARD_NORMALS:
            strands.normals = lambda count=len(strands.positions): numpy.tile(numpy.float32((0, 0, 1)), (count, 1))
        _read_emitter(strands, shown.data, (modifier, system), numbers)
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


def _places(shown, system, drawn, depsgraph):
    """World places of all keys: strands × keys × 3. `drawn`: as `_drawn` gives it."""
    numbers, keys = drawn
    place, steps = system.co_hair, range(keys)

    def read(through, numbers):
        found = (place(through, particle_no=number, step=step) for number in numbers.tolist() for step in steps)
        values = numpy.fromiter(itertools.chain.from_iterable(found), numpy.float32, len(numbers) * keys * 3)
        return values.reshape(-1, keys, 3)

    places = read(shown, numbers)
    # Beyond the end of a strand that is cut, Blender tells the world's origin, where a key may also be. That one is elsewhere by
    # the matrix of an object elsewhere.
    doubtful = numpy.flatnonzero((~places.any(axis=2)).any(axis=1))
    if not len(doubtful):
        return places
    missing = ~places[doubtful].any(axis=2)
    here = shown.matrix_world.translation
    elsewhere = next((thing for thing in depsgraph.objects if thing.matrix_world.translation != here), None)
    if elsewhere is not None:
        missing &= ~read(elsewhere, numbers[doubtful]).any(axis=2)
    # Cycles has the last key once more.
    last = keys - 1 - numpy.argmin(missing[:, ::-1], axis=1)
    kept = numpy.minimum(numpy.arange(keys), last[:, None])
    places[doubtful] = numpy.take_along_axis(places[doubtful], kept[:, :, None], axis=1)
    return places


def _moved(places, matrix):
    """Places (… × 3) by a matrix."""
    # Ten times as fast as numpy's product of so flat a matrix.
    x, y, z = numpy.moveaxis(places, -1, 0).astype(float)
    moved = numpy.empty(places.shape, numpy.float32)
    for axis, (a, b, c, d) in enumerate(matrix[:3]):
        moved[..., axis] = a * x + b * y + c * z + d
    return moved


def _is_thick(settings):
    """Whether strands have a radius: some of old files have none, and many keys."""
    return settings.radius_scale != 0 and (settings.root_radius != 0 or settings.tip_radius != 0)


def _radii(settings, places):
    """Radius of each key, by its way along its strand: strands × keys."""
    way = numpy.zeros(places.shape[:2])
    way[:, 1:] = numpy.cumsum(numpy.linalg.norm(numpy.diff(places, axis=1), axis=2), axis=1)
    length = way[:, -1:]
    rest = numpy.clip(1 - way / numpy.where(length > 0, length, 1), 0, 1)
    shape = settings.shape
    if shape < 0:
        rest = rest ** (1 + shape)
    elif shape > 0:
        # At 1 the exponent is infinite.
        rest = rest ** (1 / (1 - shape)) if shape < 1 else (rest >= 1).astype(float)
    scale = 0.5 * settings.radius_scale
    root, tip = settings.root_radius * scale, settings.tip_radius * scale
    radii = rest * (root - tip) + tip
    if settings.use_close_tip:
        radii[:, -1] = 0
    return radii


def _read_emitter(strands, mesh, drawn, numbers):
    """Lets strands read what their mesh has at their roots: UV maps, and colours of corners in bytes. Cycles has no others."""
    modifier, system = drawn
    particles = system.particles
    total = len(particles)

    def at_roots(read, width):
        if not total:
            return None
        # Children know their places by their numbers.
        found = (read(modifier, particles[n if n < total else 0], n) for n in numbers.tolist())
        values = numpy.fromiter(itertools.chain.from_iterable(found), numpy.float32, len(numbers) * width)
        return values.reshape(-1, width)

    def uvs(name):
        layers = mesh.uv_layers
        at = next((i for i, layer in enumerate(layers) if (layer.name == name if name else layer.active_render)), None)
        if at is None:
            return None
        found = at_roots(lambda m, p, n: system.uv_on_emitter(m, particle=p, particle_no=n, uv_no=at), 2)
        return None if found is None else strands.of_curves(found)

    def named(name, width):
        layer = uvs(name) if name and name in mesh.uv_layers else None
        if layer is not None:
            return geometry.to_width(layer, width)
        corners = [c.name for c in mesh.color_attributes if c.data_type == "BYTE_COLOR" and c.domain == "CORNER"]
        if name not in corners:
            return None
        at = corners.index(name)
        found = at_roots(lambda m, p, n: system.mcol_on_emitter(m, particle=p, particle_no=n, vcol_no=at), 3)
        return None if found is None else geometry.to_width(strands.of_curves(images.decode_srgb(found)), width)

    strands.uvs, strands.named = uvs, named


# Curves and points


def of_curves(data):
    """The Strands of evaluated hair curves. As in Cycles, control points are keys whatever the type of a curve, and none is closed."""
    read = functools.partial(_attribute, data)
    positions = read("position")
    if positions is None or not len(positions):
        return []
    counts = numpy.diff(geometry.read(data.curve_offset_data, "value", numpy.int32))
    radii = read("radius", counts)
    radii = numpy.full(len(positions), RADIUS) if radii is None else radii[:, 0]
    # A curve of one key has no segment; others keep their numbers.
    drawn = counts > 1
    kept = numpy.repeat(drawn, counts)
    if not kept.any():
        return []
    strands = Strands(0, positions[kept], radii[kept], counts[drawn], numpy.flatnonzero(drawn))
    _read_attributes(strands, data, lambda name: values[kept] if (values := read(name, counts)) is not None else None)
    # One by one: read as an array they are not what they are (5.2.3).
    strands.normals = lambda: numpy.array([normal.vector[:] for normal in data.normals], numpy.float32)[kept]
    kinds = read("curve_type")
    if kinds is not None and kinds[0, 0] == _POLY and HAS_POLY:
        # As Cycles: the first curve decides.
        strands.look = {"shape": "round-linear", "radius": RADII}
    return [strands]


def of_points(data):
    """The Strands of an evaluated point cloud. Raises geometry.GeometryError."""
    if getattr(data, "type", "POINTS") != "POINTS":
        # From 5.3 on.
        raise geometry.GeometryError("it is made of Gaussian splats")
    positions = _attribute(data, "position")
    if positions is None or not len(positions):
        return []
    radii = _attribute(data, "radius")
    radii = numpy.full(len(positions), POINT_RADIUS) if radii is None else radii[:, 0]
    strands = Strands(0, positions, radii, None)
    _read_attributes(strands, data, functools.partial(_attribute, data))
    return [strands]


def _attribute(data, name, counts=None):
    """Rows of an attribute as it is; with `counts`, the keys of curves, those of curves for each of their keys. None if there is
    none of that name."""
    attribute = data.attributes.get(name)
    if attribute is None or attribute.data_type not in geometry.FIELDS:
        return None
    values = geometry.values_of(attribute)
    return values if counts is None or attribute.domain != "CURVE" else numpy.repeat(values, counts, axis=0)


def _read_attributes(strands, data, read):
    """Lets strands read attributes of their keys and curves; `read(name)` gives rows for all keys, or None."""

    def uvs(name):
        if not name:
            # Cycles' own choice: the first pair of numbers of curves.
            pairs = (a.name for a in data.attributes if a.data_type == "FLOAT2" and a.domain == "CURVE")
            name = next(pairs, None)
        found = None if name is None else read(name)
        return None if found is None else geometry.to_width(found, 3)[:, :2]

    def named(name, width):
        found = read(name) if name else None
        return None if found is None else geometry.to_width(found, width)

    def velocity():
        found = read("velocity")
        return found if found is not None and found.shape[1] == 3 else None

    strands.uvs, strands.named, strands.velocity = uvs, named, velocity
