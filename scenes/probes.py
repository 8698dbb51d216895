# SPDX-License-Identifier: MIT OR Apache-2.0
"""Probes: small scenes that each ask one question, so that a difference from Cycles has an address.

Most are grids of balls before an orthographic camera; the means of the cells say which parameter differs.
"""

import math
import os

import numpy as np

import kit

SCENES = {}
CELL = 24  # pixels a grid cell
ROUGHNESSES = (0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0)


def probe(name, width, height):
    def note(make):
        make.size = (width, height)
        SCENES[f"probe-{name}"] = make
        return make

    return note


def grid_probe(name, columns, rows):
    """A probe whose cells are listed in NAME.json as `grid`: [columns, rows]."""

    def note(make):
        def with_grid(folder):
            cells = make()
            assert len(cells) == rows and all(len(row) == columns for row in cells)
            grid(cells)
            return {"constant": (1.0, 1.0, 1.0), "bounces": 16, "grid": [columns, rows], "view": "Standard"}

        with_grid.__doc__ = make.__doc__
        return probe(name, columns * CELL, rows * CELL)(with_grid)

    return note


def grid(cells, segments=64, rings=32):
    """One ball a cell, row 0 on top, seen along +Y."""
    rows, columns = len(cells), len(cells[0])
    for line, row in enumerate(cells):
        for column, material in enumerate(row):
            kit.sphere(
                f"Ball {line} {column}", 0.42, (column + 0.5 - columns / 2, 0.0, rows / 2 - line - 0.5), material,
                segments, rings,
            )
    kit.look_from((0.0, -10.0, 0.0), (0.0, 0.0, 0.0), orthographic_scale=max(columns, rows))


@grid_probe("furnace", 8, 3)
def furnace():
    """White metal, white glass and a white matte of eight roughnesses: all must vanish before the white world."""
    white = (1.0, 1.0, 1.0)
    return [
        [kit.principled(f"Metal {r}", base_color=white, metallic=1.0, roughness=r) for r in ROUGHNESSES],
        [kit.glass(f"Glass {r}", roughness=r) for r in ROUGHNESSES],
        [kit.principled(f"Plastic {r}", base_color=white, roughness=r, specular_ior_level=0.0) for r in ROUGHNESSES],
    ]


@grid_probe("metal", 8, 2)
def metal():
    """Copper and chrome of eight roughnesses. (Blender's edge tint has no place in glTF: it stays white.)"""
    return [
        [kit.principled(f"{name} {r}", base_color=color, metallic=1.0, roughness=r) for r in ROUGHNESSES]
        for name, color in (("Copper", (0.95, 0.55, 0.30)), ("Chrome", (0.55, 0.56, 0.55)))
    ]


@grid_probe("dielectric", 8, 4)
def dielectric():
    """The default specular layer over white, mid and black bases, and with no layer at all."""
    rows = (("White", 1.0, 0.5), ("Grey", 0.5, 0.5), ("Black", 0.0, 0.5), ("Bare", 0.8, 0.0))
    return [
        [kit.principled(f"{name} {r}", base_color=(base, base * 0.8, base * 0.6), roughness=r, specular_ior_level=level)
         for r in ROUGHNESSES]
        for name, base, level in rows
    ]


@grid_probe("ior", 6, 4)
def ior():
    """IOR against specular level and tint, over black. (Level 0.5 with no tint would lose the IOR in the file.)"""
    rows = (("Quarter", 0.25, (1, 1, 1)), ("Nearly", 0.49, (1, 1, 1)), ("More", 0.8, (1, 1, 1)), ("Tinted", 0.5, (1.0, 0.6, 0.3)))
    return [
        [kit.principled(f"{name} {n}", base_color=(0.0, 0.0, 0.0), roughness=0.2, ior=n, specular_ior_level=level, specular_tint=tint)
         for n in (1.05, 1.2, 1.33, 1.5, 1.8, 2.4)]
        for name, level, tint in rows
    ]


