"""Repairs of a network that was made elsewhere: chains of single daughters, and vessels too short to carry a wave.

A segmentation leaves vessels of a micrometer and points at which nothing divides. A vessel that is far shorter than it
is wide carries no wave, yet it asks for steps as short as itself, and Poiseuille's division of the flow (eq. 11) gives
it nearly all. What is repaired keeps its resistance to steady flow and its compliance; what waves meet, `model.repairs`
knows.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from vasowave.base.cures import Tidy
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind
from vasowave.pulse.network.graph import meetings
from vasowave.pulse.network.network import MEASURED, Network

SHORTEST = 0.25
"""Shortest vessel that is kept, in its own radii: a junction is about one radius wide."""

LOST = 0.01
"""Volume, as a share of the network's, that lengthened vessels may add where a network is repaired unasked."""

_NAMED = 4  # repairs that a finding names
_NONE, _ROUNDING = -1.0, 1e-9

REPAIRED = look_kind(
    "network.repaired",
    "{summary}: {repairs}",
    "Repair the table yourself, or let it be repaired into a new file and look at that.",
    Tidy(),
)
NOT_REPAIRED = look_kind(
    "network.not-repaired",
    "vessels are too short to carry a wave, and repairing them would add {percent:.2g} % to the network's volume; they "
    "are left as they are",
    "Repair the table yourself, or let it be repaired into a new file and look at that.",
    Tidy(),
)

Code = Literal["joined", "merged", "lengthened"]

_MEANING: dict[Code, str] = {
    "joined": "nothing divides between '{into}' and '{vessel}' ({length:.3g} cm); both are '{into}' now",
    "merged": "'{vessel}' ({length:.3g} cm long, {radius:.3g} cm in radius) is too short for a wave; its daughters "
    "carry its resistance and compliance and start where it did",
    "lengthened": "'{vessel}' ({length:.3g} cm long, {radius:.3g} cm in radius) is too short for a wave; it is "
    "{shortest:.3g} cm long now",
}


@dataclass(frozen=True)
class Repair:
    """One repair of a network.

    Attributes
    ----------
    code : {"joined", "merged", "lengthened"}
        Joined to the only vessel before it; taken up by its daughters; made long enough, where it has none.
    vessel : str
        As it was called.
    into : str
        The vessel that took it up: the one before it if it was joined, or a terminal behind it, whose bed may be called
        by its name; else the first daughter; empty if it is there.
    length, radius : float
        As they were, cm.
    shortest : float
        Length below which such a vessel is repaired, cm.
    """

    code: Code
    vessel: str
    into: str
    length: float
    radius: float
    shortest: float

    def __str__(self) -> str:
        """Return the repair in words."""
        return _MEANING[self.code].format(**vars(self))


@dataclass(frozen=True, eq=False)
class Tidied:
    """A network after its repairs.

    Attributes
    ----------
    network : Network
    repairs : tuple of Repair
        In the order in which they were made; empty if nothing was wrong.
    added_volume : float
        Volume that lengthening added, as a share of the whole network's. All other repairs change no compliance.
    alike : float
        By how much the radii of vessels that were joined differ at most, largest over smallest less 1.
    change, split : float array, shape (harmonic,), optional
        By how much repairs change the input impedance, as a share of it, from the first harmonic on: with the same
        beds, and with those that share the flow anew (eq. 11). None where it was not asked.
    """

    network: Network
    repairs: tuple[Repair, ...]
    added_volume: float
    alike: float = np.inf
    change: np.ndarray | None = None
    split: np.ndarray | None = None

    def summary(self) -> str:
        """Return the repairs in one sentence; empty if there are none."""
        if not self.repairs:
            return ""
        counts = Counter(repair.code for repair in self.repairs)
        counted_codes = [f"{count} {code}" for code, count in counts.items()]
        end = f", which adds {100 * self.added_volume:.2g} % of its volume" if self.added_volume else ""
        counted = f"{len(self.repairs)} vessels of the network were repaired ({', '.join(counted_codes)}{end})"
        if self.change is None or self.split is None:
            return counted
        return (
            f"{counted}; this changes its input impedance by {100 * self.change.max():.3g} % at most in "
            f"{len(self.change)} harmonics, and by {100 * self.split.max():.3g} % with beds that share the flow anew"
        )


