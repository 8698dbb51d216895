# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes made with Blender that have the traps of real files: what an exporter is likely to miss, to double or to turn.

`SCENES`: name -> function(folder), which fills the empty session (`read_factory_settings(use_empty=True)`) with a scene, its
lamps, world and camera; files that it needs (a linked library) go to the folder. Works in Blender 4.2 to 5.0.

    PYTHON_WITH_BPY tests/parity/traps.py FOLDER [NAME...]      saves them as .blend files
"""

import math
import os
import sys

import bpy
import mathutils

SCENES = {}


def scene(function):
    """Enters a scene under its name, "trap-" before it."""
    SCENES["trap-" + function.__name__.replace("_", "-")] = function
    return function


# --- what the scenes are made of --------------------------------------------------------------------------------------

def material(name, color=(0.8, 0.8, 0.8), **inputs):
    """A Principled BSDF; inputs by their names with _ for a space."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1)
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    return made


def put(data, name, place=(0, 0, 0), turn=(0, 0, 0), size=(1, 1, 1), parent=None, collection=None):
    """A new object in the scene, or in a collection; angles in degrees."""
    thing = bpy.data.objects.new(name, data)
    thing.location, thing.rotation_euler, thing.scale = place, [math.radians(a) for a in turn], size
    thing.parent = parent
    (collection or bpy.context.scene.collection).objects.link(thing)
    return thing


def mesh(name, points, faces, *materials, smooth=False):
    """A mesh of corners and faces."""
    made = bpy.data.meshes.new(name)
    made.from_pydata(points, [], faces)
    for one in materials:
        made.materials.append(one)
    if smooth:
        made.shade_smooth()
    made.update()
    return made


def box(name, *materials):
    """A cube of side 2."""
    points = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    return mesh(name, points, [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)], *materials)


def grid(name, side, cells, *materials, height=lambda x, y: 0.0, smooth=False):
    """A square of cells x cells faces, with a UV map."""
    steps = range(cells + 1)
    at = [(side * (i / cells - 0.5), side * (j / cells - 0.5)) for j in steps for i in steps]
    corner = lambda i, j: j * (cells + 1) + i
    faces = [(corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)) for j in range(cells) for i in range(cells)]
    made = mesh(name, [(x, y, height(x, y)) for x, y in at], faces, *materials, smooth=smooth)
    layer = made.uv_layers.new(name="UVMap")
    for loop in made.loops:
        x, y = at[loop.vertex_index]
        layer.uv[loop.index].vector = (x / side + 0.5, y / side + 0.5)
    return made


def ball(name, *materials, rings=12):
    """A smooth ball of radius 1."""
    points = [(0, 0, -1)]
    for ring in range(1, rings):
        a = math.pi * ring / rings - math.pi / 2
        points += [(math.cos(a) * math.cos(b), math.cos(a) * math.sin(b), math.sin(a)) for b in (math.tau * k / (2 * rings) for k in range(2 * rings))]
    points.append((0, 0, 1))
    around, top = 2 * rings, len(points) - 1
    at = lambda ring, k: 1 + (ring - 1) * around + k % around
    faces = [(0, at(1, k + 1), at(1, k)) for k in range(around)] + [(top, at(rings - 1, k), at(rings - 1, k + 1)) for k in range(around)]
    faces += [(at(r, k), at(r, k + 1), at(r + 1, k + 1), at(r + 1, k)) for r in range(1, rings - 1) for k in range(around)]
    return mesh(name, points, faces, *materials, smooth=True)


def lamp(kind, name, place, target=(0, 0, 0.5), energy=100.0, parent=None, scale=(1, 1, 1), **settings):
    """A lamp that looks at a place (in the parent's space, if it has one)."""
    data = bpy.data.lights.new(name, kind)
    data.energy = energy
    for key, value in settings.items():
        if hasattr(data, key):
            setattr(data, key, value)
    made = put(data, name, place, size=scale, parent=parent)
    aim = mathutils.Vector(target) - mathutils.Vector(place)
    made.rotation_euler = aim.to_track_quat("-Z", "Y").to_euler()
    return made


def stage(width=6.0, floor=True, lamps=True, world=0.15):
    """A floor, a lamp of every kind, a dim world, and a camera that sees it all."""
    here = bpy.context.scene
    if floor:
        put(grid("floor", width * 2, 4, material("floor", (0.5, 0.5, 0.5), Roughness=0.9)), "floor")
    if lamps:
        lamp("SUN", "sun", (3, -2, 6), energy=1.0, angle=0.05)
        lamp("POINT", "point", (-width / 2, -width / 3, 2.5), energy=120, shadow_soft_size=0.2, color=(1, 0.85, 0.7), use_soft_falloff=False)
        lamp("SPOT", "spot", (width / 2, -width / 2, 4), energy=300, spot_size=0.9, spot_blend=0.3, shadow_soft_size=0.1, use_soft_falloff=False)
        lamp("AREA", "area", (0, width / 2, 4), energy=120, shape="RECTANGLE", size=2.0, size_y=1.0, color=(0.7, 0.85, 1))
    made = bpy.data.worlds.new("world")
    made.use_nodes = True
    made.node_tree.nodes["Background"].inputs["Color"].default_value = (world, world, world * 1.2, 1)
    here.world = made
    camera(width)


def camera(width, place=None, target=(0, 0, 0.6)):
    """Looks from the front and above."""
    data = bpy.data.cameras.new("camera")
    data.lens = 40
    place = mathutils.Vector(place or (width * 0.35, -width * 1.15, width * 0.55))
    made = put(data, "camera", place)
    made.rotation_euler = (mathutils.Vector(target) - place).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = made


def nodes_of(tree):
    """(nodes, link function) of a node tree."""
    return tree.nodes, lambda a, b: tree.links.new(a, b)


def principled(made):
    """The Principled BSDF of a material."""
    return made.node_tree.nodes["Principled BSDF"]


def picture(name, width, height, color):
    """An image in memory, packed: color(x, y) with both in 0..1, RGBA."""
    made = bpy.data.images.new(name, width, height, alpha=True)
    pixels = [c for j in range(height) for i in range(width) for c in color((i + 0.5) / width, (j + 0.5) / height)]
    made.pixels.foreach_set(pixels)
    made.update()
    made.pack()
    return made


# --- instances --------------------------------------------------------------------------------------------------------

