"""One compiled cardiac cycle: the steps of `cells` and `nodes` in their order, and what is kept of them.

Half steps lie at t = 0, dt, 2dt …: inflow, outlets and output live there, and nothing is interpolated in time.
"""

from functools import cache
from typing import Any

from numba import njit

from vasowave.base.runtime.kernels import is_known, kept
from vasowave.pulse.model import walls
from vasowave.pulse.solver import beds as bed_kernels
from vasowave.pulse.solver import cells as cell_kernels
from vasowave.pulse.solver import changing as changing_kernels
from vasowave.pulse.solver import grid, laws, powers, valve, viscosity
from vasowave.pulse.solver import nodes as node_kernels
from vasowave.pulse.solver.beds import beat_behind
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
from vasowave.pulse.solver.changing import carry_to_ends, continue_by_pressure, faces_by_pressure, keep_energy
from vasowave.pulse.solver.nodes import characteristics, gather, solve_nodes
from vasowave.pulse.solver.valve import fill
from vasowave.pulse.solver.viscosity import find_viscosity, push_cells, solve_viscous

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
def record_viscous(sample, vessels, at_faces, out):
    """Viscous pressure at inlet, middle and outlet of every vessel into out[2]."""
    for v in range(len(vessels.first)):
        i, k = vessels.first[v], vessels.last[v]
        left_face = (i + k) // 2
        out[2, sample, v, 0], out[2, sample, v, 2] = at_faces[i], at_faces[k]
        out[2, sample, v, 1] = 0.5 * (at_faces[left_face] + at_faces[i + k - left_face])


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
    *(walls, laws, powers, grid, bed_kernels, cell_kernels, changing_kernels, node_kernels),
    *(viscosity, valve),
)
"""Modules of which a cycle is compiled."""


def _compiled() -> Any:
    @njit(**WHOLE)
    def advance_cycle(
        state, inflow, heart, behind, law, outlet, geometry, changing, fluid, scratch, viscous, watched, watched_waves,
        out, cell_out, report
    ):  # fmt: skip
        """Run a cycle from `state`, which becomes that of its end; `report`, all zeros before, says how it went.

        Where walls are not viscous (`viscous` is None), no vessel changes along its way (`changing`), no ventricle
        drives (`heart`), or the pressure `behind` beds is steady, the compiler leaves them out.
        """
        area, flow, memory = state
        wall, face_wall, end_wall = law
        vessels, cells, at_faces, ends = geometry
        faces, fluxes, nodes = scratch
        stride = len(inflow) // out.shape[1]
        watch = max(stride, len(inflow) // WATCHES)
        if heart is not None:
            fill(heart)
        of_cells = len(inflow) // max(cell_out.shape[1], 1)
        for n in range(len(inflow)):
            cells_kept = cell_out.shape[1] > 0 and n % of_cells == 0
            if not find_fluxes(area, flow, cells, wall, fluid, fluxes):
                report[STATUS], report[PLACE], report[STEP] = LEFT_LAW, worst_slot(area, cells), n
                return
            if n % watch == 0 or not is_calm(area, flow, cells, wall, fluid, fluxes):
                courant, fastest, mach, swiftest = largest_speeds(area, flow, cells, wall, fluid, fluxes)
                note(report, COURANT, courant, fastest, n)
                note(report, MACH, mach, swiftest, n)
            inner_faces(area, flow, cells, fluid, fluxes, faces)
            if changing is not None:
                faces_by_pressure(flow, cells, at_faces, face_wall, changing, fluxes, faces)
            gather(area, flow, fluxes, ends, nodes)
            if changing is not None:
                carry_to_ends(ends, end_wall, fluid, changing, fluxes, nodes)
            characteristics(ends, end_wall, fluid, nodes)
            if behind is not None:
                beat_behind(outlet, behind, n)
            if viscous is None:
                failed = solve_nodes(inflow[n], n, heart, outlet, memory, ends, end_wall, nodes, faces)
            else:
                find_viscosity(area, flow, vessels, cells, fluid, viscous)
                failed = solve_viscous(inflow[n], heart, outlet, memory, vessels, ends, end_wall, viscous, nodes, faces)
            if failed >= 0:
                report[STATUS], report[PLACE], report[STEP] = NODE_FAILED, ends.vessel[failed], n
                return
            for i in range(len(watched)):
                watched_waves[0, n, i], watched_waves[1, n, i] = faces.area[watched[i]], faces.flow[watched[i]]
                if viscous is not None:
                    watched_waves[2, n, i] = viscous.at_faces[watched[i]]
            if not find_fluxes(faces.area, faces.flow, at_faces, face_wall, fluid, fluxes):
                report[STATUS], report[PLACE], report[STEP] = LEFT_LAW, worst_slot(faces.area, at_faces), n
                return
            if n % stride == 0:
                record_stations(n // stride, vessels, faces, out)
                if viscous is not None:
                    record_viscous(n // stride, vessels, viscous.at_faces, out)
            if cells_kept:
                record_cells(n // of_cells, area, flow, cell_out)
            update_cells(area, flow, cells, fluid, fluxes, faces)
            if changing is not None:
                keep_energy(flow, cells, changing, faces)
            if viscous is not None:
                push_cells(flow, vessels, cells, fluid, viscous, faces)
            continue_lines(area, flow, vessels.single, faces)
            if changing is not None:
                continue_by_pressure(area, flow, cells, wall, changing, fluxes, faces)
            if cells_kept:
                center_cells(n // of_cells, area, flow, cell_out)
                if viscous is not None:
                    for j in range(len(area)):
                        cell_out[2, n // of_cells, j] = viscous.pressure[j]
            for i in range(inflow.shape[1]):
                report[INFLOW] += faces.flow[ends.face[ends.inlet + i]]
            for k in range(ends.first_terminal, len(nodes.step)):
                report[OUTFLOW] += faces.flow[ends.face[k]]
        if not find_fluxes(area, flow, cells, wall, fluid, fluxes):
            report[STATUS], report[PLACE], report[STEP] = LEFT_LAW, worst_slot(area, cells), len(inflow)

    return advance_cycle


@cache
def _kernels() -> tuple[Any, Any]:
    return kept(_compiled(), *PARTS), _compiled()


def cycle_kernel(law: type) -> Any:
    """Return the compiled cycle for models with this wall law (its class).

    Kernels of our own laws, and of laws in files, are kept on disk. One with a law from elsewhere is compiled in each
    process: nobody knows which files it consists of.
    """
    return _kernels()[not is_known(law)]
