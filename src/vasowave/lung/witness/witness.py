"""No answer without its witness: everything that contradicts a measured tree, or that it does not settle, by vessel."""

from dataclasses import replace
from statistics import NormalDist

import numpy as np
from scipy.spatial import cKDTree

from vasowave.base.findings import FindingKind
from vasowave.lung.lumen.segmentation import Segmentation
from vasowave.lung.measure.measurement import Measurement
from vasowave.lung.tree import Tree, free_stretches
from vasowave.lung.witness.doubts import About, Doubt, Grade, doubt_kind
from vasowave.lung.witness.skeleton import Branches
from vasowave.lung.witness.topology import NOT_SEEN, SHORT, crossing_doubts, topology_doubts

LENGTH, RADIUS = 0.10, 0.05
"""A vessel is named if so many SD of its length (`LENGTH_DEVIATIONS`) or radius (`CHANCE`) exceed this share."""
LENGTH_DEVIATIONS = 3.0
CHANCE = 0.2
"""So many SD of a radius that in one tree of five some radius is beyond them: the more vessels, the more SD. Few of
these radii are off by a `RADIUS` that is not named: most vessels are surer than just sure enough."""
MAX_SHORT_SHARE = 0.5
"""A tree with a larger share of vessels that are too short to be measured is doubted as a whole."""
MAX_SHORT_INNER_SHARE = 0.25
"""False branches cut vessels into pieces, too: without so large a share among those that divide, stumps are stumps."""
MAX_LOST_SHARE, MAX_UNEVEN_SHARE = 0.5, 0.25
"""Ridges are those of vessels that are not round, and a second tree lacks them; of stumps it lacks a few."""
UNEVEN = 0.06
"""A lumen whose surface lies so far from a round tube (`surface_misfit`) is named; round ones show 0.01 to 0.04."""
MIN_CONTRAST_SHARE = 0.7
"""A vessel with less than this share of the root's contrast is partly filled."""

SHATTER = doubt_kind(
    "witness.shattered",
    Grade.WRONG,
    "{short} of {vessels} vessels are too short between junctions to be measured, as where vessels are flat or rough "
    "and their ridges are taken for branches: {remedy}",
    "do not use this tree, give the outlets",
)
_VESSELS = "vessel(s) {vessels}: "
CUT = doubt_kind(
    "witness.cut",
    Grade.LOOK,
    f"{_VESSELS}cut by the border of the image: longer than what is seen",
    "Scan or crop wider.",
)
UNSURE_LENGTH = doubt_kind(
    "witness.length",
    Grade.UNCERTAIN,
    f"{_VESSELS}the length is uncertain by more than {{share:.0%}} ({{deviations:g}} SD): {{remedy}}",
    "look at its junctions, of the root at the end of the cannula too",
)
UNSURE_RADIUS = doubt_kind(
    "witness.radius",
    Grade.UNCERTAIN,
    f"{_VESSELS}the radius is uncertain by more than {{share:.0%}} ({{deviations:.1f}} SD)",
    "Scan finer, or give the model this uncertainty.",
)
JUNCTION = doubt_kind(
    "witness.junction",
    Grade.UNCERTAIN,
    f"{_VESSELS}the surface does not settle where they meet ({{radii:.2f}} radii, 1 SD), so all their lengths are "
    "uncertain: {remedy}",
    "look at the junction",
)
NO_RADIUS = doubt_kind(
    "witness.short-for-radius",
    Grade.UNCERTAIN,
    f"{_VESSELS}too short between junctions, sisters and ends: the radius is not reliable",
    "Look at it, and merge what is not a vessel.",
)
NOT_ROUND = doubt_kind(
    "witness.not-round",
    Grade.LOOK,
    f"{_VESSELS}the surface is not that of a round tube: not round, touched by another vessel, or badly segmented",
    "Look at the lumen there.",
)
UNEVEN_WIDTH = doubt_kind(
    "witness.uneven-width",
    Grade.LOOK,
    f"{_VESSELS}areas or levels of the sections differ along the vessel, or their outline is neither round nor oval, "
    "as with a rim of calcium, a clot, a narrow place or a neighbor; the radius is known to {share:.0%} (1 SD) at "
    "best: {remedy}",
    "look along the vessel, and give a mask without what is no lumen",
)
PARTLY_FILLED = doubt_kind(
    "witness.partly-filled",
    Grade.LOOK,
    f"{_VESSELS}less than {{share:.0%}} of the root's contrast: partly filled, and what lies beyond may be missing",
    "Look at the image beyond it.",
)


