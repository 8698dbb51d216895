# SPDX-License-Identifier: GPL-3.0-or-later
"""Hard cases whose answer is known, made here and rendered by Sundog and by Cycles: what each of them finds.

    python hard_answers.py --sundog PROGRAM [--only PART] [--json FILE]

Each scene goes through the add-on's export. What is asked for is the mean of the picture; behind it stands four times its standard
error, from the differences between pixels, where that is more than half of the last digit. Cycles runs without what biases it by choice
(clamping, filter glossy, adaptive sampling, denoising) and with as many bounces. Sundog must be within four standard errors and the
bound of the case, or the script fails; what Cycles finds is shown, not judged.
"""

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(HERE), "addon"))

import bpy  # noqa: E402
import bmesh  # noqa: E402  (a module of bpy)
import export_kit as kit  # noqa: E402
import numpy  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402
from sundog import export  # noqa: E402

WIDTH, HEIGHT = 32, 24
LUMINANCE = numpy.array([0.2126, 0.7152, 0.0722])
WHITE, GREY, BLACK = (1, 1, 1, 1), (0.5, 0.5, 0.5, 1), (0, 0, 0, 1)
# Roundings of a few hundred operations in single precision, 2^-24 each.
ROUNDING = 2e-5
# Sundog's tables of multiple scattering are linear between 40 points (docs/hard-cases.md, `grazing-views`).
TABLES = 5e-3

CASES = []


def case(about, expected, samples=64, bounces=16, transparent=8, bound=ROUNDING, of=None):
    """Notes a scene. `of`: what of the pixels counts, instead of their luminance."""

    def note(make):
        CASES.append({"about": about, "expected": expected, "make": make, "samples": samples, "bounces": bounces, "transparent": transparent,
                      "bound": bound, "of": of or (lambda pixels: pixels @ LUMINANCE)})
        return make

    return note


# ---- Parts of scenes ----


def fresh(world=0.0):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("world")
    scene.world.color = [world] * 3
    return scene


def look(position, target, scale=None, degrees=None, far=100.0):
    """A camera: orthographic of that width, or of that field of view."""
    data = bpy.data.cameras.new("camera")
    data.clip_start, data.clip_end = 1e-5, far
    if scale is not None:
        data.type, data.ortho_scale = "ORTHO", scale
    else:
        data.angle = math.radians(degrees)
    camera = bpy.data.objects.new("camera", data)
    direction = Vector(target) - Vector(position)
    camera.matrix_world = Matrix.Translation(position) @ direction.to_track_quat("-Z", "Y").to_matrix().to_4x4()
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera


def add(mesh, material, place=None):
    """An object."""
    if material is not None:
        mesh.materials.append(material)
    made = bpy.data.objects.new(mesh.name, mesh)
    made.matrix_world = place or Matrix.Identity(4)
    bpy.context.scene.collection.objects.link(made)
    return made


def matte(color=WHITE, emission=0.0, alpha=1.0):
    return kit.material("matte", Base_Color=color, Roughness=1.0, Specular_IOR_Level=0.0, Emission_Color=WHITE, Emission_Strength=emission, Alpha=alpha)


def glass(ior, roughness=0.0):
    return kit.material("glass", Base_Color=WHITE, Roughness=roughness, IOR=ior, Transmission_Weight=1.0)


def ball(rings, smooth, radius=1.0, half=False, inward=False):
    """A sphere; `half`: the lower half of it alone."""
    shape = bmesh.new()
    bmesh.ops.create_uvsphere(shape, u_segments=2 * rings, v_segments=rings, radius=radius)
    if half:
        bmesh.ops.delete(shape, geom=[v for v in shape.verts if v.co.z > 1e-4 * radius], context="VERTS")
    if inward:
        bmesh.ops.reverse_faces(shape, faces=shape.faces)
    mesh = bpy.data.meshes.new("ball")
    shape.to_mesh(mesh)
    shape.free()
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
    return mesh


