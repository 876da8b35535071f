"""The primary comparison of groups of independent animals: pooled ratios of each group over the reference."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import comb
from typing import TypeVar

import numpy as np

from vasowave.base.descriptions import LEVEL
from vasowave.base.errors import InputError
from vasowave.base.io.columns import split_unit
from vasowave.pulse.inference.known_errors import SHARED_SOURCES
from vasowave.pulse.quantities import MEASURED
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.effects import ContrastEstimate, ContrastLabel, GroupEffect, Omission, Untested
from vasowave.study.cohort.estimates import Estimates, Values, estimates_of, image_unknown, shared_error
from vasowave.study.cohort.lungs import tipping_radius
from vasowave.study.cohort.pooling import Ratio, pooled_ratio
from vasowave.study.cohort.simultaneous_intervals import (
    NO_FAMILY,
    ComparedQuantity,
    Simultaneous,
    animal_indices,
    simultaneous,
)
from vasowave.study.cohort.table import column, rows_of

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class GroupContrast(Values):
    """One quantity that can be compared between two groups, of their animals that have it."""

    in_second: np.ndarray
    """Bool, shape (animal,)."""
    fits: Estimates | None = None
    """What the fits tell where `estimates` is of posteriors."""

    @property
    def names(self) -> list[str]:
        """Names of the animals."""
        return [result.name for result in self.results]

    @property
    def untested(self) -> Untested:
        """Why its effect has no p."""
        return Untested.ONE_IMAGE if image_unknown(self.estimates, self.in_second, self.source) else Untested.NO

    @property
    def shared(self) -> float:
        """Standard error of the difference of the groups from what animals share."""
        return shared_error(self.estimates, self.in_second)

    def ratio(self, selection: np.ndarray | slice = slice(None), level: float = LEVEL) -> Ratio:
        """Return the pooled ratio of the second group over the first, of the animals kept."""
        estimates, in_second = self.estimates.selected(selection), self.in_second[selection]
        reference = estimates.logs[~in_second], estimates.errors[~in_second]
        return pooled_ratio(
            reference,
            (estimates.logs[in_second], estimates.errors[in_second]),
            level,
            shared_error(estimates, in_second),
        )

    def tipping_lung_sd(self, critical: float) -> float:
        """Return how much the lungs of one group may differ for the interval still to exclude 1.

        SD of the logarithm of all radii. NaN where the interval holds 1 even if all lungs are alike, infinite where it
        excludes 1 though lungs differ by `_MAX_LUNG_DIFFERENCE`.
        """

        def excludes(sd: float) -> bool:
            ratio = replace(self, estimates=self.estimates.of_lungs(sd)).ratio(level=1 - critical)
            return not ratio.low <= 1 <= ratio.high

        if not excludes(0.0) or excludes(_MAX_LUNG_DIFFERENCE):
            return np.inf if excludes(0.0) else np.nan
        low, high = 0.0, _MAX_LUNG_DIFFERENCE
        while high - low > _LUNG_STEP:
            middle = (low + high) / 2
            low, high = (middle, high) if excludes(middle) else (low, middle)
        return low


_MAX_LUNG_DIFFERENCE, _LUNG_STEP = 0.5, 1e-3
"""SD of the logarithm of radii between lungs: the largest that is tried, and how exactly a tipping point is told."""


@dataclass(frozen=True)
class Assurance:
    """How far the p and intervals of the family can be relied on, from the sizes and spreads at hand."""

    rate: float
    """Estimated share of cohorts without any effect, normal on logarithms and of these sizes, spreads and correlations,
    in which a row has p < 0.05 all the same: 0.05 if the method were exact."""
    alone: float
    """Level of each interval by itself; together they hold in 95 %."""
    spread_ratio: float
    """Largest ratio, over the rows, of the SD of the two groups' logarithms."""
    smallest: int
    """Animals of the smallest group of any row."""

    @property
    def doubtful(self) -> bool:
        """Whether a study must say so: false positives, by `rate`, are more than 0.06."""
        return self.rate > _MAX_FALSE_POSITIVE_RATE


_MAX_FALSE_POSITIVE_RATE = 0.06
"""Rate of false positives up to which a p is called family-wise without a remark."""


