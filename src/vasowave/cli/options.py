"""Options that are more than their type: ``name=value``, ``name=low:high``, ``kind:number``, a file to write."""

from collections.abc import Mapping, Sequence
from typing import Any

from vasowave.blood import Blood, BoundaryLayer, Friction, Poiseuille, PowerLaw
from vasowave.calibration.parameters import fitted_parameters
from vasowave.errors import InputError, did_you_mean

_WALLS = {"linear": ("linear",), "tangent": ("tangent",), "both": ("linear", "tangent")}


def walls_named(text: str) -> tuple[str, ...]:
    """Return the wall laws of ``--wall``."""
    if text not in _WALLS:
        raise InputError(f"--wall {text}{did_you_mean(text, _WALLS)}: choose one of {', '.join(_WALLS)}")
    return _WALLS[text]


def read_held(options: Sequence[str]) -> dict[str, float]:
    """Return the parameters of ``--hold name=value`` and their values."""
    return {name: _number("--hold", option, value) for option in options for name, value in [_pair("--hold", option)]}


def read_bounds(options: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return the bounds of ``--bounds name=low:high``."""
    found = {}
    for option in options:
        name, span = _pair("--bounds", option)
        low, colon, high = span.partition(":")
        if not colon:
            raise InputError(f"--bounds {option}: write name=low:high, for example beta=20:90")
        found[name] = _number("--bounds", option, low), _number("--bounds", option, high)
    return found


def read_friction(text: str) -> Blood:
    """Return the paper's blood with the friction of ``--friction``."""
    kind, _, number = text.partition(":")
    frictions = ("local", "fixed", "poiseuille", "power-law")
    if kind not in frictions:
        raise InputError(f"--friction {text}{did_you_mean(kind, frictions)}: choose one of {', '.join(frictions)}")
    if (kind in ("fixed", "power-law")) != bool(number):
        raise InputError(f"--friction {text}: write local, fixed:0.07, poiseuille or power-law:9")
    value = _number("--friction", text, number) if number else 0.0
    friction: Friction = BoundaryLayer()
    if kind == "fixed":
        friction = BoundaryLayer(value)
    elif kind == "power-law":
        friction = PowerLaw(value)
    elif kind == "poiseuille":
        friction = Poiseuille()
    return Blood(friction=friction)


def for_wall(law: str, laws: Sequence[str], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return `values` (by parameter) without those that only another of the wall laws has."""
    own = set(fitted_parameters(law))
    foreign = {name for other in laws for name in fitted_parameters(other)} - own
    return {name: value for name, value in values.items() if name not in foreign}


def _pair(option: str, text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        raise InputError(f"{option} {text}: write a parameter's name, an equals sign and its value")
    return name.strip(), value.strip()


def _number(option: str, text: str, part: str) -> float:
    try:
        return float(part)
    except ValueError:
        raise InputError(f"{option} {text}: '{part}' is not a number") from None
