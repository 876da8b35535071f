"""The compiled scheme inside the vessels: two-step Lax-Wendroff, on all slots of the network at once.

One step goes from level n to n + 1. At the half step between, every face has a state (A, q, p): inner faces by the
first Lax-Wendroff step, vessel ends from their node. The cells then take the difference of the faces' fluxes, so
whatever volume leaves a cell enters its neighbour, and the network keeps volume to round-off.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numba.core import ir
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.ir_utils import build_definitions
from numba.core.untyped_passes import InlineInlinables

from vasowave.pulse.solver.laws import pressure_at, slope_at

_PURE = "getattr", "static_getitem", "build_tuple", "exhaust_iter"


@register_pass(mutates_CFG=False, analysis_only=False)
class DropUnused(FunctionPass):
    """Drop what is read and not used: arguments of functions that do nothing, of a hundred arrays each."""

    _name = "drop_unused"

    def __init__(self) -> None:
        FunctionPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        """Return whether anything was dropped."""
        dropped, blocks = False, state.func_ir.blocks.values()
        while unused := _unused(blocks):
            for block in blocks:
                block.body = [line for line in block.body if id(line) not in unused]
            dropped = True
        if dropped:
            state.func_ir._definitions = build_definitions(state.func_ir.blocks)
        return dropped


def _unused(blocks: Any) -> set[int]:
    """Return the identities of assignments without effect whose target nothing reads."""
    lines = [line for block in blocks for line in block.body]
    read: set[str] = set()
    for line in lines:
        value = line.value if isinstance(line, ir.Assign) else line
        if isinstance(value, ir.Var):
            read.add(value.name)
        elif isinstance(value, ir.Inst):
            read |= {variable.name for variable in value.list_vars()}
    return {
        id(line)
        for line in lines
        if isinstance(line, ir.Assign)
        and line.target.name not in read
        and (isinstance(line.value, ir.Var | ir.Global | ir.FreeVar) or getattr(line.value, "op", None) in _PURE)
    }


class Distinct(CompilerBase):
    """Numba's compiler, told that no two arrays which a kernel writes or reads beside another's writing overlap.

    Loops of a few dozen slots are too short for the checks at run time that would otherwise stand before each of them.
    """

    def define_pipelines(self) -> Any:
        """Return Numba's own passes, and one after inlining."""
        self.state.flags.noalias = True
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(DropUnused, InlineInlinables)
        passes.finalize()
        return [passes]


WHOLE: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract", "reassoc", "nsz", "arcp"},
    "no_cfunc_wrapper": True,
    "pipeline_class": Distinct,
    "_nrt": False,  # kernels make no arrays, so nothing need count who holds one: a fifth less compiling
}
"""How a kernel that Python calls is compiled."""

# Forced inlining: handing these bundles of arrays to a real call costs as much as the work on twenty vessels. A door
# for Python would cost as much compiling as the part itself.
OPTIONS = WHOLE | {"forceinline": True, "no_cpython_wrapper": True}
"""How the parts of a kernel are compiled, which only kernels call."""

JOINED: dict[str, Any] = {name: value for name, value in OPTIONS.items() if name != "pipeline_class"}
"""How those are compiled that take whole bundles; a claim that these are distinct would cost much compiling."""

INLINED: dict[str, Any] = JOINED | {"inline": "always"}
"""How those are compiled that hand bundles on: within their callers, for a call with a hundred arrays costs much."""


class FluidConstants(NamedTuple):
    """Blood in the units of the model: density (mmHg s²/cm²) and drag (k0 + k1 √A)/A, 1/s, of the flow."""

    inertia: float
    k0: float
    k1: float


class Faces(NamedTuple):
    """Area and flow at the faces at the half step; scratch memory of one simulation."""

    area: np.ndarray
    flow: np.ndarray


class Fluxes(NamedTuple):
    """Pressure, momentum flux and drag, of the cells in the first half of a step and of the faces in the second."""

    pressure: np.ndarray
    momentum: np.ndarray
    drag: np.ndarray


@njit(**OPTIONS)
def find_fluxes(area, flow, cells, wall, fluid, fluxes):
    """Pressure, momentum flux q²/A and drag at all slots (eqs. 2, 3, 4); False if an area left the wall law."""
    inside = True
    for j in range(len(area)):
        A, q = area[j], flow[j]
        inside &= (A > cells.smallest[j]) & (A < cells.largest[j])
        per_area = 1.0 / A
        fluxes.pressure[j] = pressure_at(wall, j, A * cells.per_area0[j])
        fluxes.momentum[j] = q * q * per_area
        fluxes.drag[j] = (fluid.k0 + fluid.k1 * np.sqrt(A)) * per_area
    return inside


