"""svZeroDSolver's input back to a model and its inflow."""

from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, note_kind, warn
from vasowave.base.io.textfile import regular_file
from vasowave.base.units import MMHG
from vasowave.pulse.cycle.cycle import Inflow
from vasowave.pulse.model.blood import Blood, Poiseuille
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.outlets import Bed, Resistance, Windkessel
from vasowave.pulse.model.walls import LinearWall
from vasowave.pulse.network.network import Network
from vasowave.pulse.network.vessel_table import network_of
from vasowave.pulse.network_formats.svzerod import number_of, read_svzerod_config, svzerod_columns
from vasowave.study.exchange.openbf_reading import even_cycle, joined_inflow

LUMPED = note_kind(
    "svzerod.lumped",
    "walls are linear, with the compliances C of its vessels at these radii; friction is Poiseuille's of its "
    "viscosity, of which its resistances are {ratio:.3g} times (median)",
)
NO_STENOSIS = look_kind(
    "svzerod.no-stenosis",
    "vessel '{vessel}' has a stenosis coefficient of {value:.3g} g/cm⁷, which is left out: of the narrowing's shape it "
    "says nothing",
    "Narrow the vessel in the model.",
)
_BEDS = {"RCR": ("Rp", "Rd", "C"), "RESISTANCE": ("R",)}


def read_svzerod(path: str | Path) -> tuple[Model, Inflow]:
    """Read a model and its inflow from the JSON file of svZeroDSolver.

    Parameters
    ----------
    path : path
        Units are cm, g and s. Radii are told by ``vessel_D`` or follow from the elements, see `read_network`; walls
        have the compliances C, and beds are RCR (`Windkessel`) or RESISTANCE (`Resistance`), of one kind.

    Raises
    ------
    InputError
        As `read_network`; a vessel without compliance, an outlet without such a bed, an inlet without a flow, a file
        without density and viscosity of the blood.

    Warns
    -----
    VasowaveWarning
        What a circuit does not tell of a model, and what was taken in its place.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> model = vw.Model(network, vw.LinearWall(60.0), vw.estimate_nominal(network, mouse).outlets)
    >>> _ = vw.export_model(model, mouse, "svzerod", "lung-0d")
    >>> back, inflow = vw.read_svzerod("lung-0d/svzerod.json")
    >>> back.network
    Network(21 vessels, 11 terminals, ...)
    """
    path = regular_file(path)
    config = read_svzerod_config(path)
    network, findings = network_of(svzerod_columns(path))
    for finding in findings:
        warn(finding.at(str(path)))
    vessels = config["vessels"]
    density, viscosity = (_blood(path, config, key) for key in ("density", "viscosity"))
    compliance, resistance = (_elements(path, vessels, network, key) for key in ("C", "R_poiseuille"))
    with np.errstate(divide="ignore"):  # where the radius was measured, dA/dp = 2A/(β + p)
        beta = 2 * network.area * network.length / (compliance * MMHG) - network.pressure
    if not np.all((beta > 0) & np.isfinite(beta)):
        row = int(np.argmin((beta > 0) & np.isfinite(beta)))
        raise InputError(f"{path}, vessel '{network.name[row]}': C is {compliance[row]:g}; no linear wall gives way so")
    ratio = resistance / (8 * viscosity * network.length / (np.pi * network.radius**4))
    warn(LUMPED(ratio=float(np.median(ratio))).at(str(path)))
    for vessel, name in zip(vessels, network.name, strict=True):
        values, key = vessel["zero_d_element_values"], "stenosis_coefficient"
        if values.get(key):
            value = number_of(values, key, f"{path}, vessel '{name}'")
            warn(NO_STENOSIS(vessel=name, value=value).at(str(path)))
    conditions = {str(condition.get("bc_name")): condition for condition in config["boundary_conditions"]}
    inlets, ends = (
        [_condition(path, vessels[row], conditions, end) for row in rows]
        for rows, end in ((network.inlets, "inlet"), (network.terminals, "outlet"))
    )
    (outlets, behind), inflow = _outlets(path, ends), _inflow(path, inlets)
    blood = Blood(density, viscosity / density, Poiseuille())
    return Model(network, LinearWall(beta), outlets, blood, outlet_pressure=behind), inflow


def _blood(path: Path, config: dict[str, Any], key: str) -> float:
    parameters = config.get("simulation_parameters")
    value = number_of(parameters if isinstance(parameters, dict) else {}, key, f"{path}, simulation_parameters")
    if not value > 0:
        raise InputError(f"{path}, simulation_parameters: '{key}' is {value:g}; blood has a positive one")
    return value


def _elements(path: Path, vessels: list[dict[str, Any]], network: Network, key: str) -> np.ndarray:
    holders = [vessel.get("zero_d_element_values") for vessel in vessels]
    places = (f"{path}, vessel '{name}'" for name in network.name)
    return np.array([number_of(values if isinstance(values, dict) else {}, key, place)
                     for values, place in zip(holders, places, strict=True)])  # fmt: skip


def _condition(path: Path, vessel: dict[str, Any], conditions: dict[str, Any], end: str) -> tuple[str, str, dict]:
    """Return place, kind and values of the boundary condition at an end of a vessel."""
    names = vessel.get("boundary_conditions")
    name = str(names.get(end, "")) if isinstance(names, dict) else ""
    condition = conditions.get(name, {})
    values = condition.get("bc_values")
    if not isinstance(values, dict):
        raise InputError(f"{path}, vessel '{vessel.get('vessel_name')}': no boundary condition at its {end}")
    return f"{path}, boundary condition '{name}'", str(condition.get("bc_type")), values


def _outlets(path: Path, ends: list[tuple[str, str, dict]]) -> tuple[Bed, np.ndarray]:
    """Return the beds, and the pressure behind each, mmHg."""
    kinds = {kind for _, kind, _ in ends}
    kind = kinds.pop()
    if kinds or kind not in _BEDS:
        names = ", ".join(sorted({*kinds, kind}))
        raise InputError(f"{path}: outlets are {names}; a model needs {' or '.join(_BEDS)}, one kind for all")
    rows = np.array([[number_of(values, key, place) for key in (*_BEDS[kind], "Pd")] for place, _, values in ends])
    behind = rows[:, -1] / MMHG
    if kind == "RESISTANCE":
        return Resistance(rows[:, 0] / MMHG), behind
    return Windkessel(rows[:, 0] / MMHG, rows[:, 1] / MMHG, rows[:, 2] * MMHG), behind


def _inflow(path: Path, ends: list[tuple[str, str, dict]]) -> Inflow:
    cycles = []
    for place, kind, values in ends:
        columns = [values.get("t"), values.get("Q")]
        if kind != "FLOW" or not all(isinstance(column, list) for column in columns):
            raise InputError(f"{place}: is {kind}; a model needs the FLOW into its inlets, lists t and Q")
        try:
            time, flow = np.array(columns, dtype=float)
        except (ValueError, TypeError, OverflowError):
            raise InputError(f"{place}: t and Q must be numbers, as many of one as of the other") from None
        cycles.append(even_cycle(place, time, flow))
    return joined_inflow(path, cycles)
