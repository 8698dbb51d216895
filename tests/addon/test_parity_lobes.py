# SPDX-License-Identifier: GPL-3.0-or-later
"""Each of Blender's shaders, alone and in mixes, beside Cycles: balls by both programs, from one scene."""

import math
import os
import subprocess
import tempfile
import unittest

import bpy
import export_kit as kit
import numpy
from sundog import export
from sundog.export import graph

# Balls a row, and pixels a ball.
ROW, SIZE = 8, 24
RED, GOLD, BLUE = (0.9, 0.4, 0.2, 1), (0.9, 0.6, 0.2, 1), (0.2, 0.5, 0.9, 1)
MEAN, ERROR = 0.01, 1e-3


def deviation(first, second):
    """Standard deviation of the mean of two pictures whose noises have nothing in common: half that of their difference."""
    different = (first - second).mean(axis=-1)
    return math.sqrt((different**2).mean() / different.size) / 2


class Shaders:
    """Materials made of shaders."""

    def __init__(self):
        self.materials = []

    def tree(self, name):
        """(node tree, the surface's socket) of a new material."""
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        self.materials.append(material)
        return tree, tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]

    @staticmethod
    def shader(tree, kind, properties=None, **inputs):
        """A shader's node. Inputs by name with _ for blanks: values, or kinds of texture nodes whose factor they take."""
        node = tree.nodes.new(f"ShaderNode{kind}")
        for key, value in (properties or {}).items():
            setattr(node, key, value)
        for key, value in inputs.items():
            socket = node.inputs[key.replace("_", " ")]
            if isinstance(value, str):
                texture = tree.nodes.new(f"ShaderNode{value}")
                tree.links.new(texture.outputs[0], socket)
            else:
                socket.default_value = value
        return node

    def alone(self, name, kind, properties=None, **inputs):
        """A material of one shader."""
        tree, surface = self.tree(name)
        tree.links.new(self.shader(tree, kind, properties, **inputs).outputs[0], surface)

    def mixed(self, name, factor, *parts):
        """A material of two shaders, each (kind, properties, inputs), mixed by a number or a layer weight; added if None."""
        tree, surface = self.tree(name)
        mix = tree.nodes.new("ShaderNodeAddShader" if factor is None else "ShaderNodeMixShader")
        first = 0 if factor is None else 1
        if factor == "facing":
            tree.links.new(tree.nodes.new("ShaderNodeLayerWeight").outputs["Facing"], mix.inputs[0])
        elif factor is not None:
            mix.inputs[0].default_value = factor
        for number, (kind, properties, inputs) in enumerate(parts):
            made = self.shader(tree, kind, properties, **inputs)
            tree.links.new(made.outputs[0], mix.inputs[first + number])
        tree.links.new(mix.outputs[0], surface)


