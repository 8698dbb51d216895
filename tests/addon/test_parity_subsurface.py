# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that goes on below surfaces, beside Cycles: heads and balls by both programs, from one scene."""

import itertools
import unittest

import bpy
import export_kit as kit
import test_parity_lobes as lobes
from test_parity_lobes import BLUE, GOLD, RED, Shaders

DARK, SKIN, MILK = (0.2, 0.1, 0.05, 1), (0.9, 0.6, 0.45, 1), (0.98, 0.95, 0.9, 1)


class Subsurface(lobes.Beside):
    """What both programs show."""

    SAMPLES = 384

    def scattering(self, shaders, name, method="RANDOM_WALK", properties=None, **inputs):
        """A Principled BSDF that is all below its surface."""
        inputs = {"Subsurface_Weight": 1.0, "Base_Color": SKIN, "Roughness": 0.5, **inputs}
        shaders.alone(name, "BsdfPrincipled", {"subsurface_method": method, **(properties or {})}, **inputs)

    def compare_radii_and_colours(self, pairs):
        s = Shaders()
        for scale, color in pairs:
            self.scattering(s, f"{scale} {color[0]}", Subsurface_Scale=scale, Base_Color=color)
        self.compare(s)

    def test_some_radii_and_colours(self):
        """A thin skin of a dark colour, a usual one, and deep milk."""
        self.compare_radii_and_colours(((0.001, DARK), (0.05, SKIN), (0.3, MILK)))

    @kit.long
    def test_radii_and_colours(self):
        """Four radii by three albedos."""
        self.compare_radii_and_colours(itertools.product((0.001, 0.01, 0.05, 0.3), (DARK, SKIN, MILK)))

    @kit.long
    def test_methods_and_entries(self):
        """Each method, with indices, roughnesses and anisotropies."""
        s = Shaders()
        known = bpy.types.ShaderNodeBsdfPrincipled.bl_rna.properties["subsurface_method"].enum_items
        for method in known.keys():
            # Profiles know no anisotropy.
            for anisotropy in (0.0,) if method == "BURLEY" else (0.0, 0.6):
                self.scattering(s, f"{method} {anisotropy}", method, Subsurface_Anisotropy=anisotropy, Subsurface_Scale=0.05)
        for ior in (1.05, 2.0):
            self.scattering(s, f"index {ior}", Subsurface_Scale=0.1, IOR=ior)
        for roughness in (0.0, 1.0):
            self.scattering(s, f"roughness {roughness}", Subsurface_Scale=0.1, Roughness=roughness)
        self.scattering(s, "skin of 1.8", "RANDOM_WALK_SKIN", Subsurface_Scale=0.1, Subsurface_IOR=1.8)
        self.scattering(s, "half", Subsurface_Weight=0.5, Subsurface_Scale=0.1, Base_Color=BLUE)
        self.scattering(s, "without red", Subsurface_Radius=(0, 1, 1), Subsurface_Scale=0.1)
        self.scattering(s, "by noise", Subsurface_Scale=0.05, Base_Color="TexNoise")
        self.scattering(s, "radius by noise", Subsurface_Scale=0.2, Subsurface_Radius="TexNoise")
        self.scattering(s, "coated", Subsurface_Scale=0.1, Coat_Weight=1.0, Coat_Tint=GOLD)
        for roughness in (0.3, 1.0):
            s.alone(f"node {roughness}", "SubsurfaceScattering", Color=RED, Scale=0.1, Roughness=roughness)
        s.alone("backward node", "SubsurfaceScattering", Color=RED, Scale=0.1, Anisotropy=-0.5)
        self.compare(s)

    def place(self, materials, suns):
        """Heads in the place of balls, if it is asked for."""
        size = super().place(materials, suns)
        for made in [o for o in self.scene.objects if o.type == "MESH"] if self.heads else ():
            place, material = made.location.copy(), made.data.materials[0]
            bpy.data.objects.remove(made)
            bpy.ops.mesh.primitive_monkey_add(size=0.8, location=place, rotation=(0.2, 0.3, 0.1))
            head = bpy.context.object
            head.modifiers.new("smooth", "SUBSURF").levels = 1
            head.data.materials.append(material)
        return size

    heads = False

    def test_heads(self):
        """A head with ears and eyes, of parts that lie in each other."""
        self.heads = True
        s = Shaders()
        for scale in (0.01, 0.05, 0.2):
            self.scattering(s, f"head {scale}", Subsurface_Scale=scale)
        self.scattering(s, "white head", Subsurface_Scale=0.1, Base_Color=(1, 1, 1, 1))
        self.compare(s)


if __name__ == "__main__":
    unittest.main()
