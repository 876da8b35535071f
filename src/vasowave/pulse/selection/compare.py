"""Which wall law the residuals prefer, by AICc and BIC under every noise model: the paper's table AICcBIC."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from vasowave.base.errors import InputError
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.cycle.cycle import resample
from vasowave.pulse.noise.fitting import NOISE, fit_noise
from vasowave.pulse.selection.criteria import dataset, noise_bic, preferred, scored

_FEWEST = 16  # samples of a residual from which a covariance can be estimated


class Comparing(NamedTuple):
    """How wall laws are compared.

    Attributes
    ----------
    covariances : tuple of str
        Noise models, of `noise.OF_PAPER`; each has one covariance for all wall laws, by their joint likelihood.
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
    largest_weight: float = 0.1
    starts: int = 4
    seed: int = 0


def compare_models(
    fits: Sequence[CalibratedModel],
    how: Comparing | None = None,
    *,
    samples: int | None = 512,
    progress: Callable[[int, int, str], None] | None = None,
) -> xr.Dataset:
    """AICc and BIC of the wall laws of one animal under every noise model (eqs. 21 to 23; the paper's table AICcBIC).

    Parameters
    ----------
    fits : sequence of CalibratedModel
        Of one recording, one for each wall law.
    how : Comparing, optional
        Noise models, regularization, seed.
    samples : int, optional
        N is at most this (the paper's 512); longer residuals are resampled in Fourier space. A fit that compared the
        harmonics with signal has fewer. None: as fitted.
    progress : callable, optional
        Called with finished rows, all rows and what was just done.

    Returns
    -------
    Dataset
        As from `compare_residuals`.

    Raises
    ------
    InputError
        Fewer than two fits, of different recordings or the same wall law; unknown names.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, recording, search = vw.control_network(), vw.virtual_mouse(), vw.Search(starts=1)
    >>> fits = [vw.calibrate(network, recording, wall, search=search) for wall in ("linear", "tangent")]
    >>> table = vw.compare_models(fits, vw.Comparing(covariances=("circulant",)))
    >>> sorted(str(wall) for wall in table["wall"].values)
    ['linear', 'tangent']
    """
    _check_fits(fits)
    N = fits[0].N if samples is None else min(samples, fits[0].N)
    residuals = {fit.wall: resample(fit.residual, N) for fit in fits}
    counts = {fit.wall: int(fit.parameters["free"].sum()) for fit in fits}
    return compare_residuals(residuals, counts, fits[0].recording.period, how, progress=progress)


def compare_residuals(
    residuals: Mapping[str, np.ndarray],
    n_parameters: Mapping[str, int],
    period: float,
    settings: Comparing | None = None,
    *,
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
    settings : Comparing, optional
    progress : callable, optional

    Returns
    -------
    Dataset
        Dim ``candidate``: one for every covariance and wall law, the likeliest covariance first and
        in each the best wall law first, discarded ones last. Variables as described by their ``long_name``. Attributes:
        largest_condition, largest_lambda, seed, preferred_covariance (highest joint log-likelihood, penalized as
        by BIC for its hyperparameters, among those that are not discarded).

    Raises
    ------
    InputError
        Fewer than two models, residuals of different length or without variance, unknown names.
    """
    settings = settings or Comparing()
    series = _series(residuals, n_parameters, period)
    rng, blocks = np.random.default_rng(settings.seed), list[list[dict]]()
    for covariance in settings.covariances:
        noise = fit_noise(covariance, series, period, starts=settings.starts, rng=rng)
        label = {"covariance": covariance, "discarded": noise.weight > settings.largest_weight}
        blocks.append([label | row for row in scored(residuals, n_parameters, noise)])
        if progress is not None:
            progress(len(blocks), len(settings.covariances), covariance)
    blocks.sort(key=lambda rows: (rows[0]["discarded"], noise_bic(rows)))
    return dataset([row for rows in blocks for row in rows]).assign_attrs(
        largest_condition=1e4,
        largest_lambda=settings.largest_weight,
        seed=settings.seed,
        preferred_covariance=preferred(blocks),
    )


def _check_fits(fits: Sequence[CalibratedModel]) -> None:
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
