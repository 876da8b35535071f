"""The residual pressure of the wall laws in each harmonic: of every animal, of all together, and of the beats."""

from typing import TYPE_CHECKING

import numpy as np

from vasowave.cohort.cohort import Cohort
from vasowave.figures.marks import mark
from vasowave.figures.panels import shared_legend
from vasowave.figures.style import DATA, WIDEST, group_looks, label_axes, new_figure, plain_log

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LEAST = 1e-3  # mmHg, below which nothing is drawn


def discrepancy_figure(cohort: Cohort, tables: "Mapping[str, pd.DataFrame]") -> "Figure":
    """Residual by harmonic of every animal, and of all as `all_discrepancies` gives it; one panel a law."""
    figure = new_figure(WIDEST, 8)
    axes = figure.subplots(1, len(tables), squeeze=False, sharey=True)[0]
    for ax, (wall, table) in zip(axes, tables.items(), strict=True):
        _draw(ax, cohort, wall, table)
        ax.set_title(f"{wall} wall")
        ax.label_outer()
    return shared_legend(figure, axes[0], 4)


def _draw(ax: "Axes", cohort: Cohort, wall: str, table: "pd.DataFrame") -> None:
    looks = group_looks(cohort.groups)
    harmonic = table["harmonic"].to_numpy()
    for result in cohort.calibrated(wall):
        own = result.laws[wall].calibration["residual_modulus"].values[1 : len(harmonic) + 1]
        look = looks[result.group]
        (line,) = ax.plot(harmonic, np.maximum(own, _LEAST), color=look.color, linewidth=0.6, alpha=0.6)
        mark(line, f"{result.name} ({result.group})", result.name)
    left, common, error = (np.maximum(table[f"{what} [mmHg]"], _LEAST) for what in ("residual", "common", "error"))
    ax.plot(harmonic, left, color=DATA, label="left of the pressure, all animals")
    ax.plot(harmonic, common, color=DATA, linestyle=":", label="left alike in all")
    alike = table[table["alike"]]
    ax.plot(alike["harmonic"], alike["common [mmHg]"], "o", color=DATA, markersize=5, label="more than chance")
    ax.plot(harmonic, error, color="0.45", linestyle="--", label="error of beats")
    ax.set_yscale("log")
    plain_log(ax.yaxis)
    ax.locator_params(axis="x", integer=True)
    label_axes(ax, "harmonic [1]", "modulus [mmHg]")
