# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras, passes and transparent film against Cycles: the same scene, made here, rendered by both. Cycles' pictures are kept (references.py).

    python film.py --sundog PROGRAM [--only PART] [--samples COUNT]

Each scene goes through the add-on's export and is rendered twice by either (independent seeds). Cameras look at coloured
boxes that shine, so that nothing but the camera matters. As in compare.py, relMSE is estimated by the products of the
differences of independent pictures, so that noise does not count, and a comparison that is too noisy fails.
"""

import argparse
import os
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(HERE), "addon"))

import bpy  # noqa: E402
import export_kit as kit  # noqa: E402
import exr  # noqa: E402
import numpy  # noqa: E402
import references  # noqa: E402
from mathutils import Euler, Matrix  # noqa: E402
from sundog import export  # noqa: E402

WIDTH, HEIGHT = 64, 48
BOUNCES = 8
LUMINANCE = numpy.array([0.2126, 0.7152, 0.0722])
RELATIVE_ERROR_BOUND = 1e-3
LUMINANCE_BOUND = 0.01
SWITCHES = {
    "z": "Depth",
    "normal": "Normal",
    "position": "Position",
    "uv": "UV",
    "emit": "Emit",
    "environment": "Env",
    **{
        f"{kind}_{part}": short + end
        for kind, short in (("diffuse", "Diff"), ("glossy", "Gloss"), ("transmission", "Trans"))
        for part, end in (("direct", "Dir"), ("indirect", "Ind"), ("color", "Col"))
    },
}


def shining(name, color):
    """A material that shines and reflects nothing."""
    made = kit.material(name, Base_Color=(0, 0, 0, 1), Emission_Color=(*color, 1), Emission_Strength=1.0)
    made.node_tree.nodes["Principled BSDF"].inputs["Specular IOR Level"].default_value = 0
    return made


def put(name, mesh, place, material):
    """An object in the scene."""
    mesh.materials.append(material)
    made = bpy.data.objects.new(name, mesh)
    made.matrix_world = place
    bpy.context.scene.collection.objects.link(made)
    return made


def fresh():
    """An empty file with a camera and a grey world."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = (0.1, -6, 0.4)
    camera.rotation_euler = (1.5, 0.1, 0.05)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    background = next(n for n in scene.world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.1, 0.12, 0.15, 1)
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH, HEIGHT, 100
    return scene, camera


def boxes():
    """Boxes of all colours at all sides and distances."""
    generator = numpy.random.default_rng(3)
    for i in range(40):
        place = Matrix.Translation(generator.uniform(-5, 5, 3)) @ Euler(generator.uniform(0, 3, 3)).to_matrix().to_4x4()
        color = generator.uniform(0, 1, 3) ** 2
        put(f"box {i}", kit.cube(size=generator.uniform(0.3, 1)), place, shining(f"paint {i}", color))


def camera_cases():
    """Name -> what is set on the camera (c) and the render settings (r)."""
    def lens(c, radius, distance, blades=0, rotation=0.0, ratio=1.0):
        c.dof.use_dof = True
        length = 1.0 if c.type == "ORTHO" else c.lens * 1e-3
        c.dof.aperture_fstop, c.dof.focus_distance = length / (2 * radius), distance
        c.dof.aperture_blades, c.dof.aperture_rotation, c.dof.aperture_ratio = blades, rotation, ratio

    def panorama(c, longitude=(-numpy.pi, numpy.pi), latitude=(-numpy.pi / 2, numpy.pi / 2)):
        c.type = "PANO"
        settings = c if hasattr(c, "panorama_type") else c.cycles
        settings.panorama_type = "EQUIRECTANGULAR"
        settings.longitude_min, settings.longitude_max = longitude
        settings.latitude_min, settings.latitude_max = latitude

    def shifted(c, r):
        c.sensor_fit, c.sensor_height, c.lens = "VERTICAL", 20, 22
        c.shift_x, c.shift_y = 0.2, -0.15

    def orthographic(c, r):
        c.type, c.ortho_scale, c.shift_x = "ORTHO", 7, 0.1

    def wide_pixels(c, r):
        r.pixel_aspect_x, c.lens = 1.5, 25

    def clipped(c, r):
        c.clip_start, c.clip_end, c.lens = 3.5, 7, 25

    def circle(c, r):
        c.lens = 30
        lens(c, 0.25, 5)

    def blades(c, r):
        c.lens = 30
        lens(c, 0.4, 4, blades=5, rotation=0.5, ratio=1.6)

    def orthographic_lens(c, r):
        orthographic(c, r)
        lens(c, 0.5, 6, blades=3, rotation=0.3)

    def all_around(c, r):
        panorama(c)

    def part(c, r):
        panorama(c, (-1.0, 2.0), (-0.4, 1.2))

    def panorama_lens(c, r):
        panorama(c)
        lens(c, 0.3, 3, blades=3, rotation=0.4)

    return {
        f.__name__.replace("_", " "): f
        for f in (
            shifted, orthographic, wide_pixels, clipped, circle, blades, orthographic_lens, all_around, part, panorama_lens,
        )
    }


