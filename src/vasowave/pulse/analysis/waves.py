"""Incident and reflected waves: separation, intensity, reflection coefficient; the single waves, named and measured."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from vasowave.base import units
from vasowave.base.errors import InputError

_WATT = units.MMHG * 1e-7
"""One mmHg cm/s in W/cm²."""
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


@dataclass(frozen=True, eq=False)
class WaveIntensity:
    """Separated waves of one period; time is the last axis of every array.

    Attributes
    ----------
    forward_pressure, backward_pressure : array
        p₊ and p₋, mmHg (eq. 15); both start at p(0), so p₊ + p₋ - p(0) = p.
    forward_velocity, backward_velocity : array
        u₊ and u₋, cm/s (eq. 15), likewise; du± = ±dp±/(ρc).
    forward_intensity, backward_intensity : array
        Time-normalized WI₊ ≥ 0 and WI₋ ≤ 0, W/(cm² s²) (eq. 16).
    reflection_coefficient : array
        I_R = Δp₋/Δp₊ (eq. 17); the amplitude Δ is the largest minus the smallest value in the period.
    drift : array
        p₊ after one period minus p₊(0), mmHg; zero for a constant wave speed, not removed for a varying one.
    """

    forward_pressure: np.ndarray
    backward_pressure: np.ndarray
    forward_velocity: np.ndarray
    backward_velocity: np.ndarray
    forward_intensity: np.ndarray
    backward_intensity: np.ndarray
    reflection_coefficient: np.ndarray
    drift: np.ndarray


def wave_intensity(
    pressure: np.ndarray,
    flow: np.ndarray,
    period: float,
    area: float | np.ndarray,
    wave_speed: float | np.ndarray,
    inertia: float,
) -> WaveIntensity:
    """Separate the waves of a periodic signal and compute WI±, W/(cm² s²) (eqs. 15, 16, 17).

    Nothing is smoothed; derivatives are central differences around the closed cycle.

    Parameters
    ----------
    pressure, flow : array, shape (..., time)
        mmHg and ml/s, evenly spaced over one period, the first sample not repeated.
    period : float
        T, s.
    area, wave_speed : float or array, shape (..., time)
        A (cm²) and c (cm/s): those at mean pressure (`measured_operating_point`, `operating_point`); the paper takes A0
        and c = A0 Z_c/ρ for measured data, and those of each instant for a model.
    inertia : float
        Density, mmHg s²/cm², see `Blood.inertia`.

    Raises
    ------
    InputError
        Shapes that differ, values that are not finite, or A, c, ρ, T not positive.

    Examples
    --------
    >>> import vasowave as vw
    >>> mouse = vw.virtual_mouse()
    >>> known = {"area": 0.0069, "wave_speed": 190.0, "inertia": vw.Blood().inertia}
    >>> waves = vw.wave_intensity(mouse.pressure, mouse.flow, mouse.period, **known)
    >>> 0 < float(waves.reflection_coefficient) < 1
    True
    """
    p, q = np.asarray(pressure, dtype=float), np.asarray(flow, dtype=float)
    if p.shape != q.shape or p.ndim == 0 or p.shape[-1] < 4:
        raise InputError(f"pressure has shape {p.shape}, flow {q.shape}; give both on the same times, at least 4")
    try:
        A, c = (np.broadcast_to(np.asarray(value, dtype=float), p.shape) for value in (area, wave_speed))
    except ValueError:
        raise InputError(f"area or wave speed does not fit the shape {p.shape} of pressure") from None
    for name, values in (("area", A), ("wave speed", c), ("density", inertia), ("period", period)):
        if not np.all(np.isfinite(values) & (np.asarray(values) > 0)):
            raise InputError(f"{name} must be positive and finite everywhere")
    if not (np.all(np.isfinite(p)) and np.all(np.isfinite(q))):
        raise InputError("pressure or flow holds a value that is not finite; fill the gap first")
    u = q / A
    acoustic = inertia * c
    forward, drift = _accumulated(p, u, acoustic)
    backward = p + p[..., :1] - forward
    forward_u, _ = _accumulated(u, p, 1 / acoustic)
    step = period / p.shape[-1]
    dp, du = _derivative(p, step), _derivative(u, step)
    plus, minus = 0.5 * (dp + acoustic * du), 0.5 * (dp - acoustic * du)
    return WaveIntensity(
        forward,
        backward,
        forward_u,
        u + u[..., :1] - forward_u,
        _WATT * plus**2 / acoustic,
        -_WATT * minus**2 / acoustic,
        np.ptp(backward, axis=-1) / np.ptp(forward, axis=-1),
        drift,
    )


def _accumulated(p: np.ndarray, u: np.ndarray, acoustic: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return p₊, starting at p(0), and its change over the closed cycle; with p and u exchanged and 1/ρc, u₊."""
    mean = 0.5 * (acoustic + np.roll(acoustic, -1, axis=-1))
    rises = 0.5 * (np.roll(p, -1, axis=-1) - p + mean * (np.roll(u, -1, axis=-1) - u))
    total = np.cumsum(rises, axis=-1)
    forward = p[..., :1] + np.concatenate([np.zeros_like(p[..., :1]), total[..., :-1]], axis=-1)
    return forward, total[..., -1]


def _derivative(values: np.ndarray, step: float) -> np.ndarray:
    return (np.roll(values, -1, axis=-1) - np.roll(values, 1, axis=-1)) / (2 * step)


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
    selected = table[size >= smallest * size.max()] if len(table) else table
    return selected.sort_values("peak time [s]", ignore_index=True)


def largest_waves(table: pd.DataFrame) -> pd.DataFrame:
    """Return the row of largest area of every kind of wave in a table from `named_waves`, indexed by ``wave``."""
    order = table["area [W/cm2/s]"].abs().sort_values(ascending=False).index
    return table.loc[order].drop_duplicates("wave").set_index("wave").reindex(list(WAVES)).dropna(how="all")


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
