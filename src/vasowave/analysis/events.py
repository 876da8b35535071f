"""The single waves of wave intensity: named, located and measured."""

import numpy as np
import pandas as pd

from vasowave.analysis.waves import WaveIntensity
from vasowave.errors import InputError


def named_waves(waves: WaveIntensity, period: float, smallest: float = 0.05) -> pd.DataFrame:
    """Forward and backward compression and decompression waves of one station, in the order of their peaks.

    A wave is a stretch of the closed cycle in which p₊ (or p₋) keeps rising (compression) or falling (decompression);
    a wave that runs across the end of the cycle is one wave, and its peak time lies in [0, T).

    Parameters
    ----------
    waves : WaveIntensity
        Of one station: arrays of shape (time,).
    period : float
        T, s.
    smallest : float
        Waves whose change of pressure is a smaller share of the largest one's, of any kind, are left out.

    Returns
    -------
    DataFrame
        ``wave`` (FCW, FDW, BCW, BDW), ``direction``, ``kind``, ``start [s]``, ``peak time [s]``, ``duration [s]``,
        ``peak [W/cm2/s2]`` and ``area [W/cm2/s]`` (negative for backward waves), ``pressure change [mmHg]``.

    Raises
    ------
    InputError
        Several stations at once, a period that is not positive, or `smallest` outside [0, 1).
    """
    if waves.forward_intensity.ndim != 1:
        raise InputError(f"waves of shape {waves.forward_intensity.shape}: name those of one station at a time")
    if not (np.isfinite(period) and period > 0 and 0 <= smallest < 1):
        raise InputError(f"period {period:g} s must be positive, smallest {smallest:g} between 0 and 1")
    drift = float(waves.drift)
    rows = [
        *_runs("forward", waves.forward_pressure, drift, waves.forward_intensity, period),
        *_runs("backward", waves.backward_pressure, -drift, waves.backward_intensity, period),
    ]
    table = pd.DataFrame(rows, columns=_COLUMNS)
    size = table["pressure change [mmHg]"].abs()
    kept = table[size >= smallest * size.max()] if len(table) else table
    return kept.sort_values("peak time [s]", ignore_index=True)


def largest_waves(table: pd.DataFrame) -> pd.DataFrame:
    """Return the row of largest area of every kind of wave in a table from `named_waves`, indexed by ``wave``."""
    order = table["area [W/cm2/s]"].abs().sort_values(ascending=False).index
    return table.loc[order].drop_duplicates("wave").set_index("wave").reindex(list(WAVES)).dropna(how="all")


WAVES = {
    "FCW": "forward compression",
    "FDW": "forward decompression",
    "BCW": "backward compression",
    "BDW": "backward decompression",
}
"""Short and long names of the four kinds of waves."""

_COLUMNS = [
    "wave",
    "direction",
    "kind",
    "start [s]",
    "peak time [s]",
    "duration [s]",
    "peak [W/cm2/s2]",
    "area [W/cm2/s]",
    "pressure change [mmHg]",
]


def _runs(direction: str, pressure: np.ndarray, drift: float, intensity: np.ndarray, period: float) -> list[tuple]:
    """Return one row per stretch in which the pressure of these waves changes with one sign."""
    count, step = len(pressure), period / len(pressure)
    ahead, behind = np.roll(pressure, -1), np.roll(pressure, 1)
    ahead[-1] += drift
    behind[0] -= drift
    change = 0.5 * (ahead - behind)  # the central difference on which the intensity rests
    sign = np.sign(change)
    borders = np.flatnonzero(sign != np.roll(sign, 1))
    if len(borders) == 0:
        borders = np.array([0])
    rows = []
    for first, end in zip(borders, [*borders[1:], borders[0] + count], strict=True):
        if sign[first] == 0:
            continue
        inside = np.arange(first, end) % count
        peak = inside[np.argmax(np.abs(intensity[inside]))]
        kind = "compression" if sign[first] > 0 else "decompression"
        rows.append(
            (
                f"{direction[0]}{kind[0]}w".upper(),
                direction,
                kind,
                first * step,
                peak * step,
                len(inside) * step,
                float(intensity[peak]),
                float(intensity[inside].sum() * step),
                float(change[inside].sum()),
            )
        )
    return rows
