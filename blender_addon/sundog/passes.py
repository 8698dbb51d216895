# SPDX-License-Identifier: GPL-3.0-or-later
"""Render passes: Blender's switches and names, and the program's names for the same."""

import collections

import bpy

from . import denoise

# `switch` of the view layer, or several, of which one is enough; `program`: the program's name; `name`: Blender's; channels as Blender's compositor has them.
Pass = collections.namedtuple("Pass", "switch program name channels kind")

COMBINED = Pass(None, "Combined", "Combined", "RGBA", "COLOR")

# The program's name of all of the view layer's AOVs.
AOV = "AOV"

# Kinds of Cryptomatte, and how many passes of two ranks each has: Blender's default of six levels.
MATTES = ("Object", "Material", "Asset")
MATTE_PARTS = 3

# (switch, the program's name, Blender 5's name, channels, kind); Blender 4 has the program's names.
_PASSES = (
    ("use_pass_z", "Depth", "Depth", "Z", "VALUE"),
    ("use_pass_position", "Position", "Position", "XYZ", "VECTOR"),
    ("use_pass_normal", "Normal", "Normal", "XYZ", "VECTOR"),
    ("use_pass_vector", "Vector", "Vector", "XYZW", "VECTOR"),
    ("use_pass_mist", "Mist", "Mist", "Z", "VALUE"),
    ("use_pass_ambient_occlusion", "AO", "Ambient Occlusion", "RGB", "COLOR"),
    ("cycles.use_pass_shadow_catcher", "Shadow Catcher", "Shadow Catcher", "RGB", "COLOR"),
    ("use_pass_object_index", "IndexOB", "Object Index", "X", "VALUE"),
    ("use_pass_material_index", "IndexMA", "Material Index", "X", "VALUE"),
    ("use_pass_uv", "UV", "UV", "UVA", "VECTOR"),
    ("use_pass_diffuse_direct", "DiffDir", "Diffuse Direct", "RGB", "COLOR"),
    ("use_pass_diffuse_indirect", "DiffInd", "Diffuse Indirect", "RGB", "COLOR"),
    ("use_pass_diffuse_color", "DiffCol", "Diffuse Color", "RGB", "COLOR"),
    ("use_pass_glossy_direct", "GlossDir", "Glossy Direct", "RGB", "COLOR"),
    ("use_pass_glossy_indirect", "GlossInd", "Glossy Indirect", "RGB", "COLOR"),
    ("use_pass_glossy_color", "GlossCol", "Glossy Color", "RGB", "COLOR"),
    ("use_pass_transmission_direct", "TransDir", "Transmission Direct", "RGB", "COLOR"),
    ("use_pass_transmission_indirect", "TransInd", "Transmission Indirect", "RGB", "COLOR"),
    ("use_pass_transmission_color", "TransCol", "Transmission Color", "RGB", "COLOR"),
    ("cycles.use_pass_volume_direct", "VolumeDir", "Volume Direct", "RGB", "COLOR"),
    ("cycles.use_pass_volume_indirect", "VolumeInd", "Volume Indirect", "RGB", "COLOR"),
    ("use_pass_emit", "Emit", "Emission", "RGB", "COLOR"),
    ("use_pass_environment", "Env", "Environment", "RGB", "COLOR"),
    *(
        (f"use_pass_cryptomatte_{kind.lower()}", f"Crypto{kind}0{part}", f"Crypto{kind}0{part}", "rgba", "COLOR")
        for kind in MATTES
        for part in range(MATTE_PARTS)
    ),
    ("sundog.use_pass_albedo cycles.denoising_store_passes", "Denoising Albedo", "Denoising Albedo", "RGB", "COLOR"),
    ("sundog.use_pass_denoising_normal cycles.denoising_store_passes", "Denoising Normal", "Denoising Normal", "XYZ", "VECTOR"),
    ("cycles.denoising_store_passes", "Denoising Depth", "Denoising Depth", "Z", "VALUE"),
    ("cycles.pass_render_time", "Cost", "Render Time", "X", "VALUE"),
    ("sundog.use_pass_sample_count cycles.pass_debug_sample_count", "Debug Sample Count", "Debug Sample Count", "X", "VALUE"),
)

# What Blender has in other units: milliseconds, where the program writes nanoseconds.
UNITS = {"Cost": 1e-6}

# There whenever the picture is denoised, as in Cycles.
NOISY = Pass(None, "Noisy Image", "Noisy Image", "RGBA", "COLOR")

