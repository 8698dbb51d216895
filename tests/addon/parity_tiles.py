# SPDX-License-Identifier: GPL-3.0-or-later
"""What the parity matrix looks at: every shader node of this Blender, every choice of its menus, every socket at several values.

Nothing here knows nodes by name but for what introspection cannot tell: whether a node looks at the place that is shaded, and
what has to be given to it (an image, the name of an attribute).
"""

import itertools
import typing

import bpy

# Nodes whose outputs depend on the surface: they are shown on balls, all others on sheets of points known to the bit.
OF_PLACES = {
    "TexCoord", "NewGeometry", "ObjectInfo", "ParticleInfo", "HairInfo", "PointInfo", "VolumeInfo", "CameraData", "LightPath",
    "Fresnel", "LayerWeight", "Tangent", "Wireframe", "AmbientOcclusion", "Bevel", "Raycast", "Bump", "NormalMap", "UVMap",
    "Attribute", "VertexColor", "VectorTransform", "UVAlongStroke", "LightFalloff",
}  # fmt: skip

# Of these the ones that ask by random rays, whose mean is shown.
OF_RAYS = {"AmbientOcclusion", "Bevel"}

# Shaders of hair, which are shown on strands.
OF_STRANDS = {"BsdfHair", "BsdfHairPrincipled"}

# No node of a surface's colours: what ends a tree, and what holds other trees.
NOT_SHOWN = {
    "OutputMaterial": "the end of a tree",
    "OutputWorld": "the end of a world's tree",
    "OutputLight": "the end of a light's tree",
    "OutputLineStyle": "of Freestyle",
    "OutputAOV": "writes passes",
    "UVAlongStroke": "of Freestyle",
    "Group": "resolved by the add-on: test_export_graph.py",
    "CustomGroup": "resolved by the add-on: test_export_graph.py",
    "Script": "OSL, which Sundog does not run",
    "Background": "of worlds alone",
    "ShaderToRGB": "of EEVEE alone",
    "EeveeSpecular": "of EEVEE alone",
    **dict.fromkeys(("LightAccumulation", "LightEvaluation", "LightInfo", "ShadowRaycast"), "of EEVEE alone"),
    **dict.fromkeys(("LightIterInternalInput", "LightIterInternalOutput"), "of EEVEE's zones"),
    "Squeeze": "of Blender before 2.8",
}

# What some nodes need before they show anything.
GIVEN = {
    "Attribute": {"attribute_name": "unit"},
    "VertexColor": {"layer_name": "tint"},
}

# Where values are far from 1.
SHOWN_BY = {"CameraData": 1e-3, "Camera": 1e-3, "Ray Length": 1e-3, "Ray Depth": 0.1}

# How far from each value of a socket without bounds.
REACH = {"low": -1.2, "high": 2.3}
LEVELS = ("low", "middle", "high", "textured")


class Tile(typing.NamedTuple):
    """One row of the matrix."""

    # The node without "ShaderNode".
    node: str
    # (property, value) pairs that differ from the defaults.
    settings: tuple
    # (identifier of an input, level) pairs.
    inputs: tuple
    # The output's identifier.
    output: str
    # sheet, ball, rays, shader, strands, volume or displacement.
    kind: str

    @property
    def words(self):
        """The row in words."""
        settings = ", ".join(f"{name.split('.')[-1]} {value}" for name, value in self.settings)
        inputs = ", ".join(f"{name} {level}" for name, level in self.inputs)
        return " · ".join(part for part in (self.node, settings, inputs, f"→ {self.output}") if part)

    @property
    def is_pattern(self):
        """Whether the bar is that of textures: what they compute is known to the bit."""
        return self.kind == "sheet" and self.node.startswith("Tex")


def kinds():
    """Names of all kinds of shader nodes, without "ShaderNode"; those that can be made."""
    for name in sorted(dir(bpy.types)):
        kind = getattr(bpy.types, name)
        if name.startswith("ShaderNode") and isinstance(kind, type) and issubclass(kind, bpy.types.ShaderNode) and name != "ShaderNode":
            yield name.removeprefix("ShaderNode")


def of_kind(tree, kind):
    """A node of the kind in a tree; None where Blender makes none."""
    try:
        return tree.nodes.new(f"ShaderNode{kind}")
    except RuntimeError:
        return None


