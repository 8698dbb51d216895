# SPDX-License-Identifier: GPL-3.0-or-later
"""Which effects the scene calls for, and what calls for them: as the program found in the last render or scene check."""

import bpy

from . import records
from .scene_check import RenderPanel, SUNDOG_OT_select_users, lines, width_of

# Kinds of causes that Blender can select.
SELECTABLE = {"object", "material", "light", "camera"}
_ICONS = {"needed": "CHECKMARK", "lacking": "ERROR"}


def called_for(findings):
    """Those that the scene calls for, first the ones that the program lacks."""
    return sorted((f for f in findings if f["state"] in _ICONS), key=lambda f: f["state"] != "lacking")


def not_needed(findings):
    """Reasons why effects are left out, with the effects: each reason once, in order."""
    reasons = {}
    for finding in findings:
        if finding["state"] == "left-out":
            for reason in finding["reasons"]:
                reasons.setdefault(reason, []).append(finding["effect"])
    return [(reason, names) for reason, names in reasons.items()]


def words(finding):
    """`alpha-clip: Leaf, Leaf.001 and 3 more`."""
    names = [cause["name"] for cause in finding["because_of"]]
    more = max(finding["count"] - len(names), 0)
    return f"{finding['effect']}: {records.listed(names, 5, more)}"


def selections(finding):
    """What can be selected of those that call for an effect: (kind, names), a kind each."""
    kinds = {}
    for cause in finding["because_of"]:
        if cause["kind"] in SELECTABLE:
            kinds.setdefault(cause["kind"], []).append(cause["name"])
    return list(kinds.items())


class SUNDOG_RENDER_PT_effects(RenderPanel, bpy.types.Panel):
    """What the scene calls for, each with a button that selects what calls for it."""

    bl_label = "Effects"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        """A line for each effect."""
        findings = records.findings()
        if not findings:
            self.layout.label(text="Nothing rendered or checked yet")
            return
        width = width_of(context)
        for finding in called_for(findings):
            row = self.layout.row()
            lines(row.column(align=True), words(finding), _ICONS[finding["state"]], width - 4)
            for kind, names in selections(finding):
                button = row.operator(SUNDOG_OT_select_users.bl_idname, text="", icon="RESTRICT_SELECT_OFF")
                button.kind, button.names = kind, "\n".join(names)


class SUNDOG_RENDER_PT_effects_left_out(RenderPanel, bpy.types.Panel):
    """What the scene does without, and why."""

    bl_label = "Not Needed"
    bl_parent_id = "SUNDOG_RENDER_PT_effects"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        """A line for each reason."""
        width = width_of(context)
        for reason, names in not_needed(records.findings()):
            lines(self.layout, f"{', '.join(names)}: {reason}", "BLANK1", width)


_CLASSES = (SUNDOG_RENDER_PT_effects, SUNDOG_RENDER_PT_effects_left_out)

register, unregister = bpy.utils.register_classes_factory(_CLASSES)
