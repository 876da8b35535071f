"""What is known of one quantity in every animal: from the posteriors where all animals have one, else from the fits."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr

from vasowave.base.descriptions import NORMAL
from vasowave.pulse.inference.known_errors import SHARED_SOURCES
from vasowave.pulse.quantities import RECORDED
from vasowave.study.animal.law_result import PosteriorResult
from vasowave.study.animal.result import AnimalResult

MAX_STANDARD_ERROR = 1.0
"""Standard error of a logarithm above which an estimate tells nothing: its interval of 95 % spans a factor of 50."""


class Estimates(NamedTuple):
    """Logarithms of one quantity and how well they are known."""

    logs: np.ndarray
    """NaN where a value is not positive. Shape (animal,)."""
    errors: np.ndarray
    """Standard errors that belong to one animal alone; 0 in all where they are not known of all. Shape (animal,)."""
    shared: np.ndarray
    """Standard errors from an image, a probe or a calibration (`SHARED_SOURCES`) that several of the animals share:
    they have the same sign in all of them, and no number of animals averages them away. Shape (source, animal)."""
    label: np.ndarray
    """Numbers of what each animal shares; animals of one image have the same in the first row. Int, shape (source,
    animal)."""
    origin: str
    """``posterior``, ``fit``, or ``plain`` without errors."""
    image_error_known: bool
    """Whether the error of the image is part of the errors."""
    per_radius: np.ndarray
    """Change of the logarithm per change of the logarithm of all radii; 0 where nothing tells it. Shape (animal,)."""
    lung_sd: float = 0.0
    """How much the lungs of one group differ, as far as `shared` allows for it; see `of_lungs`."""

    def of_lungs(self, sd: float) -> "Estimates":
        """Return the same estimates where the lung of a shared image differs by `sd` from those of its animals.

        The SD is that of the logarithm of all radii between lungs. It moves all animals of the image alike; that of an
        animal with an image of its own lung is a part of what animals differ.
        """
        several = np.bincount(self.label[0])[self.label[0]] > 1
        added_variance = np.where(several, (sd**2 - self.lung_sd**2) * self.per_radius**2, 0.0)
        image = np.sqrt(np.maximum(self.shared[0] ** 2 + added_variance, 0.0))
        return self._replace(shared=np.vstack([image, self.shared[1:]]), lung_sd=sd)

    def alike_within(self, cell: Sequence[str]) -> "Estimates":
        """Return the same estimates with the `typical_errors` of the cell (group, occasion) of each animal."""
        return self._replace(errors=typical_errors(self.errors, cell))

    def selected(self, selection: np.ndarray | slice) -> "Estimates":
        """Return the estimates of some animals."""
        shared, label = self.shared[:, selection], self.label[:, selection]
        logs, errors, slopes = self.logs[selection], self.errors[selection], self.per_radius[selection]
        return self._replace(logs=logs, errors=errors, shared=shared, label=label, per_radius=slopes)

    def by_animal(self, names: Sequence[str]) -> "Estimates":
        """Return one estimate for each animal, the mean of its recordings, from whose each recording is."""
        animal = np.unique(names, return_inverse=True)[1]
        first = np.unique(animal, return_index=True)[1]
        count = np.bincount(animal)
        errors = np.sqrt(np.bincount(animal, self.errors**2)) / count  # those of each recording alone
        shared = np.array([np.bincount(animal, row) / count for row in self.shared])
        logs = np.bincount(animal, self.logs) / count
        slope = np.bincount(animal, self.per_radius) / count
        return self._replace(logs=logs, errors=errors, shared=shared, label=self.label[:, first], per_radius=slope)

    @property
    def covariance(self) -> np.ndarray:
        """Of the errors of all animals, shape (animal, animal)."""
        common = sum(np.outer(shared_errors, shared_errors) * np.equal.outer(label, label)
                     for shared_errors, label in zip(self.shared, self.label, strict=True))  # fmt: skip
        return np.asarray(np.diag(self.errors**2) + common)


@dataclass(frozen=True, eq=False)
class Values:
    """One quantity of the animals that have it, by one source."""

    name: str
    source: str
    unit: str
    results: list[AnimalResult]
    estimates: Estimates


def estimates_of(
    results: Sequence[AnimalResult],
    source: str,
    name: str,
    shares: Mapping[str, Mapping[str, str]] | None = None,
    posteriors: bool = True,
) -> Estimates:
    """Return what is known of a quantity of a source, a wall law or ``measured``, in animals that have it.

    `shares` says by column of `SHARED_SOURCES` and animal what it shares with others of the same word. Without
    `posteriors` fits tell it even where all animals have a posterior.
    """
    label = np.array([numbered(results, column, (shares or {}).get(column, {})) for column in SHARED_SOURCES])
    drawn = [posterior for result in results if (posterior := _posterior(result, source, name)) is not None]
    if posteriors and results and len(drawn) == len(results):
        middle, spread, share = (
            np.array(numbers) for numbers in zip(*(_drawn(posterior, name) for posterior in drawn), strict=True)
        )
        slopes = np.array([_drawn_per_radius(posterior, name) for posterior in drawn])
        return _estimates((middle, spread, slopes), share.T, label, "posterior", image_error_known=True)
    values = [result.sources[source].quantities[RECORDED.get(name, name)] for result in results]
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = np.log(np.array([float(value) for value in values]))
    errors = np.array([_log_error(value) for value in values])
    slopes = np.array([float(value.attrs.get("per_radius", 0.0)) for value in values])
    if not np.all(np.isfinite(errors)):
        return _estimates(
            (logs, np.zeros(len(logs)), slopes), np.zeros(label.shape), label, "plain", image_error_known=False
        )
    share = np.array(
        [[float(value.attrs.get(f"share_{column}", 0.0)) for value in values] for column in SHARED_SOURCES]
    )
    has_shares = np.array(["share_image" in value.attrs for value in values], dtype=bool)
    image_error_known = 2 * has_shares.sum() >= len(has_shares) and bool(np.all(share[0, has_shares] > 0))
    if image_error_known and not has_shares.all():
        # An animal beside whose optimum no model runs has the errors that are usual here.
        errors[~has_shares] = np.maximum(errors[~has_shares], np.median(errors[has_shares]))
        slopes[~has_shares] = np.median(slopes[has_shares])
        share[:, ~has_shares] = np.median(share[:, has_shares], axis=1, keepdims=True)
    return _estimates((logs, errors, slopes), share, label, "fit", image_error_known)


def _estimates(
    values: tuple[np.ndarray, np.ndarray, np.ndarray],
    share: np.ndarray,
    label: np.ndarray,
    origin: str,
    image_error_known: bool,
) -> Estimates:
    """Return estimates whose errors are split into those that several animals share and each animal's own.

    `values` are the logarithms, their standard errors, and their changes with the radii.
    """
    logs, spread, slopes = values
    several = np.array([np.bincount(row)[row] > 1 for row in label])
    shared = np.where(several, spread * np.sqrt(share), 0.0)
    own_errors = np.sqrt(np.maximum(spread**2 - (shared**2).sum(axis=0), 0.0))
    return Estimates(logs, own_errors, shared, label, origin, image_error_known, slopes)


def typical_errors(errors: np.ndarray, cell: Sequence[str]) -> np.ndarray:
    """Return for every animal the median error of its cell, so that its weight does not know its value.

    An error that is constant in the quantity's unit (of a share near 0), or in that of its inverse (of a compliance),
    is large in the logarithm where the value is small, or large; weights by such errors move a mean towards the other
    animals. Errors above `MAX_STANDARD_ERROR` stay: of such an animal the data tell nothing, and it counts as little.

    Parameters
    ----------
    errors : array, shape (animal,)
        Standard errors of logarithms.
    cell : sequence of str
        Group, or group and occasion, of each.
    """
    number = np.unique(cell, return_inverse=True)[1]
    medians = np.array([np.median(errors[number == place]) for place in range(1 + number.max(initial=-1))])
    typical = medians[number] if len(number) else errors
    return np.where(errors > MAX_STANDARD_ERROR, errors, typical)


def shared_error(estimates: Estimates, in_second: np.ndarray) -> float:
    """Return the standard error of the difference of two groups, `in_second` minus the rest, from what animals share.

    An image, a probe or a calibration moves a group by the share of its animals that have it; one that both groups have
    alike cancels.
    """
    variance = 0.0
    for shared, label in zip(estimates.shared, estimates.label, strict=True):
        for number in np.unique(label):
            sharing = label == number
            weight = float(np.mean(sharing[in_second]) - np.mean(sharing[~in_second]))
            variance += weight**2 * float(np.mean(shared[sharing] ** 2))
    return float(np.sqrt(variance))


def image_unknown(estimates: Estimates, in_second: np.ndarray, source: str) -> bool:
    """Return whether images that animals share may move the difference of two groups by an error that is not known.

    A fit takes the image as exact unless its error is said. Images that animals have each for themselves are part of
    their scatter; shared ones are asked for here if they move the difference by more than as many images as there are
    animals would.
    """
    if source == "measured" or estimates.image_error_known:
        return False
    shared = 0.0
    for number in np.unique(estimates.label[0]):
        sharing = estimates.label[0] == number
        if sharing.sum() > 1:
            shared += float(np.mean(sharing[in_second]) - np.mean(sharing[~in_second])) ** 2
    return shared > 1 / in_second.sum() + 1 / (~in_second).sum()


def _posterior(result: AnimalResult, source: str, name: str) -> PosteriorResult | None:
    """Return the posterior of a wall law that knows a positive quantity, if there is one that can be trusted."""
    posterior = result.laws[source].posterior if source in result.laws else None
    if posterior is None or not posterior.trusted or name not in posterior.table["quantity"].values:
        return None
    return posterior if np.all(posterior.draws(name) > 0) else None


def _drawn(posterior: PosteriorResult, name: str) -> tuple[float, float, list[float]]:
    """Return mean and SD of the logarithm of a quantity's draws, and shares of their variance by `SHARED_SOURCES`."""
    logs, row = np.log(posterior.draws(name)), posterior.table.sel(quantity=name)
    return (
        float(logs.mean()),
        float(logs.std(ddof=1)),
        [float(row.get(f"share_{column}", 0.0)) for column in SHARED_SOURCES],
    )


