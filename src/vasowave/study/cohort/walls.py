"""Which wall, beyond AICc: what posteriors say of two laws, and how the wall stiffens, animal by animal and pooled."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from vasowave.base.descriptions import CLEAR_EVIDENCE_RATIO, NORMAL, TAILS
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.estimates import Estimates, estimates_of
from vasowave.study.cohort.pooling import Interval, LogEstimate, pooled_mean
from vasowave.study.cohort.votes import enough

_GRID_MEANS, _GRID_SPREADS = 801, 41  # of the grid on which the likelihood is maximized
_GRID_REACH = 8.0  # of the grid beyond the outermost values, in scales of the animals and their errors


UNTRUSTED, UNUSABLE = "a posterior that cannot be trusted", "a fit that must not be used"
"""Why animals are not weighed."""


class Evidence(NamedTuple):
    """One wall law against another by the evidences of both."""

    wall: str
    ratios: dict[str, float]
    """By animal: how many times as likely its recording is under the reference law as under `wall`, all that is unknown
    integrated out."""
    left_out: dict[str, str]
    """Animals that are not among the ratios: `UNTRUSTED` or `UNUSABLE`."""

    @property
    def clear(self) -> tuple[int, int]:
        """Number of animals for which the reference is clearly likelier, and for which `wall` is."""
        values = np.array(list(self.ratios.values()))
        return int((values >= CLEAR_EVIDENCE_RATIO).sum()), int((values <= 1 / CLEAR_EVIDENCE_RATIO).sum())

    @property
    def enough(self) -> bool:
        """Whether the animals that are left may speak for all."""
        return enough(len(self.ratios), self.unusable)

    @property
    def unusable(self) -> int:
        """How many are left out for a fit that must not be used."""
        return [*self.left_out.values()].count(UNUSABLE)

    @property
    def side(self) -> int:
        """1 where the animals together speak for the reference, -1 for `wall`, 0 for neither or where too few are left.

        They do where some animal does clearly, none clearly against it, and the product of all ratios is clear. Small
        ratios of many animals alone decide nothing: an image that the animals share moves all of them alike.
        """
        if not self.enough:
            return 0
        together = float(np.sum(np.log(list(self.ratios.values()))))
        sign = 0 if abs(together) < np.log(CLEAR_EVIDENCE_RATIO) else int(np.sign(together))
        favorable, contrary = self.clear[::sign] if sign else (0, 0)
        return sign if favorable and not contrary else 0


def evidences(cohort: Cohort, reference: str) -> list[Evidence]:
    """Return what the stored comparisons of posteriors say of `reference` against each other law; none without them."""
    evidence_by_wall: dict[str, Evidence] = {}
    for result in cohort.results:
        if result.evidence is None:
            continue
        logs = result.evidence["log_evidence"].to_series()
        if reference not in logs:
            continue
        posteriors = {wall: result.laws[wall].posterior for wall in logs.index}
        trusted = {wall: posterior is not None and posterior.trusted for wall, posterior in posteriors.items()}
        for wall in (law for law in logs.index if law != reference):
            evidence = evidence_by_wall.setdefault(wall, Evidence(wall, {}, {}))
            if {wall, reference} & cohort.unusable[result.name]:
                evidence.left_out[result.name] = UNUSABLE
            elif trusted[wall] and trusted[reference]:
                evidence.ratios[result.name] = float(np.exp(np.clip(logs[reference] - logs[wall], -700, 700)))
            else:
                evidence.left_out[result.name] = UNTRUSTED
    return list(evidence_by_wall.values())


def pooled_censored(values: np.ndarray, errors: np.ndarray, beyond: np.ndarray) -> Interval:
    """Return the mean of animals that differ, are each known with an error, and lie in part beyond a bound.

    An animal whose search stopped at a bound says that its estimate lies beyond, so it adds the probability of that to
    the likelihood (Tobin 1958); leaving it out would choose animals by their outcome. Mean and variance of the
    animals, normal, maximize the likelihood. The interval holds the means whose profile likelihood is not below the
    best by more than it is at the ends of Student's interval, so that without bounds and errors it is Student's; the
    animals inside their bounds are counted for its degrees of freedom.

    Parameters
    ----------
    values, errors : array, shape (animal,)
        Estimates and their standard errors, for instance of logarithms; at a bound the bound.
    beyond : array of int, shape (animal,)
        -1 where the estimate lies at or below its value, 1 where at or above, 0 where it is the value.

    Returns
    -------
    Interval
        NaN and an endless interval where fewer than two animals lie inside their bounds.
    """
    from scipy.special import stdtrit

    inside = int(np.sum(beyond == 0))
    if inside < 2:
        return Interval(np.nan, -np.inf, np.inf)
    center = values[beyond == 0]
    scale = max(float(np.ptp(values)), float(np.median(errors)), 1e-9 * float(np.abs(values).max()) + 1e-12)
    means = np.linspace(values.min() - _GRID_REACH * scale, values.max() + _GRID_REACH * scale, _GRID_MEANS)
    means = np.sort(np.append(means, np.linspace(center.min() - scale, center.max() + scale, _GRID_MEANS)))
    spreads = np.append(1e-6 * scale, np.geomspace(1e-3, 10.0, _GRID_SPREADS) * scale)
    profile = _likelihood(values, errors, beyond, means, spreads).max(axis=1)
    deviance = 2 * (profile.max() - profile)
    t = float(stdtrit(inside - 1, TAILS[-1]))
    within = np.flatnonzero(deviance <= inside * np.log1p(t**2 / (inside - 1)))
    first, last = int(within[0]), int(within[-1])
    limit = inside * np.log1p(t**2 / (inside - 1))
    low = -np.inf if first == 0 else _crossing(means, deviance, first - 1, limit)
    high = np.inf if last == len(means) - 1 else _crossing(means, deviance, last, limit)
    return Interval(float(means[profile.argmax()]), low, high)


def _likelihood(
    values: np.ndarray, errors: np.ndarray, beyond: np.ndarray, means: np.ndarray, spreads: np.ndarray
) -> np.ndarray:
    """Return the log-likelihood, shape (mean, spread)."""
    from scipy.special import log_ndtr

    total = np.zeros((len(means), len(spreads)))
    for value, error, side in zip(values, errors, beyond, strict=True):
        sd = np.hypot(spreads, error)
        z = (value - means[:, np.newaxis]) / sd
        total += log_ndtr(-side * z) if side else -0.5 * z**2 - np.log(sd)
    return total


def _crossing(means: np.ndarray, deviance: np.ndarray, before: int, limit: float) -> float:
    """Return where the deviance passes its limit between a point of the grid and the next."""
    ends = slice(before, before + 2)
    order = np.argsort(deviance[ends])
    return float(np.interp(limit, deviance[ends][order], means[ends][order]))


class Exponent(NamedTuple):
    """A law's exponent with its 95 % interval, over the animals that were fitted with it."""

    name: str
    """Of the parameter."""
    linear: float
    """At which the law is the linear one."""
    value: float
    low: float
    high: float
    """NaN, 0 and infinite where the animals do not tell."""
    animals: int
    below: int
    above: int
    """Those fitted, and of them those whose search stopped at the lower and at the upper bound."""
    drawn: bool
    """Whether it comes from posteriors."""
    left_out: int = 0
    """Animals whose fit must not be used."""

    @property
    def side(self) -> int:
        """1 where the wall stiffens more than a linear one, -1 where less, 0 where that is open or animals too few."""
        return enough(self.animals, self.left_out) * (int(self.low > self.linear) - int(self.high < self.linear))