def by_cycles(name, samples, seed, folder):
    """Its passes by name, rows from top to bottom."""
    scene = bpy.context.scene
    cycles, render = scene.cycles, scene.render
    render.engine = "CYCLES"
    cycles.device, cycles.samples, cycles.seed = "CPU", samples, seed
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = BOUNCES
    cycles.transparent_max_bounces = 64
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    cycles.pixel_filter_type = "BOX"
    image = render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "MULTI_LAYER_IMAGE"
    image.file_format, image.color_depth, image.exr_codec = "OPEN_EXR_MULTILAYER", "32", "NONE"
    if hasattr(image, "use_exr_interleave"):
        # All layers in one part, as before 5.0.
        image.use_exr_interleave = True
    render.filepath = os.path.join(folder, "cycles.exr")

    def rendered():
        with kit.quiet():
            bpy.ops.render.render(write_still=True)
        return exr.passes(exr.read(render.filepath))

    found = references.kept(__file__, f"{name} {samples} {seed}", rendered)
    found = {name.rpartition(".")[2]: values.astype(float) for name, values in found.items()}
    return {SHORT.get(name, name): values for name, values in found.items()}


# What passes were called before Blender 5.0.
SHORT = {"Emission": "Emit", "Environment": "Env"}
SHORT.update({
    f"{long} {way}": short + way_then
    for long, short in (("Diffuse", "Diff"), ("Glossy", "Gloss"), ("Transmission", "Trans"))
    for way, way_then in (("Direct", "Dir"), ("Indirect", "Ind"), ("Color", "Col"))
})


def by_sundog(program, samples, seed, folder):
    """The same."""
    def task(depsgraph):
        return export.write_scene(depsgraph, depsgraph.scene, os.path.join(folder, "scene"), os.path.join(folder, "cache"))

    result = os.path.join(folder, "sundog.exr")
    arguments = [program, "render", kit.in_render(task).path, "--allow-outside", "-o", result, "--samples", samples, "--seed", seed]
    arguments += ["--filter", "box", "--bounces", BOUNCES, "--passes", "all", "--exr-compression", "none"]
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"sundog failed: {done.stderr}")
    found = exr.passes(exr.read(result))
    return {name or "Combined": values.astype(float) for name, values in found.items()}


def relative_error(sundog, cycles):
    """(relMSE, its standard error) of two pairs of independent pictures."""
    weight = 1 / (numpy.mean(cycles, axis=0) ** 2 + 0.01)
    products = [(sundog[i] - cycles[k]) * (sundog[1 - i] - cycles[1 - k]) for i in (0, 1) for k in (0, 1)]
    values = (numpy.mean(products, axis=0) * weight).mean(axis=-1)
    return values.mean(), values.std() / numpy.sqrt(values.size)


def ratio_of_means(sundog, cycles):
    """(ratio, its standard error) of the mean luminances."""
    means = [[float(p.mean(axis=(0, 1)) @ LUMINANCE) for p in pictures] for pictures in (sundog, cycles)]
    whole = numpy.mean(means[1])
    if whole == 0:
        return (1.0 if numpy.mean(means[0]) == 0 else numpy.inf), 0.0
    error = numpy.hypot(means[0][0] - means[0][1], means[1][0] - means[1][1]) / 2 / whole
    return numpy.mean(means[0]) / whole, error


class Verdicts:
    """Lines of the table, and whether all is well."""

    def __init__(self):
        self.wrong = []

    def add(self, name, value, error, bound, unit=""):
        """One number, which with two standard errors may not be above its bound."""
        # Not a number is not good.
        good = value + 2 * error <= bound
        print(f"{name:42} {value:10.2e} ± {error:.1e}  (at most {bound:.0e}) {unit} {'' if good else 'DIFFERS'}", flush=True)
        if not good:
            self.wrong.append(name)

    def pictures(self, name, sundog, cycles, bound=RELATIVE_ERROR_BOUND):
        """relMSE and mean luminance."""
        self.add(f"{name}: relMSE", *relative_error(sundog, cycles), bound)
        ratio, error = ratio_of_means(sundog, cycles)
        self.add(f"{name}: luminance", abs(ratio - 1), error, LUMINANCE_BOUND, f"{100 * (ratio - 1):+.2f} %")


def compare_cameras(given, folder, verdicts):
    """Every kind of camera."""
    for name, setting in camera_cases().items():
        if given.only not in f"camera {name}":
            continue
        scene, camera = fresh()
        boxes()
        setting(camera.data, scene.render)
        cycles = [by_cycles(name, given.samples, s, folder)["Combined"][..., :3] for s in (0, 1)]
        sundog = [by_sundog(given.sundog, given.samples, s, folder)["Combined"][..., :3] for s in (0, 1)]
        verdicts.pictures(f"camera {name}", sundog, cycles)


