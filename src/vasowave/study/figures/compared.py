"""The figures that set groups of animals against each other: means, importance indices, ratios, power of a plan."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import pandas as pd

from vasowave.base.io.columns import split_unit
from vasowave.pulse.quantities import short_symbol
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.comparison import group_means
from vasowave.study.figures.groups import plot_cells, plot_groups, plot_importance, plot_ratios
from vasowave.study.figures.matplotlib_style import (
    FAINT,
    NARROW,
    WIDEST,
    color_stops,
    columns_that_fit,
    group_looks,
    label_axes,
    new_figure,
    short,
    source_looks,
    style,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from vasowave.study.cohort.planning import Plan


_LETTERS = 24
"""Of the smallest size, side by side below one of four panels."""
_DASHES = ("solid", (0, (5, 2)), (0, (1, 1)), (0, (5, 1, 1, 1)))


def means_figure(
    cohort: Cohort, quantities: dict[str, str], sources: Sequence[str], annotations: Mapping[str, Mapping[str, str]]
) -> "Figure":
    """Every animal, and means with their intervals, of quantities, one panel each ("ParOpt").

    Parameters
    ----------
    cohort : Cohort
    quantities : dict of str to str
        Column of the table to label of the axis.
    sources : sequence of str
        Of the table's column ``source``; each panel shows those that have the quantity.
    annotations : mapping of str to mapping of str to str
        By column what is written above each group.
    """
    table = _with_cells(cohort, cohort.table[cohort.table["source"].isin(sources)])
    columns = 4 if len(quantities) > 2 else len(quantities)
    rows = -(-len(quantities) // columns)
    figure = new_figure(WIDEST if columns == 4 else NARROW, 5.2 * rows)
    axes = figure.subplots(rows, columns, squeeze=False)
    looks = group_looks(cohort.groups), source_looks(cohort.sources)
    room = _LETTERS if columns > 1 else 2 * _LETTERS
    named = not cohort.crossed and sum(len(short(group, 14)) + 1 for group in cohort.groups) <= room
    if not named:
        _legend(figure, cohort, WIDEST if columns == 4 else NARROW)
    for ax, (quantity, label) in zip(axes.flat, quantities.items(), strict=False):
        name = split_unit(quantity)[0]
        means = {
            (group, source): mean for source in sources for group, mean in group_means(cohort, source, name).items()
        }
        known_rows = table[table[quantity].notna()]
        if cohort.crossed:
            cell_rows = table[table["source"].isin(known_rows["source"])]
            plot_cells(ax, cell_rows, quantity, label, looks, means, room)
        else:
            plot_groups(ax, known_rows, quantity, label, *looks, means=means, annotations=annotations.get(quantity),
                        named=named)  # fmt: skip
    for ax in axes.flat[len(quantities) :]:
        ax.remove()
    return figure


def _with_cells(cohort: Cohort, table: pd.DataFrame) -> pd.DataFrame:
    """Return the table with whose each recording is and in which cell it stands, cell after cell."""
    cells = {result.name: label for label, cell in cohort.cells.items() for result in cell.results}
    levels = {label: cell.level for label, cell in cohort.cells.items()}
    cell = table["animal"].map(cells)
    table = table.assign(subject=table["animal"].map(cohort.subjects), cell=cell, level=cell.map(levels))
    return table.sort_values("cell", key=lambda labels: labels.map([*cohort.cells].index), kind="stable")


def _legend(figure: "Figure", cohort: Cohort, width: float) -> None:
    """Say which group has which color, where names do not fit below the panels."""
    from matplotlib.lines import Line2D

    looks = group_looks(cohort.groups)
    names = {group: f"{short(group, 40)} ({cohort.counts(group)})" for group in cohort.groups}
    handles = [
        Line2D([], [], color=looks[group].color, marker=looks[group].marker, ls="", ms=4, label=name)
        for group, name in names.items()
    ]
    figure.legend(handles=handles, loc="outside upper left", ncols=columns_that_fit([*names.values()], width))


def importance_figure(cohort: Cohort, measured: pd.DataFrame, modeled: pd.DataFrame) -> "Figure":
    """Importance index of the data's indices and of the models' parameters ("ParAll_change")."""
    tables = [table for table in (measured, modeled) if len(table)]
    figure = new_figure(
        NARROW if len(tables) == 1 else WIDEST,
        max(5.0, 2.6 + 0.7 * max(table["quantity"].nunique() for table in tables)),
    )
    for ax, table in zip(figure.subplots(1, len(tables), squeeze=False)[0], tables, strict=True):
        plot_importance(ax, table, group_looks(cohort.groups), source_looks(cohort.sources))
    return figure


def ratios_figure(contrasts: pd.DataFrame) -> "Figure":
    """Ratios of geometric means with their intervals."""
    figure = new_figure(NARROW, 2.2 + 0.55 * len(contrasts))
    plot_ratios(figure.subplots(), contrasts)
    return figure


def planned_figure(plan: "Plan") -> "Figure":
    """Draw how often each quantity's effect is shown, by the animals of each group."""
    with style():
        figure = new_figure(NARROW, 7)
        ax = figure.subplots()
        ax.axhline(plan.settings.power, color=FAINT, lw=0.9)
        colors = color_stops(1 + len(plan.powers.columns))
        for place, (name, powers) in enumerate(plan.powers.items()):
            red, green, blue = (channel / 255 for channel in colors[place])
            ax.plot(powers.index, powers, color=(red, green, blue), ls=_DASHES[place % len(_DASHES)],
                    label=short_symbol(str(name)))  # fmt: skip
        ax.set_xscale("log")
        ax.set_xticks([3, 5, 10, 20, 40, 60], ["3", "5", "10", "20", "40", "60"])
        ax.minorticks_off()
        ax.set_ylim(0, 1.02)
        ax.legend(loc="lower right")
        label_axes(
            ax,
            "pairs [1]" if plan.settings.pairs is not None else "animals of each group [1]",
            f"power to show a ratio of {plan.settings.effect:g} [1]",
        )
    return figure
