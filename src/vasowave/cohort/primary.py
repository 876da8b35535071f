"""The one primary comparison: a family of quantities that was declared before, effects pooled, p for all at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.animal.reading import group_of, name_of, wall_laws
from vasowave.cohort.cohort import Cohort
from vasowave.cohort.estimates import Estimates, estimates_of, shared_error
from vasowave.cohort.permutation import MOST_RELABELINGS, family_p, smallest_family_p
from vasowave.cohort.pooling import Ratio, pooled_ratio
from vasowave.cohort.table import INDICES, column, rows_of
from vasowave.columns import split_unit
from vasowave.errors import InputError, did_you_mean

QUESTIONS = {
    "Pressure and flow": INDICES,
    "Large arteries": ("stiffness", "wave_speed", "C_v", "C_v_plain"),
    "Small vessels": ("R_T", "C_p", "C_T", "C_T_plain", "tau", "tau_plain", "a"),
    "Waves": ("I_R",),
}
"""What a quantity tells of; a quantity that is none of these tells of itself."""


@dataclass(frozen=True)
class Family:
    """What is compared between groups as primary; everything else in a report is secondary.

    Attributes
    ----------
    law : str
        Wall law whose quantities are primary. Empty: the first of `calibration.walls`, by default the law with the
        fewest parameters, which recordings determine best; the other laws stand beside it without a p.
    quantities : tuple of str
        Of the recording (HR, CO, mPAP, …) and of the model, one family for one p. By default one or a few for each
        question: pressure and flow, stiffness of the large arteries, small vessels, waves.
    """

    law: str | None = None
    quantities: tuple[str, ...] = ("mPAP", "CO", "PVR", "stiffness", "wave_speed", "C_p", "tau", "a", "I_R")


class Compared(NamedTuple):
    """One quantity that can be compared between two groups.

    Attributes
    ----------
    name, source, unit : str
    results : list of DataTree
        Animals of both groups that have it.
    known : Estimates
    other : array of bool, shape (animal,)
    """

    name: str
    source: str
    unit: str
    results: list[xr.DataTree]
    known: Estimates
    other: np.ndarray

    def ratio(self, kept: np.ndarray | slice = slice(None)) -> Ratio:
        """Return the pooled ratio of the second group over the first, of the animals kept."""
        one, other = self.known.of(kept), self.other[kept]
        reference = one.logs[~other], one.errors[~other]
        return pooled_ratio(reference, (one.logs[other], one.errors[other]), shared=shared_error(one, other))


@dataclass(frozen=True, eq=False)
class Primary:
    """The primary comparison of every group with the first.

    Attributes
    ----------
    law : str
        The law whose quantities are primary; empty if no animal was calibrated.
    rows : DataFrame
        One per pair of groups and quantity: ``reference, other, question, quantity, source, n reference, n other``,
        ``mean reference, mean other, unit, ratio, low, high, p, smallest p, apart, without, ratio without``,
        ``estimates``. The means are the groups' pooled geometric means, in the unit of the cohort's table; their ratio
        is `ratio`. `p` is family-wise over all quantities and pairs. `apart`: no animal of one group lies among the
        other. `without` is the animal that moves the ratio most when it is left out (empty for fewer than three), and
        the ratio is then `ratio without`. `estimates` says what the animals' values and errors are of: their
        ``posterior`` where all have one that can be trusted, their ``fit``, or ``plain`` values without errors.
    others : DataFrame
        The same effects by the other laws, without a test: ``reference, other, quantity, source, ratio, low, high``.
    left_out : dict of str to str
        Quantities and groups that could not be compared, and why.
    """

    law: str
    rows: pd.DataFrame
    others: pd.DataFrame
    left_out: dict[str, str]


def primary_comparison(cohort: Cohort, family: Family | None = None) -> Primary:
    """Compare every group with the first by the primary family.

    Raises
    ------
    InputError
        A law that no animal was calibrated with, or a quantity that no source has.
    """
    family = family or Family()
    law = _law(cohort, family)
    _check(cohort, family, law)
    names = family.quantities if law else tuple(name for name in family.quantities if name in INDICES)
    reference, *others = cohort.groups
    left_out: dict[str, str] = {}
    parts, beside = [], []
    for other in others:
        usable = _usable(cohort, names, law, other, left_out)
        parts += _rows(usable, reference, other, pairs=len(others))
        for further in (wall for wall in cohort.walls if wall != law):
            modeled = tuple(one.name for one in usable if one.source == law)
            beside += [
                {"reference": reference, "other": other, "quantity": one.name, "source": further}
                | dict(zip(("ratio", "low", "high"), one.ratio()[:3], strict=True))
                for one in _usable(cohort, modeled, further, other, {})
            ]
    return Primary(law, pd.DataFrame(parts), pd.DataFrame(beside), left_out)


def question_of(name: str) -> str:
    """Return what a quantity tells of."""
    return next((question for question, names in QUESTIONS.items() if name in names), name)


def source_of(name: str, law: str) -> str:
    """Return where a quantity of the family comes from: the recording, or the law."""
    return "measured" if name in INDICES else law


def smallest_p(sizes: tuple[int, int], pairs: int = 1) -> float:
    """Return the smallest family-wise p that two groups of these sizes can reach, with so many pairs of groups."""
    return min(1.0, pairs * smallest_family_p(*sizes))


def relabelings(sizes: tuple[int, int]) -> int:
    """Return how many relabelings stand behind a p."""
    return min(comb(sum(sizes), sizes[0]), MOST_RELABELINGS)


def _law(cohort: Cohort, family: Family) -> str:
    if family.law and family.law not in cohort.walls:
        known = ", ".join(cohort.walls) or "none"
        hint = did_you_mean(family.law, cohort.walls)
        raise InputError(f"no animal was calibrated with the primary law '{family.law}'{hint}; there are: {known}")
    return family.law or next(iter(cohort.walls), "")


def _check(cohort: Cohort, family: Family, law: str) -> None:
    """Refuse a name that nothing has; what only this law or these animals lack is left out and named."""
    known = [str(label).split(" [")[0] for label in cohort.table.columns]
    for name in family.quantities:
        if name not in known and (law or name in INDICES):
            raise InputError(f"no animal has the quantity '{name}'{did_you_mean(name, known)}; see the table Groups")


def _usable(cohort: Cohort, names: Sequence[str], law: str, other: str, left_out: dict[str, str]) -> list[Compared]:
    """Return the quantities that can be compared; `left_out` gets the others with the reason."""
    usable = []
    for name in names:
        source = source_of(name, law)
        one = _compared(cohort, source, name, other)
        if reason := "no animal has it" if one is None else _refusal(one):
            left_out[f"{name} ({other})"] = reason
        elif one is not None:
            usable.append(one)
    return usable


def _compared(cohort: Cohort, source: str, name: str, other: str) -> Compared | None:
    rows = rows_of(cohort.table, source)
    label = column(rows, name)
    if not label:
        return None
    values = rows[label].astype(float)
    pair = (cohort.reference, other)
    results = [
        result
        for result in cohort.results
        if group_of(result) in pair
        and (source == "measured" or source in wall_laws(result))
        and np.isfinite(values[name_of(result)])
    ]
    of_other = np.array([group_of(result) == other for result in results])
    return Compared(name, source, split_unit(label)[1], results, estimates_of(results, source, name), of_other)


def _refusal(one: Compared) -> str:
    """Return why groups cannot be compared by a quantity; empty if they can."""
    if min(one.other.sum(), (~one.other).sum()) < 2:
        return "a group has fewer than two animals with it"
    if not np.all(np.isfinite(one.known.logs)):
        return "a value is not positive; a ratio needs positive values"
    if min(np.ptp(one.known.logs[one.other]), np.ptp(one.known.logs[~one.other])) < 1e-9:
        return "the values hardly vary within a group; there is nothing to test"
    return ""


def _rows(usable: Sequence[Compared], reference: str, other: str, pairs: int) -> list[dict[str, object]]:
    """Return the rows of one pair of groups. Quantities of the same animals share one test."""
    p = _family_p(usable)
    rows: list[dict[str, object]] = []
    for one, value in zip(usable, p, strict=True):
        sizes = int((~one.other).sum()), int(one.other.sum())
        ratio = one.ratio()
        row = {
            "reference": reference, "other": other, "question": question_of(one.name), "quantity": one.name,
            "source": one.source, "n reference": sizes[0], "n other": sizes[1],
            "mean reference": ratio.reference, "mean other": ratio.other, "unit": one.unit, "ratio": ratio.value,
            "low": ratio.low, "high": ratio.high, "p": min(1.0, pairs * value), "smallest p": smallest_p(sizes, pairs),
            "apart": _apart(one), "estimates": one.known.origin,
        }  # fmt: skip
        rows.append(row | _influence(one, ratio))
    return rows


def _apart(one: Compared) -> bool:
    """Return whether every animal of one group lies above every animal of the other."""
    x, y = one.known.logs[~one.other], one.known.logs[one.other]
    return bool(x.max() < y.min() or y.max() < x.min())


def _family_p(usable: Sequence[Compared]) -> np.ndarray:
    """Return the family-wise p of the quantities; an animal counts where it has a value."""
    if not usable:
        return np.empty(0)
    everyone = {name_of(result): group for one in usable for result, group in zip(one.results, one.other, strict=True)}
    place = {name: row for row, name in enumerate(everyone)}
    values = np.full((len(place), len(usable)), np.nan)
    for quantity, one in enumerate(usable):
        values[[place[name_of(result)] for result in one.results], quantity] = one.known.logs
    return family_p(values, np.array(list(everyone.values())))


def _influence(one: Compared, ratio: Ratio) -> dict[str, object]:
    """Return the animal whose absence moves the ratio most, and the ratio without it."""
    nothing: dict[str, object] = {"without": "", "ratio without": np.nan}
    if min(one.other.sum(), (~one.other).sum()) < 3:
        return nothing
    count = len(one.results)
    left = [one.ratio(np.arange(count) != row).value for row in range(count)]
    farthest = int(np.argmax(np.abs(np.log(left) - np.log(ratio.value))))
    return {"without": name_of(one.results[farthest]), "ratio without": left[farthest]}
