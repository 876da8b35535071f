"""The compiled scheme where radius or stiffness change along a vessel: what `cells` and `nodes` do otherwise there.

Inside, the momentum equation needs no further term: it takes A/ρ ∂p/∂x as the difference of pressures, which holds the
terms of A0'(x) and of the wall's changing parameters. But areas must not be averaged or carried from place to place,
because at one pressure they differ. What is carried is the pressure: a place has the area that its own wall has at it.
So a vessel at rest under a uniform pressure stays at rest, whatever its shape and law.

The characteristic that leaves a vessel keeps ``dq - m (dA/dp) dp = (u² ∂A/∂x - drag q) dt``, with ∂A/∂x at a constant
pressure: its end differs from its foot by the pressure, and by what the change of area gives the flow.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from vasowave.pulse.solver.cells import OPTIONS
from vasowave.pulse.solver.laws import pressure_at, ratio_at, slope_at
from vasowave.pulse.solver.variations import SHIFT


class Changing(NamedTuple):
    """Places of the vessels whose radius or stiffness changes along their way: a term."""

    face: np.ndarray  # (inner face,)
    cell: np.ndarray  # (cell,)
    slot: np.ndarray  # (slot,) with the ghosts
    end: np.ndarray  # (end,) among `Ends`
    single: np.ndarray  # (short vessel,) the only cell of every one of them of one cell

    def at_faces(self, step, n):
        """Give the inner faces the area at their pressures."""
        half, scheme = step.half, step.scheme
        faces_by_pressure(
            step.state.flow, scheme.cells, scheme.faces, scheme.walls.faces, self, half.cell_fluxes, half.faces
        )

    def at_ends(self, step, n):
        """Bring pressures, not areas, to the ends."""
        half, scheme = step.half, step.scheme
        carry_to_ends(scheme.ends, scheme.walls.ends, scheme.fluid, self, half.cell_fluxes, half.nodes)

    def in_cells(self, step, n):
        """Keep Bernoulli's energy."""
        keep_energy(step.state.flow, step.scheme.cells, self, step.half.faces)

    def around_single(self, step, n):
        """Continue vessels of one cell by pressures."""
        half, scheme, state = step.half, step.scheme, step.state
        continue_by_pressure(
            state.area, state.flow, scheme.cells, scheme.walls.cells, self, half.face_fluxes, half.faces
        )


@njit(**OPTIONS)
def faces_by_pressure(flow, cells, at_faces, wall, changing, fluxes, faces):
    """Area at the inner faces at the half step: that of their own wall at the mean of the cells' pressures."""
    for j in changing.face:
        ratio = ratio_at(wall, j, 0.5 * (fluxes.pressure[j - 1] + fluxes.pressure[j]))
        faces.area[j] = ratio / at_faces.per_area0[j] - cells.half[j - 1] * (flow[j] - flow[j - 1])


@njit(**OPTIONS)
def keep_energy(flow, cells, changing, faces):
    """Take the momentum flux q²/A in the cells as ū Δq + Ā Δ(u²/2), with which a steady flow keeps Bernoulli's energy.

    The difference of q²/A itself has ½ Δ(u²) (Ā + Δu ΔA/4ū): of second order, but it grows with the change of area.
    """
    for j in changing.cell:
        wider = faces.area[j + 1] - faces.area[j]
        faster = faces.flow[j + 1] / faces.area[j + 1] - faces.flow[j] / faces.area[j]
        flow[j] += 0.5 * cells.half[j] * wider * faster * faster


@njit(**OPTIONS)
def carry_to_ends(ends, wall, fluid, changing, fluxes, nodes):
    """Area that the ends' own walls have at the pressures of the cells, its drag, and what the change of area adds."""
    for e in changing.end:
        A = ends.area0[e] * ratio_at(wall, e, nodes.cell_pressure[e])
        u = nodes.flow[e] / A
        nodes.gain[e] = 2.0 * ends.half[e] * ends.side[e] * u * u * (A - nodes.area[e])
        nodes.area[e], nodes.drag[e] = A, (fluid.k0 + fluid.k1 * np.sqrt(A)) / A
        nodes.inner_area[e] = ends.area0[e] * ratio_at(wall, e, fluxes.pressure[ends.inner[e]])


