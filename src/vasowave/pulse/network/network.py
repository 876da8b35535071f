"""The vessel network: topology and measured size of every vessel, as arrays, and the pressure of its image."""

import os
from collections.abc import Callable
from dataclasses import InitVar, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.base.accessors import Accessor
from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.notebook import card
from vasowave.pulse.network.graph import Meeting, in_series, meetings, parents, shares_by_conductance

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

POSSIBLE = {"radius": (1e-5, 15.0), "length": (1e-5, 3000.0)}
"""Sizes outside are no animal's, cm: from a tenth of a micrometer, far below a capillary's radius (3 µm), to what
exceeds a blue whale, the largest animal, whose aorta measures 23 cm across and which is 30 m long."""

HIGHEST = 100.0
"""Highest pressure at which lungs are filled for an image, mmHg."""

_COUNTED = 2.0**53  # above it numbers cannot tell one row from the next
_NO_TAPER = 0.05  # probability of the measured tapers in a straight tree from which it is straight
MEASURED = ("radius_sd", "taper", "taper_sd", "radius_scale_sd")
"""What may be known of each vessel beside its sizes."""

_TOPOLOGY = ("name", "parent", "nodes", "root", "inlets", "start", "end", "junctions", "daughters", "terminals",
             "generations", "_rows")  # fmt: skip


