"""The one primary comparison: a family of quantities declared before, its effects, intervals and p for all at once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import comb
from typing import Annotated, NamedTuple

import numpy as np
import pandas as pd
from annotated_types import Ge, Le

from vasowave.base.descriptions import LEVEL
from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import Finding
from vasowave.base.io.columns import split_unit
from vasowave.base.settings import settings_class
from vasowave.pulse.inference.known_errors import SHARED_SOURCES
from vasowave.pulse.quantities import MEASURED, question_of
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.designed import Modeled, Values, beside, covariate_effects, modeled, rows_of_design
from vasowave.study.cohort.estimates import Estimates, estimates_of, image_unknown, shared_error
from vasowave.study.cohort.lungs import LungDifferences, tipping_radius
from vasowave.study.cohort.missing import Missing, missing_animals
from vasowave.study.cohort.pooling import Ratio, pooled_ratio
from vasowave.study.cohort.simultaneous_intervals import ComparedQuantity, Simultaneous, simultaneous
from vasowave.study.cohort.table import column, rows_of


@settings_class
class Family:
    """What is compared between groups as primary; everything else in a report is secondary."""

    law: str | None = None
    """Wall law whose quantities are primary. Empty: the first of `calibration.walls`, by default the law with the
    fewest parameters, which recordings determine best; the other laws stand beside it without a p."""
    quantities: tuple[str, ...] = (
        "mPAP", "CO", "PVR", "measured_Z_c", "pPAP_over_SV", "stiffness", "wave_speed", "measured_C_T", "C_p", "tau",
        "a", "measured_I_R", "I_R",
    )  # fmt: skip
    """Of the recording (HR, CO, mPAP, …, measured_Z_c, measured_C_T, measured_tau, measured_I_R, pPAP_over_SV) and of
    the model, one family for one p. By default a few for each question (pressure and flow, large arteries, small
    vessels, waves), by the recording alone, which needs no image of vessels, and by the model."""
    lung_sd: Annotated[float, Ge(0), Le(1)] | None = None
    """How much the lungs of one group differ: SD of the logarithm of all radii between them. An image that animals
    share is of one lung, so that this moves all of them alike. Empty: 0.09, of mice of one strain, or nearer to what
    the roots' radii show where several lungs of a group were imaged. 0: every lung is like the imaged one."""


class GroupContrast(NamedTuple):
    """One quantity that can be compared between two groups.

    Attributes
    ----------
    name, source, unit : str
    results : list of AnimalResult
        Animals of both groups that have it.
    estimates : Estimates
    in_second : array of bool, shape (animal,)
    fits : Estimates, optional
        What the fits tell where `estimates` is of posteriors.
    """

    name: str
    source: str
    unit: str
    results: list[AnimalResult]
    estimates: Estimates
    in_second: np.ndarray
    fits: Estimates | None = None

    @property
    def names(self) -> list[str]:
        """Names of the animals."""
        return [result.name for result in self.results]

    @property
    def untested(self) -> "Untested":
        """Why its row has no p."""
        return Untested.ONE_IMAGE if image_unknown(self.estimates, self.in_second, self.source) else Untested.NO

    @property
    def shared(self) -> float:
        """Standard error of the difference of the groups from what animals share."""
        return shared_error(self.estimates, self.in_second)

    def ratio(self, selection: np.ndarray | slice = slice(None), level: float = LEVEL) -> Ratio:
        """Return the pooled ratio of the second group over the first, of the animals kept."""
        estimates, in_second = self.estimates.of(selection), self.in_second[selection]
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
            ratio = self._replace(estimates=self.estimates.of_lungs(sd)).ratio(level=1 - critical)
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


class Untested(StrEnum):
    """Why a row has no p."""

    NO = ""
    ONE_IMAGE = "one image"
    """Animals of a group have one image, and nothing tells how far its error moves this quantity: fits take the image
    as exact. With posteriors the error is known, and the row has a p."""


class Missed(NamedTuple):
    """An effect of a design that the animals do not tell, why, and the quantities that lack it."""

    finding: Finding
    quantities: tuple[str, ...]


