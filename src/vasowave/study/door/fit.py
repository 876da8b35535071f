"""A calibrated model with what parts above calibration make of it: tables, figures, posterior, report."""

from collections.abc import Callable
from dataclasses import fields
from functools import cached_property, wraps
from pathlib import Path
from typing import Any, ParamSpec

import pandas as pd

from vasowave.pulse.calibration import fitting
from vasowave.pulse.calibration.fitting import Search
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.inference.priors import Priors
from vasowave.pulse.inference.result import Posterior
from vasowave.pulse.inference.sampling import posterior
from vasowave.study.animal.files import write_result
from vasowave.study.animal.pipeline import result_of_fit
from vasowave.study.animal.result import AnimalResult, FitPlots
from vasowave.study.report.write import write_report

P = ParamSpec("P")


class Fit(CalibratedModel):
    """A model calibrated to one recording: values of `CalibratedModel`, tables, figures and report.

    Examples
    --------
    >>> import vasowave as vw
    >>> fit = vw.calibrate(vw.control_network(), vw.virtual_mouse(), search=vw.Search(starts=1))
    >>> fit.plot.residuals().get_ylabel()
    'residual pressure [mmHg]'
    >>> fit.summary().loc["wave_speed", "unit"]
    'cm/s'
    """

    @cached_property
    def result(self) -> AnimalResult:
        """Everything about the animal, as `analyze` returns it."""
        return result_of_fit(self)

    @property
    def plot(self) -> FitPlots:
        """Panels: ``fit.plot.pressure(ax)``, ``residuals``, ``autocorrelation``, ``pressure_area``, ``impedance``."""
        return FitPlots(self.result)

    def summary(self) -> pd.DataFrame:
        """Return parameters and what follows from them, one a row: ``value, low, high`` (95 %), ``unit``.

        The interval is NaN where nothing tells it.
        """
        return self.result.laws[self.wall].summary()

    def sample(self, **settings: Any) -> Posterior:
        """Return the posterior of the same animal, law and beds; the settings are those of `posterior`: ``draws=200``.

        Parameters that the fit held at a value stay there.
        """
        held = {str(name): float(row["value"]) for name, row in self.parameters.iterrows() if not row["free"]}
        sites = self.compared.sites
        arguments: dict[str, Any] = {
            "bed": type(self.model.outlets),
            "fit": self,
            "blood": self.model.blood,
            "search": Search(fixed=held, enters=self.compared.enters),
            "sites": () if sites is None else sites.observations,
        }
        if self.response:
            sds: dict[str, Any] = {f"{name}_sd": estimate.prior for name, estimate in self.response.items()}
            arguments["priors"] = Priors(**sds)
        return posterior(self.model.network, self.recording, type(self.model.wall), **arguments | settings)

    def to_netcdf(self, path: str | Path) -> Path:
        """Write `result` as netCDF-4, one group a part; returns the path.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        write_result(self.result, Path(path))
        return Path(path)

    def report(self, folder: str | Path, *, pdf: bool = False) -> Path:
        """Write the report of this fit into `folder` and return its page.

        The folder holds no results; `vasowave fit` keeps those that `vasowave posterior` and others go on from.

        Raises
        ------
        InputError
            The folder holds another report or cannot be written.
        """
        return write_report([self.result], Path(folder), pdf=pdf)


def _with_methods(calibrated: Callable[P, CalibratedModel]) -> Callable[P, Fit]:
    @wraps(calibrated)
    def calibrate(*args: P.args, **kwargs: P.kwargs) -> Fit:
        fit = calibrated(*args, **kwargs)
        return Fit(**{field.name: getattr(fit, field.name) for field in fields(fit)})

    return calibrate


calibrate = _with_methods(fitting.calibrate)
