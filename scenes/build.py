# SPDX-License-Identifier: MIT OR Apache-2.0
"""Makes Sundog's own scenes in Blender and exports them with the stock glTF exporter.

    PYTHON_WITH_BPY scenes/build.py NAME... OUTDIR [--quick]

NAME is one of the scenes (`--list` names them), `all` (the gallery), `probes`, or `everything`. Each scene writes
NAME.glb, NAME.blend (for Cycles) and NAME.json, which says how the picture is meant to be rendered.
"""

import argparse
import contextlib
import json
import os
import struct
import sys

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import gallery  # noqa: E402
import kit  # noqa: E402
import probes  # noqa: E402

SCENES = {**gallery.SCENES, **probes.SCENES}

# What NAME.json says unless the scene says otherwise.
DEFAULTS = {
    "environment": None,
    "environment_strength": 1.0,
    "environment_rotation": 0.0,
    "bounces": 8,
    "filter": "blackman-harris",
    "view": "AgX",
    "exposure": 0.0,
}


def build(name, folder, quick):
    """Makes one scene and writes its files into `folder`."""
    make = SCENES[name]
    width, height = make.size
    if quick:
        width, height = width // 4, height // 4
    scene = kit.start_empty(width, height)
    said = make(folder) or {}
    plain_shading(scene)
    constant = said.pop("constant", None)
    scene.view_settings.view_transform = said.get("view", DEFAULTS["view"])
    scene.view_settings.exposure = said.get("exposure", DEFAULTS["exposure"])
    if constant is not None:
        # Sundog takes its environment as a picture: a constant one is a picture of one colour.
        said["environment"] = f"{name}-environment.hdr"
        kit.write_constant_hdr(os.path.join(folder, said["environment"]), constant)
    if said.get("environment"):
        kit.environment(
            os.path.join(folder, said["environment"]), said.get("environment_strength", 1.0),
            said.get("environment_rotation", 0.0),
        )
    bpy.context.view_layer.update()
    with quiet():
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, f"{name}.blend"), compress=True)
        export(os.path.join(folder, f"{name}.glb"))
    settings = {"scene": f"{name}.glb", "blend": f"{name}.blend", "width": width, "height": height, **DEFAULTS, **said}
    with open(os.path.join(folder, f"{name}.json"), "w") as file:
        json.dump(settings, file, indent=2)
        file.write("\n")


def plain_shading(scene):
    """Takes off what Cycles adds to hide artefacts and glTF has no word for.

    The shadow terminator's geometry offset (0.1 by default) moves the origins of shadow rays on smooth meshes.
    """
    for holder in scene.objects:
        if holder.type == "MESH":
            holder.cycles.shadow_terminator_offset = 0.0
            holder.cycles.shadow_terminator_geometry_offset = 0.0


def export(path):
    """The stock exporter, then the radius and angle of the lights and the aperture of the camera, which it loses."""
    bpy.ops.export_scene.gltf(
        filepath=path,
        export_format="GLB",
        export_cameras=True,
        export_lights=True,
        export_import_convert_lighting_mode="SPEC",
        export_yup=True,
        export_apply=False,
        export_animations=False,
        export_image_format="AUTO",
        export_tangents=False,
        export_vertex_color="MATERIAL",
        export_gpu_instances=False,
    )
    write_light_sizes(path)
    write_aperture(path)


def write_aperture(path):
    """Adds `SUNDOG_camera` to the camera of a .glb if it has a lens.

    Cycles' aperture has the diameter focal length / f-stop; Blender's focal length is in millimetres.
    """
    lens = bpy.context.scene.camera.data.dof
    if not lens.use_dof:
        return
    document, rest = read_glb(path)
    aperture = {
        "radius": 0.5e-3 * bpy.context.scene.camera.data.lens / lens.aperture_fstop,
        "blades": lens.aperture_blades,
        "rotation": lens.aperture_rotation,
        "ratio": lens.aperture_ratio,
        "focus_distance": lens.focus_distance,
    }
    document["cameras"][0].setdefault("extensions", {})["SUNDOG_camera"] = {"aperture": aperture}
    document.setdefault("extensionsUsed", []).append("SUNDOG_camera")
    write_glb(path, document, rest)


def write_light_sizes(path):
    """Adds `SUNDOG_light` to each light of a .glb: {"radius": metres} or {"angle": radians, the full diameter}.

    As with new lights of Blender the camera does not see them.
    """
    document, rest = read_glb(path)
    lights = document.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    sizes = {}
    for data in bpy.data.lights:
        if data.type == "SUN":
            sizes[data.name] = {"angle": data.angle, "visibility": {"camera": False}}
            if bpy.app.version >= (5, 2, 0):
                # New lamps of 5.2 have nodes, and of a sun with nodes the exporter writes their strength, 1, without its own.
                sizes[data.name]["strength"] = [data.energy * channel for channel in data.color]
        elif data.type in ("POINT", "SPOT"):
            sizes[data.name] = {"radius": data.shadow_soft_size, "visibility": {"camera": False}}
    for light in lights:
        light.setdefault("extensions", {})["SUNDOG_light"] = sizes[light["name"]]
    if lights:
        used = document.setdefault("extensionsUsed", [])
        if "SUNDOG_light" not in used:
            used.append("SUNDOG_light")
    write_glb(path, document, rest)


def read_glb(path):
    """The JSON of a .glb and the bytes of the chunks after it."""
    with open(path, "rb") as file:
        whole = file.read()
    magic, version, _ = struct.unpack_from("<4sII", whole, 0)
    length, kind = struct.unpack_from("<I4s", whole, 12)
    if (magic, version, kind) != (b"glTF", 2, b"JSON"):
        raise ValueError(f"{path}: not a glTF 2 binary file")
    return json.loads(whole[20 : 20 + length]), whole[20 + length :]


def write_glb(path, document, rest):
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + len(rest)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + rest)


@contextlib.contextmanager
def quiet():
    """Sends Blender's chatter on standard output (from Python and from C) to nowhere."""
    sys.stdout.flush()
    keep, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(keep, 1)
        os.close(keep)
        os.close(nowhere)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="scenes, or all, probes, everything")
    parser.add_argument("folder", nargs="?", metavar="OUTDIR", help="where the files go")
    parser.add_argument("--quick", action="store_true", help="a quarter of the width and height")
    parser.add_argument("--list", action="store_true", help="name the scenes and stop")
    given = parser.parse_args()
    if given.list:
        print("\n".join(SCENES))
        return
    # argparse cannot split "NAME... OUTDIR" by itself when both are optional.
    words = given.names + ([given.folder] if given.folder else [])
    if len(words) < 2:
        parser.error("give one or more scenes and a folder")
    *names, folder = words
    families = {"all": list(gallery.SCENES), "probes": list(probes.SCENES), "everything": list(SCENES)}
    wanted = [scene for name in names for scene in families.get(name, [name])]
    unknown = [name for name in wanted if name not in SCENES]
    if unknown:
        parser.error(f"no scene is called {unknown[0]}; there are {', '.join(SCENES)}")
    folder = os.path.abspath(folder)
    os.makedirs(folder, exist_ok=True)
    for name in wanted:
        build(name, folder, given.quick)
        print(f"{name}: {os.path.getsize(os.path.join(folder, name + '.glb')) / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
