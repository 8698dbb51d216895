# SPDX-License-Identifier: GPL-3.0-or-later
"""What a socket of a shader node tree amounts to: constants, images, attributes and operations on
them, evaluated with numpy for single values and for whole images alike."""

import hashlib
import json

import numpy

from . import colorspace

# Values that no glTF can carry (procedural textures, view angles) are stood for by this many samples of their
# range, so that what follows them (a ramp, a product) is averaged as a whole.
SAMPLES = 512


class Expression:
    """A scalar (shape ()) or a colour or vector (shape (3,)) that may vary over the surface."""

    is_color = False

    def leaves(self):
        """All leaves below, each once."""
        yield self

    def key(self):
        """Something that JSON can hold, equal for equal expressions."""
        raise NotImplementedError

    def digest(self):
        """A hash of the key."""
        return hashlib.sha1(json.dumps(self.key(), sort_keys=True).encode()).hexdigest()


class Const(Expression):
    """The same everywhere."""

    def __init__(self, value):
        self.value = numpy.asarray(value, numpy.float64)
        self.is_color = self.value.shape == (3,)

    def key(self):
        return ["const", self.value.tolist()]


ONE, ZERO, WHITE, BLACK = Const(1.0), Const(0.0), Const(numpy.ones(3)), Const(numpy.zeros(3))


class Image(Expression):
    """An image texture's colour or alpha. `texture` is a shaders.TextureSpec."""

    def __init__(self, texture, alpha=False):
        self.texture, self.alpha = texture, alpha
        self.is_color = not alpha

    def key(self):
        return ["image", self.texture.key(), self.alpha]


class Attribute(Expression):
    """A colour attribute of the mesh ("" means the one that is active for rendering)."""

    def __init__(self, name, alpha=False):
        self.name, self.alpha = name, alpha
        self.is_color = not alpha

    def key(self):
        return ["attribute", self.name, self.alpha]


class Unknown(Expression):
    """What cannot be carried: samples of its values, and the name for the verdict."""

    def __init__(self, samples, what):
        self.samples, self.what = numpy.asarray(samples, numpy.float64), what
        self.is_color = self.samples.ndim == 2

    def key(self):
        return ["unknown", self.what, self.samples.mean(axis=0).tolist()]


class Operation(Expression):
    """A function of other expressions; `name` tells it apart from others, with its parameters."""

    def __init__(self, name, function, arguments, is_color):
        self.name, self.function, self.arguments, self.is_color = name, function, arguments, is_color
        # What many operations share is looked at once: a tree of uses may be exponentially larger.
        self._digest = self._factors = None

    def leaves(self):
        stack, seen = [self], set()
        while stack:
            expression = stack.pop()
            if id(expression) in seen:
                continue
            seen.add(id(expression))
            if isinstance(expression, Operation):
                stack.extend(reversed(expression.arguments))
            else:
                yield expression

    def key(self):
        if self._digest is None:
            self._digest = hashlib.sha1(json.dumps([self.name, *(a.key() for a in self.arguments)]).encode()).hexdigest()
        return ["operation", self._digest]

    def factors(self):
        """See the function of this name."""
        if self._factors is None:
            self._factors = (_factors_of(self),)
        return self._factors[0]


def operation(name, function, arguments, is_color):
    """An operation, folded to a constant where it has only constants to work on."""
    made = Operation(name, function, arguments, is_color)
    if all(isinstance(a, Const) for a in arguments):
        return Const(numpy.broadcast_to(evaluate(made, None), (3,) if is_color else ()))
    return made


def evaluate(expression, images, known=None):
    """The value with numpy's broadcasting; colours have three values in the last axis.

    `images` gives an Image leaf's texels (None if there is none), Attributes and Unknowns are their
    mean unless there are no images. `known` has the values of operations that several others use, None until they have one.
    """
    if isinstance(expression, Const):
        return expression.value
    if isinstance(expression, Image):
        return images(expression)
    if isinstance(expression, Attribute):
        return numpy.ones(3) if expression.is_color else numpy.ones(())
    if isinstance(expression, Unknown):
        return expression.samples if images is None else expression.samples.mean(axis=0)
    known = _shared(expression) if known is None else known
    value = known.get(id(expression))
    if value is None:
        value = expression.function(*(evaluate(a, images, known) for a in expression.arguments))
        if id(expression) in known:
            known[id(expression)] = value
    return value


