"""The posterior of one animal and wall law as labelled data beside its fit."""

import numpy as np
import xarray as xr

from vasowave.animal.labelled import table_dataset
from vasowave.animal.law_result import PosteriorResult
from vasowave.findings import as_json
from vasowave.inference import Posterior
from vasowave.inference.known_errors import SOURCES


def posterior_result(drawn: Posterior) -> PosteriorResult:
    """Return a posterior as it is stored.

    The table has, by ``quantity``, ``median, interval_low, interval_high, prior_low, prior_high, contraction`` and the
    shares of the variance, ``share_recording, share_probe, share_calibration, share_image, share_model, share_prior``,
    how well each ``block`` of harmonics is predicted by the others (``left_out``, ``left_out_k_hat``), and the
    diagnostics. Its attributes say whether it is ``trusted``, and the ``findings`` with their numbers (JSON).
    """
    summary = drawn.summary.rename(columns={name: f"share_{name}" for name in SOURCES})
    table = table_dataset(summary.rename_axis("quantity").reset_index(), "quantity")
    blocks = drawn.left_out
    table = table.assign_coords(block=blocks.index.to_numpy(object))
    table["left_out"] = ("block", blocks["log_density"].to_numpy(), {"units": "1"})
    table["left_out_k_hat"] = ("block", blocks["k_hat"].to_numpy(), {"units": "1"})
    for name, value in drawn.diagnostics._asdict().items():
        table[name] = ((), float(value), {"units": "1"})
    table.attrs = {
        "trusted": int(drawn.diagnostics.trusted),
        "findings": as_json(drawn.findings),
    }
    return PosteriorResult(table, {str(name): _plain(node.to_dataset()) for name, node in drawn.data.children.items()})


def _plain(part: xr.Dataset) -> xr.Dataset:
    """Return a group whose attributes netCDF can hold."""
    kept = {key: int(value) if isinstance(value, bool | np.bool_) else value for key, value in part.attrs.items()}
    return part.assign_attrs(kept)