def repaired(network: Network) -> tuple[Network, list[Finding]]:
    """Return a network whose vessels can all be computed, and what was done for it; chains of longer vessels stay.

    Nothing is repaired where it would add more than `LOST` of the volume: all other repairs keep resistance and
    compliance.
    """
    tidied = tidy(network, alike=_NONE)
    if tidied.added_volume > LOST:
        return network, [NOT_REPAIRED(percent=100 * tidied.added_volume)]
    if not tidied.repairs:
        return network, []
    surplus = len(tidied.repairs) - _NAMED
    named = [*map(str, tidied.repairs[:_NAMED]), *([f"and {surplus} more"] if surplus > 0 else [])]
    return tidied.network, [REPAIRED(summary=tidied.summary(), repairs="; ".join(named))]


def tidy(network: Network, shortest: float = SHORTEST, *, alike: float = np.inf) -> Tidied:
    """Return the network without chains of single daughters and without vessels too short to carry a wave.

    Two vessels in line become one with the sum of their resistances to Poiseuille flow, ∝ Σ L/r⁴, and of their
    compliances at equal stiffness, ∝ Σ L r². A vessel shorter than `shortest` of its own radii hands both on to its
    daughters, as they share its flow; one without daughters is made `shortest` long, and so is an inlet, and one whose
    end others meet.

    Parameters
    ----------
    network : Network
    shortest : float
        Shortest vessel that is kept, in its own radii.
    alike : float
        Vessels in line that are long enough are joined if their radii, largest over smallest, differ by no more than
        this share; below 0, none is.

    Raises
    ------
    InputError
        `shortest` is negative or not a number.
    """
    if not (np.isfinite(shortest) and shortest >= 0):
        raise InputError(f"the shortest vessel, {shortest:g} radii, must be a number of at least 0")
    vessels = _Vessels(network)
    repairs = [*vessels.join_chains(shortest, alike)]
    before = float(network.length @ network.radius**2)
    while (row := vessels.shortest(shortest)) is not None:
        repairs += [vessels.merge(row, shortest), *vessels.join_chains(shortest, alike)]
    repairs += vessels.lengthen(shortest)
    if not repairs:
        return Tidied(network, (), 0.0, alike)
    after = vessels.network()
    added = float(after.length @ after.radius**2) / before - 1.0
    return Tidied(after, tuple(repairs), max(added, 0.0) if added > 1e-12 else 0.0, alike)


