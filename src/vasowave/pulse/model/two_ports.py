"""Two-ports joined in nodes: spectra of pressure and flow in every vessel of a network, from inflows and beds.

A tree is eliminated from its beds up and filled from its root down; a graph with loops is one linear system of its
nodes' pressures a harmonic.
"""

from typing import NamedTuple

import numpy as np

from vasowave.pulse.network.network import Network


class TwoPort(NamedTuple):
    """P_in = d (turn P_out + across Q_out), Q_in = d (along P_out + Q_out); shapes (harmonic, vessel)."""

    d: np.ndarray
    turn: np.ndarray
    across: np.ndarray
    along: np.ndarray

    def then(self, after: "TwoPort") -> "TwoPort":
        """Return both, one behind the other."""
        share = 1.0 + self.along * after.across
        return TwoPort(
            self.d * after.d * share,
            (self.turn * after.turn + self.across * after.along) / share,
            (self.turn * after.across + self.across) / share,
            (self.along * after.turn + after.along) / share,
        )


def input_impedances(network: Network, end: np.ndarray, ports: TwoPort) -> np.ndarray:
    """Impedance at every inlet of a tree, from the beds (whose impedance is `end`) up, one generation at a time."""
    load_admittance = np.zeros((len(end), len(network)), dtype=complex)
    load_admittance[:, network.terminals] = 1.0 / end
    Z_in, (_, turn, across, along) = np.empty_like(load_admittance), ports
    for rows in reversed(network.generations):
        admittance, parents = load_admittance[:, rows], network.parent[rows]
        Z_in[:, rows] = (turn[:, rows] + admittance * across[:, rows]) / (admittance + along[:, rows])
        if parents[0] >= 0:
            np.add.at(load_admittance.T, parents, (1.0 / Z_in[:, rows]).T)
    return Z_in


def driven_from_behind(
    network: Network, ports: TwoPort, end: np.ndarray, behind: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return spectra of pressure and flow at all inlets of a network without inflow: what pressures behind beds make.

    In a tree every vessel with what lies beyond it is a pressure without flow before an impedance (Thévenin).
    Parameters as of `joined`.
    """
    if network.nodes is not None:
        return joined(network, ports, end, np.zeros((len(end), len(network.inlets))), behind)
    d, turn, across, along = ports
    load, driven = np.zeros((2, len(end), len(network)), dtype=complex)  # admittance, and its flow at no pressure
    load[:, network.terminals], driven[:, network.terminals] = 1.0 / end, behind / end
    alone = np.empty_like(load)
    for rows in reversed(network.generations):
        source_flow, admittance, parents = driven[:, rows], load[:, rows], network.parent[rows]
        held = admittance + along[:, rows]
        alone[:, rows] = d[:, rows] * (turn[:, rows] - across[:, rows] * along[:, rows]) * source_flow / held
        if parents[0] >= 0:
            inward = held / (turn[:, rows] + admittance * across[:, rows])
            np.add.at(load.T, parents, inward.T)
            np.add.at(driven.T, parents, (inward * alone[:, rows]).T)
    pressure = np.empty_like(load)
    pressure[:, network.root] = alone[:, network.root]
    outlet = np.empty_like(load)
    for rows in network.generations:
        if network.parent[rows][0] >= 0:
            pressure[:, rows] = outlet[:, network.parent[rows]]
        entering = pressure[:, rows] / d[:, rows] + across[:, rows] * driven[:, rows]
        outlet[:, rows] = entering / (turn[:, rows] + across[:, rows] * load[:, rows])
    return pressure, d * ((along + load) * outlet - driven)


def joined(
    network: Network, ports: TwoPort, end: np.ndarray, inflow: np.ndarray, behind: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return spectra of pressure and flow at the start of every vessel of any network, shape (harmonic, vessel).

    Parameters
    ----------
    network : Network
    ports : TwoPort
        Vessels, none without anything `across`.
    end : complex array, shape (harmonic, terminal)
        Impedance of the beds.
    inflow : complex array, shape (harmonic, inlet)
        ml/s.
    behind : array, shape (harmonic, terminal), optional
        Pressure behind the beds, mmHg; none by default.
    """
    number, ends = np.unique(np.concatenate([network.start, network.end]), return_inverse=True)
    first, last = ends[: len(network)], ends[len(network) :]
    d, turn, across, along = ports
    by_start, by_end = 1.0 / across, d * (along - turn / across)  # of the flow that enters a vessel
    passed, held = 1.0 / (d * across), -turn / across  # of the flow that leaves it
    balance = np.zeros((len(end), len(number), len(number)), dtype=complex)
    source_flow = np.zeros((len(end), len(number)), dtype=complex)
    for rows, columns, values in ((first, first, by_start), (first, last, by_end), (last, first, -passed),
                                  (last, last, -held)):  # fmt: skip
        np.add.at(balance.transpose(1, 2, 0), (rows, columns), values.T)
    source_flow[:, first[network.inlets]] = inflow
    beds = last[network.terminals]
    balance[:, beds, beds] += 1.0 / end
    if behind is not None:
        source_flow[:, beds] = behind / end
    pressure = np.linalg.solve(balance, source_flow[..., np.newaxis])[..., 0]
    return pressure[:, first], by_start * pressure[:, first] + by_end * pressure[:, last]


def steady_means(
    network: Network, fall: np.ndarray, bed: np.ndarray, inflow: np.ndarray, behind: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return mean pressure in the middle (mmHg) and flow (ml/s) of vessels with steady resistances `fall`, (vessel,).

    `bed` and the pressure `behind` are those of the terminals, `inflow` is that into the inlets.
    """
    if network.nodes is not None:
        ones = np.ones((1, len(network)))
        pressure, flow = joined(network, TwoPort(ones, ones, fall[np.newaxis], 0 * ones), bed[np.newaxis],
                                inflow[np.newaxis], behind[np.newaxis])  # fmt: skip
        return pressure[0].real - 0.5 * fall * flow[0].real, flow[0].real
    parent, downward = network.parent.tolist(), np.concatenate(network.generations).tolist()
    beds, pulled = np.zeros(len(network)), np.zeros(len(network))
    beds[network.terminals] = 1.0 / bed
    pulled[network.terminals] = beds[network.terminals] * behind
    resistance, conductance, without = fall.tolist(), beds.tolist(), pulled.tolist()
    for row in reversed(downward):  # plain numbers: arrays of a few vessels cost more
        resistance[row] += 1.0 / conductance[row]
        without[row] /= conductance[row]
        if parent[row] >= 0:
            conductance[parent[row]] += 1.0 / resistance[row]
            without[parent[row]] += without[row] / resistance[row]
    share_passed, above = 1.0 - fall / resistance, [float(inflow[0]) * resistance[network.root]] * len(network)
    for row in downward[1:]:
        before = parent[row]
        above[row] = above[before] * float(share_passed[before]) + without[before] - without[row]
    return np.asarray(without) + 0.5 * (1.0 + share_passed) * above, np.asarray(above) / resistance
