"""The response of an instrument of second order: a fluid-filled catheter, or the filter of an amplifier."""

import numpy as np


def second_order(lag: float | np.ndarray, inertia: float | np.ndarray, frequency: np.ndarray) -> np.ndarray:
    """Return recorded over true signal, 1 / (1 + iωτ - ω²θ), at frequencies in Hz; arrays are broadcast.

    With a lag τ (s) and an inertia θ (s²): 1/(2π f_c) and 0 of a filter of first order, ζ/(π f_n) and 1/(2π f_n)² of a
    catheter. What fits and posteriors say of an unknown response is this.
    """
    rate = 2j * np.pi * np.asarray(frequency)
    return np.asarray(1.0 / (1.0 + rate * lag + rate**2 * inertia))
