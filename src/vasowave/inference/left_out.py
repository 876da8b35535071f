"""How well each part of the measured pressure is foretold by the rest: blocks of harmonics left out one by one.

The posterior without a block is not computed again: the draws are weighted by what the block had added to their
likelihood (Vehtari, Gelman & Gabry, Stat. Comput. 27 (2017), 1413), and Pareto k says where that cannot be trusted,
because the block decides by itself where the posterior lies.
"""

import numpy as np
import pandas as pd
from scipy.special import logsumexp

from vasowave.inference.discrepancy import Discrepancy
from vasowave.inference.reweighting import smoothed

_FIRST = (0, 1, 2, 3, 5, 9, 17)
"""First harmonic of each block: the mean, the first two, then octaves."""


def left_out(noise: Discrepancy, residuals: np.ndarray, log_weight: np.ndarray) -> pd.DataFrame:
    """Return the log density of each block of harmonics given all others.

    Parameters
    ----------
    noise : Discrepancy
    residuals : array, shape (draw, coefficient)
        Measured minus simulated, mmHg.
    log_weight : array, shape (draw,)
        Of the draws, as of the posterior of all harmonics.

    Returns
    -------
    DataFrame
        Indexed by ``block``, a name such as ``3-4``: ``log_density`` of the block's coefficients (mmHg, orthonormal)
        and ``k_hat``.
    """
    harmonic = noise.harmonic
    simulated = np.isfinite(residuals).all(axis=1)
    residuals, log_weight = residuals[simulated], log_weight[simulated]
    whole = noise.log_likelihood(residuals)
    rows = {}
    for first, end in zip(_FIRST, (*_FIRST[1:], np.inf), strict=True):
        block = (harmonic >= first) & (harmonic < end)
        if block.any() and not block.all():
            added = whole - noise.without(block).log_likelihood(residuals)
            weights = smoothed(log_weight - added)
            rows[_name(harmonic[block])] = (float(logsumexp(weights.log_weight + added)), weights.k_hat)
    return pd.DataFrame.from_dict(rows, orient="index", columns=["log_density", "k_hat"]).rename_axis("block")


def _name(harmonic: np.ndarray) -> str:
    first, last = int(harmonic.min()), int(harmonic.max())
    return str(first) if first == last else f"{first}-{last}"
