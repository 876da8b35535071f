"""The whole way from a volume to a checked network, and the folder that holds the result."""

import csv
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from vasowave.errors import InputError, VasowaveWarning
from vasowave.files import write_folder
from vasowave.imaging.cannula import PE90_RADIUS, cannula_radius, without_cannula
from vasowave.imaging.loops import loop_count, loop_places
from vasowave.imaging.places import written
from vasowave.imaging.radii import densitometric_radii, lumen_grey
from vasowave.imaging.segmentation import Segmentation, segment
from vasowave.imaging.tree import Tree, free_length, network_of
from vasowave.imaging.uncertainty import radius_spread
from vasowave.imaging.vessels import tree_of
from vasowave.imaging.volume import Volume, isotropic, read_volume
from vasowave.network import Network

Segmenter = Callable[[Volume, float, np.ndarray], Segmentation]

RELIABLE = 2.0
"""A radius is reliable if it was measured over a free length of at least this many radii."""


@dataclass(frozen=True)
class Options:
    """What the user decides.

    Attributes
    ----------
    root : sequence of 3 floats
        A point (z, y, x, cm) at the end where the flow enters: the outer end of the cannula, if there is one.
    outlets : sequence of points, optional
        Guided mode: the network reaches these and no other.
    threshold : float
        Grey level of the wall; radii are repeated at ±20 % of it for their uncertainty.
    cannula_radius : float, optional
        Known inner radius, cm; None where there is no cannula.
    spacing : float, optional
        Voxel size, cm, in place of the file's.
    loops : "open" or "refuse"
        What becomes of a lumen that closes loops: a tree that opens them, with a warning, or an error; both say where.
    """

    root: Sequence[float]
    outlets: Sequence[Sequence[float]] | None = None
    threshold: float = 45.0
    cannula_radius: float | None = PE90_RADIUS
    spacing: float | None = None
    loops: Literal["open", "refuse"] = "open"

    def __post_init__(self) -> None:
        if self.loops not in ("open", "refuse"):
            raise InputError(f"loops '{self.loops}'; the tree can 'open' or 'refuse' them")


@dataclass(frozen=True, eq=False)
class Extraction:
    """A network with where it came from.

    Attributes
    ----------
    network : Network
        Radii are densitometric where a vessel has a free stretch, inscribed elsewhere.
    tree : Tree
    inscribed, densitometric : float array, shape (vessel,)
        Radii by the two estimators, cm; NaN where not measured.
    radius_sd : float array, shape (vessel,)
        SD of `network.radius` over three thresholds, each vessel by its own estimator, cm; NaN if it was not
        measured at all three.
    reliable : bool array, shape (vessel,)
        Whether the vessel's free length is at least two radii and its radius densitometric.
    scale : float
        Known over measured radius of the cannula; 1 without a cannula. It is reported, not applied.
    """

    network: Network
    tree: Tree
    inscribed: np.ndarray
    densitometric: np.ndarray
    radius_sd: np.ndarray
    reliable: np.ndarray
    scale: float


def extract(
    volume: Volume | str | Path,
    options: Options,
    progress: Callable[[str], None] | None = None,
    segmenter: Segmenter = segment,
    revise: Callable[[Tree], Tree] = lambda tree: tree,
) -> Extraction:
    """Return the vessel network in `volume`.

    Parameters
    ----------
    volume : Volume or path
    options : Options
    progress : callable, optional
        Called with the name of each stage as it begins.
    segmenter : callable
        Finds the lumen in a volume at a threshold from a point in it, see `segment`.
    revise : callable
        Changes the tree before it is measured, see `edits`.

    Raises
    ------
    InputError
        As `read_volume`, `segment`, `tree_of`; a lumen that closes loops, if `options.loops` is "refuse".

    Warns
    -----
    VasowaveWarning
        The cannula contradicts the file's voxel size by more than 1 %; at another threshold vessels are not in the
        lumen; the lumen closes loops.
    """
    say = progress or (lambda stage: None)
    say("volume")
    volume = isotropic(volume if isinstance(volume, Volume) else read_volume(volume, options.spacing))
    say("centerlines")
    tree, cannula = _tree(volume, options, segmenter, revise)
    first = network_of(tree)
    say("radii")
    dense = densitometric_radii(tree, volume, first.radius)
    radius = np.where(np.isfinite(dense), dense, first.radius)
    scale = _scale(cannula, volume, tree, options.cannula_radius)
    say("uncertainty")
    measured = np.isfinite(dense)
    spread = radius_spread(tree, volume, np.asarray(options.root), radius, measured, options.threshold, segmenter)
    network = Network(first.name, first.parent, first.length, radius)
    reliable = measured & (free_length(tree) >= RELIABLE * radius)
    return Extraction(network, tree, first.radius, dense, spread, reliable, scale)


