"""A model as tables: the network as `read_network` takes it, its parameters by vessel, and its inflow."""

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.io.files import write_file
from vasowave.pulse.model.laws import bed_quantities, parameter_names
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.outlets import Bed
from vasowave.pulse.network.vessel_table import write_network
from vasowave.study.exchange.solved import Solved, losses

NETWORK, PARAMETERS, INFLOW = "network.csv", "parameters.csv", "inflow.csv"


def write_tables(solved: Solved, folder: Path) -> list[str]:
    """Write ``network.csv``, ``parameters.csv`` and ``inflow.csv`` into `folder` and return what to do with them.

    Raises
    ------
    InputError
        Outlets without parameters.
    """
    network, wall, inflow = solved.network, solved.model.wall, solved.inflow
    write_network(network, folder / NETWORK)
    names = parameter_names(type(wall))
    units = {name: parameter.unit for name, parameter in zip(names, wall.law().parameters, strict=True)}
    further = _further(solved.model)
    outlets: Any = solved.model.outlets
    if not isinstance(outlets, Bed):
        raise InputError(f"tables hold beds with parameters, this model has {type(outlets).__name__}; give it a Bed")
    beds = {name: parameter.unit for name, parameter in bed_quantities(type(outlets)).items()}
    at_ends = dict(zip(network.terminals.tolist(), zip(*map(np.asarray, outlets), strict=True), strict=True))
    rows = ([name, *(value[row] for value in (*wall, *further.values())), *at_ends.get(row, [""] * len(beds))]
            for row, name in enumerate(network.name))  # fmt: skip
    titles = [[f"{name} [{unit}]" for name, unit in columns.items()] for columns in (units, beds)]
    header = ["vessel", *titles[0], *further, *titles[1]]
    _write(folder / PARAMETERS, header, rows)
    time = np.arange(len(inflow.flow)) * (inflow.period / len(inflow.flow))
    flows = [f"flow into {name} [ml/s]" for name in network.inlet_names if inflow.flow.ndim > 1] or ["flow [ml/s]"]
    _write(folder / INFLOW, ["time [s]", *flows], np.column_stack([time, inflow.flow]).tolist())
    return [
        f"{NETWORK} is the network that every command takes; {PARAMETERS} holds wall, losses and outlets of "
        "each vessel, for which it has no columns."
    ]


def _further(model: Model) -> dict[str, np.ndarray]:
    """Return what vessels have beside the wall law's parameters, by title, where any has it."""
    values = {
        "loss [1]": losses(model),
        "resistance [mmHg s/ml]": model.narrowings,
        "wall_viscosity [mmHg s]": model.wall_viscosity,
    }
    return {title: np.broadcast_to(value, len(model.network)) for title, value in values.items() if np.any(value)}


def _write(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(header)
    writer.writerows([repr(float(cell)) if isinstance(cell, float) else cell for cell in row] for row in rows)
    write_file(path, text.getvalue())
