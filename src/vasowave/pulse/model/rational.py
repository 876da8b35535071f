"""Impedances as rational functions: a resistance and a few poles, which a solver steps exactly and cheaply.

A spectrum is approximated by vector fitting: poles are moved until the spectrum times a function that has zeros where
the poles should be is a sum of the same partial fractions (Gustavsen and Semlyen, IEEE Trans. Power Deliv. 14, 1999;
relaxed: Gustavsen, ibid. 21, 2006). The steady resistance is kept exactly, all poles decay, and the real part is
brought above zero at every frequency, so that no bed gives off energy.
"""

from typing import NamedTuple

import numpy as np

SIGNAL = 10
"""Harmonics that carry the pulse of pressure and flow."""

CLOSE = 0.002
"""Largest error of the impedance there, as a share of it, that ends the search for more poles."""

MOST = 64
"""Harmonics to which more poles are fitted, at most."""

_ORDERS = 1, 2, 4, 7, 10, 13
_MORE = 20, 30, 44, 60  # where those miss the harmonics that carry the signal
_ENOUGH = 1e-5  # root mean square error, as a share of the impedance, that ends the search for more poles
_BETTER, _STALLED = 0.8, 2  # the poles are moved until this often in turn the error is no longer multiplied by less
_SINGULAR = 1e-4  # singular values below this share of the largest move nothing when a bed changes a little
_FLAT = 1e-8  # least value at infinity of the function whose zeros are the new poles
_FITTED = 48  # harmonics that are all fitted; above, one in every twelfth of a factor e
_IMPORTANCE = 16.0  # harmonics above it count less, as they do in the flow
_DAMPED = 0.02  # a starting pole's rate over its angular frequency
_PASSIVE = 1e-9  # share of the resistance by which the real part stays above zero
_NEAR = 0.02  # a dip to this share of the resistance may be below zero between the places that are looked at
_REPAIRS = 30  # times that the places where it does not are added to those where it must
_WIDE, _AROUND = np.linspace(0.0, 1.0, 200), np.tan(np.linspace(-1.4, 1.4, 15))
"""Where the real part is looked at: between the lowest and the highest frequency, and in half widths of a pole."""


_ZERO = np.zeros(1)


