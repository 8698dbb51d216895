# SPDX-License-Identifier: MIT OR Apache-2.0
"""Small scenes in which code without care fails so that one sees it, for the pictures of docs/notes/hard-cases.md."""

import base64
import json
import math
import struct

import numpy as np

SIZE = (160, 120)
# Where four bounces are too few.
BOUNCES = {"bubble": 24, "room": 8}


def sphere(rings, smooth):
    """Corners, normals and triangles of a unit sphere."""
    theta, phi = np.meshgrid(np.linspace(0, math.pi, rings + 1), np.linspace(0, 2 * math.pi, 2 * rings + 1), indexing="ij")
    points = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], axis=-1)
    # The seam and the poles have the same bits from both sides.
    points[:, -1], points[0], points[-1] = points[:, 0], (0, 1, 0), (0, -1, 0)
    row, column = np.meshgrid(np.arange(rings), np.arange(2 * rings), indexing="ij")
    at = lambda r, c: r * (2 * rings + 1) + c
    upper = np.stack([at(row, column), at(row, column + 1), at(row + 1, column)], axis=-1)[1:]
    lower = np.stack([at(row, column + 1), at(row + 1, column + 1), at(row + 1, column)], axis=-1)[:-1]
    return points.reshape(-1, 3), points.reshape(-1, 3) if smooth else None, np.concatenate([upper.reshape(-1, 3), lower.reshape(-1, 3)])


def box():
    """A cube from -1 to 1."""
    corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], float)
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return corners, None, np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])


def ground(half):
    corners = np.array([[-half, 0, half], [half, 0, half], [half, 0, -half], [-half, 0, -half]], float)
    return corners, None, np.array([[0, 1, 2], [0, 2, 3]])


class File:
    """A .gltf under construction: lengths are multiplied by `scale`, all is moved by `center` metres along each axis."""

    def __init__(self, scale=1.0, center=0.0, sky=(0.0, 0.0, 0.0)):
        self.bytes = b""
        about = {"name": "About all", "children": [], "scale": [scale] * 3, "translation": [center] * 3}
        self.document = {
            "asset": {"version": "2.0"}, "scene": 0, "nodes": [about], "meshes": [], "materials": [], "cameras": [], "accessors": [], "bufferViews": [],
            "scenes": [{"nodes": [0], "extensions": {"SUNDOG_scene": {"world": {"color": list(sky)}}}}],
            "extensions": {"KHR_lights_punctual": {"lights": []}},
            "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_volume", "SUNDOG_light", "SUNDOG_scene"],
        }

    def add(self, kind, value):
        self.document[kind].append(value)
        return len(self.document[kind]) - 1

    def node(self, **what):
        self.document["nodes"][0]["children"].append(self.add("nodes", what))

    def numbers(self, values, kind, component, code):
        data = b"".join(struct.pack(f"<{len(row)}{code}" if np.ndim(row) else f"<{code}", *np.atleast_1d(row)) for row in values)
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data)})
        self.bytes += data
        bounds = {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()} if kind == "VEC3" else {}
        return self.add("accessors", {"bufferView": view, "componentType": component, "count": len(values), "type": kind, **bounds})

    def mesh(self, shape, color, emission=0.0, extensions=None, **place):
        points, normals, triangles = shape
        attributes = {"POSITION": self.numbers(points.astype(np.float32), "VEC3", 5126, "f")}
        if normals is not None:
            attributes["NORMAL"] = self.numbers(normals.astype(np.float32), "VEC3", 5126, "f")
        material = {"pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "metallicFactor": 0, "roughnessFactor": 0 if extensions else 1}, "doubleSided": True, "emissiveFactor": [emission] * 3,
                    "extensions": extensions or {"KHR_materials_specular": {"specularFactor": 0}}}
        primitive = {"attributes": attributes, "indices": self.numbers(triangles.reshape(-1), "SCALAR", 5125, "I"), "material": self.add("materials", material)}
        self.node(mesh=self.add("meshes", {"primitives": [primitive]}), **place)

    def sun(self, strength, direction_turn):
        lights = self.document["extensions"]["KHR_lights_punctual"]["lights"]
        lights.append({"type": "directional", "intensity": 1, "extensions": {"SUNDOG_light": {"strength": [strength] * 3}}})
        self.node(rotation=direction_turn, extensions={"KHR_lights_punctual": {"light": len(lights) - 1}})

    def camera(self, at, turn, fov):
        lens = {"yfov": fov, "aspectRatio": SIZE[0] / SIZE[1], "znear": 1e-9}
        self.node(camera=self.add("cameras", {"type": "perspective", "perspective": lens}), translation=at, rotation=turn)

    def write(self, path):
        data = base64.b64encode(self.bytes).decode()
        self.document["buffers"] = [{"byteLength": len(self.bytes), "uri": f"data:application/octet-stream;base64,{data}"}]
        with open(path, "w") as file:
            json.dump({name: value for name, value in self.document.items() if value != []}, file)