@scene
def scatter(_folder):
    """Geometry nodes: cones and balls scattered on a hill, turned and scaled at random, the hill itself kept."""
    stage()
    green, red = material("green", (0.1, 0.5, 0.15)), material("red", (0.7, 0.1, 0.1), Roughness=0.2)
    # What is scattered lies in a collection that the scene does not render by itself.
    shelf = bpy.data.collections.new("shelf")
    put(ball("berry", red), "berry", size=(0.12, 0.12, 0.12), collection=shelf)
    leaf = mesh("leaf", [(0, 0, 0), (0.1, 0, 0.25), (0, 0, 0.5), (-0.1, 0, 0.25)], [(0, 1, 2, 3)], green)
    put(leaf, "leaf", collection=shelf)
    hill = put(grid("hill", 5, 24, material("earth", (0.3, 0.2, 0.1)), height=lambda x, y: 0.5 * math.cos(x) * math.cos(y) + 0.55, smooth=True), "hill")

    tree = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    nodes, link = nodes_of(tree)
    given, result = nodes.new("NodeGroupInput"), nodes.new("NodeGroupOutput")
    points, things = nodes.new("GeometryNodeDistributePointsOnFaces"), nodes.new("GeometryNodeCollectionInfo")
    places, join = nodes.new("GeometryNodeInstanceOnPoints"), nodes.new("GeometryNodeJoinGeometry")
    turn, scale = nodes.new("FunctionNodeRandomValue"), nodes.new("FunctionNodeRandomValue")
    points.inputs["Density"].default_value, points.inputs["Seed"].default_value = 12, 3
    things.inputs["Collection"].default_value = shelf
    things.inputs["Separate Children"].default_value = True
    places.inputs["Pick Instance"].default_value = True
    turn.data_type = "FLOAT_VECTOR"

    # Random Value has a socket of each name for each of its types, in an order that differs between Blenders.
    def typed(sockets, name, kind):
        return next(s for s in sockets if s.name == name and s.type == kind)

    for node, kind, least, most in ((turn, "VECTOR", (-0.4, -0.4, 0), (0.4, 0.4, math.tau)), (scale, "VALUE", 0.5, 1.5)):
        typed(node.inputs, "Min", kind).default_value, typed(node.inputs, "Max", kind).default_value = least, most
    for a, b in (
        (given.outputs[0], points.inputs["Mesh"]), (points.outputs["Points"], places.inputs["Points"]),
        (things.outputs[0], places.inputs["Instance"]), (typed(turn.outputs, "Value", "VECTOR"), places.inputs["Rotation"]),
        (typed(scale.outputs, "Value", "VALUE"), places.inputs["Scale"]), (places.outputs[0], join.inputs[0]), (given.outputs[0], join.inputs[0]),
        (join.outputs[0], result.inputs[0]),
    ):  # fmt: skip
        link(a, b)
    hill.modifiers.new("scatter", "NODES").node_group = tree


@scene
def collection_instances(_folder):
    """Collections placed by empties: offset, nested, turned, unevenly scaled, mirrored; and instances on faces and points."""
    stage()
    inner, outer = bpy.data.collections.new("inner"), bpy.data.collections.new("outer")
    put(ball("knob", material("gold", (0.9, 0.7, 0.3), Metallic=1.0, Roughness=0.3)), "knob", (0, 0, 0.8), size=(0.2, 0.2, 0.2), collection=inner)
    put(box("post", material("wood", (0.4, 0.2, 0.1))), "post", (0, 0, 0.3), size=(0.08, 0.16, 0.3), collection=inner)
    inner.instance_offset = (0.1, 0, 0)

    def place(instanced, name, *given, **named):
        empty = put(None, name, *given, **named)
        empty.instance_type, empty.instance_collection = "COLLECTION", instanced
        return empty

    for k in range(3):
        place(inner, f"row{k}", (k * 0.5 - 0.5, 0, 0), (0, 0, 30 * k), collection=outer)
    # A light in a collection is instanced as well.
    bulb = bpy.data.lights.new("bulb", "POINT")
    bulb.energy, bulb.shadow_soft_size = 15, 0.05
    put(bulb, "bulb", (0, -0.4, 0.7), collection=outer)
    place(outer, "as it is", (-1.5, 0, 0))
    place(outer, "uneven", (1.3, 0.5, 0), (0, 0, 40), (1.2, 0.6, 1.8))
    place(outer, "mirrored", (0, 1.8, 0), (10, 0, 0), (-1, 1, 1))
    parent = put(None, "parent", (0, -1.6, 0), (0, 0, 20), (1.5, 0.8, 1))
    place(inner, "child", (0.5, 0, 0), (0, 25, 0), parent=parent)

    roof = put(grid("roof", 1.2, 2, material("tile", (0.6, 0.2, 0.1))), "roof", (-2.2, -1.5, 0.5), (15, 0, 0))
    put(ball("pearl", material("pearl", (0.9, 0.9, 0.9))), "pearl", size=(0.1, 0.1, 0.1), parent=roof)
    roof.instance_type, roof.use_instance_faces_scale, roof.show_instancer_for_render = "FACES", True, True
    corners = put(mesh("corners", [(0, 0, 0), (0.5, 0, 0), (0, 0.5, 0.4)], []), "corners", (2.2, -1.6, 0.2))
    put(box("die", material("die", (0.1, 0.3, 0.7))), "die", size=(0.12, 0.12, 0.12), parent=corners)
    corners.instance_type = "VERTS"


@scene
def particles(_folder):
    """An old particle system that places objects, some of them unborn at this frame."""
    stage()
    here = bpy.context.scene
    stone = put(box("stone", material("stone", (0.4, 0.4, 0.45))), "stone", (0, 0, -50), size=(0.15, 0.15, 0.15))
    ground = put(grid("ground", 4, 8, material("moss", (0.2, 0.35, 0.1))), "ground", (0, 0, 0.05))
    system = ground.modifiers.new("stones", "PARTICLE_SYSTEM").particle_system
    settings = system.settings
    settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 60, 1, 20, 100
    settings.physics_type, settings.render_type, settings.instance_object = "NO", "OBJECT", stone
    settings.particle_size, settings.size_random, settings.use_rotation_instance = 1.0, 0.6, True
    system.seed = 4
    here.frame_set(10)


# --- kinds of objects -------------------------------------------------------------------------------------------------

