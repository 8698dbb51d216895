# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: Sundog's own, and Blender's that stay visible for it."""

import bpy
from bpy.types import Panel

from . import denoise, records
from .engine import SundogRenderEngine
from .properties import SUNDOG_OT_copy_settings_from_cycles
from .scene_check import SUNDOG_RENDER_PT_scene_check

ENGINE = SundogRenderEngine.bl_idname

# Of the panels that every engine is offered: those that have a panel of Sundog's own, or no meaning here.
HIDDEN = {
    "DATA_PT_light",
    "DATA_PT_preview",
    "DATA_PT_spot",
    "NODE_DATA_PT_light",
    # It would stand above Sampling, which is first in Cycles.
    "RENDER_PT_simplify",
    "RENDER_PT_simplify_viewport",
    "RENDER_PT_simplify_render",
    "RENDER_PT_simplify_greasepencil",
}
# Of the panels that Blender keeps for its own engines: those whose data Sundog renders.
SHOWN = {"DATA_PT_camera_dof", "DATA_PT_camera_dof_aperture", "EEVEE_MATERIAL_PT_context_material"}

# Blender's panels of what is not rendered, and what they then say at their top.
NOT_RENDERED = {
    "DATA_PT_context_volume": "Sundog does not render volume objects",
    "DATA_PT_lightprobe": "Light probes do nothing in Sundog",
    "PHYSICS_PT_smoke": "Sundog does not render smoke",
}

_adopted = []
# (panel, function) of those.
_says = []


def blenders_panels():
    """Blender's panels that make sense for Sundog."""
    found = []
    for panel in Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", ())
        offered = "BLENDER_RENDER" in engines and panel.__name__ not in HIDDEN
        if panel.__name__ in SHOWN or offered:
            found.append(panel)
    return found


def prop(layout, data, name, **options):
    """A property where this version of Blender has it."""
    if name in data.bl_rna.properties:
        layout.prop(data, name, **options)


class _Buttons:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        """For this engine, where there is something to show."""
        return context.engine in cls.COMPAT_ENGINES and cls.applies(context)

    @classmethod
    def applies(cls, _context):
        """Whether there is something to show."""
        return True

    def draw(self, context):
        """Names at the left, values at the right."""
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        self.show(self.layout, context)


class _Closed(_Buttons):
    bl_options = {"DEFAULT_CLOSED"}


# Render


class SUNDOG_RENDER_PT_sampling(_Buttons, Panel):
    bl_label = "Sampling"
    bl_context = "render"

    def show(self, layout, context):
        settings = context.scene.sundog
        layout.prop(settings, "samples")
        layout.prop(settings, "time_limit")
        layout.prop(settings, "error_target")
        layout.prop(settings, "use_adaptive_sampling")
        own = layout.column()
        own.active = settings.use_adaptive_sampling
        own.prop(settings, "adaptive_threshold", text="Threshold")
        own.prop(settings, "adaptive_min_samples")
        other = layout.column()
        other.active = not settings.use_adaptive_sampling
        other.prop(settings, "pixel_error_target")
        layout.operator(SUNDOG_OT_copy_settings_from_cycles.bl_idname, icon="PASTEDOWN")


class SUNDOG_RENDER_PT_denoising(_Buttons, Panel):
    bl_label = "Denoising"
    bl_context = "render"
    bl_parent_id = "SUNDOG_RENDER_PT_sampling"

    def show(self, layout, context):
        scene = context.scene
        layout.prop(scene.sundog, "denoising")
        column = layout.column()
        column.active = denoise.is_on(scene, context.view_layer)
        column.prop(scene.sundog, "denoising_keep_energy")
        column.prop(scene.sundog, "denoising_passes")
        column.prop(scene.sundog, "denoised_error_target")
        if hasattr(scene, "cycles"):
            for name in ("denoising_input_passes", "denoising_prefilter", "denoising_quality"):
                prop(column, scene.cycles, name)
        found = records.last_statistics().get("denoised")
        for part in denoise.words(found).split(", ") + [denoise.error_words(found)]:
            if part:
                layout.label(text=f"Last render: {part}")


