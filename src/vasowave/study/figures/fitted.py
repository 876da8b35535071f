"""The panels of one fit, for a notebook: ``fit.plot.residuals()``."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.io.files import check_file, write_file
from vasowave.study.animal.result import AnimalResult, FitPlots
from vasowave.study.figures.fit import PANELS
from vasowave.study.figures.matplotlib_style import CTL, new_figure, shown_figure, style
from vasowave.study.figures.rendering import as_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def plot_panel(panels: FitPlots, name: str, ax: "Axes | None" = None) -> "Axes":
    """Draw a panel into axes, or a new figure; returns the axes."""
    draw = PANELS[checked_panel(name)].draw
    return draw(ax or shown_figure(12, 7.5).subplots(), panels.result, panels.color or CTL, panels.shaded)


def checked_panel(name: str) -> str:
    """Return the name of a panel; `InputError` if there is none."""
    if name not in PANELS:
        raise InputError(f"there is no panel '{name}'{did_you_mean(name, PANELS)}; there are: {', '.join(PANELS)}")
    return name


def save_panels(shown: FitPlots, path: str | Path, panels: Sequence[str], **appearance: Any) -> Path:
    """Write panels side by side as one figure, see `FitPlots.save`."""
    check_file(Path(path), ".svg", ".pdf", ".png")
    content = figure_bytes(shown.result, panels, Path(path).suffix.lower()[1:], Appearance(**appearance))
    return write_file(Path(path), content)


_FAMILIES = ("sans-serif", "serif", "monospace")
"""Fonts that are everywhere."""


@dataclass(frozen=True)
class Appearance:
    """Size of a figure (mm) and of its letters (points), their family, and the color of curves, as `FitPlots.save`."""

    width: float = 170.0
    height: float = 60.0
    font: float = 8.0
    family: str = "sans-serif"
    color: str | None = None


def figure_bytes(result: AnimalResult, panels: Sequence[str], kind: str, appearance: Appearance) -> bytes:
    """Return panels of a fit side by side as a file: svg, pdf or png."""
    import matplotlib

    if not panels:
        raise InputError(f"a figure needs a panel; there are: {', '.join(PANELS)}")
    drawn = [PANELS[checked_panel(name)] for name in panels]
    font, color = appearance.font, appearance.color
    _check_look(appearance.family, color or CTL)
    letters: dict[str, object] = dict.fromkeys(("font.size", "axes.labelsize", "axes.titlesize"), font)
    letters |= dict.fromkeys(("legend.fontsize", "xtick.labelsize", "ytick.labelsize"), font - 1)
    letters["font.family"] = appearance.family
    with style(), matplotlib.rc_context(letters):  # type: ignore[arg-type]
        figure = new_figure(appearance.width / 10, appearance.height / 10)
        for ax, panel in zip(figure.subplots(1, len(panels), squeeze=False)[0], drawn, strict=True):
            panel.draw(ax, result, color or CTL, color is None)
        return as_file(figure, kind)


def _check_look(family: str, color: str) -> None:
    from matplotlib.colors import is_color_like
    from matplotlib.font_manager import findfont

    if not is_color_like(color):
        raise InputError(f"'{color}' is no color; write #rrggbb or a name that matplotlib knows")
    if family in _FAMILIES:
        return
    try:
        findfont(family, fallback_to_default=False)
    except ValueError:
        raise InputError(f"there is no font '{family}' here; take one of: {', '.join(_FAMILIES)}") from None
