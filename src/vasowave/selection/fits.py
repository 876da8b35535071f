"""The paper's table of AICc and BIC for one animal, from its calibrated fits, at both optima."""

import json
from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
import xarray as xr

from vasowave.calibration import Fit
from vasowave.calibration.generalized import reoptimize
from vasowave.errors import InputError
from vasowave.noise.models import CirculantNoise, Noise
from vasowave.recording import resample, samples_needed
from vasowave.selection.compare import NOISE, UNDECIDED, Sharing, fit_noise, verdicts
from vasowave.selection.criteria import aicc, bic
from vasowave.selection.generalized import explained_away
from vasowave.solver.simulate import Numerics

Optima = Literal["OLS", "GLS"]

_TEXT = ("covariance", "wall", "sharing", "optimum", "AICc_verdict", "BIC_verdict", "hyperparameters")
_MEANINGS = {
    "loglik": "log-likelihood (eq. 23)",
    "D": "fitted parameters",
    "N": "pressure samples",
    "AICc": "corrected Akaike information criterion (eq. 21)",
    "BIC": "Bayesian information criterion (eq. 22)",
    "AICc_difference": "AICc minus the least of the wall laws under the same covariance",
    "BIC_difference": "BIC minus the least of the wall laws under the same covariance",
    "AICc_verdict": f"what AICc says; a difference below {UNDECIDED:g} is undecided",
    "BIC_verdict": f"what BIC says; a difference below {UNDECIDED:g} is undecided",
    "lambda": "weight of the regularization",
    "discarded": "1 where the covariance needs too large a weight of the regularization, or explains the data away",
    "covariance": "noise model",
    "wall": "wall law",
    "sharing": "one covariance of all wall laws from their joint likelihood, or the average of separate ones",
    "optimum": "parameters of ordinary (OLS) or generalized (GLS) least squares",
    "hyperparameters": "hyperparameters of the noise model, JSON",
}