def doubts_about(
    measured: Measurement,
    lumen: Segmentation,
    skeleton: Branches,
    misfit: np.ndarray,
    place_sd: np.ndarray,
    all_ends: bool,
) -> tuple[Doubt, ...]:
    """Return what speaks against `measured`.

    Parameters
    ----------
    measured : Measurement
    lumen : Segmentation
    skeleton : Branches
        The second tree of the lumen.
    misfit : float array, shape (vessel,)
        See `surface_misfit`.
    place_sd : float array, shape (vessel,)
        SD of the place where each vessel's daughters leave it, cm, see `settled`.
    all_ends : bool
        Whether the tree should have every end of the lumen, see `topology_doubts`.
    """
    min_lengths = measured.network.length - LENGTH_DEVIATIONS * measured.length_sd
    doubts = topology_doubts(measured.tree, skeleton, lumen.spacing, all_ends, min_lengths)
    short = _shattered(measured, doubts, misfit) if all_ends else []
    doubts += crossing_doubts(measured.tree) + short
    return (
        *doubts,
        *_cut(measured, lumen),
        *_junctions(measured, place_sd),
        *_unsettled(measured),
        *_uneven(measured, misfit),
    )


def _has_ridges(tree: Tree, doubts: list[Doubt], misfit: np.ndarray) -> bool:
    """Return whether ridges may be taken for branches, by the surface (`misfit`) and by a second tree's `doubts`."""
    lost = sum(len(doubt.vessels) for doubt in doubts if doubt.finding.code == NOT_SEEN.code)
    otherwise = any(doubt.finding.code not in (SHORT.code, NOT_SEEN.code) for doubt in doubts)
    is_uneven = np.mean(np.nan_to_num(misfit) > UNEVEN) > MAX_UNEVEN_SHARE
    return bool(otherwise or is_uneven or lost >= MAX_LOST_SHARE * len(tree.terminals))


def _shattered(measured: Measurement, doubts: list[Doubt], misfit: np.ndarray) -> list[Doubt]:
    """Return the doubt about a tree most of whose vessels are too short to be measured, as ridges are; stumps of a
    pruned tree are too, and a second tree, by its `doubts`, has most of them: what it lacks it names itself.
    """
    short, terminals = ~measured.reliable, list(measured.tree.terminals)
    if short.mean() <= MAX_SHORT_SHARE or np.delete(short, terminals).mean() <= MAX_SHORT_INNER_SHARE:
        return []
    if not _has_ridges(measured.tree, doubts, misfit):
        return []
    names = tuple(measured.network.name[row] for row in np.flatnonzero(short))
    return [Doubt("topology", SHATTER(short=len(names), vessels=len(short)), names)]


def _cut(measured: Measurement, lumen: Segmentation) -> list[Doubt]:
    """Return which vessels end where the image does: there alone the lumen reaches the faces of its crop."""
    reached = [[np.take(lumen.mask, side, axis=axis).any() for axis in range(3)] for side in (0, -1)]
    ends = np.zeros(len(measured.tree), dtype=bool)
    for row in measured.tree.terminals:
        line = measured.tree.lines[row]
        voxel = (line.points[-1] - lumen.origin) / lumen.spacing
        to_faces = np.array([voxel, np.array(lumen.mask.shape) - 1 - voxel])
        ends[row] = (np.where(reached, to_faces, np.inf) < line.typical_radius / lumen.spacing + 2).any()
    if not ends.any():
        return []
    return [_doubt(measured, "length", ends, CUT)]


