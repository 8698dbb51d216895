# SPDX-License-Identifier: MIT OR Apache-2.0
"""Sundog's own scenes: the gallery, and what the pictures are tested with.

Each function fills an empty file and returns what NAME.json says beyond the defaults of build.py.
"""

import math
import os
import random

import bpy
import numpy as np

import kit

SCENES = {}


def scene(name, width, height):
    def note(make):
        make.size = (width, height)
        SCENES[name] = make
        return make

    return note


@scene("cornell", 640, 640)
def cornell(folder):
    """The Cornell box: one mesh light, diffuse walls, two diffuse boxes."""
    white = kit.matte("White", (0.73, 0.73, 0.73))
    red = kit.matte("Red", (0.63, 0.06, 0.05))
    green = kit.matte("Green", (0.14, 0.45, 0.09))
    light = kit.glowing("Light", (1.0, 0.78, 0.48), 18.0)
    kit.quad("Floor", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], white)
    kit.quad("Ceiling", [(-1, 1, 2), (1, 1, 2), (1, -1, 2), (-1, -1, 2)], white)
    kit.quad("Back", [(-1, 1, 0), (1, 1, 0), (1, 1, 2), (-1, 1, 2)], white)
    kit.quad("Left", [(-1, -1, 0), (-1, 1, 0), (-1, 1, 2), (-1, -1, 2)], red)
    kit.quad("Right", [(1, 1, 0), (1, -1, 0), (1, -1, 2), (1, 1, 2)], green)
    kit.box("Lamp", (0.5, 0.4, 0.02), (0.0, 0.0, 1.985), light)
    kit.box("Tall box", (0.58, 0.58, 1.2), (-0.34, 0.3, 0.6), white, turn=-17.0)
    kit.box("Short box", (0.58, 0.58, 0.58), (0.36, -0.3, 0.29), white, turn=17.0)
    kit.look_from((0.0, -3.9, 1.0), (0.0, 0.0, 1.0), degrees=39.3)
    return {"bounces": 8, "view": "Filmic"}


@scene("three-objects", 960, 540)
def three_objects(folder):
    """A diffuse, a mirror and a rough-metal object on a ground, under a procedural sky with a bright small sun."""
    towards_sun = (0.62, -0.55, 0.42)
    kit.write_hdr(
        os.path.join(folder, "sky-with-sun.hdr"),
        kit.sky_picture(1024, 512, towards_sun, sun_radiance=190.0, sun_radius=5.0, clouds=0.8),
    )
    ground = kit.principled("Ground", base_color=(0.22, 0.20, 0.18), roughness=0.6)
    clay = kit.matte("Clay", (0.72, 0.23, 0.10))
    mirror = kit.principled("Mirror", base_color=(0.94, 0.95, 0.96), metallic=1.0, roughness=0.0)
    gold = kit.principled("Rough gold", base_color=(1.0, 0.71, 0.29), metallic=1.0, roughness=0.35)
    kit.quad("Ground", [(-60, -60, 0), (60, -60, 0), (60, 60, 0), (-60, 60, 0)], ground)
    kit.monkey("Suzanne of clay", (-2.3, 0.15, 0.78), clay, size=0.95, turn=18.0).rotation_euler[0] = math.radians(-32.0)
    kit.sphere("Mirror ball", 1.0, (0.0, 0.5, 1.0), mirror, 96, 48)
    ring = kit.link(kit.torus_mesh("Ring", 0.72, 0.30, gold), "Ring of gold")
    ring.location = (2.15, 0.1, 0.98)
    ring.rotation_euler = (math.radians(78.0), 0.0, math.radians(-28.0))
    kit.look_from((0.2, -7.6, 2.2), (0.0, 0.0, 0.92), degrees=50.0)
    return {"environment": "sky-with-sun.hdr", "environment_rotation": -20.0, "bounces": 8}


