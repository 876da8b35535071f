"""The fits of many animals at one glance: a sheet of small panels, the worst first."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vasowave.animal.result import AnimalResult
from vasowave.figures.marks import mark
from vasowave.figures.style import DATA, SMALL, WIDEST, closed, group_looks, new_figure, short, source_looks, wall_lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ON_A_SHEET = 48  # animals
_ABREAST = 6  # fits in a row of a sheet
_POINTS = 128  # of a curve of 2.5 cm
_PANEL = 2.7  # cm, height of a panel with its title


def sheets(results: Sequence[AnimalResult]) -> list[list[AnimalResult]]:
    """Return the animals that were calibrated, those with the largest error first, as many as a sheet holds."""
    fitted = sorted((result for result in results if result.laws), key=_error, reverse=True)
    return [fitted[first : first + ON_A_SHEET] for first in range(0, len(fitted), ON_A_SHEET)]


def sheet_figure(results: Sequence[AnimalResult], groups: Sequence[str]) -> "Figure":
    """Draw measured and fitted pressure of up to `ON_A_SHEET` animals, each over one cycle in a panel of its own.

    Parameters
    ----------
    results : sequence of AnimalResult
    groups : sequence of str
        All groups of the study in their order, which sets the colors.
    """
    looks, rows = group_looks(groups), -(-len(results) // _ABREAST)
    height = _PANEL * rows + 0.8
    figure = new_figure(WIDEST, height)
    figure.set_layout_engine("none")  # nothing stands outside the panels
    room = {"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 1 - 0.8 / height, "wspace": 0.08, "hspace": 0.75}
    axes = figure.subplots(rows, _ABREAST, squeeze=False, gridspec_kw=room).ravel()
    for ax, result in zip(axes, results, strict=False):
        _draw(ax, result, looks[result.group].color)
    for ax in axes:
        ax.set_axis_off()
    return figure


def _draw(ax: "Axes", result: AnimalResult, color: str) -> None:
    pressure = result.recording["pressure"].values
    (line,) = ax.plot(*_thinned(pressure), color=DATA, linewidth=0.9)
    for wall, look in wall_lines(result.laws, color).items():
        inlet = result.laws[wall].simulated("pressure", result.root).values
        ax.plot(*_thinned(inlet), **(look | {"linewidth": 0.9}))
    looks = source_looks(result.laws)
    errors = ", ".join(f"{looks[wall].short} {error:.2f}" for wall, error in _errors(result).items())
    ax.set_title(f"{short(result.name, 16)}\n{errors}", fontsize=SMALL, pad=2)
    ax.text(0.98, 0.98, f"{pressure.min():.0f} to {pressure.max():.0f}", transform=ax.transAxes, fontsize=SMALL,
            ha="right", va="top")  # fmt: skip
    mark(line, f"{result.name} ({result.group}), RMSE [mmHg]: {errors}", result.name)


def _thinned(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return shares of the cycle and the values there, closed."""
    whole = closed(values)
    chosen = np.unique(np.linspace(0, len(whole) - 1, _POINTS).round().astype(int))
    return chosen / (len(whole) - 1), whole[chosen]


def _errors(result: AnimalResult) -> dict[str, float]:
    return {wall: law.rmse for wall, law in result.laws.items()}


def _error(result: AnimalResult) -> float:
    """Return the error of the law that fits best, mmHg; errors that rounding makes unlike are one, in any order."""
    return round(min(_errors(result).values()), 6)
