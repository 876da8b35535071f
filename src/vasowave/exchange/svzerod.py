"""A model as input of svZeroDSolver: a resistor, a capacitor and an inductor a vessel, the beds, the inflow.

The vessels are taken at their mean pressure: C = L dA/dp, inertance ρ L/A; their resistance is that of the mean flow
(`Solved.resistance`). Units are those usual there: cm, s, g, so that pressures are dyn/cm² (1333.22 make 1 mmHg).
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.exchange.solved import Solved, circuit
from vasowave.model import walls
from vasowave.units import MMHG

FILE = "svzerod.json"
_INFLOW = "INFLOW"
_STEPS = 1000  # a cycle
_FEWEST_CYCLES, _TIME_CONSTANTS = 10, 8.0  # a Windkessel has then forgotten its start to 3e-4


def write_svzerod(solved: Solved, folder: Path) -> list[str]:
    """Write ``svzerod.json`` into `folder` and return what its reader should know.

    Raises
    ------
    InputError
        Outlets that are no circuits.
    """
    network, period = solved.network, solved.inflow.period
    _, distal, compliance = circuit(solved.model, "svZeroDSolver")
    longest = float(np.max(distal * compliance))
    cycles = max(_FEWEST_CYCLES, int(np.ceil(_TIME_CONSTANTS * longest / period)))
    content = {
        "description": {"units": "cm, s, g; pressure dyn/cm^2 (1 mmHg is 1333.22), flow cm^3/s", "made by": "vasowave"},
        "simulation_parameters": {
            "number_of_cardiac_cycles": cycles,
            "number_of_time_pts_per_cardiac_cycle": _STEPS + 1,
            "output_all_cycles": False,
        },
        "boundary_conditions": [_inflow(solved), *_beds(solved)],
        "vessels": _vessels(solved),
        "junctions": [
            {
                "junction_name": f"J{row}",
                "junction_type": "NORMAL_JUNCTION",
                "inlet_vessels": [row],
                "outlet_vessels": list(daughters),
            }
            for row, daughters in enumerate(network.daughters)
            if daughters
        ],
    }
    (folder / FILE).write_text(json.dumps(content, indent=1), encoding="utf-8")
    return [
        f"Run it with: svzerodsolver {FILE} result.csv. Its vessels are linear and lumped, taken at their mean "
        "pressure: no wave travels in them, and pressures are dyn/cm²."
    ]


def _inflow(solved: Solved) -> dict[str, Any]:
    flow, period = solved.inflow.flow, solved.inflow.period
    time = np.linspace(0.0, period, len(flow) + 1)
    return {"bc_name": _INFLOW, "bc_type": "FLOW",
            "bc_values": {"t": time.tolist(), "Q": [*flow.tolist(), float(flow[0])]}}  # fmt: skip


def _beds(solved: Solved) -> list[dict[str, Any]]:
    beds, behind = circuit(solved.model, "svZeroDSolver"), np.asarray(solved.model.outlet_pressure)
    parts = zip(solved.network.terminals.tolist(), *beds, behind, strict=True)
    return [{"bc_name": f"OUT{row}", **_bed(*map(float, values))} for row, *values in parts]


def _bed(proximal: float, distal: float, compliance: float, behind: float) -> dict[str, Any]:
    if not compliance:
        return {"bc_type": "RESISTANCE", "bc_values": {"R": proximal * MMHG, "Pd": behind * MMHG}}
    values = {"Rp": proximal * MMHG, "Rd": distal * MMHG, "C": compliance / MMHG, "Pd": behind * MMHG}
    return {"bc_type": "RCR", "bc_values": values}


def _vessels(solved: Solved) -> list[dict[str, Any]]:
    network, model, area = solved.network, solved.model, solved.mean_area
    inertance = network.length * model.blood.density / area
    compliance = network.length * np.asarray(walls.area_compliance(model.wall, solved.mean_pressure, model.area0))
    terminals = set(network.terminals.tolist())
    vessels = []
    for row, name in enumerate(network.name):
        ends = {"inlet": _INFLOW} if row == network.root else {}
        ends |= {"outlet": f"OUT{row}"} if row in terminals else {}
        values = {"R_poiseuille": solved.resistance[row] * MMHG, "L": inertance[row],
                  "C": compliance[row] / MMHG, "stenosis_coefficient": 0.0}  # fmt: skip
        vessel: dict[str, Any] = {"vessel_id": row, "vessel_name": name, "vessel_length": float(network.length[row])}
        vessel |= {"zero_d_element_type": "BloodVessel", "zero_d_element_values": values}
        vessels.append(vessel | ({"boundary_conditions": ends} if ends else {}))
    return vessels
