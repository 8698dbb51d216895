# SPDX-License-Identifier: GPL-3.0-or-later
"""Sundog's extensions in File > Export > glTF 2.0: called by Blender's own exporter, whose files they are added to.

The exporter looks for `glTF2ExportUserExtension` and `draw_export` in the add-on's top module.
"""

import os
import shutil
import tempfile
from urllib.parse import quote

import bpy
import numpy

from . import camera as cameras
from . import colorspace, fast_gi, images, lights, nodes, shaders, visibility
from . import scene as scenes
from . import world as worlds
from .verdicts import LOST


class SundogExportSettings(bpy.types.PropertyGroup):
    """The switch in the export panel."""

    enabled: bpy.props.BoolProperty(
        name="Sundog",
        description="Add what glTF has no word for: area lights, sizes of lights, ray visibility, camera, world, colours",
        default=True,
    )


def draw_export(context, layout):
    """The panel in the export dialogue."""
    header, body = layout.panel("SUNDOG_gltf_export", default_closed=True)
    settings = context.window_manager.sundog_gltf_export
    header.use_property_split = False
    header.prop(settings, "enabled")
    if body is not None:
        body.active = settings.enabled
        body.label(text="Area lights, sizes of lights, visibility,")
        body.label(text="camera, world and colours for Sundog")


class glTF2ExportUserExtension:
    """What the exporter calls, for one export. It reports errors of the hooks and goes on without."""

    def __init__(self):
        from io_scene_gltf2.io.com.gltf2_io_extensions import Extension

        self._wrap = Extension
        self._enabled = bpy.context.window_manager.sundog_gltf_export.enabled

    def _extension(self, name, content):
        return self._wrap(name=name, extension=content, required=False)

    def _add(self, item, name, content):
        if item.extensions is None:
            item.extensions = {}
        item.extensions[name] = self._extension(name, content)

    def _evaluated(self, data):
        """As the exporter sees it: with the animation of the frame."""
        return data.evaluated_get(bpy.context.evaluated_depsgraph_get())

    def gather_node_hook(self, node, blender_object, export_settings):
        """A node of an object: visibility of meshes, lights."""
        if not self._enabled or not isinstance(blender_object, bpy.types.Object):
            return
        if blender_object.type == "LIGHT":
            if export_settings["gltf_lights"]:
                self._light(node, blender_object, export_settings)
        elif node.mesh is not None:
            content = visibility.sundog_object([blender_object], bpy.context.view_layer)
            if content:
                self._add(node, "SUNDOG_object", content)

    def _light(self, node, shown, export_settings):
        findings = []
        light = self._evaluated(shown.data)
        if lights.is_portal(light):
            # The exporter turns the nodes of all lights to glTF's -Z.
            self._add(node, "SUNDOG_light", lights.describe_portal(light, shown.name))
            return
        content = lights.describe(light, findings)
        seen = lights.ray_visibility(light, [shown])
        if shown.indirect_only_get(view_layer=bpy.context.view_layer):
            seen["camera"] = False
        if seen:
            content["visibility"] = seen
        self._tell(export_settings, f"light \"{shown.name}\"", findings)
        if content.get("type") == "area":
            # The exporter turns the nodes of all lights to glTF's -Z, those of kinds that it leaves out as well.
            content["name"] = shown.name
            self._add(node, "SUNDOG_light", content)
            return
        punctual = (node.extensions or {}).get("KHR_lights_punctual")
        if punctual is None:
            return
        held = punctual.extension["light"]
        # Objects that share a lamp share this dictionary, but not their visibility.
        held.extension = {**held.extension, "extensions": {"SUNDOG_light": self._extension("SUNDOG_light", content)}}

    def gather_camera_hook(self, camera, blender_camera, export_settings):
        """A camera: window, lens, clip planes, panorama."""
        if not self._enabled:
            return
        scene = bpy.context.scene
        users = [o for o in (scene.camera, *scene.objects) if o is not None and o.data == blender_camera]
        if not users:
            return
        findings = []
        shown = self._evaluated(users[0])
        content, _ = cameras.describe(shown.data, cameras.without_scale(shown.matrix_world), scene.render, findings, self._evaluated)
        self._tell(export_settings, f"camera \"{blender_camera.name}\"", findings)
        self._add(camera, "SUNDOG_camera", content)

    def gather_material_hook(self, gltf_material, blender_material, export_settings):
        """A material: what the exporter's own extensions do not say."""
        if not self._enabled or blender_material is None:
            return
        nodes.SceneWide.of(bpy.context.scene)
        reader = shaders.Reader(nodes.Walker())
        content = {"thin_walled": False}
        try:
            surface = reader.read(self._evaluated(blender_material))
            content.update(surface.others)
        except (images.ImageError, RecursionError, KeyError, AttributeError, ValueError) as error:
            self._tell(export_settings, f"material \"{blender_material.name}\"", [(LOST, str(error))])
        self._add(gltf_material, "SUNDOG_material", content)

    def gather_scene_hook(self, gltf_scene, blender_scene, export_settings):
        """A scene: world, colours, size of the picture."""
        if not self._enabled:
            return
        findings = []
        world = blender_scene.world
        beside = _Beside(export_settings)
        with tempfile.TemporaryDirectory(prefix="sundog-export-") as cache:
            try:
                described = worlds.describe(world and self._evaluated(world), cache, beside, findings, as_tree=False)
            except (images.ImageError, RecursionError) as error:
                findings.append((LOST, str(error)))
                described = {"color": [0.0, 0.0, 0.0]}
        if not export_settings["gltf_yup"]:
            _without_turn(described)
        self._tell(export_settings, "world", findings)
        content = {
            "world": described,
            "color_management": scenes.color_management(blender_scene),
            "render": scenes.render_settings(blender_scene),
        }
        for name, value in (("fast_gi", fast_gi.of_scene(blender_scene, world)), ("texture_limit", scenes.texture_limit(blender_scene))):
            if value:
                content[name] = value
        if colorspace.working_space() != colorspace.REC709:
            # The exporter writes numbers as they stand.
            content["working_space"] = colorspace.working_space()
        if colorspace.unknown():
            words = f"its working space \"{colorspace.unknown()}\" is not known: its colours are taken as {colorspace.REC709}"
            self._tell(export_settings, "scene", [(LOST, words)])
        self._add(gltf_scene, "SUNDOG_scene", content)

    def _tell(self, export_settings, what, findings):
        log = export_settings.get("log")
        for verdict, detail, *_ in findings:
            sentence = f"Sundog, {what}: {verdict}: {detail}"
            if log is not None:
                log.warning(sentence)
            else:
                print(sentence)


