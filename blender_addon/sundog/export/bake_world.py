# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by a Blender of its own: renders worlds as equirectangular pictures, tells what sky textures give for directions, and
reads files of images as Cycles does, one of it for each line that it is told.

    blender --background --factory-startup --python bake_world.py -- IDLE_SECONDS

A line is a JSON object (see `bake`, `read`, and with "sky" in it `evaluate_sky`); the answer is a line that begins with ANSWER. It ends with its input, or when it has been
told nothing for so long.
"""

import json
import math
import os
import signal
import sys
import traceback

import bpy
import numpy

ANSWER = "SUNDOG-BAKED "

# Pixels along a side of the picture of the sun, and how much wider it is than the disc.
SUN_PIXELS, SUN_MARGIN, SUN_SAMPLES = 32, 1.25, 4


def serve(idle):
    """Answers until there is nothing more to answer."""
    while True:
        # Whoever started it may have died in a way that keeps the input open.
        signal.alarm(idle)
        line = sys.stdin.readline()
        signal.alarm(0)
        if not line:
            return
        try:
            request = json.loads(line)
            if "sky" in request:
                answer = evaluate_sky(**request["sky"])
            else:
                answer = read(**request) if "picture" in request else bake(**request)
        except BaseException as error:
            traceback.print_exc()
            answer = {"error": f"{type(error).__name__}: {error}"}
        print(f"\n{ANSWER}{json.dumps(answer)}", flush=True)


def bake(blend, name, out, width, samples, space, values, sun):
    """Renders the world of that name in a .blend to `out`.

    `values`: by tree ("" is the world's own, the others are groups) and node: properties and values of sockets as they are now.
    `sun`: direction and angular diameter of a disc that is left out of the picture and told apart, or None.
    """
    scene = prepare(blend, name, space, values)
    skies = [node for tree in trees(scene.world) for node in tree.nodes if node.type == "TEX_SKY" and getattr(node, "sun_disc", False)]
    answer = {}
    if sun is not None:
        strength = disc(scene, skies, out, **sun)
        if strength is not None:
            answer["sun"] = {**sun, "strength": strength}
            for node in skies:
                node.sun_disc = False
    camera = scene.camera
    camera.data.type = "PANO"
    settings = camera.data if hasattr(camera.data, "panorama_type") else camera.data.cycles
    settings.panorama_type = "EQUIRECTANGULAR"
    # The middle of an environment image lies in direction +X.
    camera.rotation_euler = (math.pi / 2, 0.0, -math.pi / 2)
    render(scene, out, width, width // 2, samples)
    return answer


def read(picture, frame, out):
    """Writes the numbers of an image file, or of a movie's frame (from 1 on), as height × width × 4 floats, the bottom row first:
    as they are coded, from 0 to 1."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    image = bpy.data.images.load(picture)
    image.colorspace_settings.name, image.alpha_mode = "Non-Color", "CHANNEL_PACKED"
    width, height = image.size
    if not width or not height:
        raise ValueError("Blender cannot read it")
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.frame_current = frame
    scene.world = None
    plain_settings(scene)
    # Of each pixel its middle alone: the texel's.
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", 0.01
    scene.cycles.samples = 1
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale, camera.sensor_fit = "ORTHO", 1.0, "HORIZONTAL"
    eye = bpy.data.objects.new("camera", camera)
    eye.location = (0.5, 0.5 * height / width, 1.0)
    scene.collection.objects.link(eye)
    scene.camera = eye
    mesh = bpy.data.meshes.new("picture")
    top = height / width
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, top, 0), (0, top, 0)], [], [(0, 1, 2, 3)])
    for corner, place in zip(mesh.uv_layers.new().data, [(0, 0), (1, 0), (1, 1), (0, 1)]):
        corner.uv = place
    material = bpy.data.materials.new("picture")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node, emission, end = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexImage", "Emission", "OutputMaterial"))
    node.image, node.interpolation, node.extension = image, "Closest", "EXTEND"
    node.image_user.frame_start, node.image_user.frame_duration = 1, max(frame, 1)
    tree.links.new(emission.outputs[0], end.inputs["Surface"])
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("picture", mesh))
    numbers = []
    for output in ("Color", "Alpha"):
        tree.links.new(node.outputs[output], emission.inputs["Color"])
        path = f"{out}.exr"
        render(scene, path, width, height, 1)
        numbers.append(pixels_of(path).astype(numpy.float32))
        os.remove(path)
    numpy.save(out, numpy.concatenate([numbers[0], numbers[1][..., :1]], axis=2))
    return {}


