"""Finding a wall law by its name: one of `walls`, one that a package offers, or a class in a file of one's own.

``linear`` · ``our_laws:ExponentialWall`` (file and class, see `law_files`) · a name in the entry points
``vasowave.walls``.
"""

from collections.abc import Sequence
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any

import numpy as np

from vasowave.errors import InputError, VasowaveError, did_you_mean
from vasowave.law_description import check_description
from vasowave.law_files import in_words, module_of, named, plain
from vasowave.walls import BUILT_IN

ENTRY_POINTS = "vasowave.walls"
"""Group of entry points in which a package offers wall laws."""

LAWS: dict[str, Any] = {law.law().name: law for law in BUILT_IN}
"""The laws of `walls` by name."""

_NEEDED = ("law", "pressure_at", "ratio_at", "slope_at", "limits")
_PRESSURES = np.array([0.05, 0.3, 1.0, 2.0])  # at which a foreign law is tried, in units of 20 mmHg
_TOLERANCE = 1e-5  # relative, of identities between the equations of a law


def find_law(wall: str | type) -> Any:
    """Return the wall law of a name, or the class itself, once its equations agree with each other.

    Parameters
    ----------
    wall : str or class
        ``linear``, ``tangent``, … (`LAWS`); the name of an entry point; ``our_laws:Class`` for the class in
        ``our_laws.py`` in the folder of the study or, without a study, in the one you are in; ``package.module:Class``
        of an installed module; or a law's class.

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


def _imported(name: str) -> Any:
    """Return the class of a name, from the file that the name says or else from an installed module."""
    wall = named(name)
    module, _, attribute = wall.partition(":")
    if "@" in module:
        found: Any = module_of(module, wall)
    else:
        try:
            found = import_module(module)
        except Exception as error:
            why = "no such module is installed" if isinstance(error, ModuleNotFoundError) else repr(error)
            raise InputError(
                f"wall law '{name}': {why}, and there is no {module}.py in the folder of the study (or, without a "
                "study, in the one you are in)"
            ) from None
    law = getattr(found, attribute, None) if attribute else None
    if law is None:
        raise InputError(f"wall law '{plain(name)}': {getattr(found, '__file__', module)} has no '{attribute}'")
    return law


def _checked(law: Any) -> Any:
    """Return a foreign law whose description and equations agree; see `walls` for what they are."""
    if not isinstance(law, type):
        raise InputError(f"{law!r} is not a wall law: give the name of one, or a class")
    return _checked_class(law)


@cache
def _checked_class(law: Any) -> Any:
    missing = [part for part in _NEEDED if not callable(getattr(law, part, None))]
    if not isinstance(getattr(law, "_fields", None), tuple) or missing:
        raise InputError(
            f"{law!r} is not a wall law: a NamedTuple class with the static methods {', '.join(_NEEDED)} is needed"
            + (f" (missing: {', '.join(missing)})" if missing else "")
        )
    try:
        with np.errstate(all="ignore"), in_words():
            said = law.law()
            check_description(law, said)
            if LAWS.get(said.name, law) is not law:
                raise InputError(f"wall law '{said.name}': take another name, one word that no other law has")
            _check_equations(law, [one.nominal * one.scale(50.0) for one in said.parameters])
    except VasowaveError:
        raise
    except Exception as error:
        raise InputError(f"{law!r} is not a wall law: {type(error).__name__}: {error}; correct it") from None
    return law


def _check_equations(law: Any, parameters: list[float]) -> None:
    """Try the identities between pressure, area and slope at nominal parameters of a mouse (β0 = 50 mmHg)."""
    p, name = 20.0 * _PRESSURES, law.law().name
    ratio, slope = law.ratio_at(p, *parameters), law.slope_at(p, *parameters)
    for what, one in (("ratio_at", ratio), ("slope_at", slope), ("pressure_at", law.pressure_at(ratio, *parameters))):
        if np.shape(one) != p.shape or np.asarray(one).dtype.kind != "f":
            raise InputError(f"wall law '{name}': {what} does not return one real number for each of its arguments")
    if len(law.limits(*parameters)) != 2 or not np.all(np.greater(*law.limits(*parameters)[::-1])):
        raise InputError(f"wall law '{name}': limits must return two area ratios, the smaller first")
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
