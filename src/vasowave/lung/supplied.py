"""What the user gave, files read and put on one grid."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from vasowave.lung.lumen.contours import level_set
from vasowave.lung.lumen.masks import EditedMask, Within, box_region
from vasowave.lung.lumen.segmentation import Segmenter, segment
from vasowave.lung.options import Options
from vasowave.lung.read.labels import ROOT, marks, on_grid_of, read_labels
from vasowave.lung.read.volume import Volume
from vasowave.lung.revise.edits import Edit, applied, outlets_of, root_of

_METHODS: dict[str, Segmenter] = {"threshold": segment, "level-set": level_set}


@dataclass(frozen=True, eq=False)
class Given:
    """An image with all that was said about it.

    Attributes
    ----------
    image, volume : Volume
        As read, and in cubes.
    segmenter : Segmenter
        Finds the lumen in `volume`.
    root, seed : float array, shape (3,), or None
        Where the blood enters, and a point inside the tree; z, y, x, cm, along the image's axes, as all places here.
    outlets : float array, shape (outlet, 3), or None
    edits : tuple of Edit
    """

    image: Volume
    volume: Volume
    segmenter: Segmenter
    root: np.ndarray | None
    seed: np.ndarray | None
    outlets: np.ndarray | None
    edits: tuple[Edit, ...]


def given(image: Volume, volume: Volume, options: Options) -> Given:
    """Read the files that `options` names; `volume` is `image` in cubes.

    Raises
    ------
    InputError
        As `read_labels`, `applied`, `box_region`.
    """
    to_image = image.frame.own
    edits = tuple(edit.turned(to_image) for edit in applied(options.edits)) if options.edits else ()
    labels = on_grid_of(read_labels(options.mask, image, options.voxel), image, volume) if options.mask else None
    entrances = marks(labels, volume) if labels is not None else {}
    painted: Any = [place for label, place in entrances.items() if label > ROOT]
    outlets: Any = to_image(options.outlets) if options.outlets is not None else painted or outlets_of(edits)
    option_root: Any = None if options.root is None else to_image(options.root)
    root: Any = next((place for place in (root_of(edits), option_root, entrances.get(ROOT)) if place is not None), None)
    seed: Any = root if options.seed is None else to_image(options.seed)
    root, seed, outlets = (None if place is None else np.asarray(place, dtype=float) for place in (root, seed, outlets))
    return Given(image, volume, _segmenter(options, image, volume, labels), root, seed, outlets, edits)


def _segmenter(options: Options, image: Volume, volume: Volume, labels: np.ndarray | None) -> Segmenter:
    region = None
    if isinstance(options.region, tuple):
        region = box_region(volume, *map(image.frame.own, options.region))
    elif options.region is not None:
        region = on_grid_of(read_labels(options.region, image, options.voxel), image, volume) > 0
    if labels is not None:
        return EditedMask((labels > 0) if region is None else (labels > 0) & region, volume, options.threshold)
    segmenter = _METHODS[options.method]
    return segmenter if region is None else Within(region, volume, segmenter)
