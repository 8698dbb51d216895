# SPDX-License-Identifier: MIT OR Apache-2.0
"""What the scene scripts share: materials, meshes, lights, cameras and procedural pictures, made with bpy.

Everything here keeps to what the stock glTF exporter carries exactly, so that Cycles (which renders the .blend) and
Sundog (which renders the .glb) are given the same scene. Lengths are metres, angles degrees unless a name says
otherwise, colours scene-linear Rec.709, Z up as in Blender.
"""

import math
import os
import struct
import zlib

import bpy
import numpy as np
from mathutils import Matrix, Vector


# --- the empty file ------------------------------------------------------------------------------------------------


def start_empty(width, height):
    """An empty factory file, Cycles chosen, with a black world and the picture's size set."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = width
    scene.render.resolution_y = height
    scene.render.resolution_percentage = 100
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    scene.world = world
    background(0.0)
    return scene


def link(thing, name):
    """Puts a new object that holds `thing` (mesh, light or camera) into the scene."""
    holder = bpy.data.objects.new(name, thing)
    bpy.context.scene.collection.objects.link(holder)
    return holder


# --- the camera ------------------------------------------------------------------------------------------------------


def look_from(position, target, name="Camera", degrees=None, orthographic_scale=None):
    """The camera at `position` looks at `target`; `degrees` is the angle of view along the picture's longer side."""
    data = bpy.data.cameras.new(name)
    data.clip_start, data.clip_end = 0.01, 10_000.0
    if orthographic_scale is not None:
        data.type = "ORTHO"
        data.ortho_scale = orthographic_scale
    else:
        data.angle = math.radians(degrees)
    holder = link(data, name)
    holder.matrix_world = facing(position, target)
    bpy.context.scene.camera = holder
    return holder


def focus(camera, distance, f_stop):
    """Gives a camera a lens: sharp at `distance` along the line of sight, with Cycles' aperture of `f_stop`."""
    lens = camera.data.dof
    lens.use_dof, lens.focus_distance, lens.aperture_fstop = True, distance, f_stop


def facing(position, target):
    """The matrix that puts an object at `position` with its -Z axis towards `target` and its Y axis as upright as can be."""
    direction = Vector(target) - Vector(position)
    return Matrix.Translation(Vector(position)) @ direction.to_track_quat("-Z", "Y").to_matrix().to_4x4()


# --- lights ----------------------------------------------------------------------------------------------------------


def lamp(kind, name, position, watts, color=(1.0, 1.0, 1.0), radius=0.0):
    """A POINT or SPOT light. It shines as a true sphere of `radius`, not as Blender's disk of "soft falloff"."""
    data = bpy.data.lights.new(name, kind)
    data.energy = watts
    data.color = color
    data.shadow_soft_size = radius
    data.use_soft_falloff = False
    holder = link(data, name)
    holder.location = position
    return holder


def spot(name, position, target, watts, cone, blend, color=(1.0, 1.0, 1.0), radius=0.0):
    """A spot light with the full opening angle `cone` in degrees and Blender's `blend` (0 hard, 1 softest)."""
    holder = lamp("SPOT", name, position, watts, color, radius)
    holder.data.spot_size = math.radians(cone)
    holder.data.spot_blend = blend
    holder.matrix_world = facing(position, target)
    return holder


def sun(name, towards, strength, color=(1.0, 1.0, 1.0), angle=0.0):
    """A sun whose light travels along `towards`; `strength` in W/m2, `angle` its full angular diameter in degrees."""
    data = bpy.data.lights.new(name, "SUN")
    data.energy = strength
    data.color = color
    data.angle = math.radians(angle)
    holder = link(data, name)
    holder.matrix_world = facing((0.0, 0.0, 0.0), towards)
    return holder


# --- the world -------------------------------------------------------------------------------------------------------


