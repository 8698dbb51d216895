# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that shadow rays find otherwise than the rays of paths, beside Cycles': how much there is of it hangs on the density of light
samples, that of the sky's table included."""

import bpy
import export_kit as kit

SIZE = 24


class UnlikeRays(kit.ExportTest):
    """A floor below something that only some rays meet."""

    def setUp(self):
        super().setUp()
        self.write_graphs(True)
        kit.unbiased(self.scene.cycles)
        self.scene.cycles.max_bounces = 2
        self.put("floor", kit.plane(size=8), kit.material("grey", Base_Color=(0.8, 0.8, 0.8, 1), Roughness=1.0))
        self.camera.location, self.camera.rotation_euler = (0, -7, 4), (1.05, 0, 0)

    def put(self, name, mesh, material, **more):
        shown = self.link(name, mesh, **more)
        shown.data.materials.append(material)
        return shown

    def sky(self, kind, disc=True):
        """A world of a sky texture; `disc` is its switch for the sun, which the older models leave without one."""
        if self.scene.world is None:
            kit.even_world(self.scene, 1)
        world = self.scene.world
        world.use_nodes = True
        tree = world.node_tree
        for node in [n for n in tree.nodes if n.type == "TEX_SKY"]:
            tree.nodes.remove(node)
        sky = tree.nodes.new("ShaderNodeTexSky")
        sky.sky_type, sky.sun_disc, sky.sun_elevation = kind, disc, 0.9
        background = next(n for n in tree.nodes if n.type == "BACKGROUND")
        tree.links.new(sky.outputs[0], background.inputs[0])

    def check(self, words, bar=0.004, samples=1024):
        """Compares the means with the Light Tree and without."""
        for tree in (False, True):
            self.scene.cycles.use_light_tree = tree
            found = self.export()
            ours = kit.rendered(found.path, SIZE, SIZE, samples, *([] if tree else ["--even-lights"])).mean()
            theirs = kit.cycles_pixels(SIZE, SIZE, samples).mean()
            print(f"{words}, {'Light Tree' if tree else 'evenly'}: {ours / theirs - 1:+.4f}", flush=True)
            self.assertLess(abs(ours / theirs - 1), bar)

    def test_a_panel_that_casts_no_shadow_below_a_sky(self):
        """Rays of paths meet the panel, light samples pass it: of the sky above it their share of the weight is left."""
        dim = kit.material("dim", Base_Color=(0, 0, 0, 1), Roughness=1.0, Emission_Color=(1, 0.9, 0.5, 1), Emission_Strength=0.02)
        panel = self.put("panel", kit.plane(size=7), dim, visible_shadow=False, visible_camera=False)
        panel.location.z = 1
        for kind, disc in (("PREETHAM", True), ("PREETHAM", False), ("HOSEK_WILKIE", True)):
            self.sky(kind, disc)
            self.check(f"{kind} {disc}")

    def test_glass_that_shadow_rays_pass(self):
        """The usual trick for windows: a mix with Transparent by Is Shadow Ray."""
        glass = bpy.data.materials.new("glass")
        glass.use_nodes = True
        tree = glass.node_tree
        tree.nodes.clear()
        mix, path = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeLightPath")
        tree.links.new(path.outputs["Is Shadow Ray"], mix.inputs[0])
        for number, kind in enumerate(("ShaderNodeBsdfGlass", "ShaderNodeBsdfTransparent")):
            tree.links.new(tree.nodes.new(kind).outputs[0], mix.inputs[1 + number])
        tree.links.new(mix.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs[0])
        pane = self.put("pane", kit.cube(), glass)
        pane.location.z, pane.scale = 1, (3, 3, 0.05)
        shining = kit.material("shining", Base_Color=(0, 0, 0, 1), Emission_Color=(1, 0.8, 0.5, 1), Emission_Strength=20)
        self.put("shining", kit.plane(size=1), shining).location = (-1, 0, 2)
        lamp = bpy.data.lights.new("lamp", "AREA")
        lamp.energy, lamp.size = 100, 2
        self.link("lamp", lamp).location = (1, 0, 3)
        self.check("a lamp and a shining panel", samples=512)
        # With the switch on, Cycles' Light Tree takes the sky for one with the sun of the newer models: see sundog-and-cycles.md.
        self.sky("HOSEK_WILKIE", disc=False)
        self.check("with a sky")