class SUNDOG_RENDER_PT_sampling_advanced(_Closed, Panel):
    bl_label = "Advanced"
    bl_context = "render"
    bl_parent_id = "SUNDOG_RENDER_PT_sampling"

    def show(self, layout, context):
        settings = context.scene.sundog
        row = layout.row(align=True)
        row.prop(settings, "seed")
        row.prop(settings, "use_animated_seed", text="", icon="TIME")
        layout.prop(settings, "sequences")


class SUNDOG_RENDER_PT_light_paths(_Closed, Panel):
    bl_label = "Light Paths"
    bl_context = "render"

    def show(self, layout, context):
        settings = context.scene.sundog
        column = layout.column(align=True, heading="Max Bounces")
        column.prop(settings, "max_bounces")
        column.prop(settings, "diffuse_bounces")
        column.prop(settings, "glossy_bounces")
        column.prop(settings, "transmission_bounces")
        column.prop(settings, "volume_bounces")
        layout.prop(settings, "transparent_max_bounces")
        layout.prop(settings, "min_light_bounces")
        column = layout.column(align=True, heading="Clamping")
        column.prop(settings, "sample_clamp_direct")
        column.prop(settings, "sample_clamp_indirect")
        layout.prop(settings, "blur_glossy")
        column = layout.column(align=True, heading="Caustics")
        column.prop(settings, "caustics_reflective", text="Reflective")
        column.prop(settings, "caustics_refractive", text="Refractive")


class SUNDOG_RENDER_PT_fast_gi(_Closed, Panel):
    bl_label = "Fast GI Approximation"
    bl_context = "render"
    bl_parent_id = "SUNDOG_RENDER_PT_light_paths"

    @classmethod
    def applies(cls, context):
        """They are Cycles' own settings."""
        return hasattr(context.scene, "cycles")

    def draw_header(self, context):
        self.layout.prop(context.scene.cycles, "use_fast_gi", text="")

    def show(self, layout, context):
        cycles, world = context.scene.cycles, context.scene.world
        layout.active = cycles.use_fast_gi
        layout.prop(cycles, "fast_gi_method", text="Method")
        if world is not None:
            layout.prop(world.light_settings, "ao_factor", text="AO Factor")
            layout.prop(world.light_settings, "distance", text="AO Distance")
        if cycles.fast_gi_method == "REPLACE":
            layout.prop(cycles, "ao_bounces_render", text="Render Bounces")


class SUNDOG_RENDER_PT_curves(_Closed, Panel):
    bl_label = "Curves"
    bl_context = "render"

    @classmethod
    def applies(cls, context):
        """They are Cycles' own settings."""
        return hasattr(context.scene, "cycles_curves")

    def show(self, layout, context):
        curves = context.scene.cycles_curves
        layout.prop(curves, "shape")
        if curves.shape == "RIBBONS":
            layout.prop(curves, "subdivisions")


class SUNDOG_RENDER_PT_simplify(_Closed, Panel):
    bl_label = "Simplify"
    bl_context = "render"

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_simplify", text="")

    def show(self, layout, context):
        render = context.scene.render
        layout.active = render.use_simplify
        column = layout.column(heading="Render")
        column.prop(render, "simplify_subdivision_render", text="Max Subdivision")
        column.prop(render, "simplify_child_particles_render", text="Child Particles")
        cycles = getattr(context.scene, "cycles", None)
        if cycles is not None:
            prop(column, cycles, "texture_resolution_render", text="Texture Resolution")
            prop(column, cycles, "texture_limit_render", text="Texture Size Limit")
        column = layout.column(heading="Viewport")
        column.prop(render, "simplify_subdivision", text="Max Subdivision")
        column.prop(render, "simplify_child_particles", text="Child Particles")
        prop(column, render, "simplify_volumes", text="Volume Resolution")
        prop(column, render, "use_simplify_normals", text="Normals")


