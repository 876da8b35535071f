"""Finding a wall law or a bed by its name: one of ours, one that a package offers, or a class in a file of one's own.

``linear`` · ``our_laws:ExponentialWall`` (file and class, see `law_files`) · a wall law's name in the
entry points ``vasowave.walls``.
"""

import math
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from inspect import getattr_static, isfunction
from typing import Any

import numpy as np

from vasowave.base.descriptions import BedLaw, Law, Parameter, Quantity
from vasowave.base.errors import InputError, VasowaveError, did_you_mean
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.law_files import file_behind, in_words, module_of, named, plain
from vasowave.pulse.model.names import ParameterName
from vasowave.pulse.model.outlets import BUILT_IN as CIRCUITS
from vasowave.pulse.model.outlets import Bed, Site
from vasowave.pulse.model.structured_tree import BloodTree, StructuredTree
from vasowave.pulse.model.walls import BUILT_IN, WALL_VISCOSITY
from vasowave.pulse.network.network import Network

ENTRY_POINTS = "vasowave.walls"
"""Group of entry points in which a package offers wall laws."""

LAWS: dict[str, Any] = {law.law().name: law for law in BUILT_IN}
"""The laws of `walls` by name."""

OUR_BEDS: tuple[Any, ...] = (*CIRCUITS, StructuredTree, BloodTree)

BEDS: dict[str, Any] = {bed.bed().name: bed for bed in OUR_BEDS}
"""Our beds by name."""

_FORK = Network(("root", "a", "b"), np.array([-1, 0, 0]), np.full(3, 0.4), np.array([0.04, 0.03, 0.02]))
_SITE = Site(80.0, 0.1, 50.0, Blood())
"""A network, and what is known of it, at whose ends a foreign bed is tried."""

STRUCTURE = frozenset({
    "radius_scale", "length_scale", "k", "taper", "taper_scale", "image_pressure", "flow_gain", "flow_delay", "zero",
    "flow_zero", "pressure_lag", "pressure_inertia", "flow_lag", "pressure_gain", "viscosity", "wedge",
})  # fmt: skip
"""Numbers of a model that belong to no law: of the image, the instruments, the blood and the tree."""

_NOT_OF_WALLS = STRUCTURE | {"R_T", "tau", "a", "radius", "length", WALL_VISCOSITY}.union(
    *((*bed.bed().factors, *bed.bed().quantities) for bed in OUR_BEDS)
)
"""Short names that no parameter of a wall has: those of beds, and of what a sweep changes beside them."""

_NEEDED = ("law", "pressure_at", "ratio_at", "slope_at", "limits")
_PRESSURES = np.array([0.05, 0.3, 1.0, 2.0])  # at which a foreign law is tried, in units of 20 mmHg
_TOLERANCE = 1e-5  # relative, of identities between the equations of a law
_MOST_PARAMETERS = 4  # that the kernels can hand over
_UNITS = ("mmHg", "1")
_LONGEST = 40  # letters of a law's name, which names what is stored