class Rational(NamedTuple):
    """Z(s) = direct + ½ Σ [r/(s - p) + r*/(s - p*)]: to a flow q, direct·q + Re Σ x with dx/dt = p x + r q.

    Attributes
    ----------
    direct : array, shape (terminal,)
        Resistance that a sudden change meets, mmHg s/ml.
    poles : complex array, shape (terminal, mode)
        p, 1/s; one of each pair. Real parts are negative.
    residues : complex array, shape (terminal, mode)
        r, mmHg/ml; 0 where a bed has fewer modes.
    """

    direct: np.ndarray
    poles: np.ndarray
    residues: np.ndarray

    def impedance(self, s: np.ndarray) -> np.ndarray:
        """Impedance, mmHg s/ml, at complex frequencies (1/s); shape (*s.shape, terminal)."""
        s = np.asarray(s)[..., np.newaxis, np.newaxis]
        direct_terms = self.residues / (s - self.poles)
        conjugate_terms = self.residues.conj() / (s - self.poles.conj())
        return np.asarray(self.direct + 0.5 * np.sum(direct_terms + conjugate_terms, axis=-1))

    def over(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Return what is left of the modes after a time (s), and what each ml/s adds to them meanwhile."""
        decay = np.exp(self.poles * time)
        return decay, self.residues * np.expm1(self.poles * time) / self.poles

    def waves(self, flow: np.ndarray, period: float, time: float) -> np.ndarray:
        """Return the modes at a time (s) of a periodic flow with harmonics (harmonic, terminal): (terminal, mode)."""
        s = 2j * np.pi / period * np.arange(len(flow))[:, np.newaxis, np.newaxis]
        q = flow[..., np.newaxis] * np.exp(s * time)
        modes = q / (s - self.poles) + q.conj() / (s.conj() - self.poles)
        return np.asarray(0.5 * self.residues * np.sum(modes, axis=0))


def bare(direct: np.ndarray) -> Rational:
    """Return bare resistances (mmHg s/ml, shape (terminal,))."""
    empty = np.zeros((len(direct), 0), dtype=complex)
    return Rational(np.array(direct, dtype=float), empty, empty)


def joined(beds: list[Rational], width: int = 0) -> Rational:
    """Return single beds as one array of them, the missing modes (of `width` in all, at least) without residue."""
    width = max(width, *(bed.poles.shape[1] for bed in beds))

    def wide(values: np.ndarray, fill: float) -> np.ndarray:
        return np.pad(values, ((0, 0), (0, width - values.shape[1])), constant_values=fill)

    return Rational(
        np.concatenate([bed.direct for bed in beds]),
        np.concatenate([wide(bed.poles, -1.0) for bed in beds]),
        np.concatenate([wide(bed.residues, 0.0) for bed in beds]),
    )


def fitted(omega: np.ndarray, Z: np.ndarray, order: int | None = None) -> Rational:
    """Return the passive rational function nearest to one bed's impedance.

    Parameters
    ----------
    omega : array, shape (frequency,)
        Angular frequencies, rad/s, the first of them 0.
    Z : complex array, shape (frequency,)
        mmHg s/ml; Z[0] is the resistance, which is kept.
    order : int, optional
        Number of poles; by default as few as are enough.
    """
    unit, scale = omega[1], Z[0].real
    s, z = 1j * omega / unit, Z / scale
    best: tuple[float, np.ndarray, np.ndarray] = np.inf, _ZERO, _ZERO
    for count in (order,) if order is not None else _ORDERS:
        if order is None and count > max(1, (2 * len(z) - 2) // 3):
            break
        candidate = _moved(s, z, _begun(count, omega[-1] / unit))
        if candidate[0] < 0.5 * best[0]:
            best = candidate
        if candidate[0] < _ENOUGH:
            break
    _, poles, coefficients = best
    return _made(poles, _passive(s, z, poles, coefficients)[0], unit, scale)


def _made(poles: np.ndarray, coefficients: np.ndarray, unit: float, scale: float) -> Rational:
    """Return the function of these poles and coefficients, with its units: rad/s and mmHg s/ml."""
    residues = _residues(poles, coefficients)
    direct = 1.0 + np.sum((residues / poles).real)
    return Rational(np.array([max(direct, 0.0) * scale]), poles[np.newaxis] * unit, residues[np.newaxis] * unit * scale)


def misfit(Z: np.ndarray, by: np.ndarray) -> np.ndarray:
    """Return the largest error of impedances at the harmonics that carry the signal, as a share, shape (terminal,).

    Both have the shape (harmonic, terminal), from the mean on.
    """
    harmonics = slice(1, SIGNAL + 1)
    return np.asarray(np.max(np.abs(by[harmonics] - Z[harmonics]) / np.abs(Z[harmonics]), axis=0))


def refined(harmonic: np.ndarray, heart: float, Z: np.ndarray, start: Rational, noise: bool) -> Rational:
    """Return `start` or, of one bed, the passive function of so many more poles that it meets the signal's harmonics.

    Parameters
    ----------
    harmonic : array, shape (frequency,)
        Frequencies in multiples of the heart's, the first of them 0; those between harmonics tell what poles are to do
        there.
    heart : float
        Angular frequency of the heart, rad/s.
    Z : complex array, shape (frequency,)
        mmHg s/ml.
    start : Rational
        Of this bed alone.
    noise : bool
        Whether the impedance may be measured: then more poles must leave less than half of what they leave of noise.
    """
    scale, s = Z[0].real, 1j * harmonic
    z, weight, best = Z / scale, _weights(s, Z)[:, np.newaxis], start
    rows = np.flatnonzero(harmonic == np.round(harmonic))

    def errors(function: Rational) -> tuple[float, float]:
        met = function.impedance(s * heart) - Z[:, np.newaxis]
        return float(np.linalg.norm(weight * met)), misfit(Z[rows, np.newaxis], met[rows] + Z[rows, np.newaxis])[0]

    smallest, off = errors(best)
    free = 2 * len(z) - 1 - 2 * np.count_nonzero(best.residues)  # numbers that are fitted, less those that are found
    for count in _MORE:
        if count > len(z) - 2 or off <= CLOSE:
            break
        started = (_moved(s, z, begun(count, harmonic[-1])) for begun in (_begun, _begun_damped))
        _, poles, coefficients = min(started, key=lambda moved: moved[0])
        coefficients, passive = _passive(s, z, poles, coefficients)
        candidate = _made(poles, coefficients, heart, scale)
        deviation, worst = errors(candidate)
        of_noise = np.sqrt((2 * len(z) - 1 - 2 * count) / free)
        if passive and (deviation < 0.5 * of_noise * smallest if noise else worst < off):
            best, smallest, off = candidate, deviation, worst
    return best


def nearby(omega: np.ndarray, change: np.ndarray, base: Rational, heart: float | None = None) -> Rational:
    """Return `base` with poles and residues moved so that it changes by the least squares that are linear in them.

    Angular frequencies (rad/s) begin with 0, and the second is the heart's if none is given; the change has the shape
    (frequency, terminal), that of the resistance is kept.
    """
    s, beds, weight = 1j * omega, [], importance(omega / (heart or omega[1]))[1:]
    for j, by in enumerate(change.T):
        used = base.residues[j] != 0
        p, r = base.poles[j, used], base.residues[j, used]
        direct_terms, conjugate_terms = 1.0 / (s[:, np.newaxis] - p), 1.0 / (s[:, np.newaxis] - p.conj())
        twice, twice_other = r * direct_terms**2, r.conj() * conjugate_terms**2
        pair = p.imag != 0
        moves = [
            direct_terms + conjugate_terms,
            twice + twice_other,
            1j * (direct_terms - conjugate_terms)[:, pair],
            1j * (twice - twice_other)[:, pair],
        ]
        matrix = 0.5 * np.concatenate(moves, axis=1)
        matrix = weight[:, np.newaxis] * (matrix[1:] - matrix[0])
        target = weight * (by[1:] - by[0])
        solution = _solved(_split(matrix), _split(target), _SINGULAR)
        (dr, dp), turned = solution[: 2 * len(p)].reshape(2, -1) + 0j, solution[2 * len(p) :].reshape(2, -1)
        dr[pair] += 1j * turned[0]
        dp[pair] += 1j * turned[1]
        direct = base.direct[j] + by[0].real + np.sum(((r + dr) / (p + dp) - r / p).real)
        beds.append(Rational(np.array([direct]), (p + dp)[np.newaxis], (r + dr)[np.newaxis]))
    return joined(beds, base.poles.shape[1])


def worth_fitting(count: int) -> np.ndarray:
    """Return which of so many harmonics are fitted: all low ones, and fewer and fewer of the high ones."""
    if count <= _FITTED:
        return np.arange(count)
    high = np.exp(np.arange(np.log(_FITTED), np.log(count - 1), 1 / 12))
    return np.unique(np.concatenate([np.arange(_FITTED), high.astype(int), [count - 1]]))


def importance(harmonic: np.ndarray) -> np.ndarray:
    """Return how much harmonics count: less and less from the sixteenth on, as in the flow."""
    return np.asarray(1.0 / (1.0 + (harmonic / _IMPORTANCE) ** 2))


def _weights(s: np.ndarray, z: np.ndarray) -> np.ndarray:
    return importance(s.imag) / np.abs(z)


def _begun(count: int, highest: float) -> np.ndarray:
    """Return starting poles, one of each pair, spread over the frequencies."""
    single = count if count < 4 else count % 2
    rates = -np.geomspace(0.3, max(0.6, 0.5 * highest), count if count < 4 else 2)[:single]
    pairs = np.geomspace(0.7, max(1.4, min(highest, 64.0)), (count - single) // 2)
    return np.concatenate([rates.astype(complex), (-_DAMPED + 1j) * pairs])


def _begun_damped(count: int, highest: float) -> np.ndarray:
    """Return starting poles of which a quarter are relaxations and the pairs evenly spread, as a tube's resonances."""
    pairs = np.linspace(0.7, max(1.4, min(highest, 40.0)), 3 * count // 8)
    rates = -np.geomspace(0.05, 3.0 * highest, count - 2 * len(pairs))
    return np.concatenate([rates.astype(complex), (-_DAMPED + 1j) * pairs])


def _columns(s: np.ndarray, poles: np.ndarray) -> np.ndarray:
    """Return the partial fractions of real coefficients, shape (frequency, coefficient): reals, then two a pair."""
    single = poles.imag == 0
    real, pair = poles[single], poles[~single]
    direct_terms, conjugate_terms = 1.0 / (s[:, np.newaxis] - pair), 1.0 / (s[:, np.newaxis] - pair.conj())
    return np.concatenate(
        [1.0 / (s[:, np.newaxis] - real), direct_terms + conjugate_terms, 1j * (direct_terms - conjugate_terms)], axis=1
    )


def _residues(poles: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    """Return the residues as `Rational` has them of coefficients as in `_columns`."""
    single = poles.imag == 0
    count, pairs = int(single.sum()), int((~single).sum())
    pair = coefficients[count : count + pairs] + 1j * coefficients[count + pairs :]
    return np.concatenate([coefficients[:count], 2.0 * pair])


def _split(values: np.ndarray) -> np.ndarray:
    return np.concatenate([values.real, values.imag])


def _solved(matrix: np.ndarray, right: np.ndarray, singular: float = 1e-13) -> np.ndarray:
    size = np.linalg.norm(matrix, axis=0) + 1e-300
    return np.asarray(np.linalg.lstsq(matrix / size, right, rcond=singular)[0] / size)


def _moved(s: np.ndarray, z: np.ndarray, poles: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Return the least error that moving the poles by relaxed vector fitting comes to, with poles and coefficients."""
    weight, ones = _weights(s, z)[:, np.newaxis], np.ones((len(s), 1))
    best: tuple[float, np.ndarray, np.ndarray] = np.inf, poles, _ZERO
    stalled = 0
    while stalled < _STALLED:
        columns = _columns(s, poles)
        basis = np.concatenate([columns, ones], axis=1)
        n = basis.shape[1]
        system = weight * np.concatenate([basis, -z[:, np.newaxis] * basis], axis=1)
        r = np.asarray(np.linalg.qr(_split(system), mode="r"))
        relaxed = np.concatenate([r[n:, n:], [basis.real.mean(axis=0)]])
        right = np.zeros(len(relaxed))
        right[-1] = 1.0
        zeros = _solved(relaxed, right)
        poles = _zeros(poles, zeros[:-1] / (zeros[-1] if abs(zeros[-1]) > _FLAT else _FLAT))
        matrix, target = _problem(s, z, poles)
        coefficients = _solved(matrix, target)
        error = float(np.sqrt(np.sum((matrix @ coefficients - target) ** 2) / len(z)))
        stalled = 0 if error < _BETTER * best[0] else stalled + 1
        if error < best[0]:
            best = error, poles, coefficients
        if error < 0.1 * _ENOUGH:
            break
    return best


def _problem(s: np.ndarray, z: np.ndarray, poles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return matrix and right-hand side of the least-squares problem for the coefficients; Z(0) is 1."""
    weight = _weights(s, z)
    columns = _columns(s, poles) - _columns(_ZERO, poles)
    return _split(weight[:, np.newaxis] * columns), _split(weight * (z - 1.0))


def _zeros(poles: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    """Return the zeros of 1 + Σ partial fractions, those that would grow mirrored; reals first, then one of a pair."""
    single = poles.imag == 0
    real, pair = poles[single].real, poles[~single]
    n, m = len(real), len(pair)
    A, b, c = np.zeros((n + 2 * m, n + 2 * m)), np.ones(n + 2 * m), coefficients.copy()
    A[range(n), range(n)] = real
    first, second = n + np.arange(m), n + m + np.arange(m)
    A[first, first] = A[second, second] = pair.real
    A[first, second], A[second, first] = pair.imag, -pair.imag
    b[first], b[second] = 2.0, 0.0
    zeros = np.linalg.eigvals(A - np.outer(b, c))
    zeros = -np.abs(zeros.real) + 1j * zeros.imag
    flat = np.abs(zeros.imag) < 1e-9 * np.abs(zeros)
    reals = np.sort(zeros[flat].real)
    reals = np.minimum(reals, -1e-6)
    pairs = zeros[~flat & (zeros.imag > 0)]
    pairs = np.minimum(pairs.real, -1e-6 * np.abs(pairs)) + 1j * pairs.imag
    return np.concatenate([reals.astype(complex), pairs[np.argsort(pairs.imag)]])


def _passive(s: np.ndarray, z: np.ndarray, poles: np.ndarray, coefficients: np.ndarray) -> tuple[np.ndarray, bool]:
    """Return the coefficients nearest to the impedance with a real part positive everywhere, and whether it is."""
    if not np.any(poles.imag) and np.all(coefficients >= 0) and 1.0 + np.sum(coefficients / poles.real) >= 0:
        return coefficients, True  # relaxations, all positive
    watched, held = _watched(poles, np.abs(s[-1])), np.empty((0, len(coefficients)))
    for _ in range(_REPAIRS):
        rows = _deepest(watched, poles, coefficients)
        low = 1.0 + rows @ coefficients < 0.5 * _PASSIVE
        if not low.any():
            return coefficients, True
        held = np.concatenate([held, rows[low]])
        coefficients = _constrained(*_problem(s, z, poles), held, np.full(len(held), 2 * _PASSIVE - 1.0))
    return coefficients, False


def _real_rows(omega: np.ndarray, poles: np.ndarray) -> np.ndarray:
    """Return what makes the real part, less 1, of coefficients, shape (frequency, coefficient)."""
    return np.asarray((_columns(1j * omega, poles) - _columns(_ZERO, poles)).real)


def _deepest(watched: np.ndarray, poles: np.ndarray, coefficients: np.ndarray) -> np.ndarray:
    """Return the rows of the places where the real part is lowest: between the watched ones, and at infinity."""
    rows = _real_rows(watched, poles)
    real = rows @ coefficients
    dips = 1 + np.flatnonzero((real[1:-1] <= real[:-2]) & (real[1:-1] <= real[2:]))
    dips = dips[1.0 + real[dips] < _NEAR]
    if not len(dips):
        return np.concatenate([rows[[0, -1]], -_columns(_ZERO, poles).real])
    low, high = watched[dips - 1], watched[dips + 1]
    for _ in range(3):  # each narrows the place of a dip to a tenth
        inside = low + (high - low) * np.linspace(0.0, 1.0, 21)[:, np.newaxis]
        real = (_real_rows(inside.ravel(), poles) @ coefficients).reshape(inside.shape)
        best = np.clip(np.argmin(real, axis=0), 1, 19)
        low, high = (np.take_along_axis(inside, best[np.newaxis] + side, axis=0)[0] for side in (-1, 1))
    return np.concatenate([rows[[0, -1]], _real_rows(0.5 * (low + high), poles), -_columns(_ZERO, poles).real])


def _watched(poles: np.ndarray, highest: float) -> np.ndarray:
    """Return the frequencies at which the real part is looked at: all scales, and closely around every pole."""
    sizes = np.abs(poles)
    low, high = 1e-3 * sizes.min(), 1e3 * max(sizes.max(), highest)
    around = poles.imag + np.abs(poles.real) * _AROUND[:, np.newaxis]
    return np.sort(np.concatenate([[0.0], low * (high / low) ** _WIDE, around[around > 0].ravel()]))


def _constrained(matrix: np.ndarray, right: np.ndarray, rows: np.ndarray, lower: np.ndarray) -> np.ndarray:
    """Return the least-squares solution with rows @ x >= least (Lawson and Hanson 1974, chapter 23)."""
    from scipy.linalg import solve_triangular
    from scipy.optimize import nnls

    size = np.linalg.norm(matrix, axis=0) + 1e-300
    q, r = np.linalg.qr(matrix / size)
    x0 = q.T @ right
    # z = R x - Qᵀ b is the move of the residual; G z >= h with G = rows R⁻¹
    G = solve_triangular(r, (rows / size).T, trans="T").T
    h = lower - G @ x0
    E, f = np.concatenate([G.T, h[np.newaxis]]), np.append(np.zeros(G.shape[1]), 1.0)
    u, _ = nnls(E, f)
    gone = E @ u - f
    move = -gone[:-1] / gone[-1] if abs(gone[-1]) > 1e-14 else np.zeros(G.shape[1])
    return np.asarray(solve_triangular(r, x0 + move) / size)
