"""The one primary comparison: a family of quantities declared before, its effects, intervals and p for all at once."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import Annotated, NamedTuple

import pandas as pd
from annotated_types import Ge, Le

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import Finding
from vasowave.base.settings import settings_class
from vasowave.pulse.quantities import MEASURED, PRIMARY, question_of
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.designed import (
    Modeled,
    covariate_effects,
    design_effects,
    design_estimates,
    group_changes,
    modeled,
)
from vasowave.study.cohort.effects import (
    ContrastEstimate,
    CovariateEffect,
    DesignEstimate,
    Effect,
    Omission,
    as_table,
    grouped,
)
from vasowave.study.cohort.independent import (
    Assurance,
    GroupContrast,
    group_effects,
    known_values,
    secondary_estimates,
    source_of,
    split_usable,
    usable_contrasts,
)
from vasowave.study.cohort.lungs import LungDifferences
from vasowave.study.cohort.missing import Missing, missing_animals
from vasowave.study.cohort.simultaneous_intervals import LEVEL


@settings_class
class Family:
    """What is compared between groups as primary; everything else in a report is secondary."""

    law: str | None = None
    """Wall law whose quantities are primary. Empty: the first of `calibration.walls`, by default the law with the
    fewest parameters, which recordings determine best; the other laws stand beside it without a p."""
    quantities: tuple[str, ...] = PRIMARY
    """Of the recording (HR, CO, mPAP, …, measured_Z_c, measured_C_T, measured_tau, measured_I_R, pPAP_over_SV) and of
    the model, one family for one p. By default a few for each question (pressure and flow, large arteries, small
    vessels, waves), by the recording alone, which needs no image of vessels, and by the model."""
    lung_sd: Annotated[float, Ge(0), Le(1)] | None = None
    """How much the lungs of one group differ: SD of the logarithm of all radii between them. An image that animals
    share is of one lung, so that this moves all of them alike. Empty: 0.09, of mice of one strain, or nearer to what
    the roots' radii show where several lungs of a group were imaged. 0: every lung is like the imaged one."""

    @property
    def stated(self) -> bool:
        """Whether a study names its quantities; the default family asks for all at once."""
        return self.quantities != PRIMARY


class Missed(NamedTuple):
    """An effect of a design that the animals do not tell, why, and the quantities that lack it."""

    finding: Finding
    quantities: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Primary:
    """The primary comparison of every group with the first.

    Attributes
    ----------
    law : str
        The law whose quantities are primary; empty if no animal was calibrated.
    effects : tuple of Effect
        One per pair of groups and quantity; with a design one per contrast and quantity.
    others : tuple of ContrastEstimate
        The same effects by the other laws, their intervals to the same level, without a test.
    left_out : tuple of Omission
        Quantities (of groups) that could not be compared, animals that a design does not know, and why.
    assurance : Assurance, optional
        How far p and intervals can be relied on; none without a tested effect.
    missing : tuple of Missing
        Of each group that misses any, the animals without a result or without the primary law: how many, of how many,
        and where their measured mPAP lies among the others'.
    untold : tuple of Missed
        Effects of a design that the animals do not tell, with the reason.
    adjusted : tuple of CovariateEffect
        What the covariates of a design do; see `designed.covariate_effects`.
    changes : tuple of DesignEstimate
        The change of each group by itself, where a design compares the changes of groups; see `designed.group_changes`.
    lungs : LungDifferences, optional
        How much the lungs of one group differ, which intervals and p of what an image is behind allow for.
    stated : bool
        Whether the study names the quantities that are compared.
    """

    law: str
    effects: tuple[Effect, ...]
    others: tuple[ContrastEstimate, ...]
    left_out: tuple[Omission, ...]
    assurance: Assurance | None = None
    missing: tuple[Missing, ...] = ()
    untold: tuple[Missed, ...] = ()
    adjusted: tuple[CovariateEffect, ...] = ()
    changes: tuple[DesignEstimate, ...] = ()
    lungs: LungDifferences | None = None
    stated: bool = False

    @property
    def shown_alone(self) -> list[tuple[Effect, float]]:
        """The effects that are not shown but had been, if their quantity alone had been tested, with their p then.

        That p is corrected for the quantity's own contrasts (Bonferroni).
        """
        tested = [effect for effect in self.effects if not effect.untested]
        contrasts = Counter(effect.quantity for effect in tested)
        alone = [(effect, contrasts[effect.quantity] * effect.p_alone) for effect in tested if effect.p >= LEVEL]
        return [(effect, p) for effect, p in alone if p < LEVEL]

    def of_group(self, group: str) -> "Primary":
        """Return what is said of one group; intervals and p still hold for all groups at once."""
        return replace(
            self,
            effects=tuple(effect for effect in self.effects if effect.contrast.group == group),
            others=tuple(estimate for estimate in self.others if estimate.contrast.group == group),
        )

    def table(self) -> pd.DataFrame:
        """Return the effects as a table, one row each, with the columns of `GroupEffect` or of `DesignEffect`."""
        return as_table(self.effects)


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
    compare = _by_groups if cohort.design.plain else _by_design
    return replace(compare(cohort, law, names), missing=missing_animals(cohort, law), lungs=cohort.lungs,
                   stated=family.stated)  # fmt: skip


