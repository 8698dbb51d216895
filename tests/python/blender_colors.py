"""Shows pictures as Blender shows them, for tests/color.rs to compare with. Runs in a Python that has `bpy`.

    python blender_colors.py FOLDER

FOLDER has `opaque.exr` (RGB) and `alpha.exr` (RGBA, associated). Every view of every display, every look that Blender lets
go with it on the first display, some exposures and gammas, 8 and 16 bits: each is saved into FOLDER by
`Image.save_render`, without dither, and described in FOLDER/cases.json, with the configuration that Blender used.
"""

import ast
import json
import os
import sys

import bpy


def choices(owner, name):
    """What an enumeration accepts now. Blender tells only by refusing."""
    try:
        setattr(owner, name, "no such thing")
    except TypeError as refusal:
        text = str(refusal)
        names = ast.literal_eval(text[text.rindex(" not found in ") + len(" not found in "):])
        return [names] if isinstance(names, str) else list(names)
    raise SystemExit(f"Blender accepted nonsense for {name}")


def load(path):
    image = bpy.data.images.load(path)
    if not image.is_float:
        raise SystemExit(f"Blender read {path} as bytes")
    if image.colorspace_settings.name != "Linear Rec.709":
        raise SystemExit(f"Blender took {path} for {image.colorspace_settings.name}")
    return image


def main(folder):
    scene = bpy.context.scene
    display, view = scene.display_settings, scene.view_settings
    scene.render.dither_intensity = 0.0
    output = scene.render.image_settings
    output.file_format = "PNG"
    output.compression = 0
    pictures = {"opaque": load(os.path.join(folder, "opaque.exr")), "alpha": load(os.path.join(folder, "alpha.exr"))}
    cases = []

    def save(picture, mode, depth, look, exposure, gamma):
        view.look, view.exposure, view.gamma = look, exposure, gamma
        output.color_mode, output.color_depth = mode, depth
        name = f"case-{len(cases):04}.png"
        pictures[picture].save_render(os.path.join(folder, name), scene=scene)
        cases.append({
            "file": name,
            "picture": picture,
            "mode": mode,
            "depth": int(depth),
            "display": display.display_device,
            "view": view.view_transform,
            "look": None if look == "None" else look,
            "exposure": exposure,
            "gamma": gamma,
        })

    displays = choices(display, "display_device")
    looks = {}
    for index, name in enumerate(displays):
        display.display_device = name
        for view_name in choices(view, "view_transform"):
            view.view_transform = view_name
            view.look = "None"
            allowed = choices(view, "look")
            looks[f"{name}|{view_name}"] = [look for look in allowed if look != "None"]
            for look in allowed if index == 0 else allowed[:2]:
                save("opaque", "RGB", "8", look, 0.0, 1.0)
            if index > 0:
                save("opaque", "RGB", "8", "None", -0.5, 1.6)
            else:
                for exposure, gamma in [(1.5, 1.0), (-3.25, 1.0), (0.0, 2.2), (0.0, 0.6), (2.0, 1.4)]:
                    save("opaque", "RGB", "8", "None", exposure, gamma)
                save("opaque", "RGB", "8", allowed[-1], -1.0, 1.8)
                save("opaque", "RGB", "16", "None", 0.0, 1.0)
                save("alpha", "RGBA", "8", "None", 0.0, 1.0)
                save("alpha", "RGBA", "16", "None", 0.5, 1.2)
                save("alpha", "RGB", "8", "None", 0.0, 1.0)

    config = os.path.join(bpy.utils.system_resource("DATAFILES"), "colormanagement", "config.ocio")
    with open(os.path.join(folder, "cases.json"), "w", encoding="utf-8") as file:
        json.dump({"blender": bpy.app.version_string, "config": config, "looks": looks, "cases": cases}, file)


main(sys.argv[1])
