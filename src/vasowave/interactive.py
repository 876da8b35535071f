"""What `vw.calibrate` returns: a fit that draws and reports itself."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, wraps
from pathlib import Path
from typing import TYPE_CHECKING, ParamSpec

import xarray as xr

from vasowave import calibration
from vasowave.animal.animal import Animal, Settings
from vasowave.animal.pipeline import result_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_Given = ParamSpec("_Given")


@dataclass(frozen=True, eq=False)
class FitPlots:
    """The panels of one fit. Each takes matplotlib axes, or makes a figure of its own, and returns the axes.

    Attributes
    ----------
    result : DataTree
        Of the animal, as `animal.analyze` returns it.
    """

    result: xr.DataTree

    def pressure(self, ax: "Axes | None" = None) -> "Axes":
        """Draw measured and fitted pressure at the inlet over one cycle."""
        from vasowave.figures.fit import plot_pressure

        return plot_pressure(ax or _axes(), self.result)

    def residuals(self, ax: "Axes | None" = None) -> "Axes":
        """Draw measured minus simulated pressure over one cycle."""
        from vasowave.figures.fit import plot_residuals

        return plot_residuals(ax or _axes(), self.result)

    def autocorrelation(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the autocorrelation of the residuals."""
        from vasowave.figures.fit import plot_autocorrelation

        return plot_autocorrelation(ax or _axes(), self.result)

    def pressure_area(self, ax: "Axes | None" = None) -> "Axes":
        """Draw pressure against area at the middle of the root vessel, and the wall law."""
        from vasowave.figures.loop import plot_pressure_area

        return plot_pressure_area(ax or _axes(), self.result)

    def impedance(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the modulus of the measured impedance by harmonic."""
        from vasowave.animal.reading import data_of
        from vasowave.figures.spectra import plot_modulus

        return plot_modulus(ax or _axes(), data_of(self.result, "measured/impedance"))


class Fit(calibration.Fit):
    """A model calibrated to one recording; see `calibration.Fit` for what it holds.

    Attributes
    ----------
    plot : FitPlots
        Panels: ``fit.plot.pressure(ax)``, ``residuals``, ``autocorrelation``, ``pressure_area``, ``impedance``.

    Examples
    --------
    >>> import vasowave as vw
    >>> fit = vw.calibrate(vw.control_network(), vw.virtual_mouse(), search=vw.Search(starts=1))
    >>> fit.parameters.loc["beta", ["interval_low", "value", "interval_high"]].is_monotonic_increasing
    True
    >>> fit.plot.residuals().get_ylabel()
    'residual pressure [mmHg]'
    """

    @cached_property
    def result(self) -> xr.DataTree:
        """Everything about the animal as labelled data, as `animal.analyze` returns it."""
        animal = Animal("animal", "animal", self.model.network, self.recording)
        return result_of(animal, [self], Settings(walls=(self.wall,), starts=len(self.starts), blood=self.model.blood))

    @property
    def plot(self) -> FitPlots:
        """The panels of this fit."""
        return FitPlots(self.result)

    def report(self, folder: str | Path, *, pdf: bool = False) -> Path:
        """Write the report of this fit into `folder` and return its page.

        Raises
        ------
        InputError
            The folder holds another report or cannot be written.
        """
        from vasowave.report.write import write_report

        return write_report([self.result], Path(folder), pdf=pdf)


def _richer(calibrate: Callable[_Given, calibration.Fit]) -> Callable[_Given, Fit]:
    @wraps(calibrate)
    def calibrated(*args: _Given.args, **given: _Given.kwargs) -> Fit:
        return Fit(**vars(calibrate(*args, **given)))

    return calibrated


def _axes() -> "Axes":
    from vasowave.figures.style import new_figure

    return new_figure(12, 7.5).subplots()


calibrate = _richer(calibration.calibrate)
