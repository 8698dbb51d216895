# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a material's shader tree as the inputs of one Principled BSDF; what is not exact is told."""

import math

import bpy
import numpy

from . import colorspace, evaluated, expressions, images, inlining, nodes, volumes
from .expressions import BLACK, ONE, WHITE, ZERO, Const, Image, Unknown, as_color, as_scalar, mix, multiply
from .verdicts import APPROXIMATED, EXACT, LOST, Finding


# What glows shows only as far as it is opaque: so much at least, and then it glows so many times brighter. Less would hide less
# of what is behind, and make more noise.
LEAST_ALPHA = 1 / 16


# Shaders of one lobe: their names in SUNDOG_material, and their sockets.
SIMPLE = {
    "BSDF_TRANSLUCENT": ("translucent", ("Color",)),
    "BSDF_REFRACTION": ("refraction", ("Color", "Roughness", "IOR")),
    "BSDF_GLASS": ("glass", ("Color", "Roughness", "IOR")),
    "BSDF_METALLIC": ("metallic", ("Base Color", "Edge Tint", "Roughness")),
    "BSDF_SHEEN": ("sheen", ("Color", "Roughness")),
    "BSDF_TOON": ("toon", ("Color", "Size", "Smooth")),
}


class TextureSpec:
    """An image and how it lies on the surface; `wrap` holds glTF's numbers for both directions."""

    def __init__(self, image, uv, transform, wrap, nearest, multiplied=False, weighted=False):
        self.image, self.uv, self.transform, self.wrap, self.nearest = image, uv, transform, wrap, nearest
        # Whether its colour is that of the file times its alpha.
        self.multiplied = multiplied
        # Whether its colours count as much as they are opaque, between texels.
        self.weighted = weighted
        self._identity = None

    def mapping(self):
        """Equal for textures whose texels lie on one another (if they are of one size)."""
        return [self.uv, self.transform, self.wrap, self.nearest]

    def key(self):
        """See Expression.key."""
        if self._identity is None:
            self._identity = images.identity(self.image)
        return [self._identity, self.mapping(), self.multiplied, self.weighted]


class Surface:
    """The inputs of a Principled BSDF, as expressions. What is not set is as if it were not there."""

    COLORS = {"base_color": BLACK, "specular_tint": WHITE, "emission": BLACK}
    SCALARS = {
        "metallic": ZERO,
        "roughness": ONE,
        "ior": Const(1.0),
        "specular_level": Const(0.5),
        "alpha": ONE,
        "transmission": ZERO,
    }

    def __init__(self, **inputs):
        for name, value in {**self.COLORS, **self.SCALARS}.items():
            setattr(self, name, inputs.pop(name, value))
        self.normal = inputs.pop("normal", None)
        # Whether its transmission goes through a sheet instead of into a solid.
        self.thin_walled = inputs.pop("thin_walled", False)
        # Features without a counterpart in the program, by the names of the contract.
        self.others = inputs.pop("others", {})
        assert not inputs, inputs

    def copy(self, **changes):
        """The same with some inputs replaced."""
        new = Surface()
        new.__dict__.update(self.__dict__)
        new.__dict__.update(changes)
        return new

    def blend(self, other, factor):
        """Each input mixed for itself."""
        new = self.copy()
        for name in [*self.COLORS, *self.SCALARS]:
            setattr(new, name, mix(factor, getattr(self, name), getattr(other, name)))
        new.normal = self.normal or other.normal
        new.thin_walled = self.thin_walled or other.thin_walled
        new.others = {**other.others, **self.others}
        return new

    def is_transparent(self):
        """Whether nothing is there but what is behind."""
        return isinstance(self.alpha, Const) and self.alpha.value == 0 and self.is_dark()

    def is_like(self, other):
        """Whether the other one has the same normals and the same of all that is not mixed."""
        normals = [s.normal and (s.normal[0].key(), s.normal[1]) for s in (self, other)]
        return normals[0] == normals[1] and self.others == other.others and self.thin_walled == other.thin_walled

    def is_dark(self):
        """Whether it emits nothing."""
        return isinstance(self.emission, Const) and not self.emission.value.any()


