"""Parameters as one number for all vessels or one for each, kept as one for each and checked once."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vasowave.errors import InputError


def one_per_vessel(values: Any, names: Sequence[str], what: str, least: Mapping[str, float] | None = None) -> Any:
    """Return a named tuple of parameters with every field as a read-only array over the vessels `names`.

    All must be positive but those of which `least` says how low they may be.

    Raises
    ------
    InputError
        A parameter of another shape, or one that is not positive and finite; the vessel is named.
    """
    given = zip(values._fields, values, strict=True)
    return type(values)(*(_row(name, value, names, what, (least or {}).get(name)) for name, value in given))


def _row(name: str, value: Any, names: Sequence[str], what: str, least: float | None) -> np.ndarray:
    try:
        given = np.asarray(value, dtype=float)
        array = np.full(len(names), given) if given.ndim == 0 else np.array(np.broadcast_to(given, (len(names),)))
    except (TypeError, ValueError):
        raise InputError(
            f"{what} parameter {name} has shape {np.shape(value)}; give one number or {len(names)} values"
        ) from None
    good = np.isfinite(array) & (array > 0 if least is None else array >= least)
    if not good.all():
        bad = np.flatnonzero(~good)
        raise InputError(
            f"vessel '{names[bad[0]]}': {what} parameter {name} = {array[bad[0]]:g}; it must be "
            + ("positive and finite" if least is None else f"a number of {least:g} or more")
        )
    array.setflags(write=False)
    return array
