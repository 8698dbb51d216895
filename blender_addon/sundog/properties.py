# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings: `scene.sundog`, named as in `scene.cycles`, and `view_layer.sundog`."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

MOST_BOUNCES = 1024

FILTERS = (
    ("BOX", "Box", "One pixel wide: each pixel is the mean over itself"),
    ("GAUSSIAN", "Gaussian", "A bell whose standard deviation is a quarter of its width"),
    ("BLACKMAN_HARRIS", "Blackman-Harris", "Cycles' default"),
)

DENOISING = (
    ("CYCLES", "As in Cycles", "As the scene and the view layer say for Cycles"),
    ("ON", "On", "Always"),
    ("OFF", "Off", "Never"),
)

SEQUENCES = (
    ("TWO", "Two Sequences", "By turns of two independent sequences: the error is told without bias"),
    ("ONE", "One Sequence", "All of one, as in Cycles: less noise where light is smooth, and the error is told too large"),
)

EXCHANGES = (
    ("GLTF", "glTF", "With extensions of Sundog's own, by which all that it renders comes through"),
    ("USD", "USD", "By Blender's own exporter. What that leaves out is told by the Scene Check"),
)


def _bounces(name, default, description):
    return IntProperty(name=name, description=description, default=default, min=0, max=MOST_BOUNCES)


