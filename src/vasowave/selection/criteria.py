"""AICc and BIC."""

import numpy as np

from vasowave.errors import InputError


def aicc(log_likelihood: float, parameters: int, samples: int) -> float:
    """AICc = -2 log L + 2D + 2D(D + 1)/(N - D - 1) (eq. 21)."""
    if samples <= parameters + 1:
        raise InputError(f"AICc needs more than {parameters + 1} samples for {parameters} parameters")
    return -2 * log_likelihood + 2 * parameters + 2 * parameters * (parameters + 1) / (samples - parameters - 1)


def bic(log_likelihood: float, parameters: int, samples: int) -> float:
    """BIC = -2 log L + D log N (eq. 22)."""
    return float(-2 * log_likelihood + parameters * np.log(samples))