def prepare(blend, name, space, values):
    """A scene with the world and a camera alone."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    set_working_space(space)
    with bpy.data.libraries.load(blend) as (source, target):
        target.worlds = [name]
    scene = bpy.context.scene
    scene.world = bpy.data.worlds[name]
    for tree in trees(scene.world):
        # Animation and drivers would have other values here.
        tree.animation_data_clear()
        for node in tree.nodes:
            set_values(node, values.get("" if tree == scene.world.node_tree else tree.name, {}).get(node.name, {}))
            if node.type == "LIGHT_PATH":
                blind(tree, node)
    look_through(scene)
    return scene


def set_working_space(space):
    """The space that colours are numbers of."""
    # Names of operators are there whether there are such operators or not.
    if hasattr(bpy.data, "colorspace") and bpy.data.colorspace.working_space != space:
        bpy.ops.wm.set_working_color_space(working_space=space, convert_colors=False)


def look_through(scene):
    """A camera, and settings by which pixels are what the world gives."""
    scene.render.engine = "CYCLES"
    camera = bpy.data.cameras.new("camera")
    camera.clip_start = 1e-4
    eye = bpy.data.objects.new("camera", camera)
    scene.collection.objects.link(eye)
    scene.camera = eye
    plain_settings(scene)
    # Each texel is the mean over itself.
    scene.cycles.pixel_filter_type = "BOX"
    # No light falls on anything here: what makes ready for it can be left out.
    scene.world.cycles.sampling_method = "NONE"
    for visible in ("camera", "diffuse", "glossy", "transmission", "scatter"):
        setattr(scene.world.cycles_visibility, visible, True)
    return scene


def plain_settings(scene):
    """Settings of a render that shows nothing but what is in the scene, in an OpenEXR file."""
    settings = scene.render
    settings.resolution_percentage = 100
    settings.pixel_aspect_x = settings.pixel_aspect_y = 1.0
    settings.film_transparent = False
    settings.use_compositing = settings.use_sequencer = False
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    image = settings.image_settings
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"
    image.exr_codec = "NONE"
    settings.use_file_extension = False


def evaluate_sky(answered, values, space, asked=None, view=None):
    """What a Sky Texture with those properties gives, into a file of numpy.

    `asked`: for the directions in such a file. `view`: up through the middle of what a narrow camera sees, as a sky with a
    disc of the sun takes no directions; `elevation` and `azimuth` of its middle, half of its `angle`, and `count` of pixels.
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    set_working_space(space)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    tree.nodes.clear()
    sky, background, output = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexSky", "Background", "OutputWorld"))
    set_values(sky, {"properties": values})
    # What this Blender does not know would be another sky.
    if sky.sky_type != values["sky_type"]:
        raise RuntimeError(f"this Blender has no sky {values['sky_type']}")
    tree.links.new(sky.outputs["Color"], background.inputs["Color"])
    tree.links.new(background.outputs["Background"], output.inputs["Surface"])
    look_through(scene)
    # Pixels are what is seen in their middles.
    scene.cycles.filter_width = 0.01
    if asked is None:
        # The middle one of some columns: Blender makes no picture of one.
        count, (width, height) = view["count"], (5, view["count"])
        camera = scene.camera
        camera.data.sensor_fit = "VERTICAL"
        camera.data.angle = 2 * view["angle"]
        camera.rotation_euler = (math.pi / 2 + view["elevation"], 0.0, view["azimuth"] - math.pi / 2)
    else:
        directions = numpy.load(asked)
        count = len(directions)
        width = min(count, 1024)
        height = -(-count // width)
        show_directions(tree, sky, directions, width, height)
    path = f"{answered}.exr"
    render(scene, path, width, height, 1)
    colors = pixels_of(path)
    colors = colors[:, width // 2] if asked is None else colors.reshape(-1, 3)[:count]
    os.remove(path)
    numpy.save(answered, colors.astype(numpy.float32))
    return {}


def show_directions(tree, sky, directions, width, height):
    """Each pixel of the picture shows what a sky gives for one of the directions."""
    texels = numpy.zeros((width * height, 4), numpy.float32)
    texels[:, 3] = 1.0
    texels[: len(directions), :3] = directions
    image = bpy.data.images.new("directions", width, height, float_buffer=True, is_data=True)
    image.use_half_precision = False
    image.pixels.foreach_set(texels.ravel())
    window, look = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeTexImage")
    look.image, look.interpolation, look.extension = image, "Closest", "EXTEND"
    tree.links.new(window.outputs["Window"], look.inputs["Vector"])
    tree.links.new(look.outputs["Color"], sky.inputs["Vector"])


def render(scene, out, width, height, samples):
    """The camera's picture in a file."""
    settings = scene.render
    settings.resolution_x, settings.resolution_y = width, height
    settings.filepath = out
    scene.cycles.samples = samples
    bpy.ops.render.render(write_still=True)
    if not os.path.isfile(out):
        raise RuntimeError("Cycles wrote no picture")


def pixels_of(path):
    """Height × width × 3 linear floats, the bottom row first."""
    image = bpy.data.images.load(path)
    try:
        image.colorspace_settings.name = "Non-Color"
        values = numpy.empty(image.size[0] * image.size[1] * image.channels, numpy.float32)
        image.pixels.foreach_get(values)
        return values.reshape(image.size[1], image.size[0], -1)[..., :3].astype(float)
    finally:
        bpy.data.images.remove(image)


def disc(scene, skies, out, direction, angle):
    """Irradiance of the sun's disc on a surface that faces it: what is more than the sky beside it; None if it isn't there."""
    import mathutils

    camera = scene.camera
    camera.data.type = "PERSP"
    camera.data.sensor_fit = "AUTO"
    half = 0.5 * angle * SUN_MARGIN
    camera.data.angle = 2 * half
    camera.rotation_euler = mathutils.Vector(direction).to_track_quat("-Z", "Y").to_euler()
    path = f"{out}.sun.exr"
    render(scene, path, SUN_PIXELS, SUN_PIXELS, SUN_SAMPLES)
    light = pixels_of(path)
    os.remove(path)
    # The solid angle of a pixel at tangents (x, y) is dx dy / (1 + x² + y²)^(3/2), and the cosine to the middle once more the root.
    width = math.tan(half)
    at = ((numpy.arange(SUN_PIXELS) + 0.5) / SUN_PIXELS * 2 - 1) * width
    # Beside the disc there is the sky alone. (A second picture without the disc would cost the sky's table once more.)
    light -= light[at[:, None] ** 2 + at**2 > (math.tan(half) * 1.1 / SUN_MARGIN) ** 2].mean(axis=0)
    weight = (2 * width / SUN_PIXELS) ** 2 / (1 + at[:, None] ** 2 + at**2) ** 2
    strength = (light * weight[..., None]).sum(axis=(0, 1))
    # It is the disc if it stands in the middle half and not at the edges.
    middle = slice(SUN_PIXELS // 4, -SUN_PIXELS // 4)
    if not strength.max() > 0 or light[middle, middle].sum() < 0.2 * light.sum() or strength.min() < 0:
        return None
    return [float(v) for v in strength]


def trees(world):
    """The world's node tree and the groups in it, each once."""
    found, open_trees = [], [world.node_tree]
    while open_trees:
        tree = open_trees.pop()
        if tree is None or tree in found:
            continue
        found.append(tree)
        open_trees += [node.node_tree for node in tree.nodes if node.type == "GROUP"]
    return found


def set_values(node, values):
    """Sets what the node's properties and sockets are now."""
    for identifier, value in values.get("properties", {}).items():
        try:
            setattr(node, identifier, value)
        except (AttributeError, TypeError, ValueError):
            # What the kind of the node does not use cannot always be set.
            continue
    for stop, (position, color) in zip(node.color_ramp.elements if values.get("stops") else (), values.get("stops", ())):
        stop.position, stop.color = position, color
    by_identifier = {socket.identifier: socket for socket in (*node.inputs, *node.outputs)}
    for identifier, value in values.get("sockets", {}).items():
        by_identifier[identifier].default_value = value


def blind(tree, node):
    """Takes a Light Path node for what falls on things: no ray of it is the camera's."""
    for output in node.outputs:
        for link in list(output.links):
            target = link.to_socket
            tree.links.remove(link)
            if hasattr(target, "default_value") and isinstance(target.default_value, float):
                target.default_value = 0.0


if __name__ == "__main__":
    serve(int(sys.argv[sys.argv.index("--") + 1]))
