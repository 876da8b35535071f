"""A calibrated model with what its data leave open: other models that they allow as well."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from vasowave.base.accessors import Accessor
from vasowave.base.descriptions import MAX_LOG_DISTANCE, NORMAL
from vasowave.base.errors import InputError
from vasowave.pulse.analysis.sensitivity_table import Sensitivity
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.cycle.cycle import Inflow
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.outlets import Outlets
from vasowave.pulse.model.parameters import with_parameters

BY_FIT = (
    "intervals hold what the recording leaves open of the parameters; errors of image and instruments, and a stiffness "
    "that changes along the tree, are not in them: fit with a posterior for these (inference: reference)"
)
BY_POSTERIOR = (
    "intervals are those of the posterior's draws, with the errors of image and instruments that it knows; those of "
    "single vessels are the image's"
)
_TRIALS = 64  # sets of parameters for each that is asked for, of which those within the bounds are taken


@dataclass(frozen=True, eq=False)
class UncertainModel:
    """A model, what flows into it, and how far its data determine its parameters.

    Attributes
    ----------
    model : Model
        The optimum.
    inflow : Inflow
        What enters it.
    parameters : DataFrame
        As `Fit.parameters`: ``value, standard_error_correlated, interval_low, interval_high, lower, upper, at_bound``
        of each; the intervals are those of the posterior where there are its draws.
    correlation : DataFrame
        Of the free ones' estimates.
    beds : Outlets
        The beds that the factors among the parameters are of.
    drawn : tuple of (Model, Inflow)
        Draws of a posterior; empty where there is none that may be believed.
    numerics : Numerics
        How finely the fit was simulated; so is what follows from it.

    Examples
    --------
    >>> import vasowave as vw
    >>> mouse = vw.Animal("mouse 6", "CTL", vw.control_network(), vw.virtual_mouse(), synthetic=True)
    >>> stored = vw.stored_fit(vw.analyze(mouse, vw.Settings(walls=("linear",), starts=1)))
    >>> vw.predict(stored, {"R_T": 0.7}, draws=4).table.loc["mPAP", "unit"]
    'mmHg'
    """

    model: Model
    inflow: Inflow
    parameters: pd.DataFrame
    correlation: pd.DataFrame
    beds: Outlets
    drawn: tuple[tuple[Model, Inflow], ...] = ()
    numerics: Numerics = field(default_factory=Numerics)

    def __repr__(self) -> str:
        values = ", ".join(f"{name} {row['value']:.4g}" for name, row in self.parameters.iterrows())
        draws = f"{len(self.drawn)} draws of its posterior" if self.drawn else "errors of the fit"
        return f"UncertainModel({type(self.model.wall).__name__}: {values}; {draws})"

    @property
    def free(self) -> pd.DataFrame:
        """The free parameters that lie at no bound of their search."""
        table = self.parameters.loc[self.correlation.index]
        return table[~table["at_bound"].to_numpy(bool)]

    def log_spread(self, table: pd.DataFrame) -> np.ndarray:
        """Return the SD of the logarithms of parameters, finite where the data do not determine one."""
        spread = (table["standard_error_correlated"] / table["value"]).fillna(np.inf).to_numpy(float)
        return np.minimum(spread, MAX_LOG_DISTANCE / NORMAL)

    def with_values(self, values: Mapping[str, float]) -> Model:
        """Return the model with other values of its parameters."""
        return with_parameters(self.model, values, self.beds)

    @Accessor
    def sensitivity(
        self, box: Mapping[str, tuple[float, float]] | None = None, *, samples: int = 4096, seed: int = 0
    ) -> Sensitivity:
        """Return which parameter matters for which quantity, as `Fit.sensitivity`."""
        raise NotImplementedError

    def draws(self, count: int, seed: int) -> Iterator[tuple[Model, Inflow] | None]:
        """Yield what the data allow: draws of the posterior, else by the errors of the fit; None for what cannot be."""
        if self.drawn:
            chosen = np.random.default_rng(seed).permutation(len(self.drawn))[:count]
            yield from (self.drawn[row] for row in chosen)
            return
        for values in self._by_errors(count, seed):
            try:
                yield self.with_values(values), self.inflow
            except InputError:
                yield None

    def _by_errors(self, count: int, seed: int) -> list[dict[str, float]]:
        """Return sets of parameters, normal in their logarithms, in pairs about the optimum.

        As in the fit's intervals a parameter at a bound stays there; what lies outside of the bounds is drawn again.
        """
        table, moving = self.parameters.loc[self.correlation.index], self.free
        if moving.empty:
            return []
        spread = np.minimum(self.log_spread(table), np.log((table["upper"] / table["lower"]).to_numpy(float)))
        covariance = self.correlation.to_numpy(float) * np.outer(spread, spread) + 1e-10 * np.diag(spread**2)
        rows = table.index.get_indexer(moving.index)
        of_moving = np.linalg.inv(np.linalg.inv(covariance)[np.ix_(rows, rows)])
        half = np.random.default_rng(seed).normal(size=(_TRIALS * count, len(rows)))
        scores = np.stack([half, -half], axis=1).reshape(-1, len(rows)) @ np.linalg.cholesky(of_moving).T
        drawn = moving["value"].to_numpy(float) * np.exp(scores)
        limits = moving[["lower", "upper"]].to_numpy(float)
        inside = ((drawn >= limits[:, 0]) & (drawn <= limits[:, 1])).all(axis=1)
        values = {str(name): float(value) for name, value in self.parameters["value"].items()}
        names = [str(name) for name in moving.index]
        return [values | dict(zip(names, map(float, row), strict=True)) for row in drawn[inside][:count]]


def uncertain_model(fit: Any) -> UncertainModel:
    """Return a fit with what its data leave open; raises `InputError` for what is none."""
    if isinstance(fit, UncertainModel):
        return fit
    if not isinstance(fit, CalibratedModel):
        raise InputError(
            f"{type(fit).__name__} was given where a fit is needed; fit the animal (vasowave.calibrate), or take a "
            "stored one: vasowave.stored_fit"
        )
    network = fit.model.network
    inlet = fit.simulation.sel(vessel=network.name[network.root], station="inlet")
    inflow = Inflow(inlet["flow"].to_numpy(), float(fit.simulation.attrs["period"]))
    beds, numerics = fit.nominal.outlets, fit.numerics
    return UncertainModel(fit.model, inflow, fit.parameters, fit.correlation, beds, numerics=numerics)
