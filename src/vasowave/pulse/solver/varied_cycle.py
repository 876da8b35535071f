"""One compiled cycle and its linearization: the steps of `cycle`, and beside them the changes in every direction."""

from functools import cache
from typing import Any

from numba import njit

from vasowave.base.runtime.kernels import is_known, kept
from vasowave.pulse.solver import changing_variations, node_variations, variations, viscosity_variations
from vasowave.pulse.solver.beds import beat_behind
from vasowave.pulse.solver.cells import WHOLE, Faces, continue_lines, find_fluxes, inner_faces, update_cells
from vasowave.pulse.solver.changing import carry_to_ends, continue_by_pressure, faces_by_pressure, keep_energy
from vasowave.pulse.solver.changing_variations import (
    change_changing_cells,
    change_changing_ends,
    change_changing_faces,
    continue_changing,
    differentiate_changing,
    differentiate_drag_along,
    differentiate_energy,
    differentiate_gains,
)
from vasowave.pulse.solver.cycle import PARTS
from vasowave.pulse.solver.node_variations import (
    change_beds,
    change_behind,
    change_characteristics,
    change_ends,
    change_memory,
    change_nodes,
    differentiate_characteristics,
    differentiate_nodes,
    differentiate_speeds,
    gather_slopes,
    lengthen_characteristics,
    see_faces,
)
from vasowave.pulse.solver.nodes import characteristics, gather, solve_nodes
from vasowave.pulse.solver.variations import (
    change_cells,
    change_faces,
    differentiate_cells,
    differentiate_faces,
    differentiate_fluxes,
    lengthen_cells,
    lengthen_faces,
)
from vasowave.pulse.solver.viscosity import find_viscosity, push_cells, solve_viscous
from vasowave.pulse.solver.viscosity_variations import change_joined, change_pushes, change_viscosity, join_changes


