"""The whole way from an image to a checked network."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vasowave.errors import InputError, VasowaveWarning
from vasowave.imaging.axes.vessels import tree_of
from vasowave.imaging.entrances import check_root, deepest_near, require_reached, root_wanted
from vasowave.imaging.given import Given, given
from vasowave.imaging.lumen.segmentation import Segmentation
from vasowave.imaging.measure.cannula import scale_of, without_cannula
from vasowave.imaging.measure.measurement import Measurement, filled_at, measured_in
from vasowave.imaging.measure.spread import with_spread
from vasowave.imaging.options import Options
from vasowave.imaging.places import written
from vasowave.imaging.read.files import read_volume
from vasowave.imaging.read.volume import Volume
from vasowave.imaging.revise.edits import edited
from vasowave.imaging.revise.parts import scaled, wanted_part
from vasowave.imaging.tree import Line, Tree
from vasowave.imaging.witness.doubts import Doubt
from vasowave.imaging.witness.loops import loop_count, loop_places
from vasowave.imaging.witness.witness import doubts_about
from vasowave.network import Network


@dataclass(frozen=True, eq=False)
class Extraction:
    """A network, and what is needed to review it.

    Attributes
    ----------
    measured : Measurement
        Of the kept part, its coordinates multiplied by `factor`.
    scale : float
        Known over measured diameter of the cannula; 1 without a cannula. Applied only if `options.scale` says so.
    factor : float
        What the coordinates were multiplied with.
    lumen : Segmentation
    image : Volume
        As read, not resampled.
    source : Path, optional
        Where the image was read from.
    root : float array, shape (3,)
        Where the blood enters, z, y, x, cm, in the image's coordinates.
    options : Options
    doubts : tuple of Doubt
        What contradicts the answer, by vessel.
    notes : tuple of str
        The warnings of this extraction.
    """

    measured: Measurement
    scale: float
    factor: float
    lumen: Segmentation
    image: Volume
    source: Path | None
    root: np.ndarray
    options: Options
    doubts: tuple[Doubt, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def network(self) -> Network:
        """The vessels' lengths and radii."""
        return self.measured.network

    @property
    def tree(self) -> Tree:
        """The vessels in space."""
        return self.measured.tree


def extract(image: Volume | str | Path, options: Options, progress: Callable[[str], None] | None = None) -> Extraction:
    """Return the vessel network in `image`.

    Parameters
    ----------
    image : Volume or path
        See `read_volume`.
    options : Options
    progress : callable, optional
        Called with the name of each stage as it begins.

    Raises
    ------
    InputError
        As `read_volume`, `read_labels`, `read_edits`, `segment`, `tree_of`; no root; a lumen that closes loops, if
        `options.loops` is "refuse"; a cannula that is off by more than 20 %.

    Warns
    -----
    VasowaveWarning
        The cannula contradicts the file's voxel size by more than 1 %; at another threshold vessels are not in the
        lumen; the lumen closes loops; a vessel wider than the root; every doubt of the witness.
    """
    say = progress or (lambda stage: None)
    notes: tuple[str, ...] = ()
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", VasowaveWarning)
            extraction = _extracted(image, options, say)
    finally:  # an error is easier to understand with the warnings that led to it
        notes = tuple(dict.fromkeys(str(one.message) for one in told if issubclass(one.category, VasowaveWarning)))
        for note in notes:
            warnings.warn(note, VasowaveWarning, stacklevel=2)
    return replace(extraction, notes=notes)


def _extracted(source: Volume | str | Path, options: Options, say: Callable[[str], None]) -> Extraction:
    say("image")
    image = source if isinstance(source, Volume) else read_volume(source, options.voxel)
    said = given(image, options)
    say("lumen")
    lumen = _lumen(said, options)
    root = np.asarray(said.root)
    say("axes")
    tree, cannula = _tree(lumen, root, said, options)
    say("radii")
    measured = measured_in(tree, said.volume)
    scale = 1.0 if cannula is None else scale_of(cannula, said.volume, options.cannula / 2)
    check_root(measured.network, scale, options.cannula / 2)
    say("uncertainty")
    inside = deepest_near(lumen, root)  # a place near the wall is outside the lumen at a higher threshold
    measured = with_spread(measured, said.volume, inside, options.threshold, said.segmenter)
    factor = scale if options.scale == "cannula" else 1.0
    say("witness")
    all_ends = said.outlets is None and not said.edits
    doubts = doubts_about(measured, lumen, root, all_ends)
    whole = scaled(measured, factor)
    kept = wanted_part(whole, options.generations, options.vessels, options.min_radius)
    path = None if isinstance(source, Volume) else Path(source)
    doubts = tuple(one for one in doubts if not one.vessels or set(one.vessels) & set(kept.network.name))
    for doubt in doubts:
        warnings.warn(doubt.text, VasowaveWarning, stacklevel=2)
    kept = filled_at(kept, options.pressure)
    return Extraction(kept, scale, factor, lumen, image, path, root, options, doubts)


def _lumen(said: Given, options: Options) -> Segmentation:
    if said.root is None:
        raise root_wanted(said.segmenter(said.volume, options.threshold, None))
    lumen = said.segmenter(said.volume, options.threshold, said.seed)
    if said.outlets is not None:
        require_reached(lumen, said.outlets)
    return lumen


def _tree(lumen: Segmentation, root: np.ndarray, said: Given, options: Options) -> tuple[Tree, Line | None]:
    """Return the tree without its cannula and after the edits, and the cannula's line if there is one."""
    tree = tree_of(lumen, root, said.outlets)
    _tell_loops(lumen, tree, options.loops)
    tree, cannula = without_cannula(tree, said.volume) if options.cannula else (tree, None)
    return edited(tree, said.edits), cannula


def _tell_loops(lumen: Segmentation, tree: Tree, what: str) -> None:
    """Warn of loops that `tree` opens in `lumen`, or refuse them, and say where they probably are."""
    count = loop_count(lumen)
    if count <= 0:
        return
    places = "; ".join(map(written, loop_places(tree)))
    where = f"probably at (x,y,z, cm) {places or 'unknown'}: vessels touch there"
    if what == "refuse":
        raise InputError(
            f"the lumen closes {count} loop(s), {where}. A tree cannot hold them, and where one is cut decides which "
            "vessels there are: give the outlets and raise the threshold, cut them in the mask, or accept any cut "
            "(loops 'open')"
        )
    warnings.warn(
        f"the lumen closes {count} loop(s), {where}. The tree cuts each somewhere: vessels, lengths and flows on it "
        "may be far off; raise the threshold or give the outlets",
        VasowaveWarning,
        stacklevel=2,
    )
