"""Panels set out in figures: one column for each group of animals, one legend for all."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Literal

from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.figures.matplotlib_style import NARROW, WIDEST, group_looks, new_figure, short

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TITLE = 88  # letters of the titles side by side
Share = Literal["none", "row"]
Panel = Callable[["Axes", AnimalResult, str], object]


def grid(cohort: Cohort, rows: int, height: float, columns: int, share: Share = "row") -> tuple["Figure", "np.ndarray"]:
    """Return an empty figure of `height` cm with its axes, shape (rows, columns).

    The axes of a single animal stand two abreast, in a figure that is as much lower.
    """
    if cohort.single and rows > 1:
        lines = -(-rows // 2)
        figure = new_figure(WIDEST, height * lines / rows)
        return figure, figure.subplots(lines, 2, squeeze=False).reshape(-1, 1)
    figure = new_figure(NARROW if columns == 1 else WIDEST, height)
    return figure, figure.subplots(rows, columns, squeeze=False, sharey=share)


def shown_figure(cohort: Cohort, panels: Sequence[Panel], height: float, share: Share = "row") -> "Figure":
    """Draw the panels, one row each, for the shown animal of each group, one column each."""
    figure, axes = grid(cohort, len(panels), height, len(cohort.groups), share)
    looks = group_looks(cohort.groups)
    for column, (group, result) in enumerate(cohort.shown.items()):
        for row, panel in enumerate(panels):
            panel(axes[row, column], result, looks[group].color)
        if not cohort.single:
            axes[0, column].set_title(name_above(cohort, group))
    return figure if share == "none" else outer(figure, axes)


def name_above(cohort: Cohort, group: str) -> str:
    """Return the name of a group's shown animal as a title above one of several columns, in two lines if it is long."""
    name, max_letters = cohort.name(group), _TITLE // len(cohort.groups)
    if len(name) <= max_letters:
        return name
    animal = cohort.shown[group].name
    return f"{short(animal, max_letters)}\n{short(name.removeprefix(animal).strip(), max_letters)}"


def outer(figure: "Figure", axes: "np.ndarray") -> "Figure":
    """Leave the labels of shared axes to the outer panels."""
    for ax in axes[:, 1:].flat:
        ax.set_ylabel("")
    return figure


def shared_legend(figure: "Figure", ax: "Axes", columns: int) -> "Figure":
    """Put the legend of `ax` above all panels, in place of their own."""
    for panel in figure.axes:
        without_legend(panel)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=columns)
    return figure


def without_legend(ax: "Axes") -> None:
    """Take away the legend of a panel."""
    if legend := ax.get_legend():
        legend.remove()