class Reader:
    """Reads one material's tree."""

    def __init__(self, walker):
        self.walker = walker
        self.evaluator = nodes.Evaluator(walker, self.texture)
        self.findings = []
        # Those of them that hold for the node tree as well as for the surface that is made of it.
        self.lasting = []
        # The graph_write.GridReads of what is filled by grids.
        self.grids = None
        # What fills the meshes, as SUNDOG_material has it.
        self.volume = None

    def note(self, verdict, detail, effect=None):
        """Adds a finding once."""
        finding = Finding(verdict, detail, effect)
        if finding not in self.findings:
            self.findings.append(finding)

    def note_lasting(self, verdict, detail, effect=None):
        """Adds a finding that no exact node tree would mend."""
        self.note(verdict, detail, effect)
        self.lasting.append(Finding(verdict, detail, effect))

    def read(self, material):
        """The surface of a material."""
        self.walker.met_invalid = False
        self.walker.met_absent = set()
        surface = self._read(material)
        if self.walker.met_invalid:
            self.note_lasting(APPROXIMATED, nodes.CUT)
        for words in self.evaluator.not_finite:
            self.note_lasting(APPROXIMATED, words)
        for label in sorted(self.walker.met_absent):
            self.note_lasting(EXACT, nodes.not_in_cycles(label))
        return surface

    def _read(self, material):
        tree = nodes.tree_of(material)
        if tree is None:
            return Surface(base_color=Const(list(material.diffuse_color)[:3]))
        output = nodes.output_of(material)
        if output is None:
            if inlining.ends_in_a_group(tree):
                self.note_lasting(LOST, "an output inside of a group is left out: black is rendered")
            # Nothing is black.
            return Surface()
        # A light's output has a surface alone.
        if "Volume" in output.inputs:
            self.volume = volumes.read(self, nodes.Place(output.inputs["Volume"]))
            if self._is_linked(nodes.Place(output.inputs["Displacement"])):
                self.note(LOST, "displacement is left out")
        place = nodes.Place(output.inputs["Surface"])
        source = self.walker.source(place)
        # Volumes' shaders are nothing here.
        surface = None if source.node.type in nodes.VOLUMES else self._simple(source) or self.surface(place)
        if surface is None:
            # Without a surface shader the body is black, if nothing fills it.
            return Surface(alpha=ZERO) if self.walker.is_only_filled(output) else Surface()
        return surface

    def _simple(self, source):
        """The surface of a shader of one lobe whose inputs are the same everywhere; None for all others."""
        node = source.node
        if not source.socket.is_output or node.type not in SIMPLE:
            return None
        kind, sockets = SIMPLE[node.type]
        distribution = getattr(node, "distribution", "GGX")
        if kind == "metallic" and node.fresnel_type != "F82":
            kind, sockets = "conductor", ("IOR", "Extinction", "Roughness")
        elif kind == "toon":
            kind = "diffuse-toon" if node.component == "DIFFUSE" else "glossy-toon"
        plain = distribution in {"GGX", "MULTI_GGX", "MICROFIBER"}
        for name in ("Anisotropy", "Thin Film Thickness"):
            plain = plain and (source.input(name) is None or self._is_const(self._scalar(source, name), 0))
        colored = {name for name in sockets if source.input(name).socket.type in {"RGBA", "VECTOR"}}
        values = {name: self._color(source, name) if name in colored else self._scalar(source, name) for name in sockets}
        if not plain or not all(isinstance(v, Const) for v in values.values()):
            return None
        inputs = {n: [float(c) for c in v.value] if n in colored else float(v.value) for n, v in values.items()}
        shown, thin = WHITE if kind == "conductor" else values[sockets[0]], {}
        if kind in {"glass", "refraction"}:
            # Each passage multiplies with the root of the base colour.
            thin = {"transmission": ONE, "ior": values["IOR"], "specular_tint": shown}
            shown = multiply(shown, shown)
        found = {"type": kind, "multiscatter": distribution == "MULTI_GGX", "inputs": inputs}
        return Surface(base_color=shown, normal=self._normal(source), others={"bsdf": found}, **thin)

    def _is_linked(self, place):
        return self.walker.source(place).socket.is_output

    # Shaders

    def surface(self, place):
        """The surface at a shader input; None if nothing is linked."""
        source = self.walker.source(place)
        if not nodes.is_fed(source.socket):
            return None
        node = source.node
        if node.type in nodes.HOLLOW:
            # A group without a tree, as of a library that is missing: black, as in Cycles.
            return Surface()
        if source.socket.type != "SHADER":
            # A colour in a shader's place is an emission of that colour.
            return Surface(emission=self.evaluator.color(place))
        method = getattr(self, f"_shader_{node.type.lower()}", None)
        if method is None:
            self.note(LOST, f"{node.bl_label} is rendered as a grey diffuse surface")
            return Surface(base_color=Const(numpy.full(3, 0.8)))
        return method(source)

    def _color(self, source, name, otherwise=WHITE):
        place = source.input(name)
        return otherwise if place is None else self.evaluator.color(place)

    def _scalar(self, source, name, otherwise=ZERO):
        place = source.input(name)
        return otherwise if place is None else self.evaluator.scalar(place)

    def _number(self, source, name, otherwise=0.0):
        """A number for what the program does not render: the mean if it varies."""
        value = self._scalar(source, name, Const(otherwise))
        return float(value.value) if isinstance(value, Const) else 0.5

    def _normal(self, source, name="Normal"):
        place = source.input(name)
        if place is None:
            return None
        found = self.walker.source(place)
        for _ in range(8):
            if not found.socket.is_output:
                return None
            kind = found.node.type
            if kind == "NORMAL_MAP":
                return self._normal_map(found)
            if kind == "BUMP":
                self.note(LOST, "the bump map is left out")
                found = self.walker.source(found.input("Normal"))
                continue
            if kind == "NEW_GEOMETRY" and found.socket.name == "Normal":
                return None
            break
        self.note(LOST, f"the normals of a {found.node.bl_label} node are left out")
        return None

    def _normal_map(self, found):
        node = found.node
        if node.space != "TANGENT":
            self.note(LOST, "a normal map in another space than the tangents' is left out")
            return None
        color, strength = self._color(found, "Color"), self._scalar(found, "Strength", ONE)
        if isinstance(strength, Const):
            strength = float(strength.value)
        else:
            self.note(APPROXIMATED, "the normal map's strength varies: 1 is used")
            strength = 1.0
        used = [leaf for leaf in color.leaves() if isinstance(leaf, Image)]
        if not used:
            # Half a step of eight bits about the normal of the surface itself.
            flat = isinstance(color, Const) and numpy.abs(color.value - [0.5, 0.5, 1.0]).max() <= 0.5 / 255 + 1e-7
            if not flat and strength != 0:
                fed = "one colour" if isinstance(color, Const) else "something else than an image"
                self.note(LOST, f"a Normal Map node fed by {fed} is left out")
            return None
        if getattr(node, "convention", "OPENGL") == "DIRECTX":
            color = expressions.operation("DirectX normals", lambda c: c * [1, -1, 1] + [0, 1, 0], [color], True)
        if node.uv_map and any((leaf.texture.uv or node.uv_map) != node.uv_map for leaf in used):
            self.note(APPROXIMATED, "the normal map's tangents follow the image's own UV map")
        return color, strength

    def _shader_bsdf_principled(self, source):
        others = self._diffuse_roughness(source, "Diffuse Roughness")
        if (weight := self._number(source, "Subsurface Weight")) != 0:
            radius = self._color(source, "Subsurface Radius")
            others["subsurface"] = {
                "weight": weight,
                "scale": self._number(source, "Subsurface Scale"),
                "radius": radius.value.tolist() if isinstance(radius, Const) else [1, 1, 1],
            }
        others.update(self._layer(source, "Sheen", ("Weight", "Roughness")))
        others.update(self._layer(source, "Coat", ("Weight", "Roughness", "IOR")))
        if "coat" in others and self._has_own_normal(source):
            self.note(APPROXIMATED, "the coat has the normals of what it lies on instead of its own", "coat")
        others.update(self._anisotropy(source, "Anisotropic", "Anisotropic Rotation"))
        if self._number(source, "Transmission Dispersion Scale") != 0:
            self.note(LOST, "an index of refraction that depends on the wavelength is rendered as one that does not", "dispersion")
        others.update(self._thin_film(source))
        emission = multiply(self._scalar(source, "Emission Strength"), self._color(source, "Emission Color"))
        metallic, transmission, roughness = (self._scalar(source, n) for n in ("Metallic", "Transmission Weight", "Roughness"))
        if source.node.distribution == "GGX":
            # In Cycles, a room of grey walls is darker by it by 4 % at a roughness of 0.5, a dark surface by 1.5 %, rough metal by half.
            if not (isinstance(roughness, Const) and roughness.value <= 0.2):
                self.note(APPROXIMATED, "GGX is rendered with multiple scattering")
        return Surface(
            base_color=self._color(source, "Base Color"),
            metallic=metallic,
            roughness=roughness,
            ior=self._scalar(source, "IOR", Const(1.5)),
            specular_level=self._scalar(source, "Specular IOR Level", Const(0.5)),
            specular_tint=self._color(source, "Specular Tint"),
            transmission=transmission,
            alpha=self._scalar(source, "Alpha", ONE),
            emission=emission,
            normal=self._normal(source),
            others=others,
            thin_walled=self._thin_wall(source),
        )

    def _layer(self, source, name, numbers):
        """A layer over the base of a Principled BSDF: {} where it is not there, otherwise its numbers and its tint."""
        values = {n.lower(): self._scalar(source, f"{name} {n}", Const(1.5 if n == "IOR" else 0.0)) for n in numbers}
        weight = values["weight"]
        if isinstance(weight, Const) and weight.value <= 0:
            return {}
        tint = self._color(source, f"{name} Tint")
        if not all(isinstance(v, Const) for v in (tint, *values.values())):
            self.note(APPROXIMATED, f"an input of the {name.lower()} varies: 0.5 is used for numbers, white for the tint", name.lower())
        found = {key: float(v.value) if isinstance(v, Const) else 0.5 for key, v in values.items()}
        if isinstance(values.get("ior"), expressions.Expression) and not isinstance(values["ior"], Const):
            found["ior"] = 1.5
        return {name.lower(): {**found, **self._tint(source, f"{name} Tint")}}

    def _has_own_normal(self, source):
        """Whether a coat has other normals than what it lies on."""
        coat, base = (source.input(name) for name in ("Coat Normal", "Normal"))
        if coat is None:
            return False
        coat, base = self.walker.source(coat), self.walker.source(base)
        return coat.socket.is_output and coat.socket != base.socket

    def _diffuse_roughness(self, source, name):
        value = self._scalar(source, name)
        if isinstance(value, Const):
            return {"diffuse_roughness": min(max(float(value.value), 0.0), 1.0)} if value.value > 0 else {}
        self.note(APPROXIMATED, "the roughness of a diffuse reflection varies: 0.5 is used", "diffuse-roughness")
        return {"diffuse_roughness": 0.5}

    def _thin_wall(self, source):
        """Principled's Thin Wall of Blender 5.2: light goes through a sheet, without being bent."""
        value = self._number(source, "Thin Wall")
        if value and self._number(source, "Transmission Weight") != 0:
            self.note(APPROXIMATED, "a thin wall is rendered as a sheet without reflections between its sides")
        return bool(value)

    def _thin_film(self, source):
        thickness = self._number(source, "Thin Film Thickness")
        return {"thin_film": {"thickness": thickness, "ior": self._number(source, "Thin Film IOR", 1.33)}} if thickness else {}

    def _anisotropy(self, source, strength="Anisotropy", rotation="Rotation"):
        strength, rotation = self._scalar(source, strength), self._scalar(source, rotation)
        if isinstance(strength, Const) and strength.value == 0:
            return {}
        if not (isinstance(strength, Const) and isinstance(rotation, Const)):
            self.note(APPROXIMATED, "the anisotropy or its rotation varies: 0.5 is used where it does", "anisotropy")
        numbers = [float(v.value) if isinstance(v, Const) else 0.5 for v in (strength, rotation)]
        return {"anisotropy": {"strength": numbers[0], "rotation": numbers[1], **self._tangent(source)}}

    def _tangent(self, source):
        """What the tangent of a shader follows: without a link the mesh's Z axis."""
        place = source.input("Tangent")
        found = self.walker.source(place) if place is not None else None
        if found is None or not found.socket.is_output:
            return {}
        node = found.node
        if node.type == "TANGENT" and node.direction_type == "UV_MAP":
            return {"tangent": "uv", "uv_map": node.uv_map or None}
        if not (node.type == "TANGENT" and node.axis == "Z"):
            axis = f"about the {node.axis} axis" if node.type == "TANGENT" else f"by a {node.bl_label} node"
            self.note(APPROXIMATED, f"the tangent {axis} is rendered as the one about the Z axis", "anisotropy")
        return {}

    def _tint(self, source, name):
        value = self._color(source, name)
        return {"tint": value.value.tolist()} if isinstance(value, Const) else {}

    def _shader_bsdf_diffuse(self, source):
        # A Principled BSDF of index 1 has no reflection: the diffuse part alone.
        return Surface(
            base_color=self._color(source, "Color"),
            normal=self._normal(source),
            others=self._diffuse_roughness(source, "Roughness"),
        )

    def _shader_bsdf_glossy(self, source):
        distribution = {"GGX": "ggx", "MULTI_GGX": "multiscatter-ggx"}.get(getattr(source.node, "distribution", ""))
        others = self._anisotropy(source)
        if distribution:
            # Facets of one colour at all angles; for other readers of glTF it is a metal, whose edges are white.
            return Surface(
                base_color=self._color(source, "Color"),
                metallic=ONE,
                roughness=self._scalar(source, "Roughness"),
                normal=self._normal(source),
                others={**others, "glossy": distribution},
            )
        return self._as_metal(
            Surface(
                base_color=self._color(source, "Color"),
                metallic=ONE,
                roughness=self._glossy_roughness(source),
                normal=self._normal(source),
                others=others,
            )
        )

    def _as_metal(self, surface):
        """A surface without a Glossy BSDF: a metal of its colour stands for it."""
        others = {k: v for k, v in surface.others.items() if k != "glossy"}
        color = surface.base_color
        if not (isinstance(color, Const) and numpy.allclose(color.value, 1)):
            self.note(APPROXIMATED, "a Glossy BSDF is rendered as a metal of its colour, whose edges are white")
        return surface.copy(others=others)

    def _glossy_roughness(self, source):
        distribution = getattr(source.node, "distribution", "")
        if distribution not in {"", "GGX", "MULTI_GGX"}:
            self.note(APPROXIMATED, f"the distribution {distribution.title()} is rendered as multiple-scattering GGX")
        elif distribution == "GGX":
            self.note(APPROXIMATED, "GGX is rendered with multiple scattering")
        return self._scalar(source, "Roughness")

    _shader_bsdf_anisotropic = _shader_bsdf_glossy

    def _shader_bsdf_metallic(self, source):
        others = {**self._anisotropy(source), **self._thin_film(source)}
        if source.node.fresnel_type != "F82":
            self.note(APPROXIMATED, "a metal by its physical conductor values is rendered with its colour of reflection")
            n, k = self._color(source, "IOR").value, self._color(source, "Extinction").value
            base = ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2)
            return Surface(base_color=Const(base), metallic=ONE, roughness=self._glossy_roughness(source), normal=self._normal(source), others=others)
        return Surface(
            base_color=self._color(source, "Base Color"),
            specular_tint=self._color(source, "Edge Tint"),
            metallic=ONE,
            roughness=self._glossy_roughness(source),
            normal=self._normal(source),
            others=others,
        )

    def _shader_bsdf_glass(self, source):
        if self._number(source, "Anisotropy") != 0:
            self.note(LOST, "the anisotropy of a Glass BSDF is left out", "anisotropy")
        color = self._color(source, "Color")
        if not (isinstance(color, Const) and numpy.allclose(color.value, 1)):
            # A Principled BSDF tints each passage by the square root of its colour, and reflections by the specular tint; but
            # those at grazing angles and from inside it leaves white.
            self.note(APPROXIMATED, "a Glass BSDF's colour does not tint its reflections at grazing angles and from inside")
        return Surface(
            base_color=multiply(color, color),
            specular_tint=color,
            transmission=ONE,
            ior=self._scalar(source, "IOR", Const(1.5)),
            roughness=self._glossy_roughness(source),
            normal=self._normal(source),
            others=self._thin_film(source),
        )

    def _shader_bsdf_refraction(self, source):
        self.note(APPROXIMATED, "a Refraction BSDF is rendered as glass, with its reflections")
        color = self._color(source, "Color")
        return Surface(
            base_color=multiply(color, color),
            transmission=ONE,
            ior=self._scalar(source, "IOR", Const(1.5)),
            roughness=self._scalar(source, "Roughness"),
            normal=self._normal(source),
        )

    def _shader_bsdf_transparent(self, source):
        color = self._color(source, "Color")
        if isinstance(color, Const):
            if max(color.value) > 1:
                self.note(APPROXIMATED, "a Transparent BSDF of a colour above 1 passes all light and adds none")
            passes = [min(max(float(v), 0.0), 1.0) for v in color.value]
            return Surface(alpha=ZERO, others={} if passes == [1.0, 1.0, 1.0] else {"transparent_color": passes})
        self.note(APPROXIMATED, "a coloured Transparent BSDF lets all colours through alike")
        return Surface(alpha=expressions.operation("invert", lambda v: 1 - numpy.clip(v, 0, 1), [as_scalar(color)], False))

    def _shader_emission(self, source):
        return Surface(emission=multiply(self._scalar(source, "Strength"), self._color(source, "Color")))

    # As Cycles has it (seen in 4.5.15).
    _shader_background = _shader_emission

    def _diffuse_instead(self, source, what, effect=None):
        self.note(LOST, f"{what} is rendered as a diffuse surface of its colour", effect)
        return Surface(base_color=self._color(source, "Color"), normal=self._normal(source))

    def _shader_subsurface_scattering(self, source):
        return self._diffuse_instead(source, "subsurface scattering", "subsurface")

    def _shader_bsdf_translucent(self, source):
        return self._diffuse_instead(source, "a Translucent BSDF", "diffuse-transmission")

    def _shader_bsdf_toon(self, source):
        return self._diffuse_instead(source, "a Toon BSDF")

    def _shader_bsdf_sheen(self, source):
        return self._diffuse_instead(source, "a Sheen BSDF", "sheen")

    def _shader_bsdf_hair(self, source):
        return self._diffuse_instead(source, "a Hair BSDF", "hair-shaders")

    def _shader_bsdf_hair_principled(self, source):
        self.note(LOST, "a Principled Hair BSDF is rendered as a diffuse surface", "hair-shaders")
        # What melanin or absorption make of it only the node tree tells.
        color = self._color(source, "Color") if source.node.parametrization == "COLOR" else Const(numpy.full(3, 0.2))
        return Surface(base_color=color)

    def _shader_holdout(self, source):
        self.note(LOST, "a Holdout shader is rendered black")
        return Surface()

    def _shader_ambient_occlusion(self, source):
        return self._diffuse_instead(source, "Ambient Occlusion")

    def _shader_mix_shader(self, source):
        shaders = [nodes.Place(s, source.groups) for s in source.node.inputs if s.type == "SHADER"]
        factor = self._scalar(source, source.node.inputs[0].name)
        if isinstance(factor, Const):
            factor = Const(min(max(float(factor.value), 0.0), 1.0))
        if self._camera_decides(source):
            rest, seen = (self.surface(s) for s in shaders)
            if (rest is None or rest.is_transparent()) and seen is not None and self._is_pure_emission(seen):
                # What glTF calls unlit, as Blender's importer of it builds it.
                self.note(APPROXIMATED, "an emission that the camera alone sees is seen by all rays")
                return seen
        if self._is_light_path(source):
            # The first is what camera and light meet where the factor is 0.
            self.note(APPROXIMATED, "a mix by Light Path is rendered with the shader of its value 0 for all rays")
            factor = ZERO
        first, second = (self.surface(s) if not (isinstance(factor, Const) and factor.value == skip) else None for s, skip in zip(shaders, (1.0, 0.0)))
        if isinstance(factor, Const) and float(factor.value) in {0.0, 1.0}:
            return first if factor.value == 0 else second
        if first is None or second is None:
            self.note(APPROXIMATED, "a mix with nothing is rendered as one with a black surface")
        first, second = first or Surface(), second or Surface()
        return self._mixed(first, second, factor)

    def _camera_decides(self, source):
        found = self.walker.source(nodes.Place(source.node.inputs[0], source.groups))
        return found.socket.is_output and found.node.type == "LIGHT_PATH" and found.socket.name == "Is Camera Ray"

    def _is_light_path(self, source):
        place = nodes.Place(source.node.inputs[0], source.groups)
        for _ in range(4):
            found = self.walker.source(place)
            if not found.socket.is_output:
                return False
            if found.node.type == "LIGHT_PATH":
                return True
            linked = [s for s in found.node.inputs if self._is_linked(nodes.Place(s, found.groups))]
            if found.node.type != "MATH" or not linked:
                return False
            place = nodes.Place(linked[0], found.groups)
        return False

    def _mixed(self, first, second, factor):
        inverse = expressions.operation("invert", lambda v: 1 - v, [factor], False)
        if first.is_transparent() and self._fits(first, second):
            return second.copy(alpha=multiply(second.alpha, factor), others={**second.others, **first.others})
        if second.is_transparent() and self._fits(second, first):
            return first.copy(alpha=multiply(first.alpha, inverse), others={**first.others, **second.others})
        first, second = (self._as_metal(s) if "glossy" in s.others else s for s in (first, second))
        if self._is_pure_emission(first) or self._is_pure_emission(second):
            emitter, other, share = (first, second, inverse) if self._is_pure_emission(first) else (second, first, factor)
            rest = factor if emitter is first else inverse
            emission = expressions.operation(
                "add", lambda a, b: a + b, [multiply(as_color(share), emitter.emission), multiply(as_color(rest), other.emission)], True
            )
            if other.is_dark() and isinstance(factor, Const) and self._is_plain_diffuse(other):
                return other.copy(base_color=multiply(as_color(rest), other.base_color), emission=emission)
            if self._is_pure_emission(other):
                return other.copy(emission=emission)
            self.note(APPROXIMATED, "a mix with an emission keeps the whole highlight")
            return other.copy(base_color=multiply(as_color(rest), other.base_color), emission=emission)
        varying = [n for n in (*Surface.COLORS, *Surface.SCALARS) if getattr(first, n).key() != getattr(second, n).key()]
        linear = self._is_plain_diffuse(first) and self._is_plain_diffuse(second)
        if not first.is_like(second) or (varying and not (linear and varying == ["base_color"])):
            gloss = next((s for s in (first, second) if self._is_const(s.metallic, 1)), None)
            base = first if gloss is second else second
            if gloss and self._is_plain_diffuse(base) and any(isinstance(l, Unknown) for l in factor.leaves()):
                # Diffuse under a gloss that grows to the edges: what Principled's specular is.
                self.note(APPROXIMATED, "a mix of diffuse and gloss by view angle is rendered as one Principled BSDF of index 1.45")
                return base.copy(ior=Const(1.45), roughness=gloss.roughness, normal=base.normal or gloss.normal)
            self.note(APPROXIMATED, "a mix of two shaders is rendered as one with their inputs mixed")
        return first.blend(second, factor)

    @staticmethod
    def _fits(clear, other):
        """Whether what passes straight on has one colour in a mix with something transparent."""
        colors = [s.others.get("transparent_color", [1.0, 1.0, 1.0]) for s in (clear, other)]
        return colors[0] == colors[1] or (isinstance(other.alpha, Const) and other.alpha.value >= 1)

    @staticmethod
    def _is_const(value, number):
        return isinstance(value, Const) and numpy.all(value.value == number)

    def _is_plain_diffuse(self, surface):
        return (
            self._is_const(surface.metallic, 0)
            and self._is_const(surface.transmission, 0)
            and self._is_const(surface.ior, 1)
            and self._is_const(surface.alpha, 1)
            # What is rough is no line in its colour; layers and other shaders are more than a colour.
            and not surface.others
        )

    def _is_pure_emission(self, surface):
        return self._is_plain_diffuse(surface) and self._is_const(surface.base_color, 0) and not surface.is_dark()

    def _shader_add_shader(self, source):
        first, second = (self.surface(nodes.Place(s, source.groups)) for s in source.node.inputs)
        if first is None or second is None:
            return first or second
        first, second = (self._as_metal(s) if "glossy" in s.others else s for s in (first, second))
        if self._is_pure_emission(first):
            return self._glowing(second, first.emission)
        if self._is_pure_emission(second):
            return self._glowing(first, second.emission)
        emission = self._sum(first.emission, second.emission)
        if self._is_plain_diffuse(first) and self._is_plain_diffuse(second) and first.is_like(second):
            base = expressions.operation("add", lambda a, b: a + b, [first.base_color, second.base_color], True)
            return first.copy(base_color=base, emission=emission)
        self.note(APPROXIMATED, "a sum of two shaders is rendered as one with their inputs averaged")
        return first.blend(second, Const(0.5)).copy(emission=emission)

    @staticmethod
    def _sum(first, second):
        return expressions.operation("add", lambda a, b: a + b, [first, second], True)

    def _glowing(self, surface, emission):
        """A surface that emits so much more, whatever its opacity (by which glTF's emission is multiplied)."""
        alpha = surface.alpha
        if surface.others.keys() & {"coat", "sheen"}:
            self.note(APPROXIMATED, "an emission added to layers shines through them")
        if isinstance(alpha, Const) and alpha.value < LEAST_ALPHA:
            self.note(APPROXIMATED, "an emission added to transparency hides a 16th of what is behind it")
            alpha = Const(LEAST_ALPHA)
        if not isinstance(alpha, Const):
            self.note(APPROXIMATED, "an emission added to a surface of varying opacity is as opaque as that")
        elif alpha.value < 1:
            emission = multiply(Const(1 / alpha.value), emission)
        return surface.copy(alpha=alpha, emission=self._sum(surface.emission, emission))

    # Textures

    def texture(self, node, place):
        """The TextureSpec of an image node; a Const where the image is missing."""
        image = images.picture_of(node.image, node.image_user)
        if images.is_missing(image):
            self.note_lasting(EXACT, f"the image \"{image.name}\" is missing or broken ({image.filepath_raw}): pink, as in Cycles")
            return images.MISSING
        if image.source == "TILED":
            self.note(APPROXIMATED, f"of the UDIM image \"{image.name}\" the first tile is used")
        elif image.source in {"SEQUENCE", "MOVIE"}:
            self.note(APPROXIMATED, f"the {image.source.lower()} \"{image.name}\" stands still: the picture that Blender has loaded is used")
        if node.projection != "FLAT":
            self.note(APPROXIMATED, f"the {node.projection.lower()} projection of \"{image.name}\" is rendered by UV map")
        if node.interpolation in {"Cubic", "Smart"}:
            self.note(APPROXIMATED, "cubic interpolation of images is rendered as linear")
        if not images.is_exactly_known(image):
            self.note(APPROXIMATED, f"the colour space {image.colorspace_settings.name} of \"{image.name}\" is read as sRGB")
        wrap = {"EXTEND": 33071, "CLIP": 33071, "MIRROR": 33648}.get(node.extension, 10497)
        if node.extension == "CLIP":
            self.note(APPROXIMATED, f"outside of \"{image.name}\" its border is repeated instead of black")
        if not evaluated.is_plain(node.texture_mapping):
            self.note(APPROXIMATED, f"the texture mapping of \"{image.name}\" from an old file is left out")
        uv, transform, own = self._coordinates(place.input("Vector"))
        # Coordinates that are wrapped before the image sees them; the image's own way is left for the others.
        wraps = [one or wrap for one in own]
        alpha = node.outputs["Alpha"].is_linked
        if image.alpha_mode == "PREMUL" and not images.holds_floats(image) and images.may_have_alpha(image):
            self.note(APPROXIMATED, f"the alpha of \"{image.name}\" is taken as straight instead of premultiplied")
        if bpy.app.version >= (5, 1, 0) and image.alpha_mode == "STRAIGHT" and images.holds_floats(image) and images.multiplies(image):
            self.note(APPROXIMATED, f"the colours of \"{image.name}\" are taken as multiplied by its alpha already")
        # Where a node asks for the alpha, Cycles takes it out of the colours again, but only after interpolating them with it.
        weighted = alpha and images.has_straight_alpha(image)
        multiplied = not alpha and images.multiplies(image)
        return TextureSpec(image, uv, transform, wraps, node.interpolation == "Closest", multiplied, weighted)

    def _coordinates(self, place):
        """(UV map, KHR_texture_transform, the ways that each direction is wrapped by nodes) of an image's vector."""
        source, wraps = self._wraps(self.walker.source(place))
        uv, transform = self._placed(source)
        return uv, transform, wraps

    def _wraps(self, source):
        """Takes coordinates apart that Blender's glTF importer wraps in each direction for itself."""
        nothing = source, (None, None)
        if not source.socket.is_output or source.node.type != "COMBXYZ":
            return nothing
        wraps, below = [], []
        for name in ("X", "Y"):
            part, wrap = self.walker.source(source.input(name)), None
            if part.socket.is_output and part.node.type == "MATH":
                values = [self.evaluator.scalar(part.identified(i)) for i in ("Value_001", "Value_002")]
                settings = [float(v.value) if isinstance(v, Const) else None for v in values]
                kind = part.node.operation
                # WRAP has its upper bound and then its lower one; the importer gives them the other way round, which is the same.
                if kind == "WRAP" and sorted(v or 0.0 for v in settings) == [0.0, 1.0]:
                    wrap = 10497
                elif kind == "PINGPONG" and settings[0] == 1:
                    wrap = 33648
                else:
                    return nothing
                part = self.walker.source(part.identified("Value"))
            if not (part.socket.is_output and part.node.type == "SEPXYZ" and part.socket.name == name):
                return nothing
            wraps.append(wrap)
            below.append(self.walker.source(part.input("Vector")))
        same = below[0].socket == below[1].socket and below[0].groups == below[1].groups
        return (below[0], wraps) if same else nothing

    def _placed(self, source):
        transform = None
        if source.socket.is_output and source.node.type == "MAPPING":
            transform = self._mapping(source)
            source = self.walker.source(source.input("Vector"))
            if not source.socket.is_output:
                self.note(APPROXIMATED, "a Mapping node without coordinates is rendered with the UV map")
        if not source.socket.is_output:
            return None, transform
        node, name = source.node, source.socket.name
        if node.type == "UVMAP" and not getattr(node, "from_instancer", False):
            return node.uv_map or None, transform
        if node.type == "TEX_COORD" and name == "UV" and not node.from_instancer:
            return None, transform
        if node.type == "ATTRIBUTE" and node.attribute_type == "GEOMETRY" and name in {"Vector", "Color"}:
            return node.attribute_name or None, transform
        self.note(APPROXIMATED, f"image coordinates by {node.bl_label} ({name}) are replaced by the UV map")
        return None, transform

    def _mapping(self, source):
        """KHR_texture_transform of a Mapping node, or None for none."""
        node = source.node
        def vector(name):
            place = source.input(name)
            return Const(numpy.zeros(3)) if place is None else self.evaluator.color(place)
        location, rotation, scale = vector("Location"), vector("Rotation"), vector("Scale")
        if not all(isinstance(v, Const) for v in (location, rotation, scale)):
            self.note(APPROXIMATED, "a Mapping node with varying inputs is left out")
            return None
        (ox, oy), angle, (sx, sy) = location.value[:2], float(rotation.value[2]), scale.value[:2]
        if rotation.value[0] or rotation.value[1]:
            self.note(APPROXIMATED, "a Mapping node turned about X or Y is rendered with its Z rotation only")
        if node.vector_type == "TEXTURE":
            # p' = S⁻¹ R⁻¹ (p - o); of the form that glTF has only if R and S commute.
            if angle and abs(sx - sy) > 1e-6:
                self.note(APPROXIMATED, "a Mapping node of type Texture with rotation and uneven scale")
            sx, sy = 1 / (sx or 1), 1 / (sy or 1)
            c, s = math.cos(-angle), math.sin(-angle)
            ox, oy = -sx * (c * ox - s * oy), -sy * (s * ox + c * oy)
            angle = -angle
        elif node.vector_type in {"VECTOR", "NORMAL"}:
            ox = oy = 0.0
            if node.vector_type == "NORMAL":
                self.note(APPROXIMATED, "a Mapping node of type Normal")
        c, s = math.cos(angle), math.sin(angle)
        # glTF's v runs the other way: v = 1 - v of Blender.
        offset = [float(ox - s * sy), float(1 - oy - c * sy)]
        if abs(offset[0]) < 1e-12 and abs(offset[1]) < 1e-12 and not angle and sx == sy == 1:
            return None
        return {"offset": offset, "rotation": angle, "scale": [float(sx), float(sy)]}
