# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts a scene together: walks the depsgraph's instances, and writes nodes for meshes, lights and the camera."""

import array
import collections
import hashlib
import math
import os
import time

import bpy
import numpy

from . import camera as cameras
from . import colorspace, culling, decomposed, dicing, evaluated, fast_gi, geometry, gltf, graph_write, grids, images, lights, linking, materials, modifiers, motion, nodes, object_info, strands, views, visibility
from . import world as worlds
from .verdicts import APPROXIMATED, EXACT, LOST, Finding

# glTF's axes are Y up: (x, y, z) of Blender is (x, z, -y). A permutation with a sign: exact.
TO_GLTF = numpy.array([[1.0, 0, 0, 0], [0, 0, 1.0, 0], [0, -1.0, 0, 0], [0, 0, 0, 1.0]])

# From this many copies on, instances are written as arrays instead of as nodes.
INSTANCING_FROM = 64

# Seconds between two words on how far the export is.
TELL_EVERY = 0.1

# Objects that are made of strands or points.
STRANDS = {"CURVES", "POINTCLOUD"}

# Before 4.3 and from then on.
GREASE_PENCIL = {"GPENCIL", "GREASEPENCIL"}


class ExportError(Exception):
    """Why a scene cannot be exported, in one sentence that names the object."""


def node_matrix(matrix):
    """glTF's `matrix` (by columns) of a world matrix of Blender; None for the identity."""
    turned = TO_GLTF @ numpy.array(matrix, float)
    return turned.T.reshape(-1).tolist()


class _Place:
    """Where objects of one mesh stand that Sundog's extension says the same of."""

    def __init__(self, extension):
        self.extension, self.names = extension, []
        # Row by row, in Blender's own precision.
        self.matrices = array.array("f")

    def add(self, name, instance):
        """Adds an instance."""
        self.names.append(name)
        for row in instance.matrix_world:
            self.matrices.extend(row)

    def extend(self, other):
        """Adds all of another."""
        self.names += other.names
        self.matrices.extend(other.matrices)

    def only(self):
        """As `node_matrix`, of the only one."""
        # Zeros have no sign.
        x, y, z, w = (self.matrices[4 * row : 4 * row + 4] for row in range(4))
        return [c + 0.0 for column in range(4) for c in (x[column], z[column], -y[column], w[column])]


def _owner(shown):
    """Whose mesh it is in Cycles: the data's, or the object's own where a material is linked to that."""
    is_own = any(slot.link == "OBJECT" for slot in shown.material_slots)
    return (shown if is_own else shown.data).as_pointer()


def _material_of(shown, number, slot):
    """What a slot of an evaluated object shows: from 5.1 on nothing where the object itself has none there, though Blender says the mesh's."""
    if slot.link == "OBJECT" and bpy.app.version >= (5, 1, 0):
        own = shown.original.material_slots
        if number < len(own) and own[number].material is None:
            return None
    return slot.material


class _Described:
    """An object that another shows: its glTF mesh, whose that is in Cycles, and the SUNDOG_object that all its instances have."""

    def __init__(self, name, mesh, owner, extension):
        self.name, self.mesh, self.owner, self.extension = name, mesh, owner, extension
        # Where its instances stand, if nothing but that is their own.
        self.place = None


