"""Whether the analysis of virtual animals finds what they were made of, and looks like the paper."""

import numpy as np
import pandas as pd

from vasowave.pulse import derived
from vasowave.pulse.examples import published_table
from vasowave.study.animal import AnimalResult
from vasowave.study.cohort import importance_index
from vasowave.study.datasets import VirtualAnimal

RECOVERED = ("beta", "p1", "gamma", "p1_over_gamma", "wave_speed", "R_T", "a", "C_p")
"""Quantities that are compared: the fitted ones, and combinations that the data determine better."""


SIGNS = {
    "HR": 1, "CO": -1, "mPAP": 1, "sPAP": 1, "dPAP": 1, "pPAP": 1, "PVR": 1, "beta": 1, "p1_over_gamma": 1, "R_T": 1,
    "C_T": -1, "C_v": -1, "C_v_plain": -1, "C_p": -1, "tau": -1, "I_R": 1, "a": 1,
}  # fmt: skip
"""Signs of η in the paper's figure "ParAll_change"."""


def recovered(result: AnimalResult, animal: VirtualAnimal) -> pd.DataFrame:
    """Compare fitted quantities with the truth.

    Returns
    -------
    DataFrame
        One row per wall law and quantity that the law and the animal share: ``animal, group, wall, quantity, truth,
        value, low, high`` (the reported 95 % interval) and ``inside``.
    """
    truth = _truth(result, animal)
    rows = []
    for wall in ("linear", "tangent"):
        if wall not in result.laws:
            continue
        found = result.laws[wall].quantities
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


def quantities_table(result: AnimalResult) -> pd.DataFrame:
    """Return all quantities of one animal, one row for what was measured and one per wall law."""
    rows = []
    for source in ("measured", "linear", "tangent"):
        if source in result.sources:
            values = {str(name): float(value) for name, value in result.sources[source].quantities.data_vars.items()}
            rows.append({"animal": result.name, "group": result.group, "source": source, **values})
    return pd.DataFrame(rows)


def against_table_1(values: pd.DataFrame) -> pd.DataFrame:
    """Return group means of the measured indices, those of Table 1, and the difference in published SD."""
    means = values[values["source"] == "measured"].groupby("group").mean(numeric_only=True)
    rows = []
    for _, row in published_table("hemodynamics").iterrows():
        for group in ("CTL", "HPH"):
            name, mean = row["quantity"], means.loc[group, row["quantity"]]
            published, sd = row[f"{group} mean"], row[f"{group} SD"]
            rows.append((name, group, mean, published, sd, (mean - published) / sd))
    return pd.DataFrame(rows, columns=["quantity", "group", "mean", "published", "published SD", "difference / SD"])


def signs(values: pd.DataFrame) -> pd.DataFrame:
    """Return η of every quantity and source, and whether its sign is the paper's."""
    rows = []
    for source, part in values.groupby("source", sort=False):
        means = part.groupby("group").mean(numeric_only=True)
        for name, sign in SIGNS.items():
            if name in means.columns and np.isfinite(means[name]).all():
                control, hypertensive = (float(value) for value in means.loc[["CTL", "HPH"], name])
                eta = importance_index(control, hypertensive)
                rows.append((source, name, control, hypertensive, eta, np.sign(eta) == sign))
    return pd.DataFrame(rows, columns=["source", "quantity", "CTL", "HPH", "eta", "sign as in the paper"])


def _truth(result: AnimalResult, animal: VirtualAnimal) -> dict[str, float]:
    """Return the truth under the names of `QUANTITIES`; the wave speed is taken where the fit takes it."""
    mean = float(result.measured.quantities["mPAP"])
    found = derived(animal.model, mean, np.full(len(animal.network), mean))
    found |= {name: animal.truth[name] for name in animal.model.wall._fields}
    return {name: found[name] for name in RECOVERED if name in found}