@scene("window-room", 960, 640)
def window_room(folder):
    """A room with no lamp: sun and sky come in through one window."""
    kit.write_hdr(os.path.join(folder, "sky.hdr"), kit.sky_picture(512, 256, clouds=0.5))
    plaster = kit.matte("Plaster", (0.82, 0.80, 0.76))
    accent = kit.matte("Accent wall", (0.16, 0.30, 0.36))
    boards = kit.principled("Boards", base_color=(1.0, 1.0, 1.0), roughness=0.45)
    u, v = kit.texture_grid(512)
    plank = np.floor(v * 8.0)
    shade = kit.value_noise(plank * 3.7, plank * 0.0 + 0.5, 3)
    grain = kit.fractal_noise(u * 6.0 + plank * 5.3, v * 96.0, 7)
    tone = 0.55 + 0.3 * shade + 0.35 * (grain - 0.5)
    gap = np.minimum((v * 8.0) % 1.0, 1.0 - (v * 8.0) % 1.0) < 0.025
    wood = np.stack([0.46 * tone, 0.27 * tone, 0.14 * tone], axis=-1) * np.where(gap, 0.25, 1.0)[..., None]
    kit.textured_color(boards, kit.texture(boards, kit.picture("boards", kit.to_srgb(wood), folder), scale=(1.5, 2.0)))
    frame = kit.principled("Painted frame", base_color=(0.85, 0.85, 0.83), roughness=0.3)
    cloth = kit.matte("Cloth", (0.62, 0.16, 0.10))
    wooden = kit.principled("Table wood", base_color=(0.35, 0.19, 0.09), roughness=0.4)
    brass = kit.principled("Brass", base_color=(0.91, 0.68, 0.33), metallic=1.0, roughness=0.22)
    porcelain = kit.principled("Porcelain", base_color=(0.85, 0.86, 0.88), roughness=0.12)

    # The room: x -2.5..2.5, y -3..3, z 0..2.8, walls 0.2 thick; the window is in the wall at +X.
    kit.box("Floor", (5.4, 6.4, 0.2), (0, 0, -0.1), boards)
    kit.box("Ceiling", (5.4, 6.4, 0.2), (0, 0, 2.9), plaster)
    kit.box("Back wall", (5.4, 0.2, 2.8), (0, 3.1, 1.4), accent)
    kit.box("Front wall", (5.4, 0.2, 2.8), (0, -3.1, 1.4), plaster)
    kit.box("Left wall", (0.2, 6.0, 2.8), (-2.6, 0, 1.4), plaster)
    kit.box("Under the window", (0.2, 6.0, 0.8), (2.6, 0, 0.4), plaster)
    kit.box("Over the window", (0.2, 6.0, 0.4), (2.6, 0, 2.6), plaster)
    kit.box("Wall before the window", (0.2, 2.6, 1.6), (2.6, -1.7, 1.6), plaster)
    kit.box("Wall behind the window", (0.2, 1.0, 1.6), (2.6, 2.5, 1.6), plaster)
    for y in (-0.4, 0.8, 2.0):
        kit.box("Window post", (0.06, 0.05, 1.6), (2.6, min(max(y, -0.375), 1.975), 1.6), frame)
    for z in (0.825, 1.6, 2.375):
        kit.box("Window bar", (0.06, 2.4, 0.05), (2.6, 0.8, z), frame)
    kit.box("Sill", (0.34, 2.5, 0.04), (2.45, 0.8, 0.8), frame)

    kit.box("Table top", (1.5, 0.8, 0.05), (0.35, 0.9, 0.74), wooden, turn=8.0)
    for dx, dy in ((-0.65, -0.3), (0.65, -0.3), (0.65, 0.3), (-0.65, 0.3)):
        turned = math.radians(8.0)
        kit.box(
            "Table leg", (0.06, 0.06, 0.715),
            (0.35 + dx * math.cos(turned) - dy * math.sin(turned), 0.9 + dx * math.sin(turned) + dy * math.cos(turned),
             0.3575), wooden, turn=8.0,
        )
    kit.sphere("Porcelain bowl", 0.17, (0.05, 0.95, 0.935), porcelain)
    ring = kit.link(kit.torus_mesh("Brass ring", 0.13, 0.04, brass), "Brass ring")
    ring.location, ring.rotation_euler = (0.62, 0.85, 0.93), (math.radians(90.0), 0.0, math.radians(35.0))
    kit.box("Bench", (0.5, 1.6, 0.42), (-2.1, 1.2, 0.21), wooden)
    kit.box("Cushion", (0.5, 1.6, 0.1), (-2.1, 1.2, 0.47), cloth)
    kit.monkey("Bust", (-2.08, 2.6, 0.62), porcelain, size=0.26, turn=40.0)
    kit.box("Plinth", (0.4, 0.4, 0.4), (-2.08, 2.6, 0.2), plaster)
    kit.box("Picture", (1.3, 0.04, 0.9), (-0.2, 2.98, 1.75), frame)
    kit.box("Canvas", (1.18, 0.05, 0.78), (-0.2, 2.97, 1.75), cloth)

    kit.sun("Sun", (-0.78, -0.20, -0.60), 14.0, (1.0, 0.86, 0.66), angle=0.53)
    kit.look_from((-0.9, -2.75, 1.5), (0.35, 1.6, 1.08), degrees=76.0)
    return {"environment": "sky.hdr", "environment_strength": 6.0, "bounces": 12, "exposure": 1.0}