def group_effects(
    cohort: Cohort, contrasts: Mapping[str, Sequence[GroupContrast]]
) -> tuple[list[GroupEffect], float, Assurance | None]:
    """Return the effects of every group, the p of one of them by itself that intervals belong to, and the assurance.

    `contrasts` are those of each group that can be compared with the reference.
    """
    pairs = [(group, contrast) for group, of_group in contrasts.items() for contrast in of_group]
    tested = [contrast for _, contrast in pairs if not contrast.untested]
    together = simultaneous(_compared_quantities(tested)) if tested else NO_FAMILY
    statements = together.statements([not contrast.untested for _, contrast in pairs])
    effects = [
        _effect(ContrastLabel(group, cohort.reference), contrast, statement, len(contrasts))
        for (group, contrast), statement in zip(pairs, statements, strict=True)
    ]
    return effects, together.critical, _assurance(tested, together) if tested else None


def secondary_estimates(
    cohort: Cohort, law: str, contrasts: Mapping[str, Sequence[GroupContrast]], critical: float
) -> list[ContrastEstimate]:
    """Return the effects by the other laws."""
    return [
        ContrastEstimate(
            contrast=ContrastLabel(group, cohort.reference), quantity=contrast.name, source=further,
            ratio=ratio.value, low=ratio.low, high=ratio.high,
        )
        for group, of_group in contrasts.items()
        for further in cohort.walls
        if further != law
        for contrast in usable_contrasts(
            cohort, [contrast.name for contrast in of_group if contrast.source == law], further, group
        )[0]
        for ratio in [contrast.ratio(level=LEVEL if contrast.untested else 1 - critical)]
    ]  # fmt: skip


def _effect(label: ContrastLabel, contrast: GroupContrast, statement: tuple[float, float], pairs: int) -> GroupEffect:
    """Return the effect on a quantity, with its p and the p by itself that its interval belongs to."""
    x, y = contrast.estimates.logs[~contrast.in_second], contrast.estimates.logs[contrast.in_second]
    sizes, (p, critical) = (len(x), len(y)), statement
    ratio = contrast.ratio(level=1 - critical)
    without, ratio_without = _influence(contrast, ratio)
    fits_ratio, fits_low, fits_high = _by_fits(contrast, critical)
    return GroupEffect(
        contrast=label, quantity=contrast.name, source=contrast.source, n_reference=sizes[0], n_group=sizes[1],
        mean_reference=ratio.reference, mean_group=ratio.other, unit=contrast.unit, ratio=ratio.value, low=ratio.low,
        high=ratio.high, standard_error=ratio.error, freedom=ratio.freedom, p=p, untested=contrast.untested,
        smallest_p=smallest_p(sizes, pairs), apart=bool(x.max() < y.min() or y.max() < x.min()),
        origin=contrast.estimates.origin,
        tipping_radius=tipping_radius(ratio.low, ratio.high, float(contrast.estimates.per_radius.mean())),
        tipping_lung_sd=contrast.tipping_lung_sd(critical), fits_ratio=fits_ratio, fits_low=fits_low,
        fits_high=fits_high, without=without, ratio_without=ratio_without,
    )  # fmt: skip


def _by_fits(contrast: GroupContrast, critical: float) -> tuple[float, float, float]:
    """Return the ratio by the fits, where the effect is by posteriors, with its interval of the same level."""
    if contrast.fits is None or not np.all(np.isfinite(contrast.fits.logs)):
        return np.nan, np.nan, np.nan
    fits = replace(contrast, estimates=contrast.fits)
    value, low, high, *_ = fits.ratio(level=1 - critical)
    return (value, 0.0, np.inf) if fits.untested else (value, low, high)


def usable_contrasts(
    cohort: Cohort, names: Sequence[str], law: str, group: str
) -> tuple[list[GroupContrast], list[Omission]]:
    """Return the quantities that can be compared, and the others with the reason."""
    return split_usable(names, lambda name: _contrast(cohort, source_of(name, law), name, group), group)


def split_usable(names: Sequence[str], make: Callable[[str], T], group: str = "") -> tuple[list[T], list[Omission]]:
    """Return what `make` makes of quantities, and the others with the reason."""
    made, left_out = [], []
    for name in names:
        try:
            made.append(make(name))
        except InputError as error:
            left_out.append(Omission(str(error), name, group))
    return made, left_out


