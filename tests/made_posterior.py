"""Posteriors made of given draws, so that what is done with them can be tested without a simulation."""

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.inference.laws import AVERAGED
from vasowave.inference.result import Diagnostics, Posterior

BLOCKS = ("0", "1", "2", "3-4")


def made_posterior(wall, log_evidence, center, spread=0.1, foretold=(0.0, 0.0, 0.0, 0.0), k_hat=0.3, harmonics=16):
    """Return a posterior whose every quantity has draws of one log-normal distribution."""
    draws = center * np.exp(spread * np.random.default_rng(1).standard_normal((4, 250)))
    tree = xr.DataTree.from_dict(
        {"posterior": xr.Dataset(dict.fromkeys(AVERAGED, (("chain", "draw"), draws)))},
    )
    table = pd.DataFrame({"unit": ["1"] * len(AVERAGED)}, index=list(AVERAGED))
    for name in ("median", "interval_low", "interval_high", "prior_low", "prior_high", "contraction"):
        table[name] = 1.0
    table[["recording", "image", "model", "prior"]] = 0.25
    diagnostics = Diagnostics(k_hat, 700.0, 0.0, 0.1, log_evidence, 0.1, 1000, 3, harmonics, 1000)
    left_out = pd.DataFrame({"log_density": foretold, "k_hat": (0.9, 0.2, 0.2, 0.2)}, pd.Index(BLOCKS, name="block"))
    return Posterior(wall, tree, table, diagnostics, left_out, ())