def find_law(wall: str | type) -> Any:
    """Return the wall law of a name, or the class itself, once its equations agree with each other.

    Parameters
    ----------
    wall : str or class
        ``linear``, ``tangent``, … (`LAWS`); the name of an entry point; ``our_laws:Class`` for the class in
        ``our_laws.py`` beside the file that names it or, typed, in the folder you are in; ``package.module:Class`` of
        an installed module; or a law's class.

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
    if _names_class(wall):
        return _checked(_imported(wall, "wall law"))
    offered = {point.name: point for point in entry_points(group=ENTRY_POINTS)}
    if wall in offered:
        return _checked(offered[wall].load())
    raise _unknown("wall law", wall, [*LAWS, *offered])


def find_bed(bed: str | type) -> Any:
    """Return the kind of beds of a name (``windkessel``, ``tree``, …; ``our_beds:Class``), or the class.

    Raises
    ------
    InputError
        No such beds, or a class whose description and equations contradict each other.

    Examples
    --------
    >>> find_bed("rc").__name__
    'CompliantBed'
    """
    if isinstance(bed, str) and bed not in BEDS and not _names_class(bed):
        raise _unknown("beds", bed, [*BEDS])
    kind = bed if not isinstance(bed, str) else BEDS.get(bed) or _imported(bed, "bed")
    return kind if kind in OUR_BEDS else _checked_bed(kind)


def _names_class(name: str) -> bool:
    """Whether a name is that of a class in a module: ``our_laws:Class``."""
    module, colon, attribute = (piece.strip() for piece in name.partition(":"))
    return bool(module and colon and attribute)


def _unknown(kind: str, name: str, names: Sequence[str]) -> InputError:
    """Return the error that says which names there are."""
    hint = "name one; " if "," in name else ""
    return InputError(
        f"unknown {kind} '{name}'{did_you_mean(name, names)}; {hint}choose from: {', '.join(names)}, or name a class "
        "of your own as module:Class"
    )


def described(kind: Any) -> Any:
    """Return what is said of a wall law or a bed (its class)."""
    return kind.bed() if issubclass(kind, Bed) else kind.law()


def identity(kind: Any) -> str:
    """Return the name by which a law or bed (its class) is found again: ``linear``, or file or module, and class."""
    return described(kind).name if _is_ours(kind) else f"{file_behind(kind.__module__)}:{kind.__qualname__}"


def parameter_name(kind: Any, field: str) -> ParameterName:
    """Return the name that a parameter of a law or bed (its class) has in fits, results and commands.

    Its text is the field where nothing else of a model can have it. What comes from elsewhere, and what is called like
    another number of a model, lends the name of its law: ``exponential.k``.
    """
    owner, taken = ("bed", STRUCTURE) if issubclass(kind, Bed) else ("wall", _NOT_OF_WALLS)
    alone = _is_ours(kind) and field not in taken
    return ParameterName(owner, field, field if alone else f"{described(kind).name}.{field}")


def _is_ours(kind: Any) -> bool:
    return kind in LAWS.values() or kind in BEDS.values()


def bed_factors(bed: Any) -> dict[ParameterName, Parameter]:
    """Return the factors of a kind of beds (its class) that are fitted, by their names."""
    return {parameter_name(bed, name): parameter for name, parameter in bed.bed().factors.items()}


def bed_quantities(bed: Any) -> dict[ParameterName, Quantity]:
    """Return what the fields of a kind of beds (its class) are, by their names, in the order of the fields."""
    return {parameter_name(bed, name): quantity for name, quantity in bed.bed().quantities.items()}


def wall_parameters(law: Any) -> dict[ParameterName, Parameter]:
    """Return the parameters of a law (its class) by their names, in the order of its fields."""
    return {
        parameter_name(law, field): parameter
        for field, parameter in zip(law._fields, law.law().parameters, strict=True)
    }


def parameter_names(law: Any) -> tuple[ParameterName, ...]:
    """Return the names of all parameters of a law (its class), in the order of its fields."""
    return tuple(parameter_name(law, field) for field in law._fields)


def _imported(name: str, kind: str) -> Any:
    """Return the class of a name, from the file that the name says or else from an installed module."""
    wall = named(name)
    module, _, attribute = wall.partition(":")
    if "@" in module:
        namespace: Any = module_of(module, wall)
    else:
        try:
            namespace = import_module(module)
        except Exception as error:
            reason = "no such module is installed" if isinstance(error, ModuleNotFoundError) else repr(error)
            raise InputError(
                f"{kind} '{name}': {reason}, and there is no {module}.py in the folder you are in"
            ) from None
    law = getattr(namespace, attribute, None) if attribute else None
    if law is None:
        raise InputError(f"{kind} '{plain(name)}': {getattr(namespace, '__file__', module)} has no '{attribute}'")
    return law


def _checked(law: Any) -> Any:
    """Return a foreign law whose description and equations agree; see `walls` for what they are."""
    if not isinstance(law, type):
        raise InputError(f"{law!r} is not a wall law: give the name of one, or a class")
    return _checked_class(law)


@cache
def _checked_class(law: Any) -> Any:
    missing = [method for method in _NEEDED if not callable(getattr(law, method, None))]
    if not isinstance(getattr(law, "_fields", None), tuple) or missing:
        raise InputError(
            f"{law!r} is not a wall law: a NamedTuple class with the static methods {', '.join(_NEEDED)} is needed"
            + (f" (missing: {', '.join(missing)})" if missing else "")
        )
    try:
        with np.errstate(all="ignore"), in_words():
            description = law.law()
            check_description(law, description)
            if LAWS.get(description.name, law) is not law:
                raise InputError(f"wall law '{description.name}': take another name, one word that no other law has")
            _check_equations(law, [parameter.nominal * parameter.scale(50.0) for parameter in description.parameters])
    except VasowaveError:
        raise
    except Exception as error:
        raise InputError(f"{law!r} is not a wall law: {type(error).__name__}: {error}; correct it") from None
    for method in _NEEDED:  # on the class alone another kind may work, but not on its values or in compiled code
        if not isfunction(getattr(getattr_static(law, method), "__func__", None)) or not isfunction(
            getattr(law, method)
        ):
            raise InputError(f"{law!r} is not a wall law: write @staticmethod above {method}, once and nothing else")
    return law


def _check_equations(law: Any, parameters: list[float]) -> None:
    """Try the identities between pressure, area and slope at nominal parameters of a mouse (β0 = 50 mmHg)."""
    p, name = 20.0 * _PRESSURES, law.law().name
    ratio, slope = law.ratio_at(p, *parameters), law.slope_at(p, *parameters)
    for identity, values in (
        ("ratio_at", ratio),
        ("slope_at", slope),
        ("pressure_at", law.pressure_at(ratio, *parameters)),
    ):
        if np.shape(values) != p.shape or np.asarray(values).dtype.kind != "f":
            raise InputError(f"wall law '{name}': {identity} does not return one real number for each of its arguments")
    if len(law.limits(*parameters)) != 2 or not np.all(np.greater(*law.limits(*parameters)[::-1])):
        raise InputError(f"wall law '{name}': limits must return two area ratios, the smaller first")
    h = 1e-4 * p
    numerical = (law.ratio_at(p + h, *parameters) - law.ratio_at(p - h, *parameters)) / (2 * h)
    for identity, values, expected in (
        ("ratio_at(0) is 1", np.asarray(law.ratio_at(0.0, *parameters)), np.asarray(1.0)),
        ("pressure_at(ratio_at(p)) is p", law.pressure_at(ratio, *parameters), p),
        ("slope_at(p) is the derivative of ratio_at", slope, numerical),
    ):
        if not np.allclose(values, expected, rtol=_TOLERANCE, atol=0):
            raise InputError(
                f"wall law '{name}': that {identity} does not hold at the nominal parameters "
                f"{', '.join(f'{value:.4g}' for value in parameters)}; correct its equations"
            )
    if not np.all(slope > 0):
        raise InputError(f"wall law '{name}': its area does not grow with pressure (slope_at must be positive)")


@cache
def _checked_bed(kind: Any) -> Any:
    """Return foreign beds whose description and equations agree; see `outlets` for what they are."""
    if not (isinstance(kind, type) and issubclass(kind, Bed) and kind._fields):
        raise InputError(
            f"{kind!r} is not a bed: give the name of one, or a class derived from vasowave.pulse.model.outlets.Bed"
        )
    try:
        with np.errstate(all="ignore"), in_words():
            description = kind.bed()
            _check_bed_description(kind, description)
            beds = kind.of(_FORK, _SITE)
            circuit = [np.asarray(array) for array in beds.circuit() or ()]
            total = beds.total_resistance() if len(circuit) in (0, 3) else np.nan
    except VasowaveError:
        raise
    except Exception as error:
        raise InputError(f"{kind!r} is not a bed: {type(error).__name__}: {error}; correct it") from None
    if circuit and (
        len(circuit) != 3
        or any(array.shape != (2,) or not np.all(np.isfinite(array) & (array >= 0)) for array in circuit)
    ):
        raise InputError(
            f"bed '{description.name}': circuit() must return three arrays, a number of 0 or more for each terminal"
        )
    if not np.isclose(total, _SITE.resistance, rtol=_TOLERANCE):
        raise InputError(
            f"bed '{description.name}': nominal(resistance, time_constant) does not have that resistance; correct it"
        )
    if circuit and np.any((circuit[1] > 0) != (circuit[2] > 0)):
        raise InputError(f"bed '{description.name}': a compliance needs a distal resistance, and that a compliance")
    return kind


def _check_bed_description(kind: Any, description: Any) -> None:
    if (
        not isinstance(description, BedLaw)
        or not str(description.name).isidentifier()
        or description.name in (*LAWS, *BEDS)
    ):
        raise InputError(f"{kind!r} is not a bed: its bed() must return a BedLaw with a name of its own, one word")
    fitted = description.fitted or kind._fields
    if (
        tuple(description.quantities) != kind._fields
        or len(description.factors) != len(fitted)
        or not set(fitted) <= {*kind._fields}
    ):
        raise InputError(
            f"bed '{description.name}' has the fields {', '.join(kind._fields)}; describe each, with one factor each"
        )
    if description.shared is not None and not set(description.shared) <= set(description.factors):
        raise InputError(f"bed '{description.name}': shared must name two of its factors")
    for name, factor in description.factors.items():
        check_parameter(f"bed '{description.name}', factor '{name}'", factor)
        if factor.unit != "1":
            raise InputError(f"bed '{description.name}', factor '{name}': a factor is a pure number, its unit 1")


def check_description(law: Any, description: Any) -> None:
    """Raise `InputError` unless `description` is a whole description of the class `law`."""
    if not isinstance(description, Law):
        raise InputError(f"{law!r} is not a wall law: its law() must return a vasowave.base.descriptions.Law")
    texts = (description.name, description.title, description.formula, description.equation, description.stiffness)
    if (
        not all(isinstance(text, str) for text in texts)
        or not description.name.isidentifier()
        or len(description.name) > _LONGEST
    ):
        raise InputError(
            f"wall law {description.name!r}: its name must be one word of at most {_LONGEST} letters, and title, "
            "formula, equation and stiffness texts"
        )
    fields, parameters = law._fields, description.parameters
    if not isinstance(parameters, tuple) or not 0 < len(fields) == len(parameters) <= _MOST_PARAMETERS:
        raise InputError(
            f"wall law '{description.name}' has the fields {', '.join(fields)} and describes {parameters!r:.60}; "
            f"describe each field once, at most {_MOST_PARAMETERS}"
        )
    for name, parameter in zip(fields, parameters, strict=True):
        check_parameter(f"wall law '{description.name}', parameter '{name}'", parameter)
    if description.ratio is not None and not (
        len(description.ratio) == 2 and isinstance(description.ratio[1], Quantity)
    ):
        raise InputError(f"wall law '{description.name}': ratio must be a name and a Quantity")
    if description.stiffness not in ("stiffness", *fields, *([description.ratio[0]] if description.ratio else [])):
        raise InputError(
            f"wall law '{description.name}': its stiffness '{description.stiffness}' is none of its parameters"
        )
    if description.linear_at is not None and not (
        description.linear_at[0] in fields and _is_number(description.linear_at[1])
    ):
        raise InputError(f"wall law '{description.name}': linear_at must be one of its parameters and a number")


def check_parameter(place: str, parameter: Any) -> None:
    """Raise `InputError`, which begins with `place`, unless `parameter` describes a parameter."""
    if reason := _wrong(parameter):
        raise InputError(f"{place}: {reason}")


def _wrong(parameter: Any) -> str:
    """Return what is wrong with the description of a parameter."""
    if not isinstance(parameter, Parameter):
        return "is described by no vasowave.base.descriptions.Parameter"
    if not all(isinstance(text, str) for text in parameter[:4]):
        return "its unit, symbol, meaning and equation must be texts"
    if parameter.unit not in _UNITS:
        return f"its unit is '{parameter.unit}'; write mmHg for a pressure, 1 for a pure number"
    spans = [parameter.bounds, *([parameter.paper_bounds] if parameter.paper_bounds is not None else [])]
    if not all(isinstance(span, tuple) and len(span) == 2 and all(map(_is_number, span)) for span in spans):
        return "its bounds must be two numbers"
    if not _is_number(parameter.nominal) or not all(0 < low < high for low, high in spans):
        return "its nominal value must be a number, and its bounds positive and ordered"
    if not parameter.bounds[0] <= parameter.nominal <= parameter.bounds[1]:
        low, high = parameter.bounds
        return f"its nominal value {parameter.nominal:g} lies outside its bounds {low:g} to {high:g}"
    return ""


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)
