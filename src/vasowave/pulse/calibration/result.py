"""What a calibration returns: the optimum, how well the data determine it, and how it was found."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.descriptions import AT_BOUND, MOST_LEFT, parameter_mark
from vasowave.base.findings import Finding, texts
from vasowave.base.notebook import card
from vasowave.pulse.calibration.compared import Compared
from vasowave.pulse.calibration.response import Response, in_words
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.nominal import Nominal
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.solver.validity import STRAINED


@dataclass(frozen=True, eq=False)
class CalibratedModel:
    """A model calibrated to one recording.

    Attributes
    ----------
    wall : str
        Name of the wall law.
    model : Model
        The model at the optimum.
    compared : Compared
        What of the recording entered the model, and the harmonics that were compared.
    nominal : Nominal
        Where the starts came from.
    parameters : DataFrame
        One row per parameter (index: the wall law's, then the beds' factors), columns ``unit, nominal, lower, upper,
        value, standard_error`` (if every sample had independent noise), ``standard_error_correlated`` (for the smooth
        noise that the residual shows, `noise.spectrum`), ``interval_low, interval_high`` (95 %, from the latter),
        ``at_bound, free, determined``.
    correlation : DataFrame
        Correlation of the free parameters' estimates.
    starts : DataFrame
        One row per start: ``start, S [mmHg2], simulations, converged, agrees, message`` and every parameter's value.
    simulation : Dataset
        The calibrated model's cycle, as `simulate` returns it.
    residual : array, shape (N,)
        Measured minus simulated pressure at the inlet, mmHg, at the samples that were compared; where the pressure
        enters the model that of the flow, each ml/s counted as `compared.scale` mmHg.
    S : float
        Objective (eq. 14) at the optimum, mmHg²: a sum over N samples, so that only `mean_square` compares with fits to
        other numbers of them. Further sites are not in it; they are in that of the starts.
    findings : tuple of Finding
        What a reader must know: parameters at a bound, not determined, starts that disagree. What was noticed of the
        recording stands with it.
    sites : Dataset, optional
        What was observed at further sites, simulated, and predicted by the fit without each of them; and what that fit
        says of the parameters. See `beside.what_sites_add`.
    response : dict
        Lag (``pressure_lag``, s) and inertia (``pressure_inertia``, s²) of amplifier and catheter where fitted
        (`Fitting`): ``value, error, prior``. The simulation is the pressure before them, the residual behind them.
    numerics : Numerics
        How finely it was simulated; what follows from a fit is simulated as finely.

    Examples
    --------
    >>> import vasowave as vw
    >>> fit = vw.calibrate(vw.control_network(), vw.virtual_mouse(), search=vw.Search(starts=1))
    >>> fit.parameters.loc["beta", ["interval_low", "value", "interval_high"]].is_monotonic_increasing
    True
    """

    wall: str
    model: Model
    compared: Compared
    nominal: Nominal
    parameters: pd.DataFrame
    correlation: pd.DataFrame
    starts: pd.DataFrame
    simulation: xr.Dataset
    residual: np.ndarray
    S: float
    findings: tuple[Finding, ...]
    sites: xr.Dataset | None = None
    response: Response = field(default_factory=dict)
    numerics: Numerics = field(default_factory=Numerics)

    def __repr__(self) -> str:
        values = ", ".join(f"{name} {row['value']:.4g}{_mark(row)}" for name, row in self.parameters.iterrows())
        stopped = f"; {AT_BOUND} at a bound of its search" if AT_BOUND in values else ""
        values += in_words(self.response)
        first = f", {self.misses}; do not use its numbers" if self.misses else ""
        return f"Fit({self.wall} wall{first}: {values}; S {self.S:.4g}, N {self.N}, RMSE {self.rmse:.3g} mmHg{stopped})"

    def _repr_html_(self) -> str:
        facts = {"do not use": self.misses} if self.misses else {}
        facts |= {
            f"{name} [{row['unit']}]" if row["unit"] != "1" else str(name): f"{row['value']:.4g}{_mark(row)} "
            f"[{row['interval_low']:.3g}, {row['interval_high']:.3g}]{'' if row['free'] else ' (held)'}"
            for name, row in self.parameters.iterrows()
        }
        facts["intervals"] = "by the recording alone; fit.summary() allows for errors of image, probe and zero, too"
        facts["S"] = (
            f"{self.S:.4g} mmHg² over {self.N} samples (harmonics 0 to {self.compared.harmonics}); root mean square "
            f"{self.rmse:.3g} mmHg"
        )
        facts["starts"] = (
            f"{int(self.starts['agrees'].sum())} of {len(self.starts)} came to this optimum or into its bowl"
        )
        return card(
            f"Fit, {self.wall} wall: {self.model.wall.law().formula}",
            facts,
            texts((*self.recording.notes, *self.findings)),
        )

    @property
    def recording(self) -> Recording:
        """The recording as it was given."""
        return self.compared.recording

    @property
    def N(self) -> int:
        """Number of samples that were compared."""
        return len(self.residual)

    @property
    def mean_square(self) -> float:
        """Mean square of the residual, mmHg²: S/N."""
        return self.S / self.N

    @property
    def harmonics(self) -> pd.DataFrame:
        """Measurement, its error, residual and discrepancy in each harmonic, mmHg; see `Compared.spectrum`."""
        return self.compared.spectrum(self.residual)

    @property
    def rmse(self) -> float:
        """Root-mean-square residual, mmHg."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def misses(self) -> str:
        """Why its numbers must not be used, in words, as the report says; empty where they may be.

        It leaves more than `MOST_LEFT` of the pulse pressure, and more than the error of the cycle, or strains a vessel
        beyond what an artery survives.
        """
        share = self.rmse / self.recording.pulse_pressure
        if share > MOST_LEFT and self.mean_square > self.compared.error_power().sum():
            return f"misses the data by {100 * share:.2g} % of the pulse pressure"
        strained = any(finding.code == STRAINED.code for finding in self.findings)
        return "strains a vessel beyond what an artery survives" if strained else ""

    @property
    def total_resistance(self) -> float:
        """Resistance R_T of all vascular beds in parallel, mmHg s/ml."""
        return self.model.outlets.total_resistance()

    @property
    def resistance_ratio(self) -> float:
        """Ratio a = R1/R_T of the vascular beds."""
        return self.model.outlets.resistance_ratio()

    @property
    def peripheral_compliance(self) -> float:
        """Weighted compliance Σ Ĉ_p of the vascular beds, ml/mmHg."""
        return float(self.model.outlets.weighted_compliance().sum())


def _mark(row: pd.Series) -> str:
    return parameter_mark(*row[["free", "at_bound", "determined"]])
