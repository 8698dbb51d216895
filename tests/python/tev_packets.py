"""Writes the packets that tev's own client makes of the calls of tests/cli/tev.rs to the standard output."""

import sys

import numpy
from tevclient import packet

names = ["R", "G", "B", "A", "Debug Sample Count.X"]
values = ((numpy.arange(7 * 3 * 5, dtype=numpy.float32) - numpy.float32(20)) / numpy.float32(3)).astype(numpy.float32)
image = "Schnee – 雪.exr"
for made in (
    packet.create_image(image, 1280, 720, names),
    packet.update_image(image, values.reshape(3, 7, 5), names, 0, 301),
    packet.update_image("a b.exr", values.reshape(3, 35, 1), names, 0, 0),
):
    sys.stdout.buffer.write(made)