class SundogSceneSettings(bpy.types.PropertyGroup):
    """How a scene is rendered."""

    samples: IntProperty(name="Samples", description="Samples of each pixel", default=256, min=1, max=1 << 20)
    time_limit: FloatProperty(
        name="Time Limit",
        description="End after this time, of which loading and preparing are a part, but not the export; 0 for no limit",
        default=0.0, min=0.0, subtype="TIME_ABSOLUTE", unit="TIME_ABSOLUTE", step=100,
    )
    error_target: FloatProperty(
        name="Error",
        description="Stop when the estimated error (root of the relative mean squared error of the picture) is not above this;"
        " 0 for no target. Another measure than Cycles' Noise Threshold",
        default=0.0, min=0.0, soft_max=0.5, precision=4, step=0.1,
    )
    use_adaptive_sampling: BoolProperty(
        name="Noise Threshold", default=False,
        description="Cycles' adaptive sampling: stop each pixel where half of its samples agree with all of them. Takes the work that the file"
        " takes in Cycles; its error is measured against the root of the brightness, from the pixel's own samples",
    )
    adaptive_threshold: FloatProperty(
        name="Noise Threshold", description="As in Cycles: less is more work; 0 lets the samples say it. No share of the brightness",
        default=0.01, min=0.0, max=1.0, soft_min=0.001, precision=4, step=0.1,
    )
    adaptive_min_samples: IntProperty(
        name="Min Samples", description="As in Cycles: samples of each pixel before it may stop; 0 lets the threshold say it",
        default=0, min=0, max=4096,
    )
    pixel_error_target: FloatProperty(
        name="Pixel Error",
        description="Adaptive sampling: take samples where the estimated error of the pixel is above this, and stop when it is"
        " nowhere; 0 for the same samples everywhere. Samples is then the most that a pixel gets. A share of the brightness, as the"
        " pixels around let expect. Not beside Noise Threshold",
        default=0.0, min=0.0, soft_max=0.5, precision=4, step=0.1,
    )
    max_bounces: _bounces("Total", 12, "Most bounces of a path; 0 is direct light alone")
    diffuse_bounces: _bounces("Diffuse", 4, "Most diffuse reflections of a path")
    glossy_bounces: _bounces("Glossy", 4, "Most glossy reflections of a path")
    transmission_bounces: _bounces("Transmission", 12, "Most passages of a path through glass")
    volume_bounces: _bounces("Volume", 0, "Most scatterings of a path by volumes; 0 leaves light that is scattered once")
    transparent_max_bounces: _bounces("Transparent", 8, "Most surfaces that a path passes by their transparency")
    min_light_bounces: IntProperty(
        name="Min Light Bounces", description="Further bounces that no path ends by chance before; more time, and less noise",
        default=0, min=0, max=1000,
    )
    sample_clamp_direct: FloatProperty(
        name="Direct Light", description="Greatest value of a contribution of direct light; 0 for no limit. Takes light away",
        default=0.0, min=0.0, max=1e9, soft_max=100.0,
    )
    sample_clamp_indirect: FloatProperty(
        name="Indirect Light", description="Greatest value of a contribution of indirect light; 0 for no limit. Takes light away"
        " (Cycles has 10 by default)",
        default=0.0, min=0.0, max=1e9, soft_max=100.0,
    )
    blur_glossy: FloatProperty(
        name="Filter Glossy", description="Makes reflections rougher behind blurring bounces; 0 for off (Cycles has 1 by default)",
        default=0.0, min=0.0, max=1e6, soft_max=10.0,
    )
    caustics_reflective: BoolProperty(
        name="Reflective Caustics", default=True,
        description="Light that reflections throw on diffuse surfaces. Off takes it away",
    )
    caustics_refractive: BoolProperty(
        name="Refractive Caustics", default=True,
        description="Light that glass throws on diffuse surfaces. Off takes it away, and makes what stands under glass darker",
    )
    film_exposure: FloatProperty(
        name="Exposure", description="Factor on all light of the picture; data and colours of surfaces stay as they are",
        default=1.0, min=0.0, max=10240.0, soft_max=10.0,
    )
    film_transparent_glass: BoolProperty(
        name="Transparent Glass", default=False,
        description="Where the film is transparent, it is so behind glass, too: for glass over another picture",
    )
    film_transparent_roughness: FloatProperty(
        name="Roughness Threshold", default=0.1, min=0.0, max=1.0, description="Glass that is rougher is opaque",
    )
    pixel_filter_type: EnumProperty(name="Filter Type", description="Pixel filter", items=FILTERS, default="BLACKMAN_HARRIS")
    filter_width: FloatProperty(name="Width", description="Width of the pixel filter", default=1.5, min=0.01, max=10.0, subtype="PIXEL")
    seed: IntProperty(name="Seed", description="Selects another independent random sequence", default=0, min=0)
    sequences: EnumProperty(
        name="Samples", items=SEQUENCES, default="TWO",
        description="How the samples of a pixel are spread",
    )
    denoising: EnumProperty(
        name="Denoising", items=DENOISING, default="CYCLES",
        description="Take the noise out of the final render with Open Image Denoise. Passes, prefilter and quality are the scene's for Cycles",
    )
    denoising_keep_energy: BoolProperty(
        name="Keep Brightness", default=False,
        description="Give back the brightness that denoising moved: of blocks as far as it is certain, of the whole exactly",
    )
    denoising_passes: BoolProperty(
        name="Passes", default=False,
        description="Denoise the passes of light as well, light groups too; each stays beside as it was, as Noisy and its name",
    )
    denoised_error_target: FloatProperty(
        name="Denoised Error",
        description="Stop when the denoised picture looks as near to the truth as this (mean FLIP, as shown); 0 for no target. Told by both"
        " halves of the samples, denoised each by itself: what the denoiser guesses wrong in both alike is in it as a mean over scenes alone",
        default=0.0, min=0.0, soft_max=0.5, precision=4, step=0.1,
    )
    use_animated_seed: BoolProperty(name="Animate Seed", description="Other random numbers in each frame", default=False)
    exchange: EnumProperty(name="Exchange", description="Format in which the program gets the scene", items=EXCHANGES, default="GLTF")


class SundogViewLayerSettings(bpy.types.PropertyGroup):
    """Passes that Blender itself has no switch for."""

    use_pass_albedo: BoolProperty(name="Denoising Albedo", description="Colour of what the camera sees, also in mirrors and through glass")
    use_pass_denoising_normal: BoolProperty(name="Denoising Normal", description="Normal of the same, in the camera's axes")
    use_pass_sample_count: BoolProperty(name="Sample Count", description="Samples of each pixel")
    use_centre_passes: BoolProperty(
        name="Data at Pixel Centres", default=False,
        description="Normals, UV, mist and Cryptomatte without filtering, by the ray through each pixel's middle: for data sets",
    )


