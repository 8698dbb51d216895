"""Media beside Mitsuba 3's volpathmis: what fills boxes, alone, nested, overlapping, and by a grid.

    python tests/parity/volpathmis.py [PROGRAM] [SAMPLES]

Mitsuba is a package of PyPI (`pip install mitsuba numpy`), best in an environment of its own. Prints for each scene what the
means differ by and the relMSE, and fails above 1 % and 1e-3. Figures: docs/cycles.md, "Volumes".
"""

import json
import os
import subprocess
import sys
import tempfile

import mitsuba as mi
import numpy

mi.set_variant("scalar_rgb")
from mitsuba import ScalarTransform4f as T  # noqa: E402

WIDTH, HEIGHT, YFOV = 48, 32, 0.5
EYE = (0.0, 0.4, 6.5)
WORLD, INTENSITY, LAMP = 0.3, 6.0, (-1.5, 2.2, 1.5)
# Names of media: what scatters, what is absorbed (1/m), and the mean cosine.
FOG = ((0.9, 0.6, 0.3), (0.1, 0.4, 0.7), 0.3)
THIN = ((0.2, 0.3, 0.4), (0.05, 0.05, 0.05), 0.0)
DENSE = ((2.0, 1.5, 0.5), (0.0, 0.1, 0.4), 0.0)