def _compiled() -> Any:
    @njit(**WHOLE)
    def advance_changes(
        state, changed, inflow, behind, law, shifted, outlet, outlets, geometry, changing, weights, fluid, base,
        scratch, viscous, watched, out, watched_waves
    ):  # fmt: skip
        area, flow, memory = state
        dA, dq, remembered = changed
        (wall, face_wall, end_wall), (wall_shift, face_wall_shift, end_wall_shift) = law, shifted
        (vessels, cells, at_faces, ends), (in_slots, in_faces, in_ends, drags) = geometry, weights
        faces, cell_fluxes, nodes, fluxes = base
        cell_slopes, slopes, to_faces, to_cells, lines, at_nodes, carrying, face_dA, face_dq, before = scratch
        for n in range(len(inflow)):
            find_fluxes(area, flow, cells, wall, fluid, cell_fluxes)
            inner_faces(area, flow, cells, fluid, cell_fluxes, faces)
            if changing is not None:
                faces_by_pressure(flow, cells, at_faces, face_wall, changing, cell_fluxes, faces)
            gather(area, flow, cell_fluxes, ends, nodes)
            if changing is not None:
                carry_to_ends(ends, end_wall, fluid, changing, cell_fluxes, nodes)
            characteristics(ends, end_wall, fluid, nodes)
            for j in range(before.shape[0]):
                for i in range(before.shape[1]):
                    before[j, i] = memory[j, i]
            if behind is not None:
                beat_behind(outlet, behind[0], n)
            if viscous is None:
                solve_nodes(inflow[n], n, None, outlet, memory, ends, end_wall, nodes, faces)
            else:
                find_viscosity(area, flow, vessels, cells, fluid, viscous.base)
                solve_viscous(inflow[n], None, outlet, memory, vessels, ends, end_wall, viscous.base, nodes, faces)
            find_fluxes(faces.area, faces.flow, at_faces, face_wall, fluid, fluxes)

            differentiate_fluxes(area, flow, cells, wall, wall_shift, fluid, cell_fluxes, cell_slopes)
            differentiate_fluxes(faces.area, faces.flow, at_faces, face_wall, face_wall_shift, fluid, fluxes, slopes)
            differentiate_faces(area, flow, cells, fluid, cell_fluxes, cell_slopes, to_faces)
            differentiate_cells(faces.area, faces.flow, cells, fluid, fluxes, slopes, to_cells)
            gather_slopes(ends, nodes, faces, cell_slopes, slopes, lines)
            if changing is not None:
                differentiate_changing(
                    area,
                    ends,
                    (cells, at_faces, changing),
                    law,
                    shifted,
                    fluid,
                    cell_fluxes,
                    fluxes,
                    nodes,
                    carrying,
                    lines,
                )
            differentiate_speeds(ends, fluid, end_wall, end_wall_shift, nodes, lines)
            differentiate_characteristics(ends, nodes, lines)
            if changing is not None:
                differentiate_gains(changing, nodes, carrying, lines)
            differentiate_nodes(outlet, ends, nodes, lines)
            if viscous is not None:
                join_changes(outlet, vessels, ends, nodes, lines, viscous.base)
            if changing is not None:
                differentiate_energy(cells, changing, faces, carrying.energy)
                differentiate_drag_along(cells, changing, cell_fluxes, fluxes, faces, to_faces, carrying.drag)
            for d in range(len(dA)):
                rows, longer = in_slots.rows[d], in_slots.length[d]
                weight, face_weight, end_weight = (
                    in_slots.wall[d, :rows],
                    in_faces.wall[d, :rows],
                    in_ends.wall[d, :rows],
                )
                change_faces(dA[d], dq[d], cells, to_faces, weight, face_dA, face_dq)
                if changing is not None:
                    change_changing_faces(
                        dA[d],
                        dq[d],
                        cells,
                        changing,
                        cell_slopes,
                        to_faces,
                        weight,
                        face_weight,
                        drags[d],
                        carrying,
                        face_dA,
                        face_dq,
                    )
                change_characteristics(dA[d], dq[d], ends, lines, end_weight, at_nodes)
                if changing is not None:
                    change_changing_ends(dA[d], ends, changing, end_weight, carrying, lines, at_nodes)
                if in_slots.lengthens[d]:
                    lengthen_faces(longer, flow, cells, to_faces, face_dA, face_dq)
                    lengthen_characteristics(in_ends.length[d], lines, at_nodes)
                change_beds(d, before, remembered[d], outlet, outlets, ends, faces, at_nodes)
                if behind is not None:
                    change_behind(d, n, behind[1], outlet, ends, at_nodes)
                if viscous is None:
                    change_nodes(ends, lines, at_nodes)
                    change_ends(ends, nodes, lines, at_nodes, face_dA, face_dq)
                else:
                    change_viscosity(d, dA[d], dq[d], area, flow, vessels, cells, in_slots.wall[d, -1], longer, viscous)
                    change_joined(area, dA[d], vessels, ends, longer, nodes, lines, viscous, at_nodes, face_dA, face_dq)
                    for i in range(len(watched)):
                        watched_waves[2, d, n, i] = viscous.at_faces[watched[i]]
                change_memory(d, before, remembered[d], outlet, outlets, ends, faces, face_dq)
                out[d, n] = at_nodes.pressure[ends.inlet]
                see_faces(d, n, watched, slopes, face_weight, face_dA, face_dq, watched_waves)
                change_cells(face_dA, face_dq, cells, to_cells, face_weight, dA[d], dq[d])
                if changing is not None:
                    change_changing_cells(
                        face_dA, face_dq, changing, slopes, to_cells, longer, face_weight, drags[d], carrying, dq[d]
                    )
                if in_slots.lengthens[d]:
                    lengthen_cells(longer, faces.flow, cells, to_cells, dA[d], dq[d])
                if viscous is not None:
                    change_pushes(dq[d], vessels, cells, fluid, longer, faces, face_dA, viscous)
                continue_lines(dA[d], dq[d], vessels.single, Faces(face_dA, face_dq))
                if changing is not None:
                    continue_changing(dA[d], dq[d], changing, weight, carrying, face_dq)
            update_cells(area, flow, cells, fluid, fluxes, faces)
            if changing is not None:
                keep_energy(flow, cells, changing, faces)
            if viscous is not None:
                push_cells(flow, vessels, cells, fluid, viscous.base, faces)
            continue_lines(area, flow, vessels.single, faces)
            if changing is not None:
                continue_by_pressure(area, flow, cells, wall, changing, fluxes, faces)

    return advance_changes


@cache
def _kernels() -> tuple[Any, Any]:
    varied = variations, node_variations, changing_variations, viscosity_variations
    return kept(_compiled(), *PARTS, *varied), _compiled()


def varied_cycle_kernel(law: type) -> Any:
    """Return the compiled cycle with changes for models with this wall law (its class); kept as `cycle_kernel` is."""
    return _kernels()[not is_known(law)]