class SUNDOG_RENDER_PT_film(_Closed, Panel):
    bl_label = "Film"
    bl_context = "render"

    def show(self, layout, context):
        settings = context.scene.sundog
        layout.prop(settings, "film_exposure")
        layout.prop(context.scene.render, "film_transparent")
        if context.scene.render.film_transparent:
            layout.prop(settings, "film_transparent_glass")
            if settings.film_transparent_glass:
                layout.prop(settings, "film_transparent_roughness")
        layout.prop(settings, "pixel_filter_type")
        if settings.pixel_filter_type != "BOX":
            layout.prop(settings, "filter_width")


class SUNDOG_RENDER_PT_performance(_Closed, Panel):
    bl_label = "Performance"
    bl_context = "render"

    def show(self, layout, context):
        render = context.scene.render
        layout.prop(render, "threads_mode")
        column = layout.column()
        column.enabled = render.threads_mode == "FIXED"
        column.prop(render, "threads")
        self.layout.prop(context.scene.sundog, "exchange")


# View layer


class SUNDOG_VIEW_LAYER_PT_passes(_Buttons, Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def show(self, layout, context):
        layer = context.view_layer
        column = layout.column(heading="Data")
        for name in ("use_pass_z", "use_pass_position", "use_pass_normal", "use_pass_uv"):
            column.prop(layer, name)
        column.prop(layer.sundog, "use_pass_albedo")
        column.prop(layer.sundog, "use_pass_denoising_normal")
        column.prop(layer.sundog, "use_pass_sample_count")
        if hasattr(layer, "cycles"):
            prop(column, layer.cycles, "pass_render_time")
        column.prop(layer.sundog, "use_centre_passes")
        if hasattr(layer, "cycles"):
            column.prop(layer.cycles, "use_pass_shadow_catcher")
        for kind in ("diffuse", "glossy", "transmission"):
            column = layout.column(heading=kind.capitalize(), align=True)
            for part in ("direct", "indirect", "color"):
                column.prop(layer, f"use_pass_{kind}_{part}", text=part.capitalize())
        column = layout.column(heading="Other")
        column.prop(layer, "use_pass_emit", text="Emission")
        column.prop(layer, "use_pass_environment", text="Environment")


class SUNDOG_VIEW_LAYER_PT_filter(_Closed, Panel):
    bl_label = "Filter"
    bl_context = "view_layer"

    def show(self, layout, context):
        layer = context.view_layer
        column = layout.column(heading="Include")
        column.prop(layer, "use_sky", text="Environment")
        column.prop(layer, "use_solid", text="Surfaces")
        column.prop(layer, "use_strand", text="Curves")
        column.prop(layer, "use_volumes", text="Volumes")
        prop(column, layer, "use_grease_pencil", text="Grease Pencil")


class SUNDOG_VIEW_LAYER_PT_override(_Closed, Panel):
    bl_label = "Override"
    bl_context = "view_layer"

    def show(self, layout, context):
        layer = context.view_layer
        layout.prop(layer, "material_override")
        prop(layout, layer, "world_override")
        layout.prop(layer, "samples")
        if hasattr(context.scene, "cycles"):
            prop(layout, context.scene.cycles, "use_layer_samples")


# Light


class SUNDOG_LIGHT_PT_light(_Buttons, Panel):
    bl_label = "Light"
    bl_context = "data"

    @classmethod
    def applies(cls, context):
        return context.light is not None

    def show(self, layout, context):
        light = context.light
        layout.row().prop(light, "type", expand=True)
        layout.use_property_decorate = True
        column = layout.column()
        prop(column, light, "use_temperature")
        if getattr(light, "use_temperature", False):
            column.prop(light, "temperature")
        column.prop(light, "color")
        column.prop(light, "energy")
        prop(column, light, "exposure")
        prop(column, light, "normalize")
        column = layout.column()
        if light.type in {"POINT", "SPOT"}:
            column.prop(light, "shadow_soft_size", text="Radius")
            prop(column, light, "use_soft_falloff")
        elif light.type == "SUN":
            column.prop(light, "angle")
        elif light.type == "AREA":
            column.prop(light, "shape")
            if light.shape in {"SQUARE", "DISK"}:
                column.prop(light, "size")
            else:
                column.prop(light, "size", text="Size X")
                column.prop(light, "size_y", text="Y")


class SUNDOG_LIGHT_PT_settings(_Buttons, Panel):
    bl_label = "Settings"
    bl_context = "data"

    @classmethod
    def applies(cls, context):
        return context.light is not None

    def show(self, layout, context):
        light = context.light
        cycles = getattr(light, "cycles", None)
        prop(layout, light, "use_shadow", text="Cast Shadow")
        if cycles is not None:
            prop(layout, cycles, "max_bounces")
            if light.type == "AREA":
                prop(layout, cycles, "is_portal", text="Portal")


class SUNDOG_LIGHT_PT_beam_shape(_Buttons, Panel):
    bl_label = "Beam Shape"
    bl_context = "data"

    @classmethod
    def applies(cls, context):
        return context.light is not None and context.light.type in {"SPOT", "AREA"}

    def show(self, layout, context):
        light = context.light
        if light.type == "SPOT":
            layout.prop(light, "spot_size", text="Spot Size")
            layout.prop(light, "spot_blend", text="Blend", slider=True)
            layout.prop(light, "show_cone")
        else:
            layout.prop(light, "spread")


class SUNDOG_LIGHT_PT_nodes(_Closed, Panel):
    bl_label = "Nodes"
    bl_context = "data"

    @classmethod
    def applies(cls, context):
        return context.light is not None and context.light.node_tree is not None

    def show(self, layout, context):
        _nodes(layout, context.light, "Surface")


# World, material, object, camera


def _nodes(layout, data, name):
    """The shader at an input of the output that Cycles, and so Sundog, renders."""
    from bpy_extras.node_utils import find_node_input

    output = data.node_tree and data.node_tree.get_output_node("CYCLES")
    entry = output and find_node_input(output, name)
    if entry:
        layout.template_node_view(data.node_tree, output, entry)
    else:
        layout.label(text="No output node")


class SUNDOG_WORLD_PT_surface(_Buttons, Panel):
    bl_label = "Surface"
    bl_context = "world"

    @classmethod
    def applies(cls, context):
        return context.world is not None

    def show(self, layout, context):
        world = context.world
        if world.node_tree is None:
            layout.prop(world, "color")
        else:
            _nodes(layout, world, "Surface")


class SUNDOG_WORLD_PT_volume(_Closed, Panel):
    bl_label = "Volume"
    bl_context = "world"

    @classmethod
    def applies(cls, context):
        return context.world is not None and context.world.node_tree is not None

    def show(self, layout, context):
        _nodes(layout, context.world, "Volume")


class SUNDOG_WORLD_PT_ray_visibility(_Closed, Panel):
    bl_label = "Ray Visibility"
    bl_context = "world"

    @classmethod
    def applies(cls, context):
        return hasattr(context.world, "cycles_visibility")

    def show(self, layout, context):
        column = layout.column(align=True)
        for name in ("camera", "diffuse", "glossy", "transmission"):
            prop(column, context.world.cycles_visibility, name)


class _Material(_Buttons):
    bl_context = "material"

    @classmethod
    def applies(cls, context):
        material = context.material
        return material is not None and not material.grease_pencil and material.node_tree is not None


class SUNDOG_MATERIAL_PT_surface(_Material, Panel):
    bl_label = "Surface"

    def show(self, layout, context):
        _nodes(layout, context.material, "Surface")


class SUNDOG_MATERIAL_PT_volume(_Material, Panel):
    bl_label = "Volume"
    bl_options = {"DEFAULT_CLOSED"}

    def show(self, layout, context):
        _nodes(layout, context.material, "Volume")


class SUNDOG_MATERIAL_PT_displacement(_Material, Panel):
    bl_label = "Displacement"
    bl_options = {"DEFAULT_CLOSED"}

    def show(self, layout, context):
        _nodes(layout, context.material, "Displacement")


class SUNDOG_MATERIAL_PT_settings(_Material, Panel):
    bl_label = "Settings"
    bl_options = {"DEFAULT_CLOSED"}

    def show(self, layout, context):
        settings = context.material.sundog
        prop(layout, settings, "use_priority")
        column = layout.column()
        column.active = settings.use_priority
        prop(column, settings, "priority")


class SUNDOG_OBJECT_PT_ray_visibility(_Closed, Panel):
    bl_label = "Ray Visibility"
    bl_context = "object"
    bl_parent_id = "OBJECT_PT_visibility"

    @classmethod
    def applies(cls, context):
        return context.object is not None and context.object.type in {
            "MESH", "CURVE", "SURFACE", "FONT", "META", "LIGHT",
        }  # fmt: skip

    def show(self, layout, context):
        shown = context.object
        column = layout.column(align=True)
        for name in ("camera", "diffuse", "glossy", "transmission", "shadow"):
            if name != "shadow" or shown.type != "LIGHT":
                prop(column, shown, f"visible_{name}", text=name.capitalize())
        if shown.type != "LIGHT":
            column = layout.column(align=True)
            prop(column, shown, "is_holdout")


class SUNDOG_CAMERA_PT_panorama(_Buttons, Panel):
    bl_label = "Panorama"
    bl_context = "data"

    @classmethod
    def applies(cls, context):
        return context.camera is not None and context.camera.type == "PANO"

    def show(self, layout, context):
        camera = context.camera
        settings = camera if hasattr(camera, "panorama_type") else getattr(camera, "cycles", None)
        if settings is None:
            return
        layout.prop(settings, "panorama_type")
        if settings.panorama_type == "EQUIRECTANGULAR":
            for axis in ("latitude", "longitude"):
                column = layout.column(align=True)
                column.prop(settings, f"{axis}_min", text=f"{axis.capitalize()} Min")
                column.prop(settings, f"{axis}_max", text="Max")
        else:
            layout.label(text="Rendered as a perspective camera", icon="ERROR")


_CLASSES = (
    SUNDOG_RENDER_PT_sampling,
    SUNDOG_RENDER_PT_denoising,
    SUNDOG_RENDER_PT_sampling_advanced,
    SUNDOG_RENDER_PT_light_paths,
    SUNDOG_RENDER_PT_fast_gi,
    SUNDOG_RENDER_PT_curves,
    SUNDOG_RENDER_PT_simplify,
    SUNDOG_RENDER_PT_film,
    SUNDOG_RENDER_PT_performance,
    SUNDOG_RENDER_PT_scene_check,
    SUNDOG_VIEW_LAYER_PT_passes,
    SUNDOG_VIEW_LAYER_PT_filter,
    SUNDOG_VIEW_LAYER_PT_override,
    SUNDOG_LIGHT_PT_light,
    SUNDOG_LIGHT_PT_beam_shape,
    SUNDOG_LIGHT_PT_settings,
    SUNDOG_LIGHT_PT_nodes,
    SUNDOG_WORLD_PT_surface,
    SUNDOG_WORLD_PT_volume,
    SUNDOG_WORLD_PT_ray_visibility,
    SUNDOG_MATERIAL_PT_surface,
    SUNDOG_MATERIAL_PT_volume,
    SUNDOG_MATERIAL_PT_displacement,
    SUNDOG_MATERIAL_PT_settings,
    SUNDOG_OBJECT_PT_ray_visibility,
    SUNDOG_CAMERA_PT_panorama,
)


def _saying(text):
    """Draws a line, for this engine alone: the panel is everybody's."""

    def says(self, context):
        if context.engine == ENGINE:
            self.layout.label(text=text, icon="INFO")

    return says


def register():
    """Adds the panels, and Sundog to Blender's."""
    for panel in blenders_panels():
        # Blender's sets belong to one class each, but some are shared by inheritance.
        if ENGINE not in panel.COMPAT_ENGINES:
            panel.COMPAT_ENGINES.add(ENGINE)
            _adopted.append(panel)
        if panel.__name__ in NOT_RENDERED:
            says = _saying(NOT_RENDERED[panel.__name__])
            panel.prepend(says)
            _says.append((panel, says))
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    """Takes them away, and Sundog out of Blender's."""
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    while _says:
        panel, says = _says.pop()
        panel.remove(says)
    while _adopted:
        _adopted.pop().COMPAT_ENGINES.discard(ENGINE)