class Beside(kit.ExportTest):
    """Balls by both programs."""

    # A pixel of each of the two pictures of both programs.
    SAMPLES = 256
    # Most of an indirect contribution; 0 for no limit.
    CLAMP = 0

    def setUp(self):
        super().setUp()
        before, graph.ENABLED = graph.ENABLED, True
        self.addCleanup(setattr, graph, "ENABLED", before)

    def place(self, materials, suns):
        """A ball for each material, lit from both sides if there are suns."""
        rows = math.ceil(len(materials) / ROW)
        for number, material in enumerate(materials):
            line, column = divmod(number, ROW)
            # As meshes, not as instances: each has its own material.
            bpy.ops.mesh.primitive_uv_sphere_add(
                segments=64, ring_count=32, radius=0.4, location=(column - (ROW - 1) / 2, line - (rows - 1) / 2, 0), rotation=(0.5, 0.3, 0.2)
            )
            ball = bpy.context.object
            ball.data.shade_smooth()
            ball.data.materials.append(material)
        lamps = (("sun", (1, 0.9, 0.8), (0.5, 0.7, 0)), ("back", (0.4, 0.6, 1), (2.4, -0.4, 0)))
        for name, color, angles in lamps if suns else ():
            sun = bpy.data.lights.new(name, "SUN")
            sun.energy, sun.angle, sun.color = 3, 0.6, color
            self.link(name, sun, rotation_euler=angles)
        self.scene.world = bpy.data.worlds.new("world")
        self.scene.world.use_nodes = True
        background = next(n for n in self.scene.world.node_tree.nodes if n.type == "BACKGROUND")
        background.inputs["Color"].default_value = (0.3, 0.3, 0.3, 1)
        data = self.camera.data
        # The lens is as wide as the longer side.
        data.type, data.ortho_scale = "ORTHO", max(ROW, rows)
        cycles = self.scene.cycles
        kit.unbiased(cycles)
        cycles.sample_clamp_indirect = self.CLAMP
        for kind in ("max", "diffuse", "glossy", "transmission", "transparent_max"):
            setattr(cycles, f"{kind}_bounces", 16)
        return ROW * SIZE, rows * SIZE

    def shown(self, path, width, height, seed):
        """The program's picture, with its own numbers of chance."""
        picture = f"{path}.{seed}.exr"
        command = [kit.program(), "render", path, "-o", picture, "--width", str(width), "--height", str(height), "--quiet", "--allow-outside"]
        command += ["--samples", str(self.SAMPLES), "--filter", "box", "--exr-layers", "combined", "--bounces", "16", "--seed", str(seed)]
        command += ["--clamp-indirect", str(self.CLAMP)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return kit.exr_pixels(picture)

    def compare(self, shaders, suns=True):
        """Renders all materials twice by both programs; fails where one differs, saying by how much."""
        materials = shaders.materials
        width, height = self.place(materials, suns)
        render = self.scene.render
        render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
        found = self.export()
        said = {v["name"]: v for v in found.result.verdicts if v["kind"] == "material"}
        seen, got = [], []
        for seed in (1, 2):
            self.scene.cycles.seed = seed
            seen.append(kit.cycles_pixels(width, height, self.SAMPLES))
            got.append(self.shown(found.path, width, height, seed))
        wrong = []
        for number, material in enumerate(materials):
            line, column = divmod(number, ROW)
            part = numpy.s_[line * SIZE : (line + 1) * SIZE, column * SIZE : (column + 1) * SIZE]
            a, b = ([picture[part] for picture in pictures] for pictures in (got, seen))
            mean, expected = numpy.mean(a), numpy.mean(b)
            # What is left beside the noise: the product of two errors whose noises have nothing in common.
            error = ((a[0] - b[0]) * (a[1] - b[1]) / (numpy.mean(b, axis=0) ** 2 + 0.01)).mean()
            noise = math.hypot(deviation(*a), deviation(*b)) / expected
            verdict = said[material.name]
            words = f"{material.name}: mean {mean:.4f} against {expected:.4f} ({mean / expected - 1:+.2%} +- {noise:.2%}), relMSE {error:.1e}"
            bad = abs(mean / expected - 1) > MEAN + 3 * noise or noise > MEAN / 2 or error > ERROR or verdict["verdict"] != "exact"
            words += f", {verdict['verdict']} {verdict['detail']}"
            print("MISS " if bad else "ok   ", words)
            if bad:
                wrong.append(words)
        self.assertFalse(wrong, "\n" + "\n".join(wrong))


class Clamped(Beside):
    """What is clamped hangs on how likely each lobe is."""

    CLAMP = 1

    def test_mixes_with_tinted_glass(self):
        """Tinted glass is drawn by what it scatters: at equal shares the red one was too bright."""
        s = Shaders()
        clear, red = ("BsdfGlass", {}, {"Roughness": 0.0, "IOR": 1.56}), ("BsdfGlass", {}, {"Color": (1, 0, 0, 1), "Roughness": 0.45, "IOR": 1.76})
        for factor in (0.3, 0.7):
            s.mixed(f"red and clear {factor}", factor, red, clear)
        self.compare(s)


class Turned(Beside):
    """Lobes whose normal is turned away from the surface."""

    SAMPLES = 128

    def test_numbers_for_normals(self):
        """A diffuse lobe that draws directions without light makes another one brighter, as in Cycles (5 % was missing)."""
        s = Shaders()
        for name, direction in (("even", (1, 1, 1)), ("up", (0, 0.3, -1))):
            tree, surface = s.tree(name)
            mix, vector = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeCombineXYZ")
            for socket, value in zip(vector.inputs, direction):
                socket.default_value = value
            plain, turned = (tree.nodes.new("ShaderNodeBsdfDiffuse") for _ in range(2))
            tree.links.new(vector.outputs[0], turned.inputs["Normal"])
            tree.links.new(plain.outputs[0], mix.inputs[1])
            tree.links.new(turned.outputs[0], mix.inputs[2])
            tree.links.new(mix.outputs[0], surface)
        self.compare(s)


class Fibres(Beside):
    """Shaders of hair. Those of Huang's model have no density, so that lamps make more noise."""

    SAMPLES = 1024

    @kit.long
    def test_fibres(self):
        """One of each shader of hair, on meshes: they follow the sides of triangles."""
        s = Shaders()
        for component in ("Reflection", "Transmission"):
            s.alone(f"hair {component}", "BsdfHair", {"component": component}, Color=GOLD, RoughnessU=0.3, RoughnessV=0.6)
        for model in ("CHIANG", "HUANG"):
            s.alone(model, "BsdfHairPrincipled", {"model": model, "parametrization": "COLOR"}, Color=GOLD, Roughness=0.5, Offset=0.3)
        self.compare(s)

    @kit.long
    def test_more_fibres(self):
        """By all that their sockets change, and in a mix."""
        s = Shaders()
        for component in ("Reflection", "Transmission"):
            for u, v in ((0.3, 0.6), (0.6, 1.0)):
                s.alone(f"hair {component} {u}", "BsdfHair", {"component": component}, Color=GOLD, RoughnessU=u, RoughnessV=v)
        for model in ("CHIANG", "HUANG"):
            of = {"model": model, "parametrization": "COLOR"}
            radial = {"Radial_Roughness": 0.6} if model == "CHIANG" else {}
            for roughness in (0.2, 0.5, 0.9):
                s.alone(f"{model} {roughness}", "BsdfHairPrincipled", of, Color=GOLD, Roughness=roughness, **radial)
            s.alone(f"{model} tilted", "BsdfHairPrincipled", of, Color=BLUE, Roughness=0.4, Offset=0.3, IOR=1.3)
            melanin = {"model": model, "parametrization": "MELANIN"}
            s.alone(f"{model} melanin", "BsdfHairPrincipled", melanin, Melanin=0.3, Melanin_Redness=0.4, Tint=GOLD, Random_Color=0.5)
            absorption = {"model": model, "parametrization": "ABSORPTION"}
            s.alone(f"{model} absorption", "BsdfHairPrincipled", absorption, Absorption_Coefficient=(0.1, 0.3, 0.9))
            s.alone(f"{model} by noise", "BsdfHairPrincipled", of, Color="TexNoise", Roughness="TexNoise", Random_Roughness=0.5)
        s.alone("elliptic", "BsdfHairPrincipled", {"model": "HUANG"}, Aspect_Ratio=0.6, Roughness=0.4)
        matte = ("BsdfDiffuse", {}, {"Color": RED})
        s.mixed("matte and a fibre", 0.5, matte, ("BsdfHairPrincipled", {"model": "CHIANG"}, {"Color": BLUE}))
        self.compare(s)


class Parity(Beside):
    """What both programs show."""

    def test_shaders_of_one_lobe(self):
        """Each alone."""
        s = Shaders()
        s.alone("translucent", "BsdfTranslucent", Color=BLUE)
        for distribution in ("GGX", "MULTI_GGX"):
            for roughness in (0.3, 0.6, 1.0):
                s.alone(f"glossy {distribution} {roughness}", "BsdfAnisotropic", {"distribution": distribution}, Color=GOLD, Roughness=roughness)
        for kind in ("F82", "PHYSICAL_CONDUCTOR"):
            for distribution in ("GGX", "MULTI_GGX"):
                s.alone(f"metallic {kind} {distribution}", "BsdfMetallic", {"distribution": distribution, "fresnel_type": kind}, Roughness=0.6)
        s.alone("metallic anisotropic", "BsdfMetallic", Roughness=0.6, Anisotropy=0.7)
        for roughness in (0.05, 0.1, 0.2, 0.3, 0.5, 0.75, 1):
            s.alone(f"sheen {roughness}", "BsdfSheen", Color=GOLD, Roughness=roughness)
        for component in ("DIFFUSE", "GLOSSY"):
            for size, smooth in ((0.3, 0.2), (0.8, 0.0)):
                s.alone(f"toon {component} {size}", "BsdfToon", {"component": component}, Color=RED, Size=size, Smooth=smooth)
        self.compare(s)

    def test_rough_glass(self):
        """Without suns: their light passes from behind through facets that face away in Cycles (docs/sundog-and-cycles.md)."""
        s = Shaders()
        for roughness in (0.3, 0.6, 1.0):
            for distribution in ("GGX", "MULTI_GGX", "BECKMANN"):
                s.alone(f"glass {distribution} {roughness}", "BsdfGlass", {"distribution": distribution}, Color=BLUE, Roughness=roughness, IOR=1.4)
            for distribution in ("GGX", "BECKMANN"):
                name = f"refraction {distribution} {roughness}"
                s.alone(name, "BsdfRefraction", {"distribution": distribution}, Color=GOLD, Roughness=roughness, IOR=1.3)
            s.alone(f"principled {roughness}", "BsdfPrincipled", Base_Color=BLUE, Roughness=roughness, Transmission_Weight=1.0)
        s.alone("glass by noise", "BsdfGlass", Roughness="TexNoise")
        # Indices about 0.5.
        s.alone("glass of varying index", "BsdfGlass", Roughness=0.9, IOR="TexNoise")
        s.alone("principled of varying index", "BsdfPrincipled", Roughness=0.6, IOR="TexNoise", Transmission_Weight=1.0)
        s.mixed("glass and clear", 0.5, ("BsdfGlass", {}, {"Roughness": 0.5}), ("BsdfTransparent", {}, {"Color": BLUE}))
        s.mixed("refraction plus gloss", None, ("BsdfRefraction", {}, {"Roughness": 0.5}), ("BsdfAnisotropic", {}, {"Color": (0.2, 0.2, 0.2, 1), "Roughness": 0.5}))
        self.compare(s, suns=False)

    def test_mixes(self):
        """Shaders in mixes and sums, with numbers from textures."""
        s = Shaders()
        matte = ("BsdfDiffuse", {}, {"Color": RED})
        for kind, properties, inputs in (
            ("BsdfTranslucent", {}, {"Color": BLUE}),
            ("BsdfGlass", {}, {"Color": BLUE, "Roughness": 0.4}),
            ("BsdfRefraction", {}, {"Roughness": 0.5, "IOR": 1.3}),
            ("BsdfMetallic", {}, {"Roughness": 0.5}),
            ("BsdfSheen", {}, {"Color": GOLD, "Roughness": 0.3}),
            ("BsdfToon", {}, {"Color": GOLD, "Size": 0.4, "Smooth": 0.2}),
        ):
            s.mixed(f"matte and {kind}", 0.4, matte, (kind, properties, inputs))
            s.mixed(f"{kind} by facing", "facing", matte, (kind, properties, inputs))
        s.mixed("background plus matte", None, ("Background", {}, {"Color": BLUE, "Strength": 0.5}), matte)
        s.alone("translucent by noise", "BsdfTranslucent", Color="TexNoise")
        s.alone("metal by noise", "BsdfMetallic", Roughness="TexNoise")
        self.compare(s)

    def test_indices_below_one(self):
        # Smooth ones at 0.6 are 1.5 % off: the ring of total reflection lies between two entries of Cycles' table.
        s = Shaders()
        for index, roughnesses in ((0.9, (0.05, 0.5)), (0.6, (0.5,)), (0.3, (0.05, 0.5))):
            for roughness in roughnesses:
                s.alone(f"index {index} {roughness}", "BsdfPrincipled", Base_Color=BLUE, IOR=index, Roughness=roughness)
        s.alone("index 0", "BsdfPrincipled", Base_Color=BLUE, IOR=0.0, Roughness=0.5)
        s.alone("glass of index 0", "BsdfGlass", Color=BLUE, IOR=0.0, Roughness=0.0)
        s.alone("refraction of index 0", "BsdfRefraction", Color=BLUE, IOR=0.0, Roughness=0.0)
        s.alone("level", "BsdfPrincipled", Base_Color=BLUE, IOR=0.6, Specular_IOR_Level=0.8, Roughness=0.5)
        s.alone("clear", "BsdfPrincipled", Base_Color=BLUE, IOR=0.8, Roughness=0.05, Transmission_Weight=1.0)
        s.alone("index by noise", "BsdfPrincipled", Base_Color=BLUE, IOR="TexNoise", Roughness=0.4)
        self.compare(s, suns=False)

    def test_colours_in_place_of_shaders(self):
        """They shine."""
        s = Shaders()
        matte = ("BsdfDiffuse", {}, {"Color": RED})
        for kind, output in (("TexNoise", "Color"), ("TexVoronoi", "Distance"), ("NewGeometry", "Normal")):
            tree, surface = s.tree(f"{kind} alone")
            tree.links.new(tree.nodes.new(f"ShaderNode{kind}").outputs[output], surface)
            s.mixed(f"{kind} and matte", 0.4, matte, (kind, {}, {}))
        self.compare(s)

    def test_colours_in_place_of_numbers(self):
        """Their luminance counts."""
        s = Shaders()
        for kind, socket, properties in (
            ("Emission", "Strength", {"Color": GOLD}),
            ("BsdfPrincipled", "Emission Strength", {"Emission_Color": GOLD}),
            ("BsdfPrincipled", "Metallic", {"Base_Color": GOLD}),
            ("BsdfGlass", "Roughness", {"Color": BLUE}),
        ):
            tree, surface = s.tree(f"{kind} {socket}")
            made = s.shader(tree, kind, {}, **properties)
            tree.links.new(tree.nodes.new("ShaderNodeTexVoronoi").outputs["Color"], made.inputs[socket])
            tree.links.new(made.outputs[0], surface)
        self.compare(s, suns=False)

    @kit.long
    def test_what_is_clear_in_mixes_and_sums(self):
        """With what scatters and what shines, side by side and one in the other."""
        s = Shaders()
        matte, shine = ("BsdfDiffuse", {"Color": RED}), ("Emission", {"Color": BLUE})
        for tint in ((1, 1, 1, 1), (0.9, 0.5, 0.3, 1)):
            clear = ("BsdfTransparent", {"Color": tint})
            nested = {
                "clear and shine": ("add", clear, shine),
                "holes and shine": ("add", ("mix", clear, matte), shine), "shine over holes": ("mix", ("mix", clear, matte), shine),
                "matte over glow": ("mix", ("add", clear, shine), matte), "shine over veil": ("mix", ("add", clear, matte), shine),
                "holes over holes": ("mix", clear, ("mix", clear, matte)),
            }  # fmt: skip
            for name, what in nested.items():
                tree, surface = s.tree(f"{name} {tint[1]}")
                noise = tree.nodes.new("ShaderNodeTexNoise")
                noise.inputs["Scale"].default_value = 3

                def made(what, depth=0):
                    kind, *parts = what
                    if kind not in {"add", "mix"}:
                        return s.shader(tree, kind, {}, **parts[0]).outputs[0]
                    node = tree.nodes.new("ShaderNodeAddShader" if kind == "add" else "ShaderNodeMixShader")
                    if kind == "mix":
                        # One that is 0 or 1, and one between.
                        factor = tree.nodes.new("ShaderNodeMath")
                        factor.operation = "MULTIPLY" if depth else "LESS_THAN"
                        factor.inputs[1].default_value = 0.8 if depth else 0.5
                        tree.links.new(noise.outputs[0], factor.inputs[0])
                        tree.links.new(factor.outputs[0], node.inputs[0])
                    sockets = [i for i in node.inputs if i.type == "SHADER"]
                    for socket, part in zip(sockets, parts):
                        tree.links.new(made(part, depth + 1), socket)
                    return node.outputs[0]

                tree.links.new(made(what), surface)
        self.compare(s, suns=False)

    @kit.long
    def test_other_distributions(self):
        """Beckmann's and Ashikhmin's."""
        s = Shaders()
        for roughness in (0.3, 0.6, 1.0):
            for distribution in ("BECKMANN", "ASHIKHMIN_SHIRLEY"):
                s.alone(f"glossy {distribution} {roughness}", "BsdfAnisotropic", {"distribution": distribution}, Color=GOLD, Roughness=roughness)
            s.alone(f"velvet {roughness}", "BsdfSheen", {"distribution": "ASHIKHMIN"}, Color=GOLD, Roughness=roughness)
        for distribution in ("BECKMANN", "ASHIKHMIN_SHIRLEY"):
            s.alone(f"anisotropic {distribution}", "BsdfAnisotropic", {"distribution": distribution}, Color=GOLD, Roughness=0.6, Anisotropy=0.6, Rotation=0.2)
        for kind in ("F82", "PHYSICAL_CONDUCTOR"):
            s.alone(f"metallic {kind}", "BsdfMetallic", {"distribution": "BECKMANN", "fresnel_type": kind}, Roughness=0.6)
        s.alone("refraction", "BsdfRefraction", {"distribution": "BECKMANN"}, Roughness=0.4, IOR=1.3)
        s.alone("glass", "BsdfGlass", {"distribution": "BECKMANN"}, Color=BLUE, Roughness=0.4)
        if bpy.app.version >= (5, 0, 0):
            film = {"Roughness": 0.5, "Thin_Film_Thickness": 400, "Thin_Film_IOR": 1.6}
            s.alone("metallic under a film", "BsdfMetallic", {"distribution": "BECKMANN"}, **film)
        self.compare(s)

    def test_principled(self):
        """GGX, thin walls, normals of coats; light below the surface is told."""
        s = Shaders()
        ggx = {"distribution": "GGX"}
        for roughness in (0.4, 0.7, 1.0):
            s.alone(f"GGX {roughness}", "BsdfPrincipled", ggx, Base_Color=RED, Roughness=roughness)
            s.alone(f"GGX metal {roughness}", "BsdfPrincipled", ggx, Base_Color=RED, Roughness=roughness, Metallic=1.0)
        s.alone("GGX glass", "BsdfPrincipled", ggx, Base_Color=BLUE, Roughness=0.4, Transmission_Weight=1.0)
        s.alone("MULTI_GGX glass", "BsdfPrincipled", {"distribution": "MULTI_GGX"}, Base_Color=BLUE, Roughness=0.4, Transmission_Weight=1.0)
        for weight in (1.0, 0.5):
            tree, surface = s.tree(f"coat with waves {weight}")
            node = s.shader(tree, "BsdfPrincipled", Base_Color=RED, Coat_Weight=weight, Coat_Roughness=0.4, Roughness=0.7)
            bump = s.shader(tree, "Bump", Height="TexWave", Distance=0.05)
            tree.links.new(bump.outputs[0], node.inputs["Coat Normal"])
            tree.links.new(node.outputs[0], surface)
        if any(i.name == "Thin Wall" for i in node.inputs):
            for roughness in (0.0, 0.3, 0.6):
                s.alone(f"pane {roughness}", "BsdfPrincipled", Thin_Wall=True, Base_Color=BLUE, Transmission_Weight=1.0, Roughness=roughness)
            s.alone("half a pane", "BsdfPrincipled", Thin_Wall=True, Base_Color=BLUE, Transmission_Weight=0.5, Roughness=0.5, IOR=1.8)
            for anisotropy in (-0.5, 0.0, 0.8):
                inputs = {"Subsurface_Weight": 0.8, "Subsurface_Anisotropy": anisotropy}
                s.alone(f"leaf {anisotropy}", "BsdfPrincipled", Thin_Wall=True, Base_Color=RED, Roughness=0.6, **inputs)
        self.compare(s)

    @kit.long
    def test_thin_films(self):
        """Over dielectrics, metals and glass."""
        if bpy.app.version < (5, 0, 0):
            self.skipTest("Cycles before 5.0 has other films")
        # The noise of rough glass alone makes an error of 1e-3 with 256; with 1536 it is 1e-4 at most.
        self.SAMPLES = 768
        s = Shaders()
        for thickness in (150, 400, 700, 1500):
            film = {"Thin_Film_Thickness": thickness, "Thin_Film_IOR": 1.6}
            s.alone(f"dielectric {thickness}", "BsdfPrincipled", Base_Color=(0, 0, 0, 1), Roughness=0.4, **film)
            s.alone(f"metal {thickness}", "BsdfPrincipled", Base_Color=GOLD, Specular_Tint=RED, Metallic=1.0, Roughness=0.4, **film)
            s.alone(f"metallic {thickness}", "BsdfMetallic", {"fresnel_type": "PHYSICAL_CONDUCTOR"}, Roughness=0.4, **film)
            s.alone(f"glass {thickness}", "BsdfPrincipled", Transmission_Weight=1.0, Roughness=0.3, **film)
        s.alone("film by noise", "BsdfGlass", {"distribution": "GGX"}, Thin_Film_Thickness="TexNoise", Roughness=0.3)
        if "Thin Wall" in bpy.data.materials["glass 150"].node_tree.nodes["Principled BSDF"].inputs:
            s.alone("bubble", "BsdfPrincipled", Thin_Wall=True, Transmission_Weight=1.0, Roughness=0.1, Thin_Film_Thickness=400)
        self.compare(s)

    def test_sheen_of_principled(self):
        """Sheen over bases, by numbers and by textures."""
        s = Shaders()
        for roughness in (0.1, 0.3, 0.5, 1.0):
            s.alone(f"sheen {roughness}", "BsdfPrincipled", Base_Color=RED, Sheen_Weight=1.0, Sheen_Roughness=roughness, Sheen_Tint=GOLD)
        s.alone("sheen by noise", "BsdfPrincipled", Base_Color=RED, Sheen_Weight="TexNoise", Sheen_Roughness=0.3)
        s.alone("sheen over coat", "BsdfPrincipled", Base_Color=RED, Sheen_Weight=0.7, Coat_Weight=0.6, Coat_Roughness=0.4, Roughness=0.6)
        # Cycles bounds neither weight from above.
        s.alone("much sheen", "BsdfPrincipled", {"distribution": "GGX"}, Base_Color=RED, Sheen_Weight=2.3)
        s.alone("much coat", "BsdfPrincipled", Base_Color=RED, Coat_Weight=2.3, Coat_Roughness=0.6, Coat_Tint=GOLD)
        self.compare(s)

    def test_what_shines_below_layers(self):
        """Coats and sheens keep a part of what the base emits, by the angle of view."""
        self.SAMPLES = 64
        s = Shaders()
        light = {"Base_Color": (0, 0, 0, 1), "Emission_Color": GOLD, "Emission_Strength": 2.0}
        for roughness in (0.0, 0.3, 0.8):
            s.alone(f"coat {roughness}", "BsdfPrincipled", Coat_Weight=1.0, Coat_Roughness=roughness, Coat_IOR=1.8, **light)
            s.alone(f"sheen {roughness}", "BsdfPrincipled", Sheen_Weight=1.0, Sheen_Roughness=roughness, Sheen_Tint=RED, **light)
        s.alone("tinted coat", "BsdfPrincipled", Coat_Weight=0.7, Coat_Tint=BLUE, **light)
        s.alone("coat by noise", "BsdfPrincipled", Coat_Weight="TexNoise", Coat_Tint=BLUE, **light)
        s.alone("both", "BsdfPrincipled", Coat_Weight=0.6, Coat_Tint=BLUE, Sheen_Weight=0.5, **light)
        both = ("BsdfPrincipled", None, {"Coat_Weight": 1.0, "Coat_Tint": RED, **light})
        s.mixed("mixed", 0.4, both, ("BsdfDiffuse", None, {"Color": RED}))
        s.alone("metal", "BsdfPrincipled", Coat_Weight=1.0, Coat_Tint=RED, Metallic=1.0, **light)
        self.compare(s)

    @unittest.skipUnless(bpy.app.version >= (5, 3, 0), "Blender has it from 5.3 on")
    def test_glass_that_spreads_colors(self):
        """Indices of refraction by wavelength: smooth and rough, weak and strong, of a part and in a mix; by a texture too."""
        s = Shaders()
        glass = {"Transmission_Weight": 1.0, "Transmission_Dispersion_Scale": 1.0}
        for abbe in (60.0, 20.0, 5.0):
            for roughness in (0.0, 0.3):
                s.alone(f"abbe {abbe} {roughness}", "BsdfPrincipled", Roughness=roughness, Transmission_Dispersion_Abbe_Number=abbe, **glass)
        s.alone("scaled", "BsdfPrincipled", Roughness=0.1, **{**glass, "Transmission_Dispersion_Scale": 0.4})
        s.alone("by noise", "BsdfPrincipled", Roughness=0.1, **{**glass, "Transmission_Dispersion_Scale": "TexNoise"})
        s.alone("no number", "BsdfPrincipled", Roughness=0.1, Transmission_Dispersion_Abbe_Number=0.0, **glass)
        s.alone("part", "BsdfPrincipled", Roughness=0.1, Base_Color=GOLD, **{**glass, "Transmission_Weight": 0.5})
        s.alone("tinted", "BsdfPrincipled", Roughness=0.2, Base_Color=BLUE, IOR=2.2, **glass)
        s.mixed("mixed", 0.4, ("BsdfPrincipled", None, {"Roughness": 0.1, **glass}), ("BsdfDiffuse", None, {"Color": RED}))
        self.SAMPLES = 2048
        self.compare(s)

    @unittest.skipUnless(bpy.app.version >= (5, 3, 0), "Blender has it from 5.3 on")
    def test_glass_whose_facets_lie_one_way(self):
        """Anisotropy of what goes through: of Glass BSDFs along and across the tangent, and of Principled ones."""
        s = Shaders()
        for distribution in ("GGX", "MULTI_GGX", "BECKMANN"):
            for anisotropy in (0.6, -0.6):
                inputs = {"Roughness": 0.4, "Anisotropy": anisotropy, "Rotation": 0.1}
                s.alone(f"{distribution} {anisotropy}", "BsdfGlass", {"distribution": distribution}, **inputs)
        s.alone("much", "BsdfGlass", Roughness=0.6, Anisotropy=0.8)
        s.alone("by noise", "BsdfGlass", Roughness=0.5, Anisotropy="TexNoise")
        for anisotropic in (0.5, 1.0):
            inputs = {"Anisotropic": anisotropic, "Roughness": 0.5, "Anisotropic_Rotation": 0.2}
            s.alone(f"principled {anisotropic}", "BsdfPrincipled", Transmission_Weight=1.0, **inputs)
            s.alone(f"half {anisotropic}", "BsdfPrincipled", Transmission_Weight=0.5, Base_Color=GOLD, **inputs)
        self.SAMPLES = 1024
        self.compare(s)

    def test_floors_at_grazing_views(self):
        """What layers leave to their base, by the angle of view: a floor under a white sky."""
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
        kit.unbiased(scene.cycles)
        scene.cycles.max_bounces = 0
        bpy.ops.mesh.primitive_plane_add(size=200)
        floor = bpy.context.object
        scene.world = bpy.data.worlds.new("white")
        scene.world.use_nodes = True
        scene.world.node_tree.nodes["Background"].inputs[0].default_value = (1, 1, 1, 1)
        bpy.ops.object.camera_add()
        scene.camera = bpy.context.object
        scene.camera.data.angle = math.radians(2)
        for inputs in ({"Roughness": 0.1}, {"Roughness": 0.5}, {"Roughness": 0.3, "Coat_Weight": 1.0, "Coat_Roughness": 0.2}):
            floor.data.materials.clear()
            floor.data.materials.append(kit.material("floor", Base_Color=(0.8, 0.8, 0.8, 1), **inputs))
            for degrees in (60, 75, 85, 88):
                angle = math.radians(degrees)
                scene.camera.location = (0, -10 * math.sin(angle), 10 * math.cos(angle))
                scene.camera.rotation_euler = (angle, 0, 0)
                with tempfile.TemporaryDirectory() as folder:
                    found = kit.in_render(lambda dg, at=folder: export.write_scene(dg, dg.scene, at, os.path.join(at, "cache")))
                    ours = kit.rendered(found.path, 32, 32, 128)
                theirs = kit.cycles_pixels(32, 32, 128)
                off = ours.mean() / theirs.mean() - 1
                with self.subTest(degrees=degrees, **inputs):
                    # Where the layer's exact albedo decided, up to 2.7 % were off. The noise of both is below 0.03 %.
                    self.assertLess(abs(off), 2e-3)


if __name__ == "__main__":
    unittest.main()
