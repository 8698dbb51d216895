# SPDX-License-Identifier: MIT OR Apache-2.0
"""Sundog's measures against independent implementations of them.

    PYTHON_WITH_MEASURES tests/python/measures.py SUNDOG FOLDER

RMSE, relMSE, MAPE and SMAPE against numpy, SSIM against scikit-image, LDR-FLIP and HDR-FLIP against NVIDIA's
flip-evaluator: on random pictures, HDR with fireflies, odd sizes, and renders of a room with little light. Numbers agree
to 1e-6 of their size (f64 sums of the same floats in both), SSIM and FLIP to 1e-4 absolutely (they go from 0 to 1;
flip-evaluator computes in f32, whose sums of 400 products are good to about 1e-5).
"""

import base64
import json
import os
import struct
import subprocess
import sys

import flip_evaluator
import numpy as np
import OpenEXR
from PIL import Image
from skimage.metrics import structural_similarity

RELATIVE = 1e-6
ABSOLUTE = 1e-4
LARGEST = {}


def write_exr(path, pixels):
    channels = {"RGB": np.ascontiguousarray(pixels, dtype=np.float32)}
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, channels).write(path)


def read_exr(path):
    with OpenEXR.File(path, separate_channels=True) as file:
        channels = file.channels()
        return np.stack([channels[name].pixels for name in ("R", "G", "B")], axis=-1).astype(np.float32)


