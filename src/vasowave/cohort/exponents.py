"""How the wall stiffens, where a law has a parameter for it: the exponent of every animal, pooled."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from vasowave.animal.result import AnimalResult
from vasowave.cohort.censored import Pooled, pooled_censored
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.estimates import Estimates, estimates_of
from vasowave.cohort.pooling import pooled_mean
from vasowave.descriptions import NORMAL, TAILS


class Exponent(NamedTuple):
    """A law's exponent with its 95 % interval, over the animals that were fitted with it.

    Attributes
    ----------
    name : str
        Of the parameter.
    linear : float
        At which the law is the linear one.
    value, low, high : float
        NaN, 0 and infinite where the animals do not tell.
    animals, below, above : int
        Those fitted, and of them those whose search stopped at the lower and at the upper bound.
    drawn : bool
        Whether it comes from posteriors.
    """

    name: str
    linear: float
    value: float
    low: float
    high: float
    animals: int
    below: int
    above: int
    drawn: bool

    @property
    def side(self) -> int:
        """1 where the wall stiffens more than a linear one, -1 where less, 0 where that is open."""
        return int(self.low > self.linear) - int(self.high < self.linear)


def exponent_of(cohort: Cohort, wall: str) -> Exponent | None:
    """Return the exponent of a law; None if it has none.

    Of several animals it is pooled on logarithms: from their posteriors, where all have one that can be trusted, else
    from their fits (`pooled_censored`). An animal whose search stopped at a bound counts as one that lies beyond it. Of
    several recordings of one animal the first counts.
    """
    firsts = {cohort.subjects[one.name]: one for one in reversed(cohort.calibrated(wall))}
    said = [(one, stiffens) for one in reversed(firsts.values()) if (stiffens := one.laws[wall].stiffening) is not None]
    if not said:
        return None
    results, each = [one for one, _ in said], [stiffens["exponent"] for _, stiffens in said]
    name, linear = str(each[0].attrs["parameter"]), float(each[0].attrs["linear_at"])
    drawn = estimates_of(results, wall, name)
    beyond = np.array([_beyond(result, wall, one) for result, one in zip(results, each, strict=True)])
    if drawn.origin == "posterior":
        pooled, beyond = _of_posteriors(drawn), np.zeros(len(each), dtype=int)
    else:
        pooled = _of_fits(results, wall, each, beyond)
    below, above = int((beyond < 0).sum()), int((beyond > 0).sum())
    value, low, high = np.exp(pooled).tolist()
    return Exponent(name, linear, value, low, high, len(each), below, above, drawn.origin == "posterior")


def _of_fits(results: list[AnimalResult], wall: str, each: list[xr.DataArray], beyond: np.ndarray) -> Pooled:
    logs = np.log([float(one) for one in each])
    if len(each) > 1:
        own = [one.laws[wall].calibration.sel(parameter=each[0].attrs["parameter"]) for one in results]
        errors = [float(one["standard_error_correlated"] / one["value"]) for one in own]
        return pooled_censored(logs, np.array(errors), beyond)
    low, high = np.log([float(each[0].attrs[f"interval_{end}"]) for end in ("low", "high")])
    return Pooled(np.nan, -np.inf, np.inf) if beyond[0] else Pooled(logs[0], low, high)


def _of_posteriors(drawn: Estimates) -> Pooled:
    """Pool the draws' means; what animals share by one image or probe does not become less with their number."""
    from scipy.special import stdtrit

    if len(drawn.logs) == 1:
        reach = NORMAL * float(np.hypot(drawn.errors[0], np.linalg.norm(drawn.shared[:, 0])))
        return Pooled(drawn.logs[0], drawn.logs[0] - reach, drawn.logs[0] + reach)
    mean = pooled_mean(drawn.logs, drawn.errors)
    common = sum(
        float(np.mean(own) ** 2 * np.mean(errors[own] ** 2))
        for errors, labels in zip(drawn.shared, drawn.label, strict=True)
        for own in (labels == number for number in np.unique(labels))
    )
    reach = float(stdtrit(mean.freedom, TAILS[-1])) * float(np.sqrt(mean.error**2 + common))
    return Pooled(mean.value, mean.value - reach, mean.value + reach)


def _beyond(result: AnimalResult, wall: str, exponent: xr.DataArray) -> int:
    """Return -1 or 1 for a search that stopped at its lower or upper bound, else 0."""
    if not int(exponent.attrs["at_bound"]):
        return 0
    bounds = result.laws[wall].calibration.sel(parameter=exponent.attrs["parameter"])
    lower, upper = float(bounds["lower"]), float(bounds["upper"])
    return -1 if float(exponent) ** 2 < lower * upper else 1