@dataclass(frozen=True, eq=False)
class Network:
    """Vessels that hang together, a tree or a graph with loops and several inlets; row i of every array is a vessel.

    Attributes
    ----------
    name : tuple of str
        Unique name of each vessel.
    parent : int array, shape (vessel,)
        Row of the vessel's parent, -1 for the root. Any number of daughters; any order of rows. Where `nodes` are
        given, it is that of the first vessel on the shortest way from an inlet; give None.
    length : float array, shape (vessel,)
        Length L, cm.
    radius : float array, shape (vessel,)
        Radius at the transmural pressure `pressure`, cm.
    pressure : float
        Transmural pressure at which the radii were measured, mmHg: that at which the lungs were filled for the image.
        0, where it is not known, takes them for the undeformed radii r0.
    radius_sd : float array, shape (vessel,), optional
        Standard deviation of each radius as it was measured, cm; NaN where it is not known.
    taper, taper_sd : float array, shape (vessel,), optional
        Fall of the radius along the vessel, -dr/ds, cm/cm, around the middle, where the radius is `radius`; and its
        standard deviation. NaN where it was not measured. Models have straight vessels unless they are
        given a shape (`Shape.of`); the posterior knows of it.
    radius_scale_sd : float array, shape (vessel,), optional
        Standard deviation of a factor that all radii have in common, as a share: what an image's faults do to all of
        them alike. NaN or None where the image shows none.
    nodes : int array, shape (vessel, 2), optional
        Numbers of the nodes in which each vessel begins and ends, in place of parents: vessels that share a node meet
        there, whichever of their ends it is. Nodes in which nothing ends are inlets, those in which nothing begins lead
        to beds. None where the vessels are a tree.

    Raises
    ------
    InputError
        No or two roots, a cycle, an unknown parent, a duplicate name, a size that is not a positive number, or that no
        animal has (`POSSIBLE`); the row is named. A pressure below 0 or above 100 mmHg. A standard deviation that is
        not a positive number, a taper that closes the vessel. Nodes that no blood reaches, or at which several vessels
        take it in or hand it to a bed.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Network(("main", "left", "right"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037])
    Network(3 vessels, 2 terminals, root 'main' r0 0.047 cm, total length 1.23 cm)

    A vessel in two parallel ones:

    >>> ring = vw.Network(("in", "a", "b", "out"), None, [1.0, 0.5, 0.5, 1.0], [0.05, 0.035, 0.035, 0.05],
    ...                   nodes=[[0, 1], [1, 2], [1, 2], [2, 3]])
    >>> ring.flow_fraction.round(12).tolist()
    [1.0, 0.5, 0.5, 1.0]
    """

    name: tuple[str, ...]
    parent: Any
    length: np.ndarray
    radius: np.ndarray
    where: InitVar[Callable[[int], str] | None] = None
    pressure: float = 0.0
    radius_sd: np.ndarray | None = None
    taper: np.ndarray | None = None
    taper_sd: np.ndarray | None = None
    nodes: np.ndarray | None = None
    radius_scale_sd: np.ndarray | None = None

    def __post_init__(self, where: Callable[[int], str] | None) -> None:
        """Check the topology once and freeze the arrays; `where` says for a row how errors call it."""
        where = where or _row
        object.__setattr__(self, "name", tuple(str(name) for name in self.name))
        if self.nodes is not None:
            _take_nodes(self, where)
        if self.parent is None:
            raise InputError("network: give the row of each vessel's parent, or nodes")
        parent = _whole(self.parent, "parents", "one per vessel: the row of its parent, -1 at the root")
        object.__setattr__(self, "parent", parent)
        object.__setattr__(self, "length", _frozen(self.length, np.float64))
        object.__setattr__(self, "radius", _frozen(self.radius, np.float64))
        object.__setattr__(self, "pressure", image_pressure(self.pressure))
        for field in MEASURED:
            values = getattr(self, field)
            object.__setattr__(self, field, None if values is None else _frozen(values, np.float64))
        _check_vessels(self, where)
        if self.nodes is None:
            _check_tree(self, where)
        _check_measured(self, where)

    def __len__(self) -> int:
        return len(self.name)

    def __repr__(self) -> str:
        return (
            f"Network({len(self)} vessels, {len(self.terminals)} terminals, root '{self.name[self.root]}' "
            f"r0 {self.radius[self.root]:.4g} cm, total length {self.length.sum():.4g} cm)"
        )

    def _repr_html_(self) -> str:
        facts = {
            "vessels": f"{len(self)}, {len(self.terminals)} of them terminal",
            "root": f"'{self.name[self.root]}', radius {self.radius[self.root]:.4g} cm",
            "total length": f"{self.length.sum():.4g} cm",
            "radii": f"{self.radius.min():.3g} to {self.radius.max():.3g} cm",
            "measured at": f"{self.pressure:g} mmHg" if self.pressure else "a pressure not known, taken for 0",
        }
        return card("Network", facts)

    @cached_property
    def root(self) -> int:
        """Row of the root vessel; the first of the inlets where there are several."""
        return int(self.inlets[0])

    @cached_property
    def inlets(self) -> np.ndarray:
        """Rows of the vessels into which blood flows from outside, in the order of the rows; the root, in a tree."""
        return np.flatnonzero(self.parent < 0)

    @property
    def inlet_names(self) -> list[str]:
        """Names of the inlets."""
        return [self.name[row] for row in self.inlets]

    @cached_property
    def start(self) -> np.ndarray:
        """Number of the node in which each vessel begins, shape (vessel,)."""
        return self.parent + 1 if self.nodes is None else self.nodes[:, 0]

    @cached_property
    def end(self) -> np.ndarray:
        """Number of the node in which each vessel ends, shape (vessel,)."""
        return np.arange(1, len(self) + 1) if self.nodes is None else self.nodes[:, 1]

    @cached_property
    def junctions(self) -> tuple[Meeting, ...]:
        """Rows that end and that begin where vessels meet, by the first that ends there."""
        met = sorted(
            (meeting for meeting in meetings(self.start, self.end).values() if meeting.ending),
            key=lambda meeting: meeting.ending,
        )
        return tuple(meeting for meeting in met if meeting.beginning)

    @cached_property
    def area(self) -> np.ndarray:
        """Cross-sectional area π r² at the pressure of the image, cm², shape (vessel,); for A0 see `Model.area0`."""
        return np.pi * self.radius**2

    @cached_property
    def daughters(self) -> tuple[tuple[int, ...], ...]:
        """Rows of the daughters of each vessel, whose `parent` it is, in the order of the rows."""
        daughters: list[list[int]] = [[] for _ in self.name]
        for row, parent in enumerate(self.parent):
            if parent >= 0:
                daughters[parent].append(row)
        return tuple(map(tuple, daughters))

    @cached_property
    def terminals(self) -> np.ndarray:
        """Rows of the vessels behind which none begins, in the order of the rows."""
        return np.flatnonzero(~np.isin(self.end, self.start))

    @cached_property
    def generations(self) -> tuple[np.ndarray, ...]:
        """Rows by the number of vessels from the inlets: those alone, their daughters, and so on."""
        by_parent = np.argsort(self.parent, kind="stable")
        first = np.searchsorted(self.parent[by_parent], np.arange(len(self)))
        last = np.searchsorted(self.parent[by_parent], np.arange(len(self)), side="right")
        levels, current = [], self.inlets
        while len(current):
            levels.append(current)
            slices = [by_parent[first[row] : last[row]] for row in current]
            current = np.concatenate(slices)
        return tuple(levels)

    @cached_property
    def flow_fraction(self) -> np.ndarray:
        """Share of the mean inflow in each vessel, by Poiseuille's law (eq. 11), shape (vessel,).

        At every junction the flow divides as the conductances π r0⁴/(8 μ L) of the daughters; the viscosity cancels.
        A vessel that is cut in pieces, one after the other, is one resistance there, wherever it is cut.
        Vessels that form loops divide it together with those that lead out of them, at whose ends one pressure stands;
        in a vessel in which it runs from the end to the start it is negative. Inlets share as their conductances.
        """
        conductance = self.radius**4 / self.length
        if self.nodes is not None:
            return shares_by_conductance(self.start, self.end, conductance)
        below = self.parent >= 0
        daughters = np.bincount(self.parent[below], minlength=len(self))
        conductance = in_series(conductance, np.where(below & (daughters[self.parent] == 1), self.parent, -1))
        siblings = np.bincount(self.parent[below], conductance[below], minlength=len(self))
        fraction = np.ones(len(self))
        for rows in self.generations[1:]:
            above = self.parent[rows]
            fraction[rows] = fraction[above] * conductance[rows] / siblings[above]
        return fraction

    def resized(
        self, *, radius: np.ndarray | None = None, length: np.ndarray | None = None, pressure: float | None = None
    ) -> "Network":
        """Return the same vessels with other sizes, and nothing measured beside them (`MEASURED`).

        The topology is not checked again, which a posterior would do for thousands of networks.

        Parameters
        ----------
        radius, length : array, shape (vessel,), optional
            cm.
        pressure : float, optional
            At which the radii are those, mmHg.

        Raises
        ------
        InputError
            As for a new network.
        """
        network = object.__new__(Network)
        sizes = {"radius": self.radius if radius is None else _frozen(radius, np.float64),
                 "length": self.length if length is None else _frozen(length, np.float64),
                 "pressure": self.pressure if pressure is None else image_pressure(pressure)}  # fmt: skip
        topology = {name: self.__dict__[name] for name in _TOPOLOGY if name in self.__dict__}
        network.__dict__.update(topology | sizes | dict.fromkeys(MEASURED))
        _check_sizes(network, _row)
        return network

    @Accessor
    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the tree into matplotlib axes, or a new figure; returns the axes."""
        raise NotImplementedError

    def to_dataframe(self) -> "pd.DataFrame":
        """Return the vessels as a table in the form of a network file, indexed by name, lengths in cm."""
        import pandas as pd

        sizes = {f"{name.replace('_', ' ')} [cm]": getattr(self, name) for name in ("length", "radius")}
        return pd.DataFrame(self.topology() | sizes, pd.Index(self.name, name="vessel"))

    def topology(self) -> dict[str, list[str]]:
        """Return what joins the vessels as columns of a table: the name of each one's parent, or its two nodes."""
        if self.nodes is not None:
            return {"from": list(map(str, self.start)), "to": list(map(str, self.end))}
        return {"parent": [self.name[row] if row >= 0 else "" for row in self.parent]}

    def row(self, name: str | int) -> int:
        """Return the row of the vessel called `name`; `InputError` if there is none."""
        try:
            return self._rows[str(name)]
        except KeyError:
            hint = did_you_mean(str(name), self.name)
            raise InputError(f"the network has no vessel '{name}'{hint}") from None

    @cached_property
    def _rows(self) -> dict[str, int]:
        return {name: row for row, name in enumerate(self.name)}


