"""What was measured of every vessel: lengths, radii, taper."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vasowave.lung.measure.profiles import Beside, Look, profile, signal_beside
from vasowave.lung.measure.radii import Densitometry, densitometry
from vasowave.lung.read.volume import Volume
from vasowave.lung.tree import Line, Tree, clear_stretches, free_length
from vasowave.pulse.network.network import Network, closes

RELIABLE = 2.0
"""A radius is reliable if it was measured over a free length of at least this many radii."""


def network_of(tree: Tree) -> Network:
    """Return lengths and mean radii of `tree` (eq. 1); vessels are numbered from 1 in the order of the tree.

    The radius is the mean over the points outside the junctions' inscribed balls and sisters' tubes and farther than
    a radius from a free end; the median of all points where no such point exists.

    Raises
    ------
    InputError
        As `Network`.
    """
    mean_radius = mean_along(tree, [line.radius for line in tree.lines])
    radius = np.where(np.isnan(mean_radius), [line.typical_radius for line in tree.lines], mean_radius)
    names = tuple(str(row + 1) for row in range(len(tree)))
    return Network(names, tree.parent, np.array([line.length for line in tree.lines]), radius)


def mean_along(tree: Tree, values: Sequence[np.ndarray]) -> np.ndarray:
    """Return the mean of each vessel's `values`, one a point, where its lumen is its own; NaN where none is finite."""
    means = np.full(len(tree), np.nan)
    for row, (line, (begin, end)) in enumerate(zip(tree.lines, clear_stretches(tree), strict=True)):
        clear_values = values[row][(line.run > begin) & (line.run < end) & np.isfinite(values[row])]
        means[row] = clear_values.mean() if len(clear_values) else np.nan
    return means


@dataclass(frozen=True, eq=False)
class Measurement:
    """A network with the tree it comes from; row i of every field is the same vessel.

    Attributes
    ----------
    network : Network
        Radii are densitometric where a vessel has a free stretch, inscribed elsewhere.
    tree : Tree
    inscribed, densitometric : float array, shape (vessel,)
        Radii by the two estimators, cm; NaN where not measured.
    radius_sd : float array, shape (vessel,)
        SD of `network.radius`, cm: of three thresholds, each vessel by its own estimator, and of the grey levels, see
        `Densitometry`; NaN if it was not measured at all three.
    reliable : bool array, shape (vessel,)
        Whether the vessel's free length is at least two radii and its radius densitometric.
    length_sd : float array, shape (vessel,)
        SD of `network.length` over the same axes fitted at the three thresholds, cm; NaN likewise. Without an image,
        that of the convention, see `exchange.convention`.
    grey : Densitometry, optional
        What else the grey levels say; None without an image.
    """

    network: Network
    tree: Tree
    inscribed: np.ndarray
    densitometric: np.ndarray
    radius_sd: np.ndarray
    reliable: np.ndarray
    length_sd: np.ndarray
    grey: Densitometry | None = None


def measured_in(
    tree: Tree, volume: Volume, profiler: Look = profile, noise_beside: Beside = signal_beside
) -> Measurement:
    """Return lengths and radii of `tree` in `volume`; the spread of the radii is not known yet (NaN)."""
    first = network_of(tree)
    grey = densitometry(tree, volume, first.radius, profiler, noise_beside)
    dense = grey.radius
    radius = np.where(np.isfinite(dense), dense, first.radius)
    reliable = np.isfinite(dense) & (free_length(tree) >= RELIABLE * radius)
    network = Network(first.name, first.parent, first.length, radius)
    unknown = np.full(len(tree), np.nan)
    return Measurement(network, tree, first.radius, dense, unknown, reliable, unknown, grey)


def filled_at(measured: Measurement, pressure: float) -> Measurement:
    """Return `measured` of vessels that were filled at `pressure` (mmHg, transmural) for the image."""
    return replace(measured, network=replace(measured.network, pressure=pressure))


def with_common_error(measured: Measurement, sd: float) -> Measurement:
    """Return `measured` whose network knows the SD of a factor of all radii, as a share; 0 of none."""
    return measured if sd <= 0 else replace(
        measured, network=replace(measured.network, radius_scale_sd=np.full(len(measured.network), sd))
    )  # fmt: skip


def with_wider_radii(measured: Measurement, share: np.ndarray) -> Measurement:
    """Return `measured` with further SDs of its radii, as shares, shape (vessel,)."""
    sd = np.hypot(measured.radius_sd, share * measured.network.radius)
    network = measured.network
    if network.radius_sd is not None:
        network = replace(network, radius_sd=np.hypot(network.radius_sd, share * network.radius))
    return measured if not share.any() else replace(measured, radius_sd=sd, network=network)


def with_errors(measured: Measurement) -> Measurement:
    """Return `measured` whose network knows the errors of its radii, and its tapers where grey levels show them."""
    network, grey = measured.network, measured.grey
    network = replace(network, radius_sd=np.where(measured.radius_sd > 0, measured.radius_sd, np.nan))
    if grey is not None:
        has_taper = (grey.taper_sd > 0) & ~closes(grey.taper, network)
        slope, sd = (np.where(has_taper, values, np.nan) for values in (grey.taper, grey.taper_sd))
        network = replace(network, taper=slope, taper_sd=sd)
    return replace(measured, network=network)


def measured_alone(tree: Tree, length_sd: np.ndarray | None = None) -> Measurement:
    """Return lengths, with their SD where it is known, and inscribed radii of a `tree` without an image, all in cm.

    The spread of the radii is unknown.
    """
    network = network_of(tree)
    unknown = np.full(len(network), np.nan)
    reliable = free_length(tree) >= RELIABLE * network.radius
    return Measurement(
        network, tree, network.radius, unknown, unknown, reliable, unknown if length_sd is None else length_sd
    )


@dataclass(frozen=True, eq=False)
class Taper:
    """Straight lines through the inscribed radius of each vessel; NaN for vessels without a free stretch.

    Attributes
    ----------
    slope : float array, shape (vessel,)
        -dr/ds, cm per cm; positive where the vessel narrows away from the heart.
    slope_se : float array, shape (vessel,)
        Standard error of the slope with as many independent points as radii fit into the stretch.
    proximal, distal : float array, shape (vessel,)
        Radius of that line at the vessel's beginning and end, cm.
    """

    slope: np.ndarray
    slope_se: np.ndarray
    proximal: np.ndarray
    distal: np.ndarray


def taper(tree: Tree) -> Taper:
    """Fit r(s) = r0 - slope · s over each vessel's clear stretch: outside junctions, sisters and its free end.

    Radii of neighboring points are of one sphere, so a stretch holds only as many independent values as radii fit
    into it; vessels with a free stretch below three radii have no taper (NaN).
    """
    rows = [_fit(line, *stretch) for line, stretch in zip(tree.lines, clear_stretches(tree), strict=True)]
    return Taper(*np.array(rows).T)


def _fit(line: Line, begin: float, end: float) -> tuple[float, float, float, float]:
    run, radius = line.run, line.radius
    free = (run > begin) & (run < end)
    independent = np.ptp(run[free]) / line.typical_radius if free.any() else 0.0
    if independent < 3 or free.sum() < 5:
        return (np.nan,) * 4
    s, r = run[free], radius[free]
    slope, intercept = np.polyfit(s, r, 1)
    residual = float(np.std(r - intercept - slope * s))
    error = residual / (float(np.std(s)) * np.sqrt(independent))
    return -float(slope), error, float(intercept), float(intercept + slope * run[-1])
