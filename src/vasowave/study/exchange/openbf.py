"""A model as input of openBF (0.8 and later): a YAML file of the network and a table of the inflow, in SI units.

openBF's tube law is eq. 3 with β = E h0/((1 - σ²) R0), σ = 1/2, and its friction 2π (ζ + 2) μ/ρ · q/A with a whole
number ζ (``gamma_profile``) a vessel and one viscosity μ for all. Any other wall law is replaced by the linear one with
the same wall at mean pressure.
"""

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, warn
from vasowave.base.io.files import write_file
from vasowave.base.units import MMHG
from vasowave.pulse.model import walls
from vasowave.pulse.model.outlets import ReflectionCoefficient
from vasowave.study.exchange.solved import Solved, circuit, losses, require_elastic

FILE, INLET = "openbf.yaml", "openbf_inlet.dat"
PA = MMHG / 10.0
"""One mmHg in Pa."""

POISSON = 0.75
"""1 - σ² of an incompressible wall, as openBF takes it."""

_THICKNESS = 0.1  # h0/R0 that is written; E follows, only their product matters
_LONGEST_CELL, _FEWEST_CELLS = 0.025, 5  # cm; openBF's own limit
_LEAST_PROFILE, _ROUNDED_PROFILE = 2, 10  # lowest exponent that openBF documents; from 10 on rounding costs below 4.2 %

CROWDED = look_kind(
    "openbf.more-than-two-daughters",
    "more than three vessels meet where '{vessel}' ends; openBF refuses that before its general junctions of 2026",
    "Use a later openBF.",
)


class LinearTube(NamedTuple):
    """The law p = β (√(A/A0) - 1) of each vessel, and where it leaves the model's own."""

    beta: np.ndarray
    """mmHg. Shape (vessel,)."""
    area0: np.ndarray
    """cm². Shape (vessel,)."""
    misfit: np.ndarray
    """Largest difference from the pressure of the model's law at the areas of the cycle, mmHg. Shape (vessel,)."""


def linear_tube(solved: Solved) -> LinearTube:
    """Return the linear law that has the area and the slope dp/dA of the model's law at each vessel's mean pressure.

    With D = dp/dA there, β = 2 A D - p and √(A/A0) = 2 A D/β; a linear wall comes back as it is.

    Raises
    ------
    InputError
        A wall so soft at its mean pressure that no linear law has this slope; the vessel is named.
    """
    model, pressure, area = solved.model, solved.mean_pressure, solved.mean_area
    slope = 1.0 / np.asarray(walls.area_compliance(model.wall, pressure, model.area0))
    beta = 2.0 * area * slope - pressure
    soft = np.flatnonzero(~(beta > 0))
    if len(soft):
        raise InputError(
            f"vessel '{solved.network.name[soft[0]]}': no linear wall is as soft at {pressure[soft[0]]:.3g} mmHg as "
            "this one, and openBF knows no other; fit the linear law and export that"
        )
    area0 = area * (beta / (2.0 * area * slope)) ** 2
    misfit = [_misfit(solved, row, beta[row], area0[row]) for row in range(len(beta))]
    return LinearTube(beta, area0, np.array(misfit))


def _misfit(solved: Solved, row: int, beta: float, area0: float) -> float:
    along = solved.along(row)
    return float(np.abs(beta * (np.sqrt(along.area / area0) - 1.0) - along.pressure).max())


def write_openbf(solved: Solved, folder: Path) -> list[str]:
    """Write ``openbf.yaml`` and its inlet file into `folder` and return what their reader should know.

    Raises
    ------
    InputError
        Outlets that are no Windkessels, a wall that is viscous or that no linear law replaces, a vessel with a loss at
        its inlet, or several inlets.

    Warns
    -----
    VasowaveWarning
        A junction of more than three vessels, which earlier versions of openBF refuse.
    """
    require_elastic(solved.model, "openBF")
    lost = losses(solved.model) + solved.model.narrowings
    if lost.any():
        lossy = solved.network.name[int(np.argmax(lost))]
        raise InputError(
            f"openBF knows no loss at the inlet of a vessel, as behind a narrowing, and '{lossy}' has one; give it a "
            "model without (loss=0, no --narrow), or export to svzerod, which knows it"
        )
    network, tube = solved.network, linear_tube(solved)
    if len(network.inlets) > 1:
        raise InputError(f"openBF has one inlet, this network {len(network.inlets)} ({', '.join(network.inlet_names)})")
    crowded = [
        network.name[junction.ending[0]]
        for junction in network.junctions
        if len(junction.ending + junction.beginning) > 3
    ]
    if crowded:
        warn(CROWDED().at(vessel=crowded[0]))
    viscosity, profiles, error = _friction(solved)
    content = {
        "project_name": "openbf",
        "inlet_file": INLET,
        "write_results": ["P", "Q", "u", "A"],
        "solver": {"Ccfl": 0.9, "cycles": 100, "convergence_tolerance": 0.05, "jump": 100},
        "blood": {"rho": 1e3 * solved.model.blood.density, "mu": viscosity},
        "network": _vessels(solved, tube, profiles),
    }
    notes = [_law_note(tube, network.name), _friction_note(error)]
    header = "".join(f"# {line}\n" for line in ["Made by vasowave. SI units: m, s, Pa.", *notes])
    write_file(folder / FILE, header + yaml.safe_dump(content, sort_keys=False, width=120))
    flow = 1e-6 * np.append(solved.inflow.flow, solved.inflow.flow[0])
    time = np.linspace(0.0, solved.inflow.period, len(flow))
    rows = (f"{t!r} {q!r}\n" for t, q in zip(time.tolist(), flow.tolist(), strict=True))
    write_file(folder / INLET, "".join(rows))
    return notes