def a_network(network: object) -> Network:
    """Return a network; raise `InputError` for anything else, with what to do."""
    if isinstance(network, Network):
        return network
    if isinstance(network, str | os.PathLike):
        raise InputError(f"'{network}' is the name of a file; read it first: vasowave.read_network('{network}')")
    raise InputError(f"{type(network).__name__} was given where a Network is needed")


def image_pressure(value: float) -> float:
    """Return the pressure of an image, mmHg; raise `InputError` unless it lies between 0 and 100."""
    pressure = float(value)
    if not 0 <= pressure <= HIGHEST:
        raise InputError(
            f"pressure of the image {pressure:g} mmHg: give the transmural pressure at which the vessels were filled, "
            f"between 0 (not known) and {HIGHEST:g} mmHg; is its unit right?"
        )
    return pressure


def _frozen(values: object, dtype: type) -> np.ndarray:
    array: np.ndarray = np.array(values, dtype=dtype)
    array.setflags(write=False)
    return array


def _whole(values: object, name: str, meaning: str) -> np.ndarray:
    """Return numbers of rows or nodes; raise `InputError`, saying what they mean, for what is none."""
    try:
        numbers = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"network: {name} are numbers, {meaning}") from None
    if not np.all((np.abs(numbers) < _COUNTED) & (numbers == np.rint(numbers))):
        raise InputError(f"network: {name} are whole numbers")
    return _frozen(numbers, np.int64)