def _tree(
    volume: Volume, options: Options, segmenter: Segmenter, revise: Callable[[Tree], Tree]
) -> tuple[Tree, np.ndarray | None]:
    """Return the tree without its cannula, and the cannula's line if there is one."""
    root = np.asarray(options.root, dtype=float)
    lumen = segmenter(volume, options.threshold, root)
    outlets = None if options.outlets is None else np.asarray(options.outlets, dtype=float)
    tree = tree_of(lumen, root, outlets)
    _tell_loops(lumen, tree, options.loops)
    cannula = None
    if options.cannula_radius is not None:
        tree, cannula = without_cannula(tree)
    return revise(tree), cannula


def _tell_loops(lumen: Segmentation, tree: Tree, what: str) -> None:
    """Warn of loops that `tree` opens in `lumen`, or refuse them, and say where they probably are."""
    count = loop_count(lumen)
    if count <= 0:
        return
    places = "; ".join(map(written, loop_places(tree)))
    where = f"probably at (x,y,z, cm) {places or 'unknown'}: vessels touch there"
    if what == "refuse":
        raise InputError(
            f"the lumen closes {count} loop(s), {where}; raise the threshold, cut them in the mask, or open them"
        )
    _warn(f"the lumen closes {count} loop(s), which the tree opens, {where}; raise the threshold or give the outlets")


def _scale(cannula: np.ndarray | None, volume: Volume, tree: Tree, known: float | None) -> float:
    if cannula is None or known is None:
        return 1.0
    measured = cannula_radius(cannula, volume, lumen_grey(tree, volume))
    scale = known / measured
    if abs(scale - 1) > 0.01:
        _warn(
            f"the cannula measures {measured:.4g} cm instead of {known:.4g}: its scale differs by "
            f"{100 * (scale - 1):+.1f} % from the file's voxel size, which was used; check the spacing"
        )
    return scale


def write_extraction(extraction: Extraction, folder: str | Path) -> None:
    """Write `network.csv` and `centerlines.csv` into the new `folder`, all or nothing.

    Raises
    ------
    InputError
        If `folder` exists.
    """
    folder = Path(folder)
    if folder.exists():
        raise InputError(f"{folder}: exists already; name a new folder")
    with write_folder(folder) as fresh:
        _write_tables(extraction, fresh)


def _write_tables(extraction: Extraction, folder: Path) -> None:
    network = extraction.network
    names = [network.name[p] if p >= 0 else "" for p in network.parent]
    columns = (network.length, network.radius, extraction.radius_sd, extraction.inscribed, extraction.densitometric)
    heads = ("length", "radius", "radius_sd", "radius_inscribed", "radius_densitometric")
    with (folder / "network.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["name", "parent", *(f"{head} [cm]" for head in heads), "radius_reliable"])
        for row, name in enumerate(network.name):
            cells = [repr(float(column[row])) if np.isfinite(column[row]) else "" for column in columns]
            writer.writerow([name, names[row], *cells, "yes" if extraction.reliable[row] else "no"])
    with (folder / "centerlines.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["vessel", "x [cm]", "y [cm]", "z [cm]", "radius [cm]"])
        for name, line in zip(network.name, extraction.tree.lines, strict=True):
            writer.writerows([name, *(f"{value:.7g}" for value in (x, y, z, r))] for z, y, x, r in line)


def _warn(message: str) -> None:
    warnings.warn(message, VasowaveWarning, stacklevel=3)
