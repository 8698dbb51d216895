# SPDX-License-Identifier: GPL-3.0-or-later
"""The schema of the extensions: it is sound itself, it says no where it should, and it names what the document names."""

import copy
import os
import re
import unittest

import bpy
import export_kit as kit
import schema_check


class Schema(kit.ExportTest):
    """Every export of the other tests is checked by the kit; here is what must not pass."""

    def setUp(self):
        super().setUp()
        self.write_graphs(True)

    def everything(self):
        """A file with every extension in it."""
        for kind in ("POINT", "SPOT", "SUN", "AREA"):
            self.link(kind, bpy.data.lights.new(kind, kind))
        self.link("opening", bpy.data.lights.new("opening", "AREA")).data.cycles.is_portal = True
        made = self.link("cube", kit.cube(), visible_camera=False)
        made.data.materials.append(kit.material("m", Coat_Weight=1.0, Sheen_Weight=1.0, Subsurface_Weight=1.0, Anisotropic=0.5, Thin_Film_Thickness=300))
        self.camera.data.dof.use_dof = True
        tree = made.data.materials[0].node_tree
        leaf = tree.nodes.new("ShaderNodeTexImage")
        leaf.image = bpy.data.images.new("leaf", 2, 2, alpha=True)
        leaf.image.pack()
        for output, name in (("Color", "Base Color"), ("Alpha", "Alpha")):
            tree.links.new(leaf.outputs[output], tree.nodes["Principled BSDF"].inputs[name])
        marbled = self.link("marbled", kit.cube())
        marbled.data.materials.append(kit.material("marble"))
        tree = marbled.data.materials[0].node_tree
        noise, ramp, told = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexNoise", "ValToRGB", "ObjectInfo"))
        tree.links.new(told.outputs["Random"], noise.inputs["Scale"])
        tree.links.new(noise.outputs[0], ramp.inputs[0])
        tree.links.new(ramp.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
        smoke = tree.nodes.new("ShaderNodeVolumePrincipled")
        tree.links.new(noise.outputs[0], smoke.inputs["Density"])
        tree.links.new(smoke.outputs[0], tree.get_output_node("CYCLES").inputs["Volume"])
        return self.export().root

    def test_every_extension_is_in_the_file_and_valid(self):
        root = self.everything()
        used = {name for name in root["extensionsUsed"] if name.startswith("SUNDOG_")}
        known = {re.sub("_(punctual|area|portal)$", "", name) for name in schema_check.schema()["$defs"] if name.startswith("SUNDOG_")}
        self.assertEqual(used, known)
        self.assertEqual(list(schema_check.errors(root, schema_check.schema())), [])
        told = [m["extensions"]["SUNDOG_material"].get("volume", {}).get("graph") for m in root["materials"]]
        self.assertEqual([graph is not None for graph in told].count(True), 1)

    def test_mistakes_are_found(self):
        root = self.everything()
        rule = schema_check.schema()

        def wrong(change):
            broken = copy.deepcopy(root)
            change(broken)
            return list(schema_check.errors(broken, rule))

        def camera(document):
            return document["cameras"][0]["extensions"]["SUNDOG_camera"]

        def lamp(document):
            return document["extensions"]["KHR_lights_punctual"]["lights"][0]["extensions"]["SUNDOG_light"]

        def drawn(document):
            return next(m for m in document["materials"] if m["name"] == "marble")["extensions"]["SUNDOG_shader_graph"]

        def ramp(document):
            return next(n for n in drawn(document)["nodes"] if "color_ramp" in n.get("properties", {}))["properties"]["color_ramp"]

        def boxed(document):
            return next(p for m in document["meshes"] for p in m["primitives"] if "extensions" in p)["extensions"]["SUNDOG_mesh"]

        changes = [
            lambda d: drawn(d).pop("blender"),
            lambda d: drawn(d)["nodes"][-1].pop("type"),
            lambda d: drawn(d)["nodes"][-1]["inputs"].update({"Base Color": [1, 2]}),
            lambda d: drawn(d)["nodes"][-1]["inputs"].update({"Base Color": "red"}),
            lambda d: drawn(d)["nodes"][-1]["inputs"].update({"Base Color": {"node": 0, "socket": "Color"}}),
            lambda d: ramp(d)["table"][3].pop(),
            lambda d: ramp(d).update(interpolation="CUBIC"),
            lambda d: boxed(d)["texture_space"]["size"].pop(),
            lambda d: next(n for n in d["nodes"] if n["name"] == "marbled")["extensions"]["SUNDOG_object"].update(random=2),
            lambda d: camera(d).update(window=[0, 1, 2]),
            lambda d: camera(d).update(widnow=[0, 1, 2, 3]),
            lambda d: camera(d)["aperture"].pop("radius"),
            lambda d: camera(d)["aperture"].update(ratio=0),
            lambda d: lamp(d).update(radius=-1),
            lambda d: lamp(d).update(max_bounces=1.5),
            lambda d: lamp(d).update(soft_falloff=1),
            lambda d: d["scenes"][0]["extensions"]["SUNDOG_scene"]["world"].update(color="black"),
            lambda d: d["samplers"][0]["extensions"]["SUNDOG_sampler"].update(weighted_by_alpha=1),
            lambda d: d["materials"][0]["extensions"]["SUNDOG_material"].update(coat=1),
            lambda d: next(n for n in d["nodes"] if "SUNDOG_light" in n.get("extensions", {}))["extensions"]["SUNDOG_light"].update(type="round"),
        ]
        for number, change in enumerate(changes):
            with self.subTest(number=number):
                self.assertEqual(len(wrong(change)), 1, wrong(change))

    def test_the_document_names_every_property(self):
        with open(os.path.join(kit.PROJECT, "docs", "gltf-extensions.md"), encoding="utf-8") as file:
            text = file.read()
        ours = text[text.index("## Sundog's extensions") : text.index("## Units of light")]

        def names(rule):
            for name, inner in rule.get("properties", {}).items():
                yield name
                yield from names(inner)

        for title, rule in schema_check.schema()["$defs"].items():
            for name in names(rule):
                # The inner values of the inputs that are not rendered yet are Blender's own words.
                inner = title == "SUNDOG_material" and name not in rule["properties"]
                self.assertTrue(inner or re.search(rf"[`.\"]{name}[`.\"]", ours), f"{title}: {name} is not in docs/gltf-extensions.md")


if __name__ == "__main__":
    unittest.main()
