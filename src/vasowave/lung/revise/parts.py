"""Parts of a tree: its first generations, its largest vessels, all above a radius; junctions stay whole."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, warn
from vasowave.lung.measure.measurement import Measurement
from vasowave.lung.options import check_wishes
from vasowave.lung.tree import Tree
from vasowave.pulse.network.network import Network

FEWER_GENERATIONS = look_kind(
    "image.fewer-generations",
    "the network has {generations} generations, not {count}: all of it is kept",
    "Ask for fewer.",
)
FEWER_VESSELS = look_kind(
    "image.fewer-vessels",
    "{vessels} vessels are kept, not {count}: one more junction would make more, or there are no more",
    "Ask for fewer.",
)

_SIZES = "inscribed", "densitometric", "radius_sd", "length_sd"  # of a measurement, by vessel, cm


def first_generations(network: Network, count: int) -> np.ndarray:
    """Return the rows of the vessels at most `count` - 1 junctions away from the root, ascending.

    Raises
    ------
    InputError
        `count` below 1.

    Warns
    -----
    VasowaveWarning
        The network has fewer generations.
    """
    _require(count >= 1, f"{count} generations; at least the root is needed: give 1 or more")
    if count > len(network.generations):
        warn(FEWER_GENERATIONS(generations=len(network.generations), count=count), stacklevel=3)
    return np.sort(np.concatenate(network.generations[:count]))


def largest_vessels(network: Network, count: int) -> np.ndarray:
    """Return the rows of the largest sub-tree of at most `count` vessels, ascending.

    It grows from the root; each time the junction opens whose widest daughter is widest, with all its daughters,
    since a junction that lost a daughter would divide the flow wrongly.

    Raises
    ------
    InputError
        `count` below 1.

    Warns
    -----
    VasowaveWarning
        No sub-tree with whole junctions has exactly `count` vessels.
    """
    _require(count >= 1, f"{count} vessels; at least the root is needed: give 1 or more")
    selection = {network.root}
    while True:
        ends = [row for row in selection if network.daughters[row] and network.daughters[row][0] not in selection]
        ends = [row for row in ends if len(selection) + len(network.daughters[row]) <= count]
        if not ends:
            break
        widest = max(ends, key=lambda row: max(network.radius[daughter] for daughter in network.daughters[row]))
        selection |= set(network.daughters[widest])
    if len(selection) < count:
        warn(FEWER_VESSELS(vessels=len(selection), count=count), stacklevel=3)
    return np.array(sorted(selection))


def wider_than(network: Network, radius: float) -> np.ndarray:
    """Return the rows of all vessels with at least `radius` (cm) whose parents are kept too, ascending.

    The narrower sisters of a kept vessel stay, as terminals, since a junction that lost a daughter would divide the
    flow wrongly.

    Raises
    ------
    InputError
        The root is narrower.
    """
    widest = float(network.radius[network.root])
    _require(radius <= widest, f"the root's radius is {widest:.4g} cm, below {radius:g}: nothing would be kept")
    wide = {row for row in range(len(network)) if network.radius[row] >= radius}
    selection = {network.root}
    for rows in network.generations:
        for row in rows.tolist():
            if row in selection and row in wide and wide.intersection(network.daughters[row]):
                selection |= set(network.daughters[row])
    return np.array(sorted(selection))


def wanted_part(
    measured: Measurement, generations: int | None, vessels: int | None, min_radius: float | None
) -> Measurement:
    """Return the part of `measured` that at most one of three wishes keeps, or all of it.

    Raises
    ------
    InputError
        More than one wish, or one that keeps nothing.
    """
    check_wishes(generations, vessels, min_radius)
    network = measured.network
    if generations is not None:
        return part_of(measured, first_generations(network, generations))
    if vessels is not None:
        return part_of(measured, largest_vessels(network, vessels))
    if min_radius is not None:
        return part_of(measured, wider_than(network, min_radius))
    return measured


def part_of(measured: Measurement, rows: Sequence[int] | np.ndarray) -> Measurement:
    """Return the vessels `rows` of `measured`, with their names; the parent of each but the root's is among them."""
    rows = np.asarray(rows)
    new = np.full(len(measured.network), -1)
    new[rows] = np.arange(len(rows))
    network = measured.network
    parent = np.where(network.parent[rows] >= 0, new[network.parent[rows]], -1)
    names = tuple(network.name[row] for row in rows)
    common = None if network.radius_scale_sd is None else network.radius_scale_sd[rows]
    sizes = network.length[rows], network.radius[rows]
    return replace(
        measured,
        network=Network(names, parent, *sizes, pressure=network.pressure, radius_scale_sd=common),
        tree=Tree(tuple(measured.tree.lines[row] for row in rows), parent),
        grey=None if measured.grey is None else measured.grey.of(rows),
        **{name: getattr(measured, name)[rows] for name in (*_SIZES, "reliable")},
    )


def scaled(measured: Measurement, factor: float) -> Measurement:
    """Return `measured` with every length, radius and coordinate times `factor`."""
    network = measured.network
    return replace(
        measured,
        network=replace(network, length=network.length * factor, radius=network.radius * factor),
        tree=measured.tree.times(factor),
        grey=None if measured.grey is None else measured.grey.times(factor),
        **{name: getattr(measured, name) * factor for name in _SIZES},
    )


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise InputError(message)