@dataclass(frozen=True)
class Assurance:
    """How far the p and intervals of the family can be relied on, from the sizes and spreads at hand.

    Attributes
    ----------
    rate : float
        Estimated share of cohorts without any effect, normal on logarithms and of these sizes, spreads and
        correlations, in which a row has p < 0.05 all the same: 0.05 if the method were exact.
    alone : float
        Level of each interval by itself; together they hold in 95 %.
    spread_ratio : float
        Largest ratio, over the rows, of the SD of the two groups' logarithms.
    smallest : int
        Animals of the smallest group of any row.
    """

    rate: float
    alone: float
    spread_ratio: float
    smallest: int

    @property
    def doubtful(self) -> bool:
        """Whether a study must say so: false positives, by `rate`, are more than 0.06."""
        return self.rate > _MAX_FALSE_POSITIVE_RATE


_MAX_FALSE_POSITIVE_RATE = 0.06
"""Rate of false positives up to which a p is called family-wise without a remark."""


@dataclass(frozen=True, eq=False)
class Primary:
    """The primary comparison of every group with the first.

    Attributes
    ----------
    law : str
        The law whose quantities are primary; empty if no animal was calibrated.
    rows : DataFrame
        One per pair of groups and quantity: ``reference, other, question, quantity, source, n reference, n other``,
        ``mean reference, mean other, unit, ratio, low, high, standard error, df, p, untested, smallest p, apart``,
        ``without, ratio without, estimates``. `standard error` is that of the ratio's logarithm, and `df` its degrees
        of freedom. The means are the groups' pooled geometric means, in the unit of the cohort's table; their ratio
        is `ratio`. Intervals and `p` hold for all tested rows at once and have one reference distribution
        (`simultaneous`): an interval excludes 1 exactly if p < 0.05. `p` is NaN where `untested`, an `Untested`, says
        why; such a row is outside the family, and its interval holds in 95 % by itself, without what `untested` names.
        `smallest p` is the smallest that a test by ranks or relabelings alone could give, without any assumption about
        distributions. `tipping radius` is by what share the images of the groups must be wrong against each other for
        the interval to hold 1, `tipping lung sd` how much lungs of one group may differ for it still to exclude 1; see
        `lungs.tipping_radius` and `GroupContrast.tipping_lung_sd`. Of rows by posteriors `fits ratio, fits low, fits
        high` are what the fits say, without limits where they take the image as exact. `apart`: no animal of one group
        lies among the other. `without` is the animal that moves the ratio most when it is left out (empty for fewer
        than three), and the ratio is then `ratio without`.
        `estimates` says what the animals' values and errors are of: their ``posterior`` where all have one that can be
        trusted, their ``fit``, or ``plain`` values without errors. With a design one per effect and quantity, ``what``
        the effect is and ``within`` what it is compared (`contrast.Contrast`); of effects that are ratios of ratios the
        means are the ratios, and ``n both`` animals stand on both sides. `smallest p` and `apart` then say nothing.
    others : DataFrame
        The same effects by the other laws, their intervals to the same level, without a test:
        ``reference, other, quantity, source, ratio, low, high``.
    left_out : dict of str to str
        Quantities and groups that could not be compared, and why.
    assurance : Assurance, optional
        How far p and intervals can be relied on; none without a tested row.
    missing : tuple of Missing
        Of each group that misses any, the animals without a result or without the primary law: how many, of how many,
        and where their measured mPAP lies among the others'.
    untold : tuple of Missed
        Effects of a design that the animals do not tell, with the reason.
    adjusted : DataFrame
        What the covariates of a design do, each interval by itself, without a test: ``quantity, source, covariate,
        ratio, low, high``; see `designed.covariate_effects`.
    lungs : LungDifferences, optional
        How much the lungs of one group differ, which intervals and p of what an image is behind allow for.
    """

    law: str
    rows: pd.DataFrame
    others: pd.DataFrame
    left_out: dict[str, str]
    assurance: Assurance | None = None
    missing: tuple[Missing, ...] = ()
    untold: tuple[Missed, ...] = ()
    adjusted: pd.DataFrame = field(default_factory=pd.DataFrame)
    lungs: LungDifferences | None = None

    def of(self, group: str) -> "Primary":
        """Return what is said of one group; intervals and p still hold for all groups at once."""
        rows, secondary = (
            table[table["other"] == group] if len(table) else table for table in (self.rows, self.others)
        )
        return replace(self, rows=rows.reset_index(drop=True), others=secondary.reset_index(drop=True))