# Passes that are denoised on request; that of shadow catchers ever is, as in Cycles.
CATCHER = "Shadow Catcher"
LIGHT = (
    "AO", "DiffDir", "DiffInd", "GlossDir", "GlossInd", "TransDir", "TransInd", "VolumeDir", "VolumeInd", "Emit", "Env",
)  # fmt: skip
# The switch of a pass that comes with another, which the program is not asked for.
BESIDE = "beside"

PASSES = tuple(
    Pass(switch, program, name if bpy.app.version >= (5, 0, 0) else program, channels, kind)
    for switch, program, name, channels, kind in _PASSES
)

# Blender's switches without a pass here.
UNKNOWN = {
    "use_pass_shadow": "Shadow",
    "use_pass_subsurface_direct": "Subsurface Direct",
    "use_pass_subsurface_indirect": "Subsurface Indirect",
    "use_pass_subsurface_color": "Subsurface Color",
    "cycles.use_pass_volume_scatter": "Volume Scatter",
    "cycles.use_pass_volume_transmit": "Volume Transmit",
    "cycles.use_pass_volume_majorant": "Volume Majorant",
}

# What Cycles 5.2 stores for denoisers besides.
STORED = ("Denoising Roughness", "Denoising Specular Albedo") if bpy.app.version >= (5, 2, 0) else ()


def _is_on(view_layer, switches):
    return any(_one_is_on(view_layer, switch) for switch in switches.split())


def _one_is_on(view_layer, switch):
    found = view_layer
    for name in switch.split("."):
        found = getattr(found, name, None)
    return bool(found)


def wanted(scene, view_layer):
    """The passes that a scene's view layer asks for, with Combined first."""
    noisy = [NOISY] if denoise.is_on(scene, view_layer) else []
    parts = matte_parts(view_layer)
    # The numbers of the passes that there are more of than levels.
    more = tuple(f"0{part}" for part in range(parts, MATTE_PARTS))
    on = [p for p in PASSES if _is_on(view_layer, p.switch)]
    kept = [p for p in on if not (p.program.startswith("Crypto") and p.program.endswith(more))]
    own = [_aov(aov) for aov in view_layer.aovs if aov.is_valid]
    found = kept + own + light_groups(view_layer)
    return [COMBINED] + noisy + found + [_noisy(p) for p in denoised(scene, view_layer, found)]


def denoised(scene, view_layer, found):
    """Those of some passes that are denoised beside the picture."""
    if not denoise.is_on(scene, view_layer):
        return []
    group = f"{COMBINED.program}_"
    light = [p for p in found if p.switch != AOV and (p.program in LIGHT or p.program.startswith(group))]
    catchers = [p for p in found if p.switch != AOV and p.program == CATCHER]
    return catchers + (light if scene.sundog.denoising_passes else [])


def _noisy(p):
    return Pass(BESIDE, f"Noisy {p.program}", f"Noisy {p.name}", p.channels, p.kind)


def light_groups(view_layer):
    """The passes of a view layer's light groups, which the program makes of those that the file has."""
    names = [f"{COMBINED.name}_{group.name}" for group in view_layer.lightgroups]
    return [Pass(None, name, name, "RGB", "COLOR") for name in names]


def _aov(aov):
    channels = "RGBA" if aov.type == "COLOR" else "X"
    return Pass(AOV, aov.name, aov.name, channels, aov.type)


def names(passes):
    """What the program is asked for: all AOVs together have one name, and noisy passes come with the denoised ones."""
    return [p.program for p in passes if p.switch not in {AOV, BESIDE}] + [AOV] * any(p.switch == AOV for p in passes)


def matte_parts(view_layer):
    """Passes of each kind of Cryptomatte: one for two levels."""
    return min((view_layer.pass_cryptomatte_depth + 1) // 2, MATTE_PARTS)


def left_out(view_layer):
    """Names of the passes that a view layer asks for and Sundog does not have."""
    names = [name for switch, name in UNKNOWN.items() if _is_on(view_layer, switch)]
    if _is_on(view_layer, "cycles.denoising_store_passes"):
        names += STORED
    levels = 2 * MATTE_PARTS
    if view_layer.pass_cryptomatte_depth > levels and any(_is_on(view_layer, f"use_pass_cryptomatte_{kind.lower()}") for kind in MATTES):
        names.append(f"Cryptomatte levels beyond {levels}")
    return names + [aov.name for aov in view_layer.aovs if not aov.is_valid]