def lamp(kind, position, energy, target=None, **settings):
    """A light that the camera does not see."""
    data = bpy.data.lights.new("light", kind)
    data.energy = energy
    for key, value in settings.items():
        setattr(data, key, value)
    light = bpy.data.objects.new("light", data)
    light.visible_camera = False
    direction = Vector(target or (0, 0, 0)) - Vector(position)
    light.matrix_world = Matrix.Translation(position) @ direction.to_track_quat("-Z", "Y").to_matrix().to_4x4()
    bpy.context.scene.collection.objects.link(light)


def floor(size=8.0):
    """Half of what falls on it comes back."""
    return add(kit.plane(size=size), matte(GREY))


# ---- White in white: 1 ----


@case("white furnace: smooth ball of 6 rings", 1.0)
def coarse_ball():
    fresh(1.0)
    add(ball(6, True), matte())
    look((4, 0.3, 0.2), (0, 0, 0), 1.2)


@case("white furnace: inside of a smooth bowl of 6 rings", 1.0, bounces=64)
def coarse_bowl():
    fresh(1.0)
    add(ball(6, True, half=True), matte())
    look((0.1, 0.2, 4), (0.1, 0.2, 0), 1.2)


@case("closed cube, albedo 0.99, shining 0.01, 1000 bounces", 1.0, samples=16, bounces=1000, bound=0.99**1000)
def closed_cube():
    fresh()
    add(kit.cube(), matte((0.99, 0.99, 0.99, 1), 0.01))
    look((0.1, 0.2, 0.3), (1, 0.4, 0), degrees=90)


@case("closed smooth ball of 6 rings, albedo 0.9, shining 0.1", 1.0, bounces=200)
def closed_ball():
    fresh()
    add(ball(6, True, inward=True), matte((0.9, 0.9, 0.9, 1), 0.1))
    look((0.1, 0.2, 0.3), (1, 0.4, 0), degrees=90)


@case("white furnace: ball at 1e5 m", 1.0)
def far_ball():
    fresh(1.0)
    add(ball(24, False), matte(), Matrix.Translation((1e5, 1e5, 1e5)))
    look((1e5 + 4, 1e5 + 0.3, 1e5 + 0.2), (1e5, 1e5, 1e5), 1.2)


@case("white furnace: ball of 1 mm on a ground of 1e7 m", 1.0, bounces=64)
def small_on_huge():
    fresh(1.0)
    add(kit.plane(size=2e7), matte())
    add(ball(24, False, 1e-3), matte(), Matrix.Translation((0, 0, 1e-3)))
    look((4e-3, 1e-3, 4e-3), (0, 0, 5e-4), 4e-3)


@case("white furnace: metal of roughness 0.2 under a cosine of 1e-4", 1.0, bound=TABLES)
def grazing_metal():
    fresh(1.0)
    add(kit.plane(size=2.0), kit.material("metal", Base_Color=WHITE, Metallic=1.0, Roughness=0.2))
    look((0.5, 0, 5e-5), (0, 0, 0), 1e-6)


@case("white furnace: ball of plastic, index 1.5, roughness 0.3", 1.0, bounces=64, bound=TABLES)
def plastic_ball():
    fresh(1.0)
    add(ball(24, False), kit.material("plastic", Base_Color=WHITE, Roughness=0.3))
    look((4, 0.3, 0.2), (0, 0, 0), 1.2)


@case("white furnace: metal ball of roughness 1", 1.0, bounces=64, bound=TABLES)
def metal_ball():
    fresh(1.0)
    add(ball(24, False), kit.material("metal", Base_Color=WHITE, Metallic=1.0, Roughness=1.0))
    look((4, 0.3, 0.2), (0, 0, 0), 1.2)


def glass_ball(ior, roughness):
    fresh(1.0)
    add(ball(24, False), glass(ior, roughness))
    look((4, 0.3, 0.2), (0, 0, 0), 1.2)