def _shared(expression):
    """The operations below that are used more than once, by identity. The values of all would need too much memory."""
    stack, seen, shared = [expression], set(), {}
    while stack:
        current = stack.pop()
        if id(current) in seen:
            shared[id(current)] = None
            continue
        seen.add(id(current))
        stack.extend(a for a in current.arguments if isinstance(a, Operation))
    return shared


def mean(expression):
    """One constant for an expression without images: the mean over the samples of its unknowns."""
    value = evaluate(expression, None)
    shape = (3,) if expression.is_color else ()
    if expression.is_color and value.ndim == 1 and value.shape != (3,):
        value = value[:, None]
    if value.ndim > len(shape):
        value = value.mean(axis=0)
    return Const(numpy.broadcast_to(value, shape))


def multiply(a, b):
    """The product; the one operation that glTF itself can carry between factor and texture."""
    if isinstance(a, Const) and numpy.all(a.value == 1) and b.is_color >= a.is_color:
        return b
    if isinstance(b, Const) and numpy.all(b.value == 1) and a.is_color >= b.is_color:
        return a
    is_color = a.is_color or b.is_color
    a, b = (as_color(a), as_color(b)) if is_color else (a, b)
    return operation("multiply", lambda x, y: x * y, [a, b], is_color)


def as_color(expression):
    """A scalar as a grey."""
    if expression.is_color:
        return expression
    if isinstance(expression, Const):
        return Const(numpy.repeat(expression.value, 3))
    return operation("grey", lambda v: numpy.repeat(numpy.asarray(v)[..., None], 3, axis=-1), [expression], True)


def as_scalar(expression, vector=False):
    """A colour's luminance, or the mean of a vector's components."""
    if not expression.is_color:
        return expression
    if vector:
        return operation("mean", lambda v: v.mean(axis=-1), [expression], False)
    if isinstance(expression, Operation) and expression.name == "grey":
        return expression.arguments[0]
    return operation("luminance", lambda v: v @ colorspace.luminance(), [expression], False)


def component(expression, index):
    """One component of a colour or vector."""
    return operation(f"component {index}", lambda v: v[..., index], [as_color(expression)], False)


def mix(factor, a, b):
    """a (1 - factor) + b factor."""
    if isinstance(factor, Const):
        if factor.value == 0:
            return a
        if factor.value == 1:
            return b
    if a.key() == b.key():
        return a
    is_color = a.is_color or b.is_color
    if is_color:
        factor, a, b = as_color(factor), as_color(a), as_color(b)
    return operation("mix", lambda f, x, y: x + (y - x) * f, [factor, a, b], is_color)


def factors(expression):
    """(constant, images, attributes) whose product the expression is, or None if it is none."""
    if isinstance(expression, Const):
        return expression.value, [], []
    if isinstance(expression, Image):
        return numpy.ones(()), [expression], []
    if isinstance(expression, Attribute):
        return numpy.ones(()), [], [expression]
    return expression.factors() if isinstance(expression, Operation) else None


# Nothing asks for the factors of products of more.
_MOST_FACTORS = 16


def _factors_of(expression):
    if expression.name == "multiply":
        parts = [factors(a) for a in expression.arguments]
        if None not in parts:
            (fa, ia, aa), (fb, ib, ab) = parts
            if len(ia + ib + aa + ab) <= _MOST_FACTORS:
                return fa * fb, ia + ib, aa + ab
    if expression.name == "grey":
        inner = factors(expression.arguments[0])
        # A grey factor is a factor; alpha spread over colours is no colour image of the file.
        if inner and not inner[1] and not inner[2]:
            return inner
    return None
