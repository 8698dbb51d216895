# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluated meshes as glTF primitives, in files named by a hash of their content.

Vertices stay in Blender's own axes: the nodes' matrices turn them to glTF's (Y up). A permutation
of axes with signs is exact.
"""

import contextlib
import hashlib
import json
import os
import struct

import bpy
import numpy

from . import colorspace, gltf, images, object_info

# Outputs of the Geometry node that Cycles computes of the mesh, and what their attributes are called here.
COMPUTED = {
    ("ShaderNodeNewGeometry", "Pointiness"): "@pointiness",
    ("ShaderNodeNewGeometry", "Random Per Island"): "@random_per_island",
}

# Names under which attributes are read that no mesh need have.
_OWN = {"uv", "generated", "pointiness", "random_per_island"}

# Raised when the layout of the files or what is made of attributes changes, so that files of older versions are not taken.
LAYOUT = 5

# At the end of a mesh's file: the description of what is in it, its length, and this.
MARK = b"sundog-2"

# A reader needs 4-byte indices and memory for it; beyond this, the answer is a report.
MOST_CORNERS = 1 << 30


class GeometryError(Exception):
    """A mesh that cannot be exported, in one sentence."""


@contextlib.contextmanager
def readable(shown):
    """The mesh of an evaluated object, with all of its layers.

    While a mesh is in Edit Mode its evaluated data are views on the edit mesh, whose layers are empty. Then this is a
    copy for the while, as Cycles makes one; neither the mode nor the user's data change.
    """
    mesh = shown.data
    if not mesh.is_editmode:
        yield mesh
        return
    try:
        yield shown.to_mesh()
    finally:
        shown.to_mesh_clear()


class Demand:
    """What the materials of a mesh need of it: names of UV maps (None: the active one), the name and the number of components
    of a colour attribute, and for shader graphs those of other attributes (1: Cycles' number of it, three times) and whether
    they read generated coordinates, displace vertices, and follow the normals of curves; for each slot in use."""

    def __init__(self, uvs=(), color=None, color_width=3, attributes=(), generated=False, vertices=False, curve_normals=False):
        self.uvs, self.color, self.color_width = tuple(uvs), color, color_width
        self.attributes, self.generated, self.vertices = tuple(attributes), generated, vertices
        self.curve_normals = curve_normals

    def key(self):
        """For hashing."""
        names = [list(self.uvs), self.color, self.color_width, [list(a) for a in self.attributes]]
        return [*names, self.generated, self.vertices, self.curve_normals]

    def colors(self):
        """Names and numbers of components of all attributes."""
        return {*self.attributes, *([(self.color, self.color_width)] if self.color is not None else ())}


def read(collection, attribute, dtype, width=1):
    """An attribute of all of a collection, as an array of rows if it has several numbers."""
    values = numpy.empty(len(collection) * width, dtype)
    collection.foreach_get(attribute, values)
    return values if width == 1 else values.reshape(-1, width)


def _attribute(mesh, name, field, dtype, width=1):
    attribute = mesh.attributes.get(name)
    return None if attribute is None else read(attribute.data, field, dtype, width)


def material_indices(mesh):
    """Which slot each polygon uses, as an int32 array; None if all use the first."""
    found = _attribute(mesh, "material_index", "value", numpy.int32)
    return found if found is not None and found.any() else None


# Stands for the name of the UV map that is active for rendering, where tangents follow a sphere in a mesh without any map.
OR_SPHERE = ""


def uv_layer(mesh, name):
    """The UV map of that name; of None or OR_SPHERE, the one that is active for rendering."""
    if name:
        return mesh.uv_layers.get(name)
    return next((layer for layer in mesh.uv_layers if layer.active_render), None)


def absent_uvs(mesh, demand):
    """Numbers of the sets that stand for UV maps that a mesh does not have: Cycles has no tangents of them."""

    def is_there(name):
        if name == OR_SPHERE and not mesh.uv_layers:
            return True
        return uv_layer(mesh, name) is not None or bool(name) and name in mesh.attributes

    return [number for number, name in enumerate(demand.uvs) if not is_there(name)]


def on_sphere(positions):
    """Coordinates of points on a sphere about the origin, as Cycles maps them."""
    x, y, z = positions.T
    length = numpy.linalg.norm(positions, axis=1)
    away = length > 0
    u = numpy.where(away & ((x != 0) | (y != 0)), 0.5 - numpy.arctan2(x, y) / (2 * numpy.pi), 0)
    v = numpy.where(away, 1 - numpy.arccos(numpy.clip(z / numpy.where(away, length, 1), -1, 1)) / numpy.pi, 0)
    return numpy.stack([u, v], axis=1).astype(numpy.float32)


# Whether a face goes on over the seam of the sphere in Cycles.
GOES_ON_OVER_SEAMS = bpy.app.version >= (5, 0, 0)


def go_on_over_seams(u, starts):
    """Lets coordinates around a sphere go on beyond 0 and 1 in faces that lie across its seam, from their first corners."""
    first = numpy.repeat(u[starts], numpy.diff(numpy.append(starts, len(u))))
    u -= numpy.round(u - first)


FIELDS = {
    "FLOAT_COLOR": ("color", 4),
    "BYTE_COLOR": ("color", 4),
    "FLOAT": ("value", 1),
    "INT": ("value", 1),
    "INT8": ("value", 1),
    "BOOLEAN": ("value", 1),
    "FLOAT_VECTOR": ("vector", 3),
    "FLOAT2": ("vector", 2),
    "QUATERNION": ("value", 4),
}
# Kinds that Cycles has as an attribute of zeros.
UNREAD = {"INT16_2D", "INT32_2D", "FLOAT4X4"}


def _color(mesh, name, width):
    """(domain, linear colours of `width` components) of an attribute, or None. One component: as in Demand."""
    if name in COMPUTED.values() or (name in _OWN and name not in mesh.attributes):
        return _computed(mesh, name.removeprefix("@"), width)
    if not name:
        name = _active_color(mesh)
    attribute = mesh.attributes.get(name)
    if attribute is None or attribute.domain not in {"POINT", "EDGE", "CORNER", "FACE"}:
        return None
    if attribute.data_type in UNREAD:
        return attribute.domain.replace("EDGE", "POINT"), to_width(numpy.zeros((_count(mesh, attribute), 1), numpy.float32), width)
    if attribute.data_type not in FIELDS:
        return None
    if attribute.domain == "EDGE":
        return "POINT", to_width(_of_edges(mesh, attribute), width)
    return attribute.domain, to_width(values_of(attribute), width)


def _count(mesh, attribute):
    """How many numbers an attribute has on the mesh; those of edges are given to vertices."""
    return len(mesh.vertices) if attribute.domain == "EDGE" else len(attribute.data)


def _active_color(mesh):
    """The name of the colour attribute that is active for rendering, on whatever it is: the list of them has those of vertices and
    corners alone."""
    number = mesh.color_attributes.render_color_index
    if 0 <= number < len(mesh.color_attributes):
        return mesh.color_attributes[number].name
    return getattr(mesh.attributes, "default_color_name", "")


def _of_edges(mesh, attribute):
    """What Blender makes of an attribute of edges for vertices: a mean over the edges that meet there, by the kind of its numbers."""
    ends, count = read(mesh.edges, "vertices", numpy.int32, 2).reshape(-1), len(mesh.vertices)
    met = numpy.maximum(numpy.bincount(ends, minlength=count), 1)[:, None]

    def mean(values):
        sums = [numpy.bincount(ends, numpy.repeat(column, 2), count) for column in values.T]
        return (numpy.stack(sums, axis=1) / met).astype(numpy.float32)

    kind = attribute.data_type
    if kind == "BYTE_COLOR":
        # The coded numbers are mixed, which stay of 8 bits.
        values = numpy.floor(mean(numpy.round(read(attribute.data, "color_srgb", numpy.float32, 4) * 255)) + 1e-4) / 255
        values[:, :3] = images.decode_srgb(values[:, :3])
        return values
    values = values_of(attribute)
    if kind == "BOOLEAN":
        # Of truths one is enough.
        return (mean(values) > 0).astype(numpy.float32)
    if kind == "QUATERNION":
        return _rotations(mean(_turns(values)))
    if kind in {"INT", "INT8"}:
        # Halves are rounded away from zero.
        means = mean(values)
        return numpy.copysign(numpy.floor(numpy.abs(means) + 0.5), means)
    return mean(values)


def _turns(rotations):
    """Axes of rotations (w, x, y, z), as long as their angles."""
    length = numpy.linalg.norm(rotations[:, 1:], axis=1, keepdims=True)
    angle = 2 * numpy.arctan2(length, rotations[:, :1])
    return rotations[:, 1:] * numpy.divide(angle, length, out=numpy.zeros_like(angle), where=length > 0)


def _rotations(turns):
    """The other way round."""
    angle = numpy.linalg.norm(turns, axis=1, keepdims=True)
    axis = numpy.divide(turns, angle, out=numpy.zeros_like(turns), where=angle > 0)
    return numpy.concatenate([numpy.cos(angle / 2), axis * numpy.sin(angle / 2)], axis=1).astype(numpy.float32)


def values_of(attribute):
    """The linear numbers of an attribute as floats: elements × 1 to 4."""
    field, components = FIELDS[attribute.data_type]
    # Blender's `color` is in the working space, and so Cycles (5.0.1, 5.2.3) has those of corners; all others it only decodes.
    encoded = (
        attribute.data_type == "BYTE_COLOR" and attribute.domain != "CORNER" and colorspace.working_space() != colorspace.REC709
    )
    if encoded:
        field = "color_srgb"
    if attribute.data_type in {"INT", "INT8", "BOOLEAN"}:
        kind = bool if attribute.data_type == "BOOLEAN" else numpy.int32
        values = read(attribute.data, field, kind).astype(numpy.float32)
    else:
        values = read(attribute.data, field, numpy.float32, components)
    values = values.reshape(-1, components)
    if encoded:
        values[:, :3] = images.decode_srgb(values[:, :3])
    return values


def to_width(values, width):
    """Numbers of an attribute as so many as are asked for, as Cycles converts them. One component: as in Demand."""
    components = values.shape[1]
    if width == 1:
        number = values[:, :1] if components < 3 else values[:, :3].mean(axis=1, keepdims=True, dtype=numpy.float32)
        return numpy.repeat(number, 3, axis=1)
    if components == 1:
        values = numpy.repeat(values, 3, axis=1)
    while values.shape[1] < width:
        fill = numpy.full((len(values), 1), 1.0 if values.shape[1] == 3 else 0.0, numpy.float32)
        values = numpy.concatenate([values, fill], axis=1)
    return values[:, :width]


def _computed(mesh, name, width):
    """As `_color`, of what Cycles has under names of its own."""
    if name == "uv":
        layer = uv_layer(mesh, None)
        if layer is None:
            return None
        domain, values = "CORNER", read(layer.uv, "vector", numpy.float32, 2)
    elif name == "generated":
        domain, values = "POINT", generated(mesh)
    else:
        domain, values = (pointiness if name == "pointiness" else islands)(mesh)
        values = values[:, None]
    if values.shape[1] == 1 or (width == 1 and values.shape[1] == 2):
        values = numpy.repeat(values[:, :1], 3, axis=1)
    elif width == 1:
        values = numpy.repeat(values.mean(axis=1, keepdims=True, dtype=numpy.float32), 3, axis=1)
    missing = [numpy.zeros(len(values)), numpy.ones(len(values))]
    columns = [*values.T, *(missing[i == 3] for i in range(values.shape[1], max(width, 3)))]
    return domain, numpy.stack(columns, axis=1).astype(numpy.float32)


def step_of(mesh, domain):
    """Positions and normals of a mesh, as it is now, for the motion of one whose normals are those of a domain."""
    positions = read(mesh.vertices, "co", numpy.float32, 3)
    normals = {"POINT": "vertex_normals", "CORNER": "corner_normals"}.get(domain)
    return positions, None if normals is None else read(getattr(mesh, normals), "vector", numpy.float32, 3)


class Raw:
    """The arrays of a mesh as Blender has them, with a hash of all of them. `steps`: see motion.Deformation."""

    def __init__(self, mesh, demands, diced=None, steps=None):
        self.mesh, self.diced = mesh, diced
        self.steps = steps or []
        self.demands = demands
        corners, polygons = len(mesh.loops), len(mesh.polygons)
        if corners > MOST_CORNERS:
            raise GeometryError(f"it has {corners} face corners; at most {MOST_CORNERS} can be exported")
        self.positions = _attribute(mesh, "position", "vector", numpy.float32, 3)
        self.corner_vertices = _attribute(mesh, ".corner_vert", "value", numpy.int32)
        if self.positions is None:
            self.positions = read(mesh.vertices, "co", numpy.float32, 3)
        if self.corner_vertices is None:
            self.corner_vertices = read(mesh.loops, "vertex_index", numpy.int32)
        self.polygon_starts = read(mesh.polygons, "loop_start", numpy.int32)
        self.slots = material_indices(mesh)
        # As Cycles has them: flat meshes by their triangles, smooth ones by their vertices, and all
        # others (sharp edges, some faces flat, custom normals) by their corners.
        self.domain = mesh.normals_domain
        self.normals = None
        if self.domain == "POINT":
            self.normals = read(mesh.vertex_normals, "vector", numpy.float32, 3)
        elif self.domain == "CORNER":
            self.normals = read(mesh.corner_normals, "vector", numpy.float32, 3)
        uv_names = sorted({name for d in demands.values() for name in d.uvs}, key=lambda n: (n is None, n or ""))
        self.uvs = {}
        for name in uv_names:
            layer = uv_layer(mesh, name)
            if layer is not None:
                self.uvs[name] = read(layer.uv, "vector", numpy.float32, 2)
            elif name == OR_SPHERE:
                if not mesh.uv_layers:
                    self.uvs[name] = on_sphere(self.positions)[self.corner_vertices]
                    if GOES_ON_OVER_SEAMS:
                        go_on_over_seams(self.uvs[name][:, 0], self.polygon_starts)
            elif (found := _color(mesh, name, 3) if name else None) is not None:
                # Coordinates by an attribute: those of geometry nodes may be of any kind. Images see the first two.
                domain, values = found
                self.uvs[name] = numpy.ascontiguousarray(self._by_corner(domain, values[:, :2]))
        self.colors = {}
        for name, width in sorted({color for d in demands.values() for color in d.colors()}):
            found = _color(mesh, name, width)
            if found is not None:
                self.colors[(name, width)] = found
        self.generated = generated(mesh) if any(d.generated for d in demands.values()) and is_deformed(mesh) else None
        displaces = any(d.vertices for d in demands.values())
        self.vertices = self._vertices() if displaces else None
        # Cycles displaces flat meshes by these; those of its finer triangles are not known.
        is_told = displaces and self.domain == "FACE" and not diced
        self.vertex_normals = read(mesh.vertex_normals, "vector", numpy.float32, 3) if is_told else None
        self._check()
        digest = hashlib.blake2b(digest_size=16)
        description = {
            "layout": LAYOUT,
            "domain": self.domain,
            "polygons": polygons,
            "demands": {str(k): d.key() for k, d in demands.items()},
            "uvs": list(self.uvs),
            "colors": [[n, w, domain] for (n, w), (domain, _) in self.colors.items()],
            "diced": diced and diced.key(),
            "steps": len(self.steps),
        }
        digest.update(json.dumps(description, sort_keys=True).encode())
        arrays = [self.positions, self.corner_vertices, self.polygon_starts, self.slots, self.normals, self.generated, self.vertices]
        arrays.append(self.vertex_normals)
        arrays += [*self.uvs.values(), *(values for _, values in self.colors.values())]
        arrays += [array for step in self.steps if step is not None for array in step]
        for array in arrays:
            if array is not None:
                digest.update(numpy.ascontiguousarray(array).data.cast("B") if array.size else b"")
        self.hash = digest.hexdigest()

    def _check(self):
        if not numpy.isfinite(self.positions).all():
            raise GeometryError("some of its vertices are at infinity or not a number")
        if len(self.corner_vertices) and not (
            0 <= self.corner_vertices.min() and self.corner_vertices.max() < len(self.positions)
        ):
            raise GeometryError("some of its faces use vertices that do not exist (run Mesh > Clean Up, or mesh.validate())")

    def _vertices(self):
        """By vertex, or where normals are those of corners by corner: what tells vertices apart, and how they are shaded."""
        by_corner = self.domain == "CORNER"
        names = self.corner_vertices if by_corner else numpy.arange(len(self.positions), dtype=numpy.int32)
        shaded = numpy.full(len(names), {"FACE": 0, "POINT": 1, "CORNER": 2}[self.domain], numpy.float32)
        sharp = _attribute(self.mesh, "sharp_face", "value", bool)
        if by_corner and sharp is not None:
            shaded += self._by_corner("FACE", sharp)
        return numpy.stack([names & 0xFFFF, names >> 16, shaded], axis=1).astype(numpy.float32)

    def _by_corner(self, domain, values):
        """An attribute's values for each corner of the faces."""
        if domain == "POINT":
            return values[self.corner_vertices]
        if domain == "FACE":
            totals = numpy.diff(numpy.append(self.polygon_starts, len(self.corner_vertices)))
            return numpy.repeat(values, totals, axis=0)
        return values

    def _slot_of(self, slots_in_use):
        last = max(slots_in_use)
        return None if self.slots is None else numpy.clip(self.slots, 0, last)

    def _triangles(self):
        """(corners, numbers of their faces) of the triangles."""
        quads = self.diced.coarser(self.positions, self.corner_vertices, self.polygon_starts) if self.diced else None
        if quads is not None:
            faces = numpy.searchsorted(self.polygon_starts, quads[:, 0], "right") - 1
            return quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3), numpy.repeat(faces, 2)
        self.mesh.calc_loop_triangles()
        numbers = None if self.slots is None else read(self.mesh.loop_triangle_polygons, "value", numpy.int32)
        return read(self.mesh.loop_triangles, "loops", numpy.int32, 3), numbers

    def primitives(self):
        """For each slot in use: slot, and the arrays of its primitive by glTF's names."""
        triangles, polygon_of = self._triangles()
        if not len(triangles):
            return []
        slots = sorted(self.demands)
        slot_of_polygon = self._slot_of(slots)
        by_corner = (
            self.domain == "CORNER"
            or bool(self.uvs)
            or any(domain != "POINT" for domain, _ in self.colors.values())
        )
        if slot_of_polygon is None:
            groups = [(slots[0], triangles, None)]
        else:
            slot_of_triangle = slot_of_polygon[polygon_of]
            order = numpy.argsort(slot_of_triangle.astype(numpy.int16), kind="stable")
            bounds = numpy.searchsorted(slot_of_triangle[order], [*slots, slots[-1] + 1])
            groups = [
                (slot, triangles[order[first:end]], slot)
                for slot, first, end in zip(slots, bounds[:-1], bounds[1:])
                if end > first
            ]
        if by_corner and slot_of_polygon is not None:
            # Corners of one slot behind one another, so that no primitive reads another's vertices.
            totals = numpy.diff(numpy.append(self.polygon_starts, len(self.corner_vertices)))
            slot_of_corner = numpy.repeat(slot_of_polygon.astype(numpy.int16), totals)
            order = numpy.argsort(slot_of_corner, kind="stable")
            place = numpy.empty(len(order), numpy.uint32)
            place[order] = numpy.arange(len(order), dtype=numpy.uint32)
            starts = numpy.searchsorted(slot_of_corner[order], [*slots, slots[-1] + 1])
            ranges = {slot: (a, b) for slot, a, b in zip(slots, starts[:-1], starts[1:])}
        result = []
        for slot, group, key in groups:
            corners = vertices = None
            if not by_corner:
                local = self.corner_vertices[group]
                if key is None:
                    indices = local.astype(numpy.uint32)
                else:
                    vertices, indices = _renumbered(local)
            elif key is None:
                indices = group.astype(numpy.uint32)
                vertices = self.corner_vertices
            else:
                first, end = ranges[slot]
                corners = order[first:end]
                indices = place[group] - numpy.uint32(first)
                vertices = self.corner_vertices[corners]
            result.append((slot, self._arrays(slot, indices, vertices, corners, by_corner)))
        return result

    def _arrays(self, slot, indices, vertices, corners, by_corner):
        def of_vertices(values):
            return values if vertices is None else values[vertices]

        def of_corners(values):
            return values if corners is None else values[corners]

        demand = self.demands[slot]
        arrays = {"POSITION": of_vertices(self.positions)}
        if self.domain == "POINT":
            arrays["NORMAL"] = of_vertices(self.normals)
        elif self.domain == "CORNER":
            arrays["NORMAL"] = of_corners(self.normals)
        for number, step in enumerate(self.steps):
            if step is None:
                continue
            arrays[f"_POSITION_{number}"] = of_vertices(step[0])
            if step[1] is not None:
                arrays[f"_NORMAL_{number}"] = (of_corners if self.domain == "CORNER" else of_vertices)(step[1])
        if self.vertices is not None:
            arrays["_VERTEX"] = (of_corners if self.domain == "CORNER" else of_vertices)(self.vertices)
        if self.vertex_normals is not None:
            arrays["_VERTEX_NORMAL"] = of_vertices(self.vertex_normals)
        if self.generated is not None and demand.generated:
            arrays["_GENERATED"] = of_vertices(self.generated)
        count = len(arrays["POSITION"])
        for number, name in enumerate(demand.uvs):
            uv = self.uvs.get(name)
            if uv is None:
                # Cycles reads a UV map that is not there as zero.
                uv = numpy.zeros((count, 2), numpy.float32)
            else:
                uv = of_corners(uv)
            flipped = numpy.empty((count, 2), numpy.float32)
            flipped[:, 0] = uv[:, 0]
            numpy.subtract(1.0, uv[:, 1], out=flipped[:, 1])
            arrays[f"TEXCOORD_{number}"] = flipped
        named = {f"_SUNDOG_{number}": attribute for number, attribute in enumerate(demand.attributes)}
        if demand.color is not None:
            named["COLOR_0"] = (demand.color, demand.color_width)
        for label, attribute in named.items():
            found = self.colors.get(attribute)
            if found is None:
                # And an attribute that is not there as black.
                arrays[label] = numpy.zeros((count, max(attribute[1], 3)), numpy.float32)
            else:
                domain, values = found
                arrays[label] = of_vertices(values) if domain == "POINT" else of_corners(self._by_corner(domain, values))
        arrays["indices"] = indices.reshape(-1)
        return arrays


