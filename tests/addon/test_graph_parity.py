# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees beside Cycles: balls that show what nodes give, by both programs, from one scene."""

import math
import unittest

import bpy
import export_kit as kit
import numpy
from sundog.export import graph

# Balls a row, and pixels a ball.
ROW, SIZE = 6, 24


class Trees:
    """Materials of node trees, and what is awaited of them."""

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

    def shown(self, name, kind, output, inputs=None, scale=1.0, **properties):
        """A material that shines with what a node gives. `inputs`: numbers, or (kind of node, output) to be linked."""
        tree, surface = self.tree(name)
        node = tree.nodes.new(f"ShaderNode{kind}")
        for key, value in properties.items():
            setattr(node, key, value)
        for key, value in (inputs or {}).items():
            socket = next((s for s in node.inputs if key in (s.identifier, s.name) and s.enabled), None)
            if socket is None:
                # Not all menus have it.
                continue
            if isinstance(value, tuple) and isinstance(value[0], str):
                source = tree.nodes.new(f"ShaderNode{value[0]}")
                for name_of, setting in (value[2] if len(value) > 2 else {}).items():
                    setattr(source, name_of, setting)
                tree.links.new(next(s for s in source.outputs if value[1] in (s.identifier, s.name) and s.enabled), socket)
            else:
                socket.default_value = value
        emission = tree.nodes.new("ShaderNodeEmission")
        emission.inputs["Strength"].default_value = scale
        tree.links.new(next(s for s in node.outputs if output in (s.identifier, s.name) and s.enabled), emission.inputs["Color"])
        tree.links.new(emission.outputs[0], surface)
        return tree, node


