"""One compiled cycle and its linearization: the steps of `cycle`, and beside them the changes in every direction."""

from functools import cache
from typing import Any

from numba import njit

from vasowave import walls
from vasowave.solver import node_variations, variations
from vasowave.solver.cells import OPTIONS, find_fluxes, inner_faces, update_cells
from vasowave.solver.cycle import source_fingerprint
from vasowave.solver.node_variations import change_characteristics, change_ends, change_nodes, differentiate_ends
from vasowave.solver.nodes import characteristics, gather, solve_nodes
from vasowave.solver.variations import (
    change_cells,
    change_faces,
    change_fluxes,
    differentiate_faces,
    differentiate_fluxes,
)


@cache
def _compiled(fingerprint: str, kept: bool) -> Any:
    @njit(cache=kept, **OPTIONS)
    def advance_changes(state, changed, inflow, law, shifted, outlet, outlets, parts, weights, fluid, scratch, out):
        _ = fingerprint
        area, flow, memory = state
        dA, dq, remembered = changed
        (wall, end_wall), (walls_beside, end_walls_beside) = law, shifted
        cells, ends = parts
        at_slots, at_ends = weights
        faces, cell_fluxes, nodes, fluxes, cell_slopes, slopes, push, end_slopes, changes, at_nodes, dA_, dq_, before = scratch
        for n in range(len(inflow)):
            find_fluxes(area, flow, cells, wall, fluid, cell_fluxes)
            inner_faces(area, flow, cells, fluid, cell_fluxes, faces)
            gather(area, flow, cell_fluxes, ends, nodes)
            characteristics(ends, end_wall, fluid, nodes)
            before[:] = memory[:, 0]
            solve_nodes(inflow[n], n, outlet, memory, ends, end_wall, nodes, faces)
            find_fluxes(faces.area, faces.flow, cells, wall, fluid, fluxes)

            differentiate_fluxes(area, flow, cells, wall, walls_beside, fluid, cell_fluxes, cell_slopes)
            differentiate_fluxes(faces.area, faces.flow, cells, wall, walls_beside, fluid, fluxes, slopes)
            differentiate_faces(area, flow, cells, fluid, cell_fluxes, push)
            differentiate_ends(ends, fluid, end_wall, end_walls_beside, nodes, faces, cell_slopes, slopes, end_slopes)
            for d in range(len(dA)):
                weight, longer = at_slots.wall[d], at_slots.length[d]
                change_fluxes(dA[d], dq[d], cell_slopes, weight, changes)
                change_faces(area, flow, dA[d], dq[d], cells, fluid, cell_fluxes, push, longer, changes, dA_, dq_)
                change_characteristics(dA[d], dq[d], ends, end_slopes, at_ends.wall[d], at_ends.length[d], at_nodes)
                change_nodes(d, before, remembered[d], outlet, outlets, ends, nodes, faces, end_slopes, at_nodes)
                change_ends(d, before, remembered[d], outlet, outlets, ends, nodes, faces, end_slopes, at_nodes, dA_, dq_)
                out[d, n] = at_nodes.pressure[0]
                change_fluxes(dA_, dq_, slopes, weight, changes)
                change_cells(faces.area, faces.flow, dA_, dq_, cells, fluid, fluxes, longer, changes, dA[d], dq[d])
            update_cells(area, flow, cells, fluid, fluxes, faces)
        return True

    return advance_changes


def varied_cycle_kernel(law: type) -> Any:
    """Return the compiled cycle with changes for models with this wall law (its class); kept as `cycle_kernel` is."""
    return _compiled(source_fingerprint(variations, node_variations), law.__module__ == walls.__name__)