def box(low, high):
    """Corners and triangles of a box, seen from outside."""
    points = [[(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)]
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    return points, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def added(*media):
    """Several in one place, all even."""
    return tuple(tuple(sum(m[i][c] for m in media) for c in range(3)) for i in (0, 1)) + (0.0,)


class Gltf:
    """A scene file with its buffer."""

    def __init__(self):
        self.bytes = b""
        self.root = {"asset": {"version": "2.0"}, "scene": 0, "accessors": [], "bufferViews": [], "meshes": [], "nodes": [], "materials": []}

    def accessor(self, array, kind):
        array = numpy.ascontiguousarray(array)
        code = {"float32": 5126, "uint32": 5125}[str(array.dtype)]
        self.root["bufferViews"].append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": array.nbytes})
        width = {"SCALAR": 1, "VEC3": 3}[kind]
        made = {"bufferView": len(self.root["bufferViews"]) - 1, "componentType": code, "count": array.size // width, "type": kind}
        if kind == "VEC3":
            made.update(min=array.min(0).tolist(), max=array.max(0).tolist())
        self.bytes += array.tobytes()
        self.root["accessors"].append(made)
        return len(self.root["accessors"]) - 1

    def mesh(self, points, triangles, material, **extension):
        points = self.accessor(numpy.array(points, "float32"), "VEC3")
        indices = self.accessor(numpy.array(triangles, "uint32").ravel(), "SCALAR")
        self.root["materials"].append(material)
        primitive = {"attributes": {"POSITION": points}, "indices": indices, "material": len(self.root["materials"]) - 1}
        if extension:
            primitive["extensions"] = {"SUNDOG_mesh": extension}
        self.root["meshes"].append({"primitives": [primitive]})
        self.root["nodes"].append({"mesh": len(self.root["meshes"]) - 1, "name": f"mesh {len(self.root['meshes'])}"})

    def write(self, folder):
        root = self.root
        root["cameras"] = [{"type": "perspective", "perspective": {"yfov": YFOV, "aspectRatio": WIDTH / HEIGHT, "znear": 0.01}}]
        root["nodes"].append({"camera": 0, "translation": EYE})
        lamp = {"strength": [INTENSITY] * 3, "radius": 0.0}
        light = {"type": "point", "color": [1, 1, 1], "intensity": INTENSITY, "extensions": {"SUNDOG_light": lamp}}
        root["extensions"] = {"KHR_lights_punctual": {"lights": [light]}}
        root["nodes"].append({"translation": LAMP, "extensions": {"KHR_lights_punctual": {"light": 0}}})
        world = {"world": {"color": [WORLD] * 3}}
        root["scenes"] = [{"nodes": list(range(len(root["nodes"]))), "extensions": {"SUNDOG_scene": world}}]
        root["extensionsUsed"] = ["KHR_lights_punctual", "SUNDOG_light", "SUNDOG_scene", "SUNDOG_material", "SUNDOG_mesh"]
        root["buffers"] = [{"uri": "scene.bin", "byteLength": len(self.bytes)}]
        with open(os.path.join(folder, "scene.bin"), "wb") as file:
            file.write(self.bytes)
        path = os.path.join(folder, "scene.gltf")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(root, file)
        return path


def filled(volume):
    """A material that only bounds a volume."""
    return {
        "alphaMode": "BLEND", "doubleSided": True,
        "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 0], "metallicFactor": 0},
        "extensions": {"SUNDOG_material": {"volume": volume}},
    }  # fmt: skip


def even(medium):
    """The same everywhere, as SUNDOG_material says it."""
    scattered, absorbed, g = medium
    return {"absorption": absorbed, "scatterers": [{"coefficient": scattered, "phase": "henyey-greenstein", "anisotropy": g}]}


def homogeneous(medium):
    """The same for Mitsuba."""
    scattered, absorbed, g = (numpy.array(v) for v in medium)
    sigma = scattered + absorbed
    albedo = numpy.divide(scattered, sigma, where=sigma > 0, out=numpy.zeros(3))
    return {
        "type": "homogeneous", "sigma_t": {"type": "rgb", "value": (sigma / sigma.max()).tolist()}, "scale": float(sigma.max()),
        "albedo": {"type": "rgb", "value": albedo.tolist()}, "phase": {"type": "hg", "g": float(g)},
    }  # fmt: skip


def faces(points, triangles, folder, **media):
    """A mesh whose sides bound media."""
    name = os.path.join(folder, f"{len(os.listdir(folder))}.ply")
    mesh = mi.Mesh("box", len(points), len(triangles))
    values = mi.traverse(mesh)
    values["vertex_positions"] = numpy.array(points, "float32").ravel()
    values["faces"] = numpy.array(triangles, "uint32").ravel()
    values.update()
    mesh.write_ply(name)
    return {"type": "ply", "filename": name, "face_normals": True, "bsdf": {"type": "null"}, **media}


def density():
    """A cloud in 24³ points, with nothing at its borders."""
    at = (numpy.mgrid[0:24, 0:24, 0:24] + 0.5) / 12 - 1
    wave = 0.5 + 0.5 * numpy.sin(5 * at[0]) * numpy.cos(4 * at[1] + 1) * numpy.sin(6 * at[2] + 2)
    cloud = numpy.clip(1.1 - (at**2).sum(0), 0, 1) * wave * 6
    cloud[[0, -1]] = cloud[:, [0, -1]] = cloud[:, :, [0, -1]] = 0
    return cloud.astype("float32")


def scenes(folder):
    """Names, what Sundog gets and what Mitsuba gets."""
    ball = box((-1, -1, -1), (1, 1, 1))

    def one(*boxes):
        made = Gltf()
        for corners, medium in boxes:
            made.mesh(*corners, filled(even(medium)))
        return made

    yield "fog", one((ball, FOG)), {"fog": faces(*ball, folder, interior=homogeneous(FOG))}
    core = box((-0.5, -0.6, -0.5), (0.5, 0.4, 0.5))
    outer = homogeneous(THIN)
    inner = homogeneous(added(THIN, DENSE))
    yield "nested", one((ball, THIN), (core, DENSE)), {
        "outer": faces(*ball, folder, interior=outer),
        "inner": faces(*core, folder, interior=inner, exterior=outer),
    }  # fmt: skip
    # Four faces of each lie in those of the other.
    left, right = box((-1.5, -1, -1), (0.5, 1, 1)), box((-0.5, -1, -1), (1.5, 1, 1))
    parts = [((-1.5, -0.5), THIN), ((-0.5, 0.5), added(THIN, DENSE)), ((0.5, 1.5), DENSE)]
    overlapping = {}
    for number, ((a, b), medium) in enumerate(parts):
        points, triangles = box((a, -1, -1), (b, 1, 1))
        # Its sides along X are the last part's and the next one's, too: the first has the one, the last the other.
        sides = [t for i, t in enumerate(triangles) if i >= 4 or (number == 0 and i < 2) or (number == 2 and i >= 2)]
        overlapping[f"part{number}"] = faces(points, sides, folder, interior=homogeneous(medium))
        if number:
            # Seen from the left, as the first side of a box.
            behind = {"interior": homogeneous(medium), "exterior": homogeneous(parts[number - 1][1])}
            overlapping[f"between{number}"] = faces(points, triangles[:2], folder, **behind)
    yield "overlapping", one((left, THIN), (right, DENSE)), overlapping
    made, cloud = Gltf(), density()
    tree = {
        "blender": [5, 2, 0],
        "nodes": [
            {"type": "ShaderNodeAttribute", "properties": {"values": {"Fac": {"grid": 0, "kind": "vector", "interpolation": "linear", "otherwise": 0.0}}}},
            {"type": "ShaderNodeVolumeScatter", "inputs": {"Color": [0.8, 0.8, 0.8, 1], "Density": {"node": 0, "output": "Fac"}, "Anisotropy": 0.4}},
            {"type": "ShaderNodeVolumeAbsorption", "inputs": {"Color": [0.8, 0.8, 0.8, 1], "Density": {"node": 0, "output": "Fac"}}},
            {"type": "ShaderNodeAddShader", "inputs": {"Shader": {"node": 1, "output": "Volume"}, "Shader_001": {"node": 2, "output": "Volume"}}},
        ],
        "volume": {"node": 3, "output": "Shader"},
    }  # fmt: skip
    values = made.accessor(cloud.transpose(2, 1, 0).reshape(-1), "SCALAR")
    matrix = [1 / 12, 0, 0, 1 / 24 - 1, 0, 1 / 12, 0, 1 / 24 - 1, 0, 0, 1 / 12, 1 / 24 - 1]
    made.mesh(*ball, filled({"graph": tree}), grids=[{"number": 0, "name": "density", "accessor": values, "size": [24, 24, 24], "matrix": matrix}])
    grid = mi.VolumeGrid(cloud.transpose(2, 1, 0)[..., None])
    place = T().translate([-1, -1, -1]).scale(2)
    heterogeneous = {
        "type": "heterogeneous", "albedo": 0.8, "phase": {"type": "hg", "g": 0.4},
        "sigma_t": {"type": "gridvolume", "grid": grid, "to_world": place, "filter_type": "trilinear", "wrap_mode": "clamp"},
    }  # fmt: skip
    yield "grid", made, {"cloud": faces(*ball, folder, interior=heterogeneous)}


def by_mitsuba(media, samples):
    """Mitsuba's picture."""
    eye = T().look_at(origin=EYE, target=(EYE[0], EYE[1], 0), up=(0, 1, 0))
    film = {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "rfilter": {"type": "box"}, "pixel_format": "rgb", "component_format": "float32"}
    floor = {"type": "rectangle", "to_world": T().translate([0, -1.2, 0]).rotate([1, 0, 0], -90).scale(8)}
    scene = {
        "type": "scene", "integrator": {"type": "volpathmis", "max_depth": 64, "rr_depth": 16},
        "sensor": {"type": "perspective", "fov": numpy.degrees(YFOV), "fov_axis": "y", "to_world": eye, "film": film, "sampler": {"type": "independent", "sample_count": samples}},
        "world": {"type": "constant", "radiance": {"type": "rgb", "value": [WORLD] * 3}},
        "lamp": {"type": "point", "position": LAMP, "intensity": {"type": "rgb", "value": [INTENSITY] * 3}},
        "floor": {**floor, "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.5] * 3}}},
        **media,
    }  # fmt: skip
    return numpy.array(mi.render(mi.load_dict(scene), seed=7))


def by_sundog(program, path, samples):
    """Sundog's."""
    picture = path + ".exr"
    command = [program, "render", path, "-o", picture, "--width", WIDTH, "--height", HEIGHT, "--samples", samples, "--filter", "box"]
    command += ["--bounces", 64, "--bounces-diffuse", 64, "--bounces-volume", 64, "--exr-layers", "combined", "--quiet"]
    subprocess.run([str(word) for word in command], check=True)
    return numpy.array(mi.Bitmap(picture).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False))


def main():
    """Compares all scenes."""
    program = sys.argv[1] if len(sys.argv) > 1 else "target/release/sundog"
    samples = int(sys.argv[2]) if len(sys.argv) > 2 else 2048
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        for name, gltf, media in scenes(folder):
            floor = {
                "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0, "roughnessFactor": 1},
                "extensions": {"KHR_materials_specular": {"specularFactor": 0}},
            }  # fmt: skip
            gltf.mesh([(-8, -1.2, 8), (8, -1.2, 8), (8, -1.2, -8), (-8, -1.2, -8)], [(0, 1, 2), (0, 2, 3)], floor)
            place = os.path.join(folder, name)
            os.mkdir(place)
            ours = by_sundog(program, gltf.write(place), samples)
            theirs = by_mitsuba(media, samples)
            off = ours.mean((0, 1)) / theirs.mean((0, 1)) - 1
            error = ((ours - theirs) ** 2 / (theirs**2 + 0.01)).mean()
            print(f"{name}: {off[0]:+.2%} {off[1]:+.2%} {off[2]:+.2%}, relMSE {error:.1e}", flush=True)
            failed |= bool(abs(off).max() > 0.01 or error > 1e-3)
    sys.exit(failed)


if __name__ == "__main__":
    main()
