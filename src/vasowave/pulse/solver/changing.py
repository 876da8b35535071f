"""The compiled scheme where radius or stiffness change along a vessel: what `cells` and `nodes` do otherwise there.

Inside, the momentum equation needs no further term: it takes A/ρ ∂p/∂x as the difference of pressures, which holds the
terms of A0'(x) and of the wall's changing parameters. But areas must not be averaged or carried from place to place,
because at one pressure they differ. What is carried is the pressure: a place has the area that its own wall has at it.
So a vessel at rest under a uniform pressure stays at rest, whatever its shape and law.

The characteristic that leaves a vessel keeps ``dq - m (dA/dp) dp = (u² ∂A/∂x - drag q) dt``, with ∂A/∂x at a constant
pressure: its end differs from its foot by the pressure, and by what the change of area gives the flow.
"""

import numpy as np
from numba import njit

from vasowave.pulse.solver.cells import OPTIONS
from vasowave.pulse.solver.laws import ratio_at


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
