"""The part of beat-by-beat levels that returns with every breath."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

_BREATH_RATES = (0.5, 4.0)
"""Breaths per second that are looked for in rodents: 30 to 240 a minute."""

_BEATS_A_BREATH = (2.5, 14.0)
"""Beats that a breath lasts: at least, and at most in animals whose hearts are slower than a rodent's."""

_BREATH_HARMONICS = 4
"""Harmonics of a breath: a hump of 40 % of it has few of size."""

_MAX_DEVIANCE_LOSS = 25.0
"""A breath explains as much as several do if its likelihood is smaller by less than exp of half of this."""

_STRETCH_SECONDS = 60.0
"""Longer recordings are taken in stretches of this length, s: no ventilator keeps its phase for hours."""

_RIDGE_SHARE = 1e-4
"""A combination of columns of which the times of the beats show less than this share is not fitted: where a breath
lasts a whole number of beats, a harmonic of it is the same in all of them, and noise in one beat would fit any height.
"""

_KERNEL_POINTS = 14
"""Grid points that one value is spread to, of a grid with twice the frequencies wanted."""

_KERNEL_STEEPNESS = 2.3 * _KERNEL_POINTS  # of the bump, the best for that grid


class Breath(NamedTuple):
    """What returns with every breath in one stretch of beats.

    Attributes
    ----------
    beats : int array, shape (beat,)
        Which beats.
    time : float array, shape (beat,)
        Of their levels, s since the first of them.
    rate : float
        Breaths per second.
    coefficients : float array, shape (1 + 2 harmonics,)
        Level, cosines, sines.
    """

    beats: np.ndarray
    time: np.ndarray
    rate: float
    coefficients: np.ndarray

    def at(self, time: np.ndarray) -> np.ndarray:
        """Return the breath, of mean zero, at times in s since the first of its beats."""
        return _columns(time, self.rate)[:, 1:] @ self.coefficients[1:]

    def within_beats(self, length: float) -> np.ndarray:
        """Return one breath at 200 even phases as it is where the levels are means over beats of a length, s."""
        passed = np.maximum(np.sinc(np.arange(1, _BREATH_HARMONICS + 1) * self.rate * length), 0.3)
        breath = self._replace(coefficients=self.coefficients / np.concatenate([[1.0], passed, passed]))
        return breath.at(np.arange(200) / (200 * self.rate))


def breathing(time: np.ndarray, level: np.ndarray, used: np.ndarray) -> np.ndarray:
    """Return the periodic part of the levels, of mean zero over a breath, shape (beat,); zeros if nothing repeats.

    Times (s) and levels without their trend are those of all beats, of which those that are `used` count.
    """
    breath = np.zeros(len(time))
    for stretch in find_breaths(time, level, used):
        breath[stretch.beats] = stretch.at(stretch.time)
    return breath


def find_breaths(time: np.ndarray, level: np.ndarray, used: np.ndarray) -> list[Breath]:
    """Return the breath of every stretch of a minute in which one is found; the arguments are those of `breathing`."""
    breaths = []
    count = max(1, round((time[-1] - time[0]) / _STRETCH_SECONDS))
    for beats in np.array_split(np.arange(len(time)), count):
        if used[beats].sum() >= 10 * _BREATH_HARMONICS:
            since = time[beats] - time[beats[0]]
            breath = _in_stretch(since[used[beats]], level[beats][used[beats]])
            breaths += [Breath(beats, since, *breath)] if breath else []
    return breaths


def _in_stretch(time: np.ndarray, level: np.ndarray) -> tuple[float, np.ndarray] | None:
    """Return rate and coefficients of the breath in a stretch, None if nothing repeats."""
    values = level - level.mean()
    step = 1.0 / (8.0 * (time[-1] - time[0]))
    beat = float(np.median(np.diff(time)))
    # Faster than half the heart rate, breaths cannot be told from slower ones.
    fastest = min(_BREATH_RATES[1], 1.0 / (_BEATS_A_BREATH[0] * beat))
    rates = np.arange(min(_BREATH_RATES[0], 1.0 / (_BEATS_A_BREATH[1] * beat)), fastest, step)
    if len(rates) == 0:
        return None
    best, squares = _best_rate(time, values, rates, step)
    # Bayes' criterion, and the choice among all rates on top.
    gain = len(values) * np.log(float(values @ values) / max(squares, 1e-300))
    if gain < (2 * _BREATH_HARMONICS + 1) * np.log(len(values)) + 2 * np.log(len(rates)):
        return None
    offsets = np.linspace(-1.0, 1.0, 17) * step
    rate, squares = _nearest(time, values, rates[best] + offsets)
    for times in (3, 2):  # several breaths repeat as one does; the shortest that explains as much is a breath
        if times * rate < fastest:
            faster, faster_squares = _nearest(time, values, times * rate + offsets)
            if len(values) * np.log(faster_squares / squares) < _MAX_DEVIANCE_LOSS:
                rate, squares = faster, faster_squares
                break
    slower = _shown_by_beats(_fit(time, values, rate), rate, beat)
    if rates[0] <= slower < fastest:
        slower, slower_squares = _nearest(time, values, slower + offsets)
        if len(values) * np.log(slower_squares / squares) < _MAX_DEVIANCE_LOSS:
            rate, squares = slower, slower_squares
    return rate, _fit(time, values, rate)