class SundogMaterialSettings(bpy.types.PropertyGroup):
    """What Blender's materials do not say."""

    use_priority: BoolProperty(
        name="Nesting Priority", default=False,
        description="Where solids with such priorities overlap, as ice in water in a glass, that of the highest one is there",
    )
    priority: IntProperty(
        name="Priority", default=0,
        description="The solid of the higher priority is there; of several with the same one the last that the light has entered",
    )


# Cycles' names of what both have.
COPIED = (
    "samples", "time_limit", "max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces",
    "volume_bounces", "transparent_max_bounces", "min_light_bounces", "sample_clamp_direct", "sample_clamp_indirect", "blur_glossy", "pixel_filter_type",
    "filter_width", "seed", "use_animated_seed", "film_exposure", "film_transparent_glass",
    "film_transparent_roughness", "caustics_reflective", "caustics_refractive",
    "use_adaptive_sampling", "adaptive_threshold", "adaptive_min_samples",
)

def noise_threshold(settings):
    """The threshold that stops pixels; `None` where that is off. As in Cycles, the samples say it where it is 0."""
    if not settings.use_adaptive_sampling:
        return None
    return settings.adaptive_threshold or max(0.001, 1.0 / max(settings.samples, 1))


def copy_from_cycles(scene):
    """Copies what `scene.cycles` says; returns sentences on what has no place here. Raises AttributeError without Cycles."""
    cycles, settings = scene.cycles, scene.sundog
    for name in COPIED:
        setattr(settings, name, getattr(cycles, name))
    for layer in scene.view_layers:
        layer.sundog.use_pass_albedo = layer.cycles.denoising_store_passes
        layer.sundog.use_pass_denoising_normal = layer.cycles.denoising_store_passes
        layer.sundog.use_pass_sample_count = layer.cycles.pass_debug_sample_count
    settings.pixel_error_target = 0.0
    settings.denoising = "CYCLES"
    # As there: one sequence a pixel.
    settings.sequences = "ONE"
    return list(_notes(scene, cycles))


def _notes(scene, cycles):
    if cycles.time_limit > 0:
        yield "the time limit counts loading and preparing, too"
    if getattr(cycles, "use_guiding", False):
        yield "there is no path guiding, which changes noise alone"
    if getattr(cycles, "use_sample_subset", False) or getattr(cycles, "sample_offset", 0):
        yield "there are no sample subsets"


class SUNDOG_OT_copy_settings_from_cycles(bpy.types.Operator):
    """Take samples, bounces, clamping, filter and seed from the scene's settings for Cycles"""

    bl_idname = "sundog.copy_settings_from_cycles"
    bl_label = "Copy Settings from Cycles"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        """Only where Cycles is enabled."""
        return hasattr(context.scene, "cycles")

    def execute(self, context):
        """Copies, and says what has no place here."""
        notes = copy_from_cycles(context.scene)
        self.report({"INFO"}, "Settings copied from Cycles" + "".join(f"; {note}" for note in notes))
        return {"FINISHED"}


_CLASSES = (SundogSceneSettings, SundogViewLayerSettings, SundogMaterialSettings, SUNDOG_OT_copy_settings_from_cycles)


def register():
    """Adds the settings to scenes, view layers and materials."""
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.sundog = PointerProperty(type=SundogSceneSettings, name="Sundog")
    bpy.types.ViewLayer.sundog = PointerProperty(type=SundogViewLayerSettings, name="Sundog")
    bpy.types.Material.sundog = PointerProperty(type=SundogMaterialSettings, name="Sundog")


def unregister():
    """Takes them away."""
    del bpy.types.Material.sundog
    del bpy.types.ViewLayer.sundog
    del bpy.types.Scene.sundog
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
