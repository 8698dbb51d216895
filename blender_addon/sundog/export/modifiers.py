# SPDX-License-Identifier: GPL-3.0-or-later
"""What modifiers do that no two pictures share. All else is in the evaluated mesh."""

from .verdicts import APPROXIMATED


def findings(shown):
    """Findings of an evaluated object's modifiers."""
    found = []
    for modifier in shown.modifiers:
        texture = getattr(modifier, "texture", None) or getattr(modifier, "mask_texture", None)
        # One that is switched off has no part in the picture.
        if texture is not None and modifier.show_render and _is_random(texture):
            words = f'its modifier "{modifier.name}" asks a Noise texture, which Blender draws anew at each evaluation: no two pictures have the same shape'
            found.append((APPROXIMATED, words))
    return found


def _is_random(texture):
    """Whether a texture is drawn anew wherever it is asked: Clouds and all others are the same each time."""
    tree = texture.node_tree if texture.use_nodes else None
    if tree is not None:
        return any(node.bl_idname == "TextureNodeTexNoise" for node in tree.nodes)
    return texture.type == "NOISE"
