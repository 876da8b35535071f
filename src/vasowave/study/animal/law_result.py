"""The results of the recording and of every wall law of an animal, as values."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.descriptions import TAILS
from vasowave.base.findings import Finding, from_json

OVERSTRAINED_CODE = "solver.vessel-overstrained"
"""Code of the finding of a law that explains the data by vessels that no artery could be."""
SITE_DOUBTS = ("fit.site-unit", "fit.site-apart")
"""Codes of the findings that a further site speaks against the recording at the inlet."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Measured:
    """The results of the recording, or of a wall law's model in its place.

    Attributes
    ----------
    waves : Dataset
        Separated waves and wave intensity at the inlet of the root.
    impedance : Dataset
        Spectrum, and estimates of Z_c.
    quantities : Dataset
        Single numbers, see `vasowave.pulse.quantities`; those that were fitted with their 95 % interval as attributes.
    """

    waves: xr.Dataset
    impedance: xr.Dataset
    quantities: xr.Dataset

    @property
    def numbers(self) -> str:
        """Those that a person looks for first, with their units."""
        rows = self.summary().reindex(self._first).dropna(subset="value")
        return ", ".join(f"{name} {row['value']:.4g} {row['unit']}".removesuffix(" 1") for name, row in rows.iterrows())

    @property
    def _first(self) -> list[str]:
        return ["HR", "CO", "mPAP", "sPAP", "dPAP", "PVR"]

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.numbers})"

    def _repr_html_(self) -> str:
        return self.summary().to_html(float_format="{:.4g}".format, na_rep="")

    def summary(self) -> pd.DataFrame:
        """Return the single numbers, one a row: ``value, low, high`` (95 %), ``unit``.

        The interval is NaN where nothing tells it. What a number means is the ``long_name`` of its `quantities`.
        """
        columns = ("low", "interval_low", np.nan), ("high", "interval_high", np.nan), ("unit", "units", "")
        rows = [{"value": float(quantity)} | {column: quantity.attrs.get(key, none) for column, key, none in columns}
                for quantity in self.quantities.data_vars.values()]  # fmt: skip
        return pd.DataFrame(rows, pd.Index(list(map(str, self.quantities.data_vars)), name="quantity"))


@dataclass(frozen=True, eq=False)
class PosteriorResult:
    """The posterior of one wall law.

    Attributes
    ----------
    table : Dataset
        By ``quantity``: median, interval, prior, shares of the variance; by ``block`` of harmonics what is left out;
        diagnostics. Attributes ``trusted, findings``.
    groups : dict of str to Dataset
        Those that ArviZ reads: ``posterior, prior, sample_stats, posterior_predictive, observed_data``.
    """

    table: xr.Dataset
    groups: Mapping[str, xr.Dataset]

    @property
    def trusted(self) -> bool:
        """Whether the numbers may be believed."""
        return bool(self.table.attrs.get("trusted", 0))

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings against the numbers, and on their meaning."""
        return from_json(self.table.attrs.get("findings", "[]"))

    def draws(self, name: str) -> np.ndarray:
        """Return the equally weighted draws of a quantity, shape (chain, draw)."""
        return self.groups["posterior"][name].values


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class LawResult(Measured):
    """The results of one wall law for an animal.

    Attributes
    ----------
    name : str
    calibration : Dataset
        Parameters, correlations, starts, residual and its harmonics, wall and outlets; blood and friction.
    simulation : Dataset
        Pressure, flow, area, velocity, wave speed by time, vessel, station; numerics as attributes.
    vessels : Dataset
        Wave speed, compliance, pressure drop by vessel.
    stiffening : Dataset, optional
        How the wall stiffens, if the law has a parameter for it.
    posterior : PosteriorResult, optional
        If it was asked for.
    sites : Dataset, optional
        What was observed at further sites, simulated and predicted, and what each adds; see `Fit.sites`.
    """

    name: str
    calibration: xr.Dataset
    simulation: xr.Dataset
    vessels: xr.Dataset
    stiffening: xr.Dataset | None = None
    posterior: PosteriorResult | None = None
    sites: xr.Dataset | None = None

    def __repr__(self) -> str:
        return f"{type(self).__name__}('{self.name}', {self.numbers})"

    @property
    def _first(self) -> list[str]:
        return ["stiffness", "wave_speed", "R_T", "C_T", "RMSE"]

    @cached_property
    def answers(self) -> dict[str, xr.DataArray]:
        """What stands for the animal, by quantity: median and 95 % interval of its posterior, else as fitted."""
        fitted = {str(name): value for name, value in self.quantities.data_vars.items()}
        if self.posterior is None:
            return fitted
        drawn = {name for name in fitted if name in self.posterior.groups["posterior"]}
        return {name: self._drawn(quantity) if name in drawn else quantity for name, quantity in fitted.items()}

    def _drawn(self, fitted: xr.DataArray) -> xr.DataArray:
        assert self.posterior is not None
        draws = self.posterior.draws(str(fitted.name)).ravel()
        low, middle, high = np.quantile(draws, TAILS, method="weibull")
        ends = {"interval_low": float(low), "interval_high": float(high)}
        return xr.DataArray(float(middle), name=fitted.name, attrs=fitted.attrs | ends)

    @property
    def origin(self) -> str:
        """Where `answers` come from, in words: ``linear wall``, or ``posterior under the linear wall``."""
        return f"{self.name} wall" if self.posterior is None else f"posterior under the {self.name} wall"

    @property
    def overstrained(self) -> Finding | None:
        """The finding that a vessel is strained beyond what an artery survives, if there is one."""
        return next((finding for finding in self.findings if finding.code == OVERSTRAINED_CODE), None)

    @property
    def site_doubts(self) -> tuple[Finding, ...]:
        """The findings that a further site speaks against the recording at the inlet."""
        return tuple(finding for finding in self.findings if finding.code in SITE_DOUBTS)

    @property
    def title(self) -> str:
        """The law in words; empty where the result does not tell, as `formula` and `equation`."""
        return str(self.calibration.attrs.get("title", ""))

    @property
    def formula(self) -> str:
        """Pressure as a function of A/A₀."""
        return str(self.calibration.attrs.get("formula", ""))

    @property
    def equation(self) -> str:
        """Number of the paper's equation."""
        return str(self.calibration.attrs.get("equation", ""))

    @property
    def stiffness(self) -> str:
        """Quantity that stands for the stiffness in tables."""
        return str(self.calibration.attrs.get("stiffness", "stiffness"))

    @property
    def parameters(self) -> tuple[str, ...]:
        """Parameters of the wall, without the factors of the outlets."""
        return tuple(str(name) for name in self.calibration["parameter"].values if name in self.calibration.data_vars)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings that a reader must know about the fit."""
        return from_json(self.calibration.attrs.get("findings", "[]"))

    @property
    def compared(self) -> str:
        """What was compared: ``pressure``, or ``flow`` where the pressure entered the model."""
        return "flow" if self.calibration.attrs.get("enters") == "pressure" else "pressure"

    @property
    def residual(self) -> xr.DataArray:
        """Measured minus simulated pressure (mmHg) or flow (ml/s), shape (time,)."""
        return self.calibration[f"{self.compared}_residual"]

    @property
    def rmse(self) -> float:
        """Root-mean-square residual, mmHg; a pulse of flow counts as one of pressure."""
        return float(self.calibration["RMSE"])

    def simulated(self, quantity: str, vessel: str, station: str = "inlet") -> xr.DataArray:
        """Return one simulated quantity over the cycle at one station, shape (time,)."""
        return self.simulation[quantity].sel(vessel=vessel, station=station)