@grid_probe("glass", 8, 3)
def glass():
    """Solid glass of eight roughnesses: white at 1.5 and 1.33, and green."""
    rows = (("Clear", (1.0, 1.0, 1.0), 1.5), ("Water", (1.0, 1.0, 1.0), 1.33), ("Green", (0.5, 0.9, 0.6), 1.5))
    return [[kit.glass(f"{name} {r}", color, r, n) for r in ROUGHNESSES] for name, color, n in rows]


@grid_probe("mixed", 6, 3)
def mixed():
    """Between the corners: metallic, transmission, and both with a base colour."""
    parts = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)

    def transmitting(part, roughness):
        material = kit.glass(f"Transmission {part} {roughness}", (0.8, 0.5, 0.3), roughness)
        kit.shader_of(material).inputs["Transmission Weight"].default_value = part
        return material

    return [
        [kit.principled(f"Metallic {part}", base_color=(0.8, 0.5, 0.3), metallic=part, roughness=0.3) for part in parts],
        [transmitting(part, 0.0) for part in parts],
        [transmitting(part, 0.4) for part in parts],
    ]


@grid_probe("lone", 8, 1)
def lone():
    """Each of eight plain materials once, for the smallest test of all."""
    return [[
        kit.matte("Matte", (0.8, 0.8, 0.8)),
        kit.principled("Plastic", base_color=(0.2, 0.4, 0.8), roughness=0.3),
        kit.principled("Mirror", base_color=(0.9, 0.9, 0.9), metallic=1.0, roughness=0.0),
        kit.principled("Rough metal", base_color=(1.0, 0.7, 0.3), metallic=1.0, roughness=0.5),
        kit.glass("Clear glass"),
        kit.glass("Rough glass", (0.8, 0.9, 1.0), 0.4),
        kit.glowing("Glow", (1.0, 0.5, 0.2), 3.0),
        kit.principled("Half there", base_color=(0.8, 0.2, 0.2), alpha=0.5),
    ]]


def table(color=(0.7, 0.7, 0.7), half=6.0):
    kit.quad("Table", [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], kit.matte("Table", color))


@probe("spot", 96, 72)
def spot(folder):
    """Spot lights of several blends and radii, each on its own patch of a table."""
    table()
    for column, (blend, radius) in enumerate(((0.0, 0.0), (0.15, 0.0), (0.5, 0.0), (1.0, 0.0))):
        kit.spot(f"Spot {column}", ((column - 1.5) * 1.8, 1.2, 2.0), ((column - 1.5) * 1.8, 1.2, 0.0), 60.0, 40.0, blend, radius=radius)
    for column, (cone, radius) in enumerate(((50.0, 0.05), (50.0, 0.2), (110.0, 0.1), (20.0, 0.3))):
        kit.spot(f"Sized spot {column}", ((column - 1.5) * 1.8, -1.4, 2.0), ((column - 1.5) * 1.8, -0.9, 0.0), 60.0, cone, 0.3,
                 (1.0, 0.8, 0.6), radius)
    kit.look_from((0.0, -5.0, 6.0), (0.0, 0.0, 0.0), degrees=52.0)
    return {"bounces": 1, "view": "Standard"}


@probe("point", 96, 72)
def point(folder):
    """Points with no, a small and a large radius; a blocker's shadow and a mirror that shows the large one."""
    table()
    kit.lamp("POINT", "Bare", (-2.2, 0.5, 1.2), 60.0, (1.0, 0.4, 0.4), 0.0)
    kit.lamp("POINT", "Small", (0.0, 0.5, 1.2), 60.0, (0.4, 1.0, 0.4), 0.1)
    kit.lamp("POINT", "Large", (2.2, 0.5, 1.2), 60.0, (0.4, 0.4, 1.0), 0.4)
    for column in range(3):
        kit.box("Blocker", (0.4, 0.4, 0.6), ((column - 1) * 2.2 + 0.5, -0.4, 0.3), kit.matte("Blocker", (0.6, 0.6, 0.6)))
    kit.sphere("Mirror", 0.5, (1.1, -1.6, 0.5), kit.principled("Mirror", base_color=(1.0, 1.0, 1.0), metallic=1.0, roughness=0.35))
    kit.look_from((0.0, -6.0, 5.0), (0.0, -0.3, 0.2), degrees=48.0)
    # No bounces: the caustics of small lights in the mirror would drown all else in noise.
    return {"bounces": 0, "view": "Standard"}


