# SPDX-License-Identifier: GPL-3.0-or-later
"""What nodes of lamps ask of their objects beside Cycles: the mean of all was shown, 27 to 75 % off."""

import unittest

import bpy
import export_kit as kit
import numpy


class LampObjects(kit.ExportTest):
    """A floor under two lamps that share their nodes."""

    SIZE, SAMPLES = 24, 64

    def setUp(self):
        super().setUp()
        self.write_graphs(True)
        self.camera.data.type, self.camera.data.ortho_scale = "ORTHO", 6
        kit.unbiased(self.scene.cycles)
        bpy.ops.mesh.primitive_plane_add(size=12)
        floor = kit.material("floor", Base_Color=(0.8, 0.8, 0.8, 1), Roughness=1.0)
        bpy.context.object.data.materials.append(floor)

    def lamps(self, kind, node, output, settings):
        """Two lamps that shine what an output gives."""
        for made in [o for o in bpy.data.objects if o.type == "LIGHT"]:
            bpy.data.objects.remove(made)
        data = bpy.data.lights.new("lamp", kind)
        data.energy, data["of_data"] = 50, 0.8
        data.use_nodes = True
        tree = data.node_tree
        asks = tree.nodes.new(f"ShaderNode{node}")
        for name, value in settings.items():
            setattr(asks, name, value)
        tree.links.new(asks.outputs[output], next(n for n in tree.nodes if n.type == "EMISSION").inputs["Color"])
        for side in (0, 1):
            lamp = self.link(f"lamp {side}", data, location=(3 * side - 1.5, 0, 1), color=(0.2 + 0.5 * side, 0.9, 0.3, 0.7), pass_index=1 + 2 * side)
            lamp["number"], lamp["colour"] = 0.3 + side, (0.1, 0.5 + side, 0.9)
        self.scene["of_scene"] = 0.6

    def compare(self, words):
        """Both pictures are alike, all verdicts exact."""
        kit.for_cycles(self.SIZE, self.SIZE, self.SAMPLES)
        found = self.export()
        self.assertEqual([v for v in found.result.verdicts if v["verdict"] != "exact"], [], words)
        ours = kit.rendered(found.path, self.SIZE, self.SIZE, self.SAMPLES)
        theirs = kit.cycles_pixels(self.SIZE, self.SIZE, self.SAMPLES)
        halves = [picture.reshape(self.SIZE, 2, -1, 3).mean((0, 2)) for picture in (ours, theirs)]
        far = float(abs(halves[0] - halves[1]).max())
        print(f"{words}: {halves[0].round(3).tolist()} Cycles {halves[1].round(3).tolist()}", flush=True)
        self.assertLess(far, 0.01 * max(float(abs(halves[1]).max()), 0.01), words)

    def test_object_info(self):
        """Location, colours, numbers; no material has a number there."""
        for kind in ("POINT", "AREA"):
            for output in ("Location", "Color", "Alpha", "Object Index", "Material Index", "Random"):
                with self.subTest(kind=kind, output=output):
                    self.lamps(kind, "ObjectInfo", output, {})
                    self.compare(f"{kind} {output}")

    def test_attributes(self):
        """Properties of the object, its data and the scene; a lamp has nothing of meshes."""
        asked = [("OBJECT", "number"), ("OBJECT", "colour"), ("OBJECT", "of_data"), ("OBJECT", "none"), ("INSTANCER", "colour"), ("VIEW_LAYER", "of_scene"), ("GEOMETRY", "number")]
        for kind, name in asked:
            for output in ("Color", "Fac", "Alpha"):
                with self.subTest(kind=kind, name=name, output=output):
                    self.lamps("POINT", "Attribute", output, {"attribute_type": kind, "attribute_name": name})
                    self.compare(f"{kind} {name} {output}")

    def test_nothing(self):
        """What a lamp has nothing of is 0."""
        for node, output in (("VertexColor", "Color"), ("Wireframe", 0), ("NewGeometry", "Pointiness"), ("NewGeometry", "Tangent"), ("ParticleInfo", "Random")):
            with self.subTest(node=node, output=output):
                self.lamps("POINT", node, output, {})
                self.compare(f"{node} {output}")

    def test_nothing_is_around(self):
        """An Ambient Occlusion is open, and a Bevel is the lamp's own normal. (The mean was shown.)"""
        for kind in ("POINT", "AREA"):
            for node, output in (("AmbientOcclusion", "AO"), ("AmbientOcclusion", "Color"), ("Bevel", 0)):
                with self.subTest(kind=kind, node=node, output=output):
                    self.lamps(kind, node, output, {})
                    self.compare(f"{kind} {node} {output}")

    def test_depths_of_rays(self):
        """Cycles counts the way to the lamp: 1 for what the camera sees and for what lights that, one more behind each bounce. (The mean
        was shown, 0.16 of the light.)"""
        bpy.ops.mesh.primitive_cube_add(size=0.8, location=(0, 0, 0.4))
        bpy.context.object.data.materials.append(kit.material("white", Base_Color=(0.95, 0.95, 0.95, 1), Roughness=1.0))
        self.SAMPLES = 256
        for kind in ("POINT", "AREA", "SUN", "SPOT"):
            with self.subTest(kind=kind):
                self.lamps(kind, "LightPath", "Ray Depth", {})
                self.compare(f"{kind} Ray Depth")

    @unittest.skipIf(bpy.app.version < (4, 5, 0), "properties of the view layer")
    def test_worlds_ask_the_scene(self):
        """A world of a property of the scene; it was black."""
        self.lamps("POINT", "ObjectInfo", "Color", {})
        self.scene["of_scene"] = 0.6
        self.scene.world = bpy.data.worlds.new("world")
        self.scene.world.use_nodes = True
        tree = self.scene.world.node_tree
        asks = tree.nodes.new("ShaderNodeAttribute")
        asks.attribute_type, asks.attribute_name = "VIEW_LAYER", "of_scene"
        tree.links.new(asks.outputs["Fac"], next(n for n in tree.nodes if n.type == "BACKGROUND").inputs["Color"])
        self.compare("world")


if __name__ == "__main__":
    unittest.main()
