# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour of Cycles' Blackbody node."""

import numpy

from . import colorspace

COLDEST, HOTTEST = 800.0, 12000.0

# Cycles' curves are fits to Planck's law, which is up to 3 % beside them in single channels: of t in thousands of kelvins red and
# green are a/t + b·t + c, blue is a polynomial. From these kelvins on (a, b, c) of red and of green and the four coefficients of
# blue are such, in linear Rec.709: least squares of 64 temperatures each that Cycles 5.2.3 rendered in ACEScg, where none is
# negative. All were within 8e-7. Nodes whose temperature is constant, and those of Cycles 4.5, are up to 4e-4 beside them.
_FIRST = numpy.array([800.0, 965.0, 1167.0, 1449.0, 1902.0, 3315.0, 6365.0])
_CURVES = numpy.array(
    [
        (1.61943771, -2.05045145, 5.03078471, -0.488988552, 0.604316726, -0.0755788364, 0.0596718152, -0.0485403785, -0.0970583482, -0.00407276967),
        (2.48888123, -1.11346039, 3.22667206, -0.755975647, 0.316723933, 0.47829281, 0.0240321677, 0.0555045036, -0.198472, 0.0289297207),
        (3.34198406, -0.486617615, 1.7651179, -1.0236161, 0.120220665, 0.936640746, -0.0140927169, 0.189837979, -0.356553308, 0.0910576454),
        (4.09527706, -0.127464941, 0.725838299, -1.26568902, 0.00487152627, 1.27052172, -0.0361395666, 0.284764328, -0.493110422, 0.156695438),
        (4.67102569, 0.029130411, 0.126721737, -1.42526068, -0.0401142413, 1.43969492, -0.0197028523, 0.175317289, -0.250482737, -0.0222728198),
        (4.5958209, 0.0287538672, 0.150369053, -1.175519, -0.021637281, 1.30404935, -0.000161967419, -0.0164175196, 0.386122746, -0.737898644),
        (3.7877878, 0.00936063137, 0.399135444, -0.500788412, -0.0045982548, 1.09096248, 0.000672488869, -0.0273013231, 0.423996372, -0.752154833),
    ]
)
# What is colder and what is hotter.
_COLD, _HOT = (5.41415542, -0.20318921, -0.08223375), (0.82642464, 0.99448459, 1.56593129)


def color(kelvin):
    """In the working space, of about luminance 1."""
    if kelvin < COLDEST:
        found = _COLD
    elif kelvin >= HOTTEST:
        found = _HOT
    else:
        t = kelvin / 1000
        curves = _CURVES[numpy.searchsorted(_FIRST, kelvin, side="right") - 1]
        found = (*(curves[:6].reshape(2, 3) @ (1 / t, t, 1.0)), numpy.polyval(curves[6:], t))
    return numpy.maximum(colorspace.convert(numpy.array(found), colorspace.REC709), 0)
