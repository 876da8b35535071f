"""From explored points to the posterior as a value: equally weighted draws, table, shares, findings.

How well each part of the measured pressure is foretold by the rest is told by blocks of harmonics left out one by one.
The posterior without a block is not computed again: the draws are weighted by what the block had added to their
likelihood (Vehtari, Gelman & Gabry, Stat. Comput. 27 (2017), 1413), and Pareto k says where that cannot be trusted,
because the block decides by itself where the posterior lies.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr
from scipy.special import logsumexp

from vasowave.base.descriptions import TAILS
from vasowave.pulse.inference.diagnostics import FitOptimum, findings
from vasowave.pulse.inference.discrepancy import Discrepancy, Drawn
from vasowave.pulse.inference.known_errors import SOURCES
from vasowave.pulse.inference.mixture import Explored
from vasowave.pulse.inference.problem import Problem
from vasowave.pulse.inference.result import Diagnostics, Posterior
from vasowave.pulse.inference.reweighting import smoothed
from vasowave.pulse.inference.starts import Screened
from vasowave.pulse.inference.wording import meanings, trust, zero_unseen
from vasowave.pulse.model.names import joined
from vasowave.pulse.quantities import OF_PARAMETERS, QUANTITIES

_MIN_PRIOR_VARIANCE = 1e-24  # variance before of a quantity that held parameters leave no freedom: rounding
_FURTHER_QUANTITIES = ("tau", "I_R", "mPAP", "CO", "PVR")
"""Quantities of a posterior beside those of the parameters alone."""
_STEP_SD = 1e-3  # of the central differences, in SD of the prior
_MIN_TERM_SHARE = 1e-3  # of the largest term of a sum that stands for the likelihood of blocks: 0.01 nats
_DRAWS_PER_NARROWING = 10  # of which one says what those terms are
_BLOCK_HARMONICS = (0, 1, 2, 3, 5, 9, 17)
"""First harmonic of each block: the mean, the first two, then octaves."""


def reported(
    problem: Problem,
    noise: Discrepancy,
    explored: Explored,
    looked: Sequence[Screened],
    simulations: int,
    rng: np.random.Generator,
    optimum: FitOptimum | None = None,
) -> Posterior:
    """Return the posterior that explored points are; `optimum` is that of a fit, if there is one.

    Draws of the prior, beside those of the posterior, are the points that the search `looked` at.
    """
    rows = _resampled(explored.weights.log_weight, rng)
    points, residuals = explored.points[rows], explored.residuals[rows]
    behind = noise.drawn(residuals, problem.zero, rng)
    values = _values(problem, points, problem.measured - residuals + behind.vessels, behind.zero, behind.errors)
    values["discrepancy"] = behind.deviation
    first, outputs = (np.concatenate(arrays) for arrays in zip(*looked, strict=True))
    errors = rng.standard_normal((len(first), noise.vessels.shape[1]))
    before = _values(problem, first, outputs + errors @ noise.vessels.T, rng.standard_normal(len(first)), errors)
    median, spread = noise.amplitude
    before["discrepancy"] = median * np.exp(spread * rng.standard_normal(len(first)))
    diagnostics = Diagnostics(
        explored.weights.k_hat, explored.effective,
        float(np.sqrt(np.nanmean(explored.missed**2))), explored.log_error, explored.log_evidence,
        explored.log_evidence_error, simulations, explored.rounds, problem.samples // 2, len(explored.points),
        explored.weights.effective / len(explored.points), len(explored.shares), explored.halves_distance,
    )  # fmt: skip
    notes = tuple(findings(
        explored.halves_distance, explored.effective, explored.shares, optimum, explored.best_log_likelihood, values
    ))  # fmt: skip
    units = _units(problem)
    summary = _summary(values, before, units).join(_shares(problem, noise, explored, rows))
    scores = pd.Series(np.median(explored.points[rows], axis=0), index=list(problem.unknowns.all))
    meaning = meanings(summary, scores, problem.unknowns.all)
    notes = (*trust(diagnostics), *notes, *meaning, *zero_unseen(problem.recording, problem.unknowns.priors.sd("zero")))
    wall = problem.unknowns.space.law.law().name
    tree = _tree(problem, noise, explored, rows, behind, _labelled(values, units), _labelled(before, units))
    blocks = left_out(noise, explored.residuals, explored.weights.log_weight)
    return Posterior(wall, tree, summary, diagnostics, blocks, notes)


def _resampled(log_weight: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return rows of equally weighted draws, in random order: each is taken as often as its weight says."""
    count = len(log_weight)
    places = (np.arange(count) + rng.random()) / count
    rows = np.searchsorted(np.cumsum(np.exp(log_weight)), places * (1 - 1e-12))
    return rng.permutation(np.minimum(rows, len(log_weight) - 1))


