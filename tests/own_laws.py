"""Wall laws as users write them into files of their own."""

EXPONENTIAL = """
from typing import NamedTuple
import numpy as np
from vasowave.base.descriptions import Parameter
from vasowave.base.descriptions import Law

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