@scene
def text(_folder):
    """Text: thick and bevelled, with a material for some letters, along a curve, flat and filled."""
    stage()
    data = bpy.data.curves.new("words", "FONT")
    data.body, data.extrude, data.bevel_depth, data.align_x = "Sundog\nparhelion", 0.08, 0.02, "CENTER"
    data.materials.append(material("letters", (0.8, 0.3, 0.05)))
    data.materials.append(material("first", (0.05, 0.2, 0.8), Roughness=0.2))
    data.body_format[0].material_index = 1
    put(data, "words", (0, 0, 1.4), (80, 0, 0))
    arc = bpy.data.curves.new("arc", "CURVE")
    arc.dimensions = "3D"
    spline = arc.splines.new("BEZIER")
    spline.bezier_points.add(1)
    for point, x in zip(spline.bezier_points, (-2, 2)):
        point.co, point.handle_left, point.handle_right = (x, 0, 0), (x - 0.8, 0, -0.9), (x + 0.8, 0, 0.9)
    path = put(arc, "arc", (0, -1.5, 0.4))
    flat = bpy.data.curves.new("flat", "FONT")
    flat.body, flat.size, flat.follow_curve = "along a curve", 0.5, path
    flat.materials.append(material("flat", (0.1, 0.6, 0.3)))
    put(flat, "flat", (0, -1.5, 0.4), (60, 0, 0))


@scene
def curves(_folder):
    """Curves: round bevel with varying radius, a bevel object and a taper, flat and filled with a hole, a NURBS surface."""
    stage()

    def bezier(name, points, **settings):
        data = bpy.data.curves.new(name, "CURVE")
        data.dimensions = settings.pop("dimensions", "3D")
        for key, value in settings.items():
            setattr(data, key, value)
        spline = data.splines.new("BEZIER")
        spline.bezier_points.add(len(points) - 1)
        for point, (co, radius) in zip(spline.bezier_points, points):
            point.co, point.radius, point.handle_left_type, point.handle_right_type = co, radius, "AUTO", "AUTO"
        return data

    hose = bezier("hose", [((-2, 0, 0.3), 1), ((-1, 0.8, 1.2), 0.4), ((0, -0.5, 0.6), 1.5), ((1, 0.3, 1.4), 0.7)], bevel_depth=0.12, use_fill_caps=True)
    hose.materials.append(material("hose", (0.7, 0.15, 0.1), Roughness=0.3))
    put(hose, "hose")
    profile = put(bezier("profile", [((0.15, 0, 0), 1), ((0, 0.25, 0), 1), ((-0.15, 0, 0), 1), ((0, -0.1, 0), 1)], dimensions="2D"), "profile", (0, 0, -20))
    profile.data.splines[0].use_cyclic_u = True
    taper = put(bezier("taper", [((0, 1.2, 0), 1), ((1, 0.3, 0), 1)]), "taper", (0, 0, -20))
    rail = bezier("rail", [((0, -1.6, 0.3), 1), ((1, -1.2, 0.9), 1), ((2.2, -1.6, 0.3), 1)], bevel_mode="OBJECT", bevel_object=profile, taper_object=taper)
    rail.materials.append(material("rail", (0.2, 0.3, 0.7), Metallic=1.0, Roughness=0.35))
    put(rail, "rail")
    plate = bezier("plate", [((-0.6, 0, 0), 1), ((0, 0.8, 0), 1), ((0.6, 0, 0), 1), ((0, -0.6, 0), 1)], dimensions="2D", fill_mode="BOTH", extrude=0.05)
    plate.splines[0].use_cyclic_u = True
    hole = plate.splines.new("POLY")
    hole.points.add(3)
    for point, (x, y) in zip(hole.points, ((-0.2, -0.15), (-0.2, 0.25), (0.2, 0.25), (0.2, -0.15))):
        point.co = (x, y, 0, 1)
    hole.use_cyclic_u = True
    plate.materials.append(material("plate", (0.2, 0.6, 0.2)))
    put(plate, "plate", (-1.8, -1.2, 0.8), (70, 0, 20))
    cloth = bpy.data.curves.new("cloth", "SURFACE")
    cloth.dimensions = "3D"
    spans = [cloth.splines.new("NURBS") for _ in range(4)]
    for j, span in enumerate(spans):
        span.points.add(3)
        for i, point in enumerate(span.points):
            point.co = (i * 0.5, j * 0.5, 0.5 * math.sin(i * 1.7) * math.cos(j * 1.3), 1)
    cloth.materials.append(material("cloth", (0.6, 0.5, 0.1)))
    sheet = put(cloth, "cloth", (0.8, 0.8, 1.0))
    # Four separate curves become one surface by an operator alone.
    bpy.context.view_layer.objects.active = sheet
    sheet.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.curve.select_all(action="SELECT")
    bpy.ops.curve.make_segment()
    bpy.ops.object.mode_set(mode="OBJECT")
    for span in cloth.splines:
        span.use_endpoint_u = span.use_endpoint_v = True
        span.order_u, span.order_v = 4, 4


@scene
def metaballs(_folder):
    """Metaballs: two objects of one family melt into each other (one has the mesh), a negative one, another family."""
    stage()

    def meta(name, color, *elements):
        data = bpy.data.metaballs.new(name)
        data.render_resolution, data.threshold = 0.08, 0.6
        for place, radius, kind, negative in elements:
            element = data.elements.new()
            element.co, element.radius, element.type, element.use_negative = place, radius, kind, negative
        data.materials.append(material(name, color, Roughness=0.3))
        return data

    put(meta("drop", (0.1, 0.4, 0.7), ((0, 0, 0), 1.1, "BALL", False), ((0.9, 0, 0.3), 0.9, "BALL", False), ((0.4, -0.7, 0.2), 0.6, "BALL", True)), "drop", (-1, 0, 0.9))
    put(meta("drop.001", (0.7, 0.1, 0.1), ((0, 0, 0), 1.0, "CAPSULE", False)), "drop.001", (0.6, 0.5, 0.9), (0, 30, 0))
    put(meta("other", (0.6, 0.6, 0.1), ((0, 0, 0), 0.9, "CUBE", False)), "other", (1.9, -0.8, 0.7), (0, 0, 30), (1, 1, 0.7))


# --- deformation and time ---------------------------------------------------------------------------------------------