def _renumbered(corners):
    """(vertices that the corners use, in ascending order; the corners as numbers among them), without sorting."""
    low, high = int(corners.min()), int(corners.max()) + 1
    used = numpy.zeros(high - low, bool)
    used[corners.reshape(-1) - low] = True
    place = numpy.cumsum(used, dtype=numpy.uint32)
    return numpy.flatnonzero(used) + low, place[corners - low] - numpy.uint32(1)


def slots_in_use(mesh, slot_count):
    """Numbers of the material slots that the mesh's faces use, as Cycles clamps them."""
    indices = material_indices(mesh)
    if indices is None:
        return [0]
    last = max(slot_count - 1, 0)
    return [int(i) for i in numpy.unique(numpy.clip(indices, 0, last))]


def texture_space(mesh):
    """The middle and half the size of the box that generated coordinates are relative to."""
    return {"location": [float(v) for v in mesh.texspace_location], "size": [float(v) for v in mesh.texspace_size]}


def is_deformed(mesh):
    """Whether vertices have other places than those that Cycles makes generated coordinates of."""
    before, after = (read(mesh.vertices, field, numpy.float32, 3) for field in ("undeformed_co", "co"))
    scale = float(numpy.abs(after).max(initial=0.0))
    # Blender keeps the places before modifiers relative to the texture space, which rounds them.
    return bool((numpy.abs(before - after) > 1e-5 * scale + 1e-12).any())


