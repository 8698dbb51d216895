# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader trees that Blender makes for Cycles, where a tree has what Blender alone resolves."""

import bpy

# What is in trees beside shaders' own nodes, and is resolved or evaluated.
_RESOLVED = {
    "NodeReroute", "NodeGroupInput", "NodeGroupOutput", "NodeFrame",
    "FunctionNodeIntegerMath", "FunctionNodeBooleanMath", "FunctionNodeGetVectorComponent",
}  # fmt: skip


# Nodes at which trees end.
_ENDS = {"OUTPUT_MATERIAL", "OUTPUT_WORLD", "OUTPUT_LIGHT"}


def ends_in_a_group(tree):
    """Whether some group of a tree has an output of materials, worlds or lamps."""
    open_trees, seen = [tree], set()
    while open_trees:
        inner = open_trees.pop()
        if inner is None or inner.as_pointer() in seen:
            continue
        seen.add(inner.as_pointer())
        if inner != tree and any(node.type in _ENDS for node in inner.nodes):
            return True
        open_trees += [node.node_tree for node in inner.nodes if node.type == "GROUP"]
    return False


# Types whose values lose something where a group takes those of others, and the others that they hold whole.
_NARROW = {"VALUE": {"INT", "BOOLEAN"}, "INT": {"BOOLEAN"}, "BOOLEAN": set()}


def _converts(link):
    """Whether a group takes another type than what is linked to it: Blender converts constants there."""
    before, after = link.from_socket.type, link.to_socket.type
    if link.to_node.type not in {"GROUP", "GROUP_OUTPUT"} or after not in _NARROW:
        return False
    return before not in {after, "SHADER", *_NARROW[after]}


def _passes_nothing(tree):
    """Whether a muted node passes an input on that nothing is linked to: what asks for it takes its own value."""
    muted = [node for node in tree.nodes if node.mute]
    hollow = any(node.type == "REROUTE" and not node.inputs[0].is_linked for node in tree.nodes)
    return any(hollow or not link.from_socket.is_linked for node in muted for link in node.internal_links)


def _asks_for_blender(tree):
    """Whether a tree has what Blender alone resolves: menus, repeated zones, closures, bundles, texts, links in a circle, constants
    that groups convert, and muted nodes that pass nothing on."""
    # An output inside of a group counts where there is no other.
    if ends_in_a_group(tree):
        return True
    open_trees, seen = [tree], set()
    while open_trees:
        tree = open_trees.pop()
        if tree.as_pointer() in seen:
            continue
        seen.add(tree.as_pointer())
        for node in tree.nodes:
            if not node.bl_idname.startswith("ShaderNode") and node.bl_idname not in _RESOLVED:
                return True
            if node.type == "GROUP" and node.node_tree is not None:
                open_trees.append(node.node_tree)
        if _passes_nothing(tree) or any(map(_converts, tree.links)):
            return True
        # Links to sockets that a node's settings switch off are not valid either.
        if any(not link.is_valid and link.from_socket.enabled and link.to_socket.enabled for link in tree.links):
            return True
    return False


def inlined(data):
    """The tree that Blender makes for Cycles, kept by what it belongs to; None where the tree's own nodes are all there is."""
    if data.node_tree is None or not _asks_for_blender(data.node_tree):
        return None
    kinds = ((bpy.types.Material, "material"), (bpy.types.World, "world"), (bpy.types.Light, "light"))
    of = next((getattr(bpy.types.InlineShaderNodes, f"from_{name}") for kind, name in kinds if isinstance(data, kind)), None)
    return of and of(data)
