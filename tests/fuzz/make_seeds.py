# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes those seeds of the fuzzer that other programs write: what the add-on exports and keeps, and pictures in ETC1S.

    ~/.cache/sundog/bpy-5.2.3/bin/python tests/fuzz/make_seeds.py addon
    python tests/fuzz/make_seeds.py ktx2        # with alktx2 of PyPI
"""

import os
import shutil
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
SEEDS = os.path.join(HERE, "seeds")
VDB = os.path.join(HERE, "../unit/import/vdb/files/zip.vdb")


def ktx2():
    """Small pictures, with levels and alpha."""
    import alktx2

    def pixels(width, height, alpha):
        return bytes(value for y in range(height) for x in range(width) for value in (9 * x, 12 * y, 90, 255 - alpha * 10 * x))

    for name, alpha, options in (("etc1s", False, {"codec": "etc1s", "mipmaps": True}), ("etc1s-alpha", True, {"codec": "etc1s"})):
        data = alktx2.encode_raw_rgba_to_ktx2(pixels(24, 18, alpha), 24, 18, alpha, **options)
        with open(os.path.join(SEEDS, f"{name}.ktx2"), "wb") as file:
            file.write(data)


def addon():
    """A scene of which each part of what the add-on writes has one: meshes, a volume, images, node trees, a world."""
    sys.path[:0] = [os.path.join(HERE, "../addon")]
    import bpy
    import export_kit as kit
    from sundog import export

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    folder = tempfile.mkdtemp()
    shutil.copy(VDB, os.path.join(folder, "smoke.vdb"))
    kit.sun_and_grey_world(scene)
    world = scene.world.node_tree
    sky = world.nodes.new("ShaderNodeTexEnvironment")
    sky.image = bpy.data.images.new("sky", 8, 4, float_buffer=True)
    sky.image.pack()
    world.links.new(sky.outputs[0], world.nodes["Background"].inputs[0])

    painted = kit.material("painted", Roughness=0.4, Coat_Weight=0.5)
    tree = painted.node_tree
    texture, noise, mix = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexImage", "TexNoise", "MixRGB"))
    texture.image = bpy.data.images.new("paint", 6, 5)
    texture.image.pixels = [0.5, 0.25, 0.75, 1.0] * 30
    texture.image.pack()
    tree.links.new(texture.outputs[0], mix.inputs[1])
    tree.links.new(noise.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
    plane = kit.plane()
    plane.materials.append(painted)
    plane.attributes.new("color", "FLOAT_COLOR", "POINT")
    kit_link(scene, bpy.data.objects.new("plane", plane))
    cube = bpy.data.objects.new("cube", kit.cube())
    kit_link(scene, cube)
    kit.stretches(cube, 1.5, ((1, 0.0), (3, 1.0)))
    scene.render.use_motion_blur = True

    smoke = bpy.data.volumes.new("smoke")
    smoke.filepath = os.path.join(folder, "smoke.vdb")
    fog = bpy.data.materials.new("fog")
    fog.use_nodes = True
    fog.node_tree.nodes.clear()
    out, volume = (fog.node_tree.nodes.new(f"ShaderNode{kind}") for kind in ("OutputMaterial", "VolumePrincipled"))
    fog.node_tree.links.new(volume.outputs[0], out.inputs["Volume"])
    smoke.materials.append(fog)
    kit_link(scene, bpy.data.objects.new("smoke", smoke))

    lamp = bpy.data.lights.new("lamp", "POINT")
    lamp.use_nodes = True
    profile = lamp.node_tree.nodes.new("ShaderNodeTexIES")
    profile.mode, profile.filepath = "EXTERNAL", os.path.join(SEEDS, "type-c.ies")
    emission = next(node for node in lamp.node_tree.nodes if node.type == "EMISSION")
    lamp.node_tree.links.new(profile.outputs[0], emission.inputs["Strength"])
    kit_link(scene, bpy.data.objects.new("lamp", lamp))

    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = (0, 0, 10)
    kit_link(scene, camera)
    scene.camera = camera
    place = os.path.join(SEEDS, "addon")
    shutil.rmtree(place, ignore_errors=True)

    def task(depsgraph):
        return export.write_scene(depsgraph, depsgraph.scene, place, place, move=kit.Engine.current.frame_set)

    path = kit.in_render(task).path
    # The file itself, of which tests/unit has the one copy, is put beside it by whoever opens the seed.
    with open(path, encoding="utf-8") as file:
        text = file.read()
    relative = os.path.relpath(os.path.join(folder, "smoke.vdb"), os.path.realpath(place))
    assert relative in text, "the scene names its volume in another way"
    with open(path, "w", encoding="utf-8") as file:
        file.write(text.replace(relative, "smoke.vdb"))


def kit_link(scene, made):
    """Puts an object into the scene."""
    scene.collection.objects.link(made)


if __name__ == "__main__":
    {"ktx2": ktx2, "addon": addon}[sys.argv[1]]()
