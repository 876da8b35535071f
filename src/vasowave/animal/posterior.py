"""The posterior of one animal and wall law as labelled data beside its fit."""

import json

import numpy as np
import xarray as xr

from vasowave.animal.datasets import table_dataset
from vasowave.findings import as_json
from vasowave.inference import Posterior

SHARES = ("recording", "image", "model", "prior")
"""Where the variance of a quantity comes from."""


def posterior_datasets(wall: str, drawn: Posterior) -> dict[str, xr.Dataset]:
    """Return the groups of a posterior, by their place in the result of an animal.

    ``WALL/inference`` holds the table by ``quantity`` (``median, interval_low, interval_high, prior_low, prior_high,
    contraction`` and the shares of the variance, ``share_recording, share_image, share_model, share_prior``), how well
    each ``block`` of harmonics is foretold by the others (``left_out``, ``left_out_k_hat``), and the diagnostics.
    Its attributes say whether it is ``trusted``, the ``warnings``, and the ``findings``
    with their numbers (both JSON). The groups in it are those that ArviZ reads (``posterior``, ``sample_stats``, …).
    """
    summary = drawn.summary.rename(columns={name: f"share_{name}" for name in SHARES})
    table = table_dataset(summary.rename_axis("quantity").reset_index(), "quantity")
    blocks = drawn.left_out
    table = table.assign_coords(block=blocks.index.to_numpy(object))
    table["left_out"] = ("block", blocks["log_density"].to_numpy(), {"units": "1"})
    table["left_out_k_hat"] = ("block", blocks["k_hat"].to_numpy(), {"units": "1"})
    for name, value in drawn.diagnostics._asdict().items():
        table[name] = ((), float(value), {"units": "1"})
    table.attrs = {
        "trusted": int(drawn.diagnostics.trusted),
        "warnings": json.dumps(drawn.warnings, ensure_ascii=False),
        "findings": as_json(drawn.findings),
    }
    parts = {name: node.to_dataset() for name, node in drawn.data.children.items()}
    return {f"{wall}/inference": table} | {f"{wall}/inference/{name}": _plain(part) for name, part in parts.items()}


def _plain(part: xr.Dataset) -> xr.Dataset:
    """Return a group whose attributes netCDF can hold."""
    kept = {key: int(value) if isinstance(value, bool | np.bool_) else value for key, value in part.attrs.items()}
    return part.assign_attrs(kept)
