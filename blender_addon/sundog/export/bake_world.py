# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by a Blender of its own: renders a world as an equirectangular picture.

    blender --background --factory-startup --python bake_world.py -- WORLD.blend NAME OUT.exr WIDTH SAMPLES
"""

import math
import os
import sys

import bpy


def main(blend, name, out, width, samples):
    """Renders; the arguments as on the command line."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(blend) as (source, target):
        target.worlds = [name]
    scene = bpy.context.scene
    scene.world = bpy.data.worlds[name]
    for tree in [scene.world.node_tree, *bpy.data.node_groups]:
        for node in tree.nodes:
            if node.type == "LIGHT_PATH":
                blind(tree, node)
    scene.render.engine = "CYCLES"
    camera = bpy.data.cameras.new("panorama")
    camera.type = "PANO"
    settings = camera if hasattr(camera, "panorama_type") else camera.cycles
    settings.panorama_type = "EQUIRECTANGULAR"
    camera.clip_start = 1e-4
    eye = bpy.data.objects.new("panorama", camera)
    # The middle of an environment image lies in direction +X.
    eye.rotation_euler = (math.pi / 2, 0.0, -math.pi / 2)
    scene.collection.objects.link(eye)
    scene.camera = eye
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = int(width), int(width) // 2, 100
    render.pixel_aspect_x = render.pixel_aspect_y = 1.0
    render.film_transparent = False
    render.use_compositing = render.use_sequencer = False
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = int(samples)
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    # Each texel is the mean over itself.
    cycles.pixel_filter_type = "BOX"
    for visible in ("camera", "diffuse", "glossy", "transmission", "scatter"):
        setattr(scene.world.cycles_visibility, visible, True)
    image = render.image_settings
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"
    image.exr_codec = "ZIP"
    render.filepath = out
    render.use_file_extension = False
    bpy.ops.render.render(write_still=True)
    if not os.path.isfile(out):
        raise SystemExit("Cycles wrote no picture")


def blind(tree, node):
    """Takes a Light Path node for what falls on things: no ray of it is the camera's."""
    for output in node.outputs:
        for link in list(output.links):
            target = link.to_socket
            tree.links.remove(link)
            if hasattr(target, "default_value") and isinstance(target.default_value, float):
                target.default_value = 0.0


if __name__ == "__main__":
    main(*sys.argv[sys.argv.index("--") + 1 :])
