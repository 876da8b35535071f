"""The whole way from a volume to a checked network, and the folder that holds the result."""

import csv
import os
import shutil
import tempfile
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vasowave.errors import InputError, VasowaveWarning
from vasowave.imaging.cannula import PE90_RADIUS, without_cannula
from vasowave.imaging.centerlines import center_paths
from vasowave.imaging.junctions import with_met_axes
from vasowave.imaging.radii import densitometric_radii
from vasowave.imaging.segmentation import segment
from vasowave.imaging.tree import Tree, network_of, vessel_tree
from vasowave.imaging.volume import Volume, isotropic, read_volume
from vasowave.network import Network


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
    """

    root: Sequence[float]
    outlets: Sequence[Sequence[float]] | None = None
    threshold: float = 45.0
    cannula_radius: float | None = PE90_RADIUS
    spacing: float | None = None


@dataclass(frozen=True, eq=False)
class Extraction:
    """A network with where it came from.

    Attributes
    ----------
    network : Network
        Radii are densitometric where a vessel has a free stretch, inscribed elsewhere.
    tree : Tree
    inscribed, densitometric, radius_sd : float array, shape (vessel,)
        Radii and the SD of the inscribed radius over the thresholds, cm; NaN where not measured.
    scale : float
        Known over measured radius of the cannula; 1 without a cannula. It is reported, not applied.
    """

    network: Network
    tree: Tree
    inscribed: np.ndarray
    densitometric: np.ndarray
    radius_sd: np.ndarray
    scale: float


def extract(volume: Volume | str | Path, options: Options, progress: Callable[[str], None] | None = None) -> Extraction:
    """Return the vessel network in `volume`.

    Parameters
    ----------
    volume : Volume or path
    options : Options
    progress : callable, optional
        Called with the name of each stage as it begins.

    Raises
    ------
    InputError
        As `read_volume`, `segment`, `center_paths`.

    Warns
    -----
    VasowaveWarning
        The cannula contradicts the file's voxel size by more than 1 %; another threshold gives another tree.
    """
    say = progress or (lambda stage: None)
    say("volume")
    volume = isotropic(volume if isinstance(volume, Volume) else read_volume(volume, options.spacing))
    say("centerlines")
    tree, measured = _tree(volume, options, options.threshold)
    first = network_of(tree)
    say("radii")
    dense = densitometric_radii(tree, volume, first.radius)
    say("uncertainty")
    others = [_radii_at(volume, options, factor, first) for factor in (0.8, 1.2)]
    spread = np.std([first.radius, *others], axis=0, ddof=1)
    scale = 1.0 if measured is None or options.cannula_radius is None else options.cannula_radius / measured
    if abs(scale - 1) > 0.01:
        _warn(
            f"the cannula measures {measured:.4g} cm instead of {options.cannula_radius:.4g}: its scale differs by "
            f"{100 * (scale - 1):+.1f} % from the file's voxel size, which was used; check the spacing or threshold"
        )
    radius = np.where(np.isfinite(dense), dense, first.radius)
    network = Network(first.name, first.parent, first.length, radius)
    return Extraction(network, tree, first.radius, dense, spread, scale)


def _tree(volume: Volume, options: Options, threshold: float) -> tuple[Tree, float | None]:
    root = np.asarray(options.root, dtype=float)
    lumen = segment(volume, threshold, root)
    outlets = None if options.outlets is None else np.asarray(options.outlets, dtype=float)
    tree = with_met_axes(vessel_tree(center_paths(lumen, root, outlets)))
    return (tree, None) if options.cannula_radius is None else without_cannula(tree)


def _radii_at(volume: Volume, options: Options, factor: float, network: Network) -> np.ndarray:
    """Return the inscribed radii at another threshold, NaN if the tree is another one there."""
    from vasowave.imaging.matching import match

    found = np.full(len(network), np.nan)
    other = network_of(_tree(volume, options, options.threshold * factor)[0])
    pairs = match(network, other)
    if len(other) != len(network) or len(pairs) < len(network):
        _warn(f"at threshold {options.threshold * factor:g} the tree has {len(other)} vessels, not {len(network)}")
    for row, same in pairs.items():
        found[row] = other.radius[same]
    return found


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
    folder.parent.mkdir(parents=True, exist_ok=True)
    draft = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    try:
        _write_tables(extraction, draft)
        os.replace(draft, folder)
    except BaseException:
        shutil.rmtree(draft, ignore_errors=True)
        raise


def _write_tables(extraction: Extraction, folder: Path) -> None:
    network = extraction.network
    names = [network.name[p] if p >= 0 else "" for p in network.parent]
    columns = (network.length, network.radius, extraction.radius_sd, extraction.inscribed, extraction.densitometric)
    heads = ("length", "radius", "radius_sd", "radius_inscribed", "radius_densitometric")
    with (folder / "network.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["name", "parent", *(f"{head} [cm]" for head in heads)])
        for row, name in enumerate(network.name):
            writer.writerow([name, names[row], *(repr(float(c[row])) if np.isfinite(c[row]) else "" for c in columns)])
    with (folder / "centerlines.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["vessel", "x [cm]", "y [cm]", "z [cm]", "radius [cm]"])
        for name, line in zip(network.name, extraction.tree.lines, strict=True):
            writer.writerows([name, *(f"{value:.7g}" for value in (x, y, z, r))] for z, y, x, r in line)


def _warn(message: str) -> None:
    warnings.warn(message, VasowaveWarning, stacklevel=3)
