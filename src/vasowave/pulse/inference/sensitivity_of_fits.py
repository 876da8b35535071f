"""Sobol' indices of a fit within what its data leave open, by an emulator that is made for them."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from vasowave.pulse.analysis.sensitivity_table import Sensitivity
from vasowave.pulse.analysis.uncertain import UncertainModel, uncertain_model
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.inference.model_emulator import check_names, checked_range, emulate

_COVERED = 1.0001  # factor by which an emulator reaches farther than it is asked


def sensitivity_of(
    fit: CalibratedModel | UncertainModel,
    box: Mapping[str, tuple[float, float]] | None = None,
    *,
    samples: int = 4096,
    seed: int = 0,
) -> Sensitivity:
    """Return Sobol' indices of a fit, by an emulator that is made for it; see `Fit.sensitivity`."""
    uncertain = uncertain_model(fit)
    if box is None:
        emulator = emulate(uncertain, seed=seed)
        return emulator.sensitivity(_intervals_within(uncertain, emulator.box), samples=samples, seed=seed)
    check_names(box, uncertain.free.index, "not free")
    values = uncertain.free["value"].astype(float)
    ends = {name: checked_range(name, limits) for name, limits in box.items()}
    factors = {name: _COVERED * max(high / values[name], values[name] / low) for name, (low, high) in ends.items()}
    return emulate(uncertain, factors=factors, seed=seed).sensitivity(ends, samples=samples, seed=seed)


def _intervals_within(uncertain: UncertainModel, box: pd.DataFrame) -> dict[str, tuple[float, float]]:
    """Return the 95 % intervals of the parameters, as far as a box holds them."""
    table = uncertain.free
    low = np.maximum(table["interval_low"].to_numpy(float), box["low"].to_numpy(float))
    high = np.minimum(table["interval_high"].to_numpy(float), box["high"].to_numpy(float))
    intervals = zip(map(str, table.index), low.tolist(), high.tolist(), strict=True)
    return {name: (start, end) for name, start, end in intervals if start < end}
