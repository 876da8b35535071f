"""Which wall law the residuals prefer, by AICc and BIC under every noise model: the paper's table AICcBIC."""

from collections.abc import Callable, Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr

from vasowave.calibration.generalized import reoptimize
from vasowave.calibration.result import Fit
from vasowave.errors import InputError
from vasowave.noise.fitting import NOISE, Sharing, fit_noise
from vasowave.noise.models import Noise
from vasowave.recording import resample
from vasowave.selection.table import dataset, noise_bic, preferred, scored
from vasowave.solver.simulate import Numerics

Optima = Literal["OLS", "GLS"]
Refit = Callable[[Noise], tuple[dict[str, np.ndarray], bool]]
"""Under a noise model: the residuals of every wall law at its generalized optimum, and whether they fit the data."""

_MOST_WORSE = 2.0  # root-mean-square residual over that of least squares
_FEWEST = 16  # samples of a residual from which a covariance can be estimated


class Comparing(NamedTuple):
    """How wall laws are compared.

    Attributes
    ----------
    covariances : tuple of str
        Noise models, of `NOISE`.
    sharings : tuple of {"joint", "average"}
        How the one covariance of all wall laws is found: by their joint likelihood, or as the mean of separate ones.
    largest_weight : float
        A covariance whose 2-norm condition number needs a larger λ to fall to 10⁴ is discarded.
    starts, seed : int
        Of the maximizations of the likelihood.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Comparing(covariances=("circulant", "ARMA")).starts
    4
    """

    covariances: Sequence[str] = NOISE
    sharings: Sequence[Sharing] = ("joint", "average")
    largest_weight: float = 0.1
    starts: int = 4
    seed: int = 0


