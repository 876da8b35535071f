"""Fourier series, input impedance, and characteristic impedance by several estimators side by side."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from vasowave.base.errors import InputError
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.model.nominal import characteristic_impedance, upstroke


@dataclass(frozen=True, eq=False)
class InputImpedance:
    """Impedance at harmonics 0 … K, arrays of shape (harmonic,).

    Attributes
    ----------
    frequency : array
        Hz.
    Z : complex array
        mmHg s/ml; Z[0] is mean pressure over mean flow.
    at_noise : bool array
        Harmonics whose flow amplitude is below the given noise level.
    """

    frequency: np.ndarray
    Z: np.ndarray
    at_noise: np.ndarray

    @property
    def modulus(self) -> np.ndarray:
        """|Z|, mmHg s/ml (eq. 19)."""
        return np.abs(self.Z)

    @property
    def phase(self) -> np.ndarray:
        """θ, rad (eq. 19); negative where pressure lags flow."""
        return np.angle(self.Z)


def fourier_series(samples: np.ndarray, harmonics: int = 14) -> np.ndarray:
    """Complex amplitudes S_k e^{iφ_k} of harmonics 0 … K (eq. 18), in the unit of `samples`.

    s(t) = Re Σ S_k e^{i(ω_k t + φ_k)}; samples are evenly spaced over one period, the first not repeated.

    Raises
    ------
    InputError
        Values that are not finite, or too few samples for `harmonics`.
    """
    s = np.asarray(samples, dtype=float)
    if s.ndim != 1 or len(s) <= 2 * harmonics or not np.all(np.isfinite(s)):
        raise InputError(f"{s.shape} samples cannot carry {harmonics} harmonics; give one finite cycle of more samples")
    amplitude = np.fft.rfft(s)[: harmonics + 1] / len(s)
    amplitude[1:] *= 2
    return amplitude


def impedance(
    pressure: np.ndarray, flow: np.ndarray, period: float, harmonics: int = 14, flow_noise: float = 0.0
) -> InputImpedance:
    """Input impedance Z = P/Q, mmHg s/ml (eq. 19), at harmonics 0 … `harmonics`.

    Parameters
    ----------
    pressure, flow : array, shape (time,)
        mmHg and ml/s over one period; the two may be sampled at different rates.
    period : float
        T, s.
    harmonics : int
    flow_noise : float
        Flow amplitude (ml/s) below which a harmonic is marked as noise.

    Raises
    ------
    InputError
        As `fourier_series`; also a period that is not positive, or a flow harmonic that is exactly zero.

    Examples
    --------
    >>> import vasowave as vw
    >>> mouse = vw.virtual_mouse()
    >>> spectrum = vw.impedance(mouse.pressure, mouse.flow, mouse.period)
    >>> float(round(spectrum.modulus[0] / mouse.input_resistance, 6))
    1.0
    """
    if not (np.isfinite(period) and period > 0):
        raise InputError(f"period {period:g} s is not a positive number")
    P, Q = fourier_series(pressure, harmonics), fourier_series(flow, harmonics)
    if np.any(Q == 0):
        raise InputError(f"flow harmonic {int(np.flatnonzero(Q == 0)[0])} is zero; its impedance does not exist")
    return InputImpedance(np.arange(harmonics + 1) / period, P / Q, np.abs(Q) < flow_noise)


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
        the paper's method. ``first half``: the same to 50 %, before beds store and waves return; the least biased of
        these on pulses of known Z_c (docs/analysis.md). ``95 % of peak flow``: Δp/Δq from 5 to 95 %. ``steepest rise``:
        largest
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
    half = max(int(np.argmax(q >= q[0] + 0.5 * (q[-1] - q[0]))) + 1, 3)
    dp, dq = (np.roll(signal, -1) - np.roll(signal, 1) for signal in (even.pressure, even.flow))
    return pd.Series(
        {
            "up-slope": characteristic_impedance(q, p),
            "first half": characteristic_impedance(q[:half], p[:half]),
            "95 % of peak flow": float((p[-1] - p[0]) / (q[-1] - q[0])),
            "steepest rise": float(dp.max() / dq.max()),
            "sum of squares": float(np.sqrt((dp @ dp) / (dq @ dq))),
            "high frequency": float(modulus.mean()) if len(modulus) else float("nan"),
        },
        name="Z_c [mmHg s/ml]",
    )