# The table's error at each of some four surfaces.
for _ior, _roughness, _bound in ((1.0, 0.0, ROUNDING), (1.000001, 0.0, ROUNDING), (1.5, 0.0, ROUNDING), (2.4, 0.0, ROUNDING), (1.5, 0.3, 4 * TABLES), (1.0001, 0.1, 4 * TABLES)):
    case(f"white furnace: glass ball of index {_ior:.7g}, roughness {_roughness:g}", 1.0, bounces=1024, bound=_bound)(
        lambda ior=_ior, roughness=_roughness: glass_ball(ior, roughness))


@case("white furnace: liquid that ends at its glass", 1.0, bounces=1024)
def liquid():
    fresh(1.0)
    add(ball(24, False), glass(1.5))
    add(ball(24, False, 0.8, inward=True), glass(1.5))
    add(ball(24, False, 0.8), glass(1.33))
    look((4, 0.3, 0.2), (0, 0, 0), 1.2)


@case("white furnace: liquid that ends 1e-6 before its glass", 1.0, bounces=1024)
def liquid_before_glass():
    fresh(1.0)
    add(ball(24, False), glass(1.5))
    add(ball(24, False, 0.8, inward=True), glass(1.5))
    add(ball(24, False, 0.8 - 1e-6), glass(1.33))
    look((4, 0.3, 0.2), (0, 0, 0), 1.2)


@case("white furnace: glass of index 1.1, roughness 0.5, under a cosine of 0.01", 1.0, bound=TABLES)
def grazing_glass():
    fresh(1.0)
    add(kit.plane(size=2.0), glass(1.1, 0.5))
    look((0.5, 0, 5e-3), (0, 0, 0), 1e-4)


@case("white furnace: camera inside of glass", 1.0, bounces=1024)
def camera_in_glass():
    fresh(1.0)
    add(ball(24, False), glass(1.5))
    look((0.1, 0.2, 0.3), (1, 0.4, 0), degrees=90)


# ---- What is before what ----


def reflectance(cos, ior):
    inner = math.sqrt(1 - (1 - cos * cos) / ior**2)
    s, p = (cos - ior * inner) / (cos + ior * inner), (ior * cos - inner) / (ior * cos + inner)
    return (s * s + p * p) / 2


def plate(thickness):
    fresh()
    panel = add(kit.plane(size=8.0), matte(BLACK, 1.0))
    panel.location.z = -2.0
    add(kit.cube(), glass(1.5), Matrix.Diagonal((1, 1, thickness / 2, 1)))
    look((0, 0, 2), (0, 0, 0), 0.5)


for _thickness in (0.1, 1e-5):
    _r = reflectance(1.0, 1.5)
    case(f"a panel of 1 behind {_thickness:g} of glass", (1 - _r) / (1 + _r), samples=1024)(lambda thickness=_thickness: plate(thickness))


@case("green share of a red sheet 1e-6 of the distance before a green one", 0.0, of=lambda pixels: pixels[..., 1] / pixels.sum(axis=-1).clip(1e-9))
def sheets():
    fresh()
    for height, color in ((0.0, (1, 0, 0, 1)), (-1e-6, (0, 1, 0, 1))):
        sheet = add(kit.plane(size=4.0), kit.material("sheet", Base_Color=BLACK, Emission_Color=color, Emission_Strength=1.0))
        sheet.location.z = height
    look((0, 0, 1), (0.1, 0.2, 0), degrees=40)


def layers(alpha):
    fresh()
    add(kit.plane(size=8.0), matte(BLACK, 1.0))
    layer, mesh = matte(BLACK, 0.0, alpha), kit.plane(size=8.0)
    mesh.materials.append(layer)
    for i in range(200):
        add(mesh, None).location.z = 0.01 * (i + 1)
    look((0, 0, 3), (0, 0, 0), 1.0)


