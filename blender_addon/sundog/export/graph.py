# SPDX-License-Identifier: GPL-3.0-or-later
"""A material's node tree as it is, for SUNDOG_shader_graph: what the surface needs, in order of dependence.

Trees may have thousands of nodes behind one another, so nothing here calls itself.
"""

import math

import bpy

from . import blackbody, colorspace, evaluated, images, object_info
from .nodes import FILLING, HOLLOW, INLINED, MOST_NODES, TRUTHS, VOLUMES, Place, SceneWide, is_cycles_own, not_finite, output_of, tree_of

# Whether graphs are written at all.
ENABLED = True

# Sockets that hold their own value for all that Blender's panels do not show it.
_VALUED = {
    ("ShaderNodeVectorRotate", "Vector"),
    ("ShaderNodeTexWhiteNoise", "Vector"),
    ("ShaderNodeMapRange", "Vector"),
    ("ShaderNodeBsdfRayPortal", "Direction"),
}
# What a Raycast takes where nothing is linked, by outputs of Geometry.
_OF_RAYS = {"Position": "Position", "Direction": "Normal"}
_IMAGES = {"TEX_IMAGE", "TEX_ENVIRONMENT"}
# The colours that shaders shine with.
_SHINING = {"ShaderNodeEmission": "Color", "ShaderNodeBackground": "Color", "ShaderNodeBsdfPrincipled": "Emission Color"}
_NUMBERS = {"VALUE", "INT", "BOOLEAN"}
_WHOLE = {"INT", "BOOLEAN"}
_TRIPLES = {"VECTOR", "ROTATION"}
_WIDTHS = {**dict.fromkeys(_NUMBERS, 1), **dict.fromkeys(_TRIPLES, 3), "RGBA": 4}


def _is_alpha_read(node):
    """Whether the opacity of a picture is linked. The Environment Texture has no such output."""
    alpha = node.outputs.get("Alpha")
    return alpha is not None and alpha.is_linked


class Link:
    """What feeds an input: an output of another use of a node. `through` says what converts it on its way, if anything does."""

    def __init__(self, use, output, through=None):
        self.use, self.output, self.through = use, output, through


class Use:
    """A node, or a node inside a group for one use of the group."""

    def __init__(self, node, groups):
        self.node, self.groups = node, groups
        # By identifier: a Link, a number, or a tuple of numbers.
        self.inputs = {}
        # The identifiers of outputs that something reads.
        self.outputs = set()

    def constant(self, identifier):
        """The number at an unlinked input; None if it is linked."""
        value = self.inputs.get(identifier, 0.0)
        return value if isinstance(value, (int, float)) else None


def _has_portals():
    """Whether some tree of the file sends rays elsewhere."""
    trees = [*map(tree_of, bpy.data.materials), *bpy.data.node_groups]
    return any(node.bl_idname == "ShaderNodeBsdfRayPortal" for tree in trees if tree is not None for node in tree.nodes)


def casts_whole_shadows(owner):
    """Whether it is a material whose Transparent Shadows are off."""
    return isinstance(owner, bpy.types.Material) and not owner.use_transparent_shadow


def _lets_through(use):
    """Whether rays may pass a shader straight on."""
    kind = use.node.bl_idname
    return kind == "ShaderNodeBsdfTransparent" or (kind == "ShaderNodeBsdfPrincipled" and use.inputs.get("Alpha", 1.0) != 1.0)


def _is_implicit(socket):
    """Whether an unlinked input stands for normals, tangents or coordinates."""
    return socket.type == "VECTOR" and socket.hide_value and (socket.node.bl_idname, socket.identifier) not in _VALUED


def _numbers(socket, kind):
    """The value of a socket of that type, as its numbers; None if it has none."""
    value = getattr(socket, "default_value", None)
    width = _WIDTHS.get(kind)
    if value is None or width is None:
        return None
    if width == 1:
        return float(value)
    # Some vectors of Blender 5 have but two numbers; Cycles knows no such.
    numbers = [float(v) for v in list(value)[:width]]
    return tuple(numbers + [0.0] * (width - len(numbers)))


def _converted(value, kind, wanted):
    """A value of a socket of one type at a socket of another, as Cycles converts it."""
    before, after = _WIDTHS[kind], _WIDTHS[wanted]
    if before == after:
        return value
    if after == 1:
        if before == 3:
            return sum(value) / 3
        return float(sum(v * w for v, w in zip(value, colorspace.luminance())))
    if before == 1:
        return (value,) * 3 + (1.0,) * (after - 3)
    return value[:3] if after == 3 else (*value, 1.0)


