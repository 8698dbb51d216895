# SPDX-License-Identifier: GPL-3.0-or-later
"""A walked node tree as SUNDOG_shader_graph, and what it asks of meshes and objects."""

import functools
import hashlib
import json
import os

import bpy
import numpy

from . import colorspace, gltf, images
from .graph import Link
from .verdicts import APPROXIMATED, LOST

# As Cycles tabulates ramps and curves (from 4.4 on): so many entries, the last one at the end of the range.
TABLE_SIZE = 257

# Textures whose coordinates are the generated ones, where nothing is linked.
_GENERATED = {
    f"ShaderNodeTex{name}" for name in ("Noise", "Voronoi", "Wave", "Magic", "Brick", "Checker", "Gradient", "Gabor", "Musgrave")
}


class Written:
    """An extension's content, and what it needs: attributes as geometry.Demand has them, generated coordinates, what Object
    Info tells; `findings` on what it cannot say."""

    def __init__(self):
        self.extension = {}
        self.attributes = []
        self.generated = self.informed = False
        self.findings = []


class GraphWriter:
    """Writes the graph of one material."""

    def __init__(self, document, cache, uvs, color):
        """`uvs`: names of UV maps by their numbers, to which more are added. `color`: name and width of the attribute that
        COLOR_0 holds, or None."""
        self.document, self.cache = document, cache
        self.uvs, self.color = uvs, color
        self.result = Written()
        # Attributes by name: the number of components that some node reads.
        self._widths = {}

    def write(self, walk, material):
        """The Written of a walk."""
        for use in walk.uses:
            self._demand(use)
            self._tell(use)
        self.result.attributes = sorted((name, width) for name, width in self._widths.items() if not self._is_color(name))
        nodes, places = [], {}

        def link(found):
            output = {"node": places[found.use], "output": found.output}
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
            entry = {"type": use.node.bl_idname}
            if use.node.name:
                entry["name"] = use.node.name
            properties = {**_plain(use.node), **self._properties(use, walk)}
            if properties:
                entry["properties"] = properties
            inputs = {i: link(v) if isinstance(v, Link) else short(v) for i, v in use.inputs.items()}
            if inputs:
                entry["inputs"] = inputs
            places[use] = len(nodes)
            nodes.append(entry)
        extension = {"blender": list(bpy.app.version), "nodes": nodes, "surface": link(walk.surface)}
        if any(u.node.bl_idname == "ShaderNodeObjectInfo" and "Material Index" in u.outputs for u in walk.uses):
            extension["pass_index"] = material.pass_index
        self.result.extension = extension
        return self.result

    def _tell(self, use):
        """What of a shader is not rendered as Cycles does."""
        kind, inputs = use.node.bl_idname, use.inputs
        is_principled = kind == "ShaderNodeBsdfPrincipled"
        if kind == "ShaderNodeSubsurfaceScattering" or (is_principled and inputs.get("Subsurface Weight", 0.0) != 0.0):
            if not inputs.get("Thin Wall", 0.0):
                self.result.findings.append((LOST, "subsurface scattering is not rendered yet", "subsurface"))
            elif inputs.get("Diffuse Roughness", 0.0) != 0.0:
                self.result.findings.append((APPROXIMATED, "light below the surface of a thin wall is scattered without roughness"))
        ior = inputs.get("IOR")
        if is_principled and isinstance(ior, float) and ior < 1:
            self.result.findings.append((APPROXIMATED, "an index of refraction below 1 is rendered as 1"))

    def _demand(self, use):
        kind, inputs = use.node.bl_idname, use.inputs
        coordinates = (
            (kind in _GENERATED and "Vector" not in inputs)
            or (kind == "ShaderNodeTexCoord" and "Generated" in use.outputs)
            # Tangents about the middle of the object.
            or (kind == "ShaderNodeNewGeometry" and "Tangent" in use.outputs)
            or ("Tangent" not in inputs and any(inputs.get(n, 0.0) != 0.0 for n in ("Anisotropic", "Anisotropy")))
        )
        self.result.generated |= coordinates
        self.result.informed |= kind == "ShaderNodeObjectInfo" and bool(use.outputs - {"Location", "Material Index"})
        name = _attribute_of(use.node)
        if name is not None:
            # Of an attribute with two components Cycles takes the first for its number, and the mean of all others.
            width = 4 if "Alpha" in use.outputs else 1 if use.outputs == {"Fac"} else 3
            self._widths[name] = max(width, self._widths.get(name, 0))

    def _is_color(self, name):
        return self.color is not None and self.color[0] == name and self._widths[name] <= self.color[1]

    def _properties(self, use, walk):
        node, kind = use.node, use.node.bl_idname
        found = {}
        name = _attribute_of(node)
        if name is not None:
            numbers = [n for n, _ in self.result.attributes]
            found["attribute"] = "COLOR_0" if self._is_color(name) else f"_SUNDOG_{numbers.index(name)}"
        map_name = self._uv_map(use)
        if map_name is not False:
            if map_name not in self.uvs:
                self.uvs.append(map_name)
            found["uv_set"] = self.uvs.index(map_name)
        if kind == "ShaderNodeTexImage":
            found["image"] = self._image(walk.picture(node))
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

    @staticmethod
    def _uv_map(use):
        """The name of the UV map that a node reads (None for the active one); False if it reads none."""
        node, kind = use.node, use.node.bl_idname
        if kind == "ShaderNodeUVMap" or (kind == "ShaderNodeNormalMap" and node.space == "TANGENT"):
            return node.uv_map or None
        if kind == "ShaderNodeTexCoord" and "UV" in use.outputs:
            return None
        if kind == "ShaderNodeTexImage" and "Vector" not in use.inputs:
            return None
        return False

    # Images

    def _image(self, image):
        space = image.colorspace_settings.name
        data = space in images.DATA_SPACES
        path = images.original(image, self.cache, data)
        alpha = image.alpha_mode
        if path is None:
            path, space, alpha = _copy(image, self.cache)
        if not images.is_exactly_known(image):
            self._note(f"the colour space {image.colorspace_settings.name} of \"{image.name}\" is read as sRGB")
        if image.alpha_mode == "PREMUL" and not image.is_float and images.may_have_alpha(image):
            self._note(f"the alpha of \"{image.name}\" is taken as straight instead of premultiplied")
        if bpy.app.version >= (5, 1, 0) and image.alpha_mode == "STRAIGHT" and image.is_float and images.multiplies(image):
            self._note(f"the colours of \"{image.name}\" are taken as multiplied by its alpha already")
        described = {
            "index": self.document.shared("images", {"uri": self.document.uri(path)}),
            "colorspace": space,
            "alpha_mode": alpha,
            "is_float": bool(image.is_float),
            "source": image.source,
        }
        if image.size[0] and image.size[1]:
            described["width"], described["height"] = image.size
        return described

    def _note(self, words):
        self.result.findings.append((APPROXIMATED, words))


