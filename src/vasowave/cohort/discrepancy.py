"""What a wall law leaves of the pressure, harmonic by harmonic: in every animal, and alike in all of them."""

import numpy as np
import pandas as pd

from vasowave.animal.result import AnimalResult
from vasowave.cohort.cohort import Cohort

FEWEST = 5
"""Animals, below which no test could tell what they have in common from chance."""
ROUNDING = 1e-9
"""Modulus of a residual, mmHg, below which it and its phase are what rounding left."""
ALIKE = 0.05
"""A harmonic is left alike if chance makes it so with less than this probability, all harmonics taken together."""


def all_discrepancies(cohort: Cohort) -> dict[str, pd.DataFrame]:
    """Return `discrepancies` of the wall laws that enough animals have, by law."""
    tables = {wall: discrepancies(cohort, wall) for wall in cohort.walls}
    return {wall: table for wall, table in tables.items() if not table.empty}


def discrepancies(cohort: Cohort, wall: str) -> pd.DataFrame:
    """Return what one law leaves of the pressure in every harmonic that all its animals have.

    Columns ``harmonic; residual, error, discrepancy [mmHg]``: root mean squares over the animals of the residual's
    modulus and of the measurement's expected error, and what the first has beyond the second; ``common [mmHg]``: the
    modulus of the mean residual, phases counted from the first harmonic of the measured pressure, so that cycles may
    begin anywhere; ``share``: that of the residual's power which all animals have in common, about 1/n where phases
    are chance; ``p``: of Rayleigh's test that they are, whatever the sizes; ``alike``: whether it is below `ALIKE` over
    the number of harmonics. Share and p are NaN where an animal's residual is rounding. Empty with fewer animals than
    `FEWEST`, and where an animal has no harmonic.
    """
    animals = cohort.calibrated(wall)
    if len(animals) < FEWEST:
        return pd.DataFrame()
    moduli = [result.laws[wall].calibration for result in animals]
    count = min(one.sizes["harmonic"] for one in moduli)
    if count < 2:
        return pd.DataFrame()
    left, error = (
        np.array([one[name].values[1:count] for one in moduli]) for name in ("residual_modulus", "measurement_error")
    )
    turned = np.array([_turned(result, wall, count) for result in animals])
    rms, noise, mean = (np.sqrt(np.mean(values**2, axis=0)) for values in (left, error, np.abs(turned)))
    common = np.abs(turned.mean(axis=0))
    something = np.abs(turned).min(axis=0) > ROUNDING
    shares = (common / np.maximum(mean, ROUNDING)) ** 2
    share, p = (np.where(something, values, np.nan) for values in (shares, rayleigh(np.angle(turned))))
    rms, common = (np.where(values > ROUNDING, values, 0.0) for values in (rms, common))
    return pd.DataFrame(
        {
            "harmonic": np.arange(1, count), "residual [mmHg]": rms, "error [mmHg]": noise,
            "discrepancy [mmHg]": np.sqrt(np.maximum(rms**2 - noise**2, 0.0)), "common [mmHg]": common,
            "share": share, "p": p, "alike": p < ALIKE / (count - 1),
        }
    )  # fmt: skip


def rayleigh(phases: np.ndarray) -> np.ndarray:
    """Return p of Rayleigh's test that phases (rad, shape (animal, …)) are spread evenly over the circle (Zar 1999)."""
    n = len(phases)
    together = np.abs(np.exp(1j * phases).sum(axis=0))
    return np.asarray(np.exp(np.sqrt(1 + 4 * n + 4 * (n**2 - together**2)) - (1 + 2 * n)))


def _turned(result: AnimalResult, wall: str, count: int) -> np.ndarray:
    """Return harmonics 1 … of the residual, mmHg, as of a cycle in which the pressure's first one has phase 0."""
    residual = result.laws[wall].calibration["pressure_residual"].values
    pressure = result.recording["pressure"].values
    amplitudes = 2 * np.fft.rfft(residual)[1:count] / len(residual)
    begin = np.angle(np.fft.rfft(pressure)[1])
    return np.asarray(amplitudes * np.exp(-1j * np.arange(1, count) * begin))
