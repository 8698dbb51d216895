# SPDX-License-Identifier: GPL-3.0-or-later
"""A walked node tree as SUNDOG_shader_graph, and what it asks of meshes and objects."""

import functools
import hashlib
import json
import math
import os

import bpy
import numpy

from . import colorspace, evaluated, geometry, gltf, ies, images, object_info, skies, strands
from .baker import BakeError
from .graph import Link, Walk
from .nodes import CUT, Walker, attribute_read, name_of, not_in_cycles, tree_of
from .stand_ins import TABLE_SIZE, in_other_words, short, table
from .verdicts import APPROXIMATED, EXACT, LOST, Finding

# Outputs that are attributes of vertices, by nodes.
COMPUTED = {**geometry.COMPUTED, **strands.COMPUTED}

# Cycles before 5.0 has other colours, and no films on metals.
OLD_FILM = "the thin film is rendered as Blender 5 does"


class Written:
    """An extension's content, and what it needs: attributes as geometry.Demand has them, generated coordinates, numbers of
    vertices, what Object Info tells, `values` of objects by their numbers; `findings` on what it cannot say."""

    def __init__(self):
        self.extension = {}
        # The graph of what is told to passes of the scene's own, if there is any.
        self.aovs = None
        self.attributes = []
        self.generated = self.informed = self.vertices = self.curve_normals = False
        self.values = set()
        self.findings = []


class GridReads:
    """The grids that a tree may read: `names` of those that there are, all `numbers` (names, to which more is added), and whether
    values between points are found by cubic splines."""

    def __init__(self, names, numbers, cubic):
        self.names, self.numbers, self.cubic = names, numbers, cubic

    def value(self, name, kind, otherwise=0.0, drawn=False):
        """What a node has in `values` for an output that reads a grid."""
        if name not in self.numbers:
            self.numbers.append(name)
        interpolation = "drawn" if drawn else "cubic" if self.cubic else "linear"
        return {"grid": self.numbers.index(name), "kind": kind, "interpolation": interpolation, "otherwise": otherwise}