def compare_fits(
    fits: Sequence[Fit],
    *,
    covariances: Sequence[str] = NOISE,
    sharings: Sequence[Sharing] = ("joint", "average"),
    optima: Sequence[Optima] = ("OLS",),
    samples: int | None = 512,
    norm: int = 2,
    largest_weight: float = 0.1,
    starts: int = 4,
    seed: int = 0,
    numerics: Numerics | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> xr.Dataset:
    """AICc and BIC of the wall laws of one animal under every noise model (eqs. 21 to 23; the paper's table AICcBIC).

    Parameters
    ----------
    fits : sequence of Fit
        Of one recording, one for each wall law.
    covariances : sequence of str
        Of `NOISE`.
    sharings : sequence of {"joint", "average"}
        How the one covariance of all wall laws is found: by their joint likelihood, or as the mean of separate ones.
    optima : sequence of {"OLS", "GLS"}
        Scores at the least-squares optimum (the paper; takes seconds), and at the generalized-least-squares optimum
        under the same covariance (simulates some tens to hundred times for every row).
    samples : int, optional
        N is at most this (the paper's 512), and at most what the harmonics in the measured cycle need: an average that
        kept 20 harmonics has 41 independent samples. Longer residuals are resampled in Fourier space. None: as fitted.
    norm : {1, 2}
        Of the condition number that λ brings below 10⁴.
    largest_weight : float
        A covariance that needs a larger λ is discarded.
    starts, seed : int
        Of the maximizations of the likelihood.
    numerics : Numerics, optional
        As given to `calibrate`, for the GLS optimum.
    progress : callable, optional
        Called with finished rows, all rows and what was just done.

    Returns
    -------
    Dataset
        Dim ``candidate``: one for every covariance, sharing, optimum and wall law, the likeliest covariance first and
        in each the best wall law first, discarded ones last. Variables as described by their ``long_name``. Attributes:
        norm, largest_condition, largest_lambda, seed, preferred_covariance (highest joint log-likelihood, penalized as
        by BIC for its hyperparameters, among those of the joint likelihood that are not discarded).

    Raises
    ------
    InputError
        Fewer than two fits, of different recordings or the same wall law; unknown names.
    """
    _check(fits, optima)
    N = fits[0].N if samples is None else min(samples, samples_needed(fits[0].recording.pressure))
    series = np.stack([resample(fit.pressure_residual, N) for fit in fits])
    if not np.all(np.any(series, axis=1)):
        raise InputError("residuals of a fit are all zero; a covariance cannot be estimated")
    rng, blocks, count = np.random.default_rng(seed), [], len(covariances) * len(sharings) * len(optima)
    for covariance in covariances:
        for sharing in sharings:
            noise = fit_noise(
                covariance, series, fits[0].recording.period, sharing=sharing, norm=norm, starts=starts, rng=rng
            )
            for optimum in optima:
                at = series if optimum == "OLS" else _refitted(fits, noise, N, numerics)
                rows = _rows(fits, at, noise)
                label = {"covariance": covariance, "sharing": sharing, "optimum": optimum}
                useless = any(explained_away(fit, residual) for fit, residual in zip(fits, at, strict=True))
                discarded = noise.weight > largest_weight or useless
                blocks.append([label | row | {"discarded": discarded} for row in rows])
                if progress is not None:
                    progress(len(blocks), count, f"{covariance}, {sharing}, {optimum}")
    blocks.sort(key=lambda rows: (rows[0]["discarded"], _noise_bic(rows)))
    return _dataset([row for rows in blocks for row in rows]).assign_attrs(
        norm=f"{norm}-norm",
        largest_condition=1e4,
        largest_lambda=largest_weight,
        seed=seed,
        preferred_covariance=_preferred(blocks),
    )


def _check(fits: Sequence[Fit], optima: Sequence[Optima]) -> None:
    walls = [fit.wall for fit in fits]
    if len(set(walls)) < 2 or len(set(walls)) != len(walls):
        raise InputError(f"a comparison needs fits of different wall laws; given: {', '.join(walls) or 'none'}")
    first = fits[0].recording
    for fit in fits[1:]:
        same = fit.recording.period == first.period and np.array_equal(fit.recording.pressure, first.pressure)
        if not same:
            raise InputError(f"the {fit.wall} wall was fitted to another recording than the {fits[0].wall} wall")
    unknown = [one for one in optima if one not in ("OLS", "GLS")]
    if unknown or not optima:
        raise InputError(f"optimum '{unknown[0] if unknown else ''}': give 'OLS', 'GLS' or both")


def _refitted(fits: Sequence[Fit], noise: Noise, N: int, numerics: Numerics | None) -> np.ndarray:
    """Return the residuals of all fits at their generalized-least-squares optima, at N samples."""

    def whiten(values: np.ndarray) -> np.ndarray:
        return noise.whiten(resample(values, N))

    return np.stack([resample(reoptimize(fit, whiten, numerics=numerics).residual, N) for fit in fits])


def _rows(fits: Sequence[Fit], series: np.ndarray, noise: Noise) -> list[dict]:
    """Return one row for every wall law, the best first."""
    N, rows = series.shape[1], {}
    for fit, residuals in zip(fits, series, strict=True):
        D, found = int(fit.parameters["free"].sum()), noise.log_likelihood(residuals)
        scores = {"AICc": aicc(found, D, N), "BIC": bic(found, D, N)}
        rows[fit.wall] = {"wall": fit.wall, "loglik": found, "D": D, "N": N, **scores}
    for criterion in ("AICc", "BIC"):
        for wall, difference, verdict in verdicts({wall: row[criterion] for wall, row in rows.items()}):
            rows[wall] |= {f"{criterion}_difference": difference, f"{criterion}_verdict": verdict}
    weight = np.nan if isinstance(noise, CirculantNoise) else noise.weight
    noted = {"lambda": weight, "hyperparameters": json.dumps(noise.hyperparameters)}
    return [row | noted for row in sorted(rows.values(), key=lambda row: row["AICc"])]


def _noise_bic(rows: list[dict]) -> float:
    """BIC of a noise model: minus twice its log-likelihood of all residuals, plus its hyperparameters' price."""
    count = len(json.loads(rows[0]["hyperparameters"])) - (2 if rows[0]["covariance"] == "ARMA" else 0)
    return sum(-2 * row["loglik"] for row in rows) + count * np.log(sum(row["N"] for row in rows))


def _preferred(blocks: list[list[dict]]) -> str:
    kept = [rows for rows in blocks if rows[0]["sharing"] == "joint" and not rows[0]["discarded"]]
    return str(kept[0][0]["covariance"]) if kept else ""


def _dataset(rows: list[dict]) -> xr.Dataset:
    variables = {}
    for name, meaning in _MEANINGS.items():
        values = np.array([row[name] for row in rows], dtype=object if name in _TEXT else float)
        attributes = {"long_name": meaning} | ({} if name in _TEXT else {"units": "1"})
        variables[name] = ("candidate", values, attributes)
    return xr.Dataset(variables)
