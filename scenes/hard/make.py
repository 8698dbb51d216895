# SPDX-License-Identifier: MIT OR Apache-2.0
"""Makes hard scenes for both renderers: the Cornell box and three objects where floating point is thin.

    PYTHON_WITH_BPY scenes/hard/make.py OUTDIR

Each variant of a gallery scene is NAME.glb, NAME.blend and NAME.json, as build.py writes them: the .glb has one more node
about the scene, whose numbers JSON keeps in double precision; in the .blend all objects hang on an empty, as a user of
Blender would move or scale a scene. The picture of every variant is that of the scene as it was.
"""

import argparse
import json
import os
import sys

import bpy

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

import build  # noqa: E402

# Name -> (metres along each axis, factor). Emission and environments know no scale, so that no light has to change.
VARIANTS = {
    "moved-1e3": (1e3, 1.0),
    "moved-1e5": (1e5, 1.0),
    "moved-1e7": (1e7, 1.0),
    "scaled-1e-6": (0.0, 1e-6),
    "scaled-1e-3": (0.0, 1e-3),
    "scaled-1e3": (0.0, 1e3),
    "scaled-1e6": (0.0, 1e6),
}
SCENES = ("cornell", "three-objects")


def move_glb(source, target, metres, factor):
    document, rest = build.read_glb(source)
    scene = document["scenes"][document.get("scene", 0)]
    document["nodes"].append({"name": "About all", "children": scene["nodes"], "translation": [metres] * 3, "scale": [factor] * 3})
    scene["nodes"] = [len(document["nodes"]) - 1]
    for camera in document["cameras"]:
        # In metres of the world, whatever the nodes above scale.
        lens = camera[camera["type"]]
        lens.update({clip: lens[clip] * factor for clip in ("znear", "zfar") if clip in lens})
    build.write_glb(target, document, rest)


def move_blend(source, target, metres, factor):
    with build.quiet():
        bpy.ops.wm.open_mainfile(filepath=source)
    holder = bpy.data.objects.new("About all", None)
    bpy.context.scene.collection.objects.link(holder)
    for thing in bpy.context.scene.objects:
        if thing is not holder and thing.parent is None:
            thing.parent = holder
    holder.location, holder.scale = [metres] * 3, [factor] * 3
    lens = bpy.context.scene.camera.data
    lens.clip_start, lens.clip_end = lens.clip_start * factor, lens.clip_end * factor
    bpy.context.view_layer.update()
    with build.quiet():
        bpy.ops.wm.save_as_mainfile(filepath=target, compress=True)


def make(name, folder):
    """Builds a scene of the gallery and all its variants; gives their names."""
    build.build(name, folder, False)
    path = lambda name, kind: os.path.join(folder, f"{name}.{kind}")
    with open(path(name, "json")) as file:
        settings = json.load(file)
    for variant, (metres, factor) in VARIANTS.items():
        hard = f"{name}-{variant}"
        move_glb(path(name, "glb"), path(hard, "glb"), metres, factor)
        move_blend(os.path.abspath(path(name, "blend")), os.path.abspath(path(hard, "blend")), metres, factor)
        with open(path(hard, "json"), "w") as file:
            json.dump({**settings, "scene": f"{hard}.glb", "blend": f"{hard}.blend"}, file, indent=2)
            file.write("\n")
    return [f"{name}-{variant}" for variant in VARIANTS]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="OUTDIR")
    given = parser.parse_args()
    os.makedirs(given.folder, exist_ok=True)
    for name in SCENES:
        for hard in make(name, given.folder):
            print(hard)


if __name__ == "__main__":
    main()