for _alpha in (0.01, 1e-7):
    case(f"a panel of 1 behind 200 layers of alpha {_alpha:g}", (1 - _alpha) ** 200, samples=256, transparent=1024)(lambda alpha=_alpha: layers(alpha))


# ---- Lights over a floor that gives back half ----


def lit(place, look_from=(0.3, 0.2, 1.5), at=(0, 0, 0), width=1e-3):
    fresh()
    floor()
    place()
    look(look_from, at, width)


def lit_case(about, irradiance, place, samples=256, bound=1e-4, **view):
    case(about, 0.5 * irradiance / math.pi, samples, 0, bound=bound)(lambda: lit(place, **view))


lit_case("sun of 0 degrees under 60 degrees", 0.5, lambda: lamp("SUN", (math.sqrt(3), 0, 1), 1.0, angle=0.0))
lit_case("sun of 1e-6 degrees under 60 degrees", 0.5, lambda: lamp("SUN", (math.sqrt(3), 0, 1), 1.0, angle=math.radians(1e-6)))
lit_case("point light of 1e-10 W, radius 0, times 1e10", 1 / (4 * math.pi), lambda: lamp("POINT", (0, 0, 1), 1e-10, shadow_soft_size=0.0))
CASES[-1]["of"] = lambda pixels: pixels @ LUMINANCE * 1e10
lit_case("point light of 1e15 W, radius 0, times 1e-15", 1 / (4 * math.pi), lambda: lamp("POINT", (0, 0, 1), 1e15, shadow_soft_size=0.0))
CASES[-1]["of"] = lambda pixels: pixels @ LUMINANCE * 1e-15
lit_case("point light of radius 1e-6", 1 / (4 * math.pi), lambda: lamp("POINT", (0, 0, 1), 1.0, shadow_soft_size=1e-6))
lit_case("spot of 1 degree", 1 / (4 * math.pi), lambda: lamp("SPOT", (0, 0, 1), 1.0, shadow_soft_size=0.0, spot_size=math.radians(1), spot_blend=0.0))
lit_case("spot of 180 degrees", 1 / (4 * math.pi), lambda: lamp("SPOT", (0, 0, 1), 1.0, shadow_soft_size=0.0, spot_size=math.pi, spot_blend=0.0))
lit_case("area light of 1e-6 m at 1 m", 1 / math.pi, lambda: lamp("AREA", (0, 0, 1), 1.0, shape="SQUARE", size=1e-6))
lit_case("area light of 1e6 m at 1 m, radiance 1", math.pi, lambda: lamp("AREA", (0, 0, 1), math.pi * 1e12, shape="SQUARE", size=1e6))
lit_case("disc of 1 m at 1e-4 m, radiance 1", math.pi * 0.25 / (0.25 + 1e-8), lambda: lamp("AREA", (0, 0, 1e-4), math.pi**2 / 4, shape="DISK", size=1.0))


def beside_disc(r, h, a):
    """Form factor of a disc of radius r for a point h below it and a beside its axis, on a surface parallel to it."""
    z = h * h + a * a + r * r
    return 0.5 * (1 - (h * h + a * a - r * r) / math.sqrt(z * z - 4 * a * a * r * r))


# The camera sees a thousandth of the distance: the factor is straight there but for the square of that. Height, distance and
# radius are good to half a step of single precision at a metre, 2^-25 m.
for _d in (1e-2, 1e-4):
    lit_case(f"disc of 1 m from {_d:g} m beside and below it, radiance 1", math.pi * beside_disc(0.5, _d, 0.5 + _d),
             lambda d=_d: lamp("AREA", (0, 0, d), math.pi**2 / 4, shape="DISK", size=1.0), samples=1024, bound=3 * 2**-25 / _d + 1e-4, at=(0.5 + _d, 0, 0),
             look_from=(0.5 + _d, 0, 1), width=1e-3 * _d)


