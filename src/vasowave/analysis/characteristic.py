"""Characteristic impedance by several estimators side by side."""

import numpy as np
import pandas as pd

from vasowave.analysis.impedance import impedance
from vasowave.errors import InputError
from vasowave.model.nominal import characteristic_impedance, upstroke
from vasowave.recording import Recording


def characteristic_impedances(
    recording: Recording, harmonics: tuple[int, int] = (4, 10), flow_noise: float = 0.0
) -> pd.Series:
    """Estimates of Z_c, mmHg s/ml (eq. 8), from one cycle; where they disagree, reflections or delays are at work.

    Parameters
    ----------
    recording : Recording
        Measured, or made from the simulated pressure and flow of any station.
    harmonics : (first, last)
        Harmonics over which |Z| is averaged.
    flow_noise : float
        Flow amplitude (ml/s) below which a harmonic is left out of that average.

    Returns
    -------
    Series
        ``up-slope``: least-squares slope of p against q from the onset of ejection (5 % of peak flow) to 95 % of it,
        the paper's method. ``95 % of peak flow``: Δp/Δq between the ends of that stretch. ``steepest rise``: largest
        dp/dt over largest dq/dt. ``sum of squares``: √(Σ(dp/dt)²/Σ(dq/dt)²) over the cycle (the single-point method).
        ``high frequency``: mean |Z| of the harmonics; NaN if all of them are noise.

    Raises
    ------
    InputError
        Harmonics that the recording cannot carry, or an upstroke of fewer than three samples.
    """
    if not 1 <= harmonics[0] <= harmonics[1]:
        raise InputError(f"harmonics {harmonics}: give the first and the last, from 1 upwards")
    even = recording.resampled(max(len(recording.pressure), len(recording.flow)))
    spectrum = impedance(even.pressure, even.flow, even.period, harmonics[1], flow_noise)
    modulus = spectrum.modulus[harmonics[0] :][~spectrum.at_noise[harmonics[0] :]]
    q, p = upstroke(even)
    if len(q) < 3 or q[-1] <= q[0]:
        raise InputError(
            f"{recording.source}: no upstroke of flow (from 5 to 95 % of its peak in {len(q)} samples); "
            "check that flow is near zero before ejection, and sample it more finely"
        )
    dp, dq = (np.roll(signal, -1) - np.roll(signal, 1) for signal in (even.pressure, even.flow))
    return pd.Series(
        {
            "up-slope": characteristic_impedance(q, p),
            "95 % of peak flow": float((p[-1] - p[0]) / (q[-1] - q[0])),
            "steepest rise": float(dp.max() / dq.max()),
            "sum of squares": float(np.sqrt((dp @ dp) / (dq @ dq))),
            "high frequency": float(modulus.mean()) if len(modulus) else float("nan"),
        },
        name="Z_c [mmHg s/ml]",
    )
