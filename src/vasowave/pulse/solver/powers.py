"""Powers, tangents and arctangents without branches, tables or calls, so that several cells can be computed at once.

x^m = exp(m log x). A floating-point number is 2^n z: its bits hold n, which the logarithm takes out and the exponential
puts in, so that series are needed for log z and exp r on short intervals only. Both are exact to double precision
there; a power is as exact as m log x is: to 2e-15 for powers up to 3000.

Tangent and arctangent are convergents of a continued fraction, exact to double precision on a short interval, to which
half-angle formulas bring every argument that a wall law meets.
"""

import numpy as np
from numba.extending import register_jitable

_LOG2 = 0.6931471805599453  # log 2
_ONE = 0x3FF0000000000000  # bits of 1
_ROOT_HALF = 0x3FE6A09E667F3BCD  # of √½
_MOST = 700.0  # logarithm that a number can have, nearly
_WHOLE = 2.0**52 + 1023.0  # with this added the last bits of a number are n + 1023, as the exponent is written


@register_jitable
def power(x, m):
    """x^m for x > 0; NaN where x is not a finite number, and at most e^700."""
    return exponential(m * logarithm(x))


@register_jitable
def logarithm(x):
    """Log x for x > 0: n log 2 + 2 artanh((z - 1)/(z + 1)) with √½ < z < √2, ten terms deep."""
    n = ((np.float64(x).view(np.int64) + (_ONE - _ROOT_HALF)) >> 52) - 1023
    z = x * np.int64((1023 - n) << 52).view(np.float64)
    s = (z - 1.0) / (z + 1.0)
    w = s * s
    P = 1 / 11 + w * (1 / 13 + w * (1 / 15 + w * (1 / 17 + w * (1 / 19))))
    P = w * (1 / 3 + w * (1 / 5 + w * (1 / 7 + w * (1 / 9 + w * P))))
    # Converted, not by _WHOLE: the compiler, who may reorder sums, would multiply that out and round.
    return np.float64(n) * _LOG2 + 2.0 * (s + s * P)


@register_jitable
def exponential(y):
    """Exp y: 2^n exp r with |r| < log(2)/2, a Taylor polynomial of degree 12."""
    y = np.minimum(np.maximum(y, -_MOST), _MOST)
    n = np.floor(y / _LOG2 + 0.5)
    r = y - n * _LOG2
    P = 1 / 39916800 + r * (1 / 479001600)
    P = 1 / 5040 + r * (1 / 40320 + r * (1 / 362880 + r * (1 / 3628800 + r * P)))
    P = 1.0 + r * (1.0 + r * (1 / 2 + r * (1 / 6 + r * (1 / 24 + r * (1 / 120 + r * (1 / 720 + r * P))))))
    return P * np.int64(np.float64(n + _WHOLE).view(np.int64) << 52).view(np.float64)


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
