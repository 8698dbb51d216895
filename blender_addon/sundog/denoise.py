# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoising: whether, and how, by the scene's settings for Cycles; and what it did to the brightness."""

import os

import bpy

LIBRARY = "libOpenImageDenoise.so.2"
# Names a folder with the library; a person's own wins.
VARIABLE = "OIDN_DIR"

_PREFILTERS = {"NONE": "none", "FAST": "fast", "ACCURATE": "accurate"}
_GUIDES = {"RGB": "none", "RGB_ALBEDO": "albedo", "RGB_ALBEDO_NORMAL": "albedo-normal"}
_QUALITIES = {"HIGH": "high", "BALANCED": "balanced", "FAST": "fast"}


def is_on(scene, layer):
    """Whether the picture of a view layer is denoised."""
    choice = scene.sundog.denoising
    if choice != "CYCLES":
        return choice == "ON"
    # Without Cycles nobody has asked for it.
    return all(bool(getattr(getattr(data, "cycles", None), "use_denoising", False)) for data in (scene, layer))


def arguments(scene, layer, abilities, warn):
    """Flags for the denoiser. `warn(text)` is told if the program has none."""
    if not is_on(scene, layer):
        return []
    if not abilities.has("denoise"):
        warn(f"sundog {abilities.version} does not know --denoise: the picture stays noisy")
        return []
    # A render inside Blender goes on without the library.
    result = ["--denoise", "--denoise-optional"]
    cycles = getattr(scene, "cycles", None)
    for flag, name, words in (
        ("prefilter", "denoising_prefilter", _PREFILTERS),
        ("guides", "denoising_input_passes", _GUIDES),
        ("quality", "denoising_quality", _QUALITIES),
    ):
        # Cycles 4.1 and older have no quality.
        word = words.get(getattr(cycles, name, None))
        if word:
            result += [f"--denoise-{flag}", word]
    if scene.sundog.denoising_keep_energy:
        result += ["--denoise-keep-energy"]
    # "all" of a picture without passes of light is none.
    if scene.sundog.denoising_passes:
        result += flag_if_known("denoise-passes", ["all"], abilities, warn)
    if scene.sundog.denoised_error_target > 0:
        result += flag_if_known("denoised-error", [f"{scene.sundog.denoised_error_target:.6g}"], abilities, warn)
    return result


# What Cycles 5.2 may do otherwise where developers switch it, and what Sundog does.
_SWITCHES = {
    "denoising_pass_follow_reflections": "Denoising Pass Reflections is off: Sundog's denoising passes follow reflections all the same",
    "denoising_pass_use_albedo_roughness_weighting":
        "Denoising Pass Albedo Roughness Weighting is off: Sundog's Denoising Albedo is weighted by roughness all the same",
}  # fmt: skip


def differences(scene, layer):
    """What the passes for denoisers do otherwise than the view layer asks for, where anything uses them."""
    cycles = getattr(layer, "cycles", None)
    if not is_on(scene, layer) and not getattr(cycles, "denoising_store_passes", False):
        return []
    return [words for name, words in _SWITCHES.items() if not getattr(cycles, name, True)]


def flag_if_known(flag, values, abilities, warn):
    """A flag with its values, or a warning that the program is too old for it."""
    if abilities.has(flag):
        return [f"--{flag}", *values]
    warn(f"sundog {abilities.version} does not know --{flag}: it renders without")
    return []


def environment():
    """The program's environment: it takes the library that Cycles takes, where Blender brings one."""
    if os.environ.get(VARIABLE):
        return None
    folder = blenders_library()
    return {**os.environ, VARIABLE: folder} if folder else None


def blenders_library():
    """The folder of the library that this Blender brings; None where it brings none."""
    data = bpy.utils.resource_path("LOCAL")
    # The folder of the version lies beside that of the libraries.
    folder = os.path.join(os.path.dirname(data), "lib") if data else ""
    return folder if os.path.isfile(os.path.join(folder, LIBRARY)) else None


def error_words(found):
    """How far the denoised picture looks from the truth, from the program's report; "" if nobody has asked."""
    error = (found or {}).get("error")
    return f"denoised FLIP {error['flip']:.4f} ({error['low']:.4f} to {error['high']:.4f}), by both halves" if error else ""


def words(found):
    """What denoising did to the brightness, from the program's report; "" if nothing is known."""
    shift = (found or {}).get("shift")
    if not shift:
        return ""
    largest = shift["largest"]
    return (
        f"brightness shift {shift['mean']:.2%} ± {shift['mean_interval']:.2%},"
        f" largest block {largest['shift']:.1%} ± {largest['interval']:.1%}"
    )
