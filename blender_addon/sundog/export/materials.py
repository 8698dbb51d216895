# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: Blender's shader trees as glTF's metallic-roughness with the KHR and SUNDOG extensions.

The exporter of File > Export reads materials too, but makes and removes images in the open file and
finds materials and images by bare names (which linked libraries repeat): neither is allowed in a
render thread. It also takes the nearest image of a tree whatever lies between. So the trees are read
here, and what is not exact is told.
"""

import functools
import math

import bpy
import numpy

from . import geometry, graph, graph_write, images, nodes, volumes
from .expressions import Const, Image, Operation
from .shaders import Reader, Surface
from .slots import Slots
from .verdicts import APPROXIMATED, EXACT, LOST, Finding

# What SUNDOG_material has and the program renders from node trees alone: the id of the effect, and what it is called.
UNRENDERED = {
    "subsurface": ("subsurface", "subsurface scattering"),
}


# Pixels along a side of textures that are made for a material beside whose node tree they stand: who reads the tree has no use for
# them, and of an image of 16384 × 8192 they took minutes.
STAND_IN = 1024

# Modifiers that make another mesh, which may have no UV map.
REMADE = {"NODES", "OCEAN", "REMESH", "SKIN", "VOLUME_TO_MESH"}


class Exported:
    """A glTF material: index in the document, what it needs of meshes, findings, whether it reads what Object Info tells, and
    the numbers of the values that it reads of objects."""

    def __init__(self, index, demand, findings, informed=False, values=()):
        self.index, self.demand, self.findings, self.informed, self.values = index, demand, findings, informed, values


class Writer:
    """Writes materials into a document, each Blender material once."""

    def __init__(self, document, cache, blender_version):
        self.document, self.cache = document, cache
        self.walker = nodes.Walker()
        self.version = blender_version
        # What node trees ask of objects, by number (object_info.asked).
        self.values = []
        # The scene and the view layer whose attributes node trees read.
        self.layer = None
        # UV maps that each material has before its own.
        self.first_uvs = []
        # Whether the pass of their numbers is asked for.
        self.writes_indices = False
        # The kinds of the view layer's AOVs by their names.
        self.aovs = {}
        # Whether standard materials beside node trees show their images, for programs that do not read trees.
        self.stand_ins = True
        # Names of the grids that node trees read of what fills objects, by number.
        self.grids = []
        self._known = {}

    def material(self, material, grids=None):
        """The Exported of an evaluated material, or of no material at all; `grids` has the names of those of an object that is
        filled by it."""
        key = (material.original.as_pointer() if material is not None else None, None if grids is None else tuple(sorted(grids)))
        if key not in self._known:
            self._known[key] = self._write(material, grids)
        return self._known[key]

    def _write(self, material, grids, walker=None):
        if material is None and grids is not None:
            # What Cycles fills volumes with that have no material.
            material = bpy.data.materials.new("(no material)")
            try:
                material.use_nodes = True
                tree = material.node_tree
                tree.nodes.clear()
                shader, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("VolumePrincipled", "OutputMaterial"))
                tree.links.new(shader.outputs[0], output.inputs["Volume"])
                # With a walker of its own: the tree's address may be another's later.
                return self._write(material, grids, nodes.Walker())
            finally:
                bpy.data.materials.remove(material)
        reader = Reader(walker or self.walker)
        if grids is not None:
            cubic = getattr(getattr(material, "cycles", None), "volume_interpolation", "LINEAR") == "CUBIC"
            reader.grids = graph_write.GridReads(frozenset(grids), self.grids, cubic)
        if material is None:
            grey = Const(numpy.full(3, 0.8))
            # What Cycles shows without a material: diffuse up to 4.5, a Principled BSDF from 5.0.
            if self.version < (5, 0, 0):
                surface = Surface(base_color=grey)
            else:
                surface = Surface(base_color=grey, roughness=Const(0.5), ior=Const(1.5))
            return self._build("(no material)", surface, reader)
        try:
            surface = reader.read(material)
            return self._build(material.name, surface, reader, material)
        except (images.ImageError, RecursionError, KeyError, IndexError, AttributeError, TypeError, ValueError) as error:
            reader.note(LOST, f"it is rendered grey: {error}")
            return self._build(material.name, Surface(base_color=Const(numpy.full(3, 0.8))), reader, material)

    def _build(self, name, surface, reader, material=None, alone=False):
        """`alone`: no node tree stands beside it."""
        side = STAND_IN if self.stand_ins else 0
        slots = Slots(self, reader, self.first_uvs, None if alone else side)
        before = list(reader.findings), list(reader.lasting), reader.volume
        pbr, extensions, exact = {}, {}, {"thin_walled": surface.thin_walled}
        result = {"name": name, "doubleSided": True, "pbrMetallicRoughness": pbr}

        alpha = surface.alpha
        mask = _mask(alpha)
        if mask is not None:
            alpha, cutoff = mask
            result["alphaMode"], result["alphaCutoff"] = "MASK", cutoff
        elif not (isinstance(alpha, Const) and alpha.value >= 1):
            result["alphaMode"] = "BLEND"
        base, factor, texture, color = slots.color_and_alpha(surface.base_color, alpha)
        clamped = [min(max(float(v), 0.0), 1.0) for v in factor]
        if clamped != [float(v) for v in factor]:
            exact["base_color"] = [max(float(v), 0.0) for v in factor[:3]]
        pbr["baseColorFactor"] = clamped
        if texture:
            pbr["baseColorTexture"] = texture

        metallic, roughness, texture = slots.metallic_roughness(surface.metallic, surface.roughness)
        pbr["metallicFactor"], pbr["roughnessFactor"] = metallic, roughness
        if texture:
            pbr["metallicRoughnessTexture"] = texture

        self._emission(surface, slots, result, extensions, reader)
        self._specular(surface, slots, extensions, exact, reader)

        transmission, texture = slots.single(surface.transmission, 0, "transmission")
        if transmission:
            extensions["KHR_materials_transmission"] = {"transmissionFactor": min(transmission, 1.0)}
            if texture:
                extensions["KHR_materials_transmission"]["transmissionTexture"] = texture

        if surface.normal is not None:
            color_of_normals, strength = surface.normal
            texture = slots.normal(color_of_normals)
            if texture:
                result["normalTexture"] = {**texture, "scale": strength}

        others = dict(surface.others)
        if "anisotropy" in others:
            others["anisotropy"] = self._anisotropy(others["anisotropy"], surface, slots, reader)
        for key, value in others.items():
            exact[key] = value
            if key == "thin_film" and self.version < (5, 0, 0):
                reader.note(APPROXIMATED, graph_write.OLD_FILM, "thin-film")
            if key in UNRENDERED:
                effect, words = UNRENDERED[key]
                reader.note(LOST, f"{words} is rendered from node trees alone", effect)
        if self.writes_indices and material is not None and material.pass_index:
            exact["pass_index"] = material.pass_index
        settings = getattr(material, "sundog", None)
        if settings is not None and settings.use_priority:
            exact["priority"] = settings.priority
        filled = None
        if isinstance(reader.volume, volumes.Varying):
            place = (self.document, self.cache, self.values)
            reader.volume, filled = reader.volume.described(material, reader, place, self.layer)
        if reader.volume is not None:
            exact["volume"] = reader.volume
        extensions["SUNDOG_material"] = exact
        width = 4 if any(a.alpha for a in slots.attributes) else 3
        color = slots.attribute_name()
        is_closed = "alphaMode" in result and graph.casts_whole_shadows(material)
        # A normal map of glTF's has nothing below the surface, and what is flat has no shadows of its own.
        is_told = slots.is_unlike or surface.normal is not None or is_closed
        # Nor has what is flat tangents about a sphere.
        is_told |= "uv_set" in others.get("anisotropy", {}) and material is not None and material.original in self._bare
        written = self._graph(material, reader, slots.uvs, None if color is None else (color, width), is_told)
        is_flat = written is None or not written.extension
        if is_flat and slots.reduced:
            # No node tree stands beside it: it is what is rendered.
            reader.findings, reader.lasting, reader.volume = before
            return self._build(name, surface, reader, material, alone=True)
        if is_flat and slots.is_unlike and graph.ENABLED and all(f.verdict == EXACT for f in reader.findings):
            reader.note(APPROXIMATED, "textures are made of its nodes texel by texel: what lies between texels differs from Cycles")
        if is_flat and is_closed:
            reader.note(APPROXIMATED, "its shadows are as light as it is, for all that its Transparent Shadows are off")
        written = written or graph_write.Written()
        if written.extension:
            extensions["SUNDOG_shader_graph"] = written.extension
            for key in UNRENDERED:
                exact.pop(key, None)
        if written.aovs:
            exact["aovs"] = written.aovs
        result["extensions"] = {self.document.uses(k): v for k, v in extensions.items()}
        index = self.document.shared("materials", result)
        radial = "anisotropy" in others and "tangent" not in others["anisotropy"]
        asked = written.generated or radial, written.vertices, written.curve_normals
        demand = geometry.Demand(slots.uvs, color, width, written.attributes, *asked)
        informed, values = written.informed, written.values
        if filled is not None:
            informed, values = informed or filled.informed, values | filled.values
        return Exported(index, demand, reader.findings, informed, values)

    @functools.cached_property
    def _bare(self):
        """Materials of meshes that have no UV map, or may have none once their modifiers have made other meshes of them."""

        def may_be(thing):
            return not getattr(thing.data, "uv_layers", None) or any(m.type in REMADE for m in thing.modifiers)

        bare = [thing for thing in bpy.data.objects if thing.type in {"MESH", "META"} and may_be(thing)]
        found = {slot.material for thing in bare for slot in thing.material_slots if slot.material is not None}
        return found | _set_by_nodes()

    def _graph(self, material, reader, uvs, color, is_told):
        """The Written of a material's node tree, if that says more than the flattened material (it does where `is_told`);
        replaces the findings then."""
        if not graph.ENABLED or material is None or nodes.tree_of(material) is None:
            return None
        is_bare = material.original in self._bare
        if is_bare and any(node.bl_idname == "ShaderNodeNormalMap" for node in nodes.tree_of(material).nodes):
            reader.note(APPROXIMATED, "the normal map has no tangents where meshes have no UV map")
        flat = all(f.verdict == EXACT for f in reader.findings) and not is_told
        lost = []
        aovs = graph_write.aovs_of(material, self.aovs, lost, layer=self.layer)
        reader.findings += lost
        reader.lasting += lost
        if flat and aovs is None:
            return None
        before = list(uvs)
        try:
            walk = None
            if not flat:
                walk = graph.Walk(self.walker, layer=self.layer)
                walk.read(material)
                if walk.objections:
                    reader.note(EXACT, f"its nodes are not evaluated as they are because of: {', '.join(walk.objections)}")
                if walk.objections or walk.surface is None:
                    walk = None
            if walk is None and aovs is None:
                return None
            writer = graph_write.GraphWriter(self.document, self.cache, uvs, color, self.values)
            writer.bare = is_bare
            written = writer.write(walk, material, aovs)
            if walk is None:
                return written
        except (images.ImageError, RecursionError, MemoryError, KeyError, IndexError, AttributeError, TypeError, ValueError) as error:
            uvs[:] = before
            reader.note(EXACT, f"its nodes are not evaluated as they are: {error}")
            return None
        reader.findings = [f for f in reader.findings if f in reader.lasting] + [Finding(*f) for f in written.findings]
        for words in [nodes.CUT] * walk.is_cut + walk.not_finite:
            reader.note(APPROXIMATED, words)
        return written

    @staticmethod
    def _is_plain(metallic):
        return isinstance(metallic, Const) and metallic.value <= 0

    @staticmethod
    def _anisotropy(found, surface, slots, reader):
        """The anisotropy with the number of the UV map that its tangent follows."""
        if "uv_map" not in found:
            return found
        found = dict(found)
        name = found.pop("uv_map")
        if name not in slots.uvs:
            slots.uvs.append(name)
        found["uv_set"] = slots.uvs.index(name)
        of_normals = [leaf.texture.uv for leaf in surface.normal[0].leaves() if isinstance(leaf, Image)] if surface.normal else []
        if any(uv != name for uv in of_normals):
            reader.note(APPROXIMATED, "the tangent follows the normal map's UV map", "anisotropy")
        return found

    def _emission(self, surface, slots, result, extensions, reader):
        factor, texture = slots.color(surface.emission, "emission")
        if min(factor) < 0:
            reader.note(APPROXIMATED, "light of less than nothing is left out")
        factor = [max(float(v), 0.0) for v in factor]
        strength = max(factor)
        if strength <= 0:
            return
        if strength > 1:
            factor = [v / strength for v in factor]
            extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
        result["emissiveFactor"] = factor
        if texture:
            result["emissiveTexture"] = texture

    def _specular(self, surface, slots, extensions, exact, reader):
        ior = slots.constant(surface.ior, "the index of refraction")
        if ior < 1:
            reader.note(APPROXIMATED, "an index of refraction below 1 is rendered as 1")
            ior = 1.0
        # Metal and glass alone do not know the level: Cycles adjusts the index of what lies under them.
        covered = any(isinstance(v, Const) and v.value >= 1 for v in (surface.metallic, surface.transmission))
        level, texture = (0.5, None) if covered else slots.single(surface.specular_level, 3, "specular level")
        specular = {}
        glassy = not (isinstance(surface.transmission, Const) and surface.transmission.value == 0)
        if texture is None and not glassy and level != 0.5:
            # Cycles replaces the index so that the reflectance at normal incidence is as told; glTF's
            # factor would scale the reflectance at grazing angles as well.
            reflectance = min(((ior - 1) / (ior + 1)) ** 2 * 2 * max(level, 0.0), 0.99)
            ior = (1 + math.sqrt(reflectance)) / (1 - math.sqrt(reflectance))
        elif texture is not None or level != 0.5:
            reader.note(APPROXIMATED, "the specular level scales the reflection at grazing angles too")
            specular["specularFactor"] = min(2 * level, 1.0)
            if 2 * level > 1:
                exact["specular"] = 2 * level
            if texture:
                specular["specularTexture"] = texture
        tint, texture = slots.color(surface.specular_tint, "specular tint")
        tint = [max(float(v), 0.0) for v in tint]
        if texture or tint != [1.0, 1.0, 1.0]:
            if not self._is_plain(surface.metallic):
                exact["edge_tint"] = True
            specular["specularColorFactor"] = tint
            if texture:
                specular["specularColorTexture"] = texture
        if specular:
            extensions["KHR_materials_specular"] = specular
        if ior != 1.5:
            extensions["KHR_materials_ior"] = {"ior": ior}


def _set_by_nodes():
    """Materials that geometry nodes may give to meshes, whatever these have of their own."""
    found = set()

    def add(values):
        # Others may have no hash, as rotations.
        found.update(value for value in values if isinstance(value, bpy.types.Material))

    for tree in bpy.data.node_groups:
        if tree.bl_idname == "GeometryNodeTree":
            for node in tree.nodes:
                add([getattr(node, "material", None)])
                add(socket.default_value for socket in node.inputs if socket.type == "MATERIAL")
            add(getattr(item, "default_value", None) for item in tree.interface.items_tree)
    for thing in bpy.data.objects:
        for modifier in thing.modifiers:
            if modifier.type == "NODES":
                add(_values_of(modifier))
    return found


def _values_of(modifier):
    """What a modifier of geometry nodes gives to its tree; from 5.2 on that has properties of its own."""
    if not hasattr(modifier, "properties"):
        return list(modifier.values())
    inputs = getattr(modifier.properties, "inputs", None)
    names = inputs.bl_rna.properties.keys() if inputs is not None else ()
    return [getattr(getattr(inputs, name), "value", None) for name in names if name not in {"rna_type", "name"}]


def _mask(alpha):
    """(alpha, cutoff) where the alpha is 0 or 1 by a threshold, or None."""
    if not isinstance(alpha, Operation):
        return None
    inner = alpha
    flipped = False
    if inner.name == "math SUBTRACT" and isinstance(inner.arguments[0], Const) and inner.arguments[0].value == 1:
        inner, flipped = inner.arguments[1], True
    if not isinstance(inner, Operation):
        return None
    kind = inner.name
    if kind == "math ROUND" and not flipped:
        return inner.arguments[0], 0.5
    if kind == ("math LESS_THAN" if flipped else "math GREATER_THAN") and isinstance(inner.arguments[1], Const):
        return inner.arguments[0], float(inner.arguments[1].value)
    return None