@njit(**OPTIONS)
def slowed(x):
    """Factors by which drag keeps a flow, and a change of it, over a time that is x drag times long.

    E = 1/(1 + x + x²/2) stands for exp(-x), to second order and without a limit on x; Φ = (1 - E)/x leaves a steady
    flow as it is.
    """
    E = 1.0 / (1.0 + x + 0.5 * x * x)
    return E, (1.0 + 0.5 * x) * E


@njit(**OPTIONS)
def inner_faces(area, flow, cells, fluid, fluxes, faces):
    """First Lax-Wendroff step: A and q at every face at the half step (vessel ends are overwritten later)."""
    for j in range(1, len(area)):
        half = cells.half[j - 1]
        A = 0.5 * (area[j - 1] + area[j])
        faces.area[j] = A - half * (flow[j] - flow[j - 1])
        force = fluxes.momentum[j] - fluxes.momentum[j - 1]
        force += A / fluid.inertia * (fluxes.pressure[j] - fluxes.pressure[j - 1])
        E, Phi = slowed(0.25 * cells.dt[j - 1] * (fluxes.drag[j - 1] + fluxes.drag[j]))
        faces.flow[j] = 0.5 * E * (flow[j - 1] + flow[j]) - half * Phi * force


@njit(**OPTIONS)
def update_cells(area, flow, cells, fluid, fluxes, faces):
    """Second Lax-Wendroff step: every cell takes the difference of its faces (eq. 2)."""
    for j in range(len(area) - 1):
        twice = 2.0 * cells.half[j]
        area[j] -= twice * (faces.flow[j + 1] - faces.flow[j])
        force = fluxes.momentum[j + 1] - fluxes.momentum[j]
        mean_area = 0.5 * (faces.area[j] + faces.area[j + 1])
        force += mean_area / fluid.inertia * (fluxes.pressure[j + 1] - fluxes.pressure[j])
        drag = fluxes.drag[j] * faces.flow[j] + fluxes.drag[j + 1] * faces.flow[j + 1]
        flow[j] -= twice * force + 0.5 * cells.dt[j] * drag


@njit(**OPTIONS)
def continue_lines(area, flow, single, faces):
    """Slots around the only cell of a vessel: the straight line through its end faces, a cell further on and back.

    It is that of the half step before, which costs second order nothing: from end to end the line rises by O(dx).
    """
    for j in single:
        rise, gain = faces.area[j + 1] - faces.area[j], faces.flow[j + 1] - faces.flow[j]
        area[j + 1], area[j + 2] = area[j] + rise, area[j] - rise
        flow[j + 1], flow[j + 2] = flow[j] + gain, flow[j] - gain


@njit(**OPTIONS)
def is_calm(area, flow, cells, wall, fluid, fluxes):
    """Whether every cell has |u| + c < dx/dt and |u| < c; written without divisions: it is asked at every step."""
    calm = True
    for j in range(len(area)):
        A, q = area[j], abs(flow[j])
        softness = fluid.inertia * slope_at(wall, j, fluxes.pressure[j])  # c² = (A/A0)/softness
        reach = A - 2.0 * cells.half[j] * q
        stiffness = A * cells.per_area0[j] * A * A
        fast = 4.0 * cells.half[j] * cells.half[j] * stiffness
        calm &= (reach > 0.0) & (fast <= softness * reach * reach) & (softness * q * q < stiffness)
    return calm


@njit(**OPTIONS)
def worst_slot(area, cells):
    """First slot whose area is outside its wall law or not a number."""
    for j in range(len(area)):
        if not ((area[j] > cells.smallest[j]) & (area[j] < cells.largest[j])):
            return j
    return 0


@njit(**OPTIONS)
def largest_speeds(area, flow, cells, wall, fluid, fluxes):
    """Largest Courant number (|u| + c) dt/dx over all cells and its slot; largest |u|/c and its slot."""
    courant, fastest, mach, swiftest = 0.0, 0, 0.0, 0
    for j in range(len(area)):
        a = area[j] * cells.per_area0[j]
        c = np.sqrt(a / (fluid.inertia * slope_at(wall, j, fluxes.pressure[j])))
        u = abs(flow[j] / area[j]) if cells.half[j] > 0.0 else 0.0  # no flow of a ghost is one that exists
        if (u + c) * 2.0 * cells.half[j] > courant:
            courant, fastest = (u + c) * 2.0 * cells.half[j], j
        if u / c > mach:
            mach, swiftest = u / c, j
    return courant, fastest, mach, swiftest
