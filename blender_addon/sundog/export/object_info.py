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
    _finish(words)
    return words[2]


def _finish(words):
    def step(to, by, turn):
        turned = (words[by] << turn | words[by] >> (32 - turn)) % 0x100000000
        words[to] = ((words[to] ^ words[by]) - turned) % 0x100000000

    for to, by, turn in ((2, 1, 14), (0, 2, 11), (1, 0, 25), (2, 1, 16), (0, 2, 4), (1, 0, 14), (2, 1, 24)):
        step(to, by, turn)


def hashed_float(number):
    """The number from 0 to 1 that Cycles makes of one word."""
    start = (0xDEADBEEF + (1 << 2) + 13) % 0x100000000
    words = [(start + number) % 0x100000000, start, start]
    _finish(words)
    return random_number(words[2])


# Values that node trees ask of objects


def asked(node, output):
    """What an output asks of an object, as a tuple for `values`; None if it asks for none."""
    kind = node.bl_idname
    if kind == "ShaderNodeAttribute" and node.attribute_type in {"OBJECT", "INSTANCER"}:
        # The number is the mean.
        return (node.attribute_type, node.attribute_name, output == "Fac")
    if kind == "ShaderNodeTexCoord" and node.from_instancer and output in {"Generated", "UV"}:
        return ("INSTANCE", output)
    if kind == "ShaderNodeUVMap" and node.from_instancer:
        return ("INSTANCE", "UV")
    if kind == "ShaderNodeParticleInfo":
        return ("PARTICLE", output)
    return None


def values(instance, scene, every, wanted):
    """Four numbers for each of what is asked; zeros for those that are not wanted."""
    return [_value(instance, scene, *ask) if number in wanted else [0.0] * 4 for number, ask in enumerate(every)]


def _value(instance, scene, kind, name, is_mean=False):
    if kind == "PARTICLE":
        return _particle(instance, scene, name)
    if kind == "INSTANCE":
        if not instance.is_instance:
            return [0.0, 0.0, 0.0, 1.0]
        return [*(0.5 * v - 0.5 for v in instance.orco), 1.0] if name == "Generated" else [*instance.uv, 0.0, 1.0]
    places = []
    if kind == "INSTANCER" and instance.is_instance:
        places += [instance.particle_system and instance.particle_system.settings, instance.parent]
    shown = instance.object
    places += [shown, shown.data]
    found = attribute_of(places, name) or (0.0, 0.0, 0.0, 0.0)
    return [sum(found[:3]) / 3] * 4 if is_mean else list(found)


def attribute_of(places, name):
    """The four numbers of a custom property, or of another property by its path, of the first that has it; None if none has."""
    for place in places:
        if place is None:
            continue
        found = place.get(name)
        if found is None:
            try:
                found = place.path_resolve(name)
            except (ValueError, AttributeError, TypeError):
                continue
        numbers = _four(found)
        if numbers is not None:
            return numbers
    return None


def _four(found):
    if isinstance(found, (bool, int, float)):
        return (float(found),) * 3 + (1.0,)
    try:
        numbers = [float(v) for v in found]
    except (TypeError, ValueError):
        return None
    return (*numbers, *(0.0, 0.0, 0.0, 1.0)[len(numbers) :]) if 1 < len(numbers) <= 4 else None


def _particle(instance, scene, name):
    system = instance.particle_system if instance.is_instance else None
    index = instance.persistent_id[0] if system is not None else 0
    if name == "Random":
        return [random_number(_mixed(index, 0))] * 4
    if system is None or index >= len(system.particles):
        return [0.0] * 4
    particle = system.particles[index]
    frame = scene.frame_current + scene.frame_subframe
    vectors = {"Location": "location", "Velocity": "velocity", "Angular Velocity": "angular_velocity"}
    if name in vectors:
        return [*map(float, getattr(particle, vectors[name])), 1.0]
    number = {
        "Index": lambda: index, "Age": lambda: frame - particle.birth_time, "Lifetime": lambda: particle.lifetime, "Size": lambda: particle.size
    }[name]()  # fmt: skip
    return [float(number)] * 4