@scene("many-lights", 960, 540)
def many_lights(folder):
    """A spiral of 260 points with radius and 90 small emissive meshes, over a terrace of slabs."""
    dice = random.Random(5)
    floor = kit.principled("Floor", base_color=(0.30, 0.30, 0.33), roughness=0.35)
    slab = kit.principled("Slab", base_color=(0.55, 0.53, 0.50), roughness=0.7)
    pale = kit.principled("Pale stone", base_color=(0.75, 0.73, 0.70), roughness=0.45)
    dark = kit.principled("Dark slab", base_color=(0.10, 0.11, 0.13), roughness=0.3)
    kit.quad("Floor", [(-30, -30, 0), (30, -30, 0), (30, 30, 0), (-30, 30, 0)], floor)
    block, dark_block = kit.box_mesh("Block", (1, 1, 1), slab), kit.box_mesh("Dark block", (1, 1, 1), dark)
    for row in range(-9, 10):
        for column in range(-9, 10):
            distance = math.hypot(row, column)
            if distance < 2.3 or dice.random() < 0.35:
                continue
            tall = 0.12 + 0.9 * dice.random() ** 3 + 0.10 * max(0.0, distance - 4.0)
            holder = kit.link(block if dice.random() < 0.7 else dark_block, "Block")
            holder.location = (row * 1.1, column * 1.1, tall / 2)
            holder.scale = (0.5 + 0.4 * dice.random(), 0.5 + 0.4 * dice.random(), tall)
    kit.monkey("Statue", (0.0, -0.6, 1.35), pale, size=1.25, turn=12.0).rotation_euler[0] = math.radians(-22.0)

    def hue(angle):
        """Amber, rose, violet and blue round the spiral."""
        stops = [(1.0, 0.50, 0.12), (1.0, 0.16, 0.22), (0.42, 0.16, 1.0), (0.10, 0.42, 1.0)]
        along = (angle / (2.0 * math.pi) % 1.0) * len(stops)
        mix = along % 1.0
        return tuple(
            a * (1 - mix) + b * mix for a, b in zip(stops[int(along) % 4], stops[(int(along) + 1) % 4])
        )

    for index in range(260):
        part = index / 260
        angle, out = index * 2.399963, 0.9 + 9.6 * math.sqrt(part)
        where = (out * math.cos(angle), out * math.sin(angle), 1.35 + 0.5 * math.sin(index * 0.7) + 0.9 * part)
        watts, radius = 3.0 + 5.0 * dice.random(), 0.02 + 0.04 * dice.random()
        kit.lamp("POINT", f"Point {index:03}", where, watts, hue(angle), radius)
    steps = 8
    glows = [kit.glowing(f"Glow {step}", hue((step + 0.5) / steps * 2 * math.pi), 16.0) for step in range(steps)]
    bulbs = [kit.sphere_mesh(f"Bulb {step}", 0.06, glow, 12, 6) for step, glow in enumerate(glows)]
    for index in range(90):
        part = index / 90
        angle, out = index * 2.399963 + 1.0, 1.8 + 8.4 * math.sqrt(part)
        holder = kit.link(bulbs[int(angle / (2 * math.pi) % 1.0 * steps)], f"Bulb {index:02}")
        holder.location = (out * math.cos(angle), out * math.sin(angle), 1.1 + 0.5 * math.cos(index * 1.3) + 0.8 * part)
    kit.look_from((0.0, -11.8, 4.1), (0.0, -0.4, 0.85), degrees=48.0)
    return {"bounces": 4, "exposure": 0.7}