def _through(kinds):
    """The type from which a link makes numbers between its ends, whose types are the first and the last; None if it makes none."""
    made, now = None, kinds[0]
    for kind in kinds[1:-1] if not INLINED else ():
        if kind in _NUMBERS and _WIDTHS.get(now, 1) > 1:
            made, now = made or now, "VALUE"
        elif now != "VALUE" and kind in _WIDTHS:
            now = kind
    if made is None and kinds[-1] in _NUMBERS and _WIDTHS.get(now, 1) > 1 and _WIDTHS[now] != _WIDTHS.get(kinds[0]):
        made = now
    return made


def _becomes_whole(kinds):
    """Whether a link makes whole numbers on its way: before 5.0 those to true and false are such, too."""
    return not INLINED and not _WHOLE.isdisjoint(kinds[1:-1])


def _becomes_truth(kinds):
    """Whether a link makes true or false of its values: what is above 0, and vectors and colours that are not 0."""
    return TRUTHS and kinds[0] != "BOOLEAN" and "BOOLEAN" in kinds[1:]


def _part(value, output):
    """What an output of the Attribute node gives of four numbers."""
    if output == "Alpha":
        return value[3]
    return sum(value[:3]) / 3 if output == "Fac" else (*value[:3], 1.0)[: 4 if output == "Color" else 3]


def _key(place):
    """What a node of a tree, in the groups that lead to it, is told by."""
    return tuple(group.as_pointer() for group in place.groups), place.node.as_pointer()