class GraphWriter:
    """Writes the graph of one material."""

    def __init__(self, document, cache, uvs, color, values, report=None):
        """`uvs`: names of UV maps by their numbers, to which more are added. `color`: name and width of the attribute that
        COLOR_0 holds, or None. `values`: what objects are asked for, by number, to which more is added. `report` is told while
        a sky is computed, and may stop it by raising."""
        self.document, self.cache, self.report = document, cache, report
        self.uvs, self.color, self.values = uvs, color, values
        # Whether some mesh with the material has no UV map, so that Cycles' tangents follow a sphere.
        self.bare = False
        # The GridReads of what is filled by grids.
        self.grids = None
        self.result = Written()
        # Attributes by name: the number of components that some node reads.
        self._widths = {}
        # The output of what stands for a node with one.
        self._renamed = {}

    def write(self, walk, material, aovs=None):
        """The Written of a walk, and of one from AOV Outputs; one of them may be None."""
        for use in [use for each in (walk, aovs) if each is not None for use in each.uses]:
            self._demand(use)
        if walk is not None:
            for use in walk.uses:
                self._tell(use, walk.table is None)
        self.result.attributes = sorted((name, width) for name, width in self._widths.items() if not self._is_color(name))
        if walk is not None:
            self.result.extension = self._surface(walk, material)
        if aovs is not None:
            nodes, link = self._nodes(aovs)
            told = [{"name": name, **link(found)} for name, found in aovs.aovs]
            self.result.aovs = {"blender": list(bpy.app.version), "nodes": nodes, "aovs": told}
        return self.result

    def _nodes(self, walk):
        """The nodes of a walk as they are written, and what says where a link leads among them."""
        nodes, places = [], {}

        def link(found):
            output = {"node": places[found.use], "output": self._renamed.get(found.use, found.output)}
            if found.through is None:
                return output
            # The conversion that a socket on the way makes is a node of its own.
            key = (found.use, found.output, found.through)
            if key not in places:
                if found.through == "RGBA":
                    nodes.append({"type": "ShaderNodeRGBToBW", "inputs": {"Color": output}})
                else:
                    third = [1 / 3] * 3
                    nodes.append({
                        "type": "ShaderNodeVectorMath", "properties": {"operation": "DOT_PRODUCT"},
                        "inputs": {"Vector": output, "Vector_001": third},
                    })  # fmt: skip
                places[key] = len(nodes) - 1
            return {"node": places[key], "output": "Val" if found.through == "RGBA" else "Value"}

        for use in walk.uses:
            inputs = {i: link(v) if isinstance(v, Link) else short(v) for i, v in use.inputs.items()}
            made = in_other_words(use, inputs, self.grids)
            if made is not None:
                first = len(nodes)
                entries, self._renamed[use] = made(first)
                nodes += entries
                places[use] = len(nodes) - 1
                continue
            entry = {"type": use.node.bl_idname}
            if use.node.name:
                entry["name"] = name_of(use.node)
            properties = {**_plain(use.node), **self._properties(use, walk)}
            if properties:
                entry["properties"] = properties
            mapping = getattr(use.node, "texture_mapping", None)
            if not evaluated.is_plain(mapping):
                inputs["Vector"] = _mapped(nodes, inputs.get("Vector"), mapping, properties.get("uv_set"))
            if inputs:
                entry["inputs"] = inputs
            places[use] = len(nodes)
            nodes.append(entry)
        return nodes, link

    def _surface(self, walk, material):
        nodes, link = self._nodes(walk)
        extension = {"blender": list(bpy.app.version), "nodes": nodes, "surface": link(walk.surface)}
        if any(u.node.bl_idname == "ShaderNodeObjectInfo" and "Material Index" in u.outputs for u in walk.uses):
            extension["pass_index"] = material.pass_index
        if walk.displacement is not None:
            extension["displacement"] = link(walk.displacement)
            extension["displacement_method"] = walk.displacement_method
            self.result.vertices = walk.displacement_method != "BUMP"
        return extension

    def write_volume(self, walk):
        """The Written of a walk from a volume."""
        for use in walk.uses:
            self._demand(use)
        nodes, link = self._nodes(walk)
        self.result.extension = {"blender": list(bpy.app.version), "nodes": nodes, "volume": link(walk.volume)}
        return self.result

    def _tell(self, use, is_surface):
        """What of a shader is not rendered as Cycles does."""
        kind, inputs = use.node.bl_idname, use.inputs
        is_principled = kind == "ShaderNodeBsdfPrincipled"
        scatters = is_principled and inputs.get("Subsurface Weight", 0.0) != 0.0
        if scatters and inputs.get("Thin Wall", 0.0):
            if inputs.get("Diffuse Roughness", 0.0) != 0.0:
                self.result.findings.append((APPROXIMATED, "light below the surface of a thin wall is scattered without roughness"))
        if inputs.get("Thin Film Thickness", 0.0) != 0.0 and bpy.app.version < (5, 0, 0):
            self.result.findings.append((APPROXIMATED, OLD_FILM, "thin-film"))
        if kind == "ShaderNodeBevel" and use.node.samples < 8 and is_surface:
            words = "the few rays of a Bevel lie otherwise: its normals differ by about 1 % (8 samples agree)"
            self.result.findings.append((APPROXIMATED, words))

    def _demand(self, use):
        kind, inputs = use.node.bl_idname, use.inputs
        coordinates = (
            (kind in {*evaluated.GENERATED, "ShaderNodeTexSky"} and "Vector" not in inputs)
            or (kind == "ShaderNodeTexCoord" and "Generated" in use.outputs)
            # Tangents about the middle of the object.
            or (kind == "ShaderNodeNewGeometry" and "Tangent" in use.outputs)
            or (kind == "ShaderNodeTangent" and use.node.direction_type == "RADIAL")
            or ("Tangent" not in inputs and any(inputs.get(n, 0.0) != 0.0 for n in ("Anisotropic", "Anisotropy")))
        )
        self.result.generated |= coordinates
        # Elliptic fibres.
        self.result.curve_normals |= inputs.get("Aspect Ratio", 1.0) != 1.0
        self.result.informed |= kind == "ShaderNodeObjectInfo" and bool(use.outputs - {"Location", "Material Index"})
        self._widths.update({COMPUTED[kind, o]: 1 for o in use.outputs if (kind, o) in COMPUTED})
        name = _attribute_of(use.node)
        if name is not None and self.grids is None:
            # Of an attribute with two components Cycles takes the first for its number, and the mean of all others.
            width = 4 if "Alpha" in use.outputs else 1 if use.outputs == {"Fac"} else 3
            self._widths[name] = max(width, self._widths.get(name, 0))

    def _is_color(self, name):
        return self.color is not None and self.color[0] == name and self._widths[name] <= self.color[1]

    def _properties(self, use, walk):
        node, kind = use.node, use.node.bl_idname
        found = {}
        name = _attribute_of(node)
        if name is not None and self.grids is None:
            numbers = [n for n, _ in self.result.attributes]
            found["attribute"] = "COLOR_0" if self._is_color(name) else f"_SUNDOG_{numbers.index(name)}"
        values = self._values(use)
        if values:
            found["values"] = values
        map_name = self._uv_map(use)
        if map_name is not False:
            if map_name not in self.uvs:
                self.uvs.append(map_name)
            found["uv_set"] = self.uvs.index(map_name)
        if kind == "ShaderNodeTexIES":
            found["ies"] = self._ies(node)
        elif kind == "ShaderNodeTexSky":
            found["sky"] = self._sky(node)
        elif kind in {"ShaderNodeTexImage", "ShaderNodeTexEnvironment"}:
            found["image"] = self._image(walk.picture(node), node)
        elif kind == "ShaderNodeTexCoord" and node.object is not None and "Object" in use.outputs:
            inverse = node.object.matrix_world.inverted_safe()
            found["object_matrix"] = [float(v) for row in inverse for v in row]
        elif kind == "ShaderNodeValToRGB":
            found["color_ramp"] = _ramp(node.color_ramp)
        elif hasattr(node, "mapping"):
            found["curves"] = _curves(node.mapping, kind)
        elif kind == "ShaderNodeNormal":
            found["direction"] = short(tuple(node.outputs["Normal"].default_value))
        return found

    def _values(self, use):
        """Outputs that have a value for each vertex or for each object, and where it stands."""
        found = {}
        numbers = [n for n, _ in self.result.attributes]
        for output in sorted(use.outputs):
            name = _grid_of(use.node, output) if self.grids is not None else None
            if name is not None:
                kind = {"Color": "color", "Alpha": "alpha"}.get(output, "vector")
                found[output] = self.grids.value(name, kind)
                continue
            computed = COMPUTED.get((use.node.bl_idname, output))
            if computed is not None:
                found[output] = {"attribute": f"_SUNDOG_{numbers.index(computed)}"}
            asked = object_info.asked(use.node, output)
            if asked is None:
                continue
            if asked not in self.values:
                self.values.append(asked)
            number = self.values.index(asked)
            self.result.values.add(number)
            kind = {"Color": "color", "Alpha": "alpha"}.get(output, "vector")
            found[output] = {"object": number, "kind": kind}
        return found

    def _uv_map(self, use):
        """The name of the UV map that a node reads (None or geometry.OR_SPHERE for the active one); False if it reads none."""
        node, kind = use.node, use.node.bl_idname
        if getattr(node, "from_instancer", False):
            return False
        active_tangents = geometry.OR_SPHERE if self.bare else None
        if kind == "ShaderNodeUVMap":
            return node.uv_map or None
        if kind == "ShaderNodeNormalMap" and node.space == "TANGENT":
            return node.uv_map or active_tangents
        if kind == "ShaderNodeTangent" and node.direction_type == "UV_MAP":
            return node.uv_map or active_tangents
        if kind == "ShaderNodeVectorDisplacement" and node.space == "TANGENT":
            return active_tangents
        if kind == "ShaderNodeTexCoord" and "UV" in use.outputs:
            return None
        if kind == "ShaderNodeTexImage" and "Vector" not in use.inputs:
            return None
        return False

    # Images

    def _image(self, image, node):
        if image.source == "TILED":
            return self._tiles(image, node)
        if image.is_dirty and image.source == "FILE" and not _is_builtin(image) and images.file_of(image):
            self._note(f"changes of \"{image.name}\" that are not saved are not seen, as in Cycles")
            image = images.Picture(image, images.file_of(image))
        path, space, alpha = _file(image, self.cache)
        return {
            "index": self.document.shared("images", {"uri": self.document.uri(path)}),
            "colorspace": space,
            "alpha_mode": alpha,
            "is_float": path.endswith((".exr", ".hdr")),
            "source": image.source,
        }

    def _tiles(self, image, node):
        tiles = images.tiles_of(image)
        if node.projection == "BOX":
            # Its sides lie on the first tile.
            tiles = {1001: tiles.get(1001)}
        missing = [str(number) for number, picture in tiles.items() if picture is None]
        if missing:
            self._note(f"tiles of \"{image.name}\" are missing: {', '.join(missing)}; they are pink, as in Cycles")
        written = {number: self._image(picture, node) for number, picture in tiles.items() if picture}
        if not written:
            raise images.ImageError(f"the image \"{image.name}\" has no tile that is shown")
        described = {**next(iter(written.values())), "source": image.source}
        # Before 5.2 the sides of a box show nothing but the tile, and that all over.
        if node.projection != "BOX" or bpy.app.version >= (5, 2, 0):
            described["tiles"] = [{"number": number, "index": file["index"]} for number, file in written.items()]
        return described

    def _sky(self, node):
        path, described = skies.table(node, self.cache, self.report)
        index = self.document.shared("images", {"uri": self.document.uri(path)})
        return {"image": {"index": index}, **described}

    def _ies(self, node):
        table = ies.table(node)
        if table is None:
            self.result.findings.append((EXACT, ies.broken(node)))
            # Up to where the angle is none that is measured.
            table = {"around": [0.0, 7.0], "down": [0.0, 4.0], "strengths": [ies.OF_NO_FILE] * 4}
        return table

    def _note(self, words):
        self.result.findings.append((APPROXIMATED, words))


