"""Wall laws as users write them into files of their own."""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vasowave.base import Law, Parameter
from vasowave.pulse.model import LinearWall

EXPONENTIAL = """
from typing import NamedTuple
import numpy as np
from vasowave.base import Parameter
from vasowave.base import Law

class ExponentialWall(NamedTuple):
    k: float
    m: float
    @staticmethod
    def law():
        k = Parameter("mmHg", "k", "pressure scale", "", 0.25, (0.01, 20.0))
        m = Parameter("1", "m", "exponent", "", 2.0, (0.1, 40.0))
        return Law("exponential", "exponential", "p = k (exp(m (A/A₀ − 1)) − 1)", "", (k, m))
    @staticmethod
    def pressure_at(a, k, m): return k * (np.exp(m * (a - 1)) - 1)
    @staticmethod
    def ratio_at(p, k, m): return 1 + np.log(np.maximum(1 + p / k, 1e-3)) / m
    @staticmethod
    def slope_at(p, k, m): return 1 / (m * (k + np.maximum(p, -0.999 * k)))
    @staticmethod
    def limits(k, m): return 0.0 * k, 0.0 * k + np.inf
"""


def printed_law() -> str:
    """Return the program that the page on walls prints; what is compiled of it serves all tests that run it."""
    page = (Path(__file__).parents[1] / "docs" / "walls.md").read_text("utf-8")
    (program,) = re.findall(r"```python\n(from typing.*?)```", page, re.DOTALL)
    return program


class Broken(NamedTuple):
    """A law that is right until a model is made of it."""

    beta: float

    @staticmethod
    def law():
        beta = Parameter("mmHg", "β", "stiffness", "", 1.0, (0.2, 20.0))
        return Law("broken", "broken", "p = β (√(A/A₀) − 1)", "3", (beta,), "beta")

    pressure_at = staticmethod(LinearWall.pressure_at)
    ratio_at = staticmethod(LinearWall.ratio_at)
    slope_at = staticmethod(LinearWall.slope_at)

    @staticmethod
    def limits(beta):
        if np.any(np.asarray(beta) != 50.0):  # at which every law is checked
            raise ZeroDivisionError("by nothing")
        return LinearWall.limits(beta)
