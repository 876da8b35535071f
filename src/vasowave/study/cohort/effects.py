"""Effects as values: a ratio with its interval, the contrast that it is of, its test; and tables of them."""

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from operator import attrgetter
from typing import ClassVar, NamedTuple, TypeVar

import numpy as np
import pandas as pd

from vasowave.pulse.quantities import question_of

Item = TypeVar("Item")
Key = TypeVar("Key", bound=Hashable)
Columns = tuple[str, ...]
_SIDES, _RATIO = ("reference", "other"), ("quantity", "source", "ratio", "low", "high")


class Untested(StrEnum):
    """Why an effect has no p."""

    NO = ""
    ONE_IMAGE = "one image"
    """Animals of a group have one image, and nothing tells how far its error moves this quantity: fits take the image
    as exact. With posteriors the error is known, and the effect has a p."""


class ContrastLabel(NamedTuple):
    """What is compared with what.

    Attributes
    ----------
    group, reference : str
        The sides: groups, or levels of a second factor; of a contrast that a study names its name alone.
    kind : {"groups", "factor", "interaction", "change", "trend", "contrast"}
    change : str
        Of a group's change, and of an interaction, whose sides are such changes: of what.
    within : str
        Where it is compared, if that is not everywhere: ``at time before``, ``in HPH``.
    """

    group: str
    reference: str
    kind: str = "groups"
    change: str = ""
    within: str = ""

    def __str__(self) -> str:
        """Return the contrast as a table names it: ``HPH / CTL``."""
        sides = " / ".join(filter(None, (self.group, self.reference)))
        text = f"{sides} {self.within}" if self.within else sides
        return f"{self.change}: {text}" if self.change else text

    def describe(self, side_kind: str) -> str:
        """Return the same in words, with what an interaction's sides are: a change within animals, or a ratio."""
        change = f"in the {side_kind} {self.change}" if self.change else ""
        pair = f"{self.group} against {self.reference}" if self.reference else self.group
        return " ".join(filter(None, (pair, change, self.within)))


@dataclass(frozen=True)
class Omission:
    """A quantity, in a group, or an animal that a comparison leaves out, and why."""

    reason: str
    quantity: str = ""
    group: str = ""
    animal: str = ""

    def describe(self, called: Callable[[str], str] = str) -> str:
        """Return what is left out, the quantity as it is `called`: ``mPAP (HPH)``."""
        return self.animal or called(self.quantity) + (f" ({self.group})" if self.group else "")


@dataclass(frozen=True, kw_only=True)
class RatioEstimate:
    """A ratio of one quantity by one source, with the ends of its 95 % interval; `columns` are those of its table."""

    columns: ClassVar[Columns]

    quantity: str
    source: str
    ratio: float
    low: float
    high: float


@dataclass(frozen=True, kw_only=True)
class CovariateEffect(RatioEstimate):
    """What a covariate of a design does to a quantity; its interval holds by itself.

    Of categories each level over the first, of numbers and dates the ratio for one standard deviation.
    """

    columns: ClassVar[Columns] = ("quantity", "source", "covariate", "ratio", "low", "high")

    covariate: str


@dataclass(frozen=True, kw_only=True)
class ContrastEstimate(RatioEstimate):
    """A contrast without a test, as the secondary laws give it."""

    columns: ClassVar[Columns] = (*_SIDES, *_RATIO)

    contrast: ContrastLabel


@dataclass(frozen=True, kw_only=True)
class DesignEstimate(ContrastEstimate):
    """The same of a design."""

    columns: ClassVar[Columns] = (*_SIDES, "change", "within", *_RATIO)


