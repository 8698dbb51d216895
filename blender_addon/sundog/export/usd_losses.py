# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's USD exporter leaves out of a scene. Measured on files of 4.5.15 and 5.2.3."""

import math

from . import colorspace, fast_gi, lights, nodes, usd_layer, usd_nodes, visibility
from .verdicts import APPROXIMATED, LOST

_KEPT = {"MESH", "CURVE", "SURFACE", "FONT", "META", "CURVES", "POINTCLOUD", "LIGHT", "CAMERA", "VOLUME"}
_NOTHING_TO_SEE = {"EMPTY", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE"}

_LINKING = "light and shadow linking"


def why_no_camera(camera):
    """Why USD has no such camera; None where it has."""
    if camera.type == "CAMERA" and camera.data.type not in {"PERSP", "ORTHO"}:
        return "it is a panorama, or has a lens of its own"
    return None


def tell(depsgraph, layer, verdicts):
    """Names all that the file lacks, by what has it."""
    scene = depsgraph.scene
    _scene(scene, layer, verdicts)
    if layer.material_override is not None:
        verdicts.add("scene", scene.name, LOST, "the view layer's material override is left out")
    _camera(scene.camera, verdicts)
    _world(fast_gi.world_of(scene, layer), scene, layer, verdicts)
    told = set()
    for shown in depsgraph.objects:
        if shown.name_full in told or shown.hide_render:
            continue
        told.add(shown.name_full)
        _object(shown, layer, verdicts)
        for slot in shown.material_slots:
            material = slot.material
            if material is not None and material.name_full not in told:
                told.add(material.name_full)
                verdicts.extend("material", material.name_full, list(_material(material)))
                if shown.type == "VOLUME":
                    verdicts.add("material", material.name_full, LOST, "volumes are filled as without a material: grey, by their density")


def _scene(scene, layer, verdicts):
    if scene.render.use_motion_blur and layer.use_motion_blur:
        verdicts.add("scene", scene.name, LOST, "motion blur is left out")
    if scene.render.use_multiview:
        verdicts.add("scene", scene.name, LOST, "stereo is left out: all views are the scene's camera's")
    if colorspace.working_space() != colorspace.REC709 or colorspace.unknown():
        verdicts.add("scene", scene.name, LOST, "its working space is taken as linear Rec.709")
    if scene.render.pixel_aspect_x != scene.render.pixel_aspect_y:
        verdicts.add("scene", scene.name, LOST, "pixels are square")
    if not layer.use_solid:
        verdicts.add("scene", scene.name, LOST, "the view layer's switch Surfaces is taken as on")
    if fast_gi.of_scene(scene, fast_gi.world_of(scene, layer)):
        verdicts.add("scene", scene.name, LOST, "the fast GI approximation is left out: all bounces are traced")
    if any(group for group in layer.lightgroups):
        verdicts.add("scene", scene.name, LOST, "light groups are left out")


def _camera(camera, verdicts):
    verdicts.add("camera", camera.name)
    if camera.type != "CAMERA":
        return
    dof = camera.data.dof
    if dof.use_dof and camera.data.type == "ORTHO":
        verdicts.add("camera", camera.name, LOST, "its depth of field is left out")
    elif dof.use_dof and (dof.aperture_blades or dof.aperture_ratio != 1):
        verdicts.add("camera", camera.name, APPROXIMATED, "its aperture is a circle")


def _world(world, scene, layer, verdicts):
    if world is None:
        return
    if world != scene.world:
        verdicts.add("world", world.name, LOST, "the view layer's world is left out for the scene's")
        return
    if not layer.use_sky:
        verdicts.add("world", world.name, LOST, "the view layer's switch Environment is taken as on")
    verdicts.add("world", world.name)
    output = nodes.output_of(world)
    if output is None:
        return
    kinds = {node.type for node, _ in _reached(output, "Surface")}
    known = {"BACKGROUND", "TEX_ENVIRONMENT", "TEX_COORD", "MAPPING"}
    others = ", ".join(sorted(kinds - known))
    if others:
        verdicts.add("world", world.name, LOST, f"its nodes ({others}) are left out: Blender writes a colour or one image")
    if "Volume" in output.inputs and output.inputs["Volume"].is_linked:
        verdicts.add("world", world.name, LOST, "its volume is left out")
    if any(not getattr(world.cycles_visibility, kind, True) for kind in ("camera", "diffuse", "glossy", "transmission", "scatter")):
        verdicts.add("world", world.name, LOST, "it is seen by all kinds of rays")
    if usd_layer.shine_of(world)[1] is None and _has_linked_strength(output):
        verdicts.add("world", world.name, LOST, "its strength, which varies, is left out")


def _has_linked_strength(output):
    return any(node.type == "BACKGROUND" and node.inputs["Strength"].is_linked for node, _ in _reached(output, "Surface"))


def _object(shown, layer, verdicts):
    if shown.type in _NOTHING_TO_SEE:
        return
    kind = "light" if shown.type == "LIGHT" else "camera" if shown.type == "CAMERA" else "object"
    if kind == "camera":
        return
    name = shown.name_full
    verdicts.add(kind, name)
    if shown.type not in _KEPT:
        verdicts.add(kind, name, LOST, f"objects of type {shown.type} are left out")
        return
    seen = visibility.of_objects([shown])
    if kind == "light" and not lights.casts_shadow(shown.data):
        seen["shadow"] = False
    # A lamp of USD is not seen by the camera itself.
    if kind == "light" and shown.visible_camera and _is_seen(shown.data):
        verdicts.add(kind, name, LOST, "the camera does not see it")
    seen.pop("camera" if kind == "light" else None, None)
    if seen:
        rays = ", ".join(sorted(seen))
        verdicts.add(kind, name, LOST, f"it is there for all kinds of rays, {rays} too")
    original = shown.original
    if shown.is_holdout or original.holdout_get(view_layer=layer):
        verdicts.add(kind, name, LOST, "it is no holdout")
    # Lamps have the switch, too, where it means another thing and is on.
    if kind == "object" and shown.is_shadow_catcher:
        verdicts.add(kind, name, LOST, "it is no shadow catcher")
    if any(slot.link == "OBJECT" and slot.material is None for slot in original.material_slots):
        verdicts.add(kind, name, LOST, "slots of its own without a material may have the mesh's")
    linking = shown.light_linking
    if linking.receiver_collection is not None or linking.blocker_collection is not None:
        verdicts.add(kind, name, LOST, f"its {_LINKING} is left out")
    if kind == "light":
        verdicts.extend(kind, name, list(_light(shown.data)))


def _is_seen(light):
    """Whether Cycles' camera sees it: lamps with a size."""
    if light.type in {"POINT", "SPOT"}:
        return light.shadow_soft_size > 0
    return light.type == "AREA"


def _light(light):
    if lights.is_portal(light):
        yield LOST, "it shines, which portals do not"
    if light.type in {"POINT", "SPOT"} and getattr(light, "use_soft_falloff", False) and light.shadow_soft_size > 0:
        yield LOST, "its soft falloff is left out"
    if light.type == "AREA":
        if light.shape == "ELLIPSE" and light.size != light.size_y:
            yield LOST, "it is no ellipse"
        if light.spread < math.pi * (1 - 1e-6):
            yield LOST, "it shines with its whole half space"
    output = nodes.output_of(light)
    if output and not _is_plain(output):
        yield LOST, "its nodes are left out: it shines by its own settings"
    most = getattr(getattr(light, "cycles", None), "max_bounces", 1024)
    if most < 1024:
        yield LOST, "its light bounces as often as all light"


def _is_plain(output):
    """Whether a lamp's nodes are those of a new one."""
    links = output.inputs["Surface"].links
    node = links[0].from_node if links else None
    if node is None or node.type != "EMISSION" or any(socket.is_linked for socket in node.inputs):
        return False
    return node.inputs["Strength"].default_value == 1 and all(v == 1 for v in node.inputs["Color"].default_value[:3])


def _material(material):
    output = nodes.output_of(material)
    if not output:
        return
    for socket in ("Volume", "Displacement"):
        if socket in output.inputs and output.inputs[socket].is_linked:
            yield LOST, f"its {socket.lower()} is left out"
    found, shaders = {}, set()
    for node, socket in _reached(output, "Surface"):
        if socket.type == "SHADER" and node.type not in {"BSDF_PRINCIPLED", "GROUP", "GROUP_INPUT", "REROUTE"} | usd_nodes.CONSTANT:
            shaders.add(node.bl_label)
        for verdict, words in usd_nodes.differs(node, socket):
            found[words] = verdict
    if shaders:
        yield LOST, f"its shaders are left out ({', '.join(sorted(shaders))}): a Principled BSDF alone comes through"
    for words, verdict in sorted(found.items()):
        yield verdict, f"its nodes: {words}"


def _reached(node, *names, seen=None):
    """(node, output socket) of all that an input is made of, groups included."""
    seen = set() if seen is None else seen
    sockets = [node.inputs[name] for name in names] if names else list(node.inputs)
    for socket in sockets:
        for link in socket.links:
            source, output = link.from_node, link.from_socket
            key = (source.id_data.name_full, source.name, output.identifier)
            if link.is_muted or key in seen:
                continue
            seen.add(key)
            yield source, output
            inner = getattr(source, "node_tree", None)
            ends = [n for n in inner.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output] if inner else []
            for end in ends:
                yield from _reached(end, seen=seen)
            yield from _reached(source, seen=seen)
