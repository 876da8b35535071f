"""The figures that set groups of animals against each other: boxes, importance indices, ratios."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import pandas as pd

from vasowave.cohort.cohort import Cohort
from vasowave.figures.groups import plot_groups, plot_importance, plot_ratios
from vasowave.figures.style import WIDEST, group_looks, new_figure, source_looks

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def boxes_figure(cohort: Cohort, quantities: dict[str, str], sources: Sequence[str]) -> "Figure":
    """Box-and-whisker plots of quantities, one panel each ("ParOpt"); sources differ by their hatch.

    Parameters
    ----------
    cohort : Cohort
    quantities : dict of str to str
        Column of the table to label of the axis.
    sources : sequence of str
        Of the table's column ``source``; each panel shows those that have the quantity.
    """
    table = cohort.table[cohort.table["source"].isin(sources)]
    columns = min(len(quantities), 4)
    rows = -(-len(quantities) // columns)
    width = max(4.3, 1.6 + 0.75 * len(cohort.groups) * len(sources))
    figure = new_figure(min(WIDEST, max(8.0, width * columns)), 5.2 * rows)
    axes = figure.subplots(rows, columns, squeeze=False)
    looks = group_looks(cohort.groups), source_looks(cohort.sources)
    for ax, (quantity, label) in zip(axes.flat, quantities.items(), strict=False):
        plot_groups(ax, table[table[quantity].notna()], quantity, label, *looks)
    for ax in axes.flat[len(quantities) :]:
        ax.remove()
    return figure


def importance_figure(cohort: Cohort, measured: pd.DataFrame, modeled: pd.DataFrame) -> "Figure":
    """Importance index of the data's indices and of the models' parameters ("ParAll_change")."""
    parts = [part for part in (measured, modeled) if len(part)]
    figure = new_figure(
        WIDEST / 2 * len(parts), max(5.0, 2.6 + 0.85 * max(part["quantity"].nunique() for part in parts))
    )
    for ax, part in zip(figure.subplots(1, len(parts), squeeze=False)[0], parts, strict=True):
        plot_importance(ax, part, group_looks(cohort.groups), source_looks(cohort.sources))
    return figure


def ratios_figure(contrasts: pd.DataFrame) -> "Figure":
    """Ratios of geometric means with their intervals."""
    figure = new_figure(15, 2.2 + 0.55 * len(contrasts))
    plot_ratios(figure.subplots(), contrasts)
    return figure