class _Vessels:
    """The vessels while they are repaired, by their rows in the network."""

    def __init__(self, network: Network) -> None:
        self.given, self.name = network, list(network.name)
        self.start, self.end = (dict(enumerate(nodes.tolist())) for nodes in (network.start, network.end))
        self.met = {node: (list(meeting.ending), list(meeting.beginning))
                    for node, meeting in meetings(network.start, network.end).items()}  # fmt: skip
        self.length, self.radius = network.length.copy(), network.radius.copy()
        self.low, self.high = network.radius.copy(), network.radius.copy()  # of what each vessel is made of
        self.measured = {name: None if (values := getattr(network, name)) is None else values.copy()
                         for name in MEASURED}  # fmt: skip

    def daughters(self, row: int) -> list[int]:
        """Return the vessels that a vessel alone leads to."""
        ending, beginning = self.met[self.end[row]]
        return beginning if len(ending) == 1 else []

    def join_chains(self, shortest: float, alike: float) -> list[Repair]:
        """Join every vessel that is the only daughter of another to it, if one is too short or both are alike."""
        repairs = []
        for rows in self.given.generations:
            for row in rows.tolist():
                while row in self.end and len(self.daughters(row)) == 1:
                    (next_row,) = self.daughters(row)
                    if self.end[next_row] == self.start[row]:  # both are a ring
                        break
                    pair = [row, next_row]
                    range_of = self.high[pair].max() / self.low[pair].min() - 1.0
                    if range_of > alike + _ROUNDING and np.all(self.length[pair] >= shortest * self.radius[pair]):
                        break
                    if not self.met[self.end[next_row]][1]:  # a bed, which may be called by its vessel's name
                        self.name[row], self.name[next_row] = self.name[next_row], self.name[row]
                    repairs.append(self._repair("joined", next_row, row, shortest))
                    self._join(row, next_row)
        return repairs

    def shortest(self, factor: float) -> int | None:
        """Return the shortest vessel, in its own radii, that is too short and can be merged into its daughters."""
        inner = [row for row in self.end if self.daughters(row) and self.met[self.start[row]][0]]
        inner = [row for row in inner if self._opens(row)]
        ratios = {row: self.length[row] / self.radius[row] for row in inner}
        return min((row for row in inner if ratios[row] < factor), key=ratios.__getitem__, default=None)

    def _opens(self, row: int) -> bool:
        """Return whether no daughter would end where it then began."""
        return all(self.end[daughter] != self.start[row] for daughter in self.daughters(row))

    def merge(self, row: int, shortest: float) -> Repair:
        """Let the daughters of a vessel start where it did, with its resistance and compliance."""
        rows = self.daughters(row)
        repair = self._repair("merged", row, rows[0], shortest)
        conductance = self.radius[rows] ** 4 / self.length[rows]
        for daughter, share in zip(rows, conductance / conductance.sum(), strict=True):
            self._in_line(daughter, row, share)
        node = self.start.pop(row)
        del self.met[self.end.pop(row)]
        beginning = self.met[node][1]
        place = beginning.index(row)
        beginning[place : place + 1] = rows
        self.start |= dict.fromkeys(rows, node)
        return repair

    def lengthen(self, shortest: float) -> list[Repair]:
        """Make the vessels long enough that cannot hand anything on: inlets, and those that none follows alone."""
        repairs = []
        for row in self.end:
            if self.length[row] < shortest * self.radius[row] * (1 - 1e-12):
                repairs.append(self._repair("lengthened", row, row, shortest))
                self.length[row] = shortest * self.radius[row]
        return repairs

    def network(self) -> Network:
        """Return what is left, in the order of the rows."""
        rows = sorted(self.end)
        return Network(
            tuple(self.name[row] for row in rows), None, self.length[rows], self.radius[rows],
            pressure=self.given.pressure, nodes=np.array([[self.start[row], self.end[row]] for row in rows]),
            **{name: None if values is None else values[rows] for name, values in self.measured.items()},
        )  # fmt: skip

    def _repair(self, code: Code, row: int, into: int, shortest: float) -> Repair:
        name, length, radius = self.name, float(self.length[row]), float(self.radius[row])
        return Repair(code, name[row], "" if into == row else name[into], length, radius, shortest * radius)

    def _join(self, row: int, next_row: int) -> None:
        """Join a vessel to the one before it."""
        self.low[row], self.high[row] = self.low[[row, next_row]].min(), self.high[[row, next_row]].max()
        first, second = self.length[row], self.length[next_row]
        for values in self.measured.values():
            if values is not None:
                values[row] = _mean(values[[row, next_row]], [first, second])
        self._in_line(row, next_row, 1.0)
        del self.met[self.end[row]], self.start[next_row]
        self.end[row] = self.end.pop(next_row)
        ending = self.met[self.end[row]][0]
        ending[ending.index(next_row)] = row

    def _in_line(self, row: int, added: int, share: float) -> None:
        """Give a vessel the resistance and the compliance of another that carries `share` of its own flow to it.

        All of it, where the share is 1. Else the pressure that is lost over the other is lost in each of its
        daughters: resistance over their share of the flow, and the compliance as they share it.
        """
        resistance = self.length[row] / self.radius[row] ** 4 + self.length[added] / self.radius[added] ** 4 / share
        compliance = self.length[row] * self.radius[row] ** 2 + self.length[added] * self.radius[added] ** 2 * share
        radius = (compliance / resistance) ** (1 / 6)
        self.length[row], self.radius[row] = compliance / radius**2, radius


def _mean(values: np.ndarray, lengths: Sequence[float]) -> float:
    """Return the mean along two vessels of what is known of both; else what is known of the longer one."""
    if np.isfinite(values).all():
        return float(np.average(values, weights=lengths))
    return float(values[int(np.argmax(lengths))])
