"""How much the lungs of one group differ: an image of one of them stands for all animals that share it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.estimates import numbered


@dataclass(frozen=True)
class LungRules:
    """What is taken of lungs that nobody has imaged.

    Attributes
    ----------
    usual_sd : float
        SD of the logarithm of all radii between lungs of one group. The unstressed main pulmonary artery of mice of
        one strain is 760 ± 60 µm wide, after hypoxia 650 ± 80 µm (SD, Vanderpool et al. 2011, PMC3253002): 8 and 12 %,
        of which 5 % are taken for the error of the measurement.
    usual_freedom : float
        Degrees of freedom that this SD counts for where several lungs of a group were imaged.
    """

    usual_sd: float = 0.09
    usual_freedom: float = 4.0


RULES = LungRules()


class LungDifferences(NamedTuple):
    """How much the lungs of one group differ."""

    sd: float
    """SD of the logarithm of all radii between lungs of one group."""
    source: Literal["usual", "lab", "imaged"]
    """Whether nobody told it, the lab did, or several lungs of a group were imaged."""
    images: Mapping[str, int]
    """How many lungs of each group were imaged."""


def lungs_of(
    groups: Mapping[str, Sequence[AnimalResult]], words: Mapping[str, str], sd: float | None = None
) -> LungDifferences:
    """Return how much the lungs of one group differ, from the radii of the roots where several were imaged.

    Parameters
    ----------
    groups : mapping of str to sequence of AnimalResult
        One result of each animal.
    words : mapping of str to str
        What the column ``image`` says of animals; see `estimates.numbered`.
    sd : float, optional
        What the lab tells.
    """
    roots = {}
    for group, results in groups.items():
        number = numbered(results, "image", words)
        firsts = [results[place].network for place in np.unique(number, return_index=True)[1]]
        roots[group] = np.log([float(network.radius[network.root]) for network in firsts])
    images = {group: len(of_group) for group, of_group in roots.items()}
    freedom = sum(max(count - 1, 0) for count in images.values())
    if sd is not None or not freedom:
        return LungDifferences(RULES.usual_sd if sd is None else sd, "usual" if sd is None else "lab", images)
    scatter = sum(float(len(logs) * logs.var()) for logs in roots.values() if len(logs))
    weight = RULES.usual_freedom
    return LungDifferences(
        float(np.sqrt((weight * RULES.usual_sd**2 + scatter) / (weight + freedom))), "imaged", images
    )


def tipping_radius(low: float, high: float, per_radius: float) -> float:
    """Return how much too wide or narrow one group's image must be against the other's for an effect to go, a share.

    A ratio whose interval excludes 1 is moved by a common factor of the radii to the power `per_radius`. NaN where the
    interval holds 1, infinite where radii do not matter.
    """
    if low <= 1 <= high:
        return np.nan
    nearer = min(abs(np.log(low)), abs(np.log(high)))
    with np.errstate(over="ignore", divide="ignore"):
        return float(np.expm1(np.float64(nearer) / abs(per_radius)))