@probe("sun", 96, 72)
def sun(folder):
    """Three suns: sharp, of 5 and of 25 degrees, with a blocker and a glossy ball."""
    table(half=8.0)
    kit.sun("Sharp", (0.5, 0.3, -0.8), 2.0, (1.0, 0.3, 0.3), 0.0)
    kit.sun("Soft", (-0.5, 0.3, -0.8), 2.0, (0.3, 1.0, 0.3), 5.0)
    kit.sun("Softest", (0.0, 0.7, -0.7), 2.0, (0.3, 0.3, 1.0), 25.0)
    kit.box("Blocker", (0.5, 0.5, 1.5), (-1.0, 0.3, 0.75), kit.matte("Blocker", (0.6, 0.6, 0.6)))
    kit.sphere("Ball", 0.7, (1.2, 0.0, 0.7), kit.principled("Glossy", base_color=(0.3, 0.3, 0.3), roughness=0.25))
    kit.look_from((0.0, -6.0, 4.0), (0.0, 0.0, 0.4), degrees=42.0)
    return {"bounces": 2, "view": "Standard"}


def compass(folder):
    """A picture in which every direction has a colour of its own, with a few small bright patches."""
    direction = kit.sky_directions(128, 64)
    pixels = 0.5 + 0.45 * direction
    for row, column, color in ((10, 20, (40, 2, 2)), (30, 64, (2, 40, 2)), (45, 100, (2, 2, 40)), (25, 0, (30, 30, 2))):
        pixels[row : row + 2, column : column + 2] = color
    kit.write_hdr(os.path.join(folder, "compass.hdr"), pixels)


@probe("environment", 96, 72)
def environment(folder):
    """Which way round the environment goes: seen straight, in a mirror, in the shadows; turned by 37 degrees."""
    compass(folder)
    kit.quad("Table", [(-1.5, -1.5, 0), (1.5, -1.5, 0), (1.5, 1.5, 0), (-1.5, 1.5, 0)], kit.matte("Table", (0.8, 0.8, 0.8)))
    kit.sphere("Mirror", 0.5, (-0.6, 0.0, 0.5), kit.principled("Mirror", base_color=(1.0, 1.0, 1.0), metallic=1.0, roughness=0.0))
    kit.sphere("Matte", 0.5, (0.6, 0.0, 0.5), kit.matte("Matte", (0.8, 0.8, 0.8)))
    kit.look_from((0.5, -3.6, 1.6), (0.0, 0.0, 0.5), degrees=60.0)
    return {"environment": "compass.hdr", "environment_strength": 1.5, "environment_rotation": 37.0, "bounces": 4, "view": "Standard"}


def camera_scene():
    """Coloured boxes from which any slip of the camera shows."""
    table(half=4.0)
    for index, (x, y, tall) in enumerate(((-1.2, 0.0, 0.8), (0.2, 0.7, 1.4), (1.3, -0.5, 0.5), (-0.3, -1.1, 0.3))):
        kit.box(f"Box {index}", (0.6, 0.5, tall), (x, y, tall / 2), kit.matte(f"Box {index}", ((1, 0.2, 0.2), (0.2, 1, 0.2), (0.2, 0.2, 1), (1, 1, 0.2))[index]), turn=20.0 * index)
    kit.sun("Sun", (0.4, 0.6, -0.8), 3.0, angle=3.0)