def still_life(transparent):
    """Every kind of surface in the light of a sun-like lamp and a world; a hole, and a holdout."""
    scene, camera = fresh()
    camera.location, camera.rotation_euler = (0, -7, 2.2), (1.3, 0, 0)
    floor = kit.plane(size=14)
    put("floor", floor, Matrix.Identity(4), kit.material("floor", Base_Color=(0.7, 0.5, 0.3, 1), Roughness=0.9))
    paints = [
        kit.material("plastic", Base_Color=(0.2, 0.5, 0.8, 1), Roughness=0.4),
        kit.material("metal", Base_Color=(0.9, 0.7, 0.3, 1), Metallic=1.0, Roughness=0.3),
        kit.material("glass", Base_Color=(0.7, 0.9, 0.7, 1), Transmission_Weight=1.0, Roughness=0.2),
        shining("lamp", (2.0, 1.5, 1.0)),
        kit.material("sheet", Base_Color=(0.8, 0.2, 0.2, 1), Roughness=0.6, Alpha=0.4),
    ]
    for i, paint in enumerate(paints):
        place = Matrix.Translation((1.3 * (i - 2), 0.4 * (i % 2), 0.8)) @ Euler((0.2, 0.3, 0.5 * i)).to_matrix().to_4x4()
        put(f"box {i}", kit.cube(size=0.9), place, paint)
    if transparent:
        hole = put("hole", kit.cube(size=0.7), Matrix.Translation((0.4, -2, 0.6)), paints[0])
        hole.is_holdout = True
        scene.render.film_transparent = True
    data = bpy.data.lights.new("lamp", "POINT")
    data.energy, data.shadow_soft_size = 400, 0.5
    lamp = bpy.data.objects.new("light", data)
    lamp.location = (2, -3, 4)
    scene.collection.objects.link(lamp)
    layer = scene.view_layers[0]
    for switch in SWITCHES:
        setattr(layer, f"use_pass_{switch}", True)


def compare_passes(given, folder, verdicts):
    """Each pass, with and without the world in the picture."""
    for transparent in (False, True):
        title = "transparent film" if transparent else "passes"
        if given.only not in title:
            continue
        still_life(transparent)
        cycles = [by_cycles(title, 4 * given.samples, s, folder) for s in (0, 1)]
        sundog = [by_sundog(given.sundog, 4 * given.samples, s, folder) for s in (0, 1)]

        def both(name, cycles=cycles, sundog=sundog):
            return [p[name] for p in sundog], [p[name] for p in cycles]

        pair = both("Combined")
        alpha = abs(numpy.mean([p[..., 3] for p in pair[0]], axis=0) - numpy.mean([p[..., 3] for p in pair[1]], axis=0))
        verdicts.add(f"{title}: Combined, mean difference of alpha", alpha.mean(), 0, 2e-3)
        verdicts.pictures(f"{title}: Combined", *([p[..., :3] for p in q] for q in pair), 4e-3)
        for kind in ("Diff", "Gloss", "Trans"):
            for way in ("Dir", "Ind"):
                lit = [[p[f"{kind}{way}"] * p[f"{kind}Col"] for p in q] for q in (sundog, cycles)]
                ratio, error = ratio_of_means(*lit)
                share = numpy.mean(lit[1]) / numpy.mean(cycles[0]["Combined"][..., :3])
                # What is a small part of the picture may differ by as much of the picture as the others.
                verdicts.add(f"{title}: {kind}{way} · {kind}Col", abs(ratio - 1) * share, error * share, LUMINANCE_BOUND, f"{100 * (ratio - 1):+.2f} %")
            ratio, error = ratio_of_means(*both(f"{kind}Col"))
            verdicts.add(f"{title}: {kind}Col", abs(ratio - 1), error, 0.03, f"{100 * (ratio - 1):+.2f} %")
        for name in ("Emit", "Env"):
            verdicts.pictures(f"{title}: {name}", *both(name))
        for name in ("Normal", "Position"):
            difference = abs(numpy.mean(both(name)[0], axis=0) - numpy.mean(both(name)[1], axis=0))
            verdicts.add(f"{title}: {name}, median difference", numpy.median(difference), 0, 2e-3)
        depth = both("Depth")
        far = depth[1][0] >= 1e9
        verdicts.add(f"{title}: Depth, pixels of nothing", abs((depth[0][0] >= 1e9) ^ far).mean(), 0, 3e-2)
        relative = abs(depth[0][0] / depth[1][0] - 1)
        verdicts.add(f"{title}: Depth, 90 % of the pixels", numpy.quantile(relative, 0.9), 0, 1e-4)


def main():
    """Renders, prints the table, and fails if anything differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sundog", required=True)
    parser.add_argument("--only", default="", help="scenes whose names contain this")
    parser.add_argument("--samples", type=int, default=128, help="samples a pixel, for each of the two seeds")
    given = parser.parse_args()
    verdicts = Verdicts()
    with tempfile.TemporaryDirectory(prefix="sundog-film-") as folder:
        compare_cameras(given, folder, verdicts)
        compare_passes(given, folder, verdicts)
    print(f"{len(verdicts.wrong)} differ")
    sys.exit(1 if verdicts.wrong else 0)


if __name__ == "__main__":
    main()
