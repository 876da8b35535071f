"""One compiled cycle and its linearization: the steps of `cycle`, and beside them the changes in every direction."""

from functools import cache
from typing import Any

from numba import njit

from vasowave.base.runtime.kernels import is_known, kept
from vasowave.pulse.solver import node_variations, variations
from vasowave.pulse.solver.cells import WHOLE, continue_lines, find_fluxes, inner_faces, update_cells
from vasowave.pulse.solver.cycle import PARTS
from vasowave.pulse.solver.node_variations import (
    change_beds,
    change_characteristics,
    change_memory,
    differentiate_characteristics,
    differentiate_nodes,
    differentiate_speeds,
    ends_changer,
    gather_slopes,
    lengthen_characteristics,
    see_faces,
)
from vasowave.pulse.solver.nodes import characteristics, gather, nodes_solver
from vasowave.pulse.solver.terms import Kinds, changes_of_all, of_all, with_modules_of
from vasowave.pulse.solver.variations import (
    change_cells,
    change_faces,
    differentiate_cells,
    differentiate_faces,
    differentiate_fluxes,
    lengthen_cells,
    lengthen_faces,
)


def _compiled(kinds: Kinds) -> Any:
    at_faces, at_ends, before_nodes = (of_all(name, kinds) for name in ("at_faces", "at_ends", "before_nodes"))
    begin, in_cells, around_single = (of_all(name, kinds) for name in ("begin", "in_cells", "around_single"))
    solve_nodes, change_all_ends = nodes_solver(kinds), ends_changer(kinds)
    linearize_ends, linearize = changes_of_all("linearize_ends", kinds), changes_of_all("linearize", kinds)
    change_faces_of_terms, change_ends_of_terms, change_inflow = (
        changes_of_all(name, kinds) for name in ("change_faces", "change_ends", "change_inflow")
    )
    record_changes, change_cells_of_terms, change_single = (
        changes_of_all(name, kinds) for name in ("record_changes", "change_cells", "change_single")
    )

    @njit(**WHOLE)
    def advance_changes(step, terms, tangent):
        """Run a cycle from its state and the changes of it, which become those of its end."""
        inflow, (area, flow, memory), scheme, half, _ = step
        vessels, cells, face_cells, ends, (wall, face_wall, end_wall), fluid, outlet = scheme
        cell_fluxes, faces, fluxes, nodes = half
        (dA, dq), shifted, outlets, in_slots, in_faces, in_ends, cell_slopes, slopes = tangent[:8]
        to_faces, to_cells, lines, at_nodes, changes, records = tangent[8:]
        face_dA, face_dq, before = changes.area, changes.flow, outlets.before
        begin(terms, step, 0)
        for n in range(len(inflow)):
            find_fluxes(area, flow, cells, wall, fluid, cell_fluxes)
            inner_faces(area, flow, cells, fluid, cell_fluxes, faces)
            at_faces(terms, step, n)
            gather(area, flow, cell_fluxes, ends, nodes)
            at_ends(terms, step, n)
            characteristics(ends, end_wall, fluid, nodes)
            for j in range(before.shape[0]):
                for i in range(before.shape[1]):
                    before[j, i] = memory[j, i]
            before_nodes(terms, step, n)
            solve_nodes(inflow[n], memory, scheme, half, terms, step, n)
            find_fluxes(faces.area, faces.flow, face_cells, face_wall, fluid, fluxes)

            differentiate_fluxes(step.state, cells, wall, shifted.cells, fluid, cell_fluxes, cell_slopes)
            differentiate_fluxes(faces, face_cells, face_wall, shifted.faces, fluid, fluxes, slopes)
            differentiate_faces(area, flow, cells, fluid, cell_fluxes, cell_slopes, to_faces)
            differentiate_cells(faces.area, faces.flow, cells, fluid, fluxes, slopes, to_cells)
            gather_slopes(ends, nodes, faces, cell_slopes, slopes, lines)
            linearize_ends(terms, step, tangent, n, 0)
            differentiate_speeds(ends, fluid, end_wall, shifted.ends, nodes, lines)
            differentiate_characteristics(ends, nodes, lines)
            differentiate_nodes(outlet, ends, nodes, lines)
            linearize(terms, step, tangent, n, 0)
            for d in range(len(dA)):
                rows, longer = in_slots.rows[d], in_slots.length[d]
                weight, face_weight = in_slots.wall[d, :rows], in_faces.wall[d, :rows]
                change_faces(dA[d], dq[d], cells, to_faces, weight, face_dA, face_dq)
                change_faces_of_terms(terms, step, tangent, n, d)
                change_characteristics(dA[d], dq[d], ends, lines, in_ends.wall[d, :rows], at_nodes)
                change_ends_of_terms(terms, step, tangent, n, d)
                if in_slots.lengthens[d]:
                    lengthen_faces(longer, flow, cells, to_faces, face_dA, face_dq)
                    lengthen_characteristics(in_ends.length[d], lines, at_nodes)
                change_beds(d, outlet, outlets, ends, faces, at_nodes)
                change_inflow(terms, step, tangent, n, d)
                change_all_ends(ends, nodes, terms, step, tangent, n, d)
                change_memory(d, outlet, outlets, ends, faces, face_dq)
                records.inlet[d, n] = at_nodes.pressure[ends.inlet]
                see_faces(d, n, records, slopes, face_weight, changes)
                record_changes(terms, step, tangent, n, d)
                change_cells(face_dA, face_dq, cells, to_cells, face_weight, dA[d], dq[d])
                if in_slots.lengthens[d]:
                    lengthen_cells(longer, faces.flow, cells, to_cells, dA[d], dq[d])
                change_cells_of_terms(terms, step, tangent, n, d)
                continue_lines(dA[d], dq[d], vessels.single, changes)
                change_single(terms, step, tangent, n, d)
            update_cells(area, flow, cells, fluid, fluxes, faces)
            in_cells(terms, step, n)
            continue_lines(area, flow, vessels.single, faces)
            around_single(terms, step, n)

    return advance_changes


@cache
def _kernels(kinds: Kinds) -> tuple[Any, Any]:
    return kept(_compiled(kinds), *with_modules_of(kinds, *PARTS, node_variations, variations)), _compiled(kinds)


def varied_cycle_kernel(law: type, kinds: Kinds) -> Any:
    """Return the compiled cycle with changes for this wall law and tangents of these kinds; kept as `cycle_kernel`."""
    return _kernels(kinds)[not is_known(law)]
