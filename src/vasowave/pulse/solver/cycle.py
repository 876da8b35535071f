"""One compiled cardiac cycle: the steps of `cells` and `nodes` in their order, and what is kept of them.

Half steps lie at t = 0, dt, 2dt …: inflow, outlets and output live there, and nothing is interpolated in time.
"""

from functools import cache
from typing import Any

from numba import njit

from vasowave.base.runtime.kernels import is_known, kept
from vasowave.pulse.model import walls
from vasowave.pulse.solver import (
    beds,
    cells,
    changing,
    elimination,
    grid,
    laws,
    nodes,
    powers,
    scheme,
    terms,
    valve,
    viscosity,
)
from vasowave.pulse.solver.cells import (
    OPTIONS,
    WHOLE,
    continue_lines,
    find_fluxes,
    inner_faces,
    is_calm,
    largest_speeds,
    update_cells,
    worst_slot,
)
from vasowave.pulse.solver.nodes import characteristics, gather, nodes_solver
from vasowave.pulse.solver.terms import Kinds, of_all, with_modules_of

DONE, LEFT_LAW, NODE_FAILED = 0, 1, 2
"""How a cycle ended: well; an area outside the wall law; a node whose pressure was not found."""

STATUS, PLACE, STEP = 0, 1, 2
"""Where a cycle's report says how it ended, in which slot or (a node) vessel, and at which step."""

COURANT, MACH = 3, 6
"""Where it says the largest Courant number and the largest |u|/c, each followed by its slot and step."""

WATCHES = 64
"""How often a cycle the speeds of all cells are noted while all is calm; whether it is calm, is asked at every step."""

INFLOW, OUTFLOW, REPORT = 9, 10, 11
"""Where it says the sums of the flows in and out; its length."""


@njit(**OPTIONS)
def note(report, key, value, slot, step):
    """Keep the largest value of its kind, and where it was met."""
    if value > report[key]:
        report[key], report[key + 1], report[key + 2] = value, slot, step


@njit(**OPTIONS)
def record_stations(sample, vessels, faces, out):
    """Area and flow at inlet, middle and outlet of every vessel into out[0] and out[1]."""
    for v in range(len(vessels.first)):
        i, k = vessels.first[v], vessels.last[v]
        left_face = (i + k) // 2
        right_face = i + k - left_face  # the same face for an even number of cells, else the two around the middle cell
        for kind, values in enumerate((faces.area, faces.flow)):
            out[kind, sample, v, 0] = values[i]
            out[kind, sample, v, 1] = 0.5 * (values[left_face] + values[right_face])
            out[kind, sample, v, 2] = values[k]


@njit(**OPTIONS)
def record_cells(sample, area, flow, out):
    """Area and flow of every cell into out[0] and out[1]."""
    for j in range(len(area)):
        out[0, sample, j], out[1, sample, j] = area[j], flow[j]


@njit(**OPTIONS)
def center_cells(sample, area, flow, out):
    """Make what was recorded before a step that of its middle: the mean of before and after."""
    for j in range(len(area)):
        out[0, sample, j] = 0.5 * (out[0, sample, j] + area[j])
        out[1, sample, j] = 0.5 * (out[1, sample, j] + flow[j])


PARTS = (
    *(walls, laws, powers, grid, beds, cells, changing, nodes, valve),
    *(viscosity, elimination, scheme, terms),
)
"""Modules of which a cycle is compiled, beside those of its terms."""


@njit(**OPTIONS)
def fail(report, status, place, n):
    """Say how a cycle ended, where and at which step."""
    report[STATUS], report[PLACE], report[STEP] = status, place, n


def _compiled(kinds: Kinds) -> Any:
    at_faces, at_ends, before_nodes = (of_all(name, kinds) for name in ("at_faces", "at_ends", "before_nodes"))
    begin, record, in_cells = (of_all(name, kinds) for name in ("begin", "record", "in_cells"))
    around_single, solve_nodes = of_all("around_single", kinds), nodes_solver(kinds)

    @njit(**WHOLE)
    def advance_cycle(step, terms, report):
        """Run a cycle from its state, which becomes that of its end; `report`, all zeros before, says how it went."""
        inflow, (area, flow, memory), scheme, half, (watched, waves, stations, cell_out) = step
        vessels, cells, face_cells, ends, (wall, face_wall, end_wall), fluid, _ = scheme
        cell_fluxes, faces, fluxes, nodes = half
        stride, of_cells = len(inflow) // stations.shape[1], len(inflow) // max(cell_out.shape[1], 1)
        watch = max(stride, len(inflow) // WATCHES)
        begin(terms, step, 0)
        for n in range(len(inflow)):
            cells_kept = cell_out.shape[1] > 0 and n % of_cells == 0
            if not find_fluxes(area, flow, cells, wall, fluid, cell_fluxes):
                fail(report, LEFT_LAW, worst_slot(area, cells), n)
                return
            if n % watch == 0 or not is_calm(area, flow, cells, wall, fluid, cell_fluxes):
                courant, fastest, mach, swiftest = largest_speeds(area, flow, cells, wall, fluid, cell_fluxes)
                note(report, COURANT, courant, fastest, n)
                note(report, MACH, mach, swiftest, n)
            inner_faces(area, flow, cells, fluid, cell_fluxes, faces)
            at_faces(terms, step, n)
            gather(area, flow, cell_fluxes, ends, nodes)
            at_ends(terms, step, n)
            characteristics(ends, end_wall, fluid, nodes)
            before_nodes(terms, step, n)
            failed = solve_nodes(inflow[n], memory, scheme, half, terms, step, n)
            if failed >= 0:
                fail(report, NODE_FAILED, ends.vessel[failed], n)
                return
            for i in range(len(watched)):
                waves[0, n, i], waves[1, n, i] = faces.area[watched[i]], faces.flow[watched[i]]
            if not find_fluxes(faces.area, faces.flow, face_cells, face_wall, fluid, fluxes):
                fail(report, LEFT_LAW, worst_slot(faces.area, face_cells), n)
                return
            if n % stride == 0:
                record_stations(n // stride, vessels, faces, stations)
            record(terms, step, n)
            if cells_kept:
                record_cells(n // of_cells, area, flow, cell_out)
            update_cells(area, flow, cells, fluid, fluxes, faces)
            in_cells(terms, step, n)
            continue_lines(area, flow, vessels.single, faces)
            around_single(terms, step, n)
            if cells_kept:
                center_cells(n // of_cells, area, flow, cell_out)
            for i in range(inflow.shape[1]):
                report[INFLOW] += faces.flow[ends.face[ends.inlet + i]]
            for k in range(ends.first_terminal, len(nodes.step)):
                report[OUTFLOW] += faces.flow[ends.face[k]]
        if not find_fluxes(area, flow, cells, wall, fluid, cell_fluxes):
            fail(report, LEFT_LAW, worst_slot(area, cells), len(inflow))

    return advance_cycle


@cache
def _kernels(kinds: Kinds) -> tuple[Any, Any]:
    return kept(_compiled(kinds), *with_modules_of(kinds, *PARTS)), _compiled(kinds)


def cycle_kernel(law: type, kinds: Kinds) -> Any:
    """Return the compiled cycle for models with this wall law (its class) and terms of these kinds.

    Kernels of our own laws, and of laws in files, are kept on disk. One with a law from elsewhere is compiled in each
    process: nobody knows which files it consists of.
    """
    return _kernels(kinds)[not is_known(law)]
