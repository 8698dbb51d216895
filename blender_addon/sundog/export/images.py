# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's images as files: the original where the program reads it as Blender does, or a copy in
the cache folder."""

import hashlib
import json
import os
import struct
import tempfile
import zlib

import bpy
import numpy

from . import baker, colorspace, gltf

LINEAR_SPACES = {"Linear Rec.709", "Linear", "Non-Color", "Raw", "Generic Data", "scene_linear", "Linear BT.709"}
DATA_SPACES = {"Non-Color", "Raw", "Generic Data"}

_MAGIC = [(b"\x89PNG", ".png"), (b"\xff\xd8\xff", ".jpg"), (b"\x76\x2f\x31\x01", ".exr"), (b"#?", ".hdr")]


# The colour that Cycles shows for images that it cannot find.
MISSING = (1.0, 0.0, 1.0)


class ImageError(Exception):
    """An image that cannot be exported, in one sentence."""


def kind_of(data):
    """The file name extension of data that the program reads, by its first bytes; or None."""
    for magic, extension in _MAGIC:
        if data.startswith(magic):
            return extension
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return ".webp"
    return None


def is_whole(path):
    """Whether a file is not cut off, as far as its end tells."""
    with open(path, "rb") as file:
        extension = kind_of(file.read(16))
        file.seek(max(file.seek(0, os.SEEK_END) - 4096, 0))
        end = file.read()
    return {".png": b"IEND", ".jpg": b"\xff\xd9"}.get(extension, b"") in end


class Picture:
    """One picture of a sequence of files, or one tile, with what is asked of images here."""

    source, library, is_dirty, has_data = "FILE", None, False, False

    def __init__(self, image, path, packed=None):
        self.name, self.name_full = image.name, image.name_full
        self.colorspace_settings, self.alpha_mode = image.colorspace_settings, image.alpha_mode
        self.filepath_raw, self.packed_file = path, packed
        start = _first_bytes(path) if packed is None else bytes(packed.data[:4096])
        self.is_float = kind_of(start) in {".exr", ".hdr"}
        # Width and height stand in a PNG's header; of other kinds the pixels are read by the program alone.
        is_png = kind_of(start) == ".png" and is_whole(path)
        self.size = struct.unpack(">II", start[16:24]) if is_png else (0, 0)

    # Of a movie.
    frame = 1

    def as_pointer(self):
        """Another one for each picture."""
        return hash((self.filepath_raw, self.frame))


class Frame(Picture):
    """A frame of a movie, from 1 on. Cycles has it from Blender, in 8 bits."""

    source = "MOVIE"

    def __init__(self, image, path, frame):
        super().__init__(image, path)
        self.frame, self.is_float = frame, False


def picture_of(image, user):
    """The image that a node shows: of a sequence or a movie the picture of the frame."""
    if image.source not in {"SEQUENCE", "MOVIE"} or image.packed_file is not None or not image.filepath_raw:
        return image
    frame = _frame_of(user, bpy.context.scene.frame_current)
    if image.source == "MOVIE":
        frame = max(1, min(frame, image.frame_duration))
        return Frame(image, bpy.path.abspath(image.filepath_raw, library=image.library), frame)
    # Without "Auto Refresh" it stands still in Blender, but not in Cycles.
    if user.frame_current != frame:
        user.frame_current = frame
    return Picture(image, bpy.path.abspath(image.filepath_from_user(image_user=user), library=image.library))


def _frame_of(user, frame):
    """The number of the picture that is shown in a frame of the scene, as Blender counts them."""
    length = user.frame_duration
    if not length:
        return 0
    frame += 1 - user.frame_start
    if user.use_cyclic:
        frame = frame % length or length
    return max(0, min(frame, length)) + user.frame_offset


def tiles_of(image):
    """The pictures of a UDIM image by the numbers of their tiles, None for those that are missing."""
    found = {}
    packed = {os.path.basename(file.filepath): file.packed_file for file in image.packed_files}
    for tile in image.tiles:
        across, up = (tile.number - 1001) % 10 + 1, (tile.number - 1001) // 10 + 1
        path = bpy.path.abspath(image.filepath_raw, library=image.library)
        path = path.replace("<UDIM>", str(tile.number)).replace("<UVTILE>", f"u{across}_v{up}")
        inside = packed.get(os.path.basename(path))
        whole = inside is not None or (os.path.isfile(path) and is_whole(path))
        found[tile.number] = Picture(image, path, inside) if whole else None
    return found


def are_tiles_saved(image):
    """Whether the tiles of a UDIM image are elsewhere than in Blender's memory alone."""
    return bool(image.filepath_raw) and not image.is_dirty


