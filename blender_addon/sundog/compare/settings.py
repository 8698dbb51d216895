# SPDX-License-Identifier: GPL-3.0-or-later
"""What both engines render with, and putting everything back as it was."""

import dataclasses


@dataclasses.dataclass
class Options:
    """How the two pictures are made."""

    # Samples a pixel of both; None for what Sundog's settings say.
    samples: int | None = None
    # Leave Cycles as the file has it: samples, noise threshold, denoising, clamping, device.
    cycles_defaults: bool = False
    # Percentage of the resolution; None for the file's.
    percentage: int | None = None
    # Frame; None for the current one.
    frame: int | None = None


class Kept:
    """Values of settings, put back at the end of a `with` in the order in which they were named."""

    def __init__(self):
        self._values = []

    def __enter__(self):
        return self

    def __exit__(self, *_error):
        for owner, name, value in self._values:
            try:
                setattr(owner, name, value)
            except (AttributeError, TypeError, ValueError):
                # A value that this Blender shows but does not take (an image format it was built without).
                continue

    def keep(self, owner, *names):
        """Remembers what a render may change."""
        for name in names:
            if hasattr(owner, name):
                self._values.append((owner, name, getattr(owner, name)))

    def set(self, owner, **values):
        """Sets what this version of Blender has, and remembers what it was."""
        self.keep(owner, *values)
        for name, value in values.items():
            if hasattr(owner, name):
                setattr(owner, name, value)


# An image format decides which depths and modes there are: in this order they can be put back.
_IMAGE_FORMAT = (
    "media_type", "file_format", "color_mode", "color_depth", "exr_codec", "compression", "color_management", "use_preview",
    "views_format",
)  # fmt: skip


def same_for_both(kept, scene, options):
    """The picture itself: no compositor, no sequencer, one view, linear EXR."""
    kept.keep(scene.render.image_settings, *_IMAGE_FORMAT)
    kept.keep(scene.render, "engine", "filepath")
    kept.set(
        scene.render,
        use_compositing=False, use_sequencer=False, use_multiview=False, use_freestyle=False, use_persistent_data=False,
        use_overwrite=True, use_placeholder=False, use_file_extension=False, dither_intensity=0.0,
    )  # fmt: skip
    if options.percentage is not None:
        kept.set(scene.render, resolution_percentage=options.percentage)
    if options.frame is not None and options.frame != scene.frame_current:
        kept.keep(scene, "frame_current", "frame_subframe")
    if options.samples and not options.cycles_defaults:
        for layer in scene.view_layers:
            # Would win over the scene's.
            kept.set(layer, samples=0)
    sundog = scene.sundog
    kept.set(
        sundog, samples=options.samples or sundog.samples, time_limit=0.0, error_target=0.0, pixel_error_target=0.0,
        use_adaptive_sampling=False, use_animated_seed=False,
    )  # fmt: skip


def as_sundog(kept, scene):
    """Cycles by Sundog's settings: what biases it or differs from pixel to pixel is off."""
    sundog, cycles = scene.sundog, scene.cycles
    kept.set(
        cycles,
        device="CPU", samples=sundog.samples, time_limit=0.0, seed=sundog.seed, use_animated_seed=False,
        use_adaptive_sampling=False, use_denoising=False, use_sample_subset=False, sample_offset=0, use_layer_samples="USE",
        # Neighbouring pixels share no random numbers.
        auto_scrambling_distance=False, scrambling_distance=1.0,
        max_bounces=sundog.max_bounces, diffuse_bounces=sundog.diffuse_bounces, glossy_bounces=sundog.glossy_bounces,
        transmission_bounces=sundog.transmission_bounces, volume_bounces=sundog.volume_bounces,
        transparent_max_bounces=sundog.transparent_max_bounces,
        min_light_bounces=sundog.min_light_bounces, min_transparent_bounces=0,
        sample_clamp_direct=sundog.sample_clamp_direct, sample_clamp_indirect=sundog.sample_clamp_indirect,
        blur_glossy=sundog.blur_glossy, light_sampling_threshold=0.0,
        caustics_reflective=sundog.caustics_reflective, caustics_refractive=sundog.caustics_refractive,
        use_fast_gi=False, use_guiding=False,
        pixel_filter_type=sundog.pixel_filter_type, filter_width=sundog.filter_width, film_exposure=sundog.film_exposure,
        film_transparent_glass=sundog.film_transparent_glass, film_transparent_roughness=sundog.film_transparent_roughness,
    )  # fmt: skip


def linear_exr(image_settings):
    """32-bit floats without loss, no view transform."""
    _image(image_settings, "OPEN_EXR", "RGBA", "32")
    image_settings.exr_codec = "ZIP"


def display_png(image_settings, transparent):
    """8 bits through the scene's view transform."""
    _image(image_settings, "PNG", "RGBA" if transparent else "RGB", "8")


def _image(image_settings, file_format, mode, depth):
    if hasattr(image_settings, "media_type"):
        image_settings.media_type = "IMAGE"
    image_settings.file_format = file_format
    image_settings.color_mode = mode
    image_settings.color_depth = depth
    if hasattr(image_settings, "color_management"):
        image_settings.color_management = "FOLLOW_SCENE"