@scene
def shape_keys(_folder):
    """Shape keys: mixed, relative to another key, masked by a vertex group, under a subdivision, driven, at a frame between."""
    stage()
    here = bpy.context.scene
    for index, (x, subdivided) in enumerate(((-1.5, False), (1.2, True))):
        thing = put(grid(f"sheet{index}", 2, 8, material(f"sheet{index}", (0.7, 0.4 * index, 0.2), Roughness=0.4), smooth=True), f"sheet{index}", (x, 0, 0.8), (25, 0, 0))
        thing.shape_key_add(name="Basis")
        wave, lift = thing.shape_key_add(name="wave"), thing.shape_key_add(name="lift")
        for k, vertex in enumerate(thing.data.vertices):
            x0, y0, _ = vertex.co
            wave.data[k].co = (x0, y0, 0.4 * math.sin(4 * x0))
            lift.data[k].co = (x0 * 0.7, y0, 0.4 * math.sin(4 * x0) + 0.5 * y0)
        lift.relative_key = wave
        group = thing.vertex_groups.new(name="half")
        group.add([v.index for v in thing.data.vertices if v.co.x > 0], 1.0, "REPLACE")
        wave.vertex_group = "half" if index else ""
        wave.value = 0.0
        wave.keyframe_insert("value", frame=1)
        wave.value = 1.0
        wave.keyframe_insert("value", frame=11)
        lift.value = 0.6
        if subdivided:
            modifier = thing.modifiers.new("smooth", "SUBSURF")
            # A render takes another level than the window.
            modifier.levels, modifier.render_levels = 0, 2
    driver = bpy.data.objects["sheet1"].data.shape_keys.key_blocks["lift"].driver_add("value").driver
    driver.type = "SUM"
    variable = driver.variables.new()
    variable.targets[0].id_type, variable.targets[0].id, variable.targets[0].data_path = "SCENE", here, "frame_current"
    driver.expression = ""
    curve = bpy.data.objects["sheet1"].data.shape_keys.animation_data.drivers[0]
    while curve.modifiers:
        curve.modifiers.remove(curve.modifiers[0])
    generator = curve.modifiers.new("GENERATOR")
    generator.coefficients = (0.0, 0.08)
    here.frame_set(6, subframe=0.5)


@scene
def armature(_folder):
    """A skinned arm in a pose, with preserved volume, and a thing held by a bone; the mesh is the armature's child."""
    stage()
    here = bpy.context.scene
    bones = bpy.data.armatures.new("bones")
    rig = put(bones, "rig", (-1, 0, 0.1), (0, 0, 25), (1.1, 1.1, 1.1))
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    names = ("lower", "middle", "upper")
    for k, name in enumerate(names):
        bone = bones.edit_bones.new(name)
        bone.head, bone.tail = (0, 0, 0.8 * k), (0, 0, 0.8 * (k + 1))
        if k:
            bone.parent, bone.use_connect = bones.edit_bones[names[k - 1]], True
    bpy.ops.object.mode_set(mode="OBJECT")
    rings, around = 25, 12
    points = [(0.25 * math.cos(math.tau * j / around), 0.25 * math.sin(math.tau * j / around), 2.4 * i / (rings - 1)) for i in range(rings) for j in range(around)]
    at = lambda i, j: i * around + j % around
    faces = [(at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)) for i in range(rings - 1) for j in range(around)]
    faces += [tuple(reversed(range(around))), tuple(at(rings - 1, j) for j in range(around))]
    arm = put(mesh("arm", points, faces, material("skin", (0.7, 0.4, 0.3)), smooth=True), "arm", parent=rig)
    for k, name in enumerate(names):
        group = arm.vertex_groups.new(name=name)
        for vertex in arm.data.vertices:
            weight = max(0.0, 1.0 - abs(vertex.co.z / 0.8 - k - 0.5))
            if weight > 0:
                group.add([vertex.index], weight, "REPLACE")
    modifier = arm.modifiers.new("pose", "ARMATURE")
    modifier.object, modifier.use_deform_preserve_volume = rig, True
    for name, angle in (("middle", 0.6), ("upper", 0.8)):
        bone = rig.pose.bones[name]
        bone.rotation_mode = "XYZ"
        bone.rotation_euler = (0, 0, 0)
        bone.keyframe_insert("rotation_euler", frame=1)
        bone.rotation_euler = (0.3, 0, angle * 2 if name == "upper" else 0)
        bone.rotation_euler.x = -2 * angle
        bone.keyframe_insert("rotation_euler", frame=21)
    held = put(ball("held", material("held", (0.1, 0.5, 0.8), Roughness=0.2)), "held", (0, 0.3, 0), size=(0.3, 0.3, 0.3), parent=rig)
    held.parent_type, held.parent_bone = "BONE", "upper"
    here.frame_set(11)


@scene
def modifiers(_folder):
    """Modifiers whose render differs from the window, in a stack: mirror, array, bevel, boolean, solidify, displace."""
    stage()
    wall = put(box("wall", material("brick", (0.6, 0.25, 0.15))), "wall", (-1.4, 0.5, 0.6), size=(0.6, 0.2, 0.6))
    drill = put(ball("drill", material("inside", (0.9, 0.9, 0.2))), "drill", (-1.4, 0.3, 0.7), size=(0.35, 0.6, 0.35))
    drill.hide_render = True
    cut = wall.modifiers.new("cut", "BOOLEAN")
    cut.object, cut.operation, cut.solver = drill, "DIFFERENCE", "EXACT"
    row = put(box("row", material("row", (0.2, 0.4, 0.7), Roughness=0.3)), "row", (0, -1, 0.2), size=(0.18, 0.18, 0.18))
    bevel = row.modifiers.new("edges", "BEVEL")
    bevel.width, bevel.segments = 0.25, 3
    array = row.modifiers.new("row", "ARRAY")
    array.count, array.relative_offset_displace = 5, (1.3, 0, 0.2)
    mirror = row.modifiers.new("mirror", "MIRROR")
    mirror.use_axis, mirror.mirror_object = (True, False, False), put(None, "axis", (-0.3, 0, 0))
    off = row.modifiers.new("off in the render", "WIREFRAME")
    off.show_render = False
    shell = put(grid("shell", 1.6, 4, material("shell", (0.7, 0.6, 0.2)), height=lambda x, y: 0.4 * x * y, smooth=True), "shell", (1.6, 0.4, 0.8), (40, 0, 0))
    finer = shell.modifiers.new("finer", "SUBSURF")
    finer.levels, finer.render_levels = 0, 2
    waves = bpy.data.textures.new("waves", "CLOUDS")
    displace = shell.modifiers.new("waves", "DISPLACE")
    displace.texture, displace.strength, displace.show_viewport = waves, 0.2, False
    thick = shell.modifiers.new("thick", "SOLIDIFY")
    thick.thickness = 0.1


