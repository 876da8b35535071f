"""The exact likelihood of ARMA noise, compiled: orders are chosen from tens of thousands of likelihoods."""

from typing import Any

import numpy as np
from numba import njit

from vasowave.base.runtime.kernels import kept

_OPTIONS: Any = {"nogil": True, "error_model": "numpy"}
_DIFFERENCE_STEP = 1e-5  # of the central differences


@kept
@njit(**_OPTIONS)
def levinson(partial):
    """Return the coefficients that belong to partial autocorrelations (Levinson and Durbin)."""
    coefficients = np.zeros(len(partial))
    for k in range(len(partial)):
        before = coefficients.copy()
        for i in range(k):
            coefficients[i] = before[i] - partial[k] * before[k - 1 - i]
        coefficients[k] = partial[k]
    return coefficients


@kept
@njit(**_OPTIONS)
def impulse_response(ar, moving, count):
    """Return the first weights of x_t = Σ ψ_j e_{t-j}; `moving` starts with 1."""
    psi = np.zeros(count)
    for j in range(count):
        psi[j] = moving[j] if j < len(moving) else 0.0
        for i in range(min(j, len(ar))):
            psi[j] += ar[i] * psi[j - 1 - i]
    return psi


@kept
@njit(**_OPTIONS)
def _solved(matrix, right):
    """Solve a few equations by elimination with pivots; not finite where they are singular."""
    size = len(right)
    for i in range(size):
        pivot = i
        for k in range(i + 1, size):
            if abs(matrix[k, i]) > abs(matrix[pivot, i]):
                pivot = k
        for j in range(size):
            matrix[i, j], matrix[pivot, j] = matrix[pivot, j], matrix[i, j]
        right[i], right[pivot] = right[pivot], right[i]
        for k in range(i + 1, size):
            factor = matrix[k, i] / matrix[i, i]
            for j in range(i, size):
                matrix[k, j] -= factor * matrix[i, j]
            right[k] -= factor * right[i]
    for i in range(size - 1, -1, -1):
        for j in range(i + 1, size):
            right[i] -= matrix[i, j] * right[j]
        right[i] /= matrix[i, i]
    return right


@kept
@njit(**_OPTIONS)
def first_autocovariances(ar, moving):
    """Autocovariance for unit innovations, lags that determine all others (Brockwell & Davis, third method)."""
    order = max(len(ar) + 1, len(moving))
    psi = impulse_response(ar, moving, len(moving))
    matrix, right = np.zeros((order, order)), np.zeros(order)
    for lag in range(order):
        for j in range(lag, len(moving)):
            right[lag] += moving[j] * psi[j - lag]
        matrix[lag, lag] += 1.0
        for i in range(len(ar)):
            matrix[lag, abs(lag - 1 - i)] -= ar[i]
    return _solved(matrix, right)


@kept
@njit(**_OPTIONS)
def squares_and_log_determinant(ar, ma, series):
    """Sum of squares of the whitened series, and log det of the covariance of one; NaN if it is not positive definite.

    The first m = max(p, q) samples stay, every later one becomes w_t = x_t - Σ φ_i x_{t-i} (Ansley 1979): the
    covariance of those has a band of width m, so its Cholesky factor costs N m². Rows of the factor are kept as long as
    later ones need them.
    """
    p, q, count = len(ar), len(ma), series.shape[1]
    m = max(p, q, 1)
    moving = np.append(np.ones(1), ma)
    gamma, psi = first_autocovariances(ar, moving), impulse_response(ar, moving, q + 1)
    inner, across = np.zeros(m + 1), np.zeros(m + 1)  # covariances of w, and of w with the first samples
    for lag in range(q + 1):
        for j in range(lag, q + 1):
            inner[lag] += moving[j] * moving[j - lag]
            across[lag] += moving[j] * psi[j - lag]
    rows, white = np.zeros((count, m + 1)), np.zeros(series.shape)  # rows[t, m - lag] is the factor at (t, t - lag)
    squares = log_det = 0.0
    for t in range(count):
        for lag in range(min(t, m), -1, -1):
            s = t - lag
            value = gamma[lag] if t < m and lag < len(gamma) else (across[lag] if s < m else inner[lag])
            for k in range(max(0, t - m), s):
                value -= rows[t, m - t + k] * rows[s, m - s + k]
            if lag > 0:
                rows[t, m - lag] = value / rows[s, m]
            elif value > 0:
                rows[t, m] = np.sqrt(value)
            else:
                return np.nan, np.nan
        log_det += 2.0 * np.log(rows[t, m])
        for row in range(len(series)):
            w = series[row, t]
            if t >= m:
                for i in range(p):
                    w -= ar[i] * series[row, t - 1 - i]
            for k in range(max(0, t - m), t):
                w -= rows[t, m - t + k] * white[row, k]
            white[row, t] = w / rows[t, m]
            squares += white[row, t] ** 2
    return squares, log_det


@kept
@njit(**_OPTIONS)
def _height(x, p, series):
    """Minus the concentrated log-likelihood per sample, up to a constant."""
    ar, ma = levinson(np.tanh(x[:p])), -levinson(np.tanh(x[p:]))
    squares, log_det = squares_and_log_determinant(ar, ma, series)
    return 0.5 * (np.log(squares / series.size) + len(series) * log_det / series.size)


@kept
@njit(**_OPTIONS)
def height_and_slope(x, p, series):
    """Minus the concentrated log-likelihood per sample, up to a constant, and its gradient, of series (series, sample).

    The tanh of each x, shape (p + q,), is a partial autocorrelation, so every model is stationary and invertible.
    """
    slope = np.empty(len(x))
    for i in range(len(x)):
        moved = x.copy()
        moved[i] = x[i] + _DIFFERENCE_STEP
        above = _height(moved, p, series)
        moved[i] = x[i] - _DIFFERENCE_STEP
        slope[i] = (above - _height(moved, p, series)) / (2.0 * _DIFFERENCE_STEP)
    return _height(x, p, series), slope
