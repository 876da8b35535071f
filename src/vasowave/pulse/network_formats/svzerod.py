"""The input of svZeroDSolver (JSON): vessels as resistors and inductors, from which their radii follow.

Units are those usual there, cm, g, s: R = 8 μ l/(π r⁴) and L = ρ l/(π r²) for each vessel.
"""

import math
from pathlib import Path
from typing import Any

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind
from vasowave.base.io.columns import Columns
from vasowave.base.io.textfile import read_bytes
from vasowave.base.stores import parsed
from vasowave.pulse.network.remarks import LEFT_OUT
from vasowave.pulse.network_formats import NETWORKS, table_format

_MOST = 1e300  # any number
_KEYS = (b'"zero_d_element_type"', b'"junction_type"', b'"bc_type"', b'"number_of_cardiac_cycles"')
_ALIKE = 0.05  # share by which radii by resistance and by inertance may differ
DIAMETER, IMAGE_PRESSURE = "vessel_D", "pressure of the image, mmHg"
"""Key of a vessel's diameter, cm, and of the description; the solver passes over both."""

BY_RESISTANCE = look_kind(
    "network.radii-by-resistance",
    "the radii follow from {elements} of its vessels by Poiseuille's flow, in cm, g and s; {remedy}",
    f"check one of them, or give every vessel its diameter in cm as '{DIAMETER}'",
)


def is_svzerod(path: Path, start: bytes) -> bool:
    """Return whether a file is JSON with the keys of svZeroDSolver."""
    return start.lstrip()[:1] == b"{" and any(key in start for key in _KEYS)


def svzerod_columns(path: Path) -> Columns:
    """Return the vessels of a file of svZeroDSolver as a table: nodes, length, radius.

    Raises
    ------
    InputError
        A file that is damaged, vessels without length, no way to tell radii, or ways that differ.
    """
    config = read_svzerod_config(path)
    vessels = config["vessels"]
    ids = [str(vessel.get("vessel_id", row)) for row, vessel in enumerate(vessels)]
    start, end = {name: f"in {name}" for name in ids}, {name: f"out {name}" for name in ids}
    for number, junction in enumerate(config["junctions"]):
        inlets, outlets = (_ids(path, junction, f"{side}_vessels", ids) for side in ("inlet", "outlet"))
        end |= dict.fromkeys(inlets, f"junction {number}")
        start |= dict.fromkeys(outlets, f"junction {number}")
    names = [str(vessel.get("vessel_name", name)) for name, vessel in zip(ids, vessels, strict=True)]
    names = names if len(set(names)) == len(names) else ids
    radii = _Radii(path, config)
    description = config.get("description")
    description = description if isinstance(description, dict) else {}
    pressure = repr(number_of({IMAGE_PRESSURE: 0.0} | description, IMAGE_PRESSURE, f"{path}, description"))
    cells = tuple(
        (name, start[key], end[key], repr(number_of(vessel, "vessel_length", f"{path}, vessel '{name}'")),
         repr(radii.radius(vessel, name)), pressure)
        for name, key, vessel in zip(names, ids, vessels, strict=True)
    )  # fmt: skip
    remarks = (BY_RESISTANCE(elements=" and ".join(sorted(radii.elements))),) if radii.elements else ()
    titles, lines = ("name", "from", "to", "length", "radius", "pressure"), tuple(range(1, len(cells) + 1))
    return Columns(str(path), titles, ("", "", "", "cm", "cm", "mmHg"), cells, lines, remarks, titles, "vessel")


def read_svzerod_config(path: Path) -> dict[str, Any]:
    """Return the content of a file of svZeroDSolver, whose lists are there."""
    try:
        config = parsed(read_bytes(path))
    except ValueError as error:
        raise InputError(f"{path}: not JSON ({str(error)[:100]}); damaged or cut off") from None
    config = config if isinstance(config, dict) else {}
    for key in ("vessels", "junctions", "boundary_conditions"):
        entries = config.setdefault(key, [])
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise InputError(f"{path}: '{key}' is not a list of objects, as svZeroDSolver has it")
    if not config["vessels"]:
        raise InputError(f"{path}: 'vessels' lists none; a network needs svZeroDSolver's vessels")
    return config


def number_of(values: dict[str, Any], key: str, place: str) -> float:
    """Return a number of an object; `InputError` with its place if it is none."""
    value = values.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= _MOST:
        raise InputError(f"{place}: '{key}' is {'missing' if value is None else 'not a finite number'}")
    return float(value)


def _ids(path: Path, junction: dict[str, Any], key: str, ids: list[str]) -> list[str]:
    entries = junction.get(key, [])
    numbers = [str(entry) for entry in entries] if isinstance(entries, list) else [""]
    unknown = next((number for number in numbers if number not in ids), None)
    if unknown is not None:
        raise InputError(f"{path}: a junction's {key} name vessel '{unknown[:20]}', which is not in the file")
    return numbers


class _Radii:
    """How the radii of a file's vessels are told: by a diameter, or by elements and the blood that it names."""

    def __init__(self, path: Path, config: dict[str, Any]) -> None:
        blood = config.get("simulation_parameters")
        self.path, self.blood = path, blood if isinstance(blood, dict) else {}
        self.elements: set[str] = set()

    def radius(self, vessel: dict[str, Any], name: str) -> float:
        """Return the radius of a vessel, cm."""
        place = f"{self.path}, vessel '{name}'"
        if DIAMETER in vessel:
            return 0.5 * number_of(vessel, DIAMETER, place)
        values = vessel.get("zero_d_element_values")
        values, length = values if isinstance(values, dict) else {}, number_of(vessel, "vessel_length", place)
        radii = {}
        for element, fluid, share, power in (("R_poiseuille", "viscosity", 8.0, 4), ("L", "density", 1.0, 2)):
            if fluid in self.blood and values.get(element):
                scaled = share * number_of(self.blood, fluid, str(self.path)) * length / math.pi
                ratio = scaled / number_of(values, element, place)
                radii[element] = ratio ** (1 / power) if ratio > 0 else math.nan
        if not radii:
            raise InputError(
                f"{place}: no radius: svZeroDSolver's vessels have none, and without 'viscosity' (or 'density') of the "
                "blood in simulation_parameters, g/(cm s), R_poiseuille (or L) does not tell it. Add that number, or "
                f"give every vessel its diameter in cm as '{DIAMETER}'"
            )
        low, high = min(radii.values()), max(radii.values())
        if not high - low <= _ALIKE * high:
            raise InputError(
                f"{place}: its radius is {' and '.join(f'{r:.3g} cm by {e}' for e, r in radii.items())}; are R, L, "
                f"viscosity and density in cm, g and s? Or give every vessel its diameter in cm as '{DIAMETER}'"
            )
        self.elements |= set(radii)
        return radii.get("L", high)


NETWORKS.register(
    table_format("svzerod", "svZeroDSolver input", (), is_svzerod, svzerod_columns,
                 (LEFT_OUT(what="beds, inflow and compliances"),))
)  # fmt: skip