class Parity(kit.ExportTest):
    """What both programs show."""

    def setUp(self):
        super().setUp()
        before, graph.ENABLED = graph.ENABLED, True
        self.addCleanup(setattr, graph, "ENABLED", before)

    def compare(self, materials, samples, mean=0.01, error=1e-3):
        """Renders a ball for each material by both; fails where one differs, saying by how much."""
        rows = max(ROW, math.ceil(len(materials) / ROW))
        for number, material in enumerate(materials):
            line, column = divmod(number, ROW)
            bpy.ops.mesh.primitive_uv_sphere_add(
                segments=48, ring_count=24, radius=0.46, location=(column - (ROW - 1) / 2, line - (rows - 1) / 2, 0), rotation=(0.5, 0.3, 0.2)
            )
            ball = bpy.context.object
            ball.name = f"ball {number}"
            ball.scale = (1.0, 0.9, 0.8)
            ball.pass_index, ball.color = number, (0.2, 0.5, 0.7, 1)
            ball.data.shade_smooth()
            ball.data.materials.append(material)
        data = self.camera.data
        data.type, data.ortho_scale = "ORTHO", rows
        cycles = self.scene.cycles
        kit.unbiased(cycles)
        cycles.max_bounces = 4
        render = self.scene.render
        width, height = ROW * SIZE, rows * SIZE
        render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
        found = self.export()
        seen = kit.cycles_pixels(width, height, samples)
        got = kit.rendered(found.path, width, height, samples)
        said = {e["name"]: e for e in found.result.findings.as_list()} if hasattr(found.result, "findings") else {}
        wrong = []
        for number, material in enumerate(materials):
            line, column = divmod(number, ROW)
            # The first row of balls is the lowest one, and so is the first row of pixels.
            part = numpy.s_[line * SIZE : (line + 1) * SIZE, column * SIZE : (column + 1) * SIZE]
            a, b = got[part], seen[part]
            pixels = lambda p: p.reshape(SIZE // 2, 2, SIZE // 2, 2, 3).mean(axis=(1, 3))  # noqa: E731
            a, b = pixels(a), pixels(b)
            by_mean = abs(a.mean() - b.mean()) / max(abs(b).mean(), 1e-3)
            by_pixel = ((a - b) ** 2 / (b**2 + 0.01)).mean()
            words = f"{material.name}: mean {a.mean():.4f} against {b.mean():.4f} ({by_mean:.2%}), relMSE {by_pixel:.1e}"
            bad = by_mean > mean or by_pixel > error
            print(("MISS " if bad else "ok   ") + words, said.get(material.name, {}).get("detail", ""))
            if bad:
                wrong.append(words)
        self.assertFalse(wrong, "\n" + "\n".join(wrong))

    def test_inputs_and_converters(self):
        """What is known of a place, and what is made of numbers."""
        t = Trees()
        for output in ("Generated", "Normal", "UV", "Object", "Camera", "Reflection"):
            t.shown(f"coordinates {output}", "TexCoord", output, scale=0.1 if output == "Camera" else 1)
        for output in ("Position", "Normal", "True Normal", "Incoming", "Parametric", "Backfacing"):
            t.shown(f"geometry {output}", "NewGeometry", output)
        for output in ("Location", "Color", "Object Index", "Random"):
            t.shown(f"object {output}", "ObjectInfo", output, scale=0.1 if output == "Object Index" else 1)
        place = ("TexCoord", "Generated")
        for kind in ("POINT", "TEXTURE", "VECTOR", "NORMAL"):
            t.shown(f"mapping {kind}", "Mapping", "Vector", {"Vector": place, "Location": (0.1, 0.2, 0.3), "Rotation": (0.3, 0.5, 0.7), "Scale": (2, 1, 0.5)}, vector_type=kind)
        t.shown("fresnel", "Fresnel", "Fac", {"IOR": 1.6})
        t.shown("layer fresnel", "LayerWeight", "Fresnel", {"Blend": 0.3})
        t.shown("layer facing", "LayerWeight", "Facing", {"Blend": 0.7})
        t.shown("wrap", "Math", "Value", {"Value": place, "Value_001": 0.3, "Value_002": 0.1}, operation="WRAP")
        t.shown("vector sine", "VectorMath", "Vector", {"Vector": place}, operation="SINE")
        t.shown("vector length", "VectorMath", "Value", {"Vector": place}, operation="LENGTH")
        t.shown("camera depth", "CameraData", "View Z Depth", scale=0.1)
        t.shown("rotate", "VectorRotate", "Vector", {"Vector": place, "Angle": 0.7}, rotation_type="AXIS_ANGLE")
        t.shown("transform", "VectorTransform", "Vector", {"Vector": ("NewGeometry", "Normal")}, vector_type="NORMAL", convert_from="WORLD", convert_to="OBJECT")
        t.shown("hue", "HueSaturation", "Color", {"Color": place, "Hue": 0.7, "Saturation": 1.5})
        t.shown("contrast", "BrightContrast", "Color", {"Color": place, "Bright": 0.1, "Contrast": 0.5})
        t.shown("range", "MapRange", "Result", {"Value": place, "From Min": 0.2, "From Max": 0.8, "To Max": 2.0}, interpolation_type="SMOOTHSTEP")
        t.shown("screen", "Mix", "Result_Color", {"A_Color": place, "B_Color": (0.2, 0.5, 0.7, 1)}, data_type="RGBA", blend_type="SCREEN")
        t.shown("hsv", "SeparateColor", "Green", {"Color": place}, mode="HSV")
        t.shown("ramp", "ValToRGB", "Color", {"Fac": place})
        t.shown("curves", "RGBCurve", "Color", {"Color": place})
        t.shown("fresnel of a vector", "Fresnel", "Fac", {"IOR": 1.33, "Normal": ("NewGeometry", "Position")})
        t.shown("facing a vector", "LayerWeight", "Facing", {"Normal": ("NewGeometry", "Position")})
        self.compare(t.materials, 64)

    def test_textures(self):
        """Patterns."""
        t = Trees()
        t.shown("noise", "TexNoise", "Color")
        t.shown("noise factor", "TexNoise", "Fac", {"Detail": 3.5, "Distortion": 0.5})
        t.shown("noise 4D", "TexNoise", "Fac", {"W": 1.5}, noise_dimensions="4D")
        for kind in ("MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HETERO_TERRAIN"):
            t.shown(f"noise {kind}", "TexNoise", "Fac", noise_type=kind, scale=0.5)
        for feature in ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE"):
            t.shown(f"voronoi {feature}", "TexVoronoi", "Distance", feature=feature)
        t.shown("voronoi color", "TexVoronoi", "Color", {"Vector": ("TexCoord", "Object")}, distance="MANHATTAN")
        t.shown("voronoi position", "TexVoronoi", "Position", voronoi_dimensions="2D")
        t.shown("wave", "TexWave", "Color", {"Distortion": 2.0})
        t.shown("rings", "TexWave", "Fac", wave_type="RINGS", wave_profile="SAW")
        t.shown("magic", "TexMagic", "Color")
        t.shown("brick", "TexBrick", "Color")
        t.shown("checker", "TexChecker", "Color")
        t.shown("gradient", "TexGradient", "Fac", gradient_type="SPHERICAL")
        t.shown("gradient object", "TexGradient", "Fac", {"Vector": ("TexCoord", "Object")}, gradient_type="RADIAL")
        t.shown("gabor", "TexGabor", "Value", {"Scale": 2.0})
        self.compare(t.materials, 256)

    def test_surfaces(self):
        """Shaders of what nodes give, under light."""
        t = Trees()

        def shader(name, kind, links, **inputs):
            tree, surface = t.tree(name)
            node = tree.nodes.new(f"ShaderNode{kind}")
            for key, value in inputs.items():
                node.inputs[key.replace("_", " ")].default_value = value
            for key, (source, output, settings) in links.items():
                of = tree.nodes.new(f"ShaderNode{source}")
                for k, v in settings.items():
                    of.inputs[k].default_value = v
                tree.links.new(of.outputs[output], node.inputs[key])
            tree.links.new(node.outputs[0], surface)
            return tree, node

        noise = ("TexNoise", "Fac", {"Scale": 3.0})
        shader("color by noise", "BsdfPrincipled", {"Base Color": ("TexNoise", "Color", {"Scale": 3.0})})
        shader("roughness by noise", "BsdfPrincipled", {"Roughness": noise}, Metallic=1.0)
        shader("metal by noise", "BsdfPrincipled", {"Metallic": noise}, Base_Color=(0.9, 0.5, 0.2, 1))
        shader("alpha by noise", "BsdfPrincipled", {"Alpha": noise}, Base_Color=(0.9, 0.5, 0.2, 1))
        shader("glow by noise", "BsdfPrincipled", {"Emission Strength": noise}, Emission_Color=(0.9, 0.5, 0.2, 1))
        shader("level", "BsdfPrincipled", {"Specular IOR Level": noise}, Roughness=0.3)
        for name, distance in (("hills", 0.1), ("steep", 1.0)):
            tree, node = shader(name, "BsdfDiffuse", {})
            bump, pattern = tree.nodes.new("ShaderNodeBump"), tree.nodes.new("ShaderNodeTexNoise")
            pattern.inputs["Scale"].default_value = 4
            bump.inputs["Distance"].default_value = distance
            tree.links.new(pattern.outputs["Fac"], bump.inputs["Height"])
            tree.links.new(bump.outputs[0], node.inputs["Normal"])
        tree, surface = t.tree("mix by facing")
        mix, weight = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeLayerWeight")
        first, second = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeBsdfGlossy")
        first.inputs["Color"].default_value = (0.7, 0.2, 0.1, 1)
        second.inputs["Roughness"].default_value = 0.4
        tree.links.new(weight.outputs["Facing"], mix.inputs[0])
        tree.links.new(first.outputs[0], mix.inputs[1])
        tree.links.new(second.outputs[0], mix.inputs[2])
        tree.links.new(mix.outputs[0], surface)
        tree, surface = t.tree("seen by the camera alone")
        mix, path = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeLightPath")
        first, second = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeEmission")
        tree.links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
        tree.links.new(first.outputs[0], mix.inputs[1])
        tree.links.new(second.outputs[0], mix.inputs[2])
        tree.links.new(mix.outputs[0], surface)
        kit.sun_and_grey_world(self.scene)
        self.compare(t.materials, 512, mean=0.01, error=2e-3)


if __name__ == "__main__":
    unittest.main()