def primary_comparison(cohort: Cohort, family: Family | None = None) -> Primary:
    """Compare every group with the first by the primary family.

    Raises
    ------
    InputError
        A law that no animal was calibrated with, or a quantity that no source has.
    """
    family = family or Family()
    cohort = with_lungs(cohort, family)
    law = primary_law(cohort, family)
    _check(cohort, family, law)
    names = family.quantities if law else tuple(name for name in family.quantities if name in MEASURED)
    left_out: dict[str, str] = {}
    missing = missing_animals(cohort, law)
    if not cohort.design.plain:
        return _by_design(cohort, law, names, missing)
    pairs = {group: _usable(cohort, names, law, group, left_out) for group in list(cohort.groups)[1:]}
    comparisons = [(group, contrast) for group, usable in pairs.items() for contrast in usable]
    if not comparisons:
        return Primary(law, pd.DataFrame(), pd.DataFrame(), left_out, missing=missing, lungs=cohort.lungs)
    tested = [contrast for _, contrast in comparisons if not contrast.untested]
    together = simultaneous(_joint(tested)) if tested else None
    p = iter([] if together is None else together.p.tolist())
    critical = 1 - LEVEL if together is None else together.critical
    rows = [
        _row(
            cohort.reference,
            group,
            contrast,
            (np.nan, 1 - LEVEL) if contrast.untested else (next(p), critical),
            len(pairs),
        )
        for group, contrast in comparisons
    ]
    secondary = _beside(cohort, law, pairs, critical)
    assurance = _assurance(tested, together) if together is not None else None
    return Primary(law, pd.DataFrame(rows), pd.DataFrame(secondary), left_out, assurance, missing, lungs=cohort.lungs)


def with_lungs(cohort: Cohort, family: Family) -> Cohort:
    """Return the cohort whose lungs differ as the family says, where it says anything."""
    return cohort if family.lung_sd is None else replace(cohort, lung_sd=family.lung_sd)


def comparable(cohort: Cohort, family: Family) -> list[GroupContrast]:
    """Return the quantities of the family in the first two groups that can be compared."""
    cohort = with_lungs(cohort, family)
    law, groups = primary_law(cohort, family), list(cohort.groups)[1:2]
    names = [name for name in family.quantities if law or name in MEASURED]
    return [contrast for group in groups for contrast in _usable(cohort, names, law, group, {})]


def _by_design(cohort: Cohort, law: str, names: Sequence[str], missing: tuple[Missing, ...]) -> Primary:
    """Compare by the model of the design; without one, by the pooled ratios of groups of independent animals."""
    left_out: dict[str, str] = {}
    findings: dict[Finding, list[str]] = {}
    models = _models(cohort, names, law, left_out, findings)
    untold = tuple(Missed(finding, tuple(quantities)) for finding, quantities in findings.items())
    if not models:
        return Primary(law, pd.DataFrame(), pd.DataFrame(), left_out, missing=missing, untold=untold)
    rows, critical = rows_of_design(models)
    tested = [model.values.name for model in models if model.values.source == law]
    secondary = [_models(cohort, tested, further, {}, {}) for further in cohort.walls if further != law]
    further = pd.DataFrame([row for law_models in secondary for row in beside(law_models, critical)])
    gaps = {
        animal: f"its cell of '{column}' is empty"
        for model in models
        for animal, column in model.layout.left_out.items()
    }
    adjusted = pd.DataFrame(covariate_effects(cohort, models))
    return Primary(
        law, pd.DataFrame(rows), further, left_out | gaps, missing=missing, untold=untold, adjusted=adjusted,
        lungs=cohort.lungs,
    )  # fmt: skip


def _models(
    cohort: Cohort, names: Sequence[str], law: str, left_out: dict[str, str], untold: dict[Finding, list[str]]
) -> list[Modeled]:
    """Return the models of the quantities that have one.

    `left_out` gets the others with the reason, and `untold` the effects that cannot be told, and of which quantities.
    """
    models = []
    for name in names:
        values = known_values(cohort, source_of(name, law), name, list(cohort.groups))
        try:
            if values is None:
                raise InputError("no animal has it")
            model = modeled(cohort, values)
        except InputError as error:
            left_out[name] = str(error)
            continue
        for effect in model.layout.untold:
            untold.setdefault(effect.finding, []).append(name)
        models += [model] if model.contrasts else []
    return models