def glowing(corners, strength, copies=1):
    for _ in range(copies):
        mesh = bpy.data.meshes.new("glow")
        mesh.from_pydata(corners, [], [tuple(range(len(corners)))])
        add(mesh, matte(BLACK, strength)).visible_camera = False


_L = 50.0
# Its edges are 0.2 m beside the camera, where single precision has steps of 1.5e-8 m.
lit_case("glowing strip of 100 m by 1e-4 m at 1 m, radiance 1e4", _L / (_L * _L + 1) + math.atan(_L),
         lambda: glowing([(-_L, -5e-5, 1), (-_L, 5e-5, 1), (_L, 5e-5, 1), (_L, -5e-5, 1)], 1e4), samples=1024, bound=1.5e-4 + ROUNDING)


def square_factor(a, h):
    """Form factor of a square of half side a for a point at h under its middle: four quarters."""
    t = a / math.hypot(a, h)
    return 4 * 2 * t * math.atan(t) / (2 * math.pi)


_square = [(-0.5, -0.5, 1), (-0.5, 0.5, 1), (0.5, 0.5, 1), (0.5, -0.5, 1)]
lit_case("glowing square of 1 m at 1 m, radiance 1", math.pi * square_factor(0.5, 1.0), lambda: glowing(_square, 1.0), samples=1024)
lit_case("the same twice in one place: that of one", math.pi * square_factor(0.5, 1.0), lambda: glowing(_square, 1.0, 2), samples=1024)


def beside_stronger():
    """A lamp of 1 W, and one of 1e8 W in a closed box."""
    lamp("POINT", (0, 0, 1), 1.0, shadow_soft_size=0.0)
    lamp("POINT", (3, 0, 1), 1e8, shadow_soft_size=0.0)
    add(kit.cube(size=0.5), matte(BLACK), Matrix.Translation((3, 0, 1)))


lit_case("lamp beside one 1e8 times as strong in a closed box", 1 / (4 * math.pi), beside_stronger, samples=4096)


# ---- Beyond ----


def hot_pixel(width=64, height=32, radiance=1e8):
    """A sky that is black but for a pixel above the horizon."""
    picture = bpy.data.images.new("sky", width, height, float_buffer=True)
    values = numpy.zeros((height, width, 4), numpy.float32)
    values[24, 20, :3] = radiance
    picture.pixels.foreach_set(values.ravel())
    picture.update()
    world = bpy.context.scene.world
    world.use_nodes = True
    tree = world.node_tree
    background = next(n for n in tree.nodes if n.type == "BACKGROUND")
    environment = tree.nodes.new("ShaderNodeTexEnvironment")
    environment.image = picture
    tree.links.new(environment.outputs["Color"], background.inputs["Color"])


def hot_irradiance(width=64, height=32, row=24):
    """Of a level floor, by its tent of linear interpolation, for a radiance of 1."""
    fine = (numpy.arange(2000) + 0.5) / 1000 - 1
    elevation = (row + 0.5 + fine) / height * math.pi - math.pi / 2
    tent = 1 - abs(fine)
    return float((tent * numpy.sin(elevation) * numpy.cos(elevation)).sum() / 1000 * math.pi / height * 2 * math.pi / width)


lit_case("sky of one pixel of 1e8, times 1e-8", hot_irradiance(), hot_pixel, samples=1024, bound=1e-3)
CASES[-1]["of"] = lambda pixels: pixels @ LUMINANCE * 1e-8


SUN = Vector((0.1, -0.98, 0.0)).normalized()


def true_sphere(width=1.2):
    """What a true sphere gives back of a sun of irradiance pi, in the middle of each pixel."""
    y, z = numpy.meshgrid((numpy.arange(WIDTH) + 0.5) / WIDTH - 0.5, ((numpy.arange(HEIGHT) + 0.5) / HEIGHT - 0.5) * HEIGHT / WIDTH)
    y, z = y * width, z * width
    x = numpy.sqrt(1 - y * y - z * z)
    return (x * SUN.x + y * SUN.y + z * SUN.z).clip(0)