def _values(
    problem: Problem, points: np.ndarray, outputs: np.ndarray, zeros: np.ndarray, errors: np.ndarray
) -> dict[str, np.ndarray]:
    """Return unknowns and derived quantities at points with their outputs, zeros and errors of single vessels."""
    unknowns = problem.unknowns
    values = {name: value for name, value in unknowns.values(points).items() if name in unknowns.all}
    return joined(values, problem.quantities(points, outputs, zeros, errors))


def _units(problem: Problem) -> dict[str, tuple[str, str]]:
    """Return unit and meaning of every variable."""
    units = {name: (unknown.unit, unknown.meaning) for name, unknown in problem.unknowns.all.items()}
    derived = {
        name: (QUANTITIES[name].unit, QUANTITIES[name].meaning) for name in (*OF_PARAMETERS, *_FURTHER_QUANTITIES)
    }
    deviation = {"discrepancy": ("mmHg", "standard deviation of what no parameters of the model explain")}
    return joined(units, derived, deviation)


def _summary(
    values: dict[str, np.ndarray], before: dict[str, np.ndarray], units: dict[str, tuple[str, str]]
) -> pd.DataFrame:
    rows = {}
    for name, draws in values.items():
        # the k-th of n draws stands for the share k/(n + 1): else 100 draws leave 7 % outside, not 5
        low, middle, high = np.quantile(draws, TAILS, method="weibull")
        prior = before[name][np.isfinite(before[name])]
        first, _, last = np.quantile(prior, TAILS)
        scale = np.log if draws.min() > 0 and prior.min() > 0 else np.asarray
        prior_variance = np.var(scale(prior))
        contraction = 1 - np.var(scale(draws)) / prior_variance if prior_variance > _MIN_PRIOR_VARIANCE else np.nan
        rows[name] = (units[name][0], middle, low, high, first, last, contraction)
    columns = ["unit", "median", "interval_low", "interval_high", "prior_low", "prior_high", "contraction"]
    return pd.DataFrame.from_dict(rows, orient="index", columns=columns).rename_axis("quantity")


def _shares(problem: Problem, noise: Discrepancy, explored: Explored, rows: np.ndarray) -> pd.DataFrame:
    """Return the sources of the variance of every quantity, to first order at the middle of the posterior."""
    middle = explored.points[rows].mean(axis=0)
    steps = _STEP_SD * np.eye(len(middle))
    of_vessels = _STEP_SD * noise.vessels.T
    offsets = np.vstack([steps, np.zeros((1 + len(of_vessels), len(middle)))])  # then the zero, then vessels are moved
    zeros = _STEP_SD * np.eye(len(offsets))[len(middle)]
    moved = np.vstack([np.zeros((1 + len(middle), problem.count)), of_vessels])
    errors = _STEP_SD * np.eye(len(offsets))[:, 1 + len(middle) :]
    up, down = (
        _values(problem, points, explored.emulator(points) + side * moved, side * zeros, side * errors)
        for points, side in ((middle + offsets, 1), (middle - offsets, -1))
    )
    slopes = {}
    for name, ends in up.items():
        scale = np.log if min(ends.min(), down[name].min()) > 0 else np.asarray
        slopes[name] = (scale(ends) - scale(down[name])) / (2 * _STEP_SD)
    sources = [unknown.source for unknown in problem.unknowns.all.values()]
    frame = pd.DataFrame.from_dict(slopes, orient="index")
    return variance_shares(
        frame, sources, explored.emulator.jacobian(middle), noise, explored.residuals[rows], problem.zero
    )


def _tree(
    problem: Problem,
    noise: Discrepancy,
    explored: Explored,
    rows: np.ndarray,
    behind: Drawn,
    posterior: xr.Dataset,
    prior: xr.Dataset,
) -> xr.DataTree:
    time = np.arange(problem.samples) * (problem.recording.period / problem.samples)
    outputs, compared = problem.measured - explored.residuals[rows], problem.compared
    simulated, again, measured = (
        problem.in_time(coefficients) / compared.scale
        for coefficients in (outputs, outputs + behind.noise, problem.measured)
    )
    unit, seconds = {"units": compared.unit}, {"units": "s"}
    axis = {"time": ("time", time, seconds)}
    dims = ("chain", "draw", "time")
    predicted = xr.Dataset(
        {compared.what: (dims, again[np.newaxis], unit), "simulated": (dims, simulated[np.newaxis], unit)}, coords=axis
    )
    likelihood = noise.log_likelihood(explored.residuals[rows])[np.newaxis]
    observed = xr.Dataset({compared.what: ("time", measured, unit)}, coords=axis)
    weights = {"log_weight": (("chain", "draw"), explored.weights.log_weight[np.newaxis])}
    groups = {
        "posterior": posterior,
        "prior": prior,
        "log_likelihood": xr.Dataset({compared.what: (("chain", "draw"), likelihood)}),
        "sample_stats": xr.Dataset(weights, attrs={"note": "importance draws before resampling"}),
        "posterior_predictive": predicted,
        "observed_data": observed,
    }
    return xr.DataTree.from_dict(groups)