def choices(owner, name):
    """All values that a property may have; of numbers the ends and what lies between."""
    about = owner.bl_rna.properties[name]
    if about.type == "BOOLEAN" and not about.is_array:
        return [False, True]
    if about.type == "ENUM" and not about.is_enum_flag:
        found = [item.identifier for item in about.enum_items]
        try:
            setattr(owner, name, "no such choice")
        except TypeError as error:
            # Menus that depend on the node tell their items in the error alone.
            told = str(error).partition(" not found in ")[2]
            found = [item.strip(" '\"()") for item in told.split(",")] or found
        return [item for item in found if item]
    if about.type in {"INT", "FLOAT"} and not about.is_array:
        value = getattr(owner, name)
        number = type(value)
        high = about.soft_max if about.soft_max < 1e3 else value + 3
        low = about.soft_min if about.soft_min > -1e3 else value - 3
        # Whole numbers get one more that is no power of two.
        return sorted({number(low), value, number(high), *([min(3, number(high))] if number is int else ())})
    return []


def menus(node):
    """(path, values, value) of what a node's panel shows beside sockets: its own properties, and its ramp's or curves'."""
    common = set(bpy.types.ShaderNode.bl_rna.properties.keys())
    for about in node.bl_rna.properties:
        if about.identifier in common or about.is_readonly and about.type != "POINTER":
            continue
        if about.type != "POINTER":
            if values := choices(node, about.identifier):
                yield about.identifier, values, getattr(node, about.identifier)
        elif about.identifier in {"color_ramp", "mapping"}:
            inner = getattr(node, about.identifier)
            names = ("interpolation", "color_mode", "hue_interpolation") if about.identifier == "color_ramp" else ("extend",)
            for name in names:
                yield f"{about.identifier}.{name}", choices(inner, name), getattr(inner, name)


def apply(node, settings):
    """Sets properties; whether all could be."""
    for path, value in settings:
        owner, _, name = path.rpartition(".")
        try:
            setattr(getattr(node, owner) if owner else node, name, value)
        except (TypeError, AttributeError):
            return False
    return True


def prepare(node, kind):
    """Gives a node what it needs; see GIVEN. Ramps and curves become such that show their interpolation."""
    apply(node, GIVEN.get(kind, {}).items())
    if hasattr(node, "image"):
        node.image = bpy.data.images.get("parity")
    if getattr(node, "color_ramp", None) is not None:
        ramp = node.color_ramp
        ramp.elements[0].color, ramp.elements[1].color = (0.9, 0.1, 0.05, 1), (0.05, 0.2, 0.8, 0.3)
        ramp.elements[1].position = 0.85
        ramp.elements.new(0.3).color = (0.1, 0.7, 0.2, 0.8)
    if getattr(node, "mapping", None) is not None and hasattr(node.mapping, "curves"):
        for number, curve in enumerate(node.mapping.curves):
            first, last = curve.points[0].location[0], curve.points[-1].location[0]
            curve.points.new(first + (last - first) * 0.4, first + (last - first) * (0.5 + 0.1 * number))
        node.mapping.update()


def shown(sockets):
    """Those that Blender shows, each identifier once."""
    found = {}
    for socket in sockets:
        if socket.enabled and not socket.is_unavailable if hasattr(socket, "is_unavailable") else socket.enabled:
            # The last one, by which Blender adds more, holds nothing.
            if not socket.identifier.startswith("__extend__"):
                found.setdefault(socket.identifier, socket)
    return list(found.values())


def is_swept(socket):
    """Whether a socket holds something that can be put at several values."""
    return socket.type in {"VALUE", "INT", "BOOLEAN", "VECTOR", "RGBA", "ROTATION"}


def levels(socket):
    """The levels at which a socket is looked at."""
    if socket.type == "BOOLEAN":
        return ("low", "high")
    if socket.hide_value and socket.type == "VECTOR":
        # Normals and tangents: that of the surface is the value of an unlinked one.
        return ("textured",)
    return LEVELS


def number(socket, level):
    """A number for a level, within what Blender lets stand in the socket."""
    was = socket.default_value
    ends = []
    for far in (-1e8, 1e8):
        try:
            socket.default_value = type(was)(far)
            ends.append(socket.default_value)
        except (TypeError, ValueError, OverflowError):
            ends.append(was)
    socket.default_value = was
    low, high = ends
    if level == "middle":
        value = was if low < was < high and was != 0 else (low + high) / 2 if high - low <= 10 else max(low, 0.0) + 0.7
        return min(max(value, low), high)
    if level == "low":
        return low if low > -100 else REACH["low"]
    return high if high < 100 else max(REACH["high"], 2 * was, low + REACH["high"])


