"""Fourier series and input impedance."""

from dataclasses import dataclass

import numpy as np

from vasowave.errors import InputError


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