@scene("glass", 960, 540)
def glass(folder):
    """Clear and rough glass of several kinds before a chequered ground, lit by two soft boxes and a dim sky."""
    kit.write_hdr(os.path.join(folder, "dim-sky.hdr"), kit.sky_picture(512, 256, clouds=0.3))
    u, v = kit.texture_grid(256)
    chequer = (np.floor(u * 8) + np.floor(v * 8)) % 2
    tiles = np.stack([0.12 + 0.62 * chequer, 0.14 + 0.58 * chequer, 0.20 + 0.48 * chequer], axis=-1)
    ground = kit.principled("Tiles", roughness=0.5)
    kit.textured_color(ground, kit.texture(ground, kit.picture("tiles", kit.to_srgb(tiles), folder), scale=(9.0, 9.0)))
    kit.quad("Ground", [(-24, -24, 0), (24, -24, 0), (24, 24, 0), (-24, 24, 0)], ground)
    kit.sphere("Clear ball", 0.8, (-2.1, 0.0, 0.8), kit.glass("Clear glass"), 96, 48)
    kit.monkey("Frosted Suzanne", (0.05, 0.2, 0.86), kit.glass("Frosted glass", roughness=0.25), size=0.9, turn=10.0)
    kit.box("Green block", (0.9, 0.9, 1.3), (2.0, 0.25, 0.66), kit.glass("Green glass", (0.55, 0.92, 0.70), 0.08, 1.45), turn=28.0)
    kit.sphere("Water drop", 0.34, (-0.95, -1.3, 0.34), kit.glass("Water", ior=1.33), 64, 32)
    ring = kit.link(kit.torus_mesh("Ring", 0.32, 0.13, kit.glass("Diamond", (0.95, 0.97, 1.0), 0.0, 2.0)), "Ring")
    ring.location = (1.0, -1.25, 0.131)
    kit.sphere("Amber ball", 0.26, (0.1, -1.75, 0.26), kit.glass("Rough amber", (1.0, 0.62, 0.22), 0.5, 1.54), 64, 32)
    soft = kit.glowing("Soft box", (1.0, 0.95, 0.88), 9.0)
    kit.quad("Left soft box", [(-5.0, -3.0, 1.0), (-5.0, 1.0, 1.0), (-3.9, 1.0, 4.4), (-3.9, -3.0, 4.4)], soft)
    kit.quad("Upper soft box", [(0.5, -1.5, 5.0), (0.5, 2.0, 5.0), (3.5, 2.0, 4.5), (3.5, -1.5, 4.5)], soft)
    kit.look_from((0.2, -6.8, 2.7), (0.0, 0.0, 0.58), degrees=49.0)
    return {"environment": "dim-sky.hdr", "environment_strength": 0.6, "bounces": 12}