def _first_bytes(path):
    try:
        with open(path, "rb") as file:
            return file.read(4096)
    except OSError:
        return b""


def has_blocks(data):
    """Whether an OpenEXR file's data says where its first lines are: Blender 5.2 packs images with nothing but zeros there."""
    try:
        at = 8
        while data[at]:
            # An attribute: its name and its type, each ended by a zero, its size, its value.
            at = data.index(b"\0", data.index(b"\0", at) + 1) + 1
            at += 4 + struct.unpack_from("<I", data, at)[0]
        return any(data[at + 1 : at + 9])
    except (IndexError, ValueError, struct.error):
        return False


def file_of(image):
    """The image's file on disk, or None (packed, generated, or away)."""
    if image.source not in {"FILE", "SEQUENCE", "TILED", "MOVIE"} or not image.filepath_raw:
        return None
    path = bpy.path.abspath(image.filepath_raw, library=image.library)
    if image.source == "TILED":
        path = path.replace("<UDIM>", "1001").replace("<UVTILE>", "u1_v1")
    return path if os.path.isfile(path) else None


def is_missing(image):
    """Whether the image's file is away or cannot be read, and nothing of it is in memory."""
    if image.source not in {"FILE", "SEQUENCE", "TILED", "MOVIE"} or image.packed_file is not None or image.has_data:
        return False
    if image.source == "TILED":
        return are_tiles_saved(image) and not any(tiles_of(image).values())
    path = file_of(image)
    return (path is None or not is_whole(path)) and not image.size[0]


def _packed(image):
    packed = image.packed_file
    return bytes(packed.data) if packed is not None and packed.size else None


def identity(image):
    """Equal for images with the same pixels, as far as that is known without reading them."""
    base = [image.name_full, image.colorspace_settings.name, image.alpha_mode, image.source]
    if colorspace.working_space() != colorspace.REC709:
        # What is made of the pixels is in that space.
        base.append(colorspace.working_space())
    if not image.is_dirty:
        if image.packed_file is not None:
            return [*base, hashlib.sha1(_packed(image) or b"").hexdigest()]
        path = file_of(image)
        if path is not None:
            status = os.stat(path)
            base.append(getattr(image, "frame", 1))
            return [*base, os.path.realpath(path), status.st_mtime_ns, status.st_size]
    return [*base, hashlib.sha1(_raw_pixels(image).tobytes()).hexdigest()]


def _raw_pixels(image):
    width, height = image.size
    if isinstance(image, Picture):
        return _decoded(image)
    if width == 0 or height == 0:
        raise ImageError(f"the image \"{image.name}\" has no pixels (its file is missing or cannot be read)")
    values = numpy.empty(width * height * image.channels, numpy.float32)
    image.pixels.foreach_get(values)
    values = values.reshape(height, width, image.channels)
    if image.channels == 1:
        values = numpy.repeat(values, 3, axis=2)
    if values.shape[2] == 3:
        values = numpy.concatenate([values, numpy.ones((height, width, 1), numpy.float32)], axis=2)
    return values


# What another Blender has read, by the identities of the pictures: the last ones.
_read = {}


def _decoded(picture):
    """The numbers of a picture, height × width × 4 as they are coded, from 0 to 1, the bottom row first."""
    try:
        data = bytes(picture.packed_file.data) if picture.packed_file is not None else None
        if data is None:
            with open(picture.filepath_raw, "rb") as file:
                data = file.read()
        if kind_of(data) == ".png" and picture.source != "MOVIE":
            values = _decoded_png(data)
            if values is not None:
                return values
    except OSError as error:
        raise ImageError(f"the picture {picture.filepath_raw} of \"{picture.name}\" cannot be read ({error.strerror})") from error
    return _read_by_blender(picture)


def _read_by_blender(picture):
    """The same by another Blender: this one has no pictures of its own to read them into while it renders."""
    key = json.dumps(identity(picture))
    if key not in _read:
        with tempfile.TemporaryDirectory(prefix="sundog-image-") as folder:
            path, out = picture.filepath_raw, os.path.join(folder, "numbers.npy")
            if picture.packed_file is not None:
                path = os.path.join(folder, os.path.basename(path) or "packed")
                gltf.write_whole(path, bytes(picture.packed_file.data))
            try:
                baker.ask({"picture": path, "frame": picture.frame, "out": out})
            except baker.BakeError as error:
                raise ImageError(f"the picture {picture.filepath_raw} of \"{picture.name}\" cannot be read: {error}") from error
            while len(_read) > 3:
                _read.pop(next(iter(_read)))
            _read[key] = numpy.load(out)
    return _read[key].copy()


