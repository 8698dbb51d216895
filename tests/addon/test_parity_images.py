# SPDX-License-Identifier: GPL-3.0-or-later
"""Image Texture and Normal Map beside Cycles: squares that shine with what an image gives, by both programs, from one scene."""

import math
import os
import struct
import unittest
import zlib

import bpy
import export_kit as kit
import numpy
from sundog.export import graph, images

# Squares a row, and pixels along a side of one: two for each texel of an image of 8 × 8 that is shown twice.
ROW, SIDE = 8, 32
# The ends of the texture coordinates along a square: what lies around the image is seen, too.
FROM, TO = -0.5, 1.5


def png(path, values, bits=8, palette=None, transparency=None):
    """A PNG of height × width × channels integers, the top row first; of a palette the numbers of its colours."""
    height, width, channels = values.shape
    kind = 3 if palette is not None else {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    rows = values.reshape(height, -1)
    if bits == 16:
        rows = rows.astype(">u2").view(numpy.uint8).reshape(height, -1)
    elif bits < 8:
        per = 8 // bits
        padded = numpy.zeros((height, -(-rows.shape[1] // per) * per), numpy.uint8)
        padded[:, : rows.shape[1]] = rows
        shifts = numpy.arange(per - 1, -1, -1) * bits
        rows = (padded.reshape(height, -1, per) << shifts).sum(axis=2).astype(numpy.uint8)
    body = numpy.zeros((height, 1 + rows.shape[1]), numpy.uint8)
    body[:, 1:] = rows

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, 0)))
        if palette is not None:
            file.write(chunk(b"PLTE", bytes(numpy.asarray(palette, numpy.uint8).ravel())))
        if transparency is not None:
            file.write(chunk(b"tRNS", bytes(transparency)))
        file.write(chunk(b"IDAT", zlib.compress(body.tobytes())) + chunk(b"IEND", b""))


def texels(height, width, channels, most=255, seed=1, premultiplied=False):
    """Random codes; some texels are transparent, some opaque, most between the two."""
    rng = numpy.random.default_rng(seed)
    values = rng.integers(most // 4, most + 1, (height, width, channels))
    if channels in {2, 4}:
        share = rng.random((height, width))
        values[..., -1] = numpy.where(share < 0.1, 0, numpy.where(share > 0.8, most, values[..., -1]))
    if premultiplied:
        values[..., :-1] = values[..., :-1] * values[..., -1:] // most
    return values


class ImageParity(kit.ExportTest):
    """What both programs show of images."""

    def setUp(self):
        super().setUp()
        self.write_graphs(True)
        self.materials = []

    def path(self, name):
        """A file in the test's folder."""
        return os.path.join(self.folder, name)

    def file(self, name, values, **settings):
        """An image of a PNG of these codes. `settings`: of the image, those of the file are `bits`, `palette` and `transparency`."""
        of_file = {k: settings.pop(k) for k in ("bits", "palette", "transparency") if k in settings}
        png(self.path(name + ".png"), values, **of_file)
        return self.loaded(self.path(name + ".png"), **settings)

    @staticmethod
    def loaded(path, space=None, packed=False, **settings):
        """The image of a file."""
        image = bpy.data.images.load(path, check_existing=False)
        if space:
            image.colorspace_settings.name = space
        for key, value in settings.items():
            setattr(image, key, value)
        if packed:
            image.pack()
        return image

    def shown(self, name, image, output="Color", coordinates="changed", read=(), **properties):
        """A material that shines with what an image gives. `coordinates`: "changed" by a node that no glTF has a word for,
        "none" linked, or (node, output). `read`: outputs that are read for a share of nothing."""
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        self.materials.append(material)
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        for key, value in properties.items():
            setattr(node, key, value)
        if coordinates == "changed":
            place, moved = tree.nodes.new("ShaderNodeUVMap"), tree.nodes.new("ShaderNodeVectorMath")
            moved.inputs[1].default_value = (0, 0, 0)
            tree.links.new(place.outputs[0], moved.inputs[0])
            tree.links.new(moved.outputs[0], node.inputs[0])
        elif coordinates != "none":
            place = tree.nodes.new(f"ShaderNode{coordinates[0]}")
            tree.links.new(place.outputs[coordinates[1]], node.inputs[0])
        emission, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(node.outputs[output], emission.inputs["Color"])
        for other in read:
            # Read, and without influence: powers of 1 are no constants to either program.
            power = tree.nodes.new("ShaderNodeMath")
            power.operation = "POWER"
            base = tree.nodes.new("ShaderNodeLightPath")
            tree.links.new(base.outputs["Is Camera Ray"], power.inputs[0])
            tree.links.new(node.outputs[other], power.inputs[1])
            tree.links.new(power.outputs[0], emission.inputs["Strength"])
        tree.links.new(emission.outputs[0], end.inputs["Surface"])
        return node

    def shape(self, name, number):
        """The object that shows a material."""
        mesh = kit.plane(name, 1.0)
        for corner, place in zip(mesh.uv_layers[0].data, [(FROM, FROM), (TO, FROM), (TO, TO), (FROM, TO)]):
            corner.uv = place
        return self.link(name, mesh)

    def compare(self, samples=256, error=1e-5, shape=None, flat=()):
        """Renders an object for each material by both programs; fails where one differs by more, or has no graph (those of `flat`
        need none)."""
        rows = math.ceil(len(self.materials) / ROW)
        size = max(rows, ROW)
        for number, material in enumerate(self.materials):
            line, column = divmod(number, ROW)
            made = (shape or self.shape)(f"square {number}", number)
            made.location = (column - (ROW - 1) / 2, line - (rows - 1) / 2, 0)
            made.data.materials.append(material)
        data = self.camera.data
        data.type, data.ortho_scale = "ORTHO", size
        cycles = self.scene.cycles
        kit.unbiased(cycles)
        cycles.max_bounces = 4
        width, height = ROW * SIDE, rows * SIDE
        kit.for_cycles(width, height, samples)
        found = self.export()
        seen = kit.cycles_pixels(width, height, samples)
        got = kit.rendered(found.path, width, height, samples)
        wrong = []
        for number, material in enumerate(self.materials):
            line, column = divmod(number, ROW)
            part = numpy.s_[line * SIDE : (line + 1) * SIDE, column * SIDE : (column + 1) * SIDE]
            # Without the border, where squares meet.
            a, b = got[part][2:-2, 2:-2], seen[part][2:-2, 2:-2]
            differs = float(((a - b) ** 2 / (b**2 + 0.01)).mean())
            verdict = found.result.verdicts
            told = next((v for v in verdict if v["kind"] == "material" and v["name"] == material.name), {})
            graphs = "SUNDOG_shader_graph" in found.material(material.name)["extensions"]
            words = f"{material.name}: mean {a.mean():.5f} against {b.mean():.5f}, relMSE {differs:.1e}{'' if graphs else ', flattened'}"
            bad = not differs <= error or not (graphs or material.name in flat)
            print(("MISS " if bad else "ok   ") + words, told.get("detail", "") if bad else "")
            if bad:
                wrong.append(f"{words} {told.get('detail', '')}")
        self.assertFalse(wrong, "\n" + "\n".join(wrong))
        return found

    def test_alpha(self):
        """All alpha modes, read and not read, of all kinds of files."""
        for name, channels in {"8 bits": 4, "grey": 1, "grey alpha": 2, "colours": 3}.items():
            modes = ("STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE") if channels in {2, 4} else ("STRAIGHT",)
            for mode in modes:
                values = texels(8, 8, channels, premultiplied=mode == "PREMUL" or (channels, mode) == (2, "STRAIGHT"))
                for space in ("sRGB", "Non-Color"):
                    image = self.file(f"{name} {mode} {space}", values, alpha_mode=mode, space=space)
                    for read in ((), ("Alpha",)):
                        self.shown(f"{name} {mode} {space} {'read' if read else ''}", image, read=read)
        self.compare()

    @kit.long
    def test_precisions(self):
        """16 bits, packed files, generated images, and OpenEXR."""
        for mode in ("STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"):
            premultiplied = mode == "PREMUL"
            values = texels(8, 8, 4, 65535, premultiplied=premultiplied)
            deep = self.file(f"deep {mode}", values, bits=16, alpha_mode=mode)
            packed = self.file(f"packed {mode}", texels(8, 8, 4, premultiplied=premultiplied), alpha_mode=mode, packed=True)
            deep_packed = self.file(f"deep packed {mode}", values, bits=16, alpha_mode=mode, packed=True)
            made = bpy.data.images.new(f"generated {mode}", 8, 8, alpha=True)
            made.pixels = (texels(8, 8, 4, seed=2, premultiplied=premultiplied) / 255).ravel().tolist()
            made.alpha_mode = mode
            path = self.path(f"float {mode}.exr")
            images.write_exr(path, texels(8, 8, 4, 1000, premultiplied=True).astype(numpy.float32) / [500, 500, 500, 1000])
            floats = self.loaded(path, alpha_mode=mode)
            floats_packed = self.loaded(path, alpha_mode=mode, packed=True)
            for image in (deep, packed, deep_packed, made, floats, floats_packed):
                for read in ((), ("Alpha",)):
                    self.shown(f"{image.name} {mode} {'packed' if image.packed_file else ''} {'read' if read else ''}", image, read=read)
        self.compare()

    def test_sampling(self):
        """All interpolations, extensions and projections."""
        image = self.file("image", texels(8, 8, 4))
        opaque = self.file("opaque", texels(8, 8, 3))
        grey = self.file("grey", texels(8, 8, 1))
        for way in ("Linear", "Closest", "Cubic", "Smart"):
            for beyond in ("REPEAT", "EXTEND", "CLIP", "MIRROR"):
                self.shown(f"{way} {beyond}", image, interpolation=way, extension=beyond)
                self.shown(f"{way} {beyond} read", image, interpolation=way, extension=beyond, read=("Alpha",))
        for of in (opaque, grey):
            self.shown(f"{of.name} clipped", of, extension="CLIP")
            self.shown(f"{of.name} clipped alpha", of, "Alpha", extension="CLIP")
            self.shown(f"{of.name} clipped without coordinates", of, coordinates="none", extension="CLIP")
        self.compare()

    def test_projections(self):
        """Images about balls, by coordinates of the object."""
        image = self.file("image", texels(8, 8, 4))
        for way in ("Linear", "Closest", "Cubic"):
            for beyond in ("REPEAT", "EXTEND", "CLIP", "MIRROR"):
                for projection in ("SPHERE", "TUBE", "BOX"):
                    for place in (("TexCoord", "Generated"), ("TexCoord", "Object")):
                        name = f"{way} {beyond} {projection} {place[1]}"
                        blend = 0.4 if beyond in {"REPEAT", "CLIP"} else 0
                        self.shown(name, image, coordinates=place, interpolation=way, extension=beyond, projection=projection, projection_blend=blend)
        self.shown("sphere by UV", image, coordinates="none", projection="SPHERE")
        # Where texels or sides of the box end, no two sets of samples of a pixel agree.
        self.compare(error=1e-3, shape=self.ball)

    def ball(self, name, number):
        """A ball that is scaled and turned."""
        bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.45, rotation=(0.5, 0.3, 0.2))
        made = bpy.context.object
        made.name, made.scale = name, (1.0, 0.9, 0.8)
        made.data.shade_smooth()
        return made

    def tiled(self, name, numbers, **settings):
        """A UDIM image."""
        for number in numbers:
            png(self.path(f"{name}.{number}.png"), texels(4, 4, 3, seed=number))
        image = bpy.data.images.load(self.path(f"{name}.{numbers[0]}.png"))
        image.source, image.filepath = "TILED", self.path(f"{name}.<UDIM>.png")
        for number in numbers:
            if number not in [t.number for t in image.tiles]:
                image.tiles.new(number)
        for key, value in settings.items():
            setattr(image, key, value)
        return image

    def test_tiles(self):
        """UDIM images, of files and packed, with tiles that are missing."""
        image = self.tiled("tiles", [1001, 1002, 1012])
        for way in ("Linear", "Closest"):
            for beyond in ("REPEAT", "CLIP"):
                self.shown(f"tiles {way} {beyond}", image, interpolation=way, extension=beyond)
        self.shown("tiles by UV", image, coordinates="none")
        self.shown("tiles generated", image, coordinates=("TexCoord", "Generated"))
        for projection in ("BOX", "SPHERE"):
            self.shown(f"tiles {projection}", image, coordinates=("TexCoord", "Object"), projection=projection)
        gone = self.tiled("gone", [1001, 1002, 1012])
        os.remove(self.path("gone.1012.png"))
        self.shown("a tile is gone", gone)
        packed = self.tiled("packed", [1001, 1002, 1012])
        packed.pack()
        self.shown("tiles packed", packed)
        self.compare()

    @kit.long
    def test_spaces(self):
        """Colour spaces of the configuration: transfer functions, primaries, logarithms."""
        spaces = ["Linear Rec.709", "Linear Rec.2020", "ACEScg", "ACES2065-1", "Display P3", "Rec.2020", "Rec.1886", "Filmic Log", "AgX Log"]
        spaces += ["sRGB", "Linear CIE-XYZ D65", "sRGB Encoded P3-D65", "Gamma 2.2 Encoded Rec.709", "ACEScct", "Filmic sRGB", "Non-Color"]
        probe = bpy.data.images.new("probe", 2, 2)
        known = [s.identifier for s in type(probe.colorspace_settings).bl_rna.properties["name"].enum_items]
        # Without what is fully transparent: before 5.0 Cycles' halves of 0 are not 0, and what is divided by them is white.
        for space in [s for s in spaces if s in known]:
            for bits, most in ((8, 255), (16, 65535)):
                image = self.file(f"{space} {bits}".replace("/", " "), numpy.maximum(texels(8, 8, 4, most) // [2, 2, 2, 1], most // 8), bits=bits, space=space)
                # Without interpolation the noise of sampling is none.
                self.shown(image.name, image, interpolation="Closest")
                self.shown(f"{image.name} read", image, interpolation="Closest", read=("Alpha",))
            packed = self.file(f"{space} packed", texels(8, 8, 3) // 2, space=space, packed=True)
            self.shown(packed.name, packed, interpolation="Closest")
            path = self.path(f"{space} float.exr")
            images.write_exr(path, texels(8, 8, 3, 1000).astype(numpy.float32) / 2500)
            self.shown(f"{space} float", self.loaded(path, space=space), interpolation="Closest")
        self.shown("linear between", self.file("between", texels(8, 8, 3), space="Display P3" if "Display P3" in known else "sRGB"))
        # Cycles keeps converted numbers as halves: those of logarithms have steps that are seen.
        self.compare(error=2e-5)

    def test_codes_in_floats(self):
        """Floats in sRGB are codes, too: Cycles interpolates them, and multiplies them with alpha, before it decodes them. (Between
        texels they were 19 to 30 % too bright, those with alpha up to three times.)"""
        for mode in ("STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"):
            path = self.path(f"codes {mode}.exr")
            # What is divided by next to no opacity is all there is to see.
            images.write_exr(path, numpy.maximum(texels(8, 8, 4, 1000), [0, 0, 0, 300]).astype(numpy.float32) / [700, 700, 700, 1000])
            for filtered in ("Linear", "Closest", "Cubic"):
                for read in ((), ("Alpha",)):
                    self.shown(f"codes {mode} {filtered} {'read' if read else ''}", self.loaded(path, alpha_mode=mode, space="sRGB"), read=read, interpolation=filtered)
        path = self.path("codes.exr")
        images.write_exr(path, texels(8, 8, 3, 1000).astype(numpy.float32) / 700)
        for space in ("sRGB", "Linear Rec.709", "Filmic sRGB", "Non-Color"):
            self.shown(f"codes without alpha {space}", self.loaded(path, space=space))
        self.compare()

    def test_mappings(self):
        """Texture mappings, which files of Blender before 2.8 have."""
        image = self.file("image", texels(8, 8, 3))
        for kind in ("POINT", "TEXTURE", "VECTOR", "NORMAL"):
            node = self.shown(f"mapping {kind}", image)
            mapping = node.texture_mapping
            mapping.vector_type, mapping.translation, mapping.rotation, mapping.scale = kind, (0.1, 0.2, 0.3), (0.3, 0.2, 0.5), (0.7, 1.3, 1)
        self.shown("mapping by UV", image, coordinates="none").texture_mapping.scale = (0.5, 0.7, 1)
        self.shown("axes", image).texture_mapping.mapping_x = "Y"
        self.shown("no axis", image).texture_mapping.mapping_y = "NONE"
        self.shown("flat", image).texture_mapping.scale = (0.9, 0, 1)
        tree = self.shown("noise", image).id_data
        noise = tree.nodes.new("ShaderNodeTexNoise")
        noise.texture_mapping.scale, noise.texture_mapping.translation = (0.5, 2, 1), (3, 0, 0)
        tree.links.new(noise.outputs["Color"], tree.nodes["Emission"].inputs["Color"])
        self.compare()

    def test_moving(self):
        """Sequences and movies: the picture of the frame, with an image user of its own."""
        for number in range(1, 6):
            png(self.path(f"frame{number:04}.png"), texels(4, 4, 3, seed=number))
        self.scene.frame_set(4)
        for name, settings in {
            "sequence": {}, "offset": {"frame_offset": 1}, "later": {"frame_start": 3}, "cyclic": {"frame_duration": 3, "use_cyclic": True},
            "ended": {"frame_duration": 2}, "not refreshed": {"use_auto_refresh": False},
        }.items():  # fmt: skip
            image = bpy.data.images.load(self.path("frame0001.png"))
            image.source = "SEQUENCE"
            user = self.shown(name, image).image_user
            user.frame_duration, user.use_auto_refresh = 5, True
            for key, value in settings.items():
                setattr(user, key, value)
        movie = self.movie()
        for name, offset in {"movie": 0, "another frame": 2, "before it": -9, "after it": 9}.items():
            user = self.shown(name, movie).image_user
            user.frame_duration, user.use_auto_refresh, user.frame_offset = 5, True, offset
        self.compare()

    def movie(self):
        """A movie of five frames."""
        scene = bpy.data.scenes.new("film")
        scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.collection.objects.link(scene.camera)
        scene.world = bpy.data.worlds.new("film")
        scene.world.use_nodes = True
        color = next(n for n in scene.world.node_tree.nodes if n.type == "BACKGROUND").inputs["Color"]
        for frame in range(1, 6):
            color.default_value = (frame / 5, 1 - frame / 5, 0.2, 1)
            color.keyframe_insert("default_value", frame=frame)
        render = scene.render
        render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 1, "CPU"
        scene.frame_start, scene.frame_end = 1, 5
        render.resolution_x = render.resolution_y = 16
        render.resolution_percentage = 100
        if hasattr(render.image_settings, "media_type"):
            render.image_settings.media_type = "VIDEO"
        render.image_settings.file_format = "FFMPEG"
        render.ffmpeg.format = "MKV"
        render.ffmpeg.codec = "FFV1"
        render.use_file_extension = False
        render.filepath = self.path("film.mkv")
        with kit.quiet():
            bpy.ops.render.render(animation=True, scene=scene.name)
        return bpy.data.images.load(render.filepath)

    def mapped(self, name, image, strength=1.0, **properties):
        """A material that shines with the normal of a map."""
        node = self.shown(name, image, coordinates="none")
        tree = node.id_data
        normal, half = tree.nodes.new("ShaderNodeNormalMap"), tree.nodes.new("ShaderNodeVectorMath")
        for key, value in properties.items():
            setattr(normal, key, value)
        half.operation = "MULTIPLY_ADD"
        half.inputs[1].default_value = half.inputs[2].default_value = (0.5, 0.5, 0.5)
        if isinstance(strength, str):
            # Linked to an image's number.
            tree.links.new(node.outputs["Alpha"], normal.inputs["Strength"])
        else:
            normal.inputs["Strength"].default_value = strength
        tree.links.new(node.outputs["Color"], normal.inputs["Color"])
        tree.links.new(normal.outputs[0], half.inputs[0])
        tree.links.new(half.outputs[0], tree.nodes["Emission"].inputs["Color"])

    @kit.long
    def test_normals(self):
        """Normal maps in all spaces, on what is smooth and scaled unevenly."""
        rng = numpy.random.default_rng(7)
        numbers = rng.integers(64, 192, (8, 8, 4))
        numbers[..., 2] = rng.integers(150, 256, (8, 8))
        image = self.file("normals", numbers, space="Non-Color")
        conventions = ["OPENGL", "DIRECTX"] if bpy.app.version >= (5, 1, 0) else [None]
        for convention in conventions:
            chosen = {"convention": convention} if convention else {}
            for space in ("TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD"):
                for strength in (1.0, 0.4, 2.0, 0.0, "linked"):
                    self.mapped(f"{space} {strength} {convention or ''}", image, strength, space=space, **chosen)
        self.mapped("of a map", image, uv_map="UVMap")

        def shape(name, number):
            # Hills that fill the square, of an object that is scaled unevenly, mirrored, or there more than once.
            bpy.ops.mesh.primitive_grid_add(x_subdivisions=8, y_subdivisions=8, size=1)
            made = bpy.context.object
            made.name = name
            scale = ((1, 1, 0.5), (-1, 1, 2), (0.5, 1, 1))[number % 3]
            for vertex in made.data.vertices:
                x, y, _ = vertex.co
                z = 0.1 * math.sin(7 * x + 1) * math.cos(5 * y)
                vertex.co = (x / scale[0], y / scale[1], z / scale[2])
            made.scale = scale
            made.data.shade_smooth()
            if number % 3 == 2:
                self.link(f"{name} again", made.data, location=(100, 0, 0))
            return made

        # In tangent space 5.2.3 differs by up to 4.4e-5, and 4.5.15 by 3e-7: why is not known yet.
        self.compare(shape=shape, error=1e-4 if bpy.app.version >= (5, 0, 0) else 1e-5)

    def through(self, name, image, kind, **inputs):
        """An image without coordinates of its own that shines through a node of that kind, all of which glTF could be told by a
        texture that is computed texel by texel."""
        node = self.shown(name, image, coordinates="none")
        tree, changed = node.id_data, node.id_data.nodes.new(f"ShaderNode{kind}")
        for key, value in inputs.items():
            changed.inputs[key.replace("_", " ")].default_value = value
        glow = node.outputs["Color"].links[0].to_socket
        tree.links.new(node.outputs["Color"], changed.inputs["Color"])
        tree.links.new(changed.outputs[0], glow)

    def test_what_textures_could_say(self):
        """Cycles mixes texels as they are coded, and computes with what comes of it: trees of which a texture could be made are
        written as they are, and images that are used as they are where their files say something else."""
        opaque, shares = texels(8, 8, 3), texels(8, 8, 4)
        self.shown("plain", self.file("plain", opaque), coordinates="none")
        for kind, inputs in (("HueSaturation", {"Saturation": 1.4}), ("Gamma", {"Gamma": 2.2}), ("Invert", {})):
            self.through(kind, self.file(kind, opaque), kind, **inputs)
        self.shown("with alpha", self.file("with alpha", shares), coordinates="none")
        made = bpy.data.images.new("generated", 8, 8)
        made.pixels = numpy.concatenate([opaque / 255, numpy.ones((8, 8, 1))], axis=2).ravel().tolist()
        self.shown("generated", made, coordinates="none")
        floats = self.path("floats.exr")
        images.write_exr(floats, (shares / [100, 100, 100, 255]).astype(numpy.float32))
        for space in ("Non-Color", "ACEScg", "Linear Rec.709"):
            self.shown(f"floats {space}", self.loaded(floats, space, alpha_mode="STRAIGHT"), coordinates="none")
        below = bpy.data.images.new("below nothing", 8, 8, float_buffer=True)
        below.pixels = numpy.concatenate([opaque / 100 - 1, numpy.ones((8, 8, 1))], axis=2).ravel().tolist()
        self.shown("below nothing", below, coordinates="none")
        # Noise of 64 samples is below 1e-4.
        found = self.compare(64, 2e-4, flat=("plain",))
        self.assertNotIn("SUNDOG_shader_graph", found.material("plain")["extensions"])

    def test_sizes(self):
        """Sizes and kinds of files that are rare."""
        for height, width in ((1, 1), (1, 7), (5, 3), (3, 5), (17, 31)):
            for channels in (1, 3, 4):
                image = self.file(f"{width} by {height} of {channels}", texels(height, width, channels))
                self.shown(image.name, image)
        palette = texels(1, 16, 3, seed=3)[0]
        for bits in (1, 2, 4, 8):
            count = min(2**bits, 16)
            values = numpy.random.default_rng(4).integers(0, count, (8, 8, 1))
            self.shown(f"palette of {count} by {bits}", self.file(f"palette {bits}", values, bits=bits, palette=palette[:count]))
            shares = numpy.random.default_rng(5).integers(0, 256, count)
            clear = self.file(f"clear palette {bits}", values, bits=bits, palette=palette[:count], transparency=shares.tolist())
            self.shown(f"clear palette of {count} by {bits}", clear)
            if bits < 8:
                grey = self.file(f"grey of {bits}", numpy.random.default_rng(4).integers(0, 2**bits, (8, 8, 1)), bits=bits)
                self.shown(grey.name, grey)
        self.shown("grey of 16", self.file("grey of 16", texels(8, 8, 1, 65535), bits=16))
        self.shown("colours of 16", self.file("colours of 16", texels(8, 8, 3, 65535), bits=16))
        self.compare(256)


if __name__ == "__main__":
    unittest.main()
