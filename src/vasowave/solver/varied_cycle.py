"""One compiled cycle with its linearization: `cycle`'s steps, and beside them the changes in every direction."""

from functools import cache
from typing import Any

import numpy as np
from numba import njit

from vasowave import walls
from vasowave.solver import node_variations, variations
from vasowave.solver.cells import OPTIONS, find_fluxes, inner_faces, update_cells
from vasowave.solver.cycle import source_fingerprint
from vasowave.solver.node_variations import change_characteristics, change_nodes, differentiate_ends
from vasowave.solver.nodes import characteristics, gather, solve_nodes
from vasowave.solver.variations import change_cells, change_faces, change_fluxes, differentiate_faces
from vasowave.solver.variations import differentiate_fluxes


@cache
def _compiled(fingerprint: str, kept: bool) -> Any:
    @njit(cache=kept, **OPTIONS)
    def advance_changes(state, changed, inflow, law, shifted, outlet, outlets, parts, weights, fluid, scratch, out):
        _ = fingerprint
        area, flow, memory = state
        wall, end_wall = law
        shifted_wall, shifted_end_wall = shifted
        cells, ends = parts
        at_slots, at_ends = weights
        faces, fluxes, nodes, slopes, face_slopes, end_slopes, changes, end_changes, face_dA, face_dq, before = scratch
        dA, dq, remembered = changed
        for n in range(len(inflow)):
            find_fluxes(area, flow, cells, wall, fluid, fluxes)
            differentiate_fluxes(area, flow, cells, wall, shifted_wall, fluid, fluxes, slopes)
            differentiate_faces(area, flow, cells, fluid, fluxes, face_slopes)
            inner_faces(area, flow, cells, fluid, fluxes, faces)
            gather(area, flow, fluxes, ends, nodes)
            characteristics(ends, end_wall, fluid, nodes)
            before[:] = memory[:, 0]
            if solve_nodes(inflow[n], n, outlet, memory, ends, end_wall, nodes, faces) >= 0:
                return False
            differentiate_ends(ends, end_wall, shifted_end_wall, fluid, slopes, nodes, end_slopes)
            for d in range(len(dA)):
                change_fluxes(dA[d], dq[d], slopes, at_slots.wall[d], changes)
                change_faces((area, flow), dA[d], dq[d], cells, fluid, fluxes, face_slopes, at_slots.length[d], changes, face_dA[d], face_dq[d])
                change_characteristics(dA[d], dq[d], ends, nodes, end_slopes, changes.drag, at_ends.wall[d], at_ends.length[d], end_changes)
                change_nodes(d, before, remembered[d], outlet, outlets, ends, nodes, faces, end_changes, face_dA[d], face_dq[d])
                out[d, n] = end_changes.pressure[0]
            find_fluxes(faces.area, faces.flow, cells, wall, fluid, fluxes)
            differentiate_fluxes(faces.area, faces.flow, cells, wall, shifted_wall, fluid, fluxes, slopes)
            for d in range(len(dA)):
                change_fluxes(face_dA[d], face_dq[d], slopes, at_slots.wall[d], changes)
                change_cells((faces.area, faces.flow), face_dA[d], face_dq[d], cells, fluid, fluxes, at_slots.length[d], changes, dA[d], dq[d])
            update_cells(area, flow, cells, fluid, fluxes, faces)
        return True

    return advance_changes


def varied_cycle_kernel(law: type) -> Any:
    """Return the compiled cycle with changes for models with this wall law (its class); kept as `cycle_kernel` is."""
    return _compiled(source_fingerprint(variations, node_variations), law.__module__ == walls.__name__)