@scene
def frames(_folder):
    """Everything moves: the picture is of frame 7 and a half; a constraint and a parent with an inverse matrix."""
    stage()
    here = bpy.context.scene
    thing = put(box("mover", material("mover", (0.8, 0.4, 0.1))), "mover", size=(0.4, 0.4, 0.4))
    for frame, place, turn in ((1, (-2, 0, 0.5), 0), (13, (2, 0, 1.5), 3)):
        thing.location, thing.rotation_euler = place, (0, turn, turn)
        thing.keyframe_insert("location", frame=frame)
        thing.keyframe_insert("rotation_euler", frame=frame)
    rider = put(ball("rider", material("rider", (0.1, 0.6, 0.3))), "rider", (0, 0, 1.5), size=(0.3, 0.3, 0.3))
    rider.parent = thing
    rider.matrix_parent_inverse = mathutils.Matrix.Translation((0.5, -0.5, 0)) @ mathutils.Matrix.Scale(2, 4)
    watcher = put(box("watcher", material("watcher", (0.3, 0.3, 0.8))), "watcher", (1.5, -1.5, 0.4), size=(0.2, 0.2, 0.5))
    constraint = watcher.constraints.new("TRACK_TO")
    constraint.target, constraint.track_axis, constraint.up_axis = thing, "TRACK_Z", "UP_Y"
    bulb = lamp("POINT", "blinking", (0, -1.5, 2), energy=0.0, shadow_soft_size=0.1)
    for frame, energy in ((1, 0.0), (13, 200.0)):
        bulb.data.energy = energy
        bulb.data.keyframe_insert("energy", frame=frame)
    paint = principled(thing.data.materials[0]).inputs["Base Color"]
    for frame, color in ((1, (1, 0, 0, 1)), (13, (0, 0, 1, 1))):
        paint.default_value = color
        paint.keyframe_insert("default_value", frame=frame)
    here.frame_set(7, subframe=0.5)


# --- transforms and visibility ----------------------------------------------------------------------------------------

@scene
def negative_scale(_folder):
    """Mirrored parents of turned children (their product shears), of lamps, of smooth things with normals."""
    stage(lamps=False)
    lamp("SUN", "sun", (3, -2, 6), energy=1.0, angle=0.05)
    mirror = put(None, "mirror", (-1.2, 0, 0.7), (0, 0, 30), (-1, 1.4, 1))
    put(ball("ball", material("ball", (0.6, 0.2, 0.5), Roughness=0.25)), "ball", (0.3, 0.4, 0), (20, 0, 30), (0.5, 0.4, 0.6), parent=mirror)
    sheared = put(box("box", material("box", (0.2, 0.5, 0.3))), "box", (-0.9, -0.6, 0), (15, 35, 20), (0.3, 0.4, 0.5), parent=mirror)
    put(box("grandchild", material("grandchild", (0.8, 0.6, 0.1))), "grandchild", (0, 0, 1.4), (30, 0, 0), (0.6, -0.5, 0.4), parent=sheared)
    thrice = put(grid("thrice", 1.2, 8, material("thrice", (0.2, 0.3, 0.8), Roughness=0.3), height=lambda x, y: 0.3 * math.sin(3 * x), smooth=True), "thrice", (1.4, 0.3, 0.9), (50, 0, 20), (-1, -1, -1))
    put(ball("flat", material("flat", (0.7, 0.7, 0.7))), "flat", (0, 0.9, 0.5), size=(0.4, 0.4, -0.15), parent=thrice)
    # Lamps below a mirrored and turned parent.
    rig = put(None, "rig", (0, 0, 0), (0, 0, 15), (-1.2, 1.2, 1.2))
    rigged_lamps(rig)
    lamp("AREA", "scaled", (2, 1, 3), energy=60, scale=(2, 0.5, -1), shape="ELLIPSE", size_y=0.6)


def rigged_lamps(rig):
    """An area lamp, a spot and a ball below a parent."""
    lamp("AREA", "area", (1.5, -1.5, 3), energy=80, parent=rig, shape="RECTANGLE", size=1.2, size_y=0.5)
    lamp("SPOT", "spot", (-2, -1.5, 3), energy=200, parent=rig, spot_size=0.8, spot_blend=0.2, shadow_soft_size=0.1, use_soft_falloff=False)
    lamp("POINT", "point", (0, 1.8, 2), energy=60, parent=rig, shadow_soft_size=0.25, use_soft_falloff=False)


@scene
def sheared_lamps(_folder):
    """Lamps that a parent shears: turned children of an unevenly scaled one."""
    stage(lamps=False)
    put(ball("ball", material("ball", (0.6, 0.6, 0.6), Roughness=0.4)), "ball", (0, 0, 0.6), size=(0.6, 0.6, 0.6))
    rigged_lamps(put(None, "rig", (0, 0, 0), (0, 0, 15), (-1.2, 0.8, 1)))


@scene
def hidden(_folder):
    """All the ways of being there or not: by object, collection and view layer; by kind of ray; lamps that are off or shadowless."""
    stage()
    here = bpy.context.scene
    shape = ball("ball", material("ball", (0.7, 0.3, 0.1), Roughness=0.4))

    def one(name, k, row=0, collection=None):
        return put(shape, name, (k * 0.7 - 2.1, 0.9 - 1.4 * row, 0.35), size=(0.3, 0.3, 0.3), collection=collection)

    def group(name, parent=None):
        made = bpy.data.collections.new(name)
        (parent or here.collection).children.link(made)
        return made

    layers = here.view_layers[0].layer_collection.children
    one("shown", 0)
    one("closed eye", 1).hide_set(True)
    one("off in the render", 2).hide_render = True
    one("off in the window", 3).hide_viewport = True
    excluded, hushed, eyed = group("excluded"), group("off in the render"), group("eyed")
    one("in an excluded collection", 4, collection=excluded)
    one("in a collection that is off", 5, collection=hushed)
    inner = group("inner", hushed)
    one("deeper", 5, row=-1, collection=inner)
    one("in a collection with a closed eye", 6, collection=eyed)
    layers["excluded"].exclude = True
    hushed.hide_render = True
    layers["eyed"].hide_viewport = True
    # Not linked to the scene at all, but kept by a user.
    loose = bpy.data.objects.new("loose", shape)
    loose.use_fake_user = True

    for k, switches in enumerate((
        {"visible_camera": False}, {"visible_shadow": False}, {"visible_diffuse": False}, {"visible_glossy": False}, {"visible_transmission": False},
    )):  # fmt: skip
        thing = one("without " + next(iter(switches)), k, row=1)
        for key, value in switches.items():
            setattr(thing, key, value)
    put(box("mirror", material("mirror", (0.9, 0.9, 0.9), Metallic=1.0, Roughness=0.3)), "mirror", (0, 2, 0.8), (-10, 0, 0), (2.4, 0.05, 0.8))
    # A hidden parent hides no child.
    parent = one("hidden parent", 5, row=1)
    parent.hide_render = True
    put(shape, "child", (3, 0, 0), size=(1, 1, 1), parent=parent)
    # A lamp that is off, and one that casts no shadows.
    lamp("POINT", "off", (0, 0, 2), energy=500).hide_render = True
    lamp("POINT", "no shadows", (-2, -2, 2), energy=40, shadow_soft_size=0.1, use_shadow=False, use_soft_falloff=False)