def too_dark(pixels):
    """Facets of 22.5 degrees are met up to 0.061 aside of the sphere (docs/hard-cases.md, `shadow-terminator`)."""
    return (pixels @ LUMINANCE < 0.5 * true_sphere()) & (true_sphere() > 0.13)


@case("black pixels of a smooth ball of 8 rings in the sun (share)", 0.0, bounces=0, of=too_dark)
def coarse_in_the_sun():
    fresh()
    add(ball(8, True), matte())
    lamp("SUN", SUN, math.pi, angle=0.0)
    look((4, 0, 0), (0, 0, 0), 1.2)


# ---- Both renderers ----


def mean_of(entry, pixels):
    """Mean, and four standard errors."""
    values = entry["of"](pixels.astype(numpy.float64)).astype(numpy.float64).ravel()
    return float(values.mean()), 4 * float(values.std(ddof=1)) / math.sqrt(values.size)


def by_cycles(entry):
    cycles = bpy.context.scene.cycles
    for name in ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces"):
        setattr(cycles, name, entry["bounces"])
    cycles.transparent_max_bounces = entry["transparent"]
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.light_sampling_threshold = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.seed = 1
    return mean_of(entry, kit.cycles_pixels(WIDTH, HEIGHT, entry["samples"]))


def by_sundog(entry, program, folder):
    def task(depsgraph):
        return export.write_scene(depsgraph, depsgraph.scene, os.path.join(folder, "scene"), os.path.join(folder, "cache"))

    path = kit.in_render(task).path
    result = os.path.join(folder, "picture.exr")
    command = [program, "render", path, "--allow-outside", "-o", result, "--width", WIDTH, "--height", HEIGHT, "--samples", entry["samples"], "--seed", 1, "--filter", "box",
               "--bounces", entry["bounces"], "--bounces-transparent", entry["transparent"], "--exr-layers", "combined", "--exr-type", "float"]
    done = subprocess.run([str(a) for a in command], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"sundog failed: {done.stderr}")
    return mean_of(entry, kit.exr_pixels(result))


def shown(found, expected):
    """A number with as many digits as are sure, and what it may be off by if that shows."""
    value, error = found
    if not math.isfinite(value):
        return "not finite"
    digits = max(0, 4 - math.floor(math.log10(abs(expected)))) if expected else 5
    text = f"{value:.{digits}f}"
    return text if error < 0.5 * 10.0**-digits else f"{text} ± {error:.{digits}f}"


def main():
    """Renders, prints the table, and fails where Sundog is off."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sundog", required=True)
    parser.add_argument("--only", default="", help="cases whose names contain this")
    parser.add_argument("--json", help="where to write the table")
    given = parser.parse_args()
    rows, wrong = [], 0
    print("| case | expected | Sundog | Cycles |\n| --- | ---: | ---: | ---: |")
    with tempfile.TemporaryDirectory(prefix="sundog-answers-") as folder:
        for entry in CASES:
            if given.only not in entry["about"]:
                continue
            entry["make"]()
            bpy.context.view_layer.update()
            expected = entry["expected"]
            cycles, sundog = by_cycles(entry), by_sundog(entry, given.sundog, folder)
            off = abs(sundog[0] - expected) > sundog[1] + entry["bound"] * max(abs(expected), 1e-3)
            wrong += off
            rows.append({"case": entry["about"], "expected": expected, "sundog": sundog, "cycles": cycles, "bound": entry["bound"], "off": bool(off)})
            print(f"| {entry['about']} | {shown((expected, 0.0), expected)} | {shown(sundog, expected)}{' (off)' if off else ''} | {shown(cycles, expected)} |",
                  flush=True)
    if given.json:
        with open(given.json, "w", encoding="utf-8") as file:
            json.dump(rows, file, indent=1)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
