"""Writes EXR files with Blender: every compression, depth and kind of channels that it offers.

    PYTHON write_exr.py FOLDER

Beside each NAME.exr lies NAME.f32: what Blender (OpenEXR's own library) reads back from it, little-endian
float32 RGB from the top row down. `combined.exr` is a multilayer render.
"""

import os
import sys

import bpy
import numpy as np

folder = sys.argv[1]
width, height = 70, 45
y, x = np.mgrid[0:height, 0:width].astype(np.float32)
checks = np.where((x // 8 + y // 8) % 2 == 0, 30.0, 0.02)
rgba = np.stack([x / width * 4, y / height * 0.5 + 0.01, checks, 0.25 + 0.5 * x / width], -1).astype(np.float32)

image = bpy.data.images.new("test", width, height, alpha=True, float_buffer=True)
image.colorspace_settings.name = "Non-Color"
image.alpha_mode = "CHANNEL_PACKED"
image.pixels.foreach_set(rgba.ravel())
image.update()
scene = bpy.context.scene
scene.view_settings.view_transform = "Raw"
settings = scene.render.image_settings


def read_back(path):
    back = bpy.data.images.load(path)
    back.colorspace_settings.name = "Non-Color"
    back.alpha_mode = "CHANNEL_PACKED"
    pixels = np.empty(width * height * 4, np.float32)
    back.pixels.foreach_get(pixels)
    bpy.data.images.remove(back)
    return pixels.reshape(height, width, 4)[::-1]


for codec in ("NONE", "RLE", "ZIPS", "ZIP", "PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB"):
    for depth in ("16", "32"):
        for mode in ("BW", "RGB", "RGBA"):
            settings.file_format = "OPEN_EXR"
            settings.color_depth = depth
            settings.color_mode = mode
            try:
                settings.exr_codec = codec
            except TypeError:
                continue  # B44 is for half floats only
            path = os.path.join(folder, f"{codec}-{depth}-{mode}.exr")
            image.save_render(path, scene=scene)
            read_back(path).astype("<f4").tofile(path[:-4] + ".f32")

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.cycles.samples = 1
scene.cycles.use_denoising = False
scene.render.resolution_x, scene.render.resolution_y = 16, 8
scene.world = bpy.data.worlds.new("world")
scene.world.use_nodes = True
scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.25, 0.5, 2.0, 1.0)
camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.collection.objects.link(camera)
scene.camera = camera
scene.view_layers[0].use_pass_z = True
scene.view_layers[0].use_pass_normal = True
scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
scene.render.image_settings.exr_codec = "DWAA"
scene.render.filepath = os.path.join(folder, "combined.exr")
bpy.ops.render.render(write_still=True)