@scene
def lamps(_folder):
    """Every lamp in every shape, alone with grey things: colours, blends, spread, scaled and turned."""
    stage(lamps=False, world=0.02)
    for k in range(5):
        put(ball(f"ball{k}", material(f"ball{k}", (0.6, 0.6, 0.6), Roughness=0.15 * k + 0.1)), f"ball{k}", (k - 2.0, -0.2 + 0.4 * (k % 2), 0.35), size=(0.35, 0.35, 0.35))
    lamp("SUN", "sun", (-3, -1, 2), energy=0.5, angle=0.3, color=(1, 0.9, 0.6))
    lamp("POINT", "sharp", (-2.5, 1, 1.2), energy=30, shadow_soft_size=0.0)
    lamp("POINT", "ball", (-2.5, -1.5, 1.2), energy=30, shadow_soft_size=0.3, color=(1, 0.4, 0.3), use_soft_falloff=False)
    lamp("SPOT", "hard", (0, -2.5, 2.5), energy=150, spot_size=0.6, spot_blend=0.0, shadow_soft_size=0.0)
    lamp("SPOT", "soft", (2.5, -2.5, 2.5), (1, 0, 0.3), energy=250, spot_size=1.2, spot_blend=1.0, shadow_soft_size=0.3, color=(0.4, 0.6, 1), use_soft_falloff=False)
    lamp("SPOT", "squeezed", (1, 2.5, 2.5), energy=150, scale=(1, 0.5, 1), spot_size=0.9, spot_blend=0.2, shadow_soft_size=0.05, use_soft_falloff=False)
    lamp("AREA", "square", (-1.5, 2, 2), energy=20, shape="SQUARE", scale=(1.5, 1.5, 1.5))
    lamp("AREA", "rectangle", (0, 2.4, 2), energy=20, shape="RECTANGLE", size_y=0.2, color=(0.6, 1, 0.6))
    lamp("AREA", "disk", (1.8, 2, 2), energy=20, shape="DISK", scale=(0.7, 0.7, 0.7))
    lamp("AREA", "ellipse", (2.8, 0, 1.5), energy=20, shape="ELLIPSE", size_y=0.3, spread=1.0)


# --- meshes and materials ---------------------------------------------------------------------------------------------

@scene
def slots(_folder):
    """Materials: one a face, on the object instead of the mesh, an empty slot, none at all, an index beyond the slots."""
    stage()
    red, green, blue = (material(name, color) for name, color in (("red", (0.7, 0.1, 0.1)), ("green", (0.1, 0.6, 0.1)), ("blue", (0.1, 0.2, 0.7))))
    shared = box("shared", red, green)
    for k, face in enumerate(shared.polygons):
        face.material_index = k % 2
    put(shared, "as the mesh", (-2, 0, 0.5), (0, 0, 20), (0.5, 0.5, 0.5))
    own = put(shared, "as the object", (-0.6, 0, 0.5), (0, 0, 20), (0.5, 0.5, 0.5))
    own.material_slots[1].link, own.material_slots[1].material = "OBJECT", blue
    gap = box("gap", red, None, blue)
    for k, face in enumerate(gap.polygons):
        face.material_index = k % 3
    put(gap, "gap", (0.8, 0, 0.5), (0, 0, 20), (0.5, 0.5, 0.5))
    put(box("none"), "none", (2.2, 0, 0.5), (0, 0, 20), (0.5, 0.5, 0.5))
    beyond = box("beyond", green)
    for face in beyond.polygons:
        face.material_index = 7 if face.index % 2 else 0
    put(beyond, "beyond", (0, -1.5, 0.4), (0, 0, 40), (0.4, 0.4, 0.4))


@scene
def meshes(_folder):
    """Meshes with corners of their own: sharp edges, custom normals, hollow polygons, loose parts, nothing at all."""
    stage()
    shiny = material("shiny", (0.5, 0.5, 0.6), Roughness=0.25)
    sharp = put(box("sharp", shiny), "sharp", (-2, 0, 0.5), (0, 0, 30), (0.5, 0.5, 0.5))
    sharp.data.shade_smooth()
    sharp.modifiers.new("round", "BEVEL").width = 0.3
    for edge in sharp.data.edges:
        edge.use_edge_sharp = edge.index % 2 == 0
    bent = put(box("bent", shiny), "bent", (-0.7, 0, 0.5), (0, 0, 30), (0.5, 0.5, 0.5))
    bent.data.shade_smooth()
    bent.data.normals_split_custom_set_from_vertices([v.co.normalized().lerp((0, 0, 1), 0.3) for v in bent.data.vertices])
    star = [(math.cos(a) * r, math.sin(a) * r, 0) for k in range(10) for a, r in ((math.tau * k / 10, 0.8 if k % 2 else 0.3),)]
    put(mesh("star", star, [tuple(range(10))], shiny), "star", (0.8, 0, 0.8), (60, 0, 0))
    bowed = [(-0.5, -0.5, 0), (0.5, -0.5, 0.3), (0.5, 0.5, 0), (-0.5, 0.5, 0.3)]
    put(mesh("bowed", bowed, [(0, 1, 2, 3)], shiny), "bowed", (2, 0, 0.6), (30, 0, 0))
    loose = bpy.data.meshes.new("loose")
    loose.from_pydata([(0, 0, 0), (0.6, 0, 0), (0, 0.6, 0), (1, 1, 1), (1, 1, 2), (5, 5, 5)], [(3, 4)], [(0, 1, 2)])
    loose.materials.append(shiny)
    put(loose, "loose", (0, -1.6, 0.3), (40, 0, 0))
    put(bpy.data.meshes.new("empty"), "empty")
    flat = mesh("no area", [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 0, 1)], [(0, 1, 2), (0, 1, 3)], shiny)
    put(flat, "no area", (1.2, -1.6, 0.2))
    put(box("squashed", shiny), "squashed", (2.4, -1.2, 0.5), (0, 20, 0), (0.4, 0.4, 0))