def exponent_of(cohort: Cohort, wall: str) -> Exponent | None:
    """Return the exponent of a law; None if it has none, or no fit with it may be used.

    Of several animals it is pooled on logarithms: from their posteriors, where all have one that can be trusted, else
    from their fits (`pooled_censored`). An animal whose search stopped at a bound counts as one that lies beyond it. Of
    several recordings of one animal the first counts.
    """
    firsts = {cohort.subjects[result.name]: result for result in reversed(cohort.calibrated(wall))}
    forbidden = {result.name for result in cohort.forbidden(wall)}
    stiffenings = [
        (result, stiffens)
        for result in reversed(firsts.values())
        if (stiffens := result.laws[wall].stiffening) is not None and result.name not in forbidden
    ]
    if not stiffenings:
        return None
    left_out = sum(result.name in forbidden for result in firsts.values())
    results, exponents = [result for result, _ in stiffenings], [stiffens["exponent"] for _, stiffens in stiffenings]
    name, linear = str(exponents[0].attrs["parameter"]), float(exponents[0].attrs["linear_at"])
    drawn = estimates_of(results, wall, name)
    beyond = np.array([_beyond(result, wall, exponent) for result, exponent in zip(results, exponents, strict=True)])
    if drawn.origin == "posterior":
        pooled, beyond = _of_posteriors(drawn), np.zeros(len(exponents), dtype=int)
    else:
        pooled = _of_fits(results, wall, exponents, beyond)
    below, above = int((beyond < 0).sum()), int((beyond > 0).sum())
    value, low, high = np.exp(pooled).tolist()
    return Exponent(name, linear, value, low, high, len(exponents), below, above, drawn.origin == "posterior", left_out)


def _of_fits(results: list[AnimalResult], wall: str, exponents: list[xr.DataArray], beyond: np.ndarray) -> Interval:
    logs = np.log([float(exponent) for exponent in exponents])
    if len(exponents) > 1:
        rows = [result.laws[wall].calibration.sel(parameter=exponents[0].attrs["parameter"]) for result in results]
        errors = [float(row["standard_error_correlated"] / row["value"]) for row in rows]
        return pooled_censored(logs, np.array(errors), beyond)
    low, high = np.log([float(exponents[0].attrs[f"interval_{end}"]) for end in ("low", "high")])
    return Interval(np.nan, -np.inf, np.inf) if beyond[0] else Interval(logs[0], low, high)


def _of_posteriors(drawn: Estimates) -> Interval:
    """Pool the draws' means; what animals share by one image or probe does not become less with their number."""
    if len(drawn.logs) == 1:
        reach = NORMAL * float(np.hypot(drawn.errors[0], np.linalg.norm(drawn.shared[:, 0])))
        return Interval(drawn.logs[0], drawn.logs[0] - reach, drawn.logs[0] + reach)
    mean = pooled_mean(drawn.logs, drawn.errors)
    common = sum(
        float(np.mean(mask) ** 2 * np.mean(errors[mask] ** 2))
        for errors, labels in zip(drawn.shared, drawn.label, strict=True)
        for mask in (labels == number for number in np.unique(labels))
    )
    return LogEstimate(mean.value, float(np.sqrt(mean.error**2 + common)), mean.freedom).interval(TAILS[-1])


def _beyond(result: AnimalResult, wall: str, exponent: xr.DataArray) -> int:
    """Return -1 or 1 for a search that stopped at its lower or upper bound, else 0."""
    if not int(exponent.attrs["at_bound"]):
        return 0
    bounds = result.laws[wall].calibration.sel(parameter=exponent.attrs["parameter"])
    lower, upper = float(bounds["lower"]), float(bounds["upper"])
    return -1 if float(exponent) ** 2 < lower * upper else 1
