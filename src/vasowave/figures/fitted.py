"""The panels of one fit, for a notebook: ``fit.plot.residuals()``."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from vasowave.animal.result import AnimalResult
from vasowave.figures.fit import plot_autocorrelation, plot_pressure, plot_residuals
from vasowave.figures.loop import plot_pressure_area
from vasowave.figures.spectra import plot_modulus
from vasowave.figures.style import shown_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class FitPlots:
    """The panels of one fit. Each takes matplotlib axes, or makes a figure of its own, and returns the axes.

    Attributes
    ----------
    result : AnimalResult
        Of the animal, as `animal.analyze` returns it.
    """

    result: AnimalResult

    def pressure(self, ax: "Axes | None" = None) -> "Axes":
        """Draw measured and fitted pressure at the inlet over one cycle."""
        return plot_pressure(ax or _axes(), self.result)

    def residuals(self, ax: "Axes | None" = None) -> "Axes":
        """Draw measured minus simulated pressure over one cycle."""
        return plot_residuals(ax or _axes(), self.result)

    def autocorrelation(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the autocorrelation of the residuals."""
        return plot_autocorrelation(ax or _axes(), self.result)

    def pressure_area(self, ax: "Axes | None" = None) -> "Axes":
        """Draw pressure against area at the middle of the root vessel, and the wall law."""
        return plot_pressure_area(ax or _axes(), self.result)

    def impedance(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the modulus of the measured impedance by harmonic."""
        return plot_modulus(ax or _axes(), self.result.measured.impedance)


def _axes() -> "Axes":
    return shown_figure(12, 7.5).subplots()