def background(strength, color=(1.0, 1.0, 1.0)):
    """A constant world."""
    tree = bpy.context.scene.world.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeBackground")
    shader.inputs["Color"].default_value = (*color, 1.0)
    shader.inputs["Strength"].default_value = strength
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(shader.outputs["Background"], output.inputs["Surface"])
    return tree, shader


def environment(path, strength=1.0, rotation=0.0):
    """An equirectangular picture round the scene; `rotation` degrees is the Z rotation of a Mapping node of type Point.

    Such a node turns the direction that is looked up: what the picture shows at azimuth a appears at a - rotation.
    """
    tree, shader = background(strength)
    picture = tree.nodes.new("ShaderNodeTexEnvironment")
    picture.image = bpy.data.images.load(path)
    picture.interpolation = "Linear"
    mapping = tree.nodes.new("ShaderNodeMapping")
    mapping.vector_type = "POINT"
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, math.radians(rotation))
    coordinate = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinate.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], picture.inputs["Vector"])
    tree.links.new(picture.outputs["Color"], shader.inputs["Color"])


def sky_directions(width, height):
    """The direction (Z up) that each pixel of an equirectangular picture shows in Blender; row 0 is the zenith.

    The middle column is +X and azimuth grows to the left: u = 1/2 - atan2(y, x) / 2 pi.
    """
    azimuth = (0.5 - (np.arange(width) + 0.5) / width) * 2.0 * math.pi
    elevation = (0.5 - (np.arange(height) + 0.5) / height) * math.pi
    x = np.cos(elevation)[:, None] * np.cos(azimuth)[None, :]
    y = np.cos(elevation)[:, None] * np.sin(azimuth)[None, :]
    z = np.broadcast_to(np.sin(elevation)[:, None], x.shape)
    return np.stack([x, y, z], axis=-1)


def sky_picture(width, height, sun_direction=None, sun_radiance=0.0, sun_radius=1.2, clouds=0.0):
    """A procedural sky: blue above, bright at the horizon, warm ground below, and a small sun if wanted."""
    direction = sky_directions(width, height)
    up = direction[..., 2]
    zenith, horizon, ground = np.array([0.06, 0.15, 0.45]), np.array([0.42, 0.52, 0.66]), np.array([0.11, 0.09, 0.07])
    blend = np.clip(up, 0.0, 1.0)[..., None] ** 0.45
    picture = horizon * (1.0 - blend) + zenith * blend
    below = np.clip(-up * 12.0, 0.0, 1.0)[..., None]
    picture = picture * (1.0 - below) + ground * below
    if clouds > 0.0:
        height_of_layer = np.maximum(up, 0.06)
        cover = fractal_noise(direction[..., 0] / height_of_layer * 0.7, direction[..., 1] / height_of_layer * 0.7, 11)
        cover = np.clip((cover - 0.5) * 3.0, 0.0, 1.0) * np.clip(up * 6.0 - 0.3, 0.0, 1.0) * clouds
        picture = picture * (1.0 - cover[..., None]) + np.array([1.0, 0.98, 0.95]) * cover[..., None]
    if sun_direction is not None:
        towards = np.asarray(sun_direction, float) / np.linalg.norm(sun_direction)
        cosine = direction @ towards
        halo = np.exp((cosine - 1.0) * 60.0) * 1.6 + np.exp((cosine - 1.0) * 600.0) * 6.0
        above = np.clip(up * 20.0 + 1.0, 0.0, 1.0)
        picture = picture + (halo * above)[..., None] * np.array([1.0, 0.82, 0.58])
        edge = math.radians(sun_radius)
        disc = np.clip((edge - np.arccos(np.clip(cosine, -1.0, 1.0))) / (math.pi / height) + 0.5, 0.0, 1.0)
        picture = picture + disc[..., None] * sun_radiance * np.array([1.0, 0.92, 0.78])
    return picture.astype(np.float32)