class Exporter:
    """One export. Call `objects`, `camera`, `world` and `finish` in this order."""

    def __init__(self, depsgraph, scene, folder, cache, verdicts, report, move=None, views=()):
        self.depsgraph, self.scene, self.cache, self.views = depsgraph, scene, cache, views
        nodes.SceneWide.of(scene)
        # What brings the depsgraph to a frame and a subframe, and what it is asked for so.
        self.move, self.motion = move, None
        self.verdicts, self.report = verdicts, report
        self.view_layer = depsgraph.view_layer.original if hasattr(depsgraph.view_layer, "original") else depsgraph.view_layer
        self.path = os.path.join(folder, "scene.gltf")
        version = ".".join(map(str, bpy.app.version))
        self.document = gltf.Document(folder, f"Sundog add-on for Blender {version}")
        self.materials = materials.Writer(self.document, cache, bpy.app.version)
        # The pass shows the active UV map, which is the first that the file has.
        self.materials.first_uvs = [None] if depsgraph.view_layer.use_pass_uv else []
        self.materials.layer = (self.view_layer, scene, scene.world)
        self.materials.aovs = {aov.name: aov.type for aov in self.view_layer.aovs if aov.is_valid}
        self.materials.writes_indices = depsgraph.view_layer.use_pass_material_index
        self._culling = self._light_groups = self._links = self._instances = None
        self.changed_geometry = 0
        self._fast_gi = fast_gi.of_scene(scene, self._world())
        self._replaces = self._fast_gi is not None and self._fast_gi["method"] == "replace"
        self._planes = lights.Planes()
        # Evaluated data and slots -> glTF mesh, or None where there is nothing to render.
        self._meshes = {}
        self._buffers = {}
        # glTF meshes with materials that read what Object Info tells.
        self._informed = set()
        # The numbers of the values that the materials of a glTF mesh read of objects.
        self._asked = {}
        # (mesh, SUNDOG_object as text) -> where it stands.
        self._placed = {}
        # By what is shown and by whom.
        self._described = {}
        # Whether glTF meshes shine.
        self._emits = {}
        # Of meshes that shine: places -> names.
        self._shining = {}

    def objects(self):
        """All that the depsgraph would render."""
        blurs = motion.is_on(self.scene, self.view_layer)
        if self.move is not None and (blurs or self.view_layer.use_pass_vector):
            self.motion = motion.Motion(self.depsgraph, self.scene, self.move, not blurs, self.view_layer.use_strand)
            self.motion.record(lambda shown: cameras.window(cameras.settings_of(shown, []), self.scene.render))
        eye, matrix, view = self._eye([])
        self._culling = culling.Culling(self.scene, eye, matrix, view)
        self._instances = object_info.Placed()
        # Also those that collections alone place.
        known = (thing.original for thing in self.depsgraph.ids if isinstance(thing, bpy.types.Object))
        self._links = linking.Linking(known)
        self._light_groups = [group.name for group in self.view_layer.lightgroups]
        worlds.prepare(self._world(), self.cache, self._pixel())
        has_hair = self.view_layer.use_strand and strands.are_in(self.depsgraph)
        told = time.monotonic()
        for count, instance in enumerate(self.depsgraph.object_instances):
            # Whoever is told may stop the export by raising.
            if time.monotonic() - told > TELL_EVERY:
                self.report(f"{count} objects")
                told = time.monotonic()
            # `show_self` is off for instancers that are not shown themselves.
            if instance.show_self:
                self._instance(instance)
            if has_hair:
                self._hair(instance)
        self._write_placed()

    def _instance(self, instance):
        shown = instance.object
        parent = instance.parent if instance.is_instance else None
        key = None
        if parent is not None and shown.type in {"MESH", *STRANDS}:
            # What is shown may be made for the moment, in one place for all that is: what it is made of tells.
            key = shown.original.as_pointer(), shown.data.as_pointer(), parent.as_pointer()
            if key in self._described:
                if not self._culling.leaves_out(shown, instance.matrix_world):
                    self._place(instance, parent, self._described[key])
                return
        described = self._describe(instance, shown, parent)
        if described is not None:
            if key is not None:
                self._described[key] = described
            self._place(instance, parent, described)

    def _describe(self, instance, shown, parent):
        """What is the same of all instances of an object that one other shows; None if it is no mesh or none to be rendered."""
        kind = shown.type
        if kind == "LIGHT":
            self._light(instance, shown)
            return None
        if kind == "VOLUME" and self._is_switched_off(kind):
            return None
        if kind == "CURVES" and self._is_switched_off(kind):
            return None
        if kind in GREASE_PENCIL:
            # Before 4.3 view layers had no switch for it.
            if getattr(self.view_layer, "use_grease_pencil", True):
                self.verdicts.add("object", shown.name, EXACT, "Blender draws its Grease Pencil over the picture, as over Cycles'")
            return None
        if kind not in {"MESH", "VOLUME", *STRANDS}:
            # Curves, surfaces, texts and metaballs come a second time, as the meshes they amount to.
            return None
        if self._culling.leaves_out(shown, instance.matrix_world):
            return None
        if kind == "MESH" and not self.view_layer.use_solid:
            # As Cycles: lamps and the world stay.
            return None
        mesh = self._strands(shown, kind) if kind in STRANDS else self._mesh(shown)
        if mesh is None:
            return None
        if kind == "MESH" and abs(getattr(shown, "shadow_terminator_geometry_offset", 0.1) - 0.1) > 1e-6:
            self.verdicts.add("object", shown.name, APPROXIMATED, "its Shadow Terminator is as by default: Geometry Offset 0.1")
        return self._described_with(mesh, shown, parent)

    def _described_with(self, mesh, shown, parent):
        """An object's glTF mesh with what all of its instances have."""
        extension = visibility.sundog_object([shown, parent], self.view_layer)
        self.verdicts.extend("object", shown.name, self._links.findings.get(shown.name_full, []), untouched=False)
        own = {**self._links.shining(shown), **self._links.lit(shown, parent)}
        offset = getattr(shown, "shadow_terminator_shading_offset", 0.0)
        if offset > 0:
            own["shading_offset"] = float(offset)
        if self._replaces and (reach := fast_gi.distance_of([shown, parent])):
            own["fast_gi_distance"] = reach
        if own:
            extension = {**(extension or {}), **own}
        extension = self._labelled(shown, extension)
        described = _Described(shown.name, mesh, _owner(shown), extension)
        if mesh not in self._informed and not self._asked.get(mesh) and self.motion is None:
            described.place = self._placed.setdefault((mesh, str(extension), described.owner), _Place(extension))
        return described

    def _place(self, instance, parent, described):
        """Puts an instance where it stands, with what is its own."""
        if described.place is not None:
            described.place.add(described.name, instance)
            return
        name, mesh, extension = described.name, described.mesh, described.extension
        if mesh in self._informed:
            extension = {**object_info.describe(instance), **(extension or {})}
        asked = self._asked.get(mesh)
        if asked:
            told = object_info.values(instance, self.scene, self.materials.values[: max(asked) + 1], asked, self._instances)
            extension = {**(extension or {}), "values": told}
            if parent is not None and object_info.Placed.misses(parent, [self.materials.values[number] for number in asked]):
                self.verdicts.add("object", name, APPROXIMATED, "attributes of instances are 0: Blender tells of them from 4.5 on")
        moving = self.motion.of(instance) if self.motion is not None else None
        if moving is not None:
            extension = {**(extension or {}), "motion": [node_matrix(matrix) for matrix in moving]}
            self._add_object(name, mesh, node_matrix(instance.matrix_world), extension)
            return
        self._placed.setdefault((mesh, str(extension), described.owner), _Place(extension)).add(name, instance)

    def _labelled(self, shown, extension):
        """The SUNDOG_object with what passes tell of the object."""
        told = {}
        if self.view_layer.use_pass_object_index and shown.pass_index:
            told["pass_index"] = shown.pass_index
        if self.view_layer.use_pass_cryptomatte_asset and shown.parent is not None:
            top = shown.parent
            while top.parent is not None:
                top = top.parent
            told["asset"] = top.name
        return {**(extension or {}), **told, **self._grouped(shown)} or None

    def _grouped(self, thing):
        """The light group of an object or a world, if the view layer has it."""
        group = getattr(thing, "lightgroup", "")
        return {"light_group": group} if group in self._light_groups else {}

    def _is_switched_off(self, kind):
        """Whether the view layer leaves out all of a kind."""
        switch = {"VOLUME": "use_volumes", "CURVES": "use_strand"}.get(kind)
        return switch is not None and not getattr(self.view_layer, switch, True)

    def _casts_caustics(self, light):
        """Whether Cycles looks for the ways of a light through what is marked for that."""
        def has(switch):
            return any(getattr(getattr(thing, "cycles", None), switch, False) for thing in self.scene.objects)
        asked = getattr(getattr(light, "cycles", None), "is_caustics_light", False)
        return asked and has("is_caustics_caster") and has("is_caustics_receiver")

    def _hair(self, instance):
        """The hair of an instance's particles, where it stands."""
        shown = strands.hairy(instance, self.depsgraph)
        if shown is None or self._culling.leaves_out(shown, instance.matrix_world):
            return
        parent = instance.parent if instance.is_instance else None
        key = "HAIR", shown.original.as_pointer(), parent and parent.as_pointer()
        if key not in self._described:
            mesh = self._strands(shown, "HAIR")
            self._described[key] = None if mesh is None else self._described_with(mesh, shown, parent)
        if self._described[key] is not None:
            self._place(instance, parent, self._described[key])

    # Meshes

    def _mesh(self, shown):
        """Index of the glTF mesh of an evaluated object, or None."""
        mesh = shown.data
        slots = self._slots(shown)
        domain = grids.domain_of(shown) if shown.type == "MESH" else None
        if domain is not None and self._is_switched_off("VOLUME"):
            return None
        key = (mesh.as_pointer(), tuple(m.original.as_pointer() if m is not None else 0 for m in slots))
        if key not in self._meshes:
            filled = shown.type == "VOLUME" or domain is not None
            read = self._read_filled if filled else self._read_mesh
            self._meshes[key] = read(shown, slots)
        return self._meshes[key]

    def _slots(self, shown):
        """The materials of an evaluated object, with what the view layer shows instead."""
        slots = [_material_of(shown, number, slot) for number, slot in enumerate(shown.material_slots)] or list(shown.data.materials)
        override = self._override("material")
        return [override] * max(len(slots), 1) if override is not None else slots or [None]

    def _strands(self, shown, kind):
        """Index of the glTF mesh of an object's strands or points, or None; `kind` as in `strands.of_object`."""
        slots = self._slots(shown)
        owner = shown.original if kind == "HAIR" else shown.data
        key = (kind, owner.as_pointer(), tuple(m.original.as_pointer() if m is not None else 0 for m in slots))
        if key not in self._meshes:
            self._meshes[key] = None
            what = "it" if kind != "HAIR" else "its hair"
            try:
                parts = strands.of_object(shown, kind, len(slots), self.depsgraph)
                if parts:
                    self._meshes[key] = self._write_strands(parts, slots, shown, kind)
            except geometry.GeometryError as error:
                self.verdicts.add("object", shown.name, LOST, f"{what} is left out: {error}")
            except MemoryError:
                self.verdicts.add("object", shown.name, LOST, f"{what} is left out: there is not enough memory for it")
        return self._meshes[key]

    def _write_strands(self, parts, slots, shown, kind):
        if self.motion is not None:
            findings = []
            self.motion.of_strands(shown, kind, parts, findings)
            self.verdicts.extend("object", shown.name, findings, untouched=False)
        exported = {part.slot: self._exported(slots[part.slot]) for part in parts}
        stored = strands.store(parts, {slot: material.demand for slot, material in exported.items()}, self.cache)
        self.changed_geometry += stored.written
        look, primitives = strands.look(self.scene), self._primitives(stored, exported)
        for primitive, part in zip(primitives, parts):
            described = part.described(look, exported[part.slot].demand.generated)
            if part.steps:
                described["motion"] = [_step(primitive["attributes"], number) for number in range(len(part.steps))]
            primitive["mode"] = 0 if part.counts is None else 1
            primitive["extensions"] = {self.document.uses("SUNDOG_mesh"): described}
        return self._add_mesh(shown.data.name, primitives, exported)

    def _read_filled(self, shown, slots):
        """A box with the grids of a Volume object or a domain of smoke."""
        findings = []
        domain = grids.domain_of(shown) if shown.type == "MESH" else None
        if domain is None:
            filled = grids.of_volume(shown, self.cache, findings)
        else:
            filled = grids.of_domain(shown, domain, shown.data, self.scene, self.cache)
        self.verdicts.extend("object", shown.name, [Finding(*f, "media") for f in findings], untouched=False)
        if filled is None:
            return None
        box = grids.box_mesh(filled)
        try:
            # Cycles takes the first material alone.
            return self._write_mesh(box, slots[:1], shown.name, (None, None), filled)
        except geometry.GeometryError as error:
            self.verdicts.add("object", shown.name, LOST, f"it is left out: {error}")
            return None
        finally:
            bpy.data.meshes.remove(box)

    def _dicing(self, shown):
        """How the object's triangles are divided by their size in the picture; None if they are not."""
        modifier = dicing.modifier_of(shown, self.scene)
        if modifier is None:
            return None
        found = dicing.Dicing(shown, modifier, self.scene, cameras.picture_size(self.scene.render), self.depsgraph.mode == "VIEWPORT")
        if not found:
            return None
        if modifier.subdivision_type == "CATMULL_CLARK" and not (modifier.levels if found.preview else modifier.render_levels):
            words = "its adaptive subdivision is approximated: its modifier's own levels, from which it goes on, are 0, so that nothing is rounded"
            self.verdicts.add("object", shown.name, APPROXIMATED, words)
        return found

    def _override(self, kind):
        """What the view layer shows instead of every material, or of the world; None if it doesn't."""
        found = getattr(self.view_layer, f"{kind}_override", None)
        return None if found is None else found.evaluated_get(self.depsgraph)

    def _read_mesh(self, shown, slots):
        try:
            diced = self._dicing(shown)
            findings = modifiers.findings(shown)
            steps = self.motion.of_mesh(shown, findings) if self.motion else None
            self.verdicts.extend("object", shown.name, findings, untouched=False)
            with geometry.readable(shown) as mesh:
                return self._write_mesh(mesh, slots, shown.name, (diced, steps))
        except geometry.GeometryError as error:
            self.verdicts.add("object", shown.name, LOST, f"it is left out: {error}")
        except MemoryError:
            self.verdicts.add("object", shown.name, LOST, "it is left out: there is not enough memory for it")
        return None

    def _write_mesh(self, mesh, slots, name_of_object, changes, filled=None):
        diced, steps = changes
        if not len(mesh.polygons):
            return None
        used = geometry.slots_in_use(mesh, len(slots))
        names = None if filled is None else filled.names
        exported = {slot: self._exported(slots[slot], names) for slot in used}
        stored = geometry.store(mesh, {slot: material.demand for slot, material in exported.items()}, self.cache, diced, steps)
        if stored is None:
            return None
        if stored.layout.get("enlarged", 1) > 1:
            words = f"its adaptive subdivision is approximated: its triangles are {stored.layout['enlarged']:.3g} times as large, so that they are not more than {dicing.MOST}"
            self.verdicts.add("object", name_of_object, APPROXIMATED, words)
        self.changed_geometry += stored.written
        primitives = self._primitives(stored, exported)
        generated = [p for p, q in zip(primitives, stored.layout["primitives"]) if exported[q["slot"]].demand.generated]
        for primitive in generated:
            if "_GENERATED" in primitive["attributes"]:
                described = {"generated": "_GENERATED"}
            else:
                described = {"texture_space": geometry.texture_space(mesh)}
            primitive["extensions"] = {self.document.uses("SUNDOG_mesh"): described}
        for primitive in primitives if filled is not None else ():
            described = {"texture_space": filled.space, **filled.described(self.document, self.materials.grids)}
            primitive["extensions"] = {self.document.uses("SUNDOG_mesh"): described}
        for primitive in primitives:
            if "_VERTEX" in primitive["attributes"]:
                self._own_part(primitive)["vertices"] = "_VERTEX"
            if "_VERTEX_NORMAL" in primitive["attributes"]:
                self._own_part(primitive)["vertex_normals"] = "_VERTEX_NORMAL"
        for primitive, found in zip(primitives, stored.layout["primitives"]):
            absent = geometry.absent_uvs(mesh, exported[found["slot"]].demand)
            if absent:
                self._own_part(primitive)["absent_uvs"] = absent
        for primitive in primitives if steps else ():
            self._own_part(primitive)["motion"] = [_step(primitive["attributes"], number) for number in range(len(steps))]
        return self._add_mesh(mesh.name, primitives, exported)

    def _exported(self, material, grids_of=None):
        """A material as it is written, with what is told of it."""
        exported = self.materials.material(material, grids_of)
        if material is not None:
            self.verdicts.extend("material", material.name_full, exported.findings)
        return exported

    def _own_part(self, primitive):
        """SUNDOG_mesh of a primitive, which may have some of it."""
        return primitive.setdefault("extensions", {}).setdefault(self.document.uses("SUNDOG_mesh"), {})

    def _primitives(self, stored, exported):
        """The primitives of what is in a file of the cache. `exported`: the materials by slot."""
        if stored.path not in self._buffers:
            self._buffers[stored.path] = self.document.add_buffer(stored.path, stored.layout)
        accessors = self._buffers[stored.path]
        return [
            {
                "attributes": {name: accessors[i] for name, i in primitive["attributes"].items()},
                "indices": accessors[primitive["indices"]],
                "material": exported[primitive["slot"]].index,
            }
            for primitive in stored.layout["primitives"]
        ]

    def _add_mesh(self, name, primitives, exported):
        """Index of a glTF mesh, and what its materials ask of objects."""
        index = self.document.shared("meshes", {"name": name, "primitives": primitives})
        if any(material.informed for material in exported.values()):
            self._informed.add(index)
        self._asked[index] = set().union(*(material.values for material in exported.values()))
        return index

    def _by_sharing(self):
        """(mesh, places) of all objects. Of equal meshes the file has one; what Cycles has one for alone says so."""
        users, owners = collections.Counter(), collections.defaultdict(set)
        for (mesh, _, owner), place in self._placed.items():
            users[mesh, owner] += len(place.names)
            owners[mesh].add(owner)
        joined = {}
        for (mesh, words, owner), place in self._placed.items():
            is_own = len(owners[mesh]) > 1 and users[mesh, owner] == 1
            key = mesh, words, is_own
            if key in joined:
                joined[key].extend(place)
                continue
            if is_own:
                place.extension = {**(place.extension or {}), "own_mesh": True}
            joined[key] = place
        return [(mesh, place) for (mesh, _, _), place in joined.items()]

    def _write_placed(self):
        for mesh, place in self._by_sharing():
            extension, names = place.extension, place.names
            if len(names) == 1 and not self._shines(mesh) and all(map(math.isfinite, place.matrices)):
                # Most of those that have something of their own.
                self._add_object(names[0], mesh, place.only(), extension)
                continue
            matrices = numpy.array(place.matrices, float).reshape(-1, 4, 4)
            finite = numpy.isfinite(matrices).all(axis=(1, 2))
            for index in numpy.nonzero(~finite)[0]:
                self.verdicts.add("object", names[index], LOST, "it is left out: its place is not a number")
            matrices, names = matrices[finite], [n for n, keep in zip(names, finite) if keep]
            self._tell_of_twins(mesh, names, matrices)
            rest = numpy.arange(len(matrices))
            if len(matrices) >= INSTANCING_FROM:
                rest = self._write_copies(mesh, extension, names[0], matrices)
            turned = (TO_GLTF @ matrices[rest]).transpose(0, 2, 1).reshape(-1, 16).tolist()
            for index, matrix in zip(rest, turned):
                self._add_object(names[index], mesh, matrix, extension)

    def _shines(self, mesh):
        """Whether a mesh has a material that emits."""
        if mesh not in self._emits:
            parts = self.document.root["meshes"][mesh]["primitives"]
            materials = [self.document.root["materials"][part["material"]] for part in parts if "material" in part]
            self._emits[mesh] = any("emissiveFactor" in material for material in materials)
        return self._emits[mesh]

    def _tell_of_twins(self, mesh, names, matrices):
        """What shines and stands in the place of another gives other light in Cycles, by rounding: a quarter of one's, or more than that."""
        if not self._shines(mesh):
            return
        seen = self._shining.setdefault(mesh, {})
        for name, matrix in zip(names, matrices):
            before = seen.setdefault(matrix.tobytes(), name)
            if before is not name:
                words = f'it shines and stands in the place of "{before}": both shine as one, where rounding decides in Cycles how much light they give'
                self.verdicts.add("object", name, APPROXIMATED, words)

    def _add_object(self, name, mesh, matrix, extension):
        node = {"name": name, "mesh": mesh, "matrix": matrix}
        if extension:
            node["extensions"] = {self.document.uses("SUNDOG_object"): extension}
        self.document.add_node(node)

    def _write_copies(self, mesh, extension, name, matrices):
        """Writes copies as arrays; returns the numbers of those that are not exact enough so (sheared ones)."""
        translation, rotation, scale, exact = decomposed.decompose(matrices)
        if exact.sum() < INSTANCING_FROM:
            return numpy.arange(len(matrices))
        arrays = [numpy.ascontiguousarray(a[exact], numpy.float32) for a in (translation, rotation, scale)]
        digest = hashlib.blake2b(b"".join(a.tobytes() for a in arrays), digest_size=16).hexdigest()
        path = os.path.join(self.cache, f"copies-{digest}.bin")
        parts, layout = gltf.describe_arrays([(a, ()) for a in arrays])
        if not os.path.isfile(path) or os.path.getsize(path) != layout["bytes"]:
            gltf.write_whole(path, parts)
        accessors = self.document.add_buffer(path, layout)
        attributes = dict(zip(("TRANSLATION", "ROTATION", "SCALE"), accessors))
        node = {
            "name": name,
            "mesh": mesh,
            "matrix": TO_GLTF.T.reshape(-1).tolist(),
            "extensions": {self.document.uses("EXT_mesh_gpu_instancing"): {"attributes": attributes}},
        }
        if extension:
            node["extensions"][self.document.uses("SUNDOG_object")] = extension
        self.document.add_node(node)
        return numpy.nonzero(~exact)[0]

    # Lights

    def _light(self, instance, shown):
        light = shown.data
        findings = []
        if lights.is_portal(light):
            self.verdicts.extend("light", shown.name, findings)
            described = lights.describe_portal(light, shown.name)
            node = {"name": shown.name, "matrix": node_matrix(instance.matrix_world)}
            self.document.add_node({**node, "extensions": {self.document.uses("SUNDOG_light"): described}})
            return
        lamp = object_info.Lamp(instance, self.scene, self._instances, self.materials.layer)
        described = lights.describe(light, findings, self.document, self.cache, lamp)
        parent = instance.parent if instance.is_instance else None
        seen = lights.ray_visibility(light, [shown, parent])
        if visibility.shower([shown, parent]).original.indirect_only_get(view_layer=self.view_layer):
            seen["camera"] = False
        if seen:
            described["visibility"] = seen
        described.update(self._grouped(shown))
        described.update(self._links.shining(shown))
        if not shown.is_shadow_catcher:
            # It does not shine in the photograph that catchers stand for.
            described["shadow_catcher"] = False
        if described.get("type") == "area" and lights.is_sheared(instance.matrix_world):
            findings.append((APPROXIMATED, "its parents shear it: it is rendered so, where Cycles mixes two other outlines"))
        if described.get("type") == "area" and self._planes.add(described, instance.matrix_world):
            words = "it overlaps another one in its plane: rays find but one of them, as in Cycles, where rounding decides which"
            findings.append((APPROXIMATED, words))
        if self._casts_caustics(light):
            words = "its shadow caustics are found by chance, as those of other lights: with more noise than Cycles' own search"
            findings.append((APPROXIMATED, words))
        self.verdicts.extend("light", shown.name, findings)
        node = {"name": shown.name, "matrix": node_matrix(instance.matrix_world)}
        if described.get("type") == "area":
            described["name"] = shown.name
            node["extensions"] = {self.document.uses("SUNDOG_light"): described}
        else:
            punctual = lights.punctual(light, described)
            punctual["extensions"] = {self.document.uses("SUNDOG_light"): described}
            index = self._light_index(punctual)
            node["extensions"] = {self.document.uses("KHR_lights_punctual"): {"light": index}}
        self.document.add_node(node)

    def _light_index(self, punctual):
        extension = self.document.root.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})
        if punctual not in extension["lights"]:
            extension["lights"].append(punctual)
        return extension["lights"].index(punctual)

    # Camera, world, colours

    def _eye(self, findings):
        """What the scene looks through: settings, unscaled place, window."""
        shown = self.scene.camera.evaluated_get(self.depsgraph)
        eye = cameras.settings_of(shown, findings)
        return eye, cameras.without_scale(shown.matrix_world), cameras.window(eye, self.scene.render)

    def camera(self):
        """The scene's camera; those of the views of stereo, in their order."""
        for view in self.views or [None]:
            self._camera(view)

    def _camera(self, view):
        name, findings = self.scene.camera.name, []
        eye, matrix, _ = self._eye(findings)
        if view is not None:
            name = view.shown.name
            eye = views.Shifted(cameras.settings_of(view.shown, findings), view.shift_x)
            matrix = cameras.without_scale(view.matrix)
        extension, plain = cameras.describe(
            eye, matrix, self.scene.render, findings, lambda o: o.evaluated_get(self.depsgraph)
        )
        stereo = view and views.eye(view, eye, findings)
        if stereo and "panorama" in extension:
            extension["panorama"]["stereo"] = stereo
        elif stereo:
            findings.append((LOST, "spherical stereo is of panoramas: both views of this camera are alike"))
        if self.motion is not None:
            moving = self._moving_camera(view, eye, findings)
            if moving is not None:
                extension["motion"] = moving
        self.verdicts.extend("camera", name, findings)
        plain["name"] = name
        plain["extensions"] = {self.document.uses("SUNDOG_camera"): extension}
        index = self.document.add("cameras", plain)
        self.document.add_node({"name": name, "camera": index, "matrix": node_matrix(matrix)})

    def _moving_camera(self, view, eye, findings):
        """SUNDOG_camera's `motion`."""
        beside = numpy.identity(4)
        if view is not None:
            if view.shown.original != self.scene.camera.original:
                findings.append((LOST, "it stands still in its view: of stereo by several cameras the scene's own alone moves"))
                return None
            own = numpy.array(self.scene.camera.evaluated_get(self.depsgraph).matrix_world, float)
            beside = numpy.linalg.inv(own) @ view.matrix
        return self.motion.of_camera(lambda matrix: cameras.without_scale(matrix @ beside), node_matrix, eye.type == "PERSP")

    def restore(self):
        """Brings the depsgraph back to the frame."""
        if self.motion is not None:
            self.motion.restore()

    def _world(self):
        """The view layer's world as the depsgraph has it, seen or not."""
        world = self._override("world") or self.scene.world
        return world and world.evaluated_get(self.depsgraph)

    def world(self):
        """The world and the colour management, as SUNDOG_scene."""
        # As Cycles: it is not seen, and lights nothing.
        world = self._world() if self.view_layer.use_sky else None
        findings = []
        extension = {}
        try:
            extension["world"] = worlds.describe(world, self.cache, self.document, findings, self.report, self._pixel(), layer=self.materials.layer)
        except (images.ImageError, RecursionError) as error:
            findings.append((LOST, f"it is rendered black: {error}"))
            extension["world"] = {"color": [0.0, 0.0, 0.0]}
        if world is not None:
            self._aovs(world, extension["world"], findings)
            self.verdicts.extend("world", world.name, findings)
            extension["world"].update(self._grouped(world))
        if self._fast_gi is not None:
            extension["fast_gi"] = self._fast_gi
        limit = texture_limit(self.scene)
        if limit:
            extension["texture_limit"] = limit
        if self._light_groups:
            extension["light_groups"] = self._light_groups
        space = colorspace.working_space()
        if space != colorspace.REC709:
            extension["working_space"] = space
        if colorspace.unknown():
            words = f"its working space \"{colorspace.unknown()}\" is not known: its colours are taken as {colorspace.REC709}"
            self.verdicts.add("scene", self.scene.name, LOST, words)
        extension["color_management"] = color_management(self.scene)
        extension["render"] = render_settings(self.scene)
        if self.materials.aovs:
            extension["aovs"] = [{"name": name, "type": kind} for name, kind in self.materials.aovs.items()]
        shutter = self.motion.shutter() if self.motion else None
        if shutter:
            extension["shutter"] = shutter
        top = self.document.root["scenes"][0]
        top["name"] = self.scene.name
        top["extensions"] = {self.document.uses("SUNDOG_scene"): extension}

    def _aovs(self, world, described, findings):
        """What the world tells AOVs: in Cycles only one that is not the same everywhere, where it is shown."""
        is_constant = "image" not in described and "shader_graph" not in described
        if is_constant or (self.scene.render.film_transparent and not self.view_layer.use_pass_environment):
            return
        walk = graph_write.aovs_of(world, self.materials.aovs, findings, evaluated.WORLD)
        if walk is not None:
            writer = graph_write.GraphWriter(self.document, self.cache, [], None, {}, self.report)
            described["aovs"] = writer.write(None, world, walk).aovs

    def _pixel(self):
        """Radians that a pixel of the picture sees of the world; None for parallel rays."""
        data = self.scene.camera.data
        across = {"PERSP": lambda: data.angle, "PANO": lambda: 2 * numpy.pi}.get(getattr(data, "type", None))
        return across() / max(cameras.picture_size(self.scene.render)) if across else None

    def finish(self):
        """Writes the .gltf."""
        self.document.write(self.path)


