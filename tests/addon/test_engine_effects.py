# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel of effects: what the scene calls for, and the button that selects what calls for it."""

import types
import unittest
import unittest.mock

import bpy

from engine_kit import EngineTest, engine, quiet
from sundog import effects, records


def found(name):
    """What the program found of an effect."""
    return next(f for f in records.findings() if f["effect"] == name)


class Lines:
    """Stands for a layout: keeps the texts and the buttons."""

    def __init__(self):
        self.texts, self.buttons = [], []

    def row(self, **_):
        """Itself, as all that is in it is told in order."""
        return self

    column = row

    def label(self, text="", **_):
        """A line."""
        self.texts.append(text)

    def operator(self, name, **_):
        """A button."""
        self.buttons.append(types.SimpleNamespace(name=name))
        return self.buttons[-1]


def drawn(panel):
    """What a panel shows."""
    layout = Lines()
    context = types.SimpleNamespace(region=types.SimpleNamespace(width=2000), preferences=bpy.context.preferences)
    panel.draw(types.SimpleNamespace(layout=layout), context)
    return layout


class Effects(EngineTest):
    """After a scene check and after a render."""

    def glass(self):
        """A material that lets light through, on the cube."""
        material = bpy.data.objects["Cube"].active_material
        material.node_tree.nodes["Principled BSDF"].inputs["Transmission Weight"].default_value = 1
        material.node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.3
        return material

    def test_a_click_selects_the_object_that_calls_for_it(self):
        self.glass()
        with quiet():
            self.assertEqual(bpy.ops.sundog.check_scene(), {"FINISHED"})
        glass = found("rough-glass")
        self.assertEqual(glass["state"], "needed")
        self.assertEqual(glass["because_of"], [{"kind": "material", "name": "Material", "object": "Cube"}])
        shown = drawn(effects.SUNDOG_RENDER_PT_effects)
        line = shown.texts.index("rough-glass: Material")
        self.assertGreaterEqual(line, 0)
        button = next(b for b in shown.buttons if (b.kind, b.names) == ("material", "Material"))
        bpy.ops.object.select_all(action="DESELECT")
        with quiet():
            self.assertEqual(bpy.ops.sundog.select_users(kind=button.kind, names=button.names), {"FINISHED"})
        self.assertEqual([o.name for o in bpy.context.selected_objects], ["Cube"])
        # Lights and objects likewise.
        for name, kind, names in (("point-lights", "light", "Light"), ("smooth-normals", "object", "Ball")):
            if name == "smooth-normals":
                bpy.ops.mesh.primitive_uv_sphere_add()
                bpy.context.object.name = "Ball"
                bpy.ops.object.shade_smooth()
                with quiet():
                    bpy.ops.sundog.check_scene()
            self.assertIn((kind, [names]), effects.selections(found(name)))
            with quiet():
                self.assertEqual(bpy.ops.sundog.select_users(kind=kind, names=names), {"FINISHED"})
            self.assertEqual([o.name for o in bpy.context.selected_objects], [names])

    def test_what_is_left_out_has_its_reason(self):
        with quiet():
            bpy.ops.sundog.check_scene()
        self.assertEqual(found("coat")["state"], "left-out")
        texts = drawn(effects.SUNDOG_RENDER_PT_effects_left_out).texts
        self.assertTrue(any("coat" in text and "weight 0 in" in text for text in texts), texts)

    def test_what_the_program_lacks_comes_first(self):
        material = bpy.data.objects["Cube"].active_material
        material.node_tree.nodes["Principled BSDF"].inputs["Subsurface Weight"].default_value = 1
        with quiet():
            bpy.ops.sundog.check_scene()
        self.assertEqual(found("subsurface")["state"], "needed")
        # As if it did not have that.
        lacking = [{**f, "state": "lacking"} if f["effect"] == "subsurface" else f for f in records.findings()]
        with unittest.mock.patch.object(records, "findings", lambda *_: lacking):
            self.assertEqual(drawn(effects.SUNDOG_RENDER_PT_effects).texts[0], "subsurface: Material")

    def test_after_a_render_the_list_is_the_renders(self):
        self.glass()
        self.assertEqual(records.findings(), engine.last_statistics().get("called_for", []))
        self.render()
        self.assertEqual(found("rough-glass")["state"], "needed")
        self.assertEqual(found("position-passes")["state"], "left-out")
        self.scene.view_layers[0].use_pass_z = True
        self.render()
        self.assertEqual(found("position-passes")["because_of"], [{"kind": "settings", "name": "--passes"}])


if __name__ == "__main__":
    unittest.main()