def _take_nodes(network: Network, where: Callable[[int], str]) -> None:
    """Check the nodes of a network that was given some and set its parents; a tree keeps its parents alone."""
    nodes = _whole(network.nodes, "nodes", "two per vessel: where it begins and where it ends")
    if nodes.shape != (len(network.name), 2) or not len(nodes):
        raise InputError(f"network: {len(network.name)} names but nodes have shape {nodes.shape}; give two per vessel")
    parent = parents(network.name, nodes, where)
    if network.parent is not None and not np.array_equal(network.parent, parent):
        raise InputError("network: parents are given that are not those of its nodes; give None for them")
    alone = np.bincount(np.unique(nodes[:, 1], return_inverse=True)[1]).max() == 1
    object.__setattr__(network, "parent", parent)
    object.__setattr__(network, "nodes", None if alone and np.sum(parent < 0) == 1 else nodes)


def _row(row: int) -> str:
    return f"row {row + 1}"


def _check_vessels(network: Network, where: Callable[[int], str]) -> None:
    """Raise `InputError`, naming the row through `where`, unless every row is a real vessel."""
    count = len(network.name)
    if count == 0:
        raise InputError("the network has no vessels")
    _check_shape(network, "parent")
    first_rows: dict[str, int] = {}
    for row, name in enumerate(network.name):
        if not name.strip():
            raise InputError(f"{where(row)}: the vessel has no name")
        if name.lstrip()[0] in "=@" or not name.isprintable():
            raise InputError(f"{where(row)}: '{name}' is not a name of a vessel: a spreadsheet would run it; rename it")
        if name in first_rows:
            raise InputError(
                f"{where(row)}: vessel '{name}' is already defined in {where(first_rows[name])}; rename one"
            )
        first_rows[name] = row
    _check_sizes(network, where)
    outside = np.flatnonzero((network.parent < -1) | (network.parent >= count))
    if len(outside):
        row = int(outside[0])
        raise InputError(
            f"{where(row)} (vessel '{network.name[row]}'): parent row {network.parent[row]} does not exist"
        )


def _check_shape(network: Network, field: str) -> None:
    shape, count = getattr(network, field).shape, len(network.name)
    if shape != (count,):
        raise InputError(f"network: {count} names but {field} has shape {shape}; give one value per vessel")


def _check_sizes(network: Network, where: Callable[[int], str]) -> None:
    """Raise `InputError`, naming the row through `where`, unless every length and radius may be an animal's."""
    for field, (low, high) in POSSIBLE.items():
        _check_shape(network, field)
        values = getattr(network, field)
        bad = np.flatnonzero(~((values >= low) & (values <= high)))
        if not len(bad):
            continue
        row = int(bad[0])
        value, statement = values[row], f"{where(row)} (vessel '{network.name[row]}'): {field} {values[row]:g} cm is"
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"{statement} not a positive number")
        raise InputError(f"{statement} no animal's (possible are {low:g} to {high:g} cm); is its unit right?")


