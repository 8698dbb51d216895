# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles' fast GI approximation, which stands for indirect light."""


def world_of(scene, view_layer):
    """The world of a view layer: its own, or the scene's. `None` if there is none."""
    return getattr(view_layer, "world_override", None) or scene.world


def of_scene(scene, world):
    """SUNDOG_scene's `fast_gi`; `None` where Cycles traces all bounces. `world`: the view layer's, seen or not."""
    cycles = getattr(scene, "cycles", None)
    if world is None or not getattr(cycles, "use_fast_gi", False):
        return None
    light = world.light_settings
    found = {"factor": float(light.ao_factor), "distance": float(light.distance)}
    if cycles.fast_gi_method == "ADD":
        return {"method": "add", **found} if light.ao_factor > 0 else None
    bounces = cycles.ao_bounces_render
    # As in Cycles, either of both is off at 0.
    return {"method": "replace", "bounces": bounces, **found} if bounces and light.ao_factor > 0 else None


def distance_of(objects):
    """How far what stands for indirect light sees from an object (the first) that others show; 0 for as far as from elsewhere."""
    own = (getattr(getattr(o, "cycles", None), "ao_distance", 0.0) for o in objects if o is not None)
    return next((float(distance) for distance in own if distance), 0.0)