class _Beside:
    """The document as far as a world needs it: its pictures lie beside the file that is being written."""

    def __init__(self, export_settings):
        self._folder = export_settings["gltf_filedirectory"]
        self._stem = os.path.splitext(os.path.basename(export_settings["gltf_filepath"]))[0]
        os.makedirs(self._folder, exist_ok=True)

    def uri(self, path):
        """The picture's name in the file."""
        name = f"{self._stem}-world{os.path.splitext(path)[1]}"
        target = os.path.join(self._folder, name)
        if not (os.path.exists(target) and os.path.samefile(path, target)):
            shutil.copyfile(path, target)
        return quote(name)


def _without_turn(world):
    """Corrects the rotation for a file without "+Y Up".

    Readers take the file's axes (x, y, z) for Blender's (x, -z, y); here they are Blender's as they stand.
    """
    if "sun" in world:
        toward = scenes.TO_GLTF[:3, :3].T @ numpy.array(world["sun"]["direction"])
        world["sun"] = {**world["sun"], "direction": [float(v) for v in toward]}
    if "image" not in world:
        return
    rotation = numpy.array(world.get("rotation", numpy.eye(3))).reshape(3, 3) @ scenes.TO_GLTF[:3, :3]
    world["rotation"] = [float(v) for v in rotation.reshape(-1)]


def register():
    """Adds the export dialogue's panel."""
    bpy.utils.register_class(SundogExportSettings)
    bpy.types.WindowManager.sundog_gltf_export = bpy.props.PointerProperty(type=SundogExportSettings)
    layouts = _layouts()
    if layouts is not None:
        layouts[_ADDON] = draw_export


def unregister():
    """Takes it away."""
    layouts = _layouts()
    if layouts is not None:
        layouts.pop(_ADDON, None)
    del bpy.types.WindowManager.sundog_gltf_export
    bpy.utils.unregister_class(SundogExportSettings)


# The add-on's own name, under which Blender 4.2's exporter enters the panel itself.
_ADDON = __package__.rpartition(".")[0]


def _layouts():
    try:
        import io_scene_gltf2
    except ImportError:
        return None
    return io_scene_gltf2.exporter_extension_layout_draw