def _beside(
    cohort: Cohort, law: str, pairs: Mapping[str, Sequence[GroupContrast]], critical: float
) -> list[dict[str, object]]:
    """Return the effects by the other laws."""
    return [
        {"reference": cohort.reference, "other": group, "quantity": contrast.name, "source": further}
        | dict(
            zip(
                ("ratio", "low", "high"),
                contrast.ratio(level=LEVEL if contrast.untested else 1 - critical)[:3],
                strict=True,
            )
        )
        for group, usable in pairs.items()
        for further in cohort.walls
        if further != law
        for contrast in _usable(
            cohort, [contrast.name for contrast in usable if contrast.source == law], further, group, {}
        )
    ]


def source_of(name: str, law: str) -> str:
    """Return where a quantity of the family comes from: the recording, or the law."""
    return "measured" if name in MEASURED else law


MAX_RELABELINGS = 200_000
"""Where there are more, a permutation test draws this many; the observed labels are always among them."""


def smallest_p(sizes: tuple[int, int], pairs: int = 1) -> float:
    """Return the smallest p that relabelings of two groups of these sizes can give, with so many pairs of groups.

    Groups of equal size can be swapped, which leaves every |t| as it is; then two relabelings always reach it.
    """
    reached = 2 if sizes[0] == sizes[1] else 1
    return min(1.0, pairs * (reached / min(comb(sum(sizes), sizes[1]), MAX_RELABELINGS)))


def primary_law(cohort: Cohort, family: Family) -> str:
    """Return the law whose quantities are primary; empty where no animal was calibrated.

    Raises
    ------
    InputError
        No animal was calibrated with the law that `family` names.
    """
    if family.law and family.law not in cohort.walls:
        names = ", ".join(cohort.walls) or "none"
        hint = did_you_mean(family.law, cohort.walls)
        raise InputError(f"no animal was calibrated with the primary law '{family.law}'{hint}; there are: {names}")
    return family.law or next(iter(cohort.walls), "")


def _check(cohort: Cohort, family: Family, law: str) -> None:
    """Refuse a name that nothing has; what only this law or these animals lack is left out and named."""
    column_names = [str(label).split(" [")[0] for label in cohort.table.columns]
    for name in family.quantities:
        if name not in column_names and question_of(name) == name and (law or name in MEASURED):
            raise InputError(
                f"no animal has the quantity '{name}'{did_you_mean(name, column_names)}; see the table Groups"
            )


def _usable(
    cohort: Cohort, names: Sequence[str], law: str, group: str, left_out: dict[str, str]
) -> list[GroupContrast]:
    """Return the quantities that can be compared; `left_out` gets the others with the reason."""
    usable = []
    for name in names:
        source = source_of(name, law)
        contrast = _compared(cohort, source, name, group)
        if reason := "no animal has it" if contrast is None else _refusal(contrast):
            left_out[f"{name} ({group})"] = reason
        elif contrast is not None:
            usable.append(contrast)
    return usable


def _compared(cohort: Cohort, source: str, name: str, group: str) -> GroupContrast | None:
    values = known_values(cohort, source, name, (cohort.reference, group))
    if values is None:
        return None
    of_other = np.array([result.group == group for result in values.results], dtype=bool)
    contrast = GroupContrast(name, source, values.unit, values.results, values.estimates, of_other)
    if values.estimates.origin != "posterior" or source == "measured":
        return contrast
    fits = known_values(cohort, source, name, (cohort.reference, group), values.results, posteriors=False)
    return contrast._replace(fits=fits and fits.estimates)


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


def _refusal(contrast: GroupContrast) -> str:
    """Return why groups cannot be compared by a quantity; empty if they can."""
    if min(contrast.in_second.sum(), (~contrast.in_second).sum()) < 2:
        return "a group has fewer than two animals with it"
    if not np.all(np.isfinite(contrast.estimates.logs)):
        return "a value is not positive; a ratio needs positive values"
    if (
        min(np.ptp(contrast.estimates.logs[contrast.in_second]), np.ptp(contrast.estimates.logs[~contrast.in_second]))
        < 1e-9
    ):
        return "the values hardly vary within a group; there is nothing to test"
    return ""