def value(socket, level):
    """What stands in a socket at a level."""
    if socket.type == "RGBA":
        return {"low": (0.0, 0.0, 0.0, 1.0), "middle": (0.75, 0.45, 0.2, 1.0), "high": (1.0, 0.9, 0.95, 1.0)}[level]
    if socket.type in {"VECTOR", "ROTATION"}:
        width = len(socket.default_value)
        return {"low": (-1.3, -0.4, 0.2, 0.1), "middle": (0.4, 0.5, 0.7, 0.3), "high": (1.7, 2.2, 3.1, 1.9)}[level][:width]
    found = number(socket, level)
    return found if socket.type == "VALUE" else type(socket.default_value)(found)


def kind_of(kind, output):
    """Where an output is shown."""
    if kind in {"Displacement", "VectorDisplacement"}:
        return "displacement"
    if kind in OF_STRANDS:
        return "strands"
    if output.type == "SHADER":
        return "volume" if kind.startswith("Volume") else "shader"
    if kind in OF_RAYS:
        return "rays"
    return "ball" if kind in OF_PLACES else "sheet"


def tiles(kind):
    """All rows of a kind of node; an empty list for those of NOT_SHOWN and those that have no output."""
    material = bpy.data.materials.new("scratch")
    material.use_nodes = True
    tree = material.node_tree
    try:
        return [] if kind in NOT_SHOWN else list(dict.fromkeys(_tiles(tree, kind)))
    finally:
        bpy.data.materials.remove(material)


def _tiles(tree, kind):
    node = of_kind(tree, kind)
    if node is None:
        return
    prepare(node, kind)
    menu = list(menus(node))
    singles = [()] + [((path, v),) for path, values, was in menu for v in values if v != was]
    for settings in singles:
        node = of_kind(tree, kind)
        prepare(node, kind)
        if not apply(node, settings):
            continue
        inputs = [s for s in shown(node.inputs) if is_swept(s)]
        for output in shown(node.outputs):
            where = kind_of(kind, output)
            yield Tile(kind, settings, (), output.identifier, where)
            if where == "volume":
                break
            for socket in inputs:
                for level in levels(socket):
                    yield Tile(kind, settings, ((socket.identifier, level),), output.identifier, where)
    # Menus that only count together: a blend mode of colours, the direction of rings.
    few = [(path, [v for v in values if v != was]) for path, values, was in menu if isinstance(was, (str, bool))]
    for (path, values), (other, others) in itertools.combinations(few, 2):
        for settings in itertools.product([(path, v) for v in values], [(other, v) for v in others]):
            # A menu's choices depend on what stands in another: the order decides.
            for order in (settings, settings[::-1]):
                node = of_kind(tree, kind)
                prepare(node, kind)
                if apply(node, order):
                    for output in shown(node.outputs):
                        where = kind_of(kind, output)
                        yield Tile(kind, order, (), output.identifier, where)
                    break
    if kind == "BsdfPrincipled":
        node = of_kind(tree, kind)
        names = [s.identifier for s in shown(node.inputs) if is_swept(s) and not (s.hide_value and s.type == "VECTOR")]
        for pair in itertools.combinations(names, 2):
            yield Tile(kind, (), tuple((name, "high") for name in pair), "BSDF", "shader")