def _law_note(tube: LinearTube, names: tuple[str, ...]) -> str:
    worst = int(np.argmax(tube.misfit))
    if tube.misfit[worst] < 1e-6:
        return "openBF's tube law is the model's own."
    return (
        "openBF's tube law has the area and the stiffness of the model's wall at each vessel's mean pressure; over the "
        f"cycle their pressures differ by up to {tube.misfit[worst]:.2g} mmHg (vessel '{names[worst]}')."
    )


def _friction(solved: Solved) -> tuple[float, np.ndarray, float]:
    """Return μ (Pa s), the whole exponent of each vessel, and the largest relative error of the friction.

    Where the model's friction is that of a whole exponent from 2 on, μ is blood's. Elsewhere μ is chosen so that the
    exponents are 10 and more, and rounding them changes little.
    """
    blood, drag = solved.model.blood, solved.drag
    exponents = drag / (2 * math.pi * blood.viscosity) - 2.0 if blood.viscosity else np.full(len(drag), 2.0)
    viscosity = blood.viscosity
    if np.any(exponents < _LEAST_PROFILE - 1e-9) or np.any(np.abs(exponents - np.round(exponents)) > 1e-9):
        viscosity = float(drag.min()) / (2 * math.pi * (_ROUNDED_PROFILE + 2))
        exponents = drag / (2 * math.pi * viscosity) - 2.0
    rounded = np.round(exponents)
    error = float(np.max(np.abs((rounded + 2) / (exponents + 2) - 1.0)))
    return 0.1 * viscosity * blood.density, rounded.astype(int), error


def _friction_note(error: float) -> str:
    if error < 1e-9:
        return "Friction is the model's."
    return (
        f"mu and gamma_profile together give the model's friction at mean area, to {100 * error:.1f} %; mu alone is "
        "not the viscosity of this blood."
    )


def _vessels(solved: Solved, tube: LinearTube, profiles: np.ndarray) -> list[dict[str, Any]]:
    network, nodes = solved.network, _nodes(solved)
    beds = dict(zip(network.terminals.tolist(), _beds(solved), strict=True))
    vessels = []
    for row in np.concatenate(network.generations).tolist():
        radius = 1e-2 * math.sqrt(tube.area0[row] / math.pi)
        cells = max(_FEWEST_CELLS, math.ceil(network.length[row] / _LONGEST_CELL))
        vessel: dict[str, Any] = {
            "label": network.name[row],
            "sn": nodes[int(network.start[row])],
            "tn": nodes[int(network.end[row])],
            "L": 1e-2 * float(network.length[row]),
            "M": cells,
            **_radii(solved, row, radius),
            "h0": _THICKNESS * radius,
            "E": POISSON / _THICKNESS * float(tube.beta[row]) * PA,
            "gamma_profile": int(profiles[row]),
        }
        vessels.append(vessel | beds.get(row, {}))
    return vessels


def _beds(solved: Solved) -> list[dict[str, Any]]:
    """Return what openBF is told of the bed behind each terminal vessel."""
    outlets = solved.model.outlets
    steady = solved.model.outlet_pulsation is None
    if isinstance(outlets, ReflectionCoefficient) and steady and not np.any(solved.model.outlet_pressure):
        return [{"Rt": float(value)} for value in np.asarray(outlets.R_t)]
    elements = circuit(solved.model, "openBF", three_element=True)
    return [
        {"R1": proximal * PA * 1e6, "R2": distal * PA * 1e6, "Cc": compliance * 1e-6 / PA,
         "inlet_impedance_matching": False}
        for proximal, distal, compliance in zip(*(element.tolist() for element in elements), strict=True)
    ]  # fmt: skip


def _radii(solved: Solved, row: int, radius: float) -> dict[str, float]:
    """Return one radius, or both ends' where the vessel tapers: openBF joins them by a straight line."""
    profile = solved.model.profile
    if profile is None or not solved.model.changing[row]:
        return {"R0": radius}
    ends = profile.at(np.array([row, row]), np.array([0.0, 1.0]))[0] * radius
    return {"Rp": float(ends[0]), "Rd": float(ends[1])}


def _nodes(solved: Solved) -> dict[int, int]:
    """Return openBF's number of every node: 1 is the inlet, others follow as blood reaches them."""
    network = solved.network
    order = np.concatenate(network.generations)
    nodes = dict.fromkeys([int(network.start[network.root]), *network.end[order].tolist()])
    return {node: number for number, node in enumerate(nodes, 1)}