def _row(
    reference: str, group: str, contrast: GroupContrast, judged: tuple[float, float], pairs: int
) -> dict[str, object]:
    """Return one row: a quantity of one pair of groups, with its p and the p by itself that its interval belongs to."""
    sizes, (p, critical) = (int((~contrast.in_second).sum()), int(contrast.in_second.sum())), judged
    ratio = contrast.ratio(level=1 - critical)
    row = {
        "reference": reference, "other": group, "question": question_of(contrast.name), "quantity": contrast.name,
        "source": contrast.source, "n reference": sizes[0], "n other": sizes[1], "mean reference": ratio.reference,
        "mean other": ratio.other, "unit": contrast.unit, "ratio": ratio.value, "low": ratio.low, "high": ratio.high,
        "standard error": ratio.error, "df": ratio.freedom, "p": p,
        "untested": str(contrast.untested), "smallest p": smallest_p(sizes, pairs),
        "apart": _apart(contrast), "estimates": contrast.estimates.origin,
        "tipping radius": tipping_radius(ratio.low, ratio.high, float(contrast.estimates.per_radius.mean())),
        "tipping lung sd": contrast.tipping_lung_sd(critical),
    } | _by_fits(contrast, critical)  # fmt: skip
    return row | _influence(contrast, ratio)


def _by_fits(contrast: GroupContrast, critical: float) -> dict[str, object]:
    """Return the ratio by the fits, where the row's is by posteriors, with its interval of the same level."""
    if contrast.fits is None or not np.all(np.isfinite(contrast.fits.logs)):
        return dict.fromkeys(("fits ratio", "fits low", "fits high"), np.nan)
    fits = contrast._replace(estimates=contrast.fits)
    value, low, high, *_ = fits.ratio(level=1 - critical)
    low, high = (0.0, np.inf) if fits.untested else (low, high)
    return {"fits ratio": value, "fits low": low, "fits high": high}


def _joint(contrasts: Sequence[GroupContrast]) -> list[ComparedQuantity]:
    """Return what the rows of all pairs of groups are, with numbers for animals and quantities."""
    animals = {
        name: place
        for place, name in enumerate(dict.fromkeys(name for contrast in contrasts for name in contrast.names))
    }
    quantities = {name: place for place, name in enumerate(dict.fromkeys(contrast.name for contrast in contrasts))}
    return [
        ComparedQuantity(
            quantities[contrast.name], np.array([animals[name] for name in contrast.names]), contrast.in_second,
            contrast.estimates.logs, contrast.estimates.errors, shared_error(contrast.estimates, contrast.in_second),
        )
        for contrast in contrasts
    ]  # fmt: skip


def _assurance(tested: Sequence[GroupContrast], together: Simultaneous) -> Assurance:
    """Return how far the rows can be relied on."""
    groups = [
        (contrast.estimates.logs[~contrast.in_second], contrast.estimates.logs[contrast.in_second])
        for contrast in tested
    ]
    log_ratio = max(abs(float(np.log(x.std(ddof=1) / y.std(ddof=1)))) for x, y in groups)
    smallest = min(min(len(x), len(y)) for x, y in groups)
    return Assurance(together.rate, 1 - together.critical, float(np.exp(log_ratio)), smallest)


def _apart(contrast: GroupContrast) -> bool:
    """Return whether every animal of one group lies above every animal of the other."""
    x, y = contrast.estimates.logs[~contrast.in_second], contrast.estimates.logs[contrast.in_second]
    return bool(x.max() < y.min() or y.max() < x.min())


def _influence(contrast: GroupContrast, ratio: Ratio) -> dict[str, object]:
    """Return the animal whose absence moves the ratio most, and the ratio without it."""
    nothing: dict[str, object] = {"without": "", "ratio without": np.nan}
    if min(contrast.in_second.sum(), (~contrast.in_second).sum()) < 3:
        return nothing
    count = len(contrast.results)
    ratios = [contrast.ratio(np.arange(count) != row).value for row in range(count)]
    farthest = int(np.argmax(np.abs(np.log(ratios) - np.log(ratio.value))))
    return {"without": contrast.results[farthest].name, "ratio without": ratios[farthest]}
