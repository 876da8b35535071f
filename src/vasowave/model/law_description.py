"""What a law from elsewhere says of itself, checked before anything relies on it."""

import math
from typing import Any

from vasowave.descriptions import Law, Parameter, Quantity
from vasowave.errors import InputError

_MOST_PARAMETERS = 4  # that the kernels can hand over
_UNITS = ("mmHg", "1")
_STORED = ("averages", "beats", "laws", "measured", "network", "nominal", "recording", "selection")  # beside the laws
_LONGEST = 40  # letters of a law's name, which names what is stored


def check_description(law: Any, said: Any) -> None:
    """Raise `InputError` unless `said` is a whole description of the class `law`."""
    if not isinstance(said, Law):
        raise InputError(f"{law!r} is not a wall law: its law() must return a vasowave.descriptions.Law")
    texts = (said.name, said.title, said.formula, said.equation, said.stiffness)
    if not all(isinstance(one, str) for one in texts) or not said.name.isidentifier() or len(said.name) > _LONGEST:
        raise InputError(
            f"wall law {said.name!r}: its name must be one word of at most {_LONGEST} letters, and title, formula, "
            "equation and stiffness texts"
        )
    if said.name in _STORED:
        raise InputError(f"wall law '{said.name}': a part of every result has this name; take another")
    fields, parameters = law._fields, said.parameters
    if not isinstance(parameters, tuple) or not 0 < len(fields) == len(parameters) <= _MOST_PARAMETERS:
        raise InputError(
            f"wall law '{said.name}' has the fields {', '.join(fields)} and describes {parameters!r:.60}; describe "
            f"each field once, at most {_MOST_PARAMETERS}"
        )
    for name, one in zip(fields, parameters, strict=True):
        check_parameter(f"wall law '{said.name}', parameter '{name}'", one)
    if said.ratio is not None and not (len(said.ratio) == 2 and isinstance(said.ratio[1], Quantity)):
        raise InputError(f"wall law '{said.name}': ratio must be a name and a Quantity")
    if said.stiffness not in ("stiffness", *fields, *([said.ratio[0]] if said.ratio else [])):
        raise InputError(f"wall law '{said.name}': its stiffness '{said.stiffness}' is none of its parameters")
    if said.linear_at is not None and not (said.linear_at[0] in fields and _is_number(said.linear_at[1])):
        raise InputError(f"wall law '{said.name}': linear_at must be one of its parameters and a number")


def check_parameter(place: str, one: Any) -> None:
    """Raise `InputError`, which begins with `place`, unless `one` describes a parameter."""
    if why := _wrong(one):
        raise InputError(f"{place}: {why}")


def _wrong(one: Any) -> str:
    """Return what is wrong with the description of a parameter."""
    if not isinstance(one, Parameter):
        return "is described by no vasowave.descriptions.Parameter"
    if not all(isinstance(text, str) for text in one[:4]):
        return "its unit, symbol, meaning and equation must be texts"
    if one.unit not in _UNITS:
        return f"its unit is '{one.unit}'; write mmHg for a pressure, 1 for a pure number"
    spans = [one.bounds, *([one.paper_bounds] if one.paper_bounds is not None else [])]
    if not all(isinstance(span, tuple) and len(span) == 2 and all(map(_is_number, span)) for span in spans):
        return "its bounds must be two numbers"
    if not _is_number(one.nominal) or not all(0 < low < high for low, high in spans):
        return "its nominal value must be a number, and its bounds positive and ordered"
    if not one.bounds[0] <= one.nominal <= one.bounds[1]:
        return f"its nominal value {one.nominal:g} lies outside its bounds {one.bounds[0]:g} to {one.bounds[1]:g}"
    return ""


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)
