"""What the kernels may call of a wall law, chosen by its type when the kernel is compiled.

The equations stand in `vasowave.pulse.model.walls`; here they are only handed to the compiler. A new wall law needs
nothing here.
"""

from typing import Any

from numba.extending import overload, register_jitable

from vasowave.pulse.model import walls
from vasowave.pulse.solver import powers

# Numba cannot unpack a tuple of arrays at one index, so the call is written out by the count of parameters.
_CALL = {
    1: lambda law: lambda wall, j, x: law(x, wall[0][j]),
    2: lambda law: lambda wall, j, x: law(x, wall[0][j], wall[1][j]),
    3: lambda law: lambda wall, j, x: law(x, wall[0][j], wall[1][j], wall[2][j]),
    4: lambda law: lambda wall, j, x: law(x, wall[0][j], wall[1][j], wall[2][j], wall[3][j]),
}


def pressure_at(wall, j, x):
    """Pressure, mmHg, at area ratio x in cell j."""
    raise NotImplementedError("compiled code only")


def ratio_at(wall, j, x):
    """Area ratio at pressure x (mmHg) in cell j."""
    raise NotImplementedError("compiled code only")


def slope_at(wall, j, x):
    """Derivative of the area ratio, 1/mmHg, at pressure x in cell j."""
    raise NotImplementedError("compiled code only")


def _hand_over(name: str, stub: Any) -> None:
    @overload(stub)
    def choose(wall, j, x):
        law_class = wall.instance_class
        return _CALL[len(law_class._fields)](register_jitable(getattr(law_class, name)))


for _stub in (pressure_at, ratio_at, slope_at):
    _hand_over(_stub.__name__, _stub)

overload(walls.tangent)(lambda x: powers.tangent)
overload(walls.arctangent)(lambda x: powers.arctangent)
overload(walls.power)(lambda x, m: powers.power)
register_jitable(walls.collapsed)
