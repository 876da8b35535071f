"""A calibrated model with what parts above calibration make of it: tables, figures, posterior, report."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from functools import cached_property, wraps
from pathlib import Path
from typing import Any, ParamSpec

import pandas as pd

from vasowave.pulse.analysis.sensitivity_table import Sensitivity
from vasowave.pulse.calibration import fitting
from vasowave.pulse.calibration.fitting import Search
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.inference.measurements import ExpectedPrecision, expected_precision
from vasowave.pulse.inference.priors import Priors
from vasowave.pulse.inference.result import Posterior
from vasowave.pulse.inference.sampling import posterior
from vasowave.pulse.inference.sensitivity_of_fits import sensitivity_of
from vasowave.pulse.model.walls import WALL_VISCOSITY
from vasowave.pulse.network.network import Network
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

        Parameters that the fit held at a value stay there, as many harmonics are compared, and as finely is simulated.
        """
        return posterior(*self._animal, fit=self, **self._sampling | settings)

    @property
    def _animal(self) -> tuple[Network, Recording, type]:
        return self.model.network, self.recording, type(self.model.wall)

    @property
    def _sampling(self) -> dict[str, Any]:
        """Settings of a posterior of the same animal, law and beds, with what the fit compared."""
        compared, sites = self.compared, self.compared.sites
        harmonics = compared.harmonics if compared.choice == "given" else compared.choice
        viscous = WALL_VISCOSITY in self.parameters.index
        held = {str(name): float(row["value"]) for name, row in self.parameters.iterrows() if not row["free"]}
        arguments: dict[str, Any] = {
            "bed": type(self.model.outlets),
            "blood": self.model.blood,
            "search": Search(fixed=held, pressure_harmonics=harmonics, viscous=viscous, enters=compared.enters),
            "numerics": self.numerics,
            "sites": () if sites is None else sites.observations,
        }
        if self.response:
            sds: dict[str, Any] = {f"{name}_sd": estimate.prior for name, estimate in self.response.items()}
            arguments["priors"] = Priors(**sds)
        return arguments

    def expected_precision(
        self, vessels: Sequence[str] | None = None, *, beats: int = 4, **settings: Any
    ) -> ExpectedPrecision:
        """Return what a second site, a wedge pressure, a better image or more beats would add.

        Parameters
        ----------
        vessels : sequence of str, optional
            Where a second pressure could be recorded, each once; by default the daughters of the root.
        beats : int
            How many times as many beats.
        settings
            Those of `posterior`, whose intervals are foretold, in place of those of the fit; see
            `vasowave.expected_precision`.
        """
        start = {str(name): float(value) for name, value in self.parameters["value"].items()}
        arguments = self._sampling | settings
        return expected_precision(*self._animal, vessels=vessels, beats=beats, start=start, **arguments)

    def sensitivity(
        self, box: Mapping[str, tuple[float, float]] | None = None, *, samples: int = 4096, seed: int = 0
    ) -> Sensitivity:
        """Return which parameter matters for which quantity: Sobol' indices, by an emulator that is made for them.

        Parameters
        ----------
        box : mapping of str to (float, float), optional
            Lowest and highest value of parameters, as the intervals of a posterior or those of a prior, within the
            bounds of the fit. By default, and of those that it does not name, the 95 % intervals of the fit, as far as
            an emulator reaches (`emulate`).
        samples, seed : int
            As of `ModelEmulator.sensitivity`.

        Raises
        ------
        InputError
            No free parameter, a range that is none or reaches beyond the bounds, samples that are no power of 2.
        NumericalError
            Models in the box cannot be simulated.
        """
        return sensitivity_of(self, box, samples=samples, seed=seed)

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
