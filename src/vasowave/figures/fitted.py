"""The panels of one fit, for a notebook: ``fit.plot.residuals()``."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vasowave.animal.result import AnimalResult
from vasowave.errors import InputError, did_you_mean
from vasowave.figures.fit import (
    plot_autocorrelation,
    plot_flow,
    plot_modulus,
    plot_pressure,
    plot_pressure_area,
    plot_residuals,
)
from vasowave.figures.rendering import as_file
from vasowave.figures.style import CTL, new_figure, shown_figure, style
from vasowave.io.files import check_file, write_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class FitPlots:
    """The panels of one fit. Each takes matplotlib axes, or makes a figure of its own, and returns the axes.

    Attributes
    ----------
    result : AnimalResult
        Of the animal, as `animal.analyze` returns it.
    color : str
        Of the wall laws' curves; data are black.
    shaded : bool
        Whether laws differ by shades of it as in the report, or by their dashes alone.
    """

    result: AnimalResult
    color: str = CTL
    shaded: bool = True

    def pressure(self, ax: "Axes | None" = None) -> "Axes":
        """Draw measured and fitted pressure at the inlet over one cycle."""
        return plot_pressure(ax or _axes(), self.result, self.color, self.shaded)

    def flow(self, ax: "Axes | None" = None) -> "Axes":
        """Draw measured and simulated flow at the inlet over one cycle."""
        return plot_flow(ax or _axes(), self.result, self.color, self.shaded)

    def residuals(self, ax: "Axes | None" = None) -> "Axes":
        """Draw measured minus simulated pressure over one cycle."""
        return plot_residuals(ax or _axes(), self.result, self.color, self.shaded)

    def autocorrelation(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the autocorrelation of the residuals."""
        return plot_autocorrelation(ax or _axes(), self.result, self.color, self.shaded)

    def pressure_area(self, ax: "Axes | None" = None) -> "Axes":
        """Draw pressure against area at the middle of the root vessel, and the wall law."""
        return plot_pressure_area(ax or _axes(), self.result, self.color, self.shaded)

    def impedance(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the modulus of the measured impedance by harmonic."""
        return plot_modulus(ax or _axes(), self.result.measured.impedance)

    def save(
        self,
        path: str | Path,
        panels: Sequence[str],
        *,
        width: float = 170.0,
        height: float = 60.0,
        font: float = 8.0,
        family: str = "sans-serif",
        color: str | None = None,
    ) -> Path:
        """Write panels side by side as one figure, ``fit.plot.save("fit.pdf", ["pressure", "impedance"])``.

        Parameters
        ----------
        path : path
            It ends in .svg, .pdf or .png.
        panels : sequence of str
            Names of the panels here, from left to right.
        width, height : float
            mm.
        font : float
            Size of the letters, pt.
        family : str
            Font: ``sans-serif``, ``serif``, ``monospace``, or the name of one that is installed.
        color : str, optional
            Of the wall laws' curves, ``"#d6259b"`` or a name that matplotlib knows, exactly so; data are black. Without
            one they have the shades of the report.

        Raises
        ------
        InputError
            No such panel, font or color, or the file cannot be written.
        """
        check_file(Path(path), ".svg", ".pdf", ".png")
        kind = Path(path).suffix.lower()[1:]
        content = figure_bytes(
            self.result, panels, kind, width=width, height=height, font=font, family=family, color=color
        )
        return write_file(Path(path), content)


_FAMILIES = ("sans-serif", "serif", "monospace")
"""Fonts that are everywhere."""

PANELS = ("pressure", "flow", "residuals", "autocorrelation", "pressure_area", "impedance")
"""Names of the panels of a fit."""


def figure_bytes(
    result: AnimalResult,
    panels: Sequence[str],
    kind: str,
    *,
    width: float,
    height: float,
    font: float,
    family: str = "sans-serif",
    color: str | None = None,
) -> bytes:
    """Return panels of a fit side by side as a file: svg, pdf or png. Sizes as `FitPlots.save`."""
    import matplotlib

    if not panels:
        raise InputError(f"a figure needs a panel; there are: {', '.join(PANELS)}")
    for name in panels:
        if name not in PANELS:
            raise InputError(f"there is no panel '{name}'{did_you_mean(name, PANELS)}; there are: {', '.join(PANELS)}")
    _check_look(family, color or CTL)
    letters: dict[str, object] = dict.fromkeys(("font.size", "axes.labelsize", "axes.titlesize"), font)
    letters |= dict.fromkeys(("legend.fontsize", "xtick.labelsize", "ytick.labelsize"), font - 1)
    letters["font.family"] = family
    with style(), matplotlib.rc_context(letters):  # type: ignore[arg-type]
        figure = new_figure(width / 10, height / 10)
        for ax, name in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
            getattr(FitPlots(result, color or CTL, shaded=color is None), name)(ax)
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


def _axes() -> "Axes":
    return shown_figure(12, 7.5).subplots()
