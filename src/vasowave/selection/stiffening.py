"""The wall question as a number: how the wall stiffens, with its interval, in place of a vote between laws."""

import xarray as xr

from vasowave.calibration.result import Fit

CAVEAT = (
    "A wrong radius or image pressure, a taper, or a wall that stiffens along the tree can look like this, and none of "
    "them is in the interval."
)


def stiffening(fit: Fit) -> xr.Dataset | None:
    """Return what a fit says about how the wall stiffens; None if its law has no parameter for that.

    Parameters
    ----------
    fit : Fit
        With a law that states at which value of which parameter it is the linear one (`Law.linear_at`): the power law's
        exponent m, 1/2.

    Returns
    -------
    Dataset
        The ``exponent``, with ``interval_low``, ``interval_high``, ``at_bound`` (0 or 1), ``parameter`` and
        ``linear_at`` as attributes. Attributes: ``verdict`` (``more`` or ``less`` than the linear law, or ``open``),
        and ``said``, the same in a sentence for a reader.
    """
    law = type(fit.model.wall).law()
    if law.linear_at is None or not fit.parameters["free"][law.linear_at[0]]:
        return None
    name, linear = law.linear_at
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
    said = f"The {law.name} law asks how the wall stiffens: {value}. {_MEANING[verdict]}"
    if row["at_bound"]:
        said += " The value lies at its bound, which is not the data's."
    if verdict != "open":
        said += f" {CAVEAT}"
    if not fit.model.network.pressure:
        said += " The pressure of the image is not known, and this answer hangs on it."
    return xr.Dataset({"exponent": ((), float(row["value"]), attrs)}, attrs={"verdict": verdict, "said": said})


_MEANING = {
    "more": "It stiffens with pressure more than the linear law.",
    "less": "It stiffens with pressure less than the linear law.",
    "open": "The recording does not tell whether it stiffens more or less than the linear law.",
}
