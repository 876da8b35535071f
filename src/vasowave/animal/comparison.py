"""Which wall law one animal prefers, how its wall stiffens, and what the laws say together, as labelled data."""

from collections.abc import Mapping, Sequence

import xarray as xr

from vasowave.animal.animal import Settings
from vasowave.animal.averages import averages_dataset
from vasowave.calibration import Fit


def compared_datasets(
    fits: Sequence[Fit], settings: Settings, groups: Mapping[str, xr.Dataset]
) -> dict[str, xr.Dataset]:
    """Return the groups that compare the wall laws and average over them; `groups` holds what each law says."""
    selection = selection_dataset(fits, settings)
    averages = averages_dataset(selection, {fit.wall: groups[f"{fit.wall}/quantities"] for fit in fits})
    return {"selection": selection} | ({} if averages is None else {"averages": averages})


def stiffening_dataset(fit: Fit) -> dict[str, xr.Dataset]:
    """Return the group that says how the wall stiffens, if the law has a parameter for it."""
    from vasowave.selection import stiffening

    stiffens = stiffening(fit)
    return {} if stiffens is None else {f"{fit.wall}/stiffening": stiffens}


def selection_dataset(fits: Sequence[Fit], settings: Settings) -> xr.Dataset:
    """Return AICc and BIC of every wall law under every noise model (eqs. 21 to 23), one candidate per pair."""
    from vasowave.selection import Comparing, compare_models

    return compare_models(
        fits,
        Comparing(seed=settings.seed),
        optima=settings.selection_optima,
        numerics=settings.numerics,
    )