@scene
def images(_folder):
    """Textures: two UV maps, mapped and repeated, clipped, cut-out alpha, a normal map, emission, vertex colours, packed."""
    stage()

    def textured(name, image, **settings):
        made = material(name)
        nodes, link = nodes_of(made.node_tree)
        node = nodes.new("ShaderNodeTexImage")
        node.image = image
        for key, value in settings.items():
            setattr(node, key, value)
        return made, node, link, nodes

    checks = picture("checks", 32, 16, lambda x, y: (*((0.9, 0.8, 0.2) if (int(x * 8) + int(y * 4)) % 2 else (0.1, 0.2, 0.5)), 1))
    stripes = picture("stripes", 16, 16, lambda x, y: (x, y, 0.3, 1))
    holes = picture("holes", 64, 64, lambda x, y: (0.3, 0.6, 0.2, float((x * 3 % 1 - 0.5) ** 2 + (y * 3 % 1 - 0.5) ** 2 > 0.1)))
    bumps = picture("bumps", 64, 64, lambda x, y: (0.5 + 0.3 * math.cos(30 * x), 0.5 + 0.3 * math.cos(30 * y), 0.9, 1))
    bumps.colorspace_settings.name = "Non-Color"

    one, node, link, nodes = textured("mapped", checks)
    place, mapping = nodes.new("ShaderNodeUVMap"), nodes.new("ShaderNodeMapping")
    place.uv_map = "second"
    mapping.inputs["Rotation"].default_value, mapping.inputs["Scale"].default_value = (0, 0, 0.5), (2, 3, 1)
    link(place.outputs[0], mapping.inputs[0])
    link(mapping.outputs[0], node.inputs[0])
    link(node.outputs[0], principled(one).inputs["Base Color"])
    sheet = grid("two maps", 1.6, 2, one)
    second = sheet.uv_layers.new(name="second")
    for loop in sheet.loops:
        second.uv[loop.index].vector = (sheet.uv_layers[0].uv[loop.index].vector.y * 2, sheet.uv_layers[0].uv[loop.index].vector.x)
    put(sheet, "two maps", (-2, 0.4, 0.9), (70, 0, 15))

    one, node, link, _ = textured("clipped", stripes, extension="CLIP", interpolation="Closest")
    link(node.outputs[0], principled(one).inputs["Base Color"])
    sheet = grid("clipped", 1.6, 1, one)
    for loop in sheet.loops:
        sheet.uv_layers[0].uv[loop.index].vector = sheet.uv_layers[0].uv[loop.index].vector * 1.6 - mathutils.Vector((0.3, 0.3))
    put(sheet, "clipped", (-0.2, 0.8, 0.9), (75, 0, 0))

    one, node, link, _ = textured("cut out", holes)
    link(node.outputs[0], principled(one).inputs["Base Color"])
    link(node.outputs[1], principled(one).inputs["Alpha"])
    put(grid("cut out", 1.6, 1, one), "cut out", (1.6, 0.4, 0.9), (75, 0, -15))

    one, node, link, nodes = textured("bumped", bumps)
    bump = nodes.new("ShaderNodeNormalMap")
    bump.inputs["Strength"].default_value = 0.7
    link(node.outputs[0], bump.inputs["Color"])
    link(bump.outputs[0], principled(one).inputs["Normal"])
    principled(one).inputs["Roughness"].default_value = 0.3
    put(grid("bumped", 1.4, 1, one), "bumped", (-1.2, -1.3, 0.4), (30, 0, 0))

    one, node, link, _ = textured("glowing", checks)
    link(node.outputs[0], principled(one).inputs["Emission Color"])
    principled(one).inputs["Emission Strength"].default_value = 1.5
    put(grid("glowing", 1.0, 1, one), "glowing", (0.5, -1.4, 0.4), (45, 0, 0))

    one = material("painted")
    nodes, link = nodes_of(one.node_tree)
    color = nodes.new("ShaderNodeVertexColor")
    color.layer_name = "paint"
    link(color.outputs[0], principled(one).inputs["Base Color"])
    sheet = grid("painted", 1.2, 4, one)
    paint = sheet.color_attributes.new("paint", "FLOAT_COLOR", "CORNER")
    for loop in sheet.loops:
        x, y, _ = sheet.vertices[loop.vertex_index].co
        paint.data[loop.index].color = (x / 1.2 + 0.5, y / 1.2 + 0.5, 0.2, 1)
    put(sheet, "painted", (1.9, -1.3, 0.4), (40, 0, 0))


