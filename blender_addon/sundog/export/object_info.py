# SPDX-License-Identifier: GPL-3.0-or-later
"""What the Object Info node tells of an object, for SUNDOG_object."""

import re

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
    finish(words)
    return words[2]


def finish(words):
    """The last mixing of the three words, in place; they are integers or arrays of 32 bits."""

    def step(to, by, turn):
        turned = (words[by] << turn | words[by] >> (32 - turn)) & 0xFFFFFFFF
        words[to] = ((words[to] ^ words[by]) - turned) & 0xFFFFFFFF

    for to, by, turn in ((2, 1, 14), (0, 2, 11), (1, 0, 25), (2, 1, 16), (0, 2, 4), (1, 0, 14), (2, 1, 24)):
        step(to, by, turn)


def hashed_float(number):
    """The number from 0 to 1 that Cycles makes of one word."""
    start = (0xDEADBEEF + (1 << 2) + 13) % 0x100000000
    words = [(start + number) % 0x100000000, start, start]
    finish(words)
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


class Lamp:
    """What the nodes of a lamp ask of its object, which is the same all over the lamp."""

    # What a lamp has nothing of.
    NOTHING = {("NEW_GEOMETRY", "Tangent"), ("NEW_GEOMETRY", "Pointiness"), ("NEW_GEOMETRY", "Random Per Island"), ("WIREFRAME", "Fac")}

    def __init__(self, instance, scene, placed, layer):
        """`placed`: the Placed of the scene; `layer`: what has the view layer's attributes."""
        self.instance, self.scene, self.placed, self.layer = instance, scene, placed, layer

    def value(self, node, output):
        """The four numbers of an output; None where they are of no object."""
        nothing = (0.0, 0.0, 0.0, 0.0)
        if node.type == "OBJECT_INFO":
            return self._info(output)
        if (node.type, output) in self.NOTHING or node.type == "VERTEX_COLOR":
            return nothing
        if node.type == "ATTRIBUTE" and node.attribute_type == "VIEW_LAYER":
            return _mean_of(attribute_of(self.layer, node.attribute_name) or nothing, output == "Fac")
        if node.type == "ATTRIBUTE" and node.attribute_type == "GEOMETRY":
            # Vertices that are not there are opaque.
            return None if node.attribute_name == "generated" else (0.0, 0.0, 0.0, 1.0)
        ask = asked(node, output)
        return None if ask is None else _value(self.instance, self.scene, self.placed, *ask)

    def _info(self, output):
        told = describe(self.instance)
        number = {"Alpha": told["color"][3], "Object Index": told["pass_index"], "Material Index": 0.0, "Random": told["random"]}
        if output in number:
            return (float(number[output]),) * 4
        return (*(told["color"][:3] if output == "Color" else map(float, self.instance.matrix_world.translation)), 1.0)


def _mean_of(four, is_mean):
    return [sum(four[:3]) / 3] * 4 if is_mean else list(four)


def values(instance, scene, every, wanted, placed):
    """Four numbers for each of what is asked; zeros for those that are not wanted. `placed`: the Placed of the scene."""
    return [_value(instance, scene, placed, *ask) if number in wanted else [0.0] * 4 for number, ask in enumerate(every)]


def _value(instance, scene, placed, kind, name, is_mean=False):
    if kind == "PARTICLE":
        return _particle(instance, scene, name)
    if kind == "INSTANCE":
        if not instance.is_instance:
            return [0.0, 0.0, 0.0, 1.0]
        return [*(0.5 * v - 0.5 for v in instance.orco), 1.0] if name == "Generated" else [*instance.uv, 0.0, 1.0]
    places, found = [], None
    if kind == "INSTANCER" and instance.is_instance:
        found = placed.attribute(instance, name)
        places += [instance.particle_system and instance.particle_system.settings, instance.parent]
    shown = instance.object
    places += [shown, shown.data]
    found = found or attribute_of(places, name) or (0.0, 0.0, 0.0, 0.0)
    return _mean_of(found, is_mean)