def _mapped(nodes, vector, mapping, uv_set):
    """The coordinates of a texture that has a mapping of its own from old files: nodes that do the same, and their output."""

    def add(kind, output, properties, inputs):
        nodes.append({"type": f"ShaderNode{kind}", "properties": properties, "inputs": inputs})
        return {"node": len(nodes) - 1, "output": output}

    if vector is None and uv_set is not None:
        vector = add("UVMap", "UV", {"uv_set": uv_set, "from_instancer": False}, {})
    elif vector is None:
        vector = add("TexCoord", "Generated", {"from_instancer": False}, {})
    axes = (mapping.mapping_x, mapping.mapping_y, mapping.mapping_z)
    if axes != ("X", "Y", "Z"):
        apart = add("SeparateXYZ", "X", {}, {"Vector": vector})
        parts = {to: {**apart, "output": of} for to, of in zip("XYZ", axes) if of != "NONE"}
        vector = add("CombineXYZ", "Vector", {}, {"X": 0, "Y": 0, "Z": 0, **parts})
    scale = tuple(mapping.scale)
    if mapping.vector_type in {"TEXTURE", "NORMAL"}:
        # As Cycles keeps it from being no scale at all.
        scale = tuple(v if abs(v) >= 1e-5 else math.copysign(1e-5, v) for v in scale)
    inputs = {"Vector": vector, "Location": short(tuple(mapping.translation)), "Rotation": short(tuple(mapping.rotation)), "Scale": short(scale)}
    return add("Mapping", "Vector", {"vector_type": mapping.vector_type}, inputs)


