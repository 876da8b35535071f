"""The part of beat-by-beat levels that returns with every breath."""

import numpy as np

_RATES = (0.5, 4.0)
"""Breaths per second that are looked for: 30 to 240 a minute."""

_HARMONICS = 4
"""Harmonics of a breath: a hump of 40 % of it has few of size."""

_STRETCH = 60.0
"""Longer recordings are taken in stretches of this length, s: no ventilator keeps its phase for hours."""


def breathing(time: np.ndarray, level: np.ndarray, used: np.ndarray) -> np.ndarray:
    """Return the periodic part of the levels, of mean zero over a breath, shape (beat,); zeros if nothing repeats.

    Parameters
    ----------
    time, level : float array, shape (beat,)
        s, and the level without its trend.
    used : bool array, shape (beat,)
        Beats that count.
    """
    breath = np.zeros(len(time))
    count = max(1, round((time[-1] - time[0]) / _STRETCH))
    for part in np.array_split(np.arange(len(time)), count):
        if used[part].sum() >= 10 * _HARMONICS:
            breath[part] = _in_stretch(time[part] - time[part[0]], level[part], used[part])
    return breath


def _in_stretch(time: np.ndarray, level: np.ndarray, used: np.ndarray) -> np.ndarray:
    here, values = time[used], level[used] - level[used].mean()
    lasts = here[-1] - here[0]
    # Faster than half the heart rate, breaths cannot be told from slower ones.
    fastest = min(_RATES[1], 0.5 / float(np.median(np.diff(time))))
    rates = np.arange(_RATES[0], fastest, 1.0 / (8.0 * lasts))
    left = np.array([_fit(here, values, rate)[1] for rate in rates])
    if len(left) == 0:
        return np.zeros(len(time))
    best = int(np.argmin(left))
    # Bayes' criterion, and the choice among all rates on top.
    gain = len(values) * np.log(float(values @ values) / max(left[best], 1e-300))
    if gain < (2 * _HARMONICS + 1) * np.log(len(values)) + 2 * np.log(len(rates)):
        return np.zeros(len(time))
    near = rates[best] + np.linspace(-1.0, 1.0, 17) / (8.0 * lasts)
    rate = min(near, key=lambda rate: _fit(here, values, rate)[1])
    coefficients, _ = _fit(here, values, rate)
    return _columns(time, rate)[:, 1:] @ coefficients[1:]


def _fit(time: np.ndarray, values: np.ndarray, rate: float) -> tuple[np.ndarray, float]:
    """Return the coefficients of a breath of this rate and the sum of squares that is left."""
    columns = _columns(time, rate)
    gram = columns.T @ columns + 1e-9 * np.eye(columns.shape[1])
    coefficients = np.linalg.solve(gram, columns.T @ values)
    rest = values - columns @ coefficients
    return coefficients, float(rest @ rest)


def _columns(time: np.ndarray, rate: float) -> np.ndarray:
    phase = 2j * np.pi * rate * time
    waves = np.exp(phase[:, None] * np.arange(1, _HARMONICS + 1))
    return np.hstack([np.ones((len(time), 1)), waves.real, waves.imag])
