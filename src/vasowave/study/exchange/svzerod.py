"""A model as input of svZeroDSolver: a resistor, a capacitor and an inductor a vessel, the beds, the inflow.

The vessels are taken at their mean pressure: C = L dA/dp, inertance ρ L/A; their resistance is that of the mean flow
(`Solved.resistance`). Units are those usual there: cm, s, g, so that pressures are dyn/cm² (1333.22 make 1 mmHg).
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.io.files import write_file
from vasowave.base.units import MMHG
from vasowave.pulse.model import walls
from vasowave.pulse.network_formats.svzerod import DIAMETER, IMAGE_PRESSURE
from vasowave.study.exchange.solved import Solved, circuit, losses, require_elastic

FILE = "svzerod.json"
_INFLOW = "INFLOW"
_STEPS = 1000  # a cycle
_FEWEST_CYCLES, _TIME_CONSTANTS = 10, 8.0  # a Windkessel has then forgotten its start to 3e-4


def write_svzerod(solved: Solved, folder: Path) -> list[str]:
    """Write ``svzerod.json`` into `folder` and return what its reader should know; `read_svzerod` reads it back.

    Raises
    ------
    InputError
        Outlets that are no circuits, or viscous walls.
    """
    require_elastic(solved.model, "svZeroDSolver")
    network, period = solved.network, solved.inflow.period
    _, distal, compliance = circuit(solved.model, "svZeroDSolver")
    longest = float(np.max(distal * compliance))
    cycles = max(_FEWEST_CYCLES, int(np.ceil(_TIME_CONSTANTS * longest / period)))
    content = {
        "description": {
            "units": "cm, s, g; pressure dyn/cm^2 (1 mmHg is 1333.22), flow cm^3/s",
            "made by": "vasowave",
            IMAGE_PRESSURE: network.pressure,
        },
        "simulation_parameters": {
            "number_of_cardiac_cycles": cycles,
            "number_of_time_pts_per_cardiac_cycle": _STEPS + 1,
            "output_all_cycles": False,
            "density": solved.model.blood.density,
            "viscosity": solved.model.blood.density * solved.model.blood.viscosity,
        },
        "boundary_conditions": [*_inflows(solved), *_beds(solved)],
        "vessels": _vessels(solved),
        "junctions": [
            {
                "junction_name": f"J{junction.ending[0]}",
                "junction_type": "NORMAL_JUNCTION",
                "inlet_vessels": list(junction.ending),
                "outlet_vessels": list(junction.beginning),
            }
            for junction in network.junctions
        ],
    }
    write_file(folder / FILE, json.dumps(content, indent=1))
    return [
        f"Run it with: svzerodsolver {FILE} result.csv. Its vessels are linear and lumped, taken at their mean "
        "pressure: no wave travels in them, and pressures are dyn/cm²."
    ]


def _inflows(solved: Solved) -> list[dict[str, Any]]:
    flows = solved.inflow.into(solved.network.inlet_names)
    time = np.linspace(0.0, solved.inflow.period, len(flows) + 1)
    return [{"bc_name": name, "bc_type": "FLOW",
             "bc_values": {"t": time.tolist(), "Q": [*flow.tolist(), float(flow[0])]}}
            for name, flow in zip(_inflow_names(solved).values(), flows.T, strict=True)]  # fmt: skip


def _inflow_names(solved: Solved) -> dict[int, str]:
    """Return what the flow into each inlet, by its row, is called."""
    inlets = solved.network.inlets.tolist()
    return {row: _INFLOW if len(inlets) == 1 else f"{_INFLOW}{row}" for row in inlets}


def _beds(solved: Solved) -> list[dict[str, Any]]:
    beds, behind = circuit(solved.model, "svZeroDSolver"), np.asarray(solved.model.outlet_pressure)
    elements = zip(solved.network.terminals.tolist(), *beds, behind, strict=True)
    return [{"bc_name": f"OUT{row}", **_bed(*map(float, values))} for row, *values in elements]


def _bed(proximal: float, distal: float, compliance: float, behind: float) -> dict[str, Any]:
    if not compliance:
        return {"bc_type": "RESISTANCE", "bc_values": {"R": proximal * MMHG, "Pd": behind * MMHG}}
    values = {"Rp": proximal * MMHG, "Rd": distal * MMHG, "C": compliance / MMHG, "Pd": behind * MMHG}
    return {"bc_type": "RCR", "bc_values": values}


def _jets(solved: Solved) -> np.ndarray:
    """Return what multiplies q|q| of each vessel so that in the mean it is the loss K ½ρu² at its inlet, g/cm⁷."""
    area, flow = solved.run.stations[:2, :, :, 0]
    squared = flow * np.abs(flow)
    return 0.5 * solved.model.blood.density * losses(solved.model) * (squared / area**2).mean(0) / squared.mean(0)


def _vessels(solved: Solved) -> list[dict[str, Any]]:
    network, model, area = solved.network, solved.model, solved.mean_area
    inertance = network.length * model.blood.density / area
    compliance = network.length * np.asarray(walls.area_compliance(model.wall, solved.mean_pressure, model.area0))
    jets, (inlet_area, flow) = _jets(solved), np.abs(solved.run.stations[:2, :, :, 0])
    narrow = model.narrowing_drag(solved.run.period) * (flow / inlet_area).mean(0) / flow.mean(0)
    terminals, inflows = set(network.terminals.tolist()), _inflow_names(solved)
    vessels = []
    for row, name in enumerate(network.name):
        ends = {"inlet": inflows[row]} if row in inflows else {}
        ends |= {"outlet": f"OUT{row}"} if row in terminals else {}
        values = {"R_poiseuille": (solved.resistance[row] + narrow[row]) * MMHG, "L": inertance[row],
                  "C": compliance[row] / MMHG, "stenosis_coefficient": jets[row]}  # fmt: skip
        vessel: dict[str, Any] = {"vessel_id": row, "vessel_name": name, "vessel_length": float(network.length[row])}
        vessel[DIAMETER] = 2.0 * float(network.radius[row])
        vessel |= {"zero_d_element_type": "BloodVessel", "zero_d_element_values": values}
        vessels.append(vessel | ({"boundary_conditions": ends} if ends else {}))
    return vessels
