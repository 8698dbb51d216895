# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair, curves and points for tests."""

import math

import bpy
import numpy

EMISSION = "ShaderNodeEmission"


def hairy(name="ball", **settings):
    """A ball with a particle system of hair, whose settings these are."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=1)
    shown = bpy.context.object
    shown.name = name
    add_hair(shown, **settings)
    return shown


def add_hair(shown, name="hair", **settings):
    """Adds a particle system of hair to an object; returns its settings."""
    shown.modifiers.new(name, "PARTICLE_SYSTEM")
    made = shown.particle_systems[-1].settings
    made.type = "HAIR"
    for key, value in {"hair_length": 0.4, "render_step": 3, "display_step": 2, **settings}.items():
        setattr(made, key, value)
    return made


def _material(name):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    made.node_tree.nodes.clear()
    return made, made.node_tree, made.node_tree.nodes.new("ShaderNodeOutputMaterial")


def diffuse(color):
    """A material of a Diffuse BSDF."""
    made, tree, output = _material("diffuse")
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = color
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return made


def elliptic(aspect):
    """A material of fibres with elliptic sections."""
    made, tree, output = _material("fibres")
    shader = tree.nodes.new("ShaderNodeBsdfHairPrincipled")
    shader.model = "HUANG"
    shader.inputs["Aspect Ratio"].default_value = aspect
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return made


def shining(color):
    """A material that shines."""
    made, tree, output = _material("shining")
    shader = tree.nodes.new(EMISSION)
    shader.inputs["Color"].default_value = color
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return made


def outputs_of(kind):
    """Names of a node's outputs."""
    tree = bpy.data.node_groups.new("tree", "ShaderNodeTree")
    names = [socket.name for socket in tree.nodes.new(kind).outputs]
    bpy.data.node_groups.remove(tree)
    return names


def telling(kind, output, scale=1.0, **properties):
    """A material that shines with what a node tells: half of it, times `scale`, and a half."""
    made, tree, end = _material(f"{kind} {output}")
    node, moved, shader = (tree.nodes.new(k) for k in (kind, "ShaderNodeVectorMath", EMISSION))
    for key, value in properties.items():
        setattr(node, key, value)
    moved.operation = "MULTIPLY_ADD"
    moved.inputs[1].default_value, moved.inputs[2].default_value = (0.5 * scale,) * 3, (0.5,) * 3
    tree.links.new(node.outputs[output], moved.inputs[0])
    tree.links.new(moved.outputs[0], shader.inputs["Color"])
    tree.links.new(shader.outputs[0], end.inputs["Surface"])
    return made


def paint(mesh, name):
    """Gives a mesh's corners a colour of bytes each, by where they are."""
    layer = mesh.color_attributes.new(name, "BYTE_COLOR", "CORNER")
    corners = numpy.empty(len(mesh.loops), numpy.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    places = numpy.empty(len(mesh.vertices) * 3, numpy.float32)
    mesh.vertices.foreach_get("co", places)
    colors = numpy.ones((len(corners), 4), numpy.float32)
    colors[:, :3] = 0.5 + 0.5 * places.reshape(-1, 3)[corners]
    layer.data.foreach_set("color", colors.reshape(-1))


# Whether Blender's Python can change what type curves are of.
HAS_TYPES = "set_types" in bpy.types.Curves.bl_rna.functions


def curves(kind="CATMULL_ROM", cyclic=False, count=40):
    """Hair curves of that many bent strands of 3 to 7 keys, with a radius."""
    data = bpy.data.hair_curves.new("curves")
    sizes = [3 + number % 5 for number in range(count)]
    data.add_curves(sizes)
    if kind != "CATMULL_ROM":
        data.set_types(type=kind)
    places, radii = [], []
    for number, size in enumerate(sizes):
        x, y = -1.3 + 2.6 * (number % 8) / 7, -0.5 + 0.25 * (number // 8)
        for key in range(size):
            t = key / (size - 1)
            turn = 0.35 * math.sin(5 * t + number)
            places.append((x + turn, y, -1.2 + 2.4 * t * (0.6 + 0.4 * math.cos(number))))
            radii.append(0.06 * (1 - 0.7 * t))
    data.attributes["position"].data.foreach_set("vector", numpy.array(places, numpy.float32).reshape(-1))
    radius = data.attributes.get("radius") or data.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", numpy.array(radii, numpy.float32))
    if cyclic:
        closed = data.attributes.get("cyclic") or data.attributes.new("cyclic", "BOOLEAN", "CURVE")
        closed.data.foreach_set("value", [True] * count)
    return data


def give_attributes(data):
    """Attributes of all kinds for `curves`."""
    count, keys = len(data.curves), len(data.points)
    draw = numpy.random.default_rng(7).random

    def give(name, kind, domain, field, width):
        attribute = data.attributes.new(name, kind, domain)
        attribute.data.foreach_set(field, draw((count if domain == "CURVE" else keys) * width).astype(numpy.float32))

    give("pair_of_keys", "FLOAT2", "POINT", "vector", 2)
    give("pair_a", "FLOAT2", "CURVE", "vector", 2)
    give("pair_b", "FLOAT2", "CURVE", "vector", 2)
    give("number", "FLOAT", "CURVE", "value", 1)
    give("vector", "FLOAT_VECTOR", "POINT", "vector", 3)
    give("bytes", "BYTE_COLOR", "CURVE", "color", 4)


def points(scene, material=None, count=60):
    """An object that geometry nodes make a point cloud of, with radius, colours and a material."""
    draw = numpy.random.default_rng(3).random
    mesh = bpy.data.meshes.new("points")
    mesh.vertices.add(count)
    mesh.vertices.foreach_set("co", (2.4 * draw(count * 3) - 1.2).astype(numpy.float32))
    size = mesh.attributes.new("size", "FLOAT", "POINT")
    size.data.foreach_set("value", (0.05 + 0.15 * draw(count)).astype(numpy.float32))
    shade = mesh.attributes.new("shade", "FLOAT_COLOR", "POINT")
    shade.data.foreach_set("color", draw(count * 4).astype(numpy.float32))
    shown = bpy.data.objects.new("points", mesh)
    scene.collection.objects.link(shown)
    tree = bpy.data.node_groups.new("to points", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    named, made = tree.nodes.new("GeometryNodeInputNamedAttribute"), tree.nodes.new("GeometryNodeMeshToPoints")
    named.data_type = "FLOAT"
    named.inputs["Name"].default_value = "size"
    shaded = tree.nodes.new("GeometryNodeSetMaterial")
    shaded.inputs["Material"].default_value = material
    tree.links.new(start.outputs[0], made.inputs["Mesh"])
    tree.links.new(next(s for s in named.outputs if s.enabled), made.inputs["Radius"])
    tree.links.new(made.outputs[0], shaded.inputs[0])
    tree.links.new(shaded.outputs[0], end.inputs[0])
    shown.modifiers.new("points", "NODES").node_group = tree
    return shown
