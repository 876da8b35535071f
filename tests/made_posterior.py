"""Posteriors made of given draws, so that what is done with them can be tested without a simulation."""

import zlib
from dataclasses import replace

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.pulse import ACROSS_LAWS
from vasowave.pulse.inference import SOURCES, Diagnostics, Posterior
from vasowave.study.animal import PosteriorResult

BLOCKS = ("0", "1", "2", "3-4")
NAMES = ("stiffness", "wave_speed")
"""Of what an animal's draws are."""
SD, SHARE = 0.2, 0.75


def made_posterior(wall, log_evidence, center, spread=0.1, foretold=(0.0, 0.0, 0.0, 0.0), k_hat=0.3, harmonics=16):
    """Return a posterior whose every quantity has draws of one log-normal distribution."""
    draws = center * np.exp(spread * np.random.default_rng(1).standard_normal((4, 250)))
    tree = xr.DataTree.from_dict(
        {"posterior": xr.Dataset(dict.fromkeys(ACROSS_LAWS, (("chain", "draw"), draws)))},
    )
    table = pd.DataFrame({"unit": ["1"] * len(ACROSS_LAWS)}, index=list(ACROSS_LAWS))
    for name in ("median", "interval_low", "interval_high", "prior_low", "prior_high", "contraction"):
        table[name] = 1.0
    table[[*SOURCES]] = 1 / len(SOURCES)
    diagnostics = Diagnostics(k_hat, 700.0, 0.0, 0.1, log_evidence, 0.1, 1000, 3, harmonics, 1000, 0.7)
    left_out = pd.DataFrame({"log_density": foretold, "k_hat": (0.9, 0.2, 0.2, 0.2)}, pd.Index(BLOCKS, name="block"))
    return Posterior(wall, tree, table, diagnostics, left_out)


def with_posterior(result, sd=SD, share=SHARE, trusted=1):
    """Return an animal with draws around what its fit says."""
    rng = np.random.default_rng(zlib.crc32(result.name.encode()))
    draws = rng.standard_normal((4, 100))
    scores = (draws - draws.mean()) / draws.std(ddof=1)
    values = {name: float(result.laws["linear"].quantities[name]) * np.exp(sd * scores) for name in NAMES}
    table = xr.Dataset({"share_image": ("quantity", [share] * 2)}, coords={"quantity": list(NAMES)})
    posterior = xr.Dataset({name: (("chain", "draw"), drawn) for name, drawn in values.items()})
    drawn = PosteriorResult(table.assign_attrs(trusted=trusted), {"posterior": posterior})
    return replace(result, laws={**result.laws, "linear": replace(result.laws["linear"], posterior=drawn)})
