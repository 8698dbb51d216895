# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene's settings as the program's command line."""

import numpy

from .denoise import flag_if_known
from .export.camera import picture_size
from .passes import names
from .properties import noise_threshold

_FILTERS = {"BLACKMAN_HARRIS": "blackman-harris", "GAUSSIAN": "gauss", "BOX": "box"}

# By whether there are reflective and refractive ones.
_CAUSTICS = {(True, True): "all", (True, False): "reflective", (False, True): "refractive", (False, False): "none"}


def border(render):
    """(x0, y0, x1, y1) of the pixels that are rendered, counted from the bottom left as Blender does; f32 as there."""
    width, height = picture_size(render)
    if not render.use_border:
        return 0, 0, width, height

    def edge(fraction, pixels):
        return int(numpy.float32(fraction) * numpy.float32(pixels))

    return (
        edge(render.border_min_x, width), edge(render.border_min_y, height),
        edge(render.border_max_x, width), edge(render.border_max_y, height),
    )  # fmt: skip


def seed(scene):
    """The seed of the current frame."""
    settings = scene.sundog
    if not settings.use_animated_seed:
        return settings.seed
    # Neighbouring frames and seeds must not meet: steps of the golden ratio in 32 bits.
    frame = int(scene.frame_current) * 64 + int(scene.frame_subframe * 64)
    return (settings.seed + frame * 0x9E3779B1) & 0xFFFFFFFF


def samples(scene, layer):
    """Samples of each pixel of a view layer: its own, if it has any and the scene lets them count, or at most these."""
    most, own = scene.sundog.samples, layer.samples
    counts = getattr(getattr(scene, "cycles", None), "use_layer_samples", "USE")
    if not own or counts == "IGNORE":
        return most
    return min(own, most) if counts == "BOUNDED" else own


def arguments(scene, layer, abilities, warn):
    """Flags for the picture, the effort and the light transport. `warn(text)` is told what the program cannot do."""
    settings, render = scene.sundog, scene.render
    width, height = picture_size(render)
    pixel_filter = _FILTERS[settings.pixel_filter_type]
    if settings.pixel_filter_type != "BOX":
        pixel_filter += f":{settings.filter_width:.6g}"
    result = ["--width", str(width), "--height", str(height), "--filter", pixel_filter, "--samples", str(samples(scene, layer))]
    x0, y0, x1, y1 = border(render)
    if (x0, y0, x1, y1) != (0, 0, width, height):
        result += ["--region", f"{x0},{height - y1},{x1},{height - y0}"]
    # The cache and the images lie where they lie.
    if abilities.has("allow-outside"):
        result += ["--allow-outside"]
    if settings.time_limit > 0:
        result += ["--time", f"{settings.time_limit:.6f}s"]
    for flag, value in (
        ("bounces", settings.max_bounces),
        ("bounces-diffuse", settings.diffuse_bounces),
        ("bounces-glossy", settings.glossy_bounces),
        ("bounces-transmission", settings.transmission_bounces),
        ("bounces-volume", settings.volume_bounces),
        ("bounces-transparent", settings.transparent_max_bounces),
    ):
        result += [f"--{flag}", str(value)]
    for flag, value in (
        ("clamp-direct", settings.sample_clamp_direct),
        ("clamp-indirect", settings.sample_clamp_indirect),
        ("filter-glossy", settings.blur_glossy),
    ):
        if value > 0:
            result += [f"--{flag}", repr(value)]
    if settings.min_light_bounces:
        # As in Cycles, two bounces more than it says. Clamping takes other light from paths that play seldom.
        result += flag_if_known("roulette", [str(settings.min_light_bounces + 2)], abilities, warn)
    clamps = settings.sample_clamp_direct > 0 or settings.sample_clamp_indirect > 0
    tree = getattr(getattr(scene, "cycles", None), "use_light_tree", True)
    if clamps or not tree:
        # What clamping takes depends on how often each light is drawn, and so does what steep bumps and smooth normals lose.
        result += flag_if_known("tree-lights" if tree else "even-lights", [], abilities, warn)
    result += ["--seed", str(seed(scene))]
    if settings.sequences == "ONE":
        result += flag_if_known("sequences", ["1"], abilities, warn)
    if render.threads_mode == "FIXED":
        result += ["--threads", str(render.threads)]
    threshold = noise_threshold(settings)
    for flag, target in (
        ("error", settings.error_target),
        ("noise-threshold", threshold or 0.0),
        ("pixel-error", 0.0 if threshold else settings.pixel_error_target),
    ):
        if target > 0:
            result += flag_if_known(flag, [f"{target:.6g}"], abilities, warn)
    if threshold and settings.adaptive_min_samples and abilities.has("min-samples"):
        result += ["--min-samples", str(settings.adaptive_min_samples)]
    if settings.film_exposure != 1:
        result += flag_if_known("film-exposure", [f"{settings.film_exposure:.6g}"], abilities, warn)
    caustics = _CAUSTICS[settings.caustics_reflective, settings.caustics_refractive]
    if caustics != "all":
        result += flag_if_known("caustics", [caustics], abilities, warn)
    if layer.sundog.use_centre_passes:
        result += flag_if_known("centre-passes", [], abilities, warn)
    if render.film_transparent:
        result += flag_if_known("transparent", [], abilities, warn)
        if settings.film_transparent_glass:
            result += flag_if_known("transparent-glass", [f"{settings.film_transparent_roughness:.6g}"], abilities, warn)
    return result


_FALLOFFS = {"QUADRATIC": 2.0, "LINEAR": 1.0, "INVERSE_QUADRATIC": 0.5}


def pass_arguments(passes, abilities, layer, world=None):
    """Flags for the passes of a view layer that the last frame shall have; `world`: the scene's."""
    if not abilities.has("passes"):
        return []
    # Those of light groups come with the file.
    own = [p for p in passes if not p.program.startswith("Combined_")]
    result = ["--passes", ",".join(names(own))]
    if any(p.program == "Mist" for p in passes) and abilities.has("mist"):
        # As Cycles has it where there is no world.
        start, depth, power = 0.0, 100.0, 1.0
        if world is not None:
            mist = world.mist_settings
            start, depth, power = mist.start, mist.depth, _FALLOFFS[mist.falloff]
        result += ["--mist", f"{start!r},{depth!r},{power}"]
    if any(p.program == "AO" for p in passes) and abilities.has("ao-distance"):
        # Mist is of the scene's world, and this of the view layer's. Without any, nothing is too far.
        own = getattr(layer, "world_override", None) or world
        result += ["--ao-distance", repr(own.light_settings.distance) if own is not None else "1e9"]
    if abilities.has("alpha-threshold"):
        result += ["--alpha-threshold", f"{layer.pass_alpha_threshold:.6g}"]
    return result
