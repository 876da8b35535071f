"""The wall question as a number: how the wall stiffens, with its interval, in place of a vote between laws."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from vasowave.base.descriptions import NORMAL
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.calibration.uncertainty import MAX_INTERVAL_RATIO, undetermined
from vasowave.pulse.model.laws import parameter_name
from vasowave.pulse.model.walls import LinearWall

CAVEAT = (
    "A wrong radius or image pressure, a taper, or a wall that stiffens along the tree can look like this, and none of "
    "them is in the interval."
)

_NEAR = 0.5
"""Standard errors between the exponent and the linear law, below which the law tells nothing of the interval's end."""


def profiled(fits: Sequence[CalibratedModel]) -> list[CalibratedModel]:
    """Return the fits of one recording; the interval of an exponent ends, on the linear law's side, by the likelihood.

    The fit of the linear law is the point of the exponent's profile at which the law is the linear one, so its S says
    how much worse that value is, without a simulation. The loss of log-likelihood is that of independent noise, scaled
    by what smooth noise makes of the variance of the exponent (Chandler and Bate 2007), and its root is taken for
    straight between the two points, as in `profile_likelihood`. So the interval excludes the linear law exactly where
    the likelihood does, also where the profile is no parabola. The other end stays, and so do exponents at a bound, or
    where the linear law was not fitted or fits no worse.
    """
    linear = next((candidate for candidate in fits if isinstance(candidate.model.wall, LinearWall)), None)
    return [fit if linear is None else _toward(fit, linear) for fit in fits]


def _toward(fit: CalibratedModel, linear: CalibratedModel) -> CalibratedModel:
    name, linear_value = _linear_at(fit)
    if not name or fit.N != linear.N:
        return fit
    row = fit.parameters.loc[name]
    free = int(fit.parameters["free"].sum())
    if not row["free"] or row["at_bound"] or not linear.S > fit.S or fit.N <= free:
        return fit
    smooth, independent = (float(row[key] / row["value"]) for key in ("standard_error_correlated", "standard_error"))
    distance = float(np.log(row["value"] / linear_value))
    if not (np.isfinite(smooth) and abs(distance) > _NEAR * smooth > 0):
        return fit
    deviance = (linear.S / fit.S - 1) * (fit.N - free) * (independent / smooth) ** 2
    table = fit.parameters.copy()
    end = "interval_low" if distance > 0 else "interval_high"
    table.loc[name, end] = row["value"] * np.exp(-NORMAL * distance / np.sqrt(deviance))
    table.loc[name, "determined"] = table["interval_high"][name] <= MAX_INTERVAL_RATIO * table["interval_low"][name]
    old, new = undetermined(fit.parameters), undetermined(table)
    return replace(fit, parameters=table, findings=(*(finding for finding in fit.findings if finding not in old), *new))


def _linear_at(fit: CalibratedModel) -> Any:
    """Return the parameter that says how the wall stiffens, and where its law is the linear one; "" if none does."""
    law = type(fit.model.wall)
    name, linear_value = law.law().linear_at or ("", 0.0)
    return name and parameter_name(law, name), linear_value


def stiffening(fit: CalibratedModel) -> xr.Dataset | None:
    """Return what a fit says about how the wall stiffens; None if its law has no parameter for that.

    Parameters
    ----------
    fit : CalibratedModel
        With a law that states at which value of which parameter it is the linear one (`Law.linear_at`): the power law's
        exponent m, 1/2.

    Returns
    -------
    Dataset
        The ``exponent``, with ``interval_low``, ``interval_high``, ``at_bound`` (0 or 1), ``parameter`` and
        ``linear_at`` as attributes. Attributes: ``verdict`` (``more`` or ``less`` than the linear law, or ``open``),
        and ``said``, the same in a sentence for a reader.
    """
    law, (name, linear) = type(fit.model.wall).law(), _linear_at(fit)
    if not name or not fit.parameters["free"][name]:
        return None
    row = fit.parameters.loc[name]
    low, high = float(row["interval_low"]), float(row["interval_high"])
    verdict = "more" if low > linear else "less" if high < linear else "open"
    if row["at_bound"]:
        verdict = "open"
    attrs = {
        "units": str(row["unit"]),
        "long_name": f"{name} of the {law.name} law; {linear:g} is the linear wall",
        "parameter": name,
        "linear_at": linear,
        "interval_low": low,
        "interval_high": high,
        "at_bound": int(row["at_bound"]),
    }
    value = f"{name} = {row['value']:.3g} [{low:.2g}, {high:.2g}] (95 %), where {linear:g} is the linear wall"
    sentence = f"The {law.name} law asks how the wall stiffens: {value}. {_MEANING[verdict]}"
    if row["at_bound"]:
        sentence += " The value lies at its bound, which is not the data's."
    if verdict != "open":
        sentence += f" {CAVEAT}"
    if not fit.model.network.pressure:
        sentence += " The pressure of the image is not known, and this answer hangs on it."
    return xr.Dataset({"exponent": ((), float(row["value"]), attrs)}, attrs={"verdict": verdict, "said": sentence})


_MEANING = {
    "more": "It stiffens with pressure more than the linear law.",
    "less": "It stiffens with pressure less than the linear law.",
    "open": "The recording does not tell whether it stiffens more or less than the linear law.",
}