class Tree:
    """Makes the material of a tile."""

    def __init__(self, tile, name):
        self.tile = tile
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        self.end = self.tree.nodes.new("ShaderNodeOutputMaterial")
        node = of_kind(self.tree, tile.node)
        prepare(node, tile.node)
        apply(node, tile.settings)
        self.sources = 0
        self._inputs(node)
        self._show(node)

    def _link(self, source, socket):
        self.tree.links.new(source, socket)

    def _new(self, kind, **settings):
        node = self.tree.nodes.new(f"ShaderNode{kind}")
        for key, value in settings.items():
            setattr(node, key, value)
        return node

    def _inputs(self, node):
        levels_of = dict(self.tile.inputs)
        on_sheet = self.tile.kind == "sheet"
        converts = on_sheet and not self.tile.node.startswith("Tex")
        for socket in shown(node.inputs):
            level = levels_of.get(socket.identifier)
            if socket.type == "SHADER":
                self._shader(socket)
            elif not is_swept(socket):
                continue
            elif level == "textured":
                self._texture(socket)
            elif level is not None:
                socket.default_value = value(socket, level)
            elif converts and not (socket.type == "BOOLEAN" or socket.name in {"Fac", "Factor"} and levels_of):
                self._texture(socket)
            elif on_sheet and socket.identifier in {"Vector", "W"}:
                self._texture(socket)
            elif not on_sheet and socket.identifier == "Height":
                self._texture(socket)

    def _shader(self, socket):
        second = socket.identifier.endswith("_001")
        kind = "BsdfGlossy" if second else "BsdfDiffuse"
        made = of_kind(self.tree, kind) or self._new("BsdfAnisotropic")
        made.inputs["Color"].default_value = (0.2, 0.5, 0.8, 1) if second else (0.8, 0.3, 0.1, 1)
        if second:
            made.inputs["Roughness"].default_value = 0.4
        self._link(made.outputs[0], socket)

    def _texture(self, socket):
        """Links something that varies: on sheets the points' own numbers, on balls noise in object coordinates."""
        self.sources += 1
        if self.tile.kind == "sheet":
            by_name = {"Vector": "place", "W": "fourth"}.get(socket.identifier, "")
            is_pattern = self.tile.node.startswith("Tex")
            name = by_name if is_pattern and by_name else ("unit", "place", "other")[self.sources % 3]
            if is_pattern and name == "place" and not by_name:
                name = "unit"
            source = self._new("Attribute", attribute_name=name).outputs["Vector"]
            if socket.type == "VALUE":
                split = self._new("SeparateXYZ")
                self._link(source, split.inputs[0])
                source = split.outputs[0 if name == "fourth" else self.sources % 3]
        elif socket.hide_value and socket.type == "VECTOR":
            # A normal that leans, or a tangent.
            place, sum_ = self._new("NewGeometry"), self._new("VectorMath", operation="ADD")
            pattern = self._new("VectorMath", operation="SINE")
            scaled = self._new("VectorMath", operation="MULTIPLY")
            scaled.inputs[1].default_value = (0.25, 0.2, 0.3)
            self._link(place.outputs["Position"], pattern.inputs[0])
            self._link(pattern.outputs[0], scaled.inputs[0])
            self._link(place.outputs["Tangent" if "Tangent" in socket.name else "Normal"], sum_.inputs[0])
            self._link(scaled.outputs[0], sum_.inputs[1])
            normal = self._new("VectorMath", operation="NORMALIZE")
            self._link(sum_.outputs[0], normal.inputs[0])
            source = normal.outputs[0]
        else:
            noise, place = self._new("TexNoise"), self._new("TexCoord")
            noise.inputs["Scale"].default_value = 2.0 + 0.3 * self.sources
            self._link(place.outputs["Object"], noise.inputs["Vector"])
            source = noise.outputs["Color"] if socket.type in {"RGBA", "VECTOR"} else noise.outputs[0]
        self._link(source, socket)

    def _show(self, node):
        output = next(s for s in shown(node.outputs) if s.identifier == self.tile.output)
        if self.tile.kind == "volume":
            return self._link(output, self.end.inputs["Volume"])
        if self.tile.kind == "displacement":
            diffuse = self._new("BsdfDiffuse")
            self._link(diffuse.outputs[0], self.end.inputs["Surface"])
            return self._link(output, self.end.inputs["Displacement"])
        if output.type == "SHADER":
            return self._link(output, self.end.inputs["Surface"])
        emission = self._new("Emission")
        # Of constant emissions Sundog leaves out what is negative: this one is 1 everywhere without being known to be.
        strength = self._new("Math", operation="MULTIPLY")
        strength.inputs[1].default_value = SHOWN_BY.get(self.tile.output, SHOWN_BY.get(self.tile.node, 1.0))
        self._link(self._new("Attribute", attribute_name="one").outputs["Fac"], strength.inputs[0])
        self._link(strength.outputs[0], emission.inputs["Strength"])
        self._link(output, emission.inputs["Color"])
        self._link(emission.outputs[0], self.end.inputs["Surface"])