@njit(**OPTIONS)
def continue_by_pressure(area, flow, cells, wall, changing, fluxes, faces):
    """As `continue_lines`: slots around the only cell of a vessel, whose walls are the cell's."""
    for j in changing.single:
        rise = (ratio_at(wall, j, fluxes.pressure[j + 1]) - ratio_at(wall, j, fluxes.pressure[j])) / cells.per_area0[j]
        gain = faces.flow[j + 1] - faces.flow[j]
        area[j + 1], area[j + 2] = area[j] + rise, area[j] - rise
        flow[j + 1], flow[j + 2] = flow[j] + gain, flow[j] - gain


class Carried(NamedTuple):
    """Places that take a pressure from elsewhere, and the derivatives there; scratch memory."""

    pressure: np.ndarray  # (place,)
    compliance: np.ndarray  # (place,) C
    wall: np.ndarray  # (parameter + 1, place) of g by the logarithms of the law's parameters and of A0


class ChangingTangent(NamedTuple):
    """The tangent of `Changing`, with scratch memory.

    Wherever a place takes the area that its own wall has at a pressure p, that area changes by ``C (dp - g)``: C is its
    compliance there, and g what its wall's parameters and A0 would do to the pressure at an unchanged area.
    """

    base: Changing
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
    drags: np.ndarray  # (direction, slot) relative change of the drag along the cell

    def linearize_ends(self, step, tangent, n, d):
        """Find the derivatives of carried areas; those of the ends' cells become those of the area carried there."""
        gather_carried(self, step.scheme.ends, step.half)
        walls, shifted, scheme, changing = step.scheme.walls, tangent.shifted, step.scheme, self.base
        cells, ends = scheme.cells.per_area0, scheme.ends.per_area0
        differentiate_carried(changing.face, scheme.faces.per_area0, walls.faces, shifted.faces, self.face)
        differentiate_carried(changing.single, cells, walls.cells, shifted.cells, self.inlet)
        differentiate_carried(changing.single, cells, walls.cells, shifted.cells, self.outlet)
        differentiate_carried(changing.end, ends, walls.ends, shifted.ends, self.end)
        differentiate_carried(changing.end, ends, walls.ends, shifted.ends, self.inner)
        differentiate_changing_ends(self, step.state.area, scheme.ends, scheme.fluid, step.half.nodes, tangent.lines)

    def linearize(self, step, tangent, n, d):
        """Find the derivatives of what the ends gain, of the kept energy, and of the drag along cells."""
        half, cells = step.half, step.scheme.cells
        differentiate_gains(self.base, half.nodes, self, tangent.lines)
        differentiate_energy(cells, self.base, half.faces, self.energy)
        differentiate_drag_along(self, cells, half, tangent.to_faces.drag)

    def change_faces(self, step, tangent, n, d):
        """Change the inner faces: the area, and the flow where the wall's changes are not the same all along."""
        rows, dq, slopes = tangent.in_slots.rows[d], tangent.changed.flow[d], tangent.cell_slopes
        weight, face_weight = tangent.in_slots.wall[d, :rows], tangent.in_faces.wall[d, :rows]
        half, face_dA, face_dq = step.scheme.cells.half, tangent.faces.area, tangent.faces.flow
        change_pressures(self.base, tangent.changed.area[d], slopes, weight, self.pressure)
        for i in range(len(self.base.face)):
            j = self.base.face[i]
            dp = 0.5 * (self.pressure[j - 1] + self.pressure[j])
            face_dA[j] = change_carried(i, dp, self.face, face_weight, j) - half[j - 1] * (dq[j] - dq[j - 1])
            face_dq[j] += self.drag[0, j] * self.drags[d, j - 1]
        for k in range(rows):
            for j in self.base.face:
                face_dq[j] += tangent.to_faces.fall[j] * slopes.wall[k, j - 1] * (weight[k, j] - weight[k, j - 1])

    def change_ends(self, step, tangent, n, d):
        """Change r at the ends, once those by the cells' own areas are known."""
        weight = tangent.in_ends.wall[d, : tangent.in_ends.rows[d]]
        dA, ends = tangent.changed.area[d], step.scheme.ends
        change_changing_ends(dA, ends, weight, self, tangent.lines, tangent.at_nodes)

    def change_cells(self, step, tangent, n, d):
        """Change the flow in the cells by `keep_energy`, and where the wall's changes are not the same all along."""
        energy, longer, dq = self.energy, tangent.in_slots.length[d], tangent.changed.flow[d]
        face_dA, face_dq, slopes = tangent.faces.area, tangent.faces.flow, tangent.face_slopes
        weight = tangent.in_faces.wall[d, : tangent.in_faces.rows[d]]
        for j in self.base.cell:
            dq[j] += energy[1, j] * face_dA[j] + energy[2, j] * face_dq[j]
            dq[j] += energy[3, j] * face_dA[j + 1] + energy[4, j] * face_dq[j + 1] - energy[0, j] * longer[j]
            dq[j] += self.drag[1, j] * self.drags[d, j]
        change_pressures(self.base, face_dA, slopes, weight, self.pressure)
        for k in range(len(weight)):
            for j in self.base.cell:
                dq[j] += tangent.to_cells.fall[j] * slopes.wall[k, j + 1] * (weight[k, j + 1] - weight[k, j])

    def change_single(self, step, tangent, n, d):
        """Continue the changes of vessels of one cell by pressures."""
        weight = tangent.in_slots.wall[d, : tangent.in_slots.rows[d]]
        continue_changing(tangent.changed.area[d], tangent.changed.flow[d], weight, self, tangent.faces.flow)