@probe("portrait", 60, 96)
def portrait(folder):
    """A picture taller than wide, with the sensor's fit "automatic": the angle is the taller side's."""
    camera_scene()
    kit.look_from((1.0, -4.5, 3.0), (0.0, 0.0, 0.4), degrees=58.0)
    return {"constant": (0.5, 0.7, 1.0), "bounces": 2, "view": "Standard"}


@probe("vertical-fit", 96, 60)
def vertical_fit(folder):
    """A wide picture whose camera fits its sensor by height."""
    camera_scene()
    camera = kit.look_from((1.0, -4.5, 3.0), (0.0, 0.0, 0.4), degrees=40.0)
    camera.data.sensor_fit = "VERTICAL"
    return {"constant": (0.5, 0.7, 1.0), "bounces": 2, "view": "Standard"}


@probe("orthographic", 72, 96)
def orthographic(folder):
    """An orthographic camera with a tall picture."""
    camera_scene()
    kit.look_from((1.0, -4.5, 3.0), (0.0, 0.0, 0.4), orthographic_scale=4.4)
    return {"constant": (0.5, 0.7, 1.0), "bounces": 2, "view": "Standard"}


@probe("textures", 96, 72)
def textures(folder):
    """Coarse textures seen large: filtering between texels, sRGB and data, transforms, wrapping; vertex colours."""
    dice = np.random.default_rng(3)
    coarse = dice.random((4, 4, 3))
    coarse[0, 0], coarse[0, 3], coarse[3, 0] = (1, 1, 1), (1, 0, 0), (0, 0, 0)
    color = kit.picture("coarse", coarse, folder)
    data = kit.picture("coarse-data", np.stack([0 * coarse[..., 0], 0.2 + 0.7 * coarse[..., 1], np.round(coarse[..., 2])], axis=-1), folder, color=False)
    materials = []
    for name, how in (("Plain", {}), ("Scaled", {"scale": (2.0, 3.0)}), ("Shifted", {"offset": (0.3, 0.6)}),
                      ("Turned", {"offset": (0.2, 0.1), "scale": (1.5, 1.5), "rotation": 25.0})):
        materials.append(kit.matte(name, (1, 1, 1)))
        kit.textured_color(materials[-1], kit.texture(materials[-1], color, **how))
    metallic = kit.principled("Metallic and rough", base_color=(0.9, 0.6, 0.4))
    kit.textured_metal_roughness(metallic, kit.texture(metallic, data))
    glowing = kit.matte("Glowing", (0.0, 0.0, 0.0))
    kit.textured_emission(glowing, kit.texture(glowing, color), 2.0)
    painted = kit.matte("Painted", (1, 1, 1))
    kit.vertex_colored(painted, "Paint")
    both = kit.matte("Painted texture", (1, 1, 1))
    kit.vertex_colored(both, "Paint", kit.texture(both, color))
    for index, material in enumerate(materials + [metallic, glowing, painted, both]):
        x, z = (index % 4) * 1.0 - 2.0, 1.5 - (index // 4) * 1.5 - 0.75 * 1.0
        holder = kit.quad(f"Tile {index}", [(x + 0.05, 0, z - 0.55), (x + 0.95, 0, z - 0.55), (x + 0.95, 0, z + 0.55), (x + 0.05, 0, z + 0.55)], material)
        if material in (painted, both):
            colors = holder.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
            colors.data.foreach_set("color", np.array([(1, 0.1, 0.1, 1), (0.1, 1, 0.1, 1), (0.1, 0.1, 1, 1), (1, 1, 0.2, 1)], np.float32).ravel())
    kit.look_from((0.0, -10.0, 0.0), (0.0, 0.0, 0.0), orthographic_scale=4.0)
    return {"constant": (1.0, 1.0, 1.0), "bounces": 1, "view": "Standard"}


@probe("normal-map", 96, 72)
def normal_map(folder):
    """Normal maps on flat and round, matte and shiny, at three strengths, under a sun and a coloured sky."""
    compass(folder)
    u, v = kit.texture_grid(64)
    waves = kit.picture("waves", kit.normals_from_height(np.sin(u * 12.566) + np.sin(v * 18.85), 2.5), folder, color=False)
    kinds = []
    for strength in (0.4, 1.0, 1.0):
        for metallic in (0.0, 1.0):
            material = kit.principled(f"Waves {strength} {metallic}", base_color=(0.8, 0.8, 0.8), roughness=0.3 if metallic else 1.0, metallic=metallic)
            if not metallic:
                kit.shader_of(material).inputs["Specular IOR Level"].default_value = 0.0
            kit.textured_normal(material, kit.texture(material, waves, scale=(1.0, 1.0)), strength)
            kinds.append(material)
    for index, material in enumerate(kinds):
        x, z = (index % 3) * 1.3 - 1.3, 0.65 - (index // 3) * 1.3
        if index < 4:
            kit.sphere(f"Ball {index}", 0.6, (x, 0.0, z), material)
        else:
            kit.quad(f"Tile {index}", [(x - 0.6, 0, z - 0.6), (x + 0.6, 0, z - 0.6), (x + 0.6, 0, z + 0.6), (x - 0.6, 0, z + 0.6)], material)
    kit.sun("Sun", (0.6, 0.6, -0.5), 2.0, angle=10.0)
    kit.look_from((0.0, -10.0, 0.0), (0.0, 0.0, 0.0), orthographic_scale=4.0)
    return {"environment": "compass.hdr", "bounces": 3, "view": "Standard"}


@probe("alpha", 96, 72)
def alpha(folder):
    """Blended and clipped alpha, constant and from a texture, and the shadows they throw."""
    table(half=5.0)
    u, v = kit.texture_grid(16)
    soft = np.clip(1.3 - 2.4 * np.hypot(u - 0.5, v - 0.5), 0.0, 1.0)
    image = kit.picture("soft-disc", np.stack([0.9 + 0 * u, 0.3 + 0.6 * u, 0.2 + 0.6 * v, soft], axis=-1), folder)
    half = kit.matte("Half", (0.9, 0.3, 0.2))
    kit.shader_of(half).inputs["Alpha"].default_value = 0.4
    blended = kit.matte("Blended", (1, 1, 1))
    node = kit.texture(blended, image)
    kit.textured_color(blended, node)
    blended.node_tree.links.new(node.outputs["Alpha"], kit.shader_of(blended).inputs["Alpha"])
    clipped = kit.matte("Clipped", (1, 1, 1))
    node = kit.texture(clipped, image)
    kit.textured_color(clipped, node)
    kit.clipped_alpha(clipped, node, 0.3)
    for column, material in enumerate((half, blended, clipped)):
        x = (column - 1) * 1.6
        kit.quad(f"Card {column}", [(x - 0.7, 0.2, 0.3), (x + 0.7, 0.2, 0.3), (x + 0.7, 0.5, 1.7), (x - 0.7, 0.5, 1.7)], material)
        kit.quad(f"Back card {column}", [(x - 0.5, 1.0, 0.2), (x + 0.9, 1.0, 0.2), (x + 0.9, 1.0, 1.4), (x - 0.5, 1.0, 1.4)], material)
    kit.sun("Sun", (0.3, -0.7, -0.8), 3.0, angle=4.0)
    kit.lamp("POINT", "Point", (0.0, -2.5, 1.5), 60.0, radius=0.1)
    kit.look_from((0.0, -6.0, 2.6), (0.0, 0.0, 0.7), degrees=46.0)
    return {"constant": (0.3, 0.35, 0.4), "bounces": 3, "view": "Standard"}


@probe("mesh-lights", 96, 72)
def mesh_lights(folder):
    """Mesh lights: plain, textured, scaled unevenly, seen from behind, and one in a mirror."""
    table(half=5.0)
    u, v = kit.texture_grid(16)
    stripes = kit.picture("stripes", np.stack([(np.floor(u * 8) % 2) * 0.9 + 0.05, 0.2 + 0.6 * v, 0.9 - 0.8 * u], axis=-1), folder)
    textured = kit.matte("Textured light", (0, 0, 0))
    kit.textured_emission(textured, kit.texture(textured, stripes), 8.0)
    kit.quad("Textured", [(-2.4, 1.0, 0.1), (-0.8, 1.0, 0.1), (-0.8, 1.0, 1.3), (-2.4, 1.0, 1.3)], textured)
    plain = kit.glowing("Plain light", (1.0, 0.8, 0.5), 12.0)
    bulb = kit.sphere("Stretched bulb", 0.3, (1.4, 0.6, 0.9), plain, 24, 12)
    bulb.scale = (1.6, 0.5, 0.8)
    kit.quad("From behind", [(0.0, -1.0, 1.6), (0.0, -0.2, 1.6), (0.8, -0.2, 1.6), (0.8, -1.0, 1.6)], kit.glowing("Blue light", (0.3, 0.5, 1.0), 5.0))
    kit.sphere("Mirror", 0.45, (-0.2, 0.2, 0.45), kit.principled("Mirror", base_color=(0.9, 0.9, 0.9), metallic=1.0, roughness=0.15))
    kit.box("Blocker", (0.3, 0.3, 0.7), (0.9, -0.9, 0.35), kit.matte("Blocker", (0.8, 0.8, 0.8)))
    kit.look_from((0.0, -6.0, 3.4), (0.0, 0.0, 0.5), degrees=46.0)
    return {"bounces": 4, "view": "Standard"}


@probe("terminator", 96, 72)
def terminator(folder):
    """Coarse smooth balls under a sharp sun: shading normals against the true surface."""
    table(half=5.0)
    for column, (segments, material) in enumerate((
        (8, kit.matte("Matte", (0.8, 0.8, 0.8))), (16, kit.principled("Plastic", base_color=(0.6, 0.2, 0.2), roughness=0.3)),
        (12, kit.principled("Metal", base_color=(0.9, 0.8, 0.6), metallic=1.0, roughness=0.3)),
    )):
        kit.sphere(f"Ball {column}", 0.7, ((column - 1) * 1.6, 0.0, 0.7), material, segments, segments // 2)
    kit.sun("Sun", (0.8, 0.25, -0.35), 3.0)
    kit.look_from((0.0, -6.0, 2.6), (0.0, 0.0, 0.6), degrees=46.0)
    return {"constant": (0.2, 0.2, 0.25), "bounces": 2, "view": "Standard"}


@probe("instances", 96, 72)
def instances(folder):
    """One mesh at many scales, turned, mirrored and sheared by a parent."""
    import bpy

    table(half=6.0)
    material = kit.principled("Plastic", base_color=(0.3, 0.5, 0.8), roughness=0.4)
    shared = kit.torus_mesh("Ring", 0.5, 0.2, material, 48, 16)
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.scale = (1.0, 0.4, 1.5)
    for index in range(8):
        holder = kit.link(shared, f"Ring {index}")
        holder.location = ((index % 4) * 1.5 - 2.25, (index // 4) * 1.8 - 0.9, 0.7)
        holder.rotation_euler = (0.4 * index, 0.7 * index, 0.3)
        holder.scale = ((1, 1, 1), (-1, 1, 1), (0.5, 1.2, 0.8), (1, -1, -1))[index % 4]
        if index >= 4:
            holder.parent = parent
    kit.sun("Sun", (0.4, 0.5, -0.8), 3.0, angle=6.0)
    kit.look_from((0.0, -6.5, 4.0), (0.0, 0.2, 0.6), degrees=46.0)
    return {"constant": (0.4, 0.45, 0.5), "bounces": 3, "view": "Standard"}
