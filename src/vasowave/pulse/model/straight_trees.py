"""Trees of straight vessels in the frequency domain, many members at once: `linear` of what is common, compiled.

TreeMembers share network and blood; walls and beds are their own. The laws' equations give areas and compliances at one
pressure a vessel, so that one kernel serves all laws. It does not know of shapes, dynamic pressures and loops.
"""

from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from vasowave.base.runtime.kernels import kept
from vasowave.pulse.model import walls
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.walls import Values
from vasowave.pulse.network.network import Network

MEAN_ROUNDS = 4
"""Rounds in which areas fix friction, that the pressure, it areas."""
_OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract", "nsz", "arcp"},
    "no_cfunc_wrapper": True,
    "_nrt": False,  # kernels make no arrays
}
_PART: dict[str, Any] = _OPTIONS | {"forceinline": True, "no_cpython_wrapper": True}


class TreeMembers(NamedTuple):
    """Models of one network.

    Attributes
    ----------
    wall : wall law
        Its parameters, shapes (member, vessel) or (member, 1).
    area0 : array, shape (member, vessel)
        cm².
    viscosity : array, shape (member, vessel) or (member, 1)
        Of the walls, mmHg s.
    end : complex array, shape (member, terminal, harmonic)
        Impedance of the beds, mmHg s/ml.
    behind : array, shape (terminal,)
        Steady pressure behind them, mmHg.
    """

    wall: Any
    area0: np.ndarray
    viscosity: np.ndarray
    end: np.ndarray
    behind: np.ndarray


class TreeOrder(NamedTuple):
    """The order of a tree, and what its blood meets: drag is (k0 + k1 √A)/A, 1/s."""

    downward: np.ndarray  # (vessel,) rows, parents first
    parent: np.ndarray  # (vessel,)
    terminals: np.ndarray  # (terminal,) rows
    length: np.ndarray  # (vessel,) cm
    inertia: float
    k0: float
    k1: float


class SteadyTree(NamedTuple):
    """Steady pressures and flows of all vessels, shape (member, vessel)."""

    fall: np.ndarray  # resistance of a vessel, mmHg s/ml
    resistance: np.ndarray  # of it and all beyond
    by_beds: np.ndarray  # pressure at its inlet where nothing flows, mmHg
    by_flow: np.ndarray  # what the flow adds to that
    flow: np.ndarray  # ml/s
    middle: np.ndarray  # pressure in its middle, mmHg


class TreeSpectra(NamedTuple):
    """Harmonics of all vessels, shape (member, vessel, harmonic); see `LinearSolution` and `UniformLines`."""

    propagation: np.ndarray
    impedance: np.ndarray
    input_impedance: np.ndarray
    pressure: np.ndarray
    flow: np.ndarray


@njit(**_PART)
def _over(a, b):
    """A over b."""
    return a * b.conjugate() * (1.0 / (b.real * b.real + b.imag * b.imag))


@njit(**_PART)
def _root(z):
    """The square root of z with positive real part, where z has none below the real axis."""
    larger = np.sqrt(0.5 * (np.sqrt(z.real * z.real + z.imag * z.imag) + abs(z.real)))
    smaller = 0.5 * z.imag / larger
    return complex(larger, smaller) if z.real >= 0.0 else complex(smaller, larger)


def steady(tree, area, bed, behind, inflow, means):
    """Fill in what a steady inflow (ml/s) makes of vessels of these areas, before beds of these resistances."""
    for n in range(len(area)):
        fall, resistance, by_beds, by_flow, flow, middle = means
        conductance = flow[n]
        for v in range(len(conductance)):
            A = area[n, v]
            fall[n, v] = tree.inertia * tree.length[v] * (tree.k0 + tree.k1 * np.sqrt(A)) / (A * A)
            conductance[v] = by_beds[n, v] = 0.0
        for t in range(len(tree.terminals)):
            conductance[tree.terminals[t]] = 1.0 / bed[n, t]
            by_beds[n, tree.terminals[t]] = behind[t] / bed[n, t]
        for i in range(len(conductance) - 1, -1, -1):
            v = tree.downward[i]
            resistance[n, v] = fall[n, v] + 1.0 / conductance[v]
            by_beds[n, v] /= conductance[v]
            if i > 0:
                conductance[tree.parent[v]] += 1.0 / resistance[n, v]
                by_beds[n, tree.parent[v]] += by_beds[n, v] / resistance[n, v]
        for i in range(len(conductance)):
            v, u = tree.downward[i], tree.parent[tree.downward[i]]
            if i == 0:
                by_flow[n, v] = inflow * resistance[n, v]
            else:
                by_flow[n, v] = by_flow[n, u] * (1.0 - fall[n, u] / resistance[n, u]) + by_beds[n, u] - by_beds[n, v]
        for v in range(len(conductance)):
            flow[n, v] = by_flow[n, v] / resistance[n, v]
            middle[n, v] = by_beds[n, v] + by_flow[n, v] - 0.5 * fall[n, v] * flow[n, v]