@scene("material-wall", 960, 600)
def material_wall(folder):
    """A grid of textured and normal-mapped balls and tiles: every kind of texture that glTF's core carries."""
    u, v = kit.texture_grid(256)
    bumps = kit.fractal_noise(u * 8, v * 8, 21, 5, period=8)
    cells = np.sin(u * 2 * math.pi * 8) * np.sin(v * 2 * math.pi * 8)
    row = np.floor(v * 8)
    brick_u = (u * 4 + 0.5 * (row % 2)) % 1.0
    mortar = (np.minimum(brick_u, 1 - brick_u) < 0.04) | (np.minimum((v * 8) % 1, 1 - (v * 8) % 1) < 0.08)
    shade = kit.value_noise(np.floor(u * 4 + 0.5 * (row % 2)) % 4 * 1.37, row * 2.11, 5)
    speckle = kit.fractal_noise(u * 32, v * 32, 9, 3, period=32)
    bricks = np.where(
        mortar[..., None], np.stack([0.55 + 0.1 * speckle] * 3, axis=-1),
        np.stack([0.36 + 0.25 * shade, 0.10 + 0.09 * shade, 0.06 + 0.04 * shade], axis=-1) * (0.7 + 0.5 * speckle[..., None]),
    )
    brick_height = np.where(mortar, 0.0, 1.0) + 0.15 * speckle
    rust = np.clip((bumps - 0.46) * 5.0, 0.0, 1.0)
    steel = np.stack([0.56 + 0 * rust, 0.57 + 0 * rust, 0.58 + 0 * rust], axis=-1)
    rusty = steel * (1 - rust[..., None]) + np.array([0.32, 0.12, 0.04]) * rust[..., None]
    scratched = np.stack([0 * u, 0.15 + 0.6 * kit.fractal_noise(u * 4, v * 64, 31, 4), np.ones_like(u)], axis=-1)
    panel = ((np.floor(u * 8) + np.floor(v * 8)) % 2).astype(float)
    neon = np.zeros((256, 256, 3))
    rings = np.abs((np.hypot(u - 0.5, v - 0.5) * 12) % 1.0 - 0.5) < 0.12
    neon[rings] = (0.1, 0.8, 1.0)
    neon[np.abs(u - v) < 0.03] = (1.0, 0.25, 0.5)

    def color(name, pixels):
        return kit.picture(name, kit.to_srgb(pixels), folder)

    def data(name, pixels):
        return kit.picture(name, pixels, folder, color=False)

    brick_normals = data("brick-normals", kit.normals_from_height(brick_height, 2.0))
    bump_normals = data("bump-normals", kit.normals_from_height(bumps, 14.0))
    cell_normals = data("cell-normals", kit.normals_from_height(cells, 3.0))
    rust_data = data("rust-metal-roughness", np.stack([0 * u, 0.25 + 0.6 * rust, 1 - rust], axis=-1))
    brick_color, rust_color = color("brick-color", bricks), color("rust-color", rusty)
    marble_color = color("marble", np.stack([0.86 - 0.6 * np.clip(1 - 9 * np.abs(bumps - 0.5), 0, 1) ** 2 * s for s in (1, 0.95, 0.85)], axis=-1))

    made = []

    def material(name, **inputs):
        made.append(kit.principled(name, **inputs))
        return made[-1]

    one = material("Bricks", roughness=0.85)
    kit.textured_color(one, kit.texture(one, brick_color))
    kit.textured_normal(one, kit.texture(one, brick_normals))
    one = material("Rusty steel")
    kit.textured_color(one, kit.texture(one, rust_color))
    kit.textured_metal_roughness(one, kit.texture(one, rust_data))
    one = material("Scratched copper", base_color=(0.95, 0.60, 0.45))
    kit.textured_metal_roughness(one, kit.texture(one, data("scratches", scratched)))
    one = material("Hammered gold", base_color=(1.0, 0.74, 0.33), metallic=1.0, roughness=0.25)
    kit.textured_normal(one, kit.texture(one, bump_normals), strength=0.8)
    one = material("Marble", roughness=0.12)
    kit.textured_color(one, kit.texture(one, marble_color))
    one = material("Neon", base_color=(0.03, 0.03, 0.035), roughness=0.4)
    kit.textured_emission(one, kit.texture(one, kit.picture("neon", neon, folder)), 2.5)
    one = material("Turned tiles", roughness=0.35)
    kit.textured_color(one, kit.texture(one, color("tiles", np.stack([0.1 + 0.7 * panel, 0.25 + 0.4 * panel, 0.45 - 0.3 * panel], axis=-1)),
                                        offset=(0.13, 0.27), scale=(2.0, 1.5), rotation=30.0))
    one = material("Painted by vertex", roughness=0.5)
    kit.vertex_colored(one, "Paint")
    one = material("Painted marble", roughness=0.3)
    kit.vertex_colored(one, "Paint", kit.texture(one, marble_color))
    one = material("Blue plastic", base_color=(0.03, 0.12, 0.55), roughness=0.3)
    kit.textured_normal(one, kit.texture(one, cell_normals, scale=(2.0, 2.0)), strength=0.6)
    one = material("Cut emerald glaze", base_color=(0.02, 0.35, 0.16), roughness=0.05, ior=1.8, specular_ior_level=0.45)
    one = material("Tinted sheen", base_color=(0.25, 0.04, 0.05), roughness=0.4, specular_ior_level=0.35, specular_tint=(1.0, 0.7, 0.5))

    def paint(data, colors_of):
        """A colour attribute from the corners' places. Only where the material uses it: the exporter writes a white
        COLOR_0 for the others."""
        colors = data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
        place = np.array([vertex.co[:] for vertex in data.vertices])
        colors.data.foreach_set(
            "color", np.concatenate([colors_of(place), np.ones((len(place), 1))], axis=1).astype(np.float32).ravel())

    for index, one in enumerate(made):
        column, line = index % 4, index // 4
        ball = kit.sphere_mesh(f"Ball of {one.name}", 0.42, one)
        tile = kit.box_mesh(f"Tile of {one.name}", (0.92, 0.08, 0.92), one)
        if one.name.startswith("Painted"):
            paint(ball, lambda place: 0.5 + 0.45 * place[:, [0, 2, 1]] / 0.42)
            paint(tile, lambda place: np.clip(0.5 + 0.9 * place[:, [2, 0, 1]], 0.0, 1.0))
        for data, behind in ((tile, 0.42), (ball, 0.0)):
            holder = kit.link(data, data.name)
            holder.location = ((column - 1.5) * 1.12, behind, (2 - line) * 1.05 + 0.55)
            if data is ball:
                holder.rotation_euler = (0.0, 0.0, math.radians(25.0 * index))
    backing = kit.matte("Backing", (0.35, 0.35, 0.36))
    kit.quad("Backing", [(-8, 0.5, -3), (8, 0.5, -3), (8, 0.5, 6), (-8, 0.5, 6)], backing)
    kit.quad("Shelf", [(-8, -8, 0), (8, -8, 0), (8, 0.5, 0), (-8, 0.5, 0)], backing)
    kit.quad("Key light", [(-4.5, -5.0, 2.5), (-3.0, -5.6, 2.5), (-3.0, -5.0, 5.0), (-4.5, -4.4, 5.0)],
             kit.glowing("Key", (1.0, 0.93, 0.84), 22.0))
    kit.write_hdr(os.path.join(folder, "studio.hdr"), kit.sky_picture(256, 128, clouds=0.4))
    kit.look_from((0.35, -6.3, 1.9), (0.0, 0.0, 1.60), degrees=46.0)
    return {"environment": "studio.hdr", "environment_strength": 0.8, "environment_rotation": 60.0, "bounces": 6}


