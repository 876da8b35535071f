"""Sobol' indices of a fit within what its data leave open, by an emulator that is made for them."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from vasowave.base.errors import InputError
from vasowave.pulse.analysis.sensitivity_table import Sensitivity
from vasowave.pulse.analysis.uncertain import UncertainModel, uncertain_model
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.inference.model_emulator import checked_box, emulate
from vasowave.pulse.inference.sobol import check_samples

_COVERED = 1.0001  # factor by which an emulator reaches farther than it is asked, and a range beyond bounds


def sensitivity_of(
    fit: CalibratedModel | UncertainModel,
    box: Mapping[str, tuple[float, float]] | None = None,
    *,
    samples: int = 4096,
    seed: int = 0,
) -> Sensitivity:
    """Return Sobol' indices of a fit, by an emulator that is made for it; see `Fit.sensitivity`."""
    uncertain = uncertain_model(fit)
    check_samples(samples)
    values, named = uncertain.free["value"].astype(float), _named_ranges(uncertain, {} if box is None else box)
    factors = {name: _COVERED * max(high / values[name], values[name] / low) for name, (low, high) in named.items()}
    emulator = emulate(uncertain, factors=factors, seed=seed)
    ends = _intervals_within(uncertain, emulator.box) | named
    return emulator.sensitivity(ends, samples=samples, seed=seed)


def _named_ranges(uncertain: UncertainModel, box: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """Return the ranges of a box; raises `InputError` for one that reaches beyond the bounds of the fit."""
    table, ranges = uncertain.free, checked_box(box, uncertain.free.index, "not free")
    for name, (low, high) in ranges.items():
        lowest, highest = table.loc[[name], ["lower", "upper"]].to_numpy(float)[0].tolist()
        if low * _COVERED < lowest or high > highest * _COVERED:  # bounds as an error shows them are rounded
            raise InputError(
                f"{name}: {low:g} to {high:g} reaches too far; give a range within the fit's bounds "
                f"{lowest:g} to {highest:g}"
            )
        ranges[name] = max(low, lowest), min(high, highest)
    return ranges


def _intervals_within(uncertain: UncertainModel, box: pd.DataFrame) -> dict[str, tuple[float, float]]:
    """Return the 95 % intervals of the parameters, as far as a box holds them."""
    table = uncertain.free
    low = np.maximum(table["interval_low"].to_numpy(float), box["low"].to_numpy(float))
    high = np.minimum(table["interval_high"].to_numpy(float), box["high"].to_numpy(float))
    intervals = zip(map(str, table.index), low.tolist(), high.tolist(), strict=True)
    return {name: (start, end) for name, start, end in intervals if start < end}