def _unsettled(measured: Measurement) -> list[Doubt]:
    """Return which lengths and radii the image does not settle."""
    network = measured.network
    deviations = NormalDist().inv_cdf(1 - CHANCE / 2 / len(network))
    lengths = ~(LENGTH_DEVIATIONS * measured.length_sd <= LENGTH * network.length)
    radii = ~(deviations * measured.radius_sd <= RADIUS * network.radius)
    sure = {"share": RADIUS, "deviations": float(deviations)}
    cases: list[tuple[About, np.ndarray, FindingKind, dict[str, float]]] = [
        ("length", lengths, UNSURE_LENGTH, {"share": LENGTH, "deviations": LENGTH_DEVIATIONS}),
        ("radius", radii & measured.reliable, UNSURE_RADIUS, sure),
        ("radius", ~measured.reliable, NO_RADIUS, {}),
    ]
    return [_doubt(measured, about, rows, kind, **values) for about, rows, kind, values in cases if rows.any()]


def _junctions(measured: Measurement, place_sd: np.ndarray) -> list[Doubt]:
    """Return a doubt about all vessels of each junction whose place leaves the length of one of them unsettled."""
    doubts, length = [], measured.network.length
    for row in np.setdiff1d(np.arange(len(length)), measured.tree.terminals).tolist():
        rows = np.append(row, measured.tree.daughters(row))
        if LENGTH_DEVIATIONS * place_sd[row] <= LENGTH * length[rows].min():
            continue
        meet = np.isin(np.arange(len(length)), rows)
        radii = float(place_sd[row] / measured.tree.lines[row].typical_radius)
        doubt = _doubt(measured, "length", meet, JUNCTION, radii=radii)
        doubts.append(replace(doubt, places=measured.tree.lines[row].points[-1:]))
    return doubts


def _uneven(measured: Measurement, misfit: np.ndarray) -> list[Doubt]:
    """Return which vessels are no evenly filled round tubes."""
    doubts = []
    uneven = np.nan_to_num(misfit) > UNEVEN
    if uneven.any():
        doubts.append(_doubt(measured, "length", uneven, NOT_ROUND))
    if measured.grey is not None:
        contrast, differ = measured.grey.contrast, measured.grey.uneven
        if differ.any():
            doubts.append(_doubt(measured, "radius", differ > 0, UNEVEN_WIDTH, share=float(differ.max())))
        dim = np.nan_to_num(contrast / contrast[measured.network.root], nan=1.0) < MIN_CONTRAST_SHARE
        if dim.any():
            doubts.append(_doubt(measured, "radius", dim, PARTLY_FILLED, share=MIN_CONTRAST_SHARE))
    return doubts


def _doubt(measured: Measurement, about: About, rows: np.ndarray, kind: FindingKind, **values: float) -> Doubt:
    names = tuple(measured.network.name[row] for row in np.flatnonzero(rows))
    places = [line.points[len(line) // 2] for line, taken in zip(measured.tree.lines, rows, strict=True) if taken]
    return Doubt(about, kind(vessels=", ".join(names), **values), names, np.array(places))


def surface_misfit(tree: Tree, radius: np.ndarray, surface: np.ndarray, spacing: float) -> np.ndarray:
    """Return how far half of the surface around each vessel lies from its tube at least, as a share of the radius.

    A round lumen on its axis has a misfit of noise alone; one that is not round, is shared with a vessel that the
    tree lacks, or lies beside its axis has a larger one. Taken outside junctions and ends.

    Parameters
    ----------
    tree : Tree
    radius : float array, shape (vessel,)
        cm.
    surface : float array, shape (corner, 3)
        Points of the lumen's surface, cm.
    spacing : float
        Voxel size, cm.

    Returns
    -------
    float array, shape (vessel,)
        NaN for vessels without a free stretch.
    """
    distance, nearest = cKDTree(tree.line.points).query(surface)
    owner = tree.owner[nearest]
    run = np.concatenate([line.run for line in tree.lines])[nearest]
    # What a tube's own taper explains is no misfit: the gap is taken from the mean along it.
    misfit = np.full(len(tree), np.nan)
    for row, (begin, end) in enumerate(free_stretches(tree)):
        in_tube = (owner == row) & (run > begin) & (run < end) & (distance < 3 * radius[row] + 3 * spacing)
        if in_tube.sum() < 30:
            continue
        bins = (run[in_tube] / max(radius[row], spacing)).astype(int)
        mean = np.bincount(bins, distance[in_tube]) / np.maximum(np.bincount(bins), 1)
        misfit[row] = float(np.median(np.abs(distance[in_tube] - mean[bins]))) / radius[row]
    return misfit
