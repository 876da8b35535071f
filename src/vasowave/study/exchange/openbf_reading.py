"""openBF's YAML back to a model and its inflow."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import Finding, look_kind, note_kind, warn
from vasowave.base.io.columns import number
from vasowave.base.io.textfile import read_lines, regular_file
from vasowave.pulse.cycle.cycle import Inflow, resample
from vasowave.pulse.model.blood import Blood, PowerLaw
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.outlets import ReflectionCoefficient, Windkessel
from vasowave.pulse.model.shape import Shape
from vasowave.pulse.model.walls import LinearWall
from vasowave.pulse.network.network import Network
from vasowave.study.exchange.openbf import PA, POISSON

_LARGEST = 8 << 20  # bytes; no network is longer
_FEWEST_SAMPLES = 512  # of an inflow that is not even in time
_MOST_FLOW = 1.0  # m³/s, a thousand hearts: the column is a pressure
_PROFILE, _OLD_PROFILE = 2.0, 9.0  # openBF's defaults: from version 0.8 on, and before
_SAME_PERIOD = 1e-6  # of the period: by so much those of several inlets may differ
_BACK = 0.01  # of the period: by so much a row's time may lie before the one above it
_KEYS = ("project_name", "inlet_file", "output_directory", "write_results", "blood", "solver", "network",
         "project name", "inlet file")  # fmt: skip
_VESSEL_KEYS = ("label", "sn", "tn", "L", "M", "E", "R0", "Rp", "Rd", "h0", "Pext", "gamma_profile", "visco-elastic",
                "phi", "Rt", "R1", "R2", "Cc", "inlet_impedance_matching", "to_save", "initial_pressure",
                "initial_flow", "outlet", "inlet", "inlet number", "inlet file", "inlet_file")  # fmt: skip
_BED_KEYS = ("Rt", "R1", "R2", "Cc", "inlet_impedance_matching", "outlet")
_NUMERICS = ("M", "to_save", "initial_pressure", "initial_flow", "inlet number")  # of openBF's own run
_NAMED = 5  # vessels that a finding names
_STRAIGHT = 1e-9  # two radii so near to each other differ by rounding
_ALONG = np.linspace(0.0, 1.0, 9)  # places along a vessel that tapers
_DEFAULT_THICKNESS = (0.2802, -505.3, 0.1324, -11.14)  # a, b, c, d of h0 = R0 (a exp(b R0) + c exp(d R0)), R0 in m

VISCOELASTIC = note_kind("openbf.viscoelastic", "its wall is viscoelastic; the elastic part was taken")
MATCHED = note_kind(
    "openbf.matched-bed", "its Windkessel was given R1 = ρ c0/A0 = {first:.3g} Pa s/m³, out of {whole:.3g} in all"
)
REFLECTED = note_kind(
    "openbf.reflection",
    "Rt was taken as the resistance (1 + Rt)/(1 - Rt) ρ c0/A0, which is what it is to small waves; "
    "to large ones openBF's gives way more",
)
PROFILES = note_kind(
    "openbf.profiles",
    "gamma_profile differs between vessels ({low:g} to {high:g}); {mean:.3g}, with the same losses of the mean flow, "
    "was taken for all",
)

DISORDERED = look_kind(
    "openbf.times-in-disorder",
    "{count} of its times lie before the one above them, by up to {most:.2g} ms; the rows were sorted",
    "Sort the rows yourself, and look at the curve.",
)
INNER_BED = look_kind(
    "openbf.bed-inside",
    "a bed is given where other vessels follow ({keys} of {some}); it is left out",
    "Give the bed to a vessel at whose end nothing follows, or put a vessel there that leads to it.",
)
UNUSED_KEY = note_kind("openbf.unused-key", "'{key}' of {some} is given and not used")
UNKNOWN_KEY = note_kind("openbf.unknown-key", "'{key}' means nothing to openBF and was left out{hint}")


def read_openbf(path: str | Path) -> tuple[Model, Inflow]:
    """Read a model and its inflow from the YAML file of openBF and the inlet files that it names.

    Loops and several inlets are taken as they are; keys are those of version 0.8 and later, or of 0.7 and earlier.

    The tube law is openBF's own; an external pressure becomes part of it: p = (β - P) (√(A/A0') - 1) with
    √(A0'/A0) = (β - P)/β. A vessel that tapers has one thickness of its wall, so that β goes with 1/R0. Junctions
    share the static pressure, as openBF's do where a vessel divides. Two-element Windkessels, and those that openBF
    matches to their vessel, get ρ c0/A0 as R1; `Rt` is a `ReflectionCoefficient`.

    Parameters
    ----------
    path : path
        Lengths in m, pressures in Pa, flow in m³/s, as openBF has them.

    Raises
    ------
    InputError
        A file that is none of openBF's, a key that is missing or no number, nodes at which several inlets or beds meet,
        an outlet without a Windkessel, an inlet file that is not a table of time and flow, or lies outside the
        folder of the first.

    Warns
    -----
    VasowaveWarning
        What the model cannot hold: velocity profiles that differ between vessels, for which one of the same dissipation
        is taken; a resistance that had to be split; walls that are viscoelastic.

    Examples
    --------
    >>> import vasowave as vw
    >>> network, mouse = vw.control_network(), vw.virtual_mouse()
    >>> beds = vw.estimate_nominal(network, mouse).outlets
    >>> model = vw.Model(network, vw.LinearWall(60.0), beds, vw.Blood(friction=vw.Poiseuille()))
    >>> _ = vw.export_model(model, mouse, "openbf", "lung-openbf")
    >>> back, inflow = vw.read_openbf("lung-openbf/openbf.yaml")
    >>> back
    Model(LinearWall(beta 60), Windkessel, Network(21 vessels, ...))
    """
    path = regular_file(path)
    config = _config(path)
    vessels = [_Vessel(path, number, values) for number, values in enumerate(_part(path, config, "network", list), 1)]
    if not vessels:
        raise InputError(f"{path}: 'network' lists no vessel")
    fluid = _Vessel(path, 0, _part(path, config, "blood", dict))
    density, viscosity = fluid.number("rho"), fluid.number("mu")
    _say_unknown(path, config, vessels)
    nodes = np.array([[vessel.node("sn"), vessel.node("tn")] for vessel in vessels])
    length = np.array([1e2 * vessel.number("L") for vessel in vessels])
    along = np.array([_wall(vessel) for vessel in vessels])  # (vessel, β or radius, place)
    beta, radius = along[:, :, len(_ALONG) // 2].T
    network = Network(
        tuple(vessel.name for vessel in vessels), None, length, 1e2 * radius,
        where=lambda row: f"{path}, vessel {row + 1}", nodes=nodes,
    )  # fmt: skip
    earlier = "project name" in config  # the keys of openBF before version 0.8, whose default is another
    profile = _profile(network, vessels, _OLD_PROFILE if earlier else _PROFILE)
    blood = Blood(1e-3 * density, 1e4 * viscosity / density, PowerLaw(profile))
    ends = [(vessels[row], density, float(beta[row]), float(radius[row])) for row in network.terminals]
    outlets = _reflections(ends) or Windkessel(*np.array([_bed(*end) for end in ends]).T)
    stiffness, width = np.moveaxis(along / along[:, :, [len(_ALONG) // 2]], 1, 0)
    model = Model(network, LinearWall(beta / PA), outlets, blood, shape=Shape(width, stiffness), junctions="static")
    inflow = _inflow(path, config, [vessels[row] for row in network.inlets])
    _say_unused(path, fluid, vessels, network.terminals.tolist())
    return model, inflow


class _Vessel:
    """One mapping of the file, which knows where it stands."""

    def __init__(self, path: Path, number: int, values: Any) -> None:
        self.place = f"{path}, vessel {number}" if number else f"{path}, blood"
        if not isinstance(values, Mapping):
            raise InputError(f"{self.place}: is not a list of keys and values, as openBF's files have it")
        self.values, self.used = values, set[str]()
        self.name = _word(self.place, "label", self.get("label", ""))
        self.place += f" ('{self.name}')" if self.name else ""

    def has(self, key: str) -> bool:
        return key in self.values

    def get(self, key: str, default: Any = None) -> Any:
        self.used.add(key)
        return self.values.get(key, default)

    def number(self, key: str, default: float | None = None, lowest: float = 0.0) -> float:
        value = self.get(key, default)
        if value is None:
            raise InputError(f"{self.place}: no '{key}'; openBF needs it")
        text = _word(self.place, key, value)
        try:
            parsed = float(text)
        except ValueError:
            raise InputError(f"{self.place}: '{key}' is '{text}', not a number") from None
        if not math.isfinite(parsed) or parsed < lowest:
            raise InputError(f"{self.place}: '{key}' is {text}; it must be a number of at least {lowest:g}")
        return parsed

    def node(self, key: str) -> int:
        number = self.number(key)
        if number != int(number):
            raise InputError(f"{self.place}: '{key}' is {number:g}; nodes are whole numbers")
        return int(number)

    def warn(self, finding: Finding) -> None:
        warn(finding.at(self.place), stacklevel=4)


def _config(path: Path) -> Mapping[str, Any]:
    if path.stat().st_size > _LARGEST:
        raise InputError(f"{path}: larger than {_LARGEST >> 20} MB; no file of openBF is")
    try:
        config = yaml.safe_load(path.read_bytes())
    except (yaml.YAMLError, UnicodeDecodeError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: not YAML ({' '.join(str(error).split())[:200]})") from None
    if not isinstance(config, Mapping) or "network" not in config:
        raise InputError(f"{path}: no 'network'; this is not a configuration of openBF")
    return config


def _word(place: str, key: str, value: Any) -> str:
    """Return a number or a text as text; lists of lists, which can be endless in YAML, are never written out."""
    if not isinstance(value, str | int | float):
        raise InputError(f"{place}: '{key}' is neither a number nor a text")
    return str(value).strip()


def _part(path: Path, config: Mapping[str, Any], key: str, kind: type) -> Any:
    section = config.get(key)
    if not isinstance(section, kind):
        raise InputError(f"{path}: '{key}' is missing or is not a {'list' if kind is list else 'section'}")
    return section


def _say_unknown(path: Path, config: Mapping[str, Any], vessels: list[_Vessel]) -> None:
    """Say which keys mean nothing here; openBF itself passes over them, too."""
    for key in (str(key) for key in config if key not in _KEYS):
        warn(UNKNOWN_KEY(key=key, hint=did_you_mean(key, _KEYS)).at(str(path)), stacklevel=3)
    counts = Counter(str(key) for vessel in vessels for key in vessel.values if key not in _VESSEL_KEYS)
    for key, count in counts.items():
        place = f"{path}, {count} of {len(vessels)} vessels"
        warn(UNKNOWN_KEY(key=key, hint=did_you_mean(key, _VESSEL_KEYS)).at(place), stacklevel=3)


def _say_unused(path: Path, fluid: _Vessel, vessels: list[_Vessel], terminals: Sequence[int]) -> None:
    """Say which keys of openBF were given a value that nothing here took, with the vessels that have it."""
    inner: dict[tuple[str, ...], list[str]] = {}
    vessels_by_key: dict[str, list[str]] = {}
    for row, vessel in enumerate(vessels):
        unused = [key for key in vessel.values if key in _VESSEL_KEYS and key not in {*vessel.used, *_NUMERICS}]
        beds = tuple(key for key in unused if key in _BED_KEYS and row not in terminals)
        if beds:
            inner.setdefault(beds, []).append(vessel.name or str(row + 1))
        for key in unused:
            if key not in beds and not (key == "outlet" and row in terminals):
                vessels_by_key.setdefault(key, []).append(vessel.name or str(row + 1))
    vessels_by_key |= {str(key): ["blood"] for key in fluid.values if key not in fluid.used}
    for beds, names in inner.items():
        warn(INNER_BED(keys=", ".join(beds), some=_several(names)).at(str(path)), stacklevel=3)
    for key, names in vessels_by_key.items():
        warn(UNUSED_KEY(key=key, some=_several(names)).at(str(path)), stacklevel=3)


def _several(names: list[str]) -> str:
    return ", ".join(f"'{name}'" for name in names[:_NAMED]) + (", …" if len(names) > _NAMED else "")


def _wall(vessel: _Vessel) -> tuple[np.ndarray, np.ndarray]:
    """Return β (Pa) and the radius at no pressure (m) along a vessel, the external pressure taken into the law."""
    proximal = vessel.number("Rp" if vessel.has("Rp") and not vessel.has("R0") else "R0")
    distal = vessel.number("Rd", proximal) if not vessel.has("R0") else proximal
    straight = math.isclose(proximal, distal, rel_tol=_STRAIGHT)
    radius = proximal + (0.0 if straight else distal - proximal) * _ALONG
    if not radius.min() > 0:
        raise InputError(f"{vessel.place}: its radius is zero")
    viscosity = vessel.number("phi", 0.0)
    if vessel.get("visco-elastic") or viscosity > 0:
        vessel.warn(VISCOELASTIC())
    a, b, c, d = _DEFAULT_THICKNESS
    middle = 0.5 * (proximal + distal)
    thickness = vessel.number("h0", middle * (a * math.exp(b * middle) + c * math.exp(d * middle)))
    beta, outside = vessel.number("E") * thickness / (POISSON * radius), vessel.number("Pext", 0.0, lowest=-math.inf)
    if not beta.min() > max(outside, 0.0):
        raise InputError(
            f"{vessel.place}: its wall (β {beta.min():.3g} Pa) collapses under Pext {outside:.3g} Pa; check E and h0"
        )
    return beta - outside, radius * (beta - outside) / beta


def _reflections(ends: list[tuple[_Vessel, float, float, float]]) -> ReflectionCoefficient | None:
    """Return the beds that openBF's reflection coefficients are at no pressure, if vessels end in them."""
    have_coefficient = [vessel.has("Rt") for vessel, *_ in ends]
    if not any(have_coefficient):
        return None
    if not all(have_coefficient):
        vessel_without = ends[have_coefficient.index(False)][0]
        raise InputError(
            f"{vessel_without.place}: ends without Rt, where others have it; give all outlets the same kind"
        )
    coefficients = np.array([vessel.number("Rt", lowest=-1.0) for vessel, *_ in ends])
    ends[0][0].warn(REFLECTED())
    Z_c = np.array([_impedance(density, beta, radius) / (1e6 * PA) for _, density, beta, radius in ends])
    return ReflectionCoefficient(Z_c, coefficients)


def _impedance(density: float, beta: float, radius: float) -> float:
    """Return ρ c0/A0, Pa s/m³, with c0 = √(β/2ρ)."""
    return math.sqrt(density * beta / 2.0) / (math.pi * radius**2)


def _bed(vessel: _Vessel, density: float, beta: float, radius: float) -> tuple[float, float, float]:
    """Return R1, R2 and C of the bed behind a terminal vessel, mmHg s/ml and ml/mmHg."""
    if not (vessel.has("R1") and vessel.has("Cc")):
        raise InputError(f"{vessel.place}: ends without a Windkessel; give it R1, R2 and Cc, or Rt")
    first, second = vessel.number("R1"), vessel.number("R2", 0.0)
    matched = vessel.get("inlet_impedance_matching", False) is True
    if matched or not second:
        total = first + second
        first = _impedance(density, beta, radius)
        if not first < total:
            raise InputError(
                f"{vessel.place}: its resistance {total:.3g} Pa s/m³ lies below its own impedance {first:.3g}"
            )
        second = total - first
        vessel.warn(MATCHED(first=first, whole=total))
    return first / (1e6 * PA), second / (1e6 * PA), 1e6 * PA * vessel.number("Cc")


def _profile(network: Network, vessels: list[_Vessel], default: float) -> float:
    """Return the exponent of the velocity profile that dissipates as much of the mean flow as the vessels' own."""
    exponents = np.array([vessel.number("gamma_profile", default, lowest=-1.9) for vessel in vessels])
    if np.ptp(exponents) == 0:
        return float(exponents[0])
    weight = network.flow_fraction**2 * network.length / network.radius**4
    mean = float(np.sum(weight * (exponents + 2)) / np.sum(weight)) - 2.0
    vessels[0].warn(PROFILES(low=float(exponents.min()), high=float(exponents.max()), mean=float(mean)))
    return mean


def _inflow(path: Path, config: Mapping[str, Any], inlets: list[_Vessel]) -> Inflow:
    """Return the flow into all inlets, from the file that each names or, for the only one, the configuration."""
    return joined_inflow(path, [_cycle(_inlet_file(path, config, inlet, len(inlets) == 1)) for inlet in inlets])


def joined_inflow(path: Path, cycles: Sequence[tuple[np.ndarray, float]]) -> Inflow:
    """Return the flow into all inlets from the samples and the period of each; a period that differs is refused."""
    periods = [period for flow, period in cycles if np.ptp(flow) > 0] or [cycles[0][1]]  # a steady flow has any
    if max(periods) - min(periods) > _SAME_PERIOD * max(periods):
        raise InputError(f"{path}: the inlets' periods differ ({min(periods):g} to {max(periods):g} s); all vessels "
                         "need one")  # fmt: skip
    if len(cycles) == 1:
        return Inflow(*cycles[0])
    count = max(len(flow) for flow, _ in cycles)
    return Inflow(np.column_stack([resample(flow, count) for flow, _ in cycles]), periods[0])


def _inlet_file(path: Path, config: Mapping[str, Any], vessel: _Vessel, alone: bool) -> Path:
    """Return the file of the flow into a vessel, which lies beside the configuration."""
    if _word(vessel.place, "inlet", vessel.get("inlet", "Q")) != "Q":
        raise InputError(
            f"{vessel.place}: its inlet is '{vessel.values['inlet']}', not a flow (Q); give it the flow into it"
        )
    file_name = vessel.get("inlet file", vessel.get("inlet_file"))
    if file_name is None and not alone:
        raise InputError(f"{vessel.place}: one of several inlets, and names no 'inlet file'; give it the flow into it")
    if file_name is None:
        project = _word(str(path), "project_name", config.get("project_name", config.get("project name", "")))
        file_name = config.get("inlet_file") or config.get("inlet file") or f"{project}_inlet.dat"
    name = _word(vessel.place, "inlet file", file_name)
    if Path(name).is_absolute() or ".." in Path(name).parts:
        raise InputError(f"{path}: names an inlet outside its own folder ({name}); put that file beside it")
    return path.parent / name


def _cycle(file: Path) -> tuple[np.ndarray, float]:
    """Return evenly spaced samples of a flow, ml/s, and its period, s."""
    table = _two_columns(file)
    back = -np.diff(table[:, 0])
    if 0 < back.max(initial=0.0) <= _BACK * table[-1, 0]:  # a few rows go back a little in a curve read off by hand
        warn(DISORDERED(count=int(np.sum(back > 0)), most=1e3 * float(back.max())).at(str(file)), stacklevel=2)
        table = table[np.argsort(table[:, 0], kind="stable")]
    if np.abs(table[:, 1]).max() > _MOST_FLOW:
        raise InputError(
            f"{file}: {np.abs(table[:, 1]).max():.3g} m³/s is no flow; vasowave takes a flow into the root"
        )
    return even_cycle(str(file), table[:, 0], 1e6 * table[:, 1])


def even_cycle(place: str, time: np.ndarray, flow: np.ndarray) -> tuple[np.ndarray, float]:
    """Return evenly spaced samples of a flow over one period, whose last time is its end, and the period, s."""
    if len(time) < 2 or time[0] != 0 or not np.all(np.diff(time) > 0) or not np.isfinite(time[-1]):
        raise InputError(f"{place}: times must begin at 0 and increase; its last one is the period")
    steps, period = len(time) - 1, float(time[-1])
    even = np.allclose(np.diff(time), period / steps, rtol=1e-3) and math.isclose(
        flow[-1], flow[0], abs_tol=1e-3 * float(np.ptp(flow)) + 1e-300
    )
    if even and steps >= _FEWEST_SAMPLES // 16:
        return flow[:-1], period
    count = max(_FEWEST_SAMPLES, 4 * steps)
    return np.interp(np.arange(count) * period / count, time, flow), period


def _two_columns(file: Path) -> np.ndarray:
    rows = []
    for block in read_lines(file):
        for line, text in enumerate(block.texts, block.first):
            cells = text.replace(",", " ").split()
            if not cells:
                continue
            try:
                row = [number(cell) for cell in cells]
            except ValueError:
                row = []
            if len(row) != 2 or not np.all(np.isfinite(row)):
                raise InputError(f"{file}, line {line}: not a time and a flow; two numbers are needed in every line")
            rows.append(row)
    if not rows:
        raise InputError(f"{file}: the file is empty")
    return np.array(rows)