def _decoded_png(data):
    """The numbers of a PNG (ISO/IEC 15948); None for kinds that are rare."""
    chunks, place = {}, 8
    while place + 8 <= len(data):
        (length,) = struct.unpack(">I", data[place : place + 4])
        kind = data[place + 4 : place + 8]
        chunks[kind] = chunks.get(kind, b"") + data[place + 8 : place + 8 + length]
        place += 12 + length
    width, height, bits, kind, _, _, interlaced = struct.unpack(">IIBBBBB", chunks.get(b"IHDR", b"").ljust(13, b"\0")[:13])
    channels = {0: 1, 2: 3, 4: 2, 6: 4}.get(kind)
    if channels is None or bits not in {8, 16} or interlaced or b"tRNS" in chunks:
        return None
    step = channels * bits // 8
    line = width * step
    try:
        raw = zlib.decompressobj().decompress(chunks.get(b"IDAT", b""), height * (line + 1))
    except zlib.error:
        return None
    if len(raw) != height * (line + 1):
        return None
    rows = numpy.frombuffer(raw, numpy.uint8).reshape(height, line + 1)
    values = numpy.zeros((height + 1, line), numpy.uint8)
    for number, row in enumerate(rows):
        values[number + 1] = _unfiltered(int(row[0]), row[1:], values[number], step)
    values = values[1:].reshape(height, width, step)
    if bits == 16:
        values = values.reshape(height, width, channels, 2).astype(numpy.float32) @ numpy.array([256, 1], numpy.float32) / 65535
    else:
        values = values.astype(numpy.float32) / 255
    color, alpha = (values[..., :-1], values[..., -1:]) if channels in {2, 4} else (values, numpy.ones_like(values[..., :1]))
    return numpy.concatenate([numpy.broadcast_to(color, (height, width, 3)), alpha], axis=2)[::-1].copy()


def _unfiltered(kind, row, above, step):
    """A row of a PNG without its filter; `step` is the width of a pixel in bytes."""
    if kind == 0:
        return row
    if kind == 2:
        return row + above
    if kind == 1:
        return numpy.cumsum(row.reshape(-1, step), axis=0, dtype=numpy.uint8).reshape(-1)
    # Each pixel asks for the one before it.
    result, wide, upper = numpy.zeros(len(row) + step, numpy.int32), row.astype(numpy.int32), numpy.zeros(len(row) + step, numpy.int32)
    upper[step:] = above
    for at in range(0, len(row), step):
        left, up, corner = result[at : at + step], upper[at + step : at + 2 * step], upper[at : at + step]
        if kind == 3:
            guess = (left + up) // 2
        else:
            a, b, c = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
            guess = numpy.where((a <= b) & (a <= c), left, numpy.where(b <= c, up, corner))
        result[at + step : at + 2 * step] = (wide[at : at + step] + guess) & 255
    return result[step:].astype(numpy.uint8)


def decode_srgb(values):
    """sRGB's transfer function, IEC 61966-2-1."""
    return numpy.where(values <= 0.04045, values / 12.92, ((numpy.maximum(values, 0) + 0.055) / 1.055) ** 2.4)


def start_of(image):
    """The first bytes of the image's file, or None."""
    packed = None if image.is_dirty else image.packed_file
    if packed is not None and packed.size:
        return bytes(packed.data[:4096])
    path = None if image.is_dirty else file_of(image)
    if path is None:
        return None
    with open(path, "rb") as file:
        return file.read(4096)


def may_have_alpha(image):
    """Whether some texels may be less than opaque, as far as the file's start tells."""
    start = start_of(image)
    kind = kind_of(start) if start else None
    if kind == ".png":
        # Colour types 4 and 6 have alpha, and palettes may by a chunk of their own.
        return start[25] in {4, 6} or b"tRNS" in start
    return kind not in {".jpg", ".hdr"}


def holds_floats(image):
    """Whether the image's numbers are floats, without loading it where its file's start tells: Blender decodes the whole image
    to say so, which takes half a second for 4096 x 4096 pixels."""
    if not isinstance(image, Picture) and not image.has_data and image.source in {"FILE", "TILED"}:
        start = start_of(image) or b""
        # Blender reads PNG of 16 bits as floats, and other kinds as it may.
        if kind_of(start) == ".jpg" or (kind_of(start) == ".png" and start[24:25] == b"\x08"):
            return False
    return image.is_float


# Whether the images of a session are opaque, by their identity.
_opaque = {}