def _step(attributes, number):
    """The attributes of a step of a mesh's motion."""
    position, normal = f"_POSITION_{number}", f"_NORMAL_{number}"
    if position not in attributes:
        position, normal = "POSITION", "NORMAL"
    return {"position": position, **({"normal": normal} if normal in attributes else {})}


def color_management(scene):
    """The scene's display, view and look by OpenColorIO's names."""
    view = scene.view_settings
    result = {
        "display": scene.display_settings.display_device,
        "view": view.view_transform,
        "look": view.look,
        "exposure": float(view.exposure),
        "gamma": float(view.gamma),
    }
    config = os.path.join(bpy.utils.resource_path("LOCAL"), "datafiles", "colormanagement", "config.ocio")
    if os.environ.get("OCIO"):
        config = os.environ["OCIO"]
    if os.path.isfile(config):
        result["config"] = config
    return result


def texture_limit(scene):
    """How large images may be, by Simplify; empty if there is no limit."""
    cycles = getattr(scene, "cycles", None)
    if cycles is None or not scene.render.use_simplify:
        return {}
    result = {}
    # From 5.2 on.
    resolution = getattr(cycles, "texture_resolution_render", 1.0)
    if resolution < 1:
        result["resolution"] = float(resolution)
    if cycles.texture_limit_render != "OFF":
        result["size"] = int(cycles.texture_limit_render)
    return result


def render_settings(scene):
    """What a render of the scene without further words is like."""
    width, height = cameras.picture_size(scene.render)
    result = {"width": width, "height": height, "transparent": bool(scene.render.film_transparent)}
    cycles = getattr(scene, "cycles", None)
    if cycles is not None and cycles.pixel_filter_type != "BOX":
        result["filter_width"] = float(cycles.filter_width)
    # Of the engine that the scene is rendered with.
    own = scene.sundog if scene.render.engine == "SUNDOG" else cycles
    if own is not None and scene.render.film_transparent and own.film_transparent_glass:
        result["transparent_glass"] = float(own.film_transparent_roughness)
    if own is not None and own.film_exposure != 1:
        result["film_exposure"] = float(own.film_exposure)
    return result