def turned(x=0.0, y=0.0):
    """A rotation about x, and then about y, in degrees, as a quaternion."""
    (sx, cx), (sy, cy) = ((math.sin(math.radians(a) / 2), math.cos(math.radians(a) / 2)) for a in (x, y))
    return [cy * sx, sy * cx, -sy * sx, cy * cx]


def still_life(**about):
    file = File(sky=(0.3, 0.35, 0.45), **about)
    file.mesh(ground(6.0), (0.6, 0.6, 0.6))
    file.mesh(sphere(48, True), (0.7, 0.25, 0.15), translation=[-0.6, 1, 0])
    file.mesh(box(), (0.2, 0.4, 0.7), translation=[1.1, 0.6, 0.4], scale=[0.6] * 3, rotation=turned(y=30))
    file.sun(3.0, turned(x=-50, y=40))
    file.camera([0, 2.4, 6.5], turned(x=-15), 0.55)
    return file


def huge():
    """A still life of 100 km: a ten-thousandth of a metre is less than its points are known to."""
    return still_life(scale=3e4)


def far():
    """A still life at 300 km from the origin, where f32 has steps of 3 cm."""
    return still_life(center=3e5)


def tiny():
    """A still life of a tenth of a millimetre: a ten-thousandth of a metre is as large as its ball."""
    return still_life(scale=1e-4)


def coarse():
    """A coarse smooth ball, lit from the side."""
    file = File(sky=(0.02, 0.02, 0.02))
    file.mesh(sphere(7, True), (0.8, 0.8, 0.8))
    file.sun(3.0, turned(x=-20, y=75))
    file.camera([0, 0, 4.4], turned(), 0.55)
    return file


def distant():
    """A still life of 10 cm from 137 km away, in a field of 9e-5 degrees."""
    file = still_life(scale=0.05)
    away, down = 137e3 / 0.05, math.radians(15)
    file.document["nodes"][-1]["translation"] = [0, 0.7 + away * math.sin(down), away * math.cos(down)]
    file.document["cameras"][0]["perspective"]["yfov"] = 4.2 / away
    return file


GLASS = {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": {"thicknessFactor": 1}}


def bubble():
    """A hollow ball of glass whose wall is a 20 000th of its radius, over the still life's ground."""
    file = File(sky=(0.3, 0.35, 0.45))
    file.mesh(ground(6.0), (0.6, 0.6, 0.6))
    file.mesh(box(), (0.2, 0.4, 0.7), translation=[0.9, 0.6, -2.0], scale=[0.6] * 3, rotation=turned(y=30))
    points, normals, triangles = sphere(64, True)
    file.mesh((points, normals, triangles), (1, 1, 1), extensions=GLASS, translation=[0, 1, 0])
    file.mesh((points * (1 - 5e-5), -normals, triangles[:, ::-1]), (1, 1, 1), extensions=GLASS, translation=[0, 1, 0])
    file.sun(3.0, turned(x=-50, y=40))
    file.camera([0, 2.0, 6.0], turned(x=-11), 0.5)
    return file


def attic():
    """A prism: its roof meets its floor at 35 degrees."""
    ridge = math.tan(math.radians(35))
    corners = np.array([[x, y, z] for z in (-1, 1) for x, y in ((-1, 0), (1, 0), (0, ridge))], float)
    return corners, None, np.array([[0, 1, 2], [3, 5, 4], [0, 3, 4], [0, 4, 1], [1, 4, 5], [1, 5, 2], [2, 5, 3], [2, 3, 0]])


def room():
    """A closed attic of 2 mm under a bright sky, with a lamp of its own."""
    file = File(scale=1e-3, sky=(8.0, 8.0, 8.0))
    file.mesh(attic(), (0.6, 0.6, 0.6))
    file.mesh(sphere(24, True), (0, 0, 0), 4.0, translation=[0.0, 0.45, -0.3], scale=[0.12] * 3)
    file.camera([0.1, 0.25, 0.9], turned(x=-5, y=15), 1.2)
    return file


# Name -> (scene, the part that is left out, samples a pixel, case of the page, what one sees without it).
SCENES = {
    "huge": (huge, "offsets", 64, "scaled", "Rays meet the surface that they leave: acne."),
    "tiny": (tiny, "offsets", 64, "scaled", "Rays start on the other side of what is near: shadows are lost or elsewhere."),
    "far": (far, "origin", 64, "moved", "Corners and cameras stand on a grid of 3 cm."),
    "coarse": (coarse, "terminator", 64, "shadow-terminator", "Facets that look away from the sun are black, although their normals see it."),
    "distant": (distant, "origin", 64, "narrow-fields", "From 137 km away, in a field of 9e-5 degrees: rays and corners are on a grid of 8 mm."),
    "bubble": (bubble, "offsets", 64, "touching-interfaces", "A bubble of glass, its wall a 20 000th of its radius: rays step over the wall's other side, and see a solid ball."),
    "room": (room, "offsets", 64, "closed-rooms", "A closed room of 2 mm: rays that start in its corners start outside, under a bright sky."),
}
