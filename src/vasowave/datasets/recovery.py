"""Whether the analysis of a virtual animal finds what it was made of."""

import numpy as np
import pandas as pd
import xarray as xr

from vasowave.datasets.virtual_cohort import VirtualAnimal
from vasowave.subject.quantities import derived

RECOVERED = ("beta", "p1", "gamma", "p1_over_gamma", "wave_speed", "R_T", "a", "C_p")
"""Quantities that are compared: the fitted ones, and combinations that the data determine better."""


def recovered(tree: xr.DataTree, animal: VirtualAnimal) -> pd.DataFrame:
    """Compare fitted quantities with the truth.

    Returns
    -------
    DataFrame
        One row per wall law and quantity that the law and the animal share: ``animal, group, wall, quantity, truth,
        value, low, high`` (the reported 95 % interval) and ``inside``.
    """
    truth = _truth(tree, animal)
    rows = []
    for wall in ("linear", "tangent"):
        if wall not in tree.children:
            continue
        found = tree[f"{wall}/quantities"]
        for name in RECOVERED:
            if name in found.data_vars and name in truth:
                value = found[name]
                low, high = value.attrs["interval_low"], value.attrs["interval_high"]
                true, inside = truth[name], low <= truth[name] <= high
                rows.append((animal.name, animal.group, wall, name, true, float(value), low, high, inside))
    columns = ["animal", "group", "wall", "quantity", "truth", "value", "low", "high", "inside"]
    return pd.DataFrame(rows, columns=columns)


def coverage(table: pd.DataFrame) -> pd.DataFrame:
    """Count per wall law and quantity how many intervals hold the truth, with their median half width in percent."""
    half = 50 * np.log(table["high"] / table["low"])
    error = 100 * np.abs(np.log(table["value"] / table["truth"]))
    table = table.assign(half_width=half, error=error)
    grouped = table.groupby(["wall", "quantity"], sort=False)
    return grouped.agg(
        inside=("inside", "sum"), of=("inside", "size"), half_width=("half_width", "median"), error=("error", "median")
    ).reset_index()


def _truth(tree: xr.DataTree, animal: VirtualAnimal) -> dict[str, float]:
    """Return the truth under the names of `QUANTITIES`; the wave speed is taken where the fit takes it."""
    mean = float(tree["measured/quantities"]["mPAP"])
    wall = {name: animal.truth[name] for name in animal.model.wall._fields}
    found = derived(animal.model, wall, np.full(len(animal.network), mean), mean)
    return {name: found[name] for name in RECOVERED if name in found}