def _drawn_per_radius(posterior: PosteriorResult, name: str) -> float:
    """Return the slope of the logarithms of a quantity's draws over those of the factor of all radii, 0 without it."""
    if "radius_scale" not in posterior.table["quantity"].values:
        return 0.0
    logs, radii = (np.log(posterior.draws(quantity)).ravel() for quantity in (name, "radius_scale"))
    spread = float(radii.var())
    return float(np.mean((logs - logs.mean()) * (radii - radii.mean()))) / spread if spread > 0 else 0.0


def numbered(results: Sequence[AnimalResult], column: str, words: Mapping[str, str]) -> np.ndarray:
    """Return a number for what each animal has of a column, the same for equal words.

    Without a word an image is that of equal networks, and anything else the animal's own.
    """
    keys: list[object] = []
    for result in results:
        default_key = (
            result.network.length.tobytes() + result.network.radius.tobytes() if column == "image" else (result.name,)
        )
        keys.append(words.get(result.name) or default_key)
    return np.array([keys.index(key) for key in keys], dtype=int)


def _log_error(value: xr.DataArray) -> float:
    """Return what an estimate says of its standard error, else what its interval does."""
    if "standard_error" in value.attrs:
        return float(value.attrs["standard_error"]) / float(value)
    if "interval_low" in value.attrs:
        ends = np.log([value.attrs["interval_low"], value.attrs["interval_high"]])
        return float(np.diff(ends)[0] / (2 * NORMAL))
    return np.nan
