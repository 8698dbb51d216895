# SPDX-License-Identifier: GPL-3.0-or-later
"""What the Object Info node tells of an object, for SUNDOG_object."""

import numpy


def describe(instance):
    """Colour, pass index and random number of an instance of the depsgraph."""
    shown = instance.object
    return {
        "color": [float(v) for v in shown.color],
        "pass_index": shown.pass_index,
        "random": random_number(instance.random_id % 0x100000000 if instance.is_instance else hash_of_name(shown.name)),
    }


def random_number(identity):
    """The number from 0 to 1 that Cycles makes of 32 bits."""
    return float(str(numpy.float32(identity) * numpy.float32(1 / 0x100000000)))


def hash_of_name(name):
    """The 32 bits that Cycles makes of an object's name: the name as a number of base 37, mixed with zero."""
    number = 0
    for byte in name.encode():
        number = (number * 37 + byte) % 0x100000000
    return _mixed(number, 0)


def _mixed(first, second):
    """Bob Jenkins' hash of two words, lookup3."""
    start = (0xDEADBEEF + (2 << 2) + 13) % 0x100000000
    words = [(start + first) % 0x100000000, (start + second) % 0x100000000, start]

    def step(to, by, turn):
        turned = (words[by] << turn | words[by] >> (32 - turn)) % 0x100000000
        words[to] = ((words[to] ^ words[by]) - turned) % 0x100000000

    for to, by, turn in ((2, 1, 14), (0, 2, 11), (1, 0, 25), (2, 1, 16), (0, 2, 4), (1, 0, 14), (2, 1, 24)):
        step(to, by, turn)
    return words[2]