def _contrast(cohort: Cohort, source: str, name: str, group: str) -> GroupContrast:
    """Return a quantity of a group and the reference; raises `InputError` if they cannot be compared by it."""
    values = known_values(cohort, source, name, (cohort.reference, group))
    if values is None:
        raise InputError("no animal has it")
    in_second = np.array([result.group == group for result in values.results], dtype=bool)
    sides = values.estimates.logs[in_second], values.estimates.logs[~in_second]
    if min(map(len, sides)) < 2:
        raise InputError("a group has fewer than two animals with it")
    if not np.all(np.isfinite(values.estimates.logs)):
        raise InputError("a value is not positive; a ratio needs positive values")
    if min(map(np.ptp, sides)) < 1e-9:
        raise InputError("the values hardly vary within a group; there is nothing to test")
    contrast = GroupContrast(**vars(values), in_second=in_second)
    if values.estimates.origin != "posterior":
        return contrast
    fits = known_values(cohort, source, name, (cohort.reference, group), values.results, posteriors=False)
    return replace(contrast, fits=None if fits is None else fits.estimates)


def source_of(name: str, law: str) -> str:
    """Return where a quantity of the family comes from: the recording, or the law."""
    return "measured" if name in MEASURED else law


def known_values(
    cohort: Cohort,
    source: str,
    name: str,
    groups: Sequence[str],
    among: Sequence[AnimalResult] | None = None,
    posteriors: bool = True,
) -> Values | None:
    """Return a quantity of the animals of some groups (`among` some) that have it; None if it is unknown.

    Errors are those of `Estimates.alike_within` the cells of the cohort, with its lungs; see `estimates_of`.
    """
    rows = rows_of(cohort.table, source)
    label = column(rows, name)
    if not label:
        return None
    values = rows[label].astype(float)
    results = [
        result
        for result in (cohort.results if among is None else among)
        if result.group in groups
        and (source == "measured" or source in result.laws)
        and np.isfinite(values[result.name])
    ]
    shares = {title: cohort.variables[title].levels for title in SHARED_SOURCES if title in cohort.variables}
    cell_of = {result.name: called for called, cell in cohort.cells.items() for result in cell.results}
    estimates = estimates_of(results, source, name, shares, posteriors)
    estimates = estimates.alike_within([cell_of[result.name] for result in results])
    return Values(name, source, split_unit(label)[1], results, estimates.of_lungs(cohort.lungs.sd))


def _compared_quantities(contrasts: Sequence[GroupContrast]) -> list[ComparedQuantity]:
    """Return what the rows of all pairs of groups are, with numbers for animals and quantities."""
    quantities = {name: place for place, name in enumerate(dict.fromkeys(contrast.name for contrast in contrasts))}
    members = animal_indices([contrast.names for contrast in contrasts])
    return [
        ComparedQuantity(
            quantities[contrast.name], animals, contrast.in_second,
            contrast.estimates.logs, contrast.estimates.errors, contrast.shared,
        )
        for contrast, animals in zip(contrasts, members, strict=True)
    ]  # fmt: skip


MAX_RELABELINGS = 200_000
"""Where there are more, a permutation test draws this many; the observed labels are always among them."""


def smallest_p(sizes: tuple[int, int], pairs: int = 1) -> float:
    """Return the smallest p that relabelings of two groups of these sizes can give, with so many pairs of groups.

    Groups of equal size can be swapped, which leaves every |t| as it is; then two relabelings always reach it.
    """
    reached = 2 if sizes[0] == sizes[1] else 1
    return min(1.0, pairs * (reached / min(comb(sum(sizes), sizes[1]), MAX_RELABELINGS)))


def _assurance(tested: Sequence[GroupContrast], together: Simultaneous) -> Assurance:
    """Return how far the rows can be relied on."""
    groups = [
        (contrast.estimates.logs[~contrast.in_second], contrast.estimates.logs[contrast.in_second])
        for contrast in tested
    ]
    log_ratio = max(abs(float(np.log(x.std(ddof=1) / y.std(ddof=1)))) for x, y in groups)
    smallest = min(min(len(x), len(y)) for x, y in groups)
    return Assurance(together.rate, 1 - together.critical, float(np.exp(log_ratio)), smallest)


def _influence(contrast: GroupContrast, ratio: Ratio) -> tuple[str, float]:
    """Return the animal whose absence moves the ratio most, and the ratio without it."""
    if min(contrast.in_second.sum(), (~contrast.in_second).sum()) < 3:
        return "", np.nan
    count = len(contrast.results)
    ratios = [contrast.ratio(np.arange(count) != row).value for row in range(count)]
    farthest = int(np.argmax(np.abs(np.log(ratios) - np.log(ratio.value))))
    return contrast.results[farthest].name, ratios[farthest]