def make_changing_tangent(changing: Changing, rows: int, slots: int, drags: np.ndarray) -> ChangingTangent:
    """Return the tangent for laws of ``rows - 1`` parameters, with the `drags` of every direction."""
    places = changing.face, changing.end, changing.end, changing.single, changing.single
    carried = [Carried(np.ones(len(place)), np.ones(len(place)), np.ones((rows, len(place)))) for place in places]
    gains = [np.ones(len(changing.end)) for _ in range(3)]
    scratch = *gains, np.ones((2, slots)), np.ones((5, slots)), np.ones(slots)
    return ChangingTangent(changing, *carried, *scratch, drags)  # type: ignore[call-arg, arg-type]


@njit(**OPTIONS)
def gather_carried(carrying, ends, half):
    """Collect the pressures that are carried from elsewhere."""
    changing, cell_pressure, face_pressure = carrying.base, half.cell_fluxes.pressure, half.face_fluxes.pressure
    for i in range(len(changing.face)):
        j = changing.face[i]
        carrying.face.pressure[i] = 0.5 * (cell_pressure[j - 1] + cell_pressure[j])
    for i in range(len(changing.single)):
        j = changing.single[i]
        carrying.inlet.pressure[i], carrying.outlet.pressure[i] = face_pressure[j], face_pressure[j + 1]
    for i in range(len(changing.end)):
        e = changing.end[i]
        carrying.end.pressure[i] = half.nodes.cell_pressure[e]
        carrying.inner.pressure[i] = cell_pressure[ends.inner[e]]


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
def differentiate_changing_ends(carrying, area, ends, fluid, nodes, slopes):
    """Derivatives of what the ends gain, and of their cells, now by the area carried to the end."""
    for i in range(len(carrying.base.end)):
        e = carrying.base.end[i]
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
def differentiate_drag_along(carrying, cells, half, by_drag):
    """What more drag along the cells does to the flows that it slows."""
    drag, of_cells, of_faces, flow = carrying.drag, half.cell_fluxes.drag, half.face_fluxes.drag, half.faces.flow
    for j in carrying.base.face:
        drag[0, j] = by_drag[j] * (of_cells[j - 1] + of_cells[j])
    for j in carrying.base.cell:
        drag[1, j] = -0.5 * cells.dt[j] * (of_faces[j] * flow[j] + of_faces[j + 1] * flow[j + 1])


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
def change_changing_ends(dA, ends, weight, carrying, slopes, changes):
    """Changes r at the ends, once those by the cells' own areas are known."""
    for i in range(len(carrying.base.end)):
        e = carrying.base.end[i]
        end, inner = ends.cell[e], ends.inner[e]
        carried = change_carried(i, carrying.pressure[end], carrying.end, weight, e)
        behind = change_carried(i, carrying.pressure[inner], carrying.inner, weight, e)
        changes.flow[e] += slopes.area[e] * (carried - dA[end]) + slopes.inner_area[e] * (behind - dA[inner])
        changes.flow[e] += slopes.by_foot_flow[e] * carrying.gain_by_cell[i] * dA[end]


@njit(**OPTIONS)
def continue_changing(dA, dq, weight, carrying, face_dq):
    """As `continue_by_pressure`, for changes."""
    for i in range(len(carrying.base.single)):
        j = carrying.base.single[i]
        rise = change_carried(i, carrying.pressure[j + 1], carrying.outlet, weight, j)
        rise -= change_carried(i, carrying.pressure[j], carrying.inlet, weight, j)
        gain = face_dq[j + 1] - face_dq[j]
        dA[j + 1], dA[j + 2] = dA[j] + rise, dA[j] - rise
        dq[j + 1], dq[j + 2] = dq[j] + gain, dq[j] - gain
