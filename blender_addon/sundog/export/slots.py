# SPDX-License-Identifier: GPL-3.0-or-later
"""The expressions of a material as glTF's factors and textures."""

import os

import numpy

from . import expressions, images
from .expressions import ONE, WHITE, Attribute, Const, Image, Operation, Unknown, as_color, multiply
from .verdicts import APPROXIMATED, LOST


class Slots:
    """Turns the expressions of one material into factors and textures."""

    def __init__(self, writer, reader, uvs=(), side=None):
        self.writer, self.reader = writer, reader
        # Textures that are made have so many pixels along each side at most; None for as many as the images have, 0 for none made.
        self.side, self.reduced = side, False
        # Whether some texture differs from what Cycles makes of the node tree: Cycles mixes texels as they are coded, and
        # computes with what comes of it.
        self.is_unlike = False
        self.uvs = list(uvs)
        self.attributes = []

    def attribute_name(self):
        """The colour attribute that the base colour uses, or None."""
        return self.attributes[0].name if self.attributes else None

    # Kinds of slots

    def constant(self, expression, what):
        """One number, whatever the expression."""
        if isinstance(expression, Const):
            return float(expression.value)
        self.reader.note(APPROXIMATED, f"{what} varies: its mean is used")
        return float(self._mean(expression).value)

    def color(self, expression, what):
        """(factor of 3, texture or None) of a colour slot."""
        expression = self._carried(as_color(expression), what)
        found = expressions.factors(expression)
        if found and not found[2]:
            constant, used, _ = found
            factor = numpy.broadcast_to(constant, 3)
            if not used:
                return factor, None
            if len(used) == 1 and not used[0].alpha:
                path = self._original(used[0].texture, False)
                if path:
                    return factor, self._texture(path, used[0].texture)
        return self._scaled(expression, used_as_data=False)

    def color_and_alpha(self, color, alpha):
        """Base colour and opacity: (expression, factor of 4, texture or None, attributes)."""
        color = self._carried(as_color(color), "the base colour", attributes=True)
        alpha = self._carried(alpha, "alpha", attributes=True)
        found, opacity = expressions.factors(color), expressions.factors(alpha)
        if found and opacity:
            constant, used, attributes = found
            constant_a, used_a, attributes_a = opacity
            names = {a.name for a in attributes + attributes_a}
            simple = (
                len(names) <= 1
                and len(attributes) <= 1
                and len(attributes_a) <= 1
                and all(a.alpha for a in attributes_a)
                and not any(a.alpha for a in attributes)
                and (not attributes_a or attributes)
                and len(used) <= 1
                and len(used_a) <= 1
                and not any(i.alpha for i in used)
            )
            if simple:
                factor = [*numpy.broadcast_to(constant, 3), float(constant_a)]
                self.attributes = attributes + attributes_a
                if not used and not used_a:
                    return color, factor, None, attributes
                if used and (not used_a or (used_a[0].alpha and used_a[0].texture.key() == used[0].texture.key())):
                    texture = used[0].texture
                    opaque = not used_a and not (isinstance(alpha, Const) and alpha.value >= 1)
                    path = None
                    if not (opaque and images.may_have_alpha(texture.image)):
                        path = self._original(texture, False)
                    if path:
                        return color, factor, self._texture(path, texture), attributes
                stripped = self._product(used, True)
                stripped_a = self._product(used_a, False)
                texture = self._bake(stripped, stripped_a, as_data=False)
                return color, factor, texture, attributes
        color = self._without_attributes(color)
        alpha = self._without_attributes(alpha)
        return color, [1.0, 1.0, 1.0, 1.0], self._bake(color, alpha, as_data=False), []

    def _product(self, used, color):
        result = WHITE if color else ONE
        for image in used:
            result = multiply(result, image)
        return result

    def metallic_roughness(self, metallic, roughness):
        """(metallic, roughness, texture or None): green is roughness, blue is metallic."""
        metallic = self._carried(metallic, "metallic")
        roughness = self._carried(roughness, "roughness")
        if isinstance(metallic, Const) and isinstance(roughness, Const):
            return self._unit(metallic), self._unit(roughness), None
        direct = self._direct_channels([(roughness, 1), (metallic, 2)])
        if direct:
            path, texture, (factor_r, factor_m) = direct
            return factor_m, factor_r, self._texture(path, texture)
        def part(expression):
            # A constant stays a factor, exactly.
            return (self._unit(expression), ONE) if isinstance(expression, Const) else (1.0, expression)
        factor_m, metallic = part(metallic)
        factor_r, roughness = part(roughness)
        packed = expressions.operation(
            "pack", lambda r, m: numpy.stack(numpy.broadcast_arrays(1.0, r, m), axis=-1), [roughness, metallic], True
        )
        return factor_m, factor_r, self._bake(packed, ONE, as_data=True)

    @staticmethod
    def _unit(expression):
        return min(max(float(expression.value), 0.0), 1.0)

    def _direct_channels(self, wanted):
        """Path, texture and factors if each expression is a constant, or the channel of that number of one
        and the same image, times a constant."""
        texture, result = None, []
        for expression, channel in wanted:
            if isinstance(expression, Const):
                result.append((self._unit(expression), False))
                continue
            factor = 1.0
            if isinstance(expression, Operation) and expression.name == "multiply":
                constants = [a for a in expression.arguments if isinstance(a, Const)]
                rest = [a for a in expression.arguments if not isinstance(a, Const)]
                if len(constants) != 1 or constants[0].value > 1 or constants[0].value < 0:
                    return None
                factor, expression = float(constants[0].value), rest[0]
            if not (isinstance(expression, Operation) and expression.name == f"component {channel}"):
                return None
            inner = expression.arguments[0]
            if not isinstance(inner, Image) or inner.alpha:
                return None
            if texture is not None and texture.key() != inner.texture.key():
                return None
            texture = inner.texture
            result.append((factor, True))
        # A constant beside a texture would be multiplied by the texture's channel.
        if not all(textured for _, textured in result):
            return None
        path = self._original(texture, True)
        return (path, texture, [f for f, _ in result]) if path else None

    def single(self, expression, channel, what):
        """(factor, texture or None) of a number that the format reads in one channel of a texture."""
        expression = self._carried(expression, what)
        if isinstance(expression, Const):
            return float(expression.value), None
        direct = self._direct_channels([(expression, channel)]) if channel < 3 else None
        if direct:
            return direct[2][0], self._texture(direct[0], direct[1])
        if channel == 3:
            return 1.0, self._bake(WHITE, expression, as_data=True)
        return 1.0, self._bake(as_color(expression), ONE, as_data=True)

    def normal(self, color):
        """The texture of a normal map, or None."""
        color = self._carried(as_color(color), "the normal map")
        if isinstance(color, Image) and not color.alpha:
            path = self._original(color.texture, True)
            if path:
                return self._texture(path, color.texture)
        if isinstance(color, Const):
            return None
        return self._bake(color, ONE, as_data=True)

    # Helpers

    def _original(self, texture, as_data):
        """The image's own file, where the program reads the same from it; see images.original."""
        image = texture.image
        # The program takes the colours as they stand in the file.
        if texture.multiplied != images.is_associated(image):
            return None
        path = images.original(image, self.writer.cache, as_data)
        self.is_unlike |= path is not None and not images.is_plain(image)
        return path

    def _mean(self, expression):
        def texels(leaf):
            pixels = images.linear_pixels(leaf.texture.image, leaf.texture.multiplied)
            step = max(1, pixels.shape[0] // 64), max(1, pixels.shape[1] // 64)
            pixels = pixels[:: step[0], :: step[1]]
            value = pixels[..., 3] if leaf.alpha else pixels[..., :3]
            return value.mean(axis=(0, 1))
        if any(isinstance(leaf, Image) for leaf in expression.leaves()):
            return Const(expressions.evaluate(expression, texels))
        return expressions.mean(expression)

    def _carried(self, expression, what, attributes=False):
        """The expression without what glTF cannot carry; findings say what was replaced."""
        leaves = list(expression.leaves())
        unknown = sorted({leaf.what for leaf in leaves if isinstance(leaf, Unknown)})
        painted = any(isinstance(leaf, Attribute) for leaf in leaves)
        if unknown:
            self.reader.note(APPROXIMATED, f"{what}: the mean is used of the {', the '.join(unknown)}")
        if painted and not attributes:
            self.reader.note(LOST, f"{what}: colour attributes are left out (taken as white)")
        if (unknown or painted) and not any(isinstance(leaf, Image) for leaf in leaves):
            if painted and attributes and not unknown:
                return expression
            return expressions.mean(expression)
        return expression

    def _without_attributes(self, expression):
        if any(isinstance(leaf, Attribute) for leaf in expression.leaves()):
            self.reader.note(LOST, "colour attributes in a mix are left out (taken as white)")
        return expression

    def _scaled(self, expression, used_as_data):
        if not any(isinstance(leaf, Image) for leaf in expression.leaves()):
            return self._mean(expression).value, None
        return numpy.ones(3), self._bake(expression, ONE, as_data=used_as_data)

    def _texture(self, path, texture, weighted=None):
        """A textureInfo for a file; `weighted`: as in TextureSpec, which it is by default."""
        if texture.uv not in self.uvs:
            self.uvs.append(texture.uv)
        document = self.writer.document
        image = document.shared("images", {"uri": document.uri(path)})
        nearest = texture.nearest
        sampler = {
            "magFilter": 9728 if nearest else 9729,
            "minFilter": 9728 if nearest else 9987,
            "wrapS": texture.wrap[0],
            "wrapT": texture.wrap[1],
        }
        if texture.weighted if weighted is None else weighted:
            sampler["extensions"] = {document.uses("SUNDOG_sampler"): {"weighted_by_alpha": True}}
        sampler = document.shared("samplers", sampler)
        info = {"index": document.shared("textures", {"sampler": sampler, "source": image})}
        number = self.uvs.index(texture.uv)
        if number:
            info["texCoord"] = number
        if texture.transform:
            info["extensions"] = {document.uses("KHR_texture_transform"): texture.transform}
        return info

    def _bake(self, color, alpha, as_data):
        """A texture of expressions with images, evaluated for each texel; None if they are white."""
        used = [leaf for e in (color, alpha) for leaf in e.leaves() if isinstance(leaf, Image)]
        if not used:
            return None
        self.is_unlike = True
        first = used[0].texture
        # The written alpha weighs where it is that of all of the colours.
        shown = [leaf for leaf in color.leaves() if isinstance(leaf, Image)]
        opacity = expressions.factors(alpha)
        own = opacity[1][0].texture.key() if opacity and len(opacity[1]) == 1 and opacity[1][0].alpha else None
        weighted = bool(shown) and all(leaf.texture.weighted and leaf.texture.key() == own for leaf in shown)
        if any(leaf.texture.mapping() != first.mapping() for leaf in used):
            self.reader.note(APPROXIMATED, "images that lie differently on the surface are combined as the first lies")
        if self.side == 0:
            # Blender would decode all of their images.
            self.reduced = True
            return None
        name = expressions.Operation("baked", None, [color, alpha, Const(float(as_data))], True).digest()
        stem = os.path.join(self.writer.cache, f"baked-{name}")
        sizes = [leaf.texture.image.size for leaf in used]
        step = max(-(-n // self.side) for size in sizes for n in size) if self.side else 1
        if step > 1:
            self.reduced = True
            stem += f"-{self.side}"
        for path in (f"{stem}.png", f"{stem}.exr"):
            if os.path.isfile(path):
                return self._texture(path, first, weighted)
        pixels = {}
        for leaf in used:
            key = (leaf.texture.image.as_pointer(), leaf.texture.multiplied)
            if key not in pixels:
                pixels[key] = images.linear_pixels(leaf.texture.image, leaf.texture.multiplied, step)
        height = max(p.shape[0] for p in pixels.values())
        width = max(p.shape[1] for p in pixels.values())
        pixels = {k: images.resized(p, height, width) for k, p in pixels.items()}

        def texels(leaf):
            found = pixels[(leaf.texture.image.as_pointer(), leaf.texture.multiplied)]
            return found[..., 3] if leaf.alpha else found[..., :3]

        values = numpy.empty((height, width, 4), numpy.float32)
        values[..., :3] = expressions.evaluate(color, texels)
        values[..., 3] = expressions.evaluate(alpha, texels)
        values = numpy.nan_to_num(values[::-1], posinf=65504.0, neginf=0.0)
        if not as_data:
            # A colour beyond what the working space holds has negative numbers: Cycles counts them as 0.
            values[..., :3] = numpy.maximum(values[..., :3], 0)
        opaque = isinstance(alpha, Const)
        # 16-bit floats: no less exact than the 8-bit files that the values come from.
        path = f"{stem}.exr"
        images.write_exr(path, values[..., :3] if opaque else values)
        return self._texture(path, first, weighted)