def _check_tree(network: Network, where: Callable[[int], str]) -> None:
    """Raise `InputError`, naming the row through `where`, unless the parents are those of one tree."""
    count = len(network)
    roots = np.flatnonzero(network.parent < 0)
    if len(roots) == 0:
        raise InputError(f"{where(0)}: no root; leave the parent of the vessel that carries the inflow empty")
    if len(roots) > 1:
        names = ", ".join(f"'{network.name[row]}' ({where(row)})" for row in roots[:3])
        raise InputError(f"{len(roots)} vessels have no parent: {names}; one network has one root, or says by "
                         "its nodes (columns from, to) where the vessels meet")  # fmt: skip
    reached = np.concatenate(network.generations)
    if len(reached) < count:
        row = int(np.setdiff1d(np.arange(count), reached)[0])
        raise InputError(
            f"{where(row)} (vessel '{network.name[row]}'): not connected to the root, its parents form a cycle; "
            "correct the parent column"
        )


def _check_measured(network: Network, where: Callable[[int], str]) -> None:
    """Raise `InputError`, naming the row through `where`, unless errors and tapers are possible ones."""
    for field in MEASURED:
        values = getattr(network, field)
        if values is None:
            continue
        if values.shape != (len(network),):
            raise InputError(f"network: {field} has shape {values.shape}; give one value per vessel, NaN if unknown")
        bad = np.isinf(values) | (values <= 0 if field != "taper" else closes(values, network))
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            raise InputError(
                f"{where(row)} (vessel '{network.name[row]}'): {field} {values[row]:g} is not possible; a standard "
                "deviation is positive, and a taper leaves both ends open. Leave the cell empty where it is not known"
            )


def closes(taper: np.ndarray, network: Network) -> np.ndarray:
    """Return which vessels a taper (cm/cm, shape (vessel,)) would close at one end."""
    return np.asarray(np.abs(taper) * network.length >= 2 * network.radius)


def measured_falls(network: Network, prior: float) -> tuple[np.ndarray, np.ndarray]:
    """Return what each vessel's radius falls from inlet to outlet, as a share of it, and its SD, shape (vessel,).

    Both are those of a normal prior around none of SD `prior` after the measurement: a taper that was measured with an
    error is drawn towards none. 0 where no taper is known.
    """
    if network.taper is None or prior == 0:
        return np.zeros(len(network)), np.zeros(len(network))
    share = network.length / network.radius
    measured = network.taper * share
    sd = np.zeros(len(network)) if network.taper_sd is None else np.nan_to_num(network.taper_sd) * share
    weight = prior**2 / (prior**2 + sd**2)
    finite = np.isfinite(measured)
    return np.where(finite, weight * measured, 0.0), np.where(finite, np.sqrt(weight) * sd, 0.0)


def tapers(network: Network) -> bool:
    """Return whether vessels narrow by more than the errors of their tapers make a straight tree seem to.

    All measured tapers together, by the sum of their squares in SD (χ², 5 %); without errors they count as they are.
    """
    if network.taper is None:
        return False
    sd = np.zeros(len(network)) if network.taper_sd is None else np.nan_to_num(network.taper_sd)
    measured = np.isfinite(network.taper) & (network.taper != 0)
    if not measured.any() or np.any(sd[measured] == 0):
        return bool(measured.any())
    from scipy.special import chdtrc

    scores = network.taper[measured] / sd[measured]
    return bool(chdtrc(len(scores), float(scores @ scores)) < _NO_TAPER)


def from_root(network: Network, per_vessel: np.ndarray) -> np.ndarray:
    """Sum of a quantity over all vessels from an inlet to the end of each vessel, on the shortest way, (vessel,)."""
    total = np.array(per_vessel, dtype=float)
    for rows in network.generations[1:]:
        total[rows] += total[network.parent[rows]]
    return total