def generated(mesh):
    """Generated coordinates of the vertices, by their places before modifiers and shape keys."""
    before = read(mesh.vertices, "undeformed_co", numpy.float32, 3)
    middle, size = (numpy.array(v, numpy.float32) for v in (mesh.texspace_location, mesh.texspace_size))
    size[size == 0] = 1
    return (before - middle + size) / (2 * size)


def pointiness(mesh):
    """Cycles' Pointiness by vertex: the angle between its normal and the mean of its edges, in turns of a half, blurred once.
    Vertices in one place count as one."""
    places = read(mesh.vertices, "co", numpy.float32, 3)
    edges = read(mesh.edges, "vertices", numpy.int32, 2)
    normals = read(mesh.vertex_normals, "vector", numpy.float32, 3)
    _, firsts, one = numpy.unique(places, axis=0, return_index=True, return_inverse=True)
    one = one.reshape(-1)
    count = len(firsts)

    def summed(numbers, values):
        return numpy.stack([numpy.bincount(numbers, column, count) for column in values.T], axis=1)

    normal = summed(one, normals)
    normal /= numpy.maximum(numpy.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    pairs = numpy.unique(numpy.sort(one[edges], axis=1), axis=0) if len(edges) else numpy.empty((0, 2), int)
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    along = (places[firsts[pairs[:, 1]]] - places[firsts[pairs[:, 0]]]).astype(float)
    along /= numpy.maximum(numpy.linalg.norm(along, axis=1, keepdims=True), 1e-30)
    ends = numpy.concatenate([pairs[:, 0], pairs[:, 1]])
    met = numpy.bincount(ends, minlength=count)
    mean = summed(ends, numpy.concatenate([along, -along])) / numpy.maximum(met, 1)[:, None]
    raw = numpy.where(met > 0, numpy.arccos(numpy.clip((normal * mean).sum(axis=1), -1, 1)) / numpy.pi, 0.0)
    others = numpy.concatenate([pairs[:, 1], pairs[:, 0]])
    blurred = (raw + numpy.bincount(ends, raw[others], count)) / (met + 1)
    return "POINT", blurred[one].astype(numpy.float32)


def islands(mesh):
    """Cycles' Random Per Island by face: a hash of the number of a vertex that stands for all that edges join."""
    parents = list(range(len(mesh.vertices)))
    ranks = [0] * len(parents)

    def root(at):
        while parents[at] != at:
            at = parents[at]
        return at

    def shortened(at):
        to = root(at)
        while parents[at] != to:
            parents[at], at = to, parents[at]
        return to

    for first, second in read(mesh.edges, "vertices", numpy.int32, 2).tolist():
        first, second = shortened(first), shortened(second)
        if first != second:
            if ranks[first] < ranks[second]:
                first, second = second, first
            parents[second] = first
            ranks[first] += ranks[first] == ranks[second]
    firsts = read(mesh.loops, "vertex_index", numpy.int32)[read(mesh.polygons, "loop_start", numpy.int32)]
    known = {}
    values = numpy.empty(len(firsts), numpy.float32)
    for number, vertex in enumerate(firsts.tolist()):
        island = shortened(vertex)
        if island not in known:
            known[island] = object_info.hashed_float(island)
        values[number] = known[island]
    return "FACE", values


class Stored:
    """A mesh in the cache folder: `path`, `layout` with the primitives, `written` if it is new."""

    def __init__(self, path, layout, written):
        self.path, self.layout, self.written = path, layout, written


def store(mesh, demands, cache, diced=None, steps=None):
    """Writes a mesh to the cache folder unless it is there; None if it has no faces.

    `demands` has a Demand for each slot in use, `diced` says how its triangles are divided, and `steps`
    how they move. Raises GeometryError.
    """
    if not len(mesh.polygons):
        return None
    raw = Raw(mesh, demands, diced, steps)
    path = os.path.join(cache, f"mesh-{raw.hash}.bin")

    def primitives():
        for slot, named in raw.primitives():
            yield slot, diced.divided(named, curved=raw.domain == "POINT") if diced else named

    return stored(path, primitives, (lambda: {"enlarged": diced.enlarged}) if diced else dict)


def stored(path, primitives, notes=dict):
    """A file of the cache with a mesh's primitives, written unless it is there; None if there are none.

    `primitives()` gives the slot of each and its arrays by glTF's names, `notes()` what the layout tells beside. Raises GeometryError.
    """
    layout = _read_layout(path)
    if layout is not None:
        return Stored(path, layout, False)
    arrays, described = [], []
    for slot, named in primitives():
        primitive = {"slot": slot, "attributes": {}}
        for name, values in named.items():
            options = {"POSITION": ("bounds",), "indices": ("index",)}.get(name, ())
            if name == "indices":
                primitive["indices"] = len(arrays)
            else:
                primitive["attributes"][name] = len(arrays)
            arrays.append((numpy.ascontiguousarray(values), options))
        described.append(primitive)
    if not described:
        return None
    try:
        parts, layout = gltf.describe_arrays(arrays)
    except MemoryError as error:
        raise GeometryError("there is not enough memory for it") from error
    layout["primitives"] = described
    layout.update(notes())
    written = json.dumps(layout).encode()
    gltf.write_whole(path, [*parts, written, struct.pack("<Q", len(written)), MARK])
    return Stored(path, layout, True)


def _read_layout(path):
    """The layout of a mesh's file, or None if it is not there or not whole."""
    end = 8 + len(MARK)
    try:
        with open(path, "rb") as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(size - end)
            ending = file.read(end)
            (length,) = struct.unpack_from("<Q", ending)
            if not ending.endswith(MARK) or length > size - end:
                return None
            file.seek(size - end - length)
            layout = json.loads(file.read(length))
        return layout if layout["bytes"] + length + end == size else None
    except (OSError, ValueError, KeyError, TypeError, struct.error):
        return None