def compare_models(
    fits: Sequence[Fit],
    how: Comparing | None = None,
    *,
    optima: Sequence[Optima] = ("OLS",),
    samples: int | None = 512,
    numerics: Numerics | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> xr.Dataset:
    """AICc and BIC of the wall laws of one animal under every noise model (eqs. 21 to 23; the paper's table AICcBIC).

    Parameters
    ----------
    fits : sequence of Fit
        Of one recording, one for each wall law.
    how : Comparing, optional
        Noise models, regularization, seed.
    optima : sequence of {"OLS", "GLS"}
        Scores at the least-squares optimum (the paper; takes seconds), and at the generalized-least-squares optimum
        under the same covariance (simulates some tens to hundred times for every row).
    samples : int, optional
        N is at most this (the paper's 512); longer residuals are resampled in Fourier space. A fit that compared the
        harmonics with signal has fewer. None: as fitted.
    numerics : Numerics, optional
        As given to `calibrate`, for the GLS optimum.
    progress : callable, optional
        Called with finished rows, all rows and what was just done.

    Returns
    -------
    Dataset
        As from `compare_residuals`, with both optima if asked for.

    Raises
    ------
    InputError
        Fewer than two fits, of different recordings or the same wall law; unknown names.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, recording, search = vw.control_network(), vw.virtual_mouse(), vw.Search(starts=1)
    >>> fits = [vw.calibrate(network, recording, wall, search=search) for wall in ("linear", "tangent")]
    >>> table = vw.compare_models(fits, vw.Comparing(covariances=("circulant",), sharings=("joint",)))
    >>> sorted(str(wall) for wall in table["wall"].values)
    ['linear', 'tangent']
    """
    _check_fits(fits, optima)
    N = fits[0].N if samples is None else min(samples, fits[0].N)
    residuals = {fit.wall: resample(fit.pressure_residual, N) for fit in fits}
    counts = {fit.wall: int(fit.parameters["free"].sum()) for fit in fits}

    def refit(noise: Noise) -> tuple[dict[str, np.ndarray], bool]:
        def whiten(values: np.ndarray) -> np.ndarray:
            return noise.whiten(resample(values, N))

        ends = {fit.wall: resample(reoptimize(fit, whiten, numerics=numerics).residual, N) for fit in fits}
        return ends, not any(explained_away(fit, ends[fit.wall]) for fit in fits)

    refits: dict[str, Refit | None] = {one: refit if one == "GLS" else None for one in optima}
    return compare_residuals(residuals, counts, fits[0].recording.period, how, refits=refits, progress=progress)


def compare_residuals(
    residuals: Mapping[str, np.ndarray],
    n_parameters: Mapping[str, int],
    period: float,
    how: Comparing | None = None,
    *,
    refits: Mapping[str, Refit | None] | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> xr.Dataset:
    """AICc and BIC of models by their residuals alone (eqs. 21 to 23).

    Parameters
    ----------
    residuals : mapping of model to array, shape (sample,)
        Measured minus simulated pressure, mmHg, evenly spaced over one period.
    n_parameters : mapping of model to int
        D, the fitted parameters of each model; hyperparameters of the noise are shared and not counted.
    period : float
        T, s.
    how : Comparing, optional
    refits : mapping of optimum to callable or None, optional
        By default the residuals as they are (``{"OLS": None}``).
    progress : callable, optional

    Returns
    -------
    Dataset
        Dim ``candidate``: one for every covariance, sharing, optimum and wall law, the likeliest covariance first and
        in each the best wall law first, discarded ones last. Variables as described by their ``long_name``. Attributes:
        largest_condition, largest_lambda, seed, preferred_covariance (highest joint log-likelihood, penalized as
        by BIC for its hyperparameters, among those of the joint likelihood that are not discarded).

    Raises
    ------
    InputError
        Fewer than two models, residuals of different length or without variance, unknown names.
    """
    how, refits = how or Comparing(), refits or {"OLS": None}
    series = _series(residuals, n_parameters, period)
    rng, blocks = np.random.default_rng(how.seed), list[list[dict]]()
    count = len(how.covariances) * len(how.sharings) * len(refits)
    for covariance in how.covariances:
        for sharing in how.sharings:
            noise = fit_noise(covariance, series, period, sharing=sharing, starts=how.starts, rng=rng)
            for optimum, refit in refits.items():
                at, useful = (residuals, True) if refit is None else refit(noise)
                label = {
                    "covariance": covariance,
                    "sharing": sharing,
                    "optimum": optimum,
                    "discarded": noise.weight > how.largest_weight or not useful,
                }
                blocks.append([label | row for row in scored(at, n_parameters, noise)])
                if progress is not None:
                    progress(len(blocks), count, f"{covariance}, {sharing}, {optimum}")
    blocks.sort(key=lambda rows: (rows[0]["discarded"], noise_bic(rows)))
    return dataset([row for rows in blocks for row in rows]).assign_attrs(
        largest_condition=1e4,
        largest_lambda=how.largest_weight,
        seed=how.seed,
        preferred_covariance=preferred(blocks),
    )


def explained_away(fit: Fit, residual: np.ndarray) -> bool:
    """Whether a generalized-least-squares optimum misses the data by more than twice what least squares leaves.

    A spectrum that falls steeply takes errors of the mean pressure for likely and puts all weight on the smallest
    harmonics; what is found then is no calibration.
    """
    return bool(np.mean(residual**2) > (_MOST_WORSE * fit.rmse) ** 2)


def _check_fits(fits: Sequence[Fit], optima: Sequence[str]) -> None:
    walls = [fit.wall for fit in fits]
    if len(set(walls)) < 2 or len(set(walls)) != len(walls):
        raise InputError(f"a comparison needs fits of different wall laws; given: {', '.join(walls) or 'none'}")
    first = fits[0].recording
    for fit in fits[1:]:
        same = fit.recording.period == first.period and np.array_equal(fit.recording.pressure, first.pressure)
        if not (same and fit.N == fits[0].N):
            raise InputError(
                f"the {fit.wall} wall was fitted to another recording, or to other harmonics of it, than the "
                f"{fits[0].wall} wall"
            )
    unknown = [one for one in optima if one not in ("OLS", "GLS")]
    if unknown or not optima:
        raise InputError(f"optimum '{unknown[0] if unknown else ''}': give 'OLS', 'GLS' or both")


def _series(residuals: Mapping[str, np.ndarray], n_parameters: Mapping[str, int], period: float) -> np.ndarray:
    """Return the residuals as one array, shape (model, sample), or say what is wrong with them."""
    if len(residuals) < 2:
        raise InputError(f"a comparison needs two models; residuals were given for {len(residuals)}")
    if set(residuals) != set(n_parameters):
        raise InputError(f"residuals are of {', '.join(residuals)}; n_parameters of {', '.join(n_parameters)}")
    if not (np.isfinite(period) and period > 0):
        raise InputError(f"period {period:g} s is not a positive number")
    first = next(iter(residuals))
    for key, r in residuals.items():
        if r.ndim != 1 or r.shape != residuals[first].shape or len(r) < _FEWEST:
            raise InputError(f"residuals of '{key}' have shape {r.shape}, of '{first}' {residuals[first].shape}")
        if not np.all(np.isfinite(r)) or not np.any(r):
            raise InputError(f"residuals of '{key}' are all zero or not finite; a covariance cannot be estimated")
    return np.stack(list(residuals.values()))