class Placed:
    """The attributes of instances that geometry nodes place, read once for each object that places some."""

    # Numbers of a value by the type of an attribute, and where they are.
    KINDS = {
        "FLOAT": (1, "value"), "INT": (1, "value"), "BOOLEAN": (1, "value"), "FLOAT2": (2, "vector"), "FLOAT_VECTOR": (3, "vector"),
        "FLOAT_COLOR": (4, "color"), "BYTE_COLOR": (4, "color"),
    }  # fmt: skip
    # What says that there is no deeper level.
    NO_LEVEL = 0x7FFFFFFF

    def __init__(self):
        self._known = {}

    @staticmethod
    def can_read(parent):
        """Whether this Blender tells of such instances: from 4.5 on."""
        return hasattr(parent, "evaluated_geometry")

    @classmethod
    def misses(cls, parent, asked):
        """Whether some of what is asked may be of instances that this Blender does not tell of."""
        places = any(modifier.type == "NODES" for modifier in parent.modifiers)
        return places and any(ask[0] == "INSTANCER" for ask in asked) and not cls.can_read(parent)

    def attribute(self, instance, name):
        """The four numbers of an attribute of an instance; None if it has none of this name."""
        parent = instance.parent
        if parent is None or not self.can_read(parent) or not any(modifier.type == "NODES" for modifier in parent.modifiers):
            return None
        known = self._known.get(parent.name_full)
        if known is None:
            known = self._known[parent.name_full] = self._read(parent)
        rows, attributes = known
        if name not in attributes:
            return None
        # The last level is that of the object itself.
        levels = [v for v in instance.persistent_id if v != self.NO_LEVEL]
        row = rows.get(levels[-1], -1) if rows is not None else levels[-1]
        found = attributes[name]
        return [float(v) for v in found[row]] if levels and 0 <= row < len(found) else None

    def _read(self, parent):
        """The row of each identity (None: they are rows themselves), and four numbers a row by the names of attributes."""
        # What it holds is only there as long as itself.
        geometry = parent.evaluated_geometry()
        cloud = geometry.instances_pointcloud()
        if cloud is None:
            return None, {}
        rows, attributes = None, {}
        for attribute in cloud.attributes:
            width, where = self.KINDS.get(attribute.data_type, (0, ""))
            # Cycles has no places of instances, whatever the points that stand for them have.
            if not width or attribute.name == "position":
                continue
            count = len(attribute.data)
            given = numpy.empty(count * width, bool if attribute.data_type == "BOOLEAN" else numpy.float32)
            if attribute.name == "id":
                given = numpy.empty(count, numpy.int32)
            attribute.data.foreach_get(where, given)
            if attribute.name == "id":
                rows = {int(v): row for row, v in reversed(list(enumerate(given)))}
            four = numpy.zeros((count, 4))
            four[:, 3] = 1
            # A number stands for all three.
            four[:, : 3 if width == 1 else width] = given.reshape(count, width)
            attributes[attribute.name] = four
        return rows, attributes


def attribute_of(places, name):
    """The four numbers of a custom property, or of another property by its path, of the first that has it; None if none has."""
    for place in places:
        if place is None:
            continue
        found = place.get(name)
        if found is None:
            try:
                found = None if _is_element(place, name) else place.path_resolve(name)
            except (ValueError, AttributeError, TypeError):
                continue
        numbers = _four(found)
        if numbers is not None:
            return numbers
    return None


def _is_element(place, name):
    """Whether a path leads to one number of several, which is nothing to Blender."""
    whole = re.fullmatch(r"(.+)(\[\d+\]|\.[xyzwrgba])", name)
    if whole is None:
        return False
    try:
        return _four(place.path_resolve(whole[1])) is not None
    except (ValueError, AttributeError, TypeError):
        return False


def _four(found):
    if isinstance(found, (bool, int, float)):
        return (float(found),) * 3 + (1.0,)
    try:
        given = list(found)
        numbers = [float(v) for v in given]
    except (TypeError, ValueError):
        return None
    if any(isinstance(v, bool) for v in given):
        # Those of true and false alone are nothing to Blender.
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