def _labelled(values: dict[str, np.ndarray], units: dict[str, tuple[str, str]]) -> xr.Dataset:
    variables = {
        name: (("chain", "draw"), draws[np.newaxis], {"units": units[name][0], "long_name": units[name][1]})
        for name, draws in values.items()
    }
    count = len(next(iter(values.values())))
    return xr.Dataset(variables, coords={"chain": [0], "draw": np.arange(count)})


def left_out(noise: Discrepancy, residuals: np.ndarray, log_weight: np.ndarray) -> pd.DataFrame:
    """Return the log density of each block of harmonics given all others.

    Parameters
    ----------
    noise : Discrepancy
    residuals : array, shape (draw, coefficient)
        Measured minus simulated, mmHg.
    log_weight : array, shape (draw,)
        Of the draws, as of the posterior of all harmonics.

    Returns
    -------
    DataFrame
        Indexed by ``block``, a name such as ``3-4``: ``log_density`` of the block's coefficients (mmHg, orthonormal)
        and ``k_hat``.
    """
    harmonic = noise.harmonic
    simulated = np.isfinite(residuals).all(axis=1)
    residuals, log_weight = residuals[simulated], log_weight[simulated]
    tenth = residuals[::_DRAWS_PER_NARROWING]
    full = noise.narrowed(tenth, _MIN_TERM_SHARE).log_likelihood(residuals)
    rows = {}
    for first, end in zip(_BLOCK_HARMONICS, (*_BLOCK_HARMONICS[1:], np.inf), strict=True):
        block = (harmonic >= first) & (harmonic < end)
        if block.any() and not block.all():
            remaining = noise.without(block).narrowed(tenth, _MIN_TERM_SHARE)  # a missed block hides its spectra
            added = full - remaining.log_likelihood(residuals)
            weights = smoothed(log_weight - added)
            rows[_block_name(harmonic[block])] = (float(logsumexp(weights.log_weight + added)), weights.k_hat)
    return pd.DataFrame.from_dict(rows, orient="index", columns=["log_density", "k_hat"]).rename_axis("block")


def _block_name(harmonic: np.ndarray) -> str:
    first, last = int(harmonic.min()), int(harmonic.max())
    return str(first) if first == last else f"{first}-{last}"


def variance_shares(
    slopes: pd.DataFrame, sources: list[str], jacobian: np.ndarray, noise: Discrepancy, residuals: np.ndarray,
    zero: np.ndarray | None = None,
) -> pd.DataFrame:  # fmt: skip
    """Return each source's share of the variance of each quantity, adding up to 1.

    Around the posterior's middle, where outputs are linear in the scores x with prior N(0, 1), the estimate is
    x̂ = K (data - base) with K = Σ Jᵀ V⁻¹ and Σ = (1 + Jᵀ V⁻¹ J)⁻¹. Its error x - x̂ = (1 - K J) x - K e has the
    covariance Σ, and each independent part of x and of e contributes its own term (Joseph's form).

    Parameters
    ----------
    slopes : DataFrame
        Derivative of each quantity (index) by each score (column), by the zero where it is given, and, else 0, by each
        error of a single vessel.
    sources : list of str
        Of each score: ``recording`` (a parameter, known before only by its prior), ``image``, ``probe``, ``model``.
    jacobian : array, shape (output, score)
    noise : Discrepancy
    residuals : array, shape (draw, output)
    zero : array, shape (output,), optional
        What one SD of the zero of the pressure changes, where `slopes` have a column for it: it then is an unknown
        beside the scores, and no longer one of the noise's errors of measurement.
    """
    measured = noise.measured
    if zero is not None:
        measured, jacobian = measured - np.outer(zero, zero), np.column_stack([jacobian, zero])
        sources = [*sources, "calibration"]
    jacobian = np.column_stack([jacobian, noise.vessels])
    sources = [*sources, *["image"] * noise.vessels.shape[1]]
    covariances = {"recording": measured, "model": np.diag(noise.variance(residuals))}
    gain = np.linalg.solve(sum(covariances.values()), jacobian).T
    covariance = np.linalg.inv(np.eye(len(sources)) + gain @ jacobian)
    K = covariance @ gain
    remainder = np.eye(len(sources)) - K @ jacobian
    G, table = np.zeros((len(slopes), len(sources))), {}
    G[:, : slopes.shape[1]] = slopes.to_numpy(float)
    for name in SOURCES:
        columns = np.array([("prior" if source == "recording" else source) == name for source in sources])
        variance = ((G @ remainder[:, columns]) ** 2).sum(axis=1)
        if name in covariances:
            variance = variance + np.einsum("qi,ij,qj->q", G @ K, covariances[name], G @ K)
        table[name] = variance
    frame = pd.DataFrame(table, index=slopes.index)
    return frame.div(frame.sum(axis=1), axis=0)
