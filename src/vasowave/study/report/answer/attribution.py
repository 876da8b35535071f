"""What made a group what it is, and what would change it: in words, and as tables."""

import numpy as np
import pandas as pd

from vasowave.pulse.quantities import HYDRAULIC_POWER, QUANTITIES
from vasowave.study.cohort.attribution import GroupAttribution, difference_of_changes
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.figures.matplotlib_style import short
from vasowave.study.report.blocks import Table
from vasowave.study.report.wording import listed, number, with_interval

_QUANTITIES = {"mPAP": "mean pressure", "pPAP": "pulse pressure"}
_LOADS = _QUANTITIES | {HYDRAULIC_POWER: "power of the heart"}
_SHARES = (
    "Each component of the fitted models was exchanged, in every order; its share is the mean of what that does, and "
    "the shares add up to the change. Heart: flow and rate; geometry: the image. Pair by pair: supplement, Attribution."
)
_OCCASIONS = (
    "Mean over animals [95 %], mmHg, between the two occasions. At the same ratio a group of "
    "higher pressure changes by more mmHg: whether ratios differ, the answer says. "
)
_GROUPS = (
    "Mean over pairs of animals [95 %], mmHg. Intervals hold the scatter of animals and errors of the radii of shared "
    "images. "
)
_ALONE = (
    "Mean [95 %] of what the fitted models of the group do if one component alone is exchanged for that of the "
    "reference or of the first occasion; components act together, so that rows do not add up. Nothing else answers: no "
    "heart, bed or vessel regulates itself."
)


def attribution_answer(cohort: Cohort, tested: int = 1) -> list[tuple[str, str]]:
    """Return the question and the answer of a cohort that knows what made its groups; none of others.

    Its intervals hold alone, those of the answer for all effects `tested`.
    """
    texts = [f"{_head(changed)}: {_shares(changed)}." for changed in cohort.changes]
    if any(changed.exchanges for changed in cohort.changes):
        corrected = f"; those of the answer are corrected for {tested} comparisons, and it decides what is shown"
        texts.append(f"The tables below have the intervals, each by itself{corrected if tested > 1 else ''}.")
    return [(_question(cohort), " ".join(texts))] if texts else []


def attribution_summary(cohort: Cohort) -> list[Table]:
    """Return the mean shares of each group, and what the exchange of one component alone does."""
    exchanged = [changed for changed in cohort.changes if changed.exchanges]
    if not exchanged:
        return []
    notes = (_GROUPS if exchanged[0].of_groups else _OCCASIONS) + _SHARES
    of_groups = [(_head(changed), {name: changed.means(name) for name in _QUANTITIES}) for changed in exchanged]
    means = [(title, name, shares) for title, of_quantities in [*of_groups, *_differences(cohort)]
             for name, shares in of_quantities.items()]  # fmt: skip
    columns = list(dict.fromkeys(component for *_, shares in means for component in shares.index))
    rows = [
        (title, _QUANTITIES[name], *(_signed(shares.loc[column]) if column in shares.index else "0"
                                     for column in columns))
        for title, name, shares in means
    ]  # fmt: skip
    shares = Table("", _question(cohort), ("group", "quantity", *columns), rows, notes)
    return [shares, _undone(exchanged)]


def _differences(cohort: Cohort) -> list[tuple[str, dict[str, pd.DataFrame]]]:
    """Return by how much the change of each group exceeds that of the reference, where animals were followed."""
    followed = [changed for changed in cohort.changes if changed.exchanges and not changed.of_groups]
    reference = next((changed for changed in followed if changed.group == cohort.reference), None)
    if reference is None:
        return []
    return [
        (f"Change of {short(changed.group)} less that of {short(reference.group)}, in mmHg, not as a ratio",
         {name: difference_of_changes(changed, reference, name) for name in _QUANTITIES})
        for changed in followed
        if changed is not reference
    ]  # fmt: skip


def _undone(exchanged: list[GroupAttribution]) -> Table:
    rows = []
    for changed in exchanged:
        means = {name: changed.means(name, "undone") for name in _LOADS}
        for component in next(iter(means.values())).index:
            numbers = (_signed(of_quantity.loc[component]) for of_quantity in means.values())
            rows.append((short(changed.group), f"{component} of {short(changed.first)}", *numbers))
    titles = [f"{title} [{QUANTITIES[name].unit}]" for name, title in _LOADS.items()]
    return Table("", "What would change", ("group", "with the", *titles), rows, _ALONE)


def _question(cohort: Cohort) -> str:
    return "What makes the difference?" if cohort.changes[0].of_groups else "What made the change?"


def _head(changed: GroupAttribution) -> str:
    names = (
        f"{short(changed.group)} against {short(changed.first)}"
        if changed.of_groups
        else f"{short(changed.group)}, {changed.first} to {changed.last}"
    )
    if not changed.exchanges:
        return names
    absent = f"; {len(changed.failures)} could not be exchanged" if changed.failures else ""
    return f"{names} (n = {' + '.join(map(str, changed.animals()))}{absent})"


def _shares(changed: GroupAttribution) -> str:
    """Return what made the change of a group, or why that cannot be told."""
    if not changed.exchanges:
        return f"not told, {next(iter(changed.failures.values()))}"
    return ", ".join(_shown(changed.means(name), name) for name in _QUANTITIES)


def _shown(means: pd.DataFrame, name: str) -> str:
    """Return the change of a quantity, its first row, the shares whose interval leaves out 0, and the other ones."""
    sizes = {str(component): _signed(row).partition(" ")[0] for component, row in means.iterrows()}
    shares = means.drop("change").sort_values("mean", key=np.abs, ascending=False)
    unclear = (shares["low"] <= 0) & (shares["high"] >= 0)
    shown = [f"{component} {sizes[str(component)]}" for component in shares.index[~unclear]]
    unshown = f"around 0: {listed(list(map(str, shares.index[unclear])))}" if unclear.any() else ""
    detail = "; ".join(text for text in (", ".join(shown), unshown) if text)
    return f"{_QUANTITIES[name]} {sizes['change']} {QUANTITIES[name].unit} ({detail})"


def _signed(row: pd.Series) -> str:
    value, low, high = row["mean"], row["low"], row["high"]
    text = with_interval(value, low, high) if np.isfinite(low) else number(value, 2)
    return text if text.startswith(("-", "−")) else f"+{text}"
