"""Parameters as one number for all vessels or one for each, kept as one for each and checked once."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vasowave.base.errors import InputError


def one_per_vessel(values: Any, names: Sequence[str], kind: str, minima: Mapping[str, float] | None = None) -> Any:
    """Return a named tuple of parameters with every field as a read-only array over the vessels `names`.

    All must be positive but those of which `minima` says how low they may be.

    Raises
    ------
    InputError
        A parameter of another shape, or one that is not positive and finite; the vessel is named.
    """
    fields = zip(values._fields, values, strict=True)
    return type(values)(*(_row(name, value, names, kind, (minima or {}).get(name)) for name, value in fields))


def _row(name: str, value: Any, names: Sequence[str], kind: str, minimum: float | None) -> np.ndarray:
    try:
        numbers = np.asarray(value, dtype=float)
        array = np.full(len(names), numbers) if numbers.ndim == 0 else np.array(np.broadcast_to(numbers, (len(names),)))
    except (TypeError, ValueError):
        raise InputError(
            f"{kind} parameter {name} has shape {np.shape(value)}; give one number or {len(names)} values"
        ) from None
    good = np.isfinite(array) & (array > 0 if minimum is None else array >= minimum)
    if not good.all():
        bad = np.flatnonzero(~good)
        raise InputError(
            f"vessel '{names[bad[0]]}': {kind} parameter {name} = {array[bad[0]]:g}; it must be "
            + ("positive and finite" if minimum is None else f"a number of {minimum:g} or more")
        )
    array.setflags(write=False)
    return array
