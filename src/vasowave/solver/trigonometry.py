"""Tangent and arctangent without branches or tables, so that the compiler can work on several cells at once.

Both are convergents of a continued fraction, exact to double precision on a short interval, to which half-angle
formulas bring every argument that a wall law meets.
"""

import numpy as np


def tangent(x):
    """Tan x for |x| < π/2: Lambert's continued fraction at x/2, nine terms deep, then the double angle."""
    z = 0.5 * x
    w = z * z
    P = z * (34459425.0 + w * (-4729725.0 + w * (135135.0 + w * (-990.0 + w))))
    Q = 34459425.0 + w * (-16216200.0 + w * (945945.0 + w * (-13860.0 + w * 45.0)))
    return 2.0 * P * Q / ((Q - P) * (Q + P))


def arctangent(x):
    """Arctan x for any x: Gauss's continued fraction at a quarter of the angle, twelve terms deep."""
    half = x / (1.0 + np.sqrt(1.0 + x * x))
    z = half / (1.0 + np.sqrt(1.0 + half * half))
    w = z * z
    P = 46107386325.0 + w * 2015310375.0
    P = 316234143225.0 + w * (802043116875.0 + w * (733034672370.0 + w * (289831331790.0 + w * P)))
    Q = 105354624375.0 + w * (8428369950.0 + w * 108056025.0)
    Q = 316234143225.0 + w * (907454497950.0 + w * (972272676375.0 + w * (477607630500.0 + w * Q)))
    return 4.0 * z * P / Q
