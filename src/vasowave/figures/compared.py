"""The figures that set groups of animals against each other: means, importance indices, ratios."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import pandas as pd

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.group_means import group_means
from vasowave.figures.groups import plot_groups, plot_importance, plot_ratios
from vasowave.figures.style import NARROW, WIDEST, group_looks, new_figure, source_looks
from vasowave.io.columns import split_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def means_figure(
    cohort: Cohort, quantities: dict[str, str], sources: Sequence[str], said: Mapping[str, Mapping[str, str]]
) -> "Figure":
    """Every animal, and means with their intervals, of quantities, one panel each ("ParOpt").

    Parameters
    ----------
    cohort : Cohort
    quantities : dict of str to str
        Column of the table to label of the axis.
    sources : sequence of str
        Of the table's column ``source``; each panel shows those that have the quantity.
    said : mapping of str to mapping of str to str
        By column what is written above each group.
    """
    table = cohort.table[cohort.table["source"].isin(sources)]
    table = table.assign(subject=table["animal"].map(cohort.subjects))
    columns = 4 if len(quantities) > 2 else len(quantities)
    rows = -(-len(quantities) // columns)
    figure = new_figure(WIDEST if columns == 4 else NARROW, 5.2 * rows)
    axes = figure.subplots(rows, columns, squeeze=False)
    looks = group_looks(cohort.groups), source_looks(cohort.sources)
    for ax, (quantity, label) in zip(axes.flat, quantities.items(), strict=False):
        name = split_unit(quantity)[0]
        means = {
            (group, source): mean for source in sources for group, mean in group_means(cohort, source, name).items()
        }
        plot_groups(ax, table[table[quantity].notna()], quantity, label, *looks, means, said.get(quantity))
    for ax in axes.flat[len(quantities) :]:
        ax.remove()
    return figure


def importance_figure(cohort: Cohort, measured: pd.DataFrame, modeled: pd.DataFrame) -> "Figure":
    """Importance index of the data's indices and of the models' parameters ("ParAll_change")."""
    parts = [part for part in (measured, modeled) if len(part)]
    figure = new_figure(
        NARROW if len(parts) == 1 else WIDEST, max(5.0, 2.6 + 0.7 * max(part["quantity"].nunique() for part in parts))
    )
    for ax, part in zip(figure.subplots(1, len(parts), squeeze=False)[0], parts, strict=True):
        plot_importance(ax, part, group_looks(cohort.groups), source_looks(cohort.sources))
    return figure


def ratios_figure(contrasts: pd.DataFrame) -> "Figure":
    """Ratios of geometric means with their intervals."""
    figure = new_figure(NARROW, 2.2 + 0.55 * len(contrasts))
    plot_ratios(figure.subplots(), contrasts)
    return figure