def _is_builtin(image):
    """Whether Cycles has an image from Blender; of others it reads the files."""
    changed = image.is_dirty and bpy.app.version >= (5, 2, 0)
    return image.packed_file is not None or image.source in {"GENERATED", "MOVIE"} or changed


def _file(image, cache):
    """(path, colour space, alpha mode) of an image as Cycles takes it: the image's own file, or a copy."""
    name = image.colorspace_settings.name
    path = None
    if not (_is_builtin(image) and (image.alpha_mode == "PREMUL" or images.holds_floats(image))):
        path = images.original(image, cache, name in images.DATA_SPACES, any_space=True)
    if path is None:
        return _copy(image, cache)
    return path, name, _alpha_of(image)


def _alpha_of(image):
    """The alpha mode by which Cycles takes an image's own numbers."""
    mode = image.alpha_mode
    if mode not in {"STRAIGHT", "PREMUL"} or _is_builtin(image):
        return mode
    return "STRAIGHT" if _multiplies(mode, images.start_of(image)) else "PREMUL"


def _multiplies(mode, start):
    """Whether Cycles multiplies the colours of a file with its alpha: before 5.3 not those of grey with alpha, whatever is told."""
    kind = images.kind_of(start)
    if kind == ".png" and start[25] == 4 and bpy.app.version < (5, 3, 0):
        return False
    if bpy.app.version >= (5, 1, 0):
        return mode == "STRAIGHT"
    # It goes by what the library that reads the file says; the last two are kinds of JPEG 2000.
    return kind not in {".exr", ".hdr", ".webp"} and start[4:6] != b"jP" and start[:4] != b"\xff\x4f\xff\x51"