def has_straight_alpha(image):
    """Whether alpha says how opaque the colours of this image are, as far as its settings and the file's start tell."""
    if image.alpha_mode in {"NONE", "CHANNEL_PACKED"} or image.colorspace_settings.name in DATA_SPACES:
        return False
    return may_have_alpha(image)


def multiplies(image):
    """Whether Cycles shows the colour of this image multiplied with its alpha where no node asks for the alpha."""
    if not has_straight_alpha(image):
        return False
    if isinstance(image, Picture) and image.is_float:
        # Its file holds them so, and no other is made of it.
        return True
    key = str(identity(image))
    if key not in _opaque:
        _opaque[key] = bool((_raw_pixels(image)[..., 3] >= 1).all())
    return not _opaque[key]


def is_associated(image):
    """Whether the file holds colours multiplied with alpha, as OpenEXR does."""
    start = start_of(image)
    floats = kind_of(start) == ".exr" if start else image.is_float
    return floats and multiplies(image)


def linear_pixels(image, multiplied=False, step=1):
    """Height × width × 4 linear floats, the bottom row first, as Cycles sees them; alpha as it is. One of `step` along each side.

    `multiplied`: the colour times alpha. Of images of integers Cycles multiplies the coded numbers, before decoding; those
    of floats hold it already, and are divided where it is not asked for.
    """
    values = _raw_pixels(image)
    if step > 1:
        values = values[step // 2 :: step, step // 2 :: step].copy()
    alpha = values[..., 3:]
    if image.is_float:
        if not multiplied and image.alpha_mode not in {"NONE", "CHANNEL_PACKED"}:
            numpy.divide(values[..., :3], alpha, out=values[..., :3], where=(alpha > 0) & (alpha < 1))
    elif multiplied:
        # Rounded down, as Cycles has it; the slack is for products that are whole.
        values[..., :3] = numpy.floor(values[..., :3] * alpha * 255 + 1e-3) / 255
    # The pixels of images of floats are in the working space already, or data.
    space = image.colorspace_settings.name
    if not image.is_float and space not in DATA_SPACES:
        if space not in LINEAR_SPACES | colorspace.LINEAR:
            values[..., :3] = decode_srgb(values[..., :3])
        values[..., :3] = colorspace.convert(values[..., :3], _linear_space(space))
    return values


def _linear_space(name):
    """The linear space that the numbers of an image of integers are in after decoding."""
    if name == "scene_linear":
        return colorspace.working_space()
    return name if name in colorspace.LINEAR else colorspace.REC709


def coded_pixels(image):
    """Height × width × 4 integers of 8 bits as they stand in an image of such, the top row first."""
    return numpy.round(_raw_pixels(image)[::-1] * 255).clip(0, 255).astype(numpy.uint8)


def codes_of(image):
    """The numbers of an image's file as Cycles reads them, the top row first: integers of 8 or 16 bits, or floats."""
    path = file_of(image)
    if path is None:
        raise ImageError(f"the image \"{image.name}\" has no file")
    values = _read_by_blender(image if isinstance(image, Picture) else Picture(image, path))[::-1]
    codes = values * 65535
    whole = numpy.round(codes)
    if (abs(codes - whole) < 0.02).all() and whole.min() >= 0 and whole.max() <= 65535:
        # Those of 8 bits are multiples of 65535 / 255.
        small = whole / 257
        return small.astype(numpy.uint8) if (small == numpy.round(small)).all() else whole.astype(numpy.uint16)
    return values


def is_exactly_known(image):
    """Whether the image's colour space is one that is followed exactly."""
    return image.colorspace_settings.name in LINEAR_SPACES | colorspace.LINEAR | {"sRGB"} or holds_floats(image)


def is_plain(image):
    """Whether a texture of the image's file is mixed between texels as Cycles does it: opaque colours or numbers of 8 or 16 bits."""
    is_known = image.colorspace_settings.name in {"sRGB", *DATA_SPACES} and image.source == "FILE"
    return is_known and kind_of(start_of(image) or b"") in {".png", ".jpg"} and not may_have_alpha(image)


def _read_as_blender_does(image, extension, as_data):
    space = image.colorspace_settings.name
    if extension in {".exr", ".hdr"}:
        # The program takes the numbers of floats for those of the scene.
        if space in DATA_SPACES | {"scene_linear"}:
            return True
        linear = _linear_space(space) if space in LINEAR_SPACES | colorspace.LINEAR else None
        return linear == colorspace.working_space()
    return space in DATA_SPACES if as_data else space == "sRGB"


def original(image, cache, as_data, any_space=False):
    """A file of the image that the program reads as Cycles reads the image, or None.

    `as_data`: the program takes it as numbers; otherwise 8- and 16-bit files are sRGB. `any_space`: the program is told its
    colour space.
    """
    if image.is_dirty or image.source not in {"FILE", "TILED"}:
        return None
    data = _packed(image)
    if data is not None:
        extension = kind_of(data)
        if extension is None or not (any_space or _read_as_blender_does(image, extension, as_data)):
            return None
        if extension == ".exr" and not has_blocks(data):
            return None
        path = os.path.join(cache, f"image-{hashlib.sha1(data).hexdigest()}{extension}")
        if not os.path.isfile(path):
            gltf.write_whole(path, data)
        return path
    path = file_of(image)
    if path is None or not is_whole(path):
        return None
    with open(path, "rb") as file:
        extension = kind_of(file.read(16))
    return path if extension and (any_space or _read_as_blender_does(image, extension, as_data)) else None


def write_png(path, values):
    """PNG of height × width × (3 or 4) integers of 8 or 16 bits, the top row first."""
    height, width, channels = values.shape
    bits = 16 if values.dtype == numpy.uint16 else 8
    if bits == 16:
        values = numpy.ascontiguousarray(values.astype(">u2")).view(numpy.uint8)
    rows = numpy.zeros((height, 1 + width * channels * bits // 8), numpy.uint8)
    rows[:, 1:] = values.reshape(height, -1)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, bits, {3: 2, 4: 6}[channels], 0, 0, 0)
    body = zlib.compress(rows.tobytes(), 1)
    gltf.write_whole(path, [b"\x89PNG\r\n\x1a\n", chunk(b"IHDR", header), chunk(b"IDAT", body), chunk(b"IEND", b"")])


def _fits_half(values):
    """Whether half floats hold an image: none beyond their largest number, and what is a thousandth of the brightest still a
    normal one (6e-5 and more), so that all that is seen beside it keeps its eleven bits."""
    largest = float(numpy.abs(values).max(initial=0.0))
    halves = numpy.finfo(numpy.float16)
    return largest == 0.0 or 1000.0 * float(halves.tiny) <= largest <= float(halves.max)


def write_exr(path, values, full=False):
    """OpenEXR (not compressed, one part, scan lines) of height × width × (3 or 4), top row first; half floats where they do, unless `full`.

    As "OpenEXR File Layout" describes it; channels in alphabetical order, each row by channel.
    """
    height, width, channels = values.shape
    names = ["B", "G", "R"] if channels == 3 else ["A", "B", "G", "R"]
    order = [2, 1, 0] if channels == 3 else [3, 2, 1, 0]

    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    kind, number = (1, "<f2") if not full and _fits_half(values) else (2, "<f4")
    channel_list = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", kind, 0, 1, 1) for n in names) + b"\0"
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = b"".join(
        [
            struct.pack("<ii", 20000630, 2),
            attribute("channels", "chlist", channel_list),
            attribute("compression", "compression", b"\0"),
            attribute("dataWindow", "box2i", box),
            attribute("displayWindow", "box2i", box),
            attribute("lineOrder", "lineOrder", b"\0"),
            attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
            attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
            attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)),
            b"\0",
        ]
    )
    largest = float(numpy.finfo(number).max)
    numbers = numpy.clip(values[..., order], -largest, largest).astype(number).transpose(0, 2, 1)
    line = width * channels * numbers.itemsize
    first = len(header) + 8 * height
    offsets = first + numpy.arange(height, dtype="<u8") * (line + 8)
    block = numpy.zeros((height, line + 8), numpy.uint8)
    block[:, :8] = numpy.stack([numpy.arange(height), numpy.full(height, line)], axis=1).astype("<i4").view(numpy.uint8)
    block[:, 8:] = numpy.ascontiguousarray(numbers).view(numpy.uint8).reshape(height, line)
    gltf.write_whole(path, [header, offsets.tobytes(), block.tobytes()])


def resized(values, height, width):
    """Bilinear, for bringing images of one material to one size."""
    if values.shape[:2] == (height, width):
        return values

    def places(new, old):
        at = numpy.clip((numpy.arange(new) + 0.5) * old / new - 0.5, 0, old - 1)
        low = numpy.floor(at).astype(int)
        return low, numpy.minimum(low + 1, old - 1), at - low

    y0, y1, fy = places(height, values.shape[0])
    x0, x1, fx = places(width, values.shape[1])
    fy, fx = fy[:, None, None], fx[None, :, None]
    top = values[y0][:, x0] * (1 - fx) + values[y0][:, x1] * fx
    low = values[y1][:, x0] * (1 - fx) + values[y1][:, x1] * fx
    return (top * (1 - fy) + low * fy).astype(values.dtype)