def _by_groups(cohort: Cohort, law: str, names: Sequence[str]) -> Primary:
    """Compare groups of independent animals by pooled ratios."""
    usable = {group: usable_contrasts(cohort, names, law, group) for group in list(cohort.groups)[1:]}
    contrasts = {group: of_group for group, (of_group, _) in usable.items()}
    left_out = tuple(omission for _, omissions in usable.values() for omission in omissions)
    effects, critical, assurance = group_effects(cohort, contrasts)
    secondary = secondary_estimates(cohort, law, contrasts, critical)
    return Primary(law, tuple(effects), tuple(secondary), left_out, assurance)


def with_lungs(cohort: Cohort, family: Family) -> Cohort:
    """Return the cohort whose lungs differ as the family says, where it says anything."""
    return cohort if family.lung_sd is None else replace(cohort, lung_sd=family.lung_sd)


def comparable(cohort: Cohort, family: Family) -> list[GroupContrast]:
    """Return the quantities of the family in the first two groups that can be compared."""
    cohort = with_lungs(cohort, family)
    law, groups = primary_law(cohort, family), list(cohort.groups)[1:2]
    names = [name for name in family.quantities if law or name in MEASURED]
    return [contrast for group in groups for contrast in usable_contrasts(cohort, names, law, group)[0]]


def _by_design(cohort: Cohort, law: str, names: Sequence[str]) -> Primary:
    """Compare by the model of the design."""
    models, left_out, untold = _models(cohort, names, law)
    effects, critical = design_effects(models)
    tested = [model.values.name for model in models if model.values.source == law]
    secondary = [
        estimate
        for further in cohort.walls
        if further != law
        for estimate in design_estimates(_models(cohort, tested, further)[0], critical)
    ]
    columns = {animal: column for model in models for animal, column in model.layout.left_out.items()}
    left_out += [Omission(f"its cell of '{column}' is empty", animal=animal) for animal, column in columns.items()]
    adjusted = tuple(effect for model in models for effect in covariate_effects(cohort, model))
    return Primary(law, tuple(effects), tuple(secondary), tuple(left_out), untold=untold, adjusted=adjusted,
                   changes=tuple(group_changes(models)))  # fmt: skip


def _models(cohort: Cohort, names: Sequence[str], law: str) -> tuple[list[Modeled], list[Omission], tuple[Missed, ...]]:
    """Return the models of the quantities that have one, the others with the reason, and effects that are not told."""
    groups = list(cohort.groups)
    models, left_out = split_usable(
        names, lambda name: modeled(cohort, known_values(cohort, source_of(name, law), name, groups))
    )
    pairs = [(effect.finding, model.values.name) for model in models for effect in model.layout.untold]
    untold = grouped(pairs, itemgetter(0))
    missed = (Missed(finding, tuple(name for _, name in of_finding)) for finding, of_finding in untold.items())
    return [model for model in models if model.contrasts], left_out, tuple(missed)


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
