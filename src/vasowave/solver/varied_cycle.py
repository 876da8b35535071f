"""One compiled cycle and its linearization: the steps of `cycle`, and beside them the changes in every direction."""

from functools import cache
from typing import Any

from numba import njit

from vasowave.model import walls
from vasowave.runtime.kernels import kept
from vasowave.solver import node_variations, variations
from vasowave.solver.cells import WHOLE, Faces, continue_lines, find_fluxes, inner_faces, update_cells
from vasowave.solver.cycle import PARTS
from vasowave.solver.node_variations import (
    change_characteristics,
    change_ends,
    change_memory,
    change_nodes,
    differentiate_characteristics,
    differentiate_nodes,
    differentiate_speeds,
    gather_slopes,
    lengthen_characteristics,
)
from vasowave.solver.nodes import characteristics, gather, solve_nodes
from vasowave.solver.variations import (
    change_cells,
    change_faces,
    differentiate_cells,
    differentiate_faces,
    differentiate_fluxes,
    lengthen_cells,
    lengthen_faces,
)


def _compiled() -> Any:
    @njit(**WHOLE)
    def advance_changes(
        state, changed, inflow, law, shifted, outlet, outlets, parts, weights, fluid, base, scratch, out
    ):
        area, flow, memory = state
        dA, dq, remembered = changed
        (wall, end_wall), (wall_beside, end_wall_beside) = law, shifted
        (vessels, cells, ends), (in_slots, at_ends) = parts, weights
        faces, cell_fluxes, nodes, fluxes = base
        cell_slopes, slopes, to_faces, to_cells, lines, at_nodes, face_dA, face_dq, before = scratch
        for n in range(len(inflow)):
            find_fluxes(area, flow, cells, wall, fluid, cell_fluxes)
            inner_faces(area, flow, cells, fluid, cell_fluxes, faces)
            gather(area, flow, cell_fluxes, ends, nodes)
            characteristics(ends, end_wall, fluid, nodes)
            for j in range(len(before)):
                before[j] = memory[j, 0]
            solve_nodes(inflow[n], n, outlet, memory, ends, end_wall, nodes, faces)
            find_fluxes(faces.area, faces.flow, cells, wall, fluid, fluxes)

            differentiate_fluxes(area, flow, cells, wall, wall_beside, fluid, cell_fluxes, cell_slopes)
            differentiate_fluxes(faces.area, faces.flow, cells, wall, wall_beside, fluid, fluxes, slopes)
            differentiate_faces(area, flow, cells, fluid, cell_fluxes, cell_slopes, to_faces)
            differentiate_cells(faces.area, faces.flow, cells, fluid, fluxes, slopes, to_cells)
            gather_slopes(ends, nodes, faces, cell_slopes, slopes, lines)
            differentiate_speeds(ends, fluid, end_wall, end_wall_beside, nodes, lines)
            differentiate_characteristics(ends, nodes, lines)
            differentiate_nodes(outlet, ends, lines)
            for d in range(len(dA)):
                weight, end_weight = in_slots.wall[d, : in_slots.rows[d]], at_ends.wall[d, : at_ends.rows[d]]
                change_faces(dA[d], dq[d], cells, to_faces, weight, face_dA, face_dq)
                change_characteristics(dA[d], dq[d], ends, lines, end_weight, at_nodes)
                if in_slots.lengthens[d]:
                    lengthen_faces(in_slots.length[d], flow, cells, to_faces, face_dA, face_dq)
                    lengthen_characteristics(at_ends.length[d], lines, at_nodes)
                change_nodes(d, before, remembered[d], outlet, outlets, ends, faces, lines, at_nodes)
                change_ends(ends, nodes, lines, at_nodes, face_dA, face_dq)
                change_memory(d, before, remembered[d], outlet, outlets, ends, faces, face_dq)
                out[d, n] = at_nodes.pressure[ends.inlet]
                change_cells(face_dA, face_dq, cells, to_cells, weight, dA[d], dq[d])
                if in_slots.lengthens[d]:
                    lengthen_cells(in_slots.length[d], faces.flow, cells, to_cells, dA[d], dq[d])
                continue_lines(dA[d], dq[d], vessels.single, Faces(face_dA, face_dq))
            update_cells(area, flow, cells, fluid, fluxes, faces)
            continue_lines(area, flow, vessels.single, faces)

    return advance_changes


@cache
def _kernels() -> tuple[Any, Any]:
    return kept(_compiled(), *PARTS, variations, node_variations), _compiled()


def varied_cycle_kernel(law: type) -> Any:
    """Return the compiled cycle with changes for models with this wall law (its class); kept as `cycle_kernel` is."""
    return _kernels()[law.__module__ != walls.__name__]
