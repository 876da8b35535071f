"""AICc and BIC, and what their differences decide."""

from collections.abc import Mapping

import numpy as np

from vasowave.errors import InputError

UNDECIDED = 5.0
"""Differences of AICc or BIC below this decide nothing."""


def aicc(log_likelihood: float, parameters: int, samples: int) -> float:
    """AICc = -2 log L + 2D + 2D(D + 1)/(N - D - 1) (eq. 21)."""
    if samples <= parameters + 1:
        raise InputError(f"AICc needs more than {parameters + 1} samples for {parameters} parameters")
    return -2 * log_likelihood + 2 * parameters + 2 * parameters * (parameters + 1) / (samples - parameters - 1)


def bic(log_likelihood: float, parameters: int, samples: int) -> float:
    """BIC = -2 log L + D log N (eq. 22)."""
    return float(-2 * log_likelihood + parameters * np.log(samples))


def verdicts(scores: Mapping[str, float]) -> list[tuple[str, float, str]]:
    """Return (model, difference to the best, verdict), best first.

    The best is "preferred" if the runner-up is at least `UNDECIDED` behind, and whatever is that far behind is "worse";
    all others are "undecided".
    """
    order = sorted(scores, key=lambda key: scores[key])
    best = scores[order[0]]
    decided = len(order) > 1 and scores[order[1]] - best >= UNDECIDED
    judged = []
    for key in order:
        difference = scores[key] - best
        clear = difference >= UNDECIDED or (key == order[0] and decided)
        judged.append((key, difference, ("preferred" if key == order[0] else "worse") if clear else "undecided"))
    return judged
