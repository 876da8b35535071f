"""Lines through numbered points, as VTK PolyData holds them."""

from dataclasses import dataclass, field

import numpy as np

from vasowave.errors import InputError


@dataclass(frozen=True, eq=False)
class PolyLines:
    """Lines through numbered points.

    Attributes
    ----------
    points : float array, shape (point, 3)
        x, y, z in the unit of the file.
    lines : tuple of int array
        Numbers of the points of each line, in order.
    fields : dict of str to array, shape (point,) or (point, component)
        Values at the points.
    cells : dict of str to array, shape (line,) or (line, component)
        Values of the lines.
    """

    points: np.ndarray
    lines: tuple[np.ndarray, ...]
    fields: dict[str, np.ndarray]
    cells: dict[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check that lines and values refer to the points there are."""
        count = len(self.points)
        if self.points.ndim != 2 or self.points.shape[1] != 3 or not np.isfinite(self.points).all():
            raise InputError("points are not finite triples x, y, z; write the file again")
        for number, line in enumerate(self.lines):
            if len(line) and (line.min() < 0 or line.max() >= count):
                raise InputError(f"line {number} names a point that does not exist ({count} points)")
        for name, values in self.fields.items():
            if len(values) != count:
                raise InputError(f"array '{name}' has {len(values)} values for {count} points")
        object.__setattr__(self, "cells", {k: v for k, v in self.cells.items() if len(v) == len(self.lines)})
