"""The compiled solver's own tangent and arctangent against the library's."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vasowave.solver.powers import arctangent, tangent


def test_tangent_is_exact_to_rounding_up_to_its_pole():
    x = np.linspace(-1.57, 1.57, 100001)
    # Rounding of x itself moves tan x by ε x (1 + tan² x): nothing can be nearer than a few times that.
    allowed = 4e-16 * (np.abs(np.tan(x)) + np.abs(x) * (1 + np.tan(x) ** 2))
    assert np.all(np.abs(tangent(x) - np.tan(x)) <= allowed)


@given(st.floats(-1e6, 1e6, allow_subnormal=False))  # whose precision is less by definition
def test_arctangent_is_exact_to_rounding(x):
    assert abs(arctangent(np.float64(x)) - np.arctan(x)) <= 1e-15 * abs(np.arctan(x))
