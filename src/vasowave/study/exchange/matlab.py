"""A model and its waves as variables of a MATLAB file (version 5 to 7), with units."""

import io
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from vasowave.base.io.files import write_file
from vasowave.pulse.model.outlets import Bed
from vasowave.pulse.solver.dataset import STATIONS, as_dataset
from vasowave.study.exchange.solved import Solved, losses

FILE = "waves.mat"


def write_matlab(solved: Solved, folder: Path) -> list[str]:
    """Write ``waves.mat`` into `folder` and return what its reader should know.

    Variables: ``time`` (s), ``waves`` with pressure, flow, area, velocity, wave_speed, each (time, vessel, station),
    ``network``, ``wall``, ``outlets``, ``blood``, ``inflow``, and ``units``, which has the same fields.
    """
    from scipy.io import savemat

    variables = _variables(solved)
    content = io.BytesIO()
    savemat(content, variables, oned_as="column", long_field_names=True)
    write_file(folder / FILE, content.getvalue())
    return [
        f"In MATLAB: load('{FILE}'); plot(time, waves.pressure(:, 1, 1)) is the pressure at the inlet of the first "
        f"vessel. Stations are {', '.join(STATIONS)}; rows in network.parent count from 1, 0 is no parent."
    ]


def _variables(solved: Solved) -> dict[str, Any]:
    model, network = solved.model, solved.network
    data = as_dataset(replace(solved.run, cells=solved.run.cells[:, :0]))  # by station, not by cell
    outlets = {field.name: getattr(model.outlets, field.name) for field in fields(cast(Any, model.outlets))}
    quantities = model.outlets.bed().quantities if isinstance(model.outlets, Bed) else {}
    units = {"Z": "mmHg s/ml"} | {name: quantity.unit for name, quantity in quantities.items()}
    parameters = {
        name: quantity.unit for name, quantity in zip(model.wall._fields, model.wall.law().parameters, strict=True)
    }
    pulsation = {} if model.outlet_pulsation is None else {"pulsation_behind": model.outlet_pulsation}
    viscosity = {"viscosity": model.wall_viscosity} if np.any(model.wall_viscosity) else {}
    return {
        "time": data["time"].values,
        "waves": {str(name): values.values for name, values in data.data_vars.items()},
        "stations": _cells(STATIONS),
        "network": {
            "name": _cells(network.name), "parent": network.parent + 1.0, "length": network.length,
            "radius": network.radius, "image_pressure": network.pressure, "area0": model.area0,
            **({} if network.nodes is None else {"start_node": network.start, "end_node": network.end}),
            **({"loss": losses(model)} if np.any(losses(model)) else {}),
            **({"resistance": model.narrowings} if np.any(model.resistance) else {}),
        },
        "wall": {"law": model.wall.law().name, **model.wall._asdict(), **viscosity},
        "outlets": {"vessel": _cells([network.name[row] for row in network.terminals]), **outlets,
                    "pressure_behind": model.outlet_pressure, **pulsation},
        "blood": {"density": model.blood.density, "viscosity": model.blood.viscosity,
                  "friction": repr(model.blood.friction)},
        "inflow": {"flow": solved.inflow.flow, "period": solved.inflow.period},
        "units": {
            "time": "s",
            "waves": {str(name): values.attrs["units"] for name, values in data.data_vars.items()},
            "network": {"length": "cm", "radius": "cm", "image_pressure": "mmHg", "area0": "cm2"},
            "wall": parameters | dict.fromkeys(viscosity, "mmHg s"),
            "outlets": {name: units.get(name, "") for name in outlets} | {"pressure_behind": "mmHg"},
            "blood": {"density": "g/ml", "viscosity": "cm2/s"},
            "inflow": {"flow": "ml/s", "period": "s"},
        },
    }  # fmt: skip


def _cells(texts: Any) -> np.ndarray:
    return np.array(list(texts), dtype=object)