def oscillate(tree, area, compliance, retardation, end, omega, entering, spectra):
    """Fill in the harmonics 1 … of vessels of these areas, compliances (cm²/mmHg) and times of viscosity (s)."""
    for n in range(len(area)):
        propagation, impedance, input_impedance, pressure, flow = spectra
        load = flow[n]
        load[:] = 0.0
        for t in range(len(tree.terminals)):
            for k in range(1, len(omega)):
                load[tree.terminals[t], k] = _over(complex(1.0, 0.0), end[n, t, k])
        for i in range(len(load) - 1, -1, -1):
            v = tree.downward[i]
            A, C, delay = area[n, v], compliance[n, v], retardation[n, v]
            drag, up = (tree.k0 + tree.k1 * np.sqrt(A)) / A, max(tree.parent[v], 0)
            for k in range(1, len(omega)):
                series = tree.inertia / A * complex(drag, omega[k])
                slowed = omega[k] * delay
                change = _root(series * complex(slowed, 1.0) * (omega[k] * C / (1.0 + slowed * slowed)))
                line = _over(series, change)
                x = change * tree.length[v]
                grown = np.exp(x.real)
                half_sum, half_difference = 0.5 * (grown + 1.0 / grown), 0.5 * (grown - 1.0 / grown)
                cos, sin = np.cos(x.imag), np.sin(x.imag)
                cosh = complex(half_sum * cos, half_difference * sin)
                tanh = _over(complex(half_difference * cos, half_sum * sin), cosh)
                share = 1.0 + load[v, k] * line * tanh
                inward = _over(load[v, k] + _over(tanh, line), share)
                propagation[n, v, k], impedance[n, v, k] = change, line
                input_impedance[n, v, k] = _over(complex(1.0, 0.0), inward)
                load[v, k] = _over(complex(1.0, 0.0), cosh * share)  # the share of the pressure that passes
                if i > 0:
                    load[up, k] += inward
        for i in range(len(load)):
            v, u = tree.downward[i], max(tree.parent[tree.downward[i]], 0)
            for k in range(1, len(omega)):
                pressure[n, v, k] = input_impedance[n, v, k] * entering[k] if i == 0 else pressure[n, u, k] * load[u, k]
        for v in range(len(load)):
            for k in range(1, len(omega)):
                flow[n, v, k] = _over(pressure[n, v, k], input_impedance[n, v, k])


@cache
def _kernels() -> tuple[Any, Any]:
    return kept(njit(**_OPTIONS)(steady)), kept(njit(**_OPTIONS)(oscillate))


def retardation(viscosity: Values, compliance: Values, area: Values, area0: Values) -> np.ndarray:
    """Time τ of viscous walls (mmHg s) of these compliances (cm²/mmHg) and areas (cm²), s."""
    return np.asarray(viscosity * compliance / (2.0 * np.sqrt(area * area0)))


@lru_cache(maxsize=8)
def _order(network: Network) -> tuple[np.ndarray, ...]:
    """Return `downward`, `parent`, `terminals` and `length` of `TreeOrder`."""
    rows = (np.concatenate(network.generations), network.parent, network.terminals)
    return *(np.array(values, dtype=np.int64) for values in rows), np.array(network.length)


def _tree(network: Network, blood: Blood, period: float) -> TreeOrder:
    k0, k1 = map(float, blood.friction.coefficients(blood.viscosity, period))
    downward, parent, terminals, length = _order(network)
    return TreeOrder(downward, parent, terminals, length, float(blood.inertia), k0, k1)


def solve_members(
    network: Network, blood: Blood, members: TreeMembers, spectrum: np.ndarray, period: float
) -> tuple[np.ndarray, SteadyTree, TreeSpectra]:
    """Return mean pressures about which vessels are linearized (mmHg, shape (member, vessel)), means and harmonics.

    Parameters
    ----------
    network : Network
        A tree.
    blood : Blood
    members : TreeMembers
    spectrum : complex array, shape (harmonic,)
        Of the inflow, ml/s.
    period : float
        s.
    """
    find_means, find_waves = _kernels()
    tree, (wall, area0, viscosity, end, behind) = _tree(network, blood, period), members
    shape, inflow = (len(end), len(network)), float(spectrum[0].real)
    bed, means = np.ascontiguousarray(end[:, :, 0].real), SteadyTree(*np.empty((len(SteadyTree._fields), *shape)))
    means.middle[:] = np.mean(behind)
    for _ in range(MEAN_ROUNDS):
        find_means(tree, np.asarray(walls.area(wall, means.middle, area0)), bed, behind, inflow, means)
    mean_pressure = means.middle.copy()
    area = np.asarray(walls.area(wall, mean_pressure, area0))
    compliance = np.asarray(walls.area_compliance(wall, mean_pressure, area0))
    find_means(tree, area, bed, behind, inflow, means)
    omega = 2 * np.pi / period * np.arange(len(spectrum))
    spectra = TreeSpectra(*np.empty((len(TreeSpectra._fields), *shape, len(spectrum)), dtype=complex))
    delay = retardation(viscosity, compliance, area, area0)
    find_waves(tree, area, compliance, delay, end, omega, np.ascontiguousarray(spectrum), spectra)
    values = 0.0, 1.0, means.resistance, means.by_beds + means.by_flow, means.flow
    for harmonics, mean in zip(spectra, values, strict=True):
        harmonics[..., 0] = mean
    return mean_pressure, means, spectra
