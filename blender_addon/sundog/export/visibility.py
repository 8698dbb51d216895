# SPDX-License-Identifier: GPL-3.0-or-later
"""Which rays see an object."""

NAMES = {
    "camera": "visible_camera",
    "diffuse": "visible_diffuse",
    "glossy": "visible_glossy",
    "transmission": "visible_transmission",
    "volume": "visible_volume_scatter",
    "shadow": "visible_shadow",
}


def of_objects(objects):
    """The kinds of rays that do not see what all these objects (an instance, its instancer) show."""
    return {
        kind: False
        for kind, attribute in NAMES.items()
        if not all(getattr(o, attribute, True) for o in objects if o is not None)
    }


def shower(objects):
    """Who says whether an object (the first) is held out or indirect only: as in Cycles the one that shows it, if it is an instance."""
    return next(o for o in reversed(objects) if o is not None)


def sundog_object(objects, view_layer):
    """The SUNDOG_object of an object placed by others (the object first), or None if it says nothing."""
    result = {}
    seen = of_objects(objects)
    shows = shower(objects)
    if shows.original.indirect_only_get(view_layer=view_layer):
        seen["camera"] = False
    if seen:
        result["visibility"] = seen
    if shows.is_holdout or shows.original.holdout_get(view_layer=view_layer):
        result["holdout"] = True
    if any(o is not None and o.is_shadow_catcher for o in objects):
        result["shadow_catcher"] = True
    return result or None
