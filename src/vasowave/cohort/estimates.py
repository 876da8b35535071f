"""What is known of one quantity in every animal: from the posteriors where all animals have one, else from the fits."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from vasowave.animal.law_result import PosteriorResult
from vasowave.animal.result import AnimalResult
from vasowave.descriptions import NORMAL


class Estimates(NamedTuple):
    """Logarithms of one quantity and how well they are known.

    Attributes
    ----------
    logs : array, shape (animal,)
        NaN where a value is not positive.
    errors : array, shape (animal,)
        Standard errors that belong to one animal alone; 0 in all where they are not known of all.
    shared : array, shape (animal,)
        Standard errors from an image that several of the animals share: they have the same sign in all of them, and no
        number of animals averages them away.
    image : array of int, shape (animal,)
        Number of the network of each animal; animals of one image have the same.
    origin : str
        ``posterior``, ``fit``, or ``plain`` without errors.
    """

    logs: np.ndarray
    errors: np.ndarray
    shared: np.ndarray
    image: np.ndarray
    origin: str

    def of(self, kept: np.ndarray | slice) -> "Estimates":
        """Return the estimates of some animals."""
        return Estimates(self.logs[kept], self.errors[kept], self.shared[kept], self.image[kept], self.origin)


def estimates_of(results: Sequence[AnimalResult], source: str, name: str) -> Estimates:
    """Return what is known of a quantity of a source, a wall law or ``measured``, in animals that have it."""
    image = _images(results)
    drawn = [one for result in results if (one := _posterior(result, source, name)) is not None]
    if results and len(drawn) == len(results):
        middle, spread, share = np.transpose([_drawn(one, name) for one in drawn])
        several = np.bincount(image)[image] > 1
        shared = np.where(several, spread * np.sqrt(share), 0.0)
        return Estimates(middle, np.sqrt(spread**2 - shared**2), shared, image, "posterior")
    values = [result.sources[source].quantities[name] for result in results]
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = np.log(np.array([float(value) for value in values]))
    errors = np.array([_log_error(value) for value in values])
    known = bool(np.all(np.isfinite(errors)))
    nothing = np.zeros(len(results))
    return Estimates(logs, errors if known else nothing, nothing, image, "fit" if known else "plain")


def shared_error(one: Estimates, other: np.ndarray) -> float:
    """Return the standard error of the difference of two groups, `other` minus the rest, from images that they share.

    An image moves a group by the share of its animals that have it; one that both groups have alike cancels.
    """
    variance = 0.0
    for number in np.unique(one.image):
        own = one.image == number
        weight = float(np.mean(own[other]) - np.mean(own[~other]))
        variance += weight**2 * float(np.mean(one.shared[own] ** 2))
    return float(np.sqrt(variance))


def image_unknown(one: Estimates, other: np.ndarray, source: str) -> bool:
    """Return whether images that animals share may move the difference of two groups by an error that is not known.

    A fit takes the image as exact. Images that animals have each for themselves are part of their scatter; shared ones
    are asked for here if they move the difference by more than as many images as there are animals would.
    """
    if source == "measured" or one.origin == "posterior":
        return False
    shared = 0.0
    for number in np.unique(one.image):
        own = one.image == number
        if own.sum() > 1:
            shared += float(np.mean(own[other]) - np.mean(own[~other])) ** 2
    return shared > 1 / other.sum() + 1 / (~other).sum()


def _posterior(result: AnimalResult, source: str, name: str) -> PosteriorResult | None:
    """Return the posterior that knows a positive quantity, if there is one that can be trusted."""
    one = result.laws[source].posterior if source in result.laws else None
    if one is None or not one.trusted or name not in one.table["quantity"].values:
        return None
    return one if np.all(one.draws(name) > 0) else None


def _drawn(posterior: PosteriorResult, name: str) -> tuple[float, float, float]:
    """Return mean and SD of the logarithm of a quantity's draws, and the image's share of their variance."""
    logs = np.log(posterior.draws(name))
    share = float(posterior.table["share_image"].sel(quantity=name))
    return float(logs.mean()), float(logs.std(ddof=1)), share


def _images(results: Sequence[AnimalResult]) -> np.ndarray:
    """Return a number for each network, the same for equal lengths and radii."""
    keys = [result.network.length.tobytes() + result.network.radius.tobytes() for result in results]
    return np.array([keys.index(key) for key in keys], dtype=int)


def _log_error(value: xr.DataArray) -> float:
    """Return what an estimate says of its standard error, else what its interval does."""
    if "standard_error" in value.attrs:
        return float(value.attrs["standard_error"]) / float(value)
    if "interval_low" in value.attrs:
        ends = np.log([value.attrs["interval_low"], value.attrs["interval_high"]])
        return float(np.diff(ends)[0] / (2 * NORMAL))
    return np.nan