def _shown_by_beats(coefficients: np.ndarray, rate: float, beat: float) -> float:
    """Return the rate of the wave that beats of one length show of a breath's strongest overtone; 0 if it has none.

    They cannot tell the overtone from that wave, which is a breath by itself.
    """
    strongest = 1 + int(np.argmax((coefficients[1:].reshape(2, -1) ** 2).sum(axis=0)))
    return abs(strongest * rate - round(strongest * rate * beat) / beat) if strongest > 1 else 0.0


def _nearest(time: np.ndarray, values: np.ndarray, rates: np.ndarray) -> tuple[float, float]:
    """Return the best of some even rates, and the squares that it leaves."""
    best, squares = _best_rate(time, values, rates, float(rates[1] - rates[0]))
    return float(rates[best]), squares


def _best_rate(time: np.ndarray, values: np.ndarray, rates: np.ndarray, step: float) -> tuple[int, float]:
    """Return which of the rates, `step` apart, leaves least, and the squares that it leaves; all are fitted at once."""
    inverse = _inverse(time.tobytes(), float(rates[0]), step, len(rates))
    moment = np.empty((len(rates), 2 * _BREATH_HARMONICS + 1))
    moment[:, 0] = values.sum()
    for k in range(1, _BREATH_HARMONICS + 1):
        transform = _transform(time, values, k * rates[0], k * step, len(rates))
        moment[:, k], moment[:, _BREATH_HARMONICS + k] = transform.real, transform.imag
    squares = values @ values - np.sum((inverse @ moment[..., None])[..., 0] * moment, axis=1)
    best = int(np.argmin(squares))
    return best, float(squares[best])


@lru_cache(256)
def _inverse(times: bytes, first: float, step: float, count: int) -> np.ndarray:
    """Return the inverse of each rate's normal equations; kept, since an edit changes one stretch of many."""
    time, size = np.frombuffer(times), 2 * _BREATH_HARMONICS + 1
    ones = np.ones(len(time))
    sums = {k: _transform(time, ones, k * first, k * step, count) for k in range(1, size)}
    sums |= {0: np.full(count, len(time) + 0j)} | {-k: np.conj(value) for k, value in sums.items()}
    gram = np.empty((count, size, size))
    gram[:, 0, 0] = len(time)
    for k in range(1, _BREATH_HARMONICS + 1):
        cosine, sine = k, _BREATH_HARMONICS + k  # columns, as in `_columns`
        gram[:, 0, cosine], gram[:, 0, sine] = sums[k].real, sums[k].imag
        for m in range(1, _BREATH_HARMONICS + 1):
            difference, total = 0.5 * sums[k - m], 0.5 * sums[k + m]
            gram[:, cosine, m], gram[:, sine, _BREATH_HARMONICS + m] = (
                difference.real + total.real,
                difference.real - total.real,
            )
            gram[:, cosine, _BREATH_HARMONICS + m] = gram[:, _BREATH_HARMONICS + m, cosine] = (
                total.imag - difference.imag
            )
    gram[:, :, 0] = gram[:, 0]
    return np.linalg.inv(gram + _RIDGE_SHARE * len(time) * np.eye(size))


def _transform(time: np.ndarray, values: np.ndarray, first: float, step: float, count: int) -> np.ndarray:
    """Return the sums of values · exp(2πi f t) at `count` frequencies from `first` on, `step` apart.

    Values at uneven times are spread to an even grid by a narrow bump, transformed, and divided by the transform of
    the bump (Barnett et al. 2019, SIAM J. Sci. Comput. 41: C479), to 11 digits.
    """
    size = 1 << int(np.ceil(np.log2(2 * count + _KERNEL_POINTS)))
    centre = first + step * (count // 2)
    strengths = values * np.exp(2j * np.pi * centre * time)
    place = (step * time % 1.0) * size
    cells = np.floor(place).astype(np.int64)[:, None] + np.arange(1 - _KERNEL_POINTS // 2, 1 + _KERNEL_POINTS // 2)
    spread = _bump((cells - place[:, None]) * (2.0 / _KERNEL_POINTS)) * strengths[:, None]
    cells = (cells % size).ravel()
    grid = np.bincount(cells, spread.real.ravel(), size) + 1j * np.bincount(cells, spread.imag.ravel(), size)
    return np.fft.ifft(grid)[(np.arange(count) - count // 2) % size] * _undone(count, size)


@lru_cache(32)
def _undone(count: int, size: int) -> np.ndarray:
    """Return by what the transform of a spread value is multiplied, by frequency."""
    mode = np.arange(count) - count // 2
    nodes, weights = np.polynomial.legendre.leggauss(48)
    return size / (
        0.5 * _KERNEL_POINTS * np.cos(np.pi * _KERNEL_POINTS / size * np.outer(mode, nodes)) @ (_bump(nodes) * weights)
    )


def _bump(place: np.ndarray) -> np.ndarray:
    """Return the bump at places from -1 to 1, its ends."""
    return np.exp(_KERNEL_STEEPNESS * (np.sqrt(np.maximum(1.0 - place**2, 0.0)) - 1.0))


def _fit(time: np.ndarray, values: np.ndarray, rate: float) -> np.ndarray:
    """Return the coefficients of a breath of this rate."""
    columns = _columns(time, rate)
    gram = columns.T @ columns + _RIDGE_SHARE * len(time) * np.eye(columns.shape[1])
    return np.linalg.solve(gram, columns.T @ values)


def _columns(time: np.ndarray, rate: float) -> np.ndarray:
    phase = 2j * np.pi * rate * time
    waves = np.exp(phase[:, None] * np.arange(1, _BREATH_HARMONICS + 1))
    return np.hstack([np.ones((len(time), 1)), waves.real, waves.imag])
