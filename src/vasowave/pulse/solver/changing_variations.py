"""The scheme where radius or stiffness change along a vessel (`changing`), linearized.

Wherever a place takes the area that its own wall has at a pressure p, that area changes by ``C (dp - g)``: C is its
compliance there, and g what its wall's parameters and A0 would do to the pressure at an unchanged area.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vasowave.pulse.solver.cells import OPTIONS
from vasowave.pulse.solver.laws import pressure_at, ratio_at, slope_at
from vasowave.pulse.solver.variations import SHIFT


class Carried(NamedTuple):
    """Places that take a pressure from elsewhere, and the derivatives there; scratch memory."""

    pressure: np.ndarray  # (place,)
    compliance: np.ndarray  # (place,) C
    wall: np.ndarray  # (parameter + 1, place) of g by the logarithms of the law's parameters and of A0


class Carrying(NamedTuple):
    """All such places, and what else is needed of them."""

    face: Carried
    end: Carried  # with the pressure of the cell next to the end
    inner: Carried  # with that of the one behind it
    inlet: Carried  # the only cell of a vessel, with the pressure of its inlet
    outlet: Carried
    gain_by_flow: np.ndarray  # (place,) of the flow that an end gains, by the flow of the cell
    gain_by_end: np.ndarray  # (place,) by the area carried to the end
    gain_by_cell: np.ndarray  # (place,) by the cell's own
    drag: np.ndarray  # (2, slot) flow of the left face, and of the cell, by the logarithm of the drag along the cell
    energy: np.ndarray  # (5, slot) the flow of `keep_energy`; by area and flow of the left face; of the right
    pressure: np.ndarray  # (slot,) change of pressure in one direction


@njit(**OPTIONS)
def differentiate_carried(place, per_area0, wall, shifted, carried):
    """Derivatives of the area that `place` has at ``carried.pressure``."""
    last = len(carried.wall) - 1
    for i in range(len(place)):
        j = place[i]
        ratio, slope = ratio_at(wall, j, carried.pressure[i]), slope_at(wall, j, carried.pressure[i])
        carried.compliance[i] = slope / per_area0[j]
        carried.wall[last, i] = -ratio / slope
    k = 0
    for up, down in shifted:
        for i in range(len(place)):
            j = place[i]
            a = ratio_at(wall, j, carried.pressure[i])
            carried.wall[k, i] = (pressure_at(up, j, a) - pressure_at(down, j, a)) / (2.0 * SHIFT)
        k += 1  # noqa: SIM113  Numba cannot enumerate tuples


@njit(**OPTIONS)
def differentiate_changing(area, ends, geometry, walls, shifted, fluid, cell_fluxes, fluxes, nodes, carrying, slopes):
    """Derivatives at all places that change; those of the ends in `slopes` become those of the area carried there."""
    cells, at_faces, changing = geometry
    wall, face_wall, end_wall = walls
    cell_shift, face_shift, end_shift = shifted
    for i in range(len(changing.face)):
        j = changing.face[i]
        carrying.face.pressure[i] = 0.5 * (cell_fluxes.pressure[j - 1] + cell_fluxes.pressure[j])
    for i in range(len(changing.single)):
        j = changing.single[i]
        carrying.inlet.pressure[i], carrying.outlet.pressure[i] = fluxes.pressure[j], fluxes.pressure[j + 1]
    for i in range(len(changing.end)):
        e = changing.end[i]
        carrying.end.pressure[i] = nodes.cell_pressure[e]
        carrying.inner.pressure[i] = cell_fluxes.pressure[ends.inner[e]]
    differentiate_carried(changing.face, at_faces.per_area0, face_wall, face_shift, carrying.face)
    differentiate_carried(changing.single, cells.per_area0, wall, cell_shift, carrying.inlet)
    differentiate_carried(changing.single, cells.per_area0, wall, cell_shift, carrying.outlet)
    differentiate_carried(changing.end, ends.per_area0, end_wall, end_shift, carrying.end)
    differentiate_carried(changing.end, ends.per_area0, end_wall, end_shift, carrying.inner)
    for i in range(len(changing.end)):
        e = changing.end[i]
        A, twice = nodes.area[e], 2.0 * ends.half[e] * ends.side[e]
        u, rise = nodes.flow[e] / A, A - area[ends.cell[e]]
        carrying.gain_by_flow[i] = 2.0 * twice * u * rise / A
        carrying.gain_by_end[i] = twice * u * u * (1.0 - 2.0 * rise / A)
        carrying.gain_by_cell[i] = -twice * u * u
        slopes.cell_pressure[e] = 1.0 / carrying.end.compliance[i]
        slopes.cell_drag[e] = -0.5 / A * (nodes.drag[e] + fluid.k0 / A)
        for k in range(len(carrying.end.wall)):
            slopes.wall[k, e] = carrying.end.wall[k, i]


@njit(**OPTIONS)
def differentiate_gains(changing, nodes, carrying, slopes):
    """What the gains of the ends add to the derivatives of r."""
    for i in range(len(changing.end)):
        e = changing.end[i]
        by_flow = slopes.by_foot_flow[e]
        slopes.flow[e] += by_flow * carrying.gain_by_flow[i]
        slopes.area[e] += by_flow * carrying.gain_by_end[i]
        slopes.length[e] -= by_flow * nodes.gain[e]  # a longer vessel has longer cells


@njit(**OPTIONS)
def differentiate_energy(cells, changing, faces, energy):
    """What `keep_energy` adds to the flow in the cells, and its derivatives."""
    for j in changing.cell:
        left_speed, right_speed = faces.flow[j] / faces.area[j], faces.flow[j + 1] / faces.area[j + 1]
        wider, faster, share = faces.area[j + 1] - faces.area[j], right_speed - left_speed, 0.5 * cells.half[j]
        by_speed = 2.0 * share * wider * faster
        energy[0, j] = share * wider * faster * faster
        energy[1, j] = by_speed * left_speed / faces.area[j] - share * faster * faster
        energy[2, j] = -by_speed / faces.area[j]
        energy[3, j] = share * faster * faster - by_speed * right_speed / faces.area[j + 1]
        energy[4, j] = by_speed / faces.area[j + 1]


@njit(**OPTIONS)
def differentiate_drag_along(cells, changing, cell_fluxes, fluxes, faces, to_faces, drag):
    """What more drag along the cells does to the flows that it slows."""
    for j in changing.face:
        drag[0, j] = to_faces.drag[j] * (cell_fluxes.drag[j - 1] + cell_fluxes.drag[j])
    for j in changing.cell:
        drag[1, j] = -0.5 * cells.dt[j] * (fluxes.drag[j] * faces.flow[j] + fluxes.drag[j + 1] * faces.flow[j + 1])


@njit(**OPTIONS)
def change_pressures(changing, dA, slopes, weight, pressure):
    """Changes of the pressures in the cells, or at the faces, of the vessels that change."""
    for j in changing.slot:
        pressure[j] = slopes.pressure[j] * dA[j]
    for k in range(len(weight)):
        for j in changing.slot:
            pressure[j] += slopes.wall[k, j] * weight[k, j]


@njit(**OPTIONS)
def change_carried(i, dp, carried, weight, j):
    """Return the change of the area that place i has at a pressure which changes by `dp`; its wall stands at j."""
    for k in range(len(weight)):
        dp -= carried.wall[k, i] * weight[k, j]
    return carried.compliance[i] * dp


@njit(**OPTIONS)
def change_changing_faces(
    dA, dq, cells, changing, slopes, stencil, weight, face_weight, drag, carrying, face_dA, face_dq
):
    """Changes at the inner faces: of the area, and of the flow where the wall's changes are not the same all along."""
    change_pressures(changing, dA, slopes, weight, carrying.pressure)
    for i in range(len(changing.face)):
        j = changing.face[i]
        dp = 0.5 * (carrying.pressure[j - 1] + carrying.pressure[j])
        face_dA[j] = change_carried(i, dp, carrying.face, face_weight, j) - cells.half[j - 1] * (dq[j] - dq[j - 1])
        face_dq[j] += carrying.drag[0, j] * drag[j - 1]
    for k in range(len(weight)):
        for j in changing.face:
            face_dq[j] += stencil.fall[j] * slopes.wall[k, j - 1] * (weight[k, j] - weight[k, j - 1])


