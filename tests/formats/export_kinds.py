"""Exports lamps, a camera and a mesh without a material with Blender's own exporter, once for each lighting mode.

    PYTHON export_kinds.py FOLDER
"""

import sys

import bpy

folder = sys.argv[1]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene


def add(data, location=(0, 0, 0)):
    thing = bpy.data.objects.new(data.name, data)
    scene.collection.objects.link(thing)
    thing.location = location
    return thing


point = bpy.data.lights.new("point", "POINT")
point.energy, point.color = 100, (1, 0.5, 0.25)
spot = bpy.data.lights.new("spot", "SPOT")
spot.energy, spot.spot_size, spot.spot_blend, spot.exposure = 50, 1.2, 0.15, 1
sun = bpy.data.lights.new("sun", "SUN")
sun.energy = 3
mesh = bpy.data.meshes.new("bare")
mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
camera = bpy.data.cameras.new("camera")
camera.lens, camera.sensor_width, camera.clip_start, camera.clip_end = 35, 36, 0.25, 75
scene.render.resolution_x, scene.render.resolution_y = 320, 200
for thing in (point, spot, sun, mesh):
    add(thing)
# Blender's (x, y, z), Z up, is glTF's (x, z, -y).
add(camera, (1, 2, 3))

for mode in ("SPEC", "COMPAT", "RAW"):
    bpy.ops.export_scene.gltf(
        filepath=f"{folder}/{mode}.glb",
        export_cameras=True,
        export_lights=True,
        export_import_convert_lighting_mode=mode,
    )