def _copy(image, cache):
    """The same of a new file. Coded numbers stay coded, as they are interpolated so."""
    name, mode, builtin = image.colorspace_settings.name, image.alpha_mode, _is_builtin(image)
    stem = os.path.join(cache, f"graph-{hashlib.sha1(json.dumps(images.identity(image)).encode()).hexdigest()}")
    alpha = _alpha_of(image)
    if not builtin and (mode == "PREMUL" or images.holds_floats(image)):
        # Blender has changed the numbers of the file.
        codes = images.codes_of(image)
        path = f"{stem}.{'exr' if codes.dtype == numpy.float32 else 'png'}"
        if not os.path.isfile(path):
            (images.write_exr if codes.dtype == numpy.float32 else images.write_png)(path, codes)
        return path, name, alpha
    if not images.holds_floats(image):
        path = f"{stem}.png"
        if not os.path.isfile(path):
            images.write_png(path, images.coded_pixels(image))
        # Before 5.1 Cycles multiplies whatever Blender gives it.
        return path, name, "STRAIGHT" if builtin and mode == "PREMUL" and bpy.app.version < (5, 1, 0) else alpha
    path = f"{stem}.exr"
    if not os.path.isfile(path):
        images.write_exr(path, numpy.nan_to_num(images.linear_pixels(image, True)[::-1], posinf=65504.0, neginf=0.0))
    # Blender has multiplied them, and from 5.1 on Cycles does so once more.
    if mode == "STRAIGHT" and bpy.app.version < (5, 1, 0):
        alpha = "PREMUL"
    return path, "Non-Color" if name in images.DATA_SPACES else colorspace.working_space(), alpha


# Worlds and lamps


def emitting(owner, rules, document, cache, findings, report=None, layer=None, lamp=None):
    """(a world's or a lamp's node tree, None) as it is, by the rules of what is evaluated there; or (None, why that cannot be).
    `layer`: what has the attributes of a world's view layer; `lamp`: the object_info.Lamp."""
    try:
        walk = Walk(Walker(), rules, layer, lamp)
        walk.read(owner)
        if walk.objections or walk.surface is None:
            return None, ", ".join(walk.objections)
        written = GraphWriter(document, cache, [], None, {}, report).write(walk, owner)
    except (
        images.ImageError, BakeError, RecursionError, MemoryError, KeyError, IndexError, AttributeError, TypeError, ValueError,
    ) as error:  # fmt: skip
        return None, str(error)
    if walk.missing():
        findings.append((EXACT, "a texture of it has no image, or one that is missing or broken: pink, as in Cycles"))
    findings += written.findings
    findings += [(APPROXIMATED, words) for words in [CUT] * walk.is_cut + walk.not_finite]
    findings += [(EXACT, not_in_cycles(label)) for label in sorted(walk.walker.met_absent)]
    return written.extension, None