@scene("foliage", 960, 540)
def foliage(folder):
    """A grove: trees, ferns and grass of alpha-clipped cards, thousands of instances of a few meshes."""
    dice = random.Random(11)
    kit.write_hdr(
        os.path.join(folder, "evening-sky.hdr"),
        kit.sky_picture(512, 256, (-0.75, 0.35, 0.30), sun_radiance=0.0, clouds=0.6),
    )

    def leaf_picture(name, outline, tint):
        u, v = kit.texture_grid(128)
        inside = outline(u - 0.5, v)
        vein = np.clip(1 - np.abs(u - 0.5) * 40, 0, 1) * 0.25 + 0.12 * np.sin((v * 1.2 + np.abs(u - 0.5)) * 40)
        shade = (0.8 + 0.4 * kit.fractal_noise(u * 6, v * 6, 3) + vein)[..., None] * np.array(tint)
        alpha = np.clip(inside * 40.0 + 0.5, 0.0, 1.0)
        return kit.picture(name, np.concatenate([kit.to_srgb(shade), alpha[..., None]], axis=-1), folder)

    def leaf_material(name, image, roughness=0.55):
        material = kit.principled(name, roughness=roughness)
        node = kit.texture(material, image)
        kit.textured_color(material, node)
        kit.clipped_alpha(material, node)
        return material

    oval = lambda x, y: 0.34 * np.sqrt(np.clip(np.sin(np.pi * y), 0, 1)) * (1.1 - 0.5 * y) - np.abs(x)
    blade = lambda x, y: 0.18 * (1 - y) - np.abs(x - 0.12 * y * y)
    fern = lambda x, y: (0.42 * np.sin(np.pi * np.clip(y, 0, 1) ** 0.8) * (0.35 + 0.65 * (np.sin(y * 60 - np.abs(x) * 30) > -0.2)) - np.abs(x))
    leaves = [
        leaf_material("Leaf", leaf_picture("leaf", oval, (0.10, 0.24, 0.035))),
        leaf_material("Young leaf", leaf_picture("young-leaf", oval, (0.26, 0.34, 0.04))),
        leaf_material("Autumn leaf", leaf_picture("autumn-leaf", oval, (0.48, 0.17, 0.03))),
    ]
    grass = leaf_material("Grass", leaf_picture("grass", blade, (0.16, 0.27, 0.05)))
    frond = leaf_material("Fern", leaf_picture("fern", fern, (0.07, 0.20, 0.05)))
    bark = kit.principled("Bark", base_color=(0.14, 0.09, 0.06), roughness=0.9)
    soil = kit.principled("Soil", roughness=0.95)
    u, v = kit.texture_grid(256)
    ground = kit.fractal_noise(u * 12, v * 12, 40, 5, period=12)[..., None]
    kit.textured_color(soil, kit.texture(
        soil, kit.picture("soil", kit.to_srgb(np.array([0.10, 0.075, 0.04]) * (0.4 + 1.2 * ground)), folder), scale=(8.0, 8.0)))

    def card(corners, faces, uvs, root, along, across):
        """One rectangle from `root`, `along` its length, `across` half its width."""
        first = len(corners)
        corners += [root - across, root + across, root + along + across, root + along - across]
        faces.append((first, first + 1, first + 2, first + 3))
        uvs += [(0, 0), (1, 0), (1, 1), (0, 1)]

    def random_direction(upward):
        while True:
            direction = np.array([dice.uniform(-1, 1) for _ in range(3)])
            if 0.1 < np.linalg.norm(direction) < 1.0:
                direction = direction / np.linalg.norm(direction)
                direction[2] += upward
                return direction / np.linalg.norm(direction)

    def crown(name, material, count, radius, leaf_length):
        corners, faces, uvs = [], [], []
        for _ in range(count):
            out = random_direction(0.2)
            root = out * radius * dice.uniform(0.55, 1.0) * np.array([1.0, 1.0, 0.8])
            along = (out + 0.8 * random_direction(-0.3))
            along = along / np.linalg.norm(along) * leaf_length * dice.uniform(0.7, 1.2)
            across = np.cross(along, random_direction(0.0))
            card(corners, faces, uvs, root, along, across / np.linalg.norm(across) * leaf_length * 0.5)
        return kit.mesh(name, corners, faces, material, uvs)

    def trunk(name, height, radius):
        corners, faces = [], []
        for level in range(7):
            part = level / 6
            for side in range(10):
                turn = 2 * math.pi * side / 10
                thick = radius * (1.25 - 0.8 * part) * (1.0 + (0.5 if level == 0 else 0.0))
                corners.append((thick * math.cos(turn) + 0.12 * math.sin(3 * part), thick * math.sin(turn) + 0.1 * math.sin(2.2 * part + 1) - 0.084, part * height))
        for level in range(6):
            for side in range(10):
                beside = (side + 1) % 10
                faces.append((level * 10 + side, level * 10 + beside, level * 10 + 10 + beside, level * 10 + 10 + side))
        return kit.mesh(name, corners, faces, bark, None, smooth=True)

    def tuft(name, material, count, length, lean, width):
        corners, faces, uvs = [], [], []
        for index in range(count):
            turn = 2 * math.pi * (index + dice.random()) / count
            out = np.array([math.cos(turn), math.sin(turn), 0.0])
            along = (out * lean * dice.uniform(0.5, 1.2) + np.array([0, 0, 1.0])) * length * dice.uniform(0.6, 1.1)
            across = np.array([-math.sin(turn), math.cos(turn), 0.0]) * width
            card(corners, faces, uvs, out * 0.03, along, across)
        return kit.mesh(name, corners, faces, material, uvs)

    crowns = [crown(f"Crown {index}", leaves[index], 420, 0.95, 0.34) for index in range(3)]
    stems = [trunk("Trunk", 2.6, 0.13)]
    tufts = [tuft("Grass tuft", grass, 14, 0.42, 0.5, 0.06), tuft("Tall tuft", grass, 18, 0.62, 0.35, 0.06)]
    ferns = [tuft("Fern", frond, 9, 0.62, 1.3, 0.22)]
    kit.quad("Ground", [(-40, -40, 0), (40, -40, 0), (40, 40, 0), (-40, 40, 0)], soil)

    def put(source, name, x, y, z, size, turn):
        holder = kit.link(source, name)
        holder.location = (x, y, z)
        holder.scale = (size, size, size)
        holder.rotation_euler = (0.0, 0.0, turn)

    trees = 0
    while trees < 46:
        x, y = dice.uniform(-13, 13), dice.uniform(-2.5, 19)
        if abs(x - 0.5 * math.sin(y * 0.4)) < 1.5 + 0.05 * y:
            continue
        size, kind = dice.uniform(0.8, 1.45), dice.choices(range(3), (5, 3, 1.3))[0]
        put(stems[0], "Trunk", x, y, -0.02, size, dice.uniform(0, 6.28))
        for dx, dy, dz, part in ((0, 0, 2.7, 1.0), (0.55, 0.3, 2.3, 0.7), (-0.5, 0.25, 2.35, 0.75), (0.1, -0.55, 2.2, 0.65)):
            put(crowns[kind], "Crown", x + dx * size, y + dy * size, dz * size, size * part, dice.uniform(0, 6.28))
        trees += 1
    for _ in range(2300):
        y = -4.5 + 22 * dice.random() ** 1.5
        x = dice.uniform(-1, 1) * (4.0 + 0.75 * (y + 4.5))
        if abs(x - 0.5 * math.sin(y * 0.4)) < 0.55:
            continue
        put(dice.choice(tufts), "Grass", x, y, -0.01, dice.uniform(0.6, 1.25), dice.uniform(0, 6.28))
    for _ in range(260):
        y = -3.5 + 16 * dice.random()
        x = dice.uniform(-1, 1) * (4.0 + 0.6 * (y + 4.0))
        if abs(x - 0.5 * math.sin(y * 0.4)) < 1.0:
            continue
        put(ferns[0], "Fern", x, y, -0.01, dice.uniform(0.6, 1.2), dice.uniform(0, 6.28))
    kit.sun("Low sun", (0.72, -0.42, -0.46), 9.0, (1.0, 0.83, 0.60), angle=1.0)
    kit.look_from((0.25, -7.2, 1.65), (0.0, 2.0, 1.45), degrees=54.0)
    return {"environment": "evening-sky.hdr", "environment_strength": 1.5, "bounces": 6}


