"""The wall law that one animal prefers, and averages over the laws, as labelled data."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from vasowave.animal.animal import Settings
from vasowave.calibration import Fit
from vasowave.descriptions import LEVEL
from vasowave.errors import InputError
from vasowave.quantities import ACROSS_LAWS, SHARES
from vasowave.selection import Comparing, averaged, compare_models, law_weights


def compared_laws(
    fits: Sequence[Fit], settings: Settings, quantities: Mapping[str, xr.Dataset]
) -> dict[str, xr.Dataset | None]:
    """Return AICc and BIC of every wall law, ``selection``, and the ``averages`` of `quantities` over the laws."""
    selection = compare_models(fits, Comparing(settings.noise_models, seed=settings.seed))
    return {"selection": selection, "averages": averages_dataset(selection, quantities)}


def averages_dataset(selection: xr.Dataset, quantities: Mapping[str, xr.Dataset]) -> xr.Dataset | None:
    """Return the quantities averaged over the laws by their weights, None if no noise model gives weights.

    Parameters
    ----------
    selection : Dataset
        From `compare_models`.
    quantities : mapping of str to Dataset
        Those of each wall law.

    Returns
    -------
    Dataset
        ``weight`` by ``covariance`` and ``wall``, and each quantity of `ACROSS_LAWS`, with its 95 % interval and
        ``between_laws`` (the share of its variance that lies between laws) as attributes: the laws weighted under the
        likeliest noise model, which stands first, is named in the attribute ``covariance`` and makes the weights.
    """
    try:
        weights = law_weights(selection)
    except InputError:
        return None
    first = weights.isel(covariance=0)
    laws = [str(wall) for wall in first["wall"].values]
    values: dict[str, xr.Variable | xr.DataArray] = {"weight": weights}
    for name in (one for one in ACROSS_LAWS if all(one in quantities[wall] for wall in laws)):
        each = [quantities[wall][name] for wall in laws]
        if all(_error(one) is not None for one in each):
            values[name] = _variable(each, first.values)
    said = "the recording's error and the model's discrepancy within each law, and the choice between these laws"
    return xr.Dataset(values, attrs={"covariance": str(first["covariance"].values), "interval_holds": said})


def _variable(each: list[xr.DataArray], weights: np.ndarray) -> xr.Variable:
    errors = [error for one in each if (error := _error(one)) is not None]
    mean = averaged([float(one) for one in each], errors, list(weights))
    attrs = {name: each[0].attrs[name] for name in ("units", "long_name", "symbol")}
    high = min(mean.high, 1.0) if each[0].name in SHARES else mean.high
    attrs |= {"interval_low": mean.low, "interval_high": high, "interval_level": LEVEL}
    return xr.Variable((), mean.value, attrs | {"between_laws": mean.between})


def _error(quantity: xr.DataArray) -> float | None:
    """Standard error of the logarithm of a quantity, None where it is not known."""
    error = quantity.attrs.get("standard_error", 0.0) / float(quantity)
    return float(error) if error > 0 else None