def write_hdr(path, picture):
    """Writes a Radiance .hdr (flat RGBE scan lines) from an array of height x width x 3, row 0 on top."""
    height, width, _ = picture.shape
    brightest = picture.max(axis=2)
    _, exponent = np.frexp(brightest)
    scale = np.where(brightest > 1e-32, np.ldexp(256.0, -exponent), 0.0)
    pixels = np.zeros((height, width, 4), np.uint8)
    pixels[..., :3] = np.clip(picture * scale[..., None], 0.0, 255.0)
    pixels[..., 3] = np.where(brightest > 1e-32, exponent + 128, 0)
    with open(path, "wb") as file:
        file.write(f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode())
        for row in pixels:
            # Scan lines of new-style run-length code, each channel in literal runs of at most 128 bytes: every reader
            # takes these, while flat ones are ambiguous when a line begins with (2, 2, ...).
            file.write(bytes([2, 2, width >> 8, width & 255]))
            for channel in range(4):
                line = row[:, channel].tobytes()
                for start in range(0, width, 128):
                    part = line[start : start + 128]
                    file.write(bytes([len(part)]) + part)


# --- procedural pictures for textures ----------------------------------------------------------------------------------


def value_noise(x, y, seed, period=None):
    """Smooth noise in 0..1 on a lattice of step 1; with `period` it repeats after so many steps."""
    cell_x, cell_y = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    part_x, part_y = x - cell_x, y - cell_y
    part_x, part_y = part_x * part_x * (3 - 2 * part_x), part_y * part_y * (3 - 2 * part_y)

    def corner(i, j):
        i, j = (i % period, j % period) if period else (i, j)
        mixed = (i * 374761393 + j * 668265263 + seed * 2246822519) & 0xFFFFFFFF
        mixed = ((mixed ^ (mixed >> 13)) * 1274126177) & 0xFFFFFFFF
        return ((mixed ^ (mixed >> 16)) & 0xFFFF) / 65535.0

    lower = corner(cell_x, cell_y) * (1 - part_x) + corner(cell_x + 1, cell_y) * part_x
    upper = corner(cell_x, cell_y + 1) * (1 - part_x) + corner(cell_x + 1, cell_y + 1) * part_x
    return lower * (1 - part_y) + upper * part_y


def fractal_noise(x, y, seed, octaves=5, period=None):
    """Octaves of `value_noise`, in 0..1."""
    total, weight, amount = 0.0, 0.0, 1.0
    for octave in range(octaves):
        step = 2**octave
        total = total + amount * value_noise(x * step, y * step, seed + octave, period * step if period else None)
        weight += amount
        amount *= 0.5
    return total / weight


def texture_grid(size):
    """Texture coordinates (u, v) of the pixels' middles; row 0 is v near 1, as the picture's top row in Blender."""
    middle = (np.arange(size) + 0.5) / size
    return np.broadcast_to(middle[None, :], (size, size)), np.broadcast_to(middle[::-1, None], (size, size))


def to_srgb(linear):
    """The sRGB transfer function (IEC 61966-2-1), for values in 0..1."""
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)


