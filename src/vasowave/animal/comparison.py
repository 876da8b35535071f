"""Which wall law the residuals of one animal prefer, as labelled data."""

from collections.abc import Sequence

import xarray as xr

from vasowave.animal.animal import Settings
from vasowave.calibration import Fit


def selection_dataset(fits: Sequence[Fit], settings: Settings) -> xr.Dataset:
    """Return AICc and BIC of every wall law under every noise model (eqs. 21 to 23), one candidate per pair."""
    from vasowave.selection import Comparing, compare_models

    return compare_models(
        fits,
        Comparing(seed=settings.seed),
        optima=settings.selection_optima,
        numerics=settings.numerics,
    )