@dataclass(frozen=True, kw_only=True)
class Effect(ContrastEstimate):
    """One effect of the primary comparison.

    Intervals and p hold for all tested effects at once, by one reference distribution (`simultaneous`): an interval
    excludes 1 exactly if p < 0.05.

    Attributes
    ----------
    n_reference, n_group : int
        Animals of both sides.
    mean_reference, mean_group : float
        Pooled geometric means in `unit`, whose ratio is `ratio`; of ratios of ratios the ratios.
    standard_error, freedom : float
        Of the ratio's logarithm, and the degrees of freedom of that.
    p : float
        NaN where `untested` says why; such an effect is outside the family, and its interval holds in 95 % by itself,
        without what `untested` names.
    origin : {"posterior", "fit", "plain"}
        What the animals' values and errors are of: their posteriors where all have one that can be trusted, their fits,
        or values without errors.
    without, ratio_without : str, float
        The animal that moves the ratio most when it is left out (empty for fewer than three), and the ratio then.
    smallest_p : float
        The smallest that a test by ranks or relabelings alone could give, without any assumption about distributions;
        NaN of a design.
    apart : bool
        Whether no animal of one group lies among the other; not of a design.
    """

    n_reference: int
    n_group: int
    mean_reference: float
    mean_group: float
    unit: str
    standard_error: float
    freedom: float
    p: float
    untested: Untested = Untested.NO
    origin: str
    without: str
    ratio_without: float
    smallest_p: float = np.nan
    apart: bool = False

    @property
    def p_alone(self) -> float:
        """The p of this effect by itself, as if nothing else had been tested (Student's t, both sides)."""
        from scipy.special import stdtr

        return float(2 * stdtr(self.freedom, -abs(np.log(self.ratio)) / self.standard_error))

    @property
    def question(self) -> str:
        """The question that the quantity answers."""
        return question_of(self.quantity)


@dataclass(frozen=True, kw_only=True)
class GroupEffect(Effect):
    """An effect between two groups of independent animals.

    Attributes
    ----------
    tipping_radius : float
        By what share the images of the groups must be wrong against each other for the interval to hold 1; see
        `lungs.tipping_radius`.
    tipping_lung_sd : float
        How much lungs of one group may differ for the interval still to exclude 1; see `GroupContrast.tipping_lung_sd`.
    fits_ratio, fits_low, fits_high : float
        What the fits say of an effect by posteriors, without limits where they take the image as exact; else NaN.
    """

    columns: ClassVar[Columns] = (
        "reference", "other", "question", "quantity", "source", "n reference", "n other", "mean reference",
        "mean other", "unit", "ratio", "low", "high", "standard error", "df", "p", "untested", "smallest p", "apart",
        "estimates", "tipping radius", "tipping lung sd", "fits ratio", "fits low", "fits high", "without",
        "ratio without",
    )  # fmt: skip

    tipping_radius: float = np.nan
    tipping_lung_sd: float = np.nan
    fits_ratio: float = np.nan
    fits_low: float = np.nan
    fits_high: float = np.nan


@dataclass(frozen=True, kw_only=True)
class DesignEffect(Effect):
    """An effect by the mixed model of a design; `n_both` animals stand on both of its sides."""

    columns: ClassVar[Columns] = (
        "reference", "other", "question", "quantity", "source", "n reference", "n other", "n both", "mean reference",
        "mean other", "unit", "ratio", "low", "high", "standard error", "df", "p", "untested", "smallest p", "apart",
        "estimates", "what", "change", "within", "without", "ratio without",
    )  # fmt: skip

    n_both: int = 0


_ATTRIBUTES = {
    "reference": "contrast.reference", "other": "contrast.group", "what": "contrast.kind", "change": "contrast.change",
    "within": "contrast.within", "n other": "n_group", "mean other": "mean_group", "df": "freedom",
    "untested": "untested.value", "estimates": "origin",
}  # fmt: skip
"""Attributes of columns; of others the column with underscores."""


def as_table(estimates: Sequence[RatioEstimate]) -> pd.DataFrame:
    """Return estimates of one class as a table with the `columns` of that class; without any an empty table."""
    columns = estimates[0].columns if estimates else ()
    attributes = {column: _ATTRIBUTES.get(column, column.replace(" ", "_")) for column in columns}
    return pd.DataFrame(
        {column: [attrgetter(path)(estimate) for estimate in estimates] for column, path in attributes.items()}
    )


def grouped(items: Iterable[Item], key: Callable[[Item], Key]) -> dict[Key, list[Item]]:
    """Return items by a key, in the order in which keys come first."""
    groups: dict[Key, list[Item]] = {}
    for item in items:
        groups.setdefault(key(item), []).append(item)
    return groups