def normals_from_height(height, strength):
    """A tangent-space normal map (OpenGL's Y) in 0..1 of a height field that repeats; `strength` scales the slopes."""
    slope_u = (np.roll(height, -1, axis=1) - np.roll(height, 1, axis=1)) * 0.5 * strength
    slope_v = (np.roll(height, 1, axis=0) - np.roll(height, -1, axis=0)) * 0.5 * strength
    normal = np.stack([-slope_u, -slope_v, np.ones_like(height)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return normal * 0.5 + 0.5


def picture(name, pixels, folder, color=True):
    """An 8-bit PNG of `pixels` (height x width x 1, 3 or 4 in 0..1, already encoded), loaded and packed.

    `color` chooses sRGB, else the picture is data. It goes through a PNG file so that Cycles and the exporter are given
    the very same bytes.
    """
    if pixels.ndim == 2:
        pixels = np.repeat(pixels[..., None], 3, axis=2)
    bytes_ = np.clip(np.round(pixels * 255.0), 0, 255).astype(np.uint8)
    path = os.path.join(folder, f"{name}.png")
    write_png(path, bytes_)
    image = bpy.data.images.load(path)
    image.name = name
    image.colorspace_settings.name = "sRGB" if color else "Non-Color"
    image.alpha_mode = "STRAIGHT" if bytes_.shape[2] == 4 else "NONE"
    image.pack()
    os.remove(path)
    return image


def write_png(path, bytes_):
    """Writes an 8-bit RGB or RGBA PNG."""
    height, width, channels = bytes_.shape

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    lines = np.concatenate([np.zeros((height, 1), np.uint8), bytes_.reshape(height, width * channels)], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 8, 6 if channels == 4 else 2, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header))
        file.write(chunk(b"IDAT", zlib.compress(lines.tobytes(), 6)) + chunk(b"IEND", b""))


# --- materials ---------------------------------------------------------------------------------------------------------


def principled(name, **inputs):
    """A Principled BSDF; keywords are socket names with underscores: `base_color`, `transmission_weight`, …"""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.use_backface_culling = False
    shader = material.node_tree.nodes["Principled BSDF"]
    for key, value in inputs.items():
        socket = shader.inputs[SOCKETS.get(key, key.replace("_", " ").title())]
        socket.default_value = (*value, 1.0) if isinstance(value, (tuple, list)) else value
    return material


SOCKETS = {"ior": "IOR", "specular_ior_level": "Specular IOR Level"}


def matte(name, color):
    """A purely diffuse material: no specular layer at all."""
    return principled(name, base_color=color, roughness=1.0, specular_ior_level=0.0)


def glowing(name, color, strength):
    """A black surface that emits the radiance `color` x `strength`."""
    return principled(
        name, base_color=(0.0, 0.0, 0.0), roughness=1.0, specular_ior_level=0.0, emission_color=color,
        emission_strength=strength,
    )


def shader_of(material):
    return material.node_tree.nodes["Principled BSDF"]


def texture(material, image, offset=None, scale=None, rotation=0.0, uv=None):
    """An image texture node; with offset, scale (pairs) or rotation (degrees) its coordinates go through a Mapping."""
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    node.interpolation = "Linear"
    node.extension = "REPEAT"
    if offset is not None or scale is not None or rotation or uv is not None:
        source = tree.nodes.new("ShaderNodeUVMap")
        if uv is not None:
            source.uv_map = uv
        mapping = tree.nodes.new("ShaderNodeMapping")
        mapping.vector_type = "POINT"
        mapping.inputs["Location"].default_value = (*(offset or (0.0, 0.0)), 0.0)
        mapping.inputs["Rotation"].default_value = (0.0, 0.0, math.radians(rotation))
        mapping.inputs["Scale"].default_value = (*(scale or (1.0, 1.0)), 1.0)
        tree.links.new(source.outputs["UV"], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs["Vector"], node.inputs["Vector"])
    return node


def textured_color(material, node):
    material.node_tree.links.new(node.outputs["Color"], shader_of(material).inputs["Base Color"])


def textured_metal_roughness(material, node):
    """Green drives the roughness and blue the metallic, as in glTF."""
    tree = material.node_tree
    split = tree.nodes.new("ShaderNodeSeparateColor")
    tree.links.new(node.outputs["Color"], split.inputs["Color"])
    tree.links.new(split.outputs["Green"], shader_of(material).inputs["Roughness"])
    tree.links.new(split.outputs["Blue"], shader_of(material).inputs["Metallic"])


def textured_normal(material, node, strength=1.0, uv="UVMap"):
    tree = material.node_tree
    bend = tree.nodes.new("ShaderNodeNormalMap")
    bend.inputs["Strength"].default_value = strength
    bend.uv_map = uv
    tree.links.new(node.outputs["Color"], bend.inputs["Color"])
    tree.links.new(bend.outputs["Normal"], shader_of(material).inputs["Normal"])


def textured_emission(material, node, strength):
    material.node_tree.links.new(node.outputs["Color"], shader_of(material).inputs["Emission Color"])
    shader_of(material).inputs["Emission Strength"].default_value = strength


def clipped_alpha(material, node, cutoff=0.5):
    """Alpha at or above `cutoff` is there, below it is not: 1 - (alpha < cutoff), which the exporter writes as MASK."""
    tree = material.node_tree
    less = tree.nodes.new("ShaderNodeMath")
    less.operation = "LESS_THAN"
    less.inputs[1].default_value = cutoff
    rest = tree.nodes.new("ShaderNodeMath")
    rest.operation = "SUBTRACT"
    rest.inputs[0].default_value = 1.0
    tree.links.new(node.outputs["Alpha"], less.inputs[0])
    tree.links.new(less.outputs["Value"], rest.inputs[1])
    tree.links.new(rest.outputs["Value"], shader_of(material).inputs["Alpha"])


def vertex_colored(material, attribute, node=None):
    """The colour attribute is the base colour, multiplied with the texture `node` if one is given."""
    tree = material.node_tree
    colors = tree.nodes.new("ShaderNodeVertexColor")
    colors.layer_name = attribute
    source = colors.outputs["Color"]
    if node is not None:
        product = tree.nodes.new("ShaderNodeMix")
        product.data_type = "RGBA"
        product.blend_type = "MULTIPLY"
        product.inputs["Factor"].default_value = 1.0
        # The Mix node has sockets of the same name for each data type: 6 and 7 are the colours, output 2 the result.
        tree.links.new(node.outputs["Color"], product.inputs[6])
        tree.links.new(source, product.inputs[7])
        source = product.outputs[2]
    tree.links.new(source, shader_of(material).inputs["Base Color"])


def glass(name, color=(1.0, 1.0, 1.0), roughness=0.0, ior=1.5):
    """Solid glass: Principled transmission, with the exporter's "glTF Material Output" group that makes it write a
    volume (Thickness above 0), as glTF's plain transmission means a thin pane."""
    material = principled(name, base_color=color, roughness=roughness, ior=ior, transmission_weight=1.0)
    group = bpy.data.node_groups.get("glTF Material Output")
    if group is None:
        group = bpy.data.node_groups.new("glTF Material Output", "ShaderNodeTree")
        for socket, start in (("Occlusion", 1.0), ("Thickness", 0.0)):
            group.interface.new_socket(socket, in_out="INPUT", socket_type="NodeSocketFloat").default_value = start
        group.nodes.new("NodeGroupInput")
        group.nodes.new("NodeGroupOutput")
    node = material.node_tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    node.inputs["Thickness"].default_value = 1.0
    return material


# --- meshes ------------------------------------------------------------------------------------------------------------


def mesh(name, corners, faces, material=None, uvs=None, smooth=False):
    """A mesh from vertices and polygons; `uvs` holds one pair for each corner of each polygon, in order."""
    data = bpy.data.meshes.new(name)
    data.from_pydata([tuple(map(float, corner)) for corner in corners], [], [tuple(map(int, face)) for face in faces])
    if uvs is not None:
        layer = data.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", np.asarray(uvs, np.float32).ravel())
    if material is not None:
        data.materials.append(material)
    data.polygons.foreach_set("use_smooth", [smooth] * len(data.polygons))
    data.update()
    return data


def box_mesh(name, size, material=None):
    """An axis-aligned box of `size` about the origin, each side with its own 0..1 texture square."""
    x, y, z = (half / 2.0 for half in size)
    corners = [(sx * x, sy * y, sz * z) for sx in (-1, 1) for sy in (-1, 1) for sz in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    square = {
        0: [(1, 0), (1, 1), (0, 1), (0, 0)],
        1: [(0, 0), (1, 0), (1, 1), (0, 1)],
        2: [(0, 0), (1, 0), (1, 1), (0, 1)],
        3: [(1, 0), (1, 1), (0, 1), (0, 0)],
        4: [(0, 1), (0, 0), (1, 0), (1, 1)],
        5: [(0, 0), (1, 0), (1, 1), (0, 1)],
    }
    return mesh(name, corners, faces, material, [uv for side in range(6) for uv in square[side]])


def box(name, size, position, material, turn=0.0):
    holder = link(box_mesh(name, size, material), name)
    holder.location = position
    holder.rotation_euler = (0.0, 0.0, math.radians(turn))
    return holder


def quad(name, corners, material):
    """One rectangle; its front is the side from which the corners run counter-clockwise."""
    return link(mesh(name, corners, [(0, 1, 2, 3)], material, [(0, 0), (1, 0), (1, 1), (0, 1)]), name)


def sphere_mesh(name, radius, material=None, segments=64, rings=32):
    """A sphere of longitude and latitude, smooth, with texture coordinates."""
    corners, faces, uvs = [], [], []
    for ring in range(rings + 1):
        polar = math.pi * ring / rings
        for segment in range(segments):
            azimuth = 2.0 * math.pi * segment / segments
            corners.append(
                (radius * math.sin(polar) * math.cos(azimuth), radius * math.sin(polar) * math.sin(azimuth),
                 radius * math.cos(polar))
            )
            if ring in (0, rings):
                break
    start = lambda ring: 0 if ring == 0 else 1 + (ring - 1) * segments
    for ring in range(rings):
        for segment in range(segments):
            following = (segment + 1) % segments
            u0, u1 = segment / segments, (segment + 1) / segments
            v0, v1 = 1.0 - ring / rings, 1.0 - (ring + 1) / rings
            if ring == 0:
                faces.append((0, start(1) + segment, start(1) + following))
                uvs += [((u0 + u1) / 2, v0), (u0, v1), (u1, v1)]
            elif ring == rings - 1:
                faces.append((start(ring) + segment, start(rings), start(ring) + following))
                uvs += [(u0, v0), ((u0 + u1) / 2, v1), (u1, v0)]
            else:
                faces.append((start(ring) + segment, start(ring + 1) + segment, start(ring + 1) + following,
                              start(ring) + following))
                uvs += [(u0, v0), (u0, v1), (u1, v1), (u1, v0)]
    return mesh(name, corners, faces, material, uvs, smooth=True)


def sphere(name, radius, position, material, segments=64, rings=32):
    holder = link(sphere_mesh(name, radius, material, segments, rings), name)
    holder.location = position
    return holder


def torus_mesh(name, radius, thickness, material=None, segments=96, sides=32):
    corners, faces, uvs = [], [], []
    for segment in range(segments):
        along = 2.0 * math.pi * segment / segments
        for side in range(sides):
            around = 2.0 * math.pi * side / sides
            out = radius + thickness * math.cos(around)
            corners.append((out * math.cos(along), out * math.sin(along), thickness * math.sin(around)))
            after, beside = (segment + 1) % segments, (side + 1) % sides
            faces.append((segment * sides + side, after * sides + side, after * sides + beside, segment * sides + beside))
            u0, u1, v0, v1 = segment / segments, (segment + 1) / segments, side / sides, (side + 1) / sides
            uvs += [(u0, v0), (u1, v0), (u1, v1), (u0, v1)]
    return mesh(name, corners, faces, material, uvs, smooth=True)


def monkey(name, position, material, size=1.0, turn=0.0, subdivisions=2):
    """Blender's Suzanne, subdivided and smooth."""
    bpy.ops.mesh.primitive_monkey_add(size=2.0 * size)
    holder = bpy.context.object
    holder.name = name
    modifier = holder.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = subdivisions
    bpy.ops.object.modifier_apply(modifier=modifier.name)
    bpy.ops.object.shade_smooth()
    holder.data.materials.append(material)
    holder.location = position
    holder.rotation_euler = (0.0, 0.0, math.radians(turn))
    return holder


def write_constant_hdr(path, color):
    """A small .hdr of one colour."""
    write_hdr(path, np.broadcast_to(np.asarray(color, np.float64), (8, 16, 3)))