@njit(**OPTIONS)
def change_changing_ends(dA, ends, changing, weight, carrying, slopes, changes):
    """Changes r at the ends, once those by the cells' own areas are known."""
    for i in range(len(changing.end)):
        e = changing.end[i]
        end, inner = ends.cell[e], ends.inner[e]
        carried = change_carried(i, carrying.pressure[end], carrying.end, weight, e)
        behind = change_carried(i, carrying.pressure[inner], carrying.inner, weight, e)
        changes.flow[e] += slopes.area[e] * (carried - dA[end]) + slopes.inner_area[e] * (behind - dA[inner])
        changes.flow[e] += slopes.by_foot_flow[e] * carrying.gain_by_cell[i] * dA[end]


@njit(**OPTIONS)
def change_changing_cells(face_dA, face_dq, changing, slopes, stencil, longer, face_weight, drag, carrying, dq):
    """Changes of the flow in the cells by `keep_energy`, and where the wall's changes are not the same all along."""
    energy = carrying.energy
    for j in changing.cell:
        dq[j] += energy[1, j] * face_dA[j] + energy[2, j] * face_dq[j]
        dq[j] += energy[3, j] * face_dA[j + 1] + energy[4, j] * face_dq[j + 1] - energy[0, j] * longer[j]
        dq[j] += carrying.drag[1, j] * drag[j]
    change_pressures(changing, face_dA, slopes, face_weight, carrying.pressure)
    for k in range(len(face_weight)):
        for j in changing.cell:
            dq[j] += stencil.fall[j] * slopes.wall[k, j + 1] * (face_weight[k, j + 1] - face_weight[k, j])


@njit(**OPTIONS)
def continue_changing(dA, dq, changing, weight, carrying, face_dq):
    """As `continue_by_pressure`, for changes."""
    for i in range(len(changing.single)):
        j = changing.single[i]
        rise = change_carried(i, carrying.pressure[j + 1], carrying.outlet, weight, j)
        rise -= change_carried(i, carrying.pressure[j], carrying.inlet, weight, j)
        gain = face_dq[j + 1] - face_dq[j]
        dA[j + 1], dA[j + 2] = dA[j] + rise, dA[j] - rise
        dq[j + 1], dq[j + 2] = dq[j] + gain, dq[j] - gain