def run(sundog, *arguments):
    done = subprocess.run([sundog, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{arguments}: {done.stderr}"
    return done.stdout


def to_srgb(linear):
    x = np.clip(linear.astype(np.float64), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def numbers(a, b):
    a, b = a.astype(np.float64), b.astype(np.float64)
    error = a - b
    return {
        "rmse": np.sqrt((error**2).mean()),
        "rel_mse": (error**2 / (b**2 + 0.01)).mean(),
        "mape": (np.abs(error) / (np.abs(b) + 0.01)).mean(),
        "smape": (2 * np.abs(error) / (np.abs(a) + np.abs(b) + 0.02)).mean(),
    }


def ssim(a, b):
    if min(a.shape[:2]) < 11:
        return None
    return structural_similarity(
        b, a, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1, channel_axis=2)


def flip(a, b, kind, parameters):
    """The mean of flip-evaluator's map. (Its own mean is a sum in f32.)"""
    error, _, used = flip_evaluator.evaluate(
        np.ascontiguousarray(b, dtype=np.float32), np.ascontiguousarray(a, dtype=np.float32), kind,
        inputsRGB=True, applyMagma=False, computeMeanError=False, parameters=parameters)
    return error.astype(np.float64).mean(), used


def note(measure, difference):
    LARGEST[measure] = max(LARGEST.get(measure, 0.0), difference)


def close(name, measure, ours, theirs, tolerance):
    difference = abs(ours - theirs)
    note(measure, difference)
    assert difference <= tolerance, f"{name}: {measure} is {ours!r}, independently {theirs!r}"


def check(name, told, a, b, linear):
    """One answer of `sundog compare --json` against what is found here."""
    for measure, value in numbers(a, b).items():
        close(name, measure, told[measure], value, RELATIVE * abs(value))
    seen_a, seen_b = (to_srgb(a), to_srgb(b)) if linear else (a, b)
    expected = ssim(seen_a, seen_b)
    assert (told["ssim"] is None) == (expected is None), name
    if expected is not None:
        close(name, "ssim", told["ssim"], expected, ABSOLUTE)
    close(name, "flip", told["flip"], flip(seen_a, seen_b, "LDR", {})[0], ABSOLUTE)
    if not linear:
        assert told["hdr_flip"] is None, name
        return
    exposures = told["hdr_flip_exposures"]
    mostly_black = np.median(b.max(axis=2)) <= 0
    given = {} if not mostly_black else {
        # flip-evaluator has no last exposure there (and answers 0).
        "startExposure": exposures["start"], "stopExposure": exposures["stop"], "numExposures": exposures["count"]}
    expected, used = flip(np.maximum(a, 0), np.maximum(b, 0), "HDR", given)
    close(name, "hdr_flip start", exposures["start"], used["startExposure"], 1e-4)
    close(name, "hdr_flip stop", exposures["stop"], used["stopExposure"], 1e-4)
    assert exposures["count"] == used["numExposures"], (name, exposures, used)
    close(name, "hdr_flip", told["hdr_flip"], expected, ABSOLUTE)


def pairs(random):
    """Pictures with their names, the reference second."""
    def noise(height, width):
        return random.random((height, width, 3))

    yield "noise", noise(64, 96), noise(64, 96)
    base = noise(53, 71)
    yield "alike", base + 0.01 * random.standard_normal(base.shape), base
    y, x = np.mgrid[0:80, 0:120] / 40.0
    smooth = np.stack([np.sin(3 * x) ** 2, np.cos(2 * y) ** 2, x * y / 6], axis=-1)
    yield "smooth against shifted", np.roll(smooth, 2, axis=1), smooth
    hdr = np.exp(3 * random.standard_normal((61, 97, 3)))
    yield "hdr", hdr * np.exp(0.3 * random.standard_normal(hdr.shape)), hdr
    fireflies = smooth * random.gamma(4, 0.25, smooth.shape)
    fireflies[random.random(smooth.shape[:2]) < 0.003] = 5000
    yield "fireflies", fireflies, smooth
    yield "fireflies in the reference", smooth, fireflies + 0.001
    edges = np.zeros((45, 131, 3))
    edges[:, ::7] = 1
    yield "mostly black", np.roll(edges, 1, axis=1) * 3, edges * 4
    yield "below 0", smooth - 0.2, smooth - 0.1
    for height, width in ((1, 1), (1, 40), (37, 1), (10, 30), (11, 11), (129, 13), (200, 12), (3, 2)):
        yield f"{width} x {height}", noise(height, width) * 2, noise(height, width) * 2


def room(path):
    """A closed room with one small lamp of triangles: found by bounces alone it gives fireflies."""
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    wall = [corner for face in faces for corner in (face[0], face[1], face[2], face[0], face[2], face[3])]
    places = [corners[index] for index in wall]
    lamp = [(-0.1, 0.9, -0.1), (0.1, 0.9, -0.1), (0.1, 0.9, 0.1)]
    data = b"".join(struct.pack("<3f", *place) for place in places + lamp)
    view = lambda first, count: {"bufferView": 0, "byteOffset": 12 * first, "componentType": 5126, "count": count, "type": "VEC3",
                                 "min": [-1, -1, -1], "max": [1, 1, 1]}
    scene = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
        "extensionsUsed": ["KHR_materials_emissive_strength"],
        "nodes": [{"mesh": 0}, {"mesh": 1}, {"camera": 0, "translation": [0.2, -0.3, 0.9]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1.2, "aspectRatio": 1.5, "znear": 0.01}}],
        "materials": [
            {"doubleSided": True, "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.5, 0.3, 1], "metallicFactor": 0}},
            {"doubleSided": True, "emissiveFactor": [1, 1, 1],
             "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 60}}},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]},
                   {"primitives": [{"attributes": {"POSITION": 1}, "material": 1}]}],
        "accessors": [view(0, len(places)), view(len(places), 3)],
        "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
    }
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file)


def renders(sundog, folder):
    """The paths of renders, the reference second."""
    scene = os.path.join(folder, "room.gltf")
    room(scene)
    path = lambda name: os.path.join(folder, name)

    def render(name, *more):
        run(sundog, "render", scene, "-o", path(name), "--quiet", "--width=145", "--height=97", "--exr-layers=combined", *more)
        return path(name)

    reference = render("reference.exr", "--samples=64", "--seed=7")
    yield "render", render("mis.exr", "--samples=4"), reference
    yield "render with fireflies", render("bsdf.exr", "--samples=4", "--light-sampling=bsdf"), reference


def main():
    sundog, folder = sys.argv[1:]
    random = np.random.default_rng(20201121)
    compare = lambda a, b: json.loads(run(sundog, "compare", a, b, "--json"))
    path_a, path_b = os.path.join(folder, "a.exr"), os.path.join(folder, "b.exr")
    count = 0
    for name, a, b in pairs(random):
        write_exr(path_a, a)
        write_exr(path_b, b)
        check(name, compare(path_a, path_b), a.astype(np.float32), b.astype(np.float32), True)
        count += 1
    for name, path_a, path_b in renders(sundog, folder):
        check(name, compare(path_a, path_b), read_exr(path_a), read_exr(path_b), True)
        count += 1
        # And as one sees them: display values in files.
        shown = []
        for path in (path_a, path_b):
            shown.append(path.replace(".exr", ".png"))
            run(sundog, "color", "apply", path, shown[-1])
        a, b = (np.asarray(Image.open(path)).astype(np.float64)[..., :3] / 255 for path in shown)
        check(f"{name} shown", compare(*shown), a, b, False)
        count += 1
    print(f"{count} pairs of pictures agree; largest differences: "
          + ", ".join(f"{measure} {value:.1e}" for measure, value in LARGEST.items()))


if __name__ == "__main__":
    main()
