"""What made the change of animals that were recorded before and after: in words, and as a table."""

import numpy as np
import pandas as pd

from vasowave.pulse.quantities import QUANTITIES
from vasowave.study.cohort.attribution import GroupAttribution
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.figures.matplotlib_style import short
from vasowave.study.report.blocks import Table
from vasowave.study.report.wording import number, with_interval

_QUANTITIES = {"mPAP": "mean pressure", "pPAP": "pulse pressure"}
QUESTION = "What made the change?"
_NOTE = (
    "Mean over animals [95 %], mmHg. Each component of the fitted models was exchanged between the two occasions, in "
    "every order; its share is the mean of what that does, and the shares add up to the change. Heart: flow and rate; "
    "geometry: the image. Animal by animal: supplement, Attribution."
)


def attribution_answer(cohort: Cohort) -> list[tuple[str, str]]:
    """Return the question and the answer of animals that were recorded before and after; none of others."""
    texts = [f"{_head(changed)}: {_shares(changed)}." for changed in cohort.changes]
    table = ["The table below has all shares."] if attribution_summary(cohort) else []
    return [(QUESTION, " ".join([*texts, *table]))] if texts else []


def attribution_summary(cohort: Cohort) -> list[Table]:
    """Return the mean shares of each group as a table; none of animals that were recorded once."""
    exchanged = [changed for changed in cohort.changes if changed.tables]
    if not exchanged:
        return []
    means = {(changed, name): changed.means(name) for changed in exchanged for name in _QUANTITIES}
    columns = list(dict.fromkeys(component for shares in means.values() for component in shares.index))
    rows = [
        (_head(changed), _QUANTITIES[name], *(_signed(shares.loc[column]) if column in shares.index else "0"
                                              for column in columns))
        for (changed, name), shares in means.items()
    ]  # fmt: skip
    return [Table("", QUESTION, ("group", "quantity", *columns), rows, _NOTE)]


def _head(changed: GroupAttribution) -> str:
    absent = f"; {len(changed.failures)} more could not be exchanged" if changed.failures else ""
    return f"{short(changed.group)}, {changed.first} to {changed.last} (n = {len(changed.tables)}{absent})"


def _shares(changed: GroupAttribution) -> str:
    """Return the change of each quantity in a group and the largest share in it, or why that cannot be told."""
    if not changed.tables:
        return f"not told: {next(iter(changed.failures.values()))}"
    texts = []
    for name, called in _QUANTITIES.items():
        means = changed.means(name)
        component = str(means.iloc[1:]["mean"].abs().idxmax())
        largest = f"most by the {component} ({_signed(means.loc[[component]].iloc[0])})"
        texts.append(f"{called} {_signed(means.iloc[0])} {QUANTITIES[name].unit}, {largest}")
    return "; ".join(texts)


def _signed(row: pd.Series) -> str:
    value, low, high = row["mean"], row["low"], row["high"]
    text = with_interval(value, low, high) if np.isfinite(low) else number(value, 2)
    return text if text.startswith(("-", "−")) else f"+{text}"