class Walk:
    """All nodes that a surface needs, in order of dependence; `findings` for what is not as in Blender."""

    def __init__(self, walker, table=None, layer=None, lamp=None):
        """`table`: the rules of what is evaluated, those of materials by default. `layer`: the scene and the view layer whose
        attributes nodes may read. `lamp`: the object_info.Lamp whose tree it is."""
        self.walker, self.table, self.layer, self.lamp = walker, table, layer, lamp
        self.uses, self.objections = [], []
        self.surface = self.displacement = self.volume = None
        # Names of passes of the scene's own, and the links to what they are told.
        self.aovs = []
        # Blender's name of what the displacement does.
        self.displacement_method = "BUMP"
        # Sentences on sockets whose values are no numbers; whether a circle of links was cut.
        self.not_finite, self.is_cut = [], False
        # Whether what is filled has grids of its own.
        self.has_grids = False
        self._fills = False
        self._known = {}
        self._pictures = {}
        walker.met_invalid = False
        walker.met_absent = set()

    def read(self, owner):
        """Walks from the output of a material or a world that Cycles renders."""
        output = output_of(owner)
        found = self._fed(output, "Surface")
        if found is None and isinstance(owner, bpy.types.Material):
            if output is not None and self.walker.is_only_filled(output):
                return
            # Nothing is black.
            found = self._made("ShaderNodeEmission", "Emission", {"Color": (0.0, 0.0, 0.0, 1.0), "Strength": 0.0})
        if not isinstance(found, Link):
            # What is constant here shines.
            return
        self.surface = found
        displaced = self._fed(output, "Displacement")
        if isinstance(displaced, Link):
            self.displacement = displaced
            self.displacement_method = owner.displacement_method
            self._walk(displaced.use)
        if found.use not in self.uses:
            self._walk(found.use)
        if casts_whole_shadows(owner) and any(map(_lets_through, self.uses)):
            self._close_for_shadows()
        self._object()

    def _fed(self, output, name):
        """What feeds a socket of the output; None without the output or the socket: lamps have a surface alone, worlds no displacement."""
        socket = None if output is None else output.inputs.get(name)
        return None if socket is None else self._feeding(socket, ())

    def _close_for_shadows(self):
        """The surface as it is, but black to rays that look for lights: Cycles lets none of them through."""
        black = self._made("ShaderNodeEmission", "Emission", {"Color": (0.0, 0.0, 0.0, 1.0), "Strength": 0.0})
        asks = self._made("ShaderNodeLightPath", "Is Shadow Ray", {})
        self.surface = self._made("ShaderNodeMixShader", "Shader", {"Fac": asks, "Shader": self.surface, "Shader_001": black})
        self._walk(self.surface.use)

    def read_volume(self, owner):
        """Walks from what fills the meshes of a material, or the world."""
        self._fills = True
        found = self._fed(output_of(owner), "Volume")
        if isinstance(found, Link):
            self.volume = found
            self._walk(found.use)
        self._object()

    def read_aovs(self, owner, kinds):
        """Walks from the AOV Outputs of a tree, by the kinds of the view layer's AOVs."""
        for node, groups in _aov_outputs(tree_of(owner)):
            kind = kinds.get(node.aov_name)
            if kind is None:
                continue
            is_color = kind == "COLOR"
            value = self._feeding(node.inputs["Color" if is_color else "Value"], groups)
            # What converts the value as the node's socket does.
            if is_color:
                inputs = {"Vector": value[:3] if isinstance(value, tuple) else value, "Vector_001": (0.0, 0.0, 0.0)}
                link = self._made("ShaderNodeVectorMath", "Vector", inputs, {"operation": "ADD"})
            else:
                link = self._made("ShaderNodeMath", "Value", {"Value": value, "Value_001": 0.0}, {"operation": "ADD", "use_clamp": False})
            self._walk(link.use)
            self.aovs.append((node.aov_name, link))
        self._object()

    def _object(self):
        self.is_cut |= self.walker.met_invalid
        labels = []
        for use in self.uses:
            inputs = {i: v if isinstance(v, float) else None for i, v in use.inputs.items()}
            labels += evaluated.objections(use.node, inputs, use.outputs, self.table)
            labels += self._image_objections(use.node)
            labels += _attribute_objections(use.node)
        self.objections = sorted(set(labels))

    def _walk(self, first):
        stack = [(first, self._links_of(first))]
        open_uses, done = {id(first)}, {id(use) for use in self.uses}
        while stack:
            use, links = stack[-1]
            link = next(links, None)
            if link is None:
                stack.pop()
                open_uses.discard(id(use))
                done.add(id(use))
                self.uses.append(use)
                continue
            identifier, link = link
            if id(link.use) in open_uses:
                del use.inputs[identifier]
                self.is_cut = True
            elif id(link.use) not in done:
                if len(self._known) > MOST_NODES:
                    raise RecursionError(f"its groups amount to more than {MOST_NODES} nodes")
                open_uses.add(id(link.use))
                stack.append((link.use, self._links_of(link.use)))

    def _links_of(self, use):
        """Reads the inputs of a node; an iterator of those that are linked."""
        node = use.node
        for socket in node.inputs:
            if not socket.enabled:
                continue
            found = self._feeding(socket, use.groups)
            if found is None and node.bl_idname == "ShaderNodeRaycast" and socket.identifier in _OF_RAYS:
                found = self._made("ShaderNodeNewGeometry", _OF_RAYS[socket.identifier], {})
            if found is not None:
                use.inputs[socket.identifier] = found
        if node.type == "MIX_SHADER":
            factor = use.constant("Fac")
            # The other one is not seen, whatever it is.
            if factor is not None and (factor <= 0 or factor >= 1):
                use.inputs.pop("Shader_001" if factor <= 0 else "Shader", None)
        elif node.type == "AMBIENT_OCCLUSION" and use.constant("Distance") == 0:
            use.inputs["Distance"] = SceneWide.reach
        elif node.bl_idname in _SHINING:
            name = _SHINING[node.bl_idname]
            color = use.inputs.get(name)
            if isinstance(color, tuple) and min(color) < 0:
                # Less than nothing is no number that the program takes in the socket itself.
                use.inputs[name] = self._made("ShaderNodeCombineXYZ", "Vector", dict(zip("XYZ", color)))
        elif node.type == "BSDF_HAIR_PRINCIPLED" and not node.inputs["Random"].is_linked:
            # As Cycles: the strand's own number, where something varies by it.
            if any(use.constant(name) != 0 for name in ("Random Roughness", "Random Color")):
                use.inputs["Random"] = self._made("ShaderNodeHairInfo", "Random", {})
        return iter([(i, v) for i, v in use.inputs.items() if isinstance(v, Link)])

    def _feeding(self, socket, groups):
        """What an input gets: a Link, numbers, or None for what the node takes by itself."""
        kinds = []
        place = self.walker.source(Place(socket, groups), kinds)
        found = place.socket
        if found == socket and place.groups == groups:
            return None if _is_implicit(socket) else self._finite(socket, _numbers(socket, socket.type))
        if socket.type == "VECTOR" and self._passes_missing(place):
            return self._feeding(place.node.inputs["Normal"], place.groups)
        constant = self._constant(place)
        if constant is not None:
            return self._fixed(socket, found, self._along(constant, [*reversed(kinds), socket.type]))
        if not found.is_output or place.node.mute or place.node.type in HOLLOW:
            # A shader's socket that nothing feeds.
            return None
        if found.type == "SHADER":
            if socket.type != "SHADER":
                return None if _is_implicit(socket) else self._finite(socket, _numbers(socket, socket.type))
            kind = place.node.type
            is_nothing = kind not in FILLING if self._fills else kind in VOLUMES
            return None if is_nothing else Link(self._use(place), found.identifier)
        # A colour where a shader is asked for shines.
        shines = socket.type == "SHADER"
        kind = "RGBA" if shines else socket.type
        way = [*reversed(kinds), kind]
        link = Link(self._use(place), found.identifier, _through(way))
        if _becomes_whole(way):
            link = self._made("ShaderNodeMath", "Value", {"Value": link, "Value_001": 0.0}, {"operation": "TRUNC", "use_clamp": False})
        if _becomes_truth(way):
            link = self._truth(Link(self._use(place), found.identifier), way[0])
        return self._made("ShaderNodeEmission", "Emission", {"Color": link, "Strength": 1.0}) if shines else link

    def _passes_missing(self, place):
        """Whether a Bump raises nothing, and its normal comes from an image that is missing: that is no constant to Cycles, which ignores
        constant normals of such a Bump."""
        bump = place.node
        if not place.socket.is_output or bump.type != "BUMP" or isinstance(self._feeding(bump.inputs["Height"], place.groups), Link):
            return False
        ahead, seen = [Place(bump.inputs["Normal"], place.groups)], set()
        while ahead:
            source = self.walker.source(ahead.pop())
            node = source.node
            key = _key(source)
            if not source.socket.is_output or key in seen:
                continue
            seen.add(key)
            if node.type in _IMAGES and self.picture(node) is images.MISSING:
                return True
            ahead += [Place(each, source.groups) for each in node.inputs if each.enabled]
        return False

    def _use(self, place):
        node = place.node
        key = _key(place)
        if key not in self._known:
            self._known[key] = Use(node, place.groups)
        use = self._known[key]
        use.outputs.add(place.socket.identifier)
        return use

    def _fixed(self, socket, found, value):
        """Numbers at an input; where the input has none of its own, they come by a node."""
        if value is None:
            return None
        value = self._finite(found, value)
        if socket.type == "SHADER":
            return self._made("ShaderNodeEmission", "Emission", {"Color": value, "Strength": 1.0})
        if not _is_implicit(socket):
            return value
        # Before 5.0 the value of a group's socket does not count here, nor does it ever where it is hidden and a normal.
        if found.is_output and found.node.mute and found.type == socket.type and not INLINED:
            # A muted node that nothing feeds is cut out there.
            return None
        if not found.is_output and (not INLINED or (found.hide_value and socket.name != "Vector")):
            return None
        return self._made("ShaderNodeCombineXYZ", "Vector", dict(zip("XYZ", value)))

    def _made(self, kind, output, inputs, properties=None):
        use = Use(Made(kind, properties or {}), ())
        use.inputs, use.outputs = inputs, {output}
        self._known[id(use)] = use
        return Link(use, output)

    def _truth(self, link, kind):
        """Whether a value of that type is true, as a number."""
        if kind not in _NUMBERS:
            link = self._made("ShaderNodeVectorMath", "Value", {"Vector": link}, {"operation": "LENGTH"})
        return self._made("ShaderNodeMath", "Value", {"Value": link, "Value_001": 0.0}, {"operation": "GREATER_THAN", "use_clamp": False})

    def _along(self, constant, kinds):
        """A constant at the end of a link; None if its kind has no numbers."""
        value, kind = constant, kinds[0]
        if _becomes_truth(kinds):
            value = float(any(value[:3]) if isinstance(value, tuple) else value > 0)
            kind, kinds = "BOOLEAN", [kinds[-1]]
        for wanted in [*(() if INLINED else kinds[1:-1]), kinds[-1]]:
            if wanted == "SHADER":
                return _converted(value, kind, "RGBA")
            if wanted in _WHOLE and kind in _WIDTHS and wanted is not kinds[-1] and not INLINED:
                value, kind = float(math.trunc(_converted(value, kind, wanted))), wanted
            elif wanted in _WIDTHS and kind in _WIDTHS:
                value, kind = _converted(value, kind, wanted), wanted
        return value

    def _constant(self, place):
        """The numbers of an output or an unlinked input that are the same everywhere, or None."""
        node, socket = place.node, place.socket
        if not socket.is_output:
            return _numbers(socket, socket.type)
        zero = 0.0 if _WIDTHS.get(socket.type) == 1 else (0.0,) * _WIDTHS.get(socket.type, 0)
        if node.mute or node.type in HOLLOW:
            return zero if zero != () else None
        if node.type in {"RGB", "VALUE"} or (node.type == "NORMAL" and socket.identifier == "Normal"):
            return _numbers(socket, socket.type)
        told = self.lamp.value(node, socket.identifier) if self.lamp else None
        if told is not None:
            width = _WIDTHS[socket.type]
            return told[3] if socket.identifier == "Alpha" else told[0] if width == 1 else (*told[:3], 1.0)[:width]
        if node.type == "BLACKBODY":
            temperature = self._feeding(node.inputs["Temperature"], place.groups)
            return (*map(float, blackbody.color(temperature)), 1.0) if isinstance(temperature, float) else None
        if node.type in _IMAGES and self.picture(node) is images.MISSING:
            return 1.0 if socket.identifier == "Alpha" else (*images.MISSING, 1.0)
        if node.type == "ATTRIBUTE" and not node.attribute_name:
            return zero
        if node.type == "ATTRIBUTE" and node.attribute_type == "VIEW_LAYER":
            value = object_info.attribute_of(self.layer, node.attribute_name) if self.layer else None
            return _part(value or (0.0, 0.0, 0.0, 0.0), socket.identifier)
        if node.type == "VOLUME_INFO" and self.has_grids:
            return None
        of_vertices = node.type == "VERTEX_COLOR" or (node.type == "ATTRIBUTE" and node.attribute_type == "GEOMETRY" and not self.has_grids)
        if self._fills and of_vertices:
            # What lies between vertices has nothing of theirs.
            return zero
        if node.type == "TEX_POINTDENSITY" and node.object is None:
            # Of no points.
            return zero
        # Only surfaces can be strands and points, and only what is filled has grids.
        is_surface = self.table is None and not self._fills
        if node.type == "VOLUME_INFO" or (node.type in {"HAIR_INFO", "POINT_INFO"} and not is_surface):
            return zero
        if (node.type, socket.identifier) == ("LIGHT_PATH", "Portal Depth") and not _has_portals():
            return zero
        return None

    def picture(self, node):
        """The image that an Image Texture shows; images.MISSING if there is none."""
        key = node.as_pointer()
        if key not in self._pictures:
            image = node.image and images.picture_of(node.image, node.image_user)
            self._pictures[key] = images.MISSING if image is None or images.is_missing(image) else image
        return self._pictures[key]

    def missing(self):
        """The images of nodes that show that there is none."""
        return [p for p, found in self._pictures.items() if found is images.MISSING]

    def _image_objections(self, node):
        if node.type in _IMAGES and self.picture(node).source not in evaluated.IMAGE_SOURCES:
            yield f"{node.bl_label} ({self.picture(node).source.lower()})"
        elif node.type in _IMAGES and self.picture(node).source == "TILED" and not images.are_tiles_saved(self.picture(node)):
            yield f"{node.bl_label} (tiles that are not saved)"

    def _finite(self, socket, value):
        values = value if isinstance(value, tuple) else (value,)
        if value is None or all(map(math.isfinite, values)):
            return value
        self.not_finite.append(not_finite(socket))
        cleaned = tuple(v if math.isfinite(v) else 0.0 for v in values)
        return cleaned if isinstance(value, tuple) else cleaned[0]


def _attribute_objections(node):
    if node.type != "ATTRIBUTE" or node.attribute_type != "GEOMETRY":
        return
    if is_cycles_own(node.attribute_name):
        yield f"{node.bl_label} ({node.attribute_name})"


def _aov_outputs(tree):
    """All AOV Outputs of a tree, those in groups by the nodes of these."""
    stack, found, seen = [(tree, ())], [], 0
    while stack:
        tree, groups = stack.pop()
        for node in tree.nodes if tree is not None else ():
            seen += 1
            if seen > MOST_NODES:
                raise RecursionError(f"its groups amount to more than {MOST_NODES} nodes")
            if node.mute:
                continue
            if node.type == "OUTPUT_AOV":
                found.append((node, groups))
            elif node.type == "GROUP":
                stack.append((node.node_tree, (*groups, node)))
    return found


class Made:
    """A node that no tree has, in the place of a constant."""

    mute, type, texture_mapping, inputs, outputs = False, "MADE", None, (), ()

    def __init__(self, kind, properties):
        self.properties = properties
        self.bl_idname = self.bl_label = kind
        self.name = ""
