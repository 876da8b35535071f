"""The posterior of one animal and one wall law: draws, table, diagnostics, and what they mean in words."""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.base.findings import Finding, texts
from vasowave.base.io.files import write_file
from vasowave.base.notebook import card
from vasowave.pulse.inference.diagnostics import halves_limit
from vasowave.pulse.inference.reweighting import trusted


class Diagnostics(NamedTuple):
    """How far the draws can be trusted.

    Attributes
    ----------
    k_hat : float
        Shape of the tail of the importance weights (Pareto k); above 0.7 weighted means cannot be trusted.
    effective : float
        Number of independent draws that would be worth as much.
    missed : float
        Root-mean-square difference between emulated and simulated pressure, mmHg, at draws that were simulated last.
    log_error : float
        Standard deviation of the emulator's error of the log-likelihood there. Up to 0.35 it speaks for the draws that
        are left.
    log_evidence, log_evidence_error : float
        Logarithm of the probability density of the measured harmonics under this law, and its standard error; of two
        laws, compared at the same harmonics, the exponential of the difference is the Bayes factor.
    simulations : int
        Simulations that the posterior rests on.
    rounds : int
        Rounds of the emulator.
    harmonics : int
        Harmonics of the pressure that were compared.
    draws : int
        Draws that were weighted.
    even : float
        Share of the draws that their weights alone would leave; 1 if all weigh the same.
    modes : int
        Separate modes that the draws come from.
    halves_apart : float
        Largest distance between the means of two halves that were searched and drawn without knowing of each other, or
        of one of them from the whole, in posterior SD.
    """

    k_hat: float
    effective: float
    missed: float
    log_error: float
    log_evidence: float
    log_evidence_error: float
    simulations: int
    rounds: int
    harmonics: int
    draws: int
    even: float
    modes: int = 1
    halves_apart: float = 0.0

    @property
    def agree(self) -> bool:
        """Whether two independent halves say the same, as far as so many draws can tell."""
        return self.halves_apart <= halves_limit(self.effective)

    @property
    def trusted(self) -> bool:
        """Whether the numbers may be believed: Pareto k is at most 0.7, or weights hardly differ, and halves agree."""
        return trusted(self.k_hat, self.even) and self.agree


@dataclass(frozen=True, eq=False)
class Posterior:
    """What one recording says about one animal under one wall law, with geometry and structure unknown.

    Attributes
    ----------
    wall : str
    data : DataTree
        As ArviZ reads it: groups ``posterior`` (every unknown and derived quantity, dims chain, draw, equally weighted;
        draws are independent, so there is one chain), ``sample_stats`` (the importance draws before resampling:
        log_weight), ``log_likelihood`` (of all harmonics together, which are not independent), ``posterior_predictive``
        (by time: ``pressure``, mmHg, with discrepancy and errors, ``simulated`` without; where the pressure enters the
        model, ``flow``, ml/s) and ``observed_data`` (the same as measured), ``prior`` (draws of the same quantities).
    summary : DataFrame
        One row per unknown and derived quantity: ``unit, median, interval_low, interval_high`` (95 %), ``prior_low,
        prior_high`` (95 %), ``contraction`` (1 - variance over prior variance, of the logarithm where it is positive)
        and the shares of the variance ``recording, image, model, prior``, which add up to 1.
    diagnostics : Diagnostics
    left_out : DataFrame
        How well each block of harmonics is foretold by the others, the block's name as index: ``log_density`` (of the
        block's orthonormal Fourier coefficients in mmHg; of two laws the larger one foretells better) and ``k_hat``
        (Pareto k; above 0.7 the block decides by itself where the posterior lies, and the number is rough).
    findings : tuple of Finding
        What a reader must know: what speaks against the posterior or the fit beside it, and what the numbers mean.

    Examples
    --------
    >>> import vasowave as vw
    >>> network = vw.Network(("1",), [-1], [0.4], [0.05])  # a quick one, as that of `posterior`
    >>> search = vw.Search(fixed={"r1": 1.0, "r2": 1.0, "c1": 1.0}, pressure_harmonics=8)
    >>> exact = dict.fromkeys(("radius_scale_sd", "length_scale_sd", "k_sd", "flow_gain_sd", "taper_sd"), 0.0)
    >>> priors = vw.Priors(radius=0, length=0, **exact)
    >>> drawn = vw.posterior(network, vw.virtual_mouse(), priors=priors, search=search, draws=40)
    >>> drawn.summary.loc["wave_speed", ["interval_low", "median", "interval_high"]].is_monotonic_increasing
    True
    """

    wall: str
    data: xr.DataTree
    summary: pd.DataFrame
    diagnostics: Diagnostics
    left_out: pd.DataFrame
    findings: tuple[Finding, ...] = ()

    def __repr__(self) -> str:
        rows = (f"{name} {row['median']:.4g} [{row['interval_low']:.3g}, {row['interval_high']:.3g}]"
                for name, row in self.summary.iterrows())  # fmt: skip
        return f"Posterior({self.wall} wall: {', '.join(rows)}; Pareto k {self.diagnostics.k_hat:.2f})"

    def _repr_html_(self) -> str:
        facts = {
            f"{name} [{row['unit']}]" if row["unit"] != "1" else str(name): f"{row['median']:.4g} "
            f"[{row['interval_low']:.3g}, {row['interval_high']:.3g}]"
            for name, row in self.summary.iterrows()
        }
        return card(f"Posterior, {self.wall} wall", facts, texts(self.findings))

    def draws(self, name: str) -> np.ndarray:
        """Return the equally weighted draws of an unknown or derived quantity, shape (draw,)."""
        return np.asarray(self.data["posterior"][name].values).ravel()

    def to_datatree(self) -> xr.DataTree:
        """Return the draws as ArviZ reads them: `data`."""
        return self.data

    def to_netcdf(self, path: str | Path) -> Path:
        """Write the draws as netCDF with one group each, which ``arviz.from_netcdf`` reads; returns the path.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        return write_file(Path(path), bytes(self.data.to_netcdf()))