@scene
def procedural(_folder):
    """Node trees without images: noise, ramps, checkers, Voronoi, bricks, gradients, mixes, bumps, groups, object coordinates."""
    stage()

    def ball_with(name, k, build, **inputs):
        made = material(name, **inputs)
        nodes, link = nodes_of(made.node_tree)
        build(nodes, link, principled(made))
        place = (-2.2 + 1.1 * (k % 5), 0.6 - 1.5 * (k // 5), 0.5)
        put(ball(name, made, rings=16), name, place, (10 * k, 0, 20), (0.45, 0.45, 0.45))

    def coordinates(nodes, link, texture, output="Object", scale=3.0):
        source = nodes.new("ShaderNodeTexCoord")
        link(source.outputs[output], texture.inputs["Vector"])
        if "Scale" in texture.inputs:
            texture.inputs["Scale"].default_value = scale
        return texture

    def noise(nodes, link, shader):
        texture, ramp = coordinates(nodes, link, nodes.new("ShaderNodeTexNoise")), nodes.new("ShaderNodeValToRGB")
        ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.8, 0.1, 0.05, 1), (0.05, 0.2, 0.6, 1)
        ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.35, 0.65
        link(texture.outputs[0], ramp.inputs[0])
        link(ramp.outputs[0], shader.inputs["Base Color"])

    def checker(nodes, link, shader):
        texture = coordinates(nodes, link, nodes.new("ShaderNodeTexChecker"), "Generated", 6)
        link(texture.outputs["Color"], shader.inputs["Base Color"])

    def voronoi(nodes, link, shader):
        texture = coordinates(nodes, link, nodes.new("ShaderNodeTexVoronoi"))
        link(texture.outputs["Color"], shader.inputs["Base Color"])
        link(texture.outputs["Distance"], shader.inputs["Roughness"])

    def bricks(nodes, link, shader):
        texture = coordinates(nodes, link, nodes.new("ShaderNodeTexBrick"), "Object", 4)
        link(texture.outputs["Color"], shader.inputs["Base Color"])

    def bump(nodes, link, shader):
        texture, bumped = coordinates(nodes, link, nodes.new("ShaderNodeTexNoise"), scale=8), nodes.new("ShaderNodeBump")
        bumped.inputs["Strength"].default_value = 0.6
        link(texture.outputs[0], bumped.inputs["Height"])
        link(bumped.outputs[0], shader.inputs["Normal"])

    def mixed(nodes, link, shader):
        output = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
        glossy, mix, fresnel = nodes.new("ShaderNodeBsdfAnisotropic"), nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeFresnel")
        glossy.inputs["Roughness"].default_value = 0.1
        link(fresnel.outputs[0], mix.inputs[0])
        link(shader.outputs[0], mix.inputs[1])
        link(glossy.outputs[0], mix.inputs[2])
        link(mix.outputs[0], output.inputs["Surface"])

    def maths(nodes, link, shader):
        color, hue, gamma = nodes.new("ShaderNodeRGB"), nodes.new("ShaderNodeHueSaturation"), nodes.new("ShaderNodeGamma")
        color.outputs[0].default_value = (0.2, 0.5, 0.1, 1)
        hue.inputs["Hue"].default_value, hue.inputs["Saturation"].default_value, gamma.inputs["Gamma"].default_value = 0.7, 1.4, 0.8
        link(color.outputs[0], hue.inputs["Color"])
        link(hue.outputs[0], gamma.inputs["Color"])
        link(gamma.outputs[0], shader.inputs["Base Color"])

    def grouped(nodes, link, shader):
        tree = bpy.data.node_groups.new("tint", "ShaderNodeTree")
        tree.interface.new_socket("Amount", in_out="INPUT", socket_type="NodeSocketFloat")
        tree.interface.new_socket("Color", in_out="OUTPUT", socket_type="NodeSocketColor")
        inner, join = nodes_of(tree)
        given, result, combine = inner.new("NodeGroupInput"), inner.new("NodeGroupOutput"), inner.new("ShaderNodeCombineColor")
        combine.inputs[1].default_value = 0.4
        join(given.outputs[0], combine.inputs[0])
        join(combine.outputs[0], result.inputs[0])
        group = nodes.new("ShaderNodeGroup")
        group.node_tree = tree
        group.inputs[0].default_value = 0.7
        link(group.outputs[0], shader.inputs["Base Color"])

    def perobject(nodes, link, shader):
        info = nodes.new("ShaderNodeObjectInfo")
        link(info.outputs["Color"], shader.inputs["Base Color"])

    def gradient(nodes, link, shader):
        texture = coordinates(nodes, link, nodes.new("ShaderNodeTexGradient"), "Generated")
        link(texture.outputs["Color"], shader.inputs["Base Color"])

    for k, build in enumerate((noise, checker, voronoi, bricks, bump, mixed, maths, grouped, perobject, gradient)):
        ball_with(build.__name__, k, build, Roughness=0.5)
    bpy.data.objects["perobject"].color = (0.1, 0.6, 0.6, 1)


@scene
def world_nodes(_folder):
    """A world that is no plain colour: a sky with its sun, mixed with another background by the kind of ray."""
    stage(lamps=False)
    put(ball("mirror", material("mirror", (0.9, 0.9, 0.9), Metallic=1.0, Roughness=0.1)), "mirror", (-0.9, 0, 0.7), size=(0.7, 0.7, 0.7))
    put(ball("chalk", material("chalk", (0.7, 0.7, 0.7), Roughness=1.0)), "chalk", (0.9, 0, 0.7), size=(0.7, 0.7, 0.7))
    tree = bpy.context.scene.world.node_tree
    nodes, link = nodes_of(tree)
    nodes.clear()
    ramp, source, split = nodes.new("ShaderNodeValToRGB"), nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeSeparateXYZ")
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.9, 0.5, 0.3, 1), (0.2, 0.4, 0.9, 1)
    background, output = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeOutputWorld")
    link(source.outputs["Generated"], split.inputs[0])
    link(split.outputs["Z"], ramp.inputs[0])
    link(ramp.outputs[0], background.inputs["Color"])
    link(background.outputs[0], output.inputs["Surface"])


# --- libraries --------------------------------------------------------------------------------------------------------

@scene
def linked_library(folder):
    """Things of another .blend file: an object, a collection instance, an override that moved, and a material alone."""
    os.makedirs(folder, exist_ok=True)
    library = os.path.join(folder, "library.blend")
    shelf = bpy.data.collections.new("shelf")
    put(ball("linked ball", material("linked red", (0.7, 0.1, 0.1), Roughness=0.3)), "linked ball", (0, 0, 0.5), size=(0.4, 0.4, 0.4), collection=shelf)
    put(box("linked box", material("linked blue", (0.1, 0.2, 0.7))), "linked box", (0, 0, 0.1), size=(0.6, 0.6, 0.1), collection=shelf)
    bpy.data.libraries.write(library, {shelf}, fake_user=True)
    for thing in list(shelf.objects):
        data = thing.data
        materials = list(data.materials)
        bpy.data.objects.remove(thing)
        bpy.data.meshes.remove(data)
        for one in materials:
            bpy.data.materials.remove(one)
    bpy.data.collections.remove(shelf)

    stage()
    here = bpy.context.scene
    with bpy.data.libraries.load(library, link=True, relative=False) as (_there, wanted):
        wanted.collections, wanted.objects, wanted.materials = ["shelf"], ["linked ball"], ["linked blue"]
    empty = put(None, "instance", (-1.6, 0, 0), (0, 0, 30), (1.2, 1.2, 1.2))
    empty.instance_type, empty.instance_collection = "COLLECTION", wanted.collections[0]
    here.collection.objects.link(wanted.objects[0])
    moved = wanted.objects[0].override_create()
    moved.location = (1.6, 0, 0.8)
    here.collection.objects.link(moved)
    put(box("local", wanted.materials[0]), "local", (0, -1.6, 0.3), (0, 0, 20), (0.3, 0.3, 0.3))


def main():
    folder, names = sys.argv[1], sys.argv[2:]
    for name, build in SCENES.items():
        if names and name not in names:
            continue
        bpy.ops.wm.read_factory_settings(use_empty=True)
        place = os.path.join(folder, name)
        os.makedirs(place, exist_ok=True)
        build(place)
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(place, f"{name}.blend"))


if __name__ == "__main__":
    main()
