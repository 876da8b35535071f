"""Degrees of freedom that a design leaves its comparisons."""

from collections.abc import Sequence

import numpy as np

from vasowave.study.cohort.contrast import Contrast
from vasowave.study.cohort.design import Layout


def degrees_left(layout: Layout, blocks: Sequence[str], contrast: Contrast) -> int:
    """Return the fewest degrees of freedom that a comparison has if all rows scatter alike.

    They are those of the first stratum that tells it: rows of one animal, animals of one block, or blocks.

    Parameters
    ----------
    layout : Layout
    blocks : sequence of str
        The blocks of its design.
    contrast : Contrast
        One that its animals tell.
    """
    weights = contrast.weights @ layout.means
    names, index = np.unique(np.array(layout.subject), return_inverse=True)
    subject = np.eye(len(names))[index]
    levels = [layout.random[name] for name in blocks if name in layout.random]
    within = np.hstack([subject, *levels])
    if _tells(layout.fixed, within, weights):
        return len(subject) - _rank(within, layout.fixed)
    averaged = np.linalg.pinv(subject)
    fixed, block = (
        averaged @ layout.fixed,
        np.hstack([np.ones((len(averaged), 1)), *(averaged @ indicators for indicators in levels)]),
    )
    if not levels or _tells(fixed, block, weights):
        return len(fixed) - _rank(block, fixed)
    return _rank(block) - _rank(block @ np.linalg.pinv(block) @ fixed)


def _tells(fixed: np.ndarray, taken: np.ndarray, weights: np.ndarray) -> bool:
    """Whether what is left of the fixed effects beside others tells a contrast."""
    residuals = fixed - taken @ np.linalg.lstsq(taken, fixed, rcond=None)[0]
    residuals[np.abs(residuals) < 1e-9 * np.abs(fixed).max()] = 0  # round-off, of which anything could be made
    solution = np.linalg.lstsq(residuals.T, weights, rcond=1e-9)[0]
    return bool(np.abs(residuals.T @ solution - weights).max() < 1e-7 * max(1.0, float(np.abs(weights).max())))


def _rank(*columns: np.ndarray) -> int:
    return int(np.linalg.matrix_rank(np.hstack(columns)))
