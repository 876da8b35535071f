"""Powers without branches, tables or calls, so that the compiler can work on several cells at once.

x^m = exp(m log x). A floating-point number is 2^n z: its bits hold n, which the logarithm takes out and the exponential
puts in, so that series are needed for log z and exp r on short intervals only. Both are exact to double precision
there; a power is as exact as m log x is: to 2e-15 for powers up to 3000.
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