def filling(owner, rules, document, cache, asked, layer=None):
    """(the Written of what fills the meshes of a material or the world, None), or (None, why that cannot be). `asked`: what
    objects are asked for, and the GridReads of what is filled by grids."""
    values, grids = asked
    try:
        walk = Walk(Walker(), rules, layer)
        walk.has_grids = grids is not None
        walk.read_volume(owner)
        if walk.objections or walk.volume is None:
            return None, ", ".join(walk.objections) or "it is no shader"
        writer = GraphWriter(document, cache, [], None, values)
        writer.grids = grids
        written = writer.write_volume(walk)
    except (
        images.ImageError, RecursionError, MemoryError, KeyError, IndexError, AttributeError, TypeError, ValueError,
    ) as error:  # fmt: skip
        return None, str(error)
    written.findings += [(APPROXIMATED, words) for words in [CUT] * walk.is_cut + walk.not_finite]
    written.findings += [(EXACT, not_in_cycles(label)) for label in sorted(walk.walker.met_absent)]
    return written, None


def aovs_of(owner, kinds, findings, table=None, layer=None):
    """The Walk from the AOV Outputs of a material or a world, or None; those that are not evaluated are told."""
    if not kinds or tree_of(owner) is None:
        return None
    kept = {}
    for name, kind in kinds.items():
        walk = Walk(Walker(), table, layer)
        try:
            walk.read_aovs(owner, {name: kind})
            why = ", ".join(walk.objections)
        except (images.ImageError, RecursionError, KeyError, IndexError, AttributeError, TypeError, ValueError) as error:
            why = str(error)
        if why:
            findings.append(Finding(LOST, f"the AOV \"{name}\" is 0 here, for its nodes are not evaluated: {why}"))
        elif walk.aovs:
            kept[name] = kind
    if not kept:
        return None
    walk = Walk(Walker(), table, layer)
    walk.read_aovs(owner, kept)
    return walk


# Tables


def _ramp(ramp):
    return {
        "interpolation": ramp.interpolation,
        "color_mode": ramp.color_mode,
        "hue_interpolation": ramp.hue_interpolation,
        "stops": [[short(e.position), *short(tuple(e.color))] for e in ramp.elements],
        "table": table([ramp.evaluate(i / (TABLE_SIZE - 1)) for i in range(TABLE_SIZE)]),
    }


def _curves(mapping, kind):
    mapping.initialize()
    curves = list(mapping.curves)[: {"ShaderNodeFloatCurve": 1, "ShaderNodeVectorCurve": 3}.get(kind, 4)]
    ends = [(c.points[0].location[0], c.points[-1].location[0]) for c in curves]
    low, high = min(a for a, _ in ends), max(b for _, b in ends)
    rows = []
    for i in range(TABLE_SIZE):
        at = low + i / (TABLE_SIZE - 1) * (high - low)
        if len(curves) == 4:
            at = mapping.evaluate(curves[3], at)
        rows.append([mapping.evaluate(c, at) for c in curves[:3]])
    return {"min_x": short(low), "max_x": short(high), "extend": mapping.extend, "table": table(rows)}


# Properties


def _attribute_of(node):
    """The name of the attribute of the mesh that a node reads, or None."""
    if node.bl_idname == "ShaderNodeVertexColor":
        return node.layer_name
    if node.bl_idname == "ShaderNodeAttribute" and node.attribute_type == "GEOMETRY":
        return attribute_read(node)
    return None


def _grid_of(node, output):
    """The name of the grid that a node's output reads, or None."""
    if node.bl_idname == "ShaderNodeVolumeInfo":
        return output.lower()
    return _attribute_of(node)


@functools.cache
def _names(kind):
    """Properties that a kind of node has of its own."""
    common = set(bpy.types.ShaderNode.bl_rna.properties.keys())
    own = getattr(bpy.types, kind).bl_rna.properties
    return [
        p.identifier
        for p in own
        if p.identifier not in common and p.type in {"ENUM", "BOOLEAN", "INT", "FLOAT", "STRING"} and not getattr(p, "is_array", False)
    ]


def _plain(node):
    """A node's own properties: what it computes."""
    if node.type == "MADE":
        return node.properties
    if not hasattr(bpy.types, node.bl_idname):
        return {}
    found = {}
    for name in _names(node.bl_idname):
        value = getattr(node, name)
        found[name] = short(value) if isinstance(value, float) else value
    return found
