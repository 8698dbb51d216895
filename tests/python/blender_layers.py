"""Reads an EXR file with layers as Blender's compositor does, for tests/blender_layers.rs. Runs in a Python that has `bpy`.

    python blender_layers.py FILE FOLDER

Sends every pass that the compositor's image node offers through a render into FOLDER, and prints one line of JSON:
the kind of image and, for each pass, its pixels as RGBA, the top row first.
"""

import json
import os
import sys

import bpy


def main(path, folder):
    scene = bpy.context.scene
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    # Blender renders nothing without a camera, not even what the compositor makes alone.
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    image = bpy.data.images.load(path)
    if bpy.app.version >= (5, 0, 0):
        tree = bpy.data.node_groups.new("compositing", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        scene.compositing_node_group = tree
        result = tree.nodes.new("NodeGroupOutput")
    else:
        scene.use_nodes = True
        tree = scene.node_tree
        tree.nodes.clear()
        result = tree.nodes.new("CompositorNodeComposite")
        scene.render.compositor_device = "CPU"
    node = tree.nodes.new("CompositorNodeImage")
    node.image = image
    passes = {}
    for index, socket in enumerate(node.outputs):
        if not socket.enabled:
            continue
        for link in list(tree.links):
            tree.links.remove(link)
        tree.links.new(socket, result.inputs[0])
        scene.render.resolution_x, scene.render.resolution_y = image.size if image.size[0] else SIZE
        scene.render.resolution_percentage = 100
        scene.render.filepath = os.path.join(folder, f"pass-{index}.exr")
        bpy.ops.render.render(write_still=True)
        shown = bpy.data.images.load(scene.render.filepath)
        width, height = shown.size
        values = shown.pixels[:]
        rows = [values[4 * width * y:4 * width * (y + 1)] for y in reversed(range(height))]
        passes[socket.name] = [value for row in rows for value in row]
    print("RESULT " + json.dumps({"type": image.type, "width": width, "height": height, "passes": passes}))


# Blender tells no size of an image with layers; the test's pictures have this one.
SIZE = (8, 6)

if __name__ == "__main__":
    main(*sys.argv[1:])
