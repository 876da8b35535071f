"""Finding a wall law by its name: one of `walls`, one that a package offers, or a class in a file of one's own.

``linear`` · ``my_laws:ExponentialWall`` (module and class) · a name in the entry points ``vasowave.walls``.
"""

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.errors import InputError, did_you_mean
from vasowave.walls import BUILT_IN

ENTRY_POINTS = "vasowave.walls"
"""Group of entry points in which a package offers wall laws."""

LAWS: dict[str, Any] = {law.law().name: law for law in BUILT_IN}
"""The laws of `walls` by name."""

_NEEDED = ("law", "pressure_at", "ratio_at", "slope_at", "limits")
_MOST_PARAMETERS = 4  # that the kernels can hand over
_PRESSURES = np.array([0.05, 0.3, 1.0, 2.0])  # at which a foreign law is tried, in units of 20 mmHg
_TOLERANCE = 1e-5  # relative, of identities between the equations of a law


def find_law(wall: str | type) -> Any:
    """Return the wall law of a name, or the class itself, once its equations agree with each other.

    Parameters
    ----------
    wall : str or class
        ``linear``, ``tangent``, … (`LAWS`); the name of an entry point; ``module:Class`` of an importable module; or a
        law's class.

    Raises
    ------
    InputError
        No such law, or one whose equations contradict each other.

    Examples
    --------
    >>> find_law("linear").__name__
    'LinearWall'
    """
    if not isinstance(wall, str):
        return wall if wall in LAWS.values() else _checked(wall)
    if wall in LAWS:
        return LAWS[wall]
    if ":" in wall:
        return _checked(_imported(wall))
    offered = {point.name: point for point in entry_points(group=ENTRY_POINTS)}
    if wall in offered:
        return _checked(offered[wall].load())
    known = [*LAWS, *offered]
    raise InputError(
        f"unknown wall law '{wall}'{did_you_mean(wall, known)}; choose from: {', '.join(known)}, or name a class of "
        "your own as module:Class"
    )


def law_parameters(walls: Sequence[str | type]) -> dict[str, str]:
    """Return the names of the laws' own parameters and their units."""
    return {
        name: parameter.unit
        for law in map(find_law, walls)
        for name, parameter in zip(law._fields, law.law().parameters, strict=True)
    }


def look_in(folder: Path) -> None:
    """Let laws named ``module:Class`` be found in `folder` from now on, after everything that is installed."""
    place = str(Path(folder).resolve())
    if place not in sys.path:
        sys.path.append(place)


def law_file(wall: str) -> Path | None:
    """Return the file of a law named ``module:Class``, None for the others: what it says enters a result."""
    source = getattr(sys.modules.get(find_law(wall).__module__), "__file__", None) if ":" in wall else None
    return Path(source) if source else None


def _imported(name: str) -> Any:
    look_in(Path.cwd())
    module, _, attribute = name.partition(":")
    try:
        return getattr(import_module(module), attribute)
    except ImportError as error:
        places = "the folder of the study or the one you are in"
        raise InputError(f"wall law '{name}': {error}; the module must lie in {places}, or be installed") from None
    except AttributeError:
        where = getattr(sys.modules.get(module), "__file__", module)
        raise InputError(f"wall law '{name}': {where} has no '{attribute}'") from None


def _checked(law: Any) -> Any:
    """Return a foreign law whose description and equations agree; see `walls` for what they are."""
    missing = [part for part in _NEEDED if not callable(getattr(law, part, None))]
    if not isinstance(law, type) or not hasattr(law, "_fields") or missing:
        raise InputError(
            f"{law!r} is not a wall law: a NamedTuple class with the static methods {', '.join(_NEEDED)} is needed"
            + (f" (missing: {', '.join(missing)})" if missing else "")
        )
    kind: Any = law
    said = kind.law()
    if not 0 < len(kind._fields) == len(said.parameters) <= _MOST_PARAMETERS:
        raise InputError(
            f"wall law '{said.name}' has the fields {', '.join(kind._fields)} and describes {len(said.parameters)} "
            f"parameters; describe each field once, at most {_MOST_PARAMETERS}"
        )
    if LAWS.get(said.name, law) is not law or not said.name.isidentifier():
        raise InputError(f"wall law '{said.name}': take another name, one word that no other law has")
    _check_equations(law, [one.nominal * one.scale(50.0) for one in said.parameters])
    return law


def _check_equations(law: Any, parameters: list[float]) -> None:
    """Try the identities between pressure, area and slope at nominal parameters of a mouse (β0 = 50 mmHg)."""
    p, name = 20.0 * _PRESSURES, law.law().name
    ratio, slope = law.ratio_at(p, *parameters), law.slope_at(p, *parameters)
    h = 1e-4 * p
    numerical = (law.ratio_at(p + h, *parameters) - law.ratio_at(p - h, *parameters)) / (2 * h)
    for what, one, other in (
        ("ratio_at(0) is 1", np.asarray(law.ratio_at(0.0, *parameters)), np.asarray(1.0)),
        ("pressure_at(ratio_at(p)) is p", law.pressure_at(ratio, *parameters), p),
        ("slope_at(p) is the derivative of ratio_at", slope, numerical),
    ):
        if not np.allclose(one, other, rtol=_TOLERANCE, atol=0):
            raise InputError(
                f"wall law '{name}': that {what} does not hold at the nominal parameters "
                f"{', '.join(f'{value:.4g}' for value in parameters)}; correct its equations"
            )
    if not np.all(slope > 0):
        raise InputError(f"wall law '{name}': its area does not grow with pressure (slope_at must be positive)")