@scene("shallow-focus", 960, 540)
def shallow_focus(folder):
    """A row of figures on a table through a wide lens: one is sharp, lamps far behind are discs of light."""
    dice = random.Random(5)
    table = kit.principled("Table", base_color=(0.24, 0.13, 0.07), roughness=0.35)
    kit.quad("Table", [(-6, -2, 0), (6, -2, 0), (6, 9, 0), (-6, 9, 0)], table)
    wall = kit.matte("Wall", (0.05, 0.06, 0.09))
    kit.quad("Wall", [(-14, 14, -4), (14, 14, -4), (14, 14, 10), (-14, 14, 10)], wall)
    colors = ((0.75, 0.16, 0.10), (0.80, 0.62, 0.20), (0.13, 0.42, 0.55), (0.62, 0.66, 0.60), (0.36, 0.20, 0.48))
    for index, color in enumerate(colors):
        clay = kit.principled(f"Clay {index}", base_color=color, roughness=0.5)
        place = (-1.5 + 0.75 * index, 0.9 * index, 0.36)
        if index == 1:
            kit.monkey("Suzanne", (place[0], place[1], 0.38), clay, size=0.42, turn=12.0)
        else:
            kit.sphere(f"Ball {index}", 0.36, place, clay, 64, 32)
    for index in range(40):
        glow = kit.glowing(f"Lamp {index}", [0.4 + 0.6 * dice.random() for _ in range(3)], 40.0)
        kit.sphere(f"Lamp {index}", 0.05, (dice.uniform(-7, 7), dice.uniform(9, 13), dice.uniform(0.2, 5.0)), glow, 16, 8)
    key = kit.glowing("Window", (1.0, 0.93, 0.82), 9.0)
    kit.quad("Window", [(-5, -3, 2.5), (-5, 0, 2.5), (-5, 0, 4.5), (-5, -3, 4.5)], key)
    camera = kit.look_from((0.4, -4.2, 1.1), (-0.2, 0.9, 0.42), degrees=36.0)
    kit.focus(camera, 5.05, 0.5)
    return {"bounces": 8}
