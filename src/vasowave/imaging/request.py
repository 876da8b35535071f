"""An extraction as a user asks for it, in files and places, and what comes of it."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np

from vasowave.errors import InputError, VasowaveWarning
from vasowave.imaging.cannula import PE90_RADIUS
from vasowave.imaging.contours import level_set
from vasowave.imaging.edits import edited, read_edits, root_of
from vasowave.imaging.ends import check_root, deepest_near, require_reached, root_wanted
from vasowave.imaging.extraction import Extraction, Options, Segmenter, extract
from vasowave.imaging.masks import ROOT, EditedMask, Within, box_region, marks, on_grid_of, read_labels
from vasowave.imaging.segmentation import Segmentation, segment
from vasowave.imaging.subtrees import check_wishes, scaled, wanted_part
from vasowave.imaging.volume import Volume, isotropic, read_volume


@dataclass(frozen=True, eq=False)
class Request:
    """What the user gives; places are z, y, x in cm, in the image's own coordinates.

    Attributes
    ----------
    image : Path
        See `read_volume`.
    root : sequence of 3 floats, optional
        Where the blood enters; an edit `root` overrules it, label 2 of `mask` stands in for it.
    seed : sequence of 3 floats, optional
        A point inside the tree, where the root is not inside it.
    outlets : array, shape (outlet, 3), optional
        Guided mode; labels from 3 on of `mask` stand in for them.
    threshold : float
        Grey level of the wall.
    method : "threshold" or "level-set"
        Region growing, or the active contour of `contours.level_set`.
    mask, edits : Path, optional
        The lumen as edited by hand (see `masks.read_labels`), corrections of the tree (see `edits`).
    region : Path or pair of corners, optional
        Mask file or box outside which nothing is lumen.
    voxel : float, optional
        Voxel size, cm, in place of the file's.
    cannula_radius : float, optional
        Known inner radius, cm; None where there is no cannula.
    scale : "file" or "cannula"
        Whether lengths follow the file's voxel size or the cannula's known radius.
    loops : "open" or "refuse"
        What becomes of loops of the lumen, see `Options`.
    generations, vessels, min_radius : optional
        At most one: the part of the tree to keep, see `subtrees`.
    """

    image: Path
    root: Sequence[float] | None = None
    seed: Sequence[float] | None = None
    outlets: np.ndarray | None = None
    threshold: float = 45.0
    method: Literal["threshold", "level-set"] = "threshold"
    mask: Path | None = None
    edits: Path | None = None
    region: Path | tuple[np.ndarray, np.ndarray] | None = None
    voxel: float | None = None
    cannula_radius: float | None = PE90_RADIUS
    scale: Literal["file", "cannula"] = "file"
    loops: Literal["open", "refuse"] = "open"
    generations: int | None = None
    vessels: int | None = None
    min_radius: float | None = None

    def __post_init__(self) -> None:
        """Refuse what contradicts itself before any file is read."""
        check_wishes(self.generations, self.vessels, self.min_radius)
        if self.method not in _METHODS:
            raise InputError(f"method '{self.method}'; there are: {', '.join(_METHODS)}")
        if self.scale not in ("file", "cannula"):
            raise InputError(f"scale '{self.scale}'; lengths follow the 'file' or the 'cannula'")
        if self.scale == "cannula" and self.cannula_radius is None:
            raise InputError("scale 'cannula' needs a cannula of known diameter")
        if self.cannula_radius is not None and not 0 < self.cannula_radius < 1:
            raise InputError(f"a cannula of radius {self.cannula_radius:g} cm; give its inner diameter in cm")
        if self.mask is not None and self.method != "threshold":
            raise InputError("a mask is the lumen; the method 'level-set' would find another: leave one out")


@dataclass(frozen=True, eq=False)
class Answer:
    """A network and what is needed to review it.

    Attributes
    ----------
    extraction : Extraction
        Of the kept part, scaled; `factor` is what its coordinates were multiplied with.
    lumen : Segmentation
    image : Volume
        As read, not resampled.
    root : float array, shape (3,)
        Where the blood enters, z, y, x, cm, in the image's coordinates.
    request : Request
    factor : float
    notes : tuple of str
        The warnings of this extraction.
    """

    extraction: Extraction
    lumen: Segmentation
    image: Volume
    root: np.ndarray
    request: Request
    factor: float
    notes: tuple[str, ...] = field(default=())


_METHODS: dict[str, Segmenter] = {"threshold": segment, "level-set": level_set}


def answer(request: Request, progress: Callable[[str], None] | None = None) -> Answer:
    """Carry out `request`.

    Parameters
    ----------
    request : Request
    progress : callable, optional
        Called with the name of each stage as it begins.

    Raises
    ------
    InputError
        As `read_volume`, `read_labels`, `read_edits`, `extract`; no root; a cannula that is off by more than 20 %.

    Warns
    -----
    VasowaveWarning
        All that `extract` warns of; a vessel wider than the root.
    """
    say = progress or (lambda stage: None)
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", VasowaveWarning)
            found = _carried_out(request, say)
    finally:  # an error is easier to understand with the warnings that led to it
        notes = tuple(dict.fromkeys(str(one.message) for one in told if issubclass(one.category, VasowaveWarning)))
        for note in notes:
            warnings.warn(note, VasowaveWarning, stacklevel=2)
    return Answer(*found, notes)


def _carried_out(
    request: Request, say: Callable[[str], None]
) -> tuple[Extraction, Segmentation, Volume, np.ndarray, Request, float]:
    edits = read_edits(request.edits) if request.edits else ()
    say("image")
    image = read_volume(request.image, request.voxel)
    volume = isotropic(image)
    labels = on_grid_of(read_labels(request.mask, image, request.voxel), volume) if request.mask else None
    found = marks(labels, volume) if labels is not None else {}
    segmenter = _segmenter(request, image, volume, labels)
    outlets = request.outlets
    if outlets is None and any(label > ROOT for label in found):
        outlets = np.array([place for label, place in found.items() if label > ROOT])
    root = next((place for place in (root_of(edits), request.root, found.get(ROOT)) if place is not None), None)
    if root is None:
        raise root_wanted(segmenter(volume, request.threshold, None))  # type: ignore[arg-type]
    root = np.asarray(root, dtype=float)
    places = None if outlets is None else outlets.tolist()
    options = Options(root.tolist(), places, request.threshold, request.cannula_radius, loops=request.loops)
    first = root if request.seed is None else np.asarray(request.seed, dtype=float)
    lumens: dict[float, Segmentation] = {}

    def remembering(volume: Volume, threshold: float, seed: np.ndarray) -> Segmentation:
        main = lumens.get(request.threshold)
        # A place near the wall is outside the lumen at a higher threshold.
        inside = first if main is None else deepest_near(main, root)
        lumens[threshold] = segmenter(volume, threshold, inside)
        if threshold == request.threshold and outlets is not None:
            require_reached(lumens[threshold], outlets)
        return lumens[threshold]

    try:
        whole = extract(volume, options, say, remembering, partial(edited, edits=edits))
    except InputError as error:
        if "cannula" in str(error):
            raise InputError(f"{error}; or the root is not at the cannula's outer end") from None
        raise
    check_root(whole, request.cannula_radius)
    factor = whole.scale if request.scale == "cannula" else 1.0
    kept = wanted_part(scaled(whole, factor), request.generations, request.vessels, request.min_radius)
    return kept, lumens[request.threshold], image, root, request, factor


def _segmenter(request: Request, image: Volume, volume: Volume, labels: np.ndarray | None) -> Segmenter:
    region = None
    if isinstance(request.region, tuple):
        region = box_region(volume, request.region[0], request.region[1])
    elif request.region is not None:
        region = on_grid_of(read_labels(request.region, image, request.voxel), volume) > 0
    if labels is not None:
        return EditedMask((labels > 0) if region is None else (labels > 0) & region, volume, request.threshold)
    found = _METHODS[request.method]
    return found if region is None else Within(region, volume, found)