def _copy(image, cache):
    """(path, colour space, alpha mode) of a new file of an image. Coded numbers stay coded, as they are interpolated so."""
    name = image.colorspace_settings.name
    stem = os.path.join(cache, f"graph-{hashlib.sha1(json.dumps(images.identity(image)).encode()).hexdigest()}")
    if not image.is_float and (name == "sRGB" or name in images.DATA_SPACES):
        path = f"{stem}.png"
        if not os.path.isfile(path):
            images.write_png(path, images.coded_pixels(image))
        return path, name, image.alpha_mode
    path = f"{stem}.exr"
    multiplied = images.multiplies(image)
    if not os.path.isfile(path):
        values = numpy.nan_to_num(images.linear_pixels(image, multiplied)[::-1], posinf=65504.0, neginf=0.0)
        images.write_exr(path, values)
    straight = images.has_straight_alpha(image)
    space = "Non-Color" if name in images.DATA_SPACES else colorspace.working_space()
    return path, space, "PREMUL" if straight else image.alpha_mode


# Tables


def _ramp(ramp):
    return {
        "interpolation": ramp.interpolation,
        "color_mode": ramp.color_mode,
        "hue_interpolation": ramp.hue_interpolation,
        "stops": [[short(e.position), *short(tuple(e.color))] for e in ramp.elements],
        "table": _table([ramp.evaluate(i / (TABLE_SIZE - 1)) for i in range(TABLE_SIZE)]),
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
    return {"min_x": short(low), "max_x": short(high), "extend": mapping.extend, "table": _table(rows)}


def _table(rows):
    values = numpy.nan_to_num(numpy.array([list(r) for r in rows], numpy.float32))
    return [[float(str(v)) for v in row] for row in values]


def short(value):
    """Numbers with as many digits as tell them apart from other floats of 32 bits."""
    if isinstance(value, tuple):
        return [short(v) for v in value]
    number = float(str(numpy.float32(value)))
    return int(number) if number.is_integer() and abs(number) < 1e9 else number


# Properties


def _attribute_of(node):
    """The name of the attribute of the mesh that a node reads, or None."""
    if node.bl_idname == "ShaderNodeVertexColor":
        return node.layer_name
    if node.bl_idname == "ShaderNodeAttribute":
        return node.attribute_name
    return None


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
    if not hasattr(bpy.types, node.bl_idname) or node.type == "MADE":
        return {}
    found = {}
    for name in _names(node.bl_idname):
        value = getattr(node, name)
        found[name] = short(value) if isinstance(value, float) else value
    return found
