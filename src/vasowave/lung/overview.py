"""The first look at an image: what it is, where its lumen is, what speaks against it, and with what to extract."""

import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from vasowave.base.cures import VOXEL, SetOption
from vasowave.base.errors import InputError, VasowaveWarning
from vasowave.base.findings import Finding, found_in, look_kind
from vasowave.base.species import SpeciesName
from vasowave.lung.axes.vessels import tree_of
from vasowave.lung.entrances import Entrance, clear_entrance, entrances, goes_on, wrong_size
from vasowave.lung.lumen.contours import level_set
from vasowave.lung.lumen.inclusions import without_inclusions
from vasowave.lung.lumen.levels import Levels, levels_of
from vasowave.lung.lumen.segmentation import Segmentation, segment
from vasowave.lung.lumen.strangers import without_strangers
from vasowave.lung.measure.cannula import NoCannulaError, cannula_radius, without_cannula
from vasowave.lung.measure.grey_levels import corrected
from vasowave.lung.measure.measurement import Measurement, measured_in
from vasowave.lung.options import Options
from vasowave.lung.places import VoxelSize, written_in_the_world
from vasowave.lung.read.files import read_volume, source_of
from vasowave.lung.read.formats import VOLUMES
from vasowave.lung.read.plausible import require_plausible
from vasowave.lung.read.volume import Volume, isotropic
from vasowave.lung.tree import Line
from vasowave.lung.witness.faults import inclusion_doubts
from vasowave.lung.witness.grey import GreyLook, grey_doubts, grey_look, saturation
from vasowave.lung.witness.loops import Loop, loop_count, loops_of, opening_threshold
from vasowave.pulse.network.network import Network

BINS = 256
_LEAST_CONTRAST = 1.0  # SD of the noise


@dataclass(frozen=True, eq=False)
class Histogram:
    """How often each grey level occurs.

    Attributes
    ----------
    edges : float array, shape (bin + 1,)
        Grey levels.
    counts : int array, shape (bin,)
        Voxels.
    whole : bool
        Whether all grey levels are whole numbers.
    at_ends : tuple of float
        Shares of the voxels at the lowest and at the highest level.
    """

    edges: np.ndarray
    counts: np.ndarray
    whole: bool
    at_ends: tuple[float, float]

    @property
    def bits(self) -> int | None:
        """Bits that hold all levels; None where they are decimal numbers."""
        return max(1, int(np.ceil(np.log2(np.ptp(self.edges) + 1)))) if self.whole else None


def histogram_of(volume: Volume) -> Histogram:
    """Return the histogram of `volume`."""
    grey = volume.grey
    low, high = float(grey.min()), float(grey.max())
    counts, edges = np.histogram(grey, BINS, (low, high))
    ends = (float(np.mean(grey == low)), float(np.mean(grey == high)))
    return Histogram(edges, counts, bool((grey == np.round(grey)).all()), ends)


UNSEEN = look_kind(
    "image.no-cannula",
    "the vessel at the widest end shows no cannula ({diameter:g} cm wide within), so the command has none and the root "
    "vessel begins at that end; {remedy}",
    "if there is one, give its diameter, with the root at its outer end",
    SetOption("Give the cannula's diameter, cm", "cannula"),
)


NO_TREE = look_kind(
    "image.no-first-tree",
    "no tree was measured at the first look, and none may be at an extraction: {problem}",
    "Look at the lumen before anything is extracted.",
)
UNLIKE = look_kind(
    "image.unlike-species", "{problem}. {remedy}", "Check the size of a voxel before anything is measured.", VOXEL
)


@dataclass(frozen=True, eq=False)
class Overview:
    """What an image shows at a first look.

    Attributes
    ----------
    source : Path, optional
        Where it was read from.
    kind : str
        Its format.
    image : Volume
        As read.
    histogram : Histogram
    levels : Levels
        Background and lumen.
    lumen : Segmentation
        At the threshold of `options`, by its method.
    entrances : tuple of Entrance
        Ends of the lumen where the blood may enter, the widest first; places z, y, x, cm, in the world.
    loops : tuple of Loop
        Rings of the lumen as the threshold alone shows them, the longest first; places likewise.
    closed : bool
        Whether the level set closes them all.
    opening : float, optional
        A higher threshold at which no ring is left.
    measured : Measurement, optional
        A first tree from the widest end, in the image's own axes; None where the lumen has loops or no tree.
    grey : GreyLook
        Saturation and curvature of the grey scale.
    findings : tuple of Finding
        What speaks against the image.
    options : Options
        What is proposed for `extract`.
    """

    source: Path | None
    kind: str
    image: Volume
    histogram: Histogram
    levels: Levels
    lumen: Segmentation
    entrances: tuple[Entrance, ...]
    loops: tuple[Loop, ...]
    closed: bool
    opening: float | None
    measured: Measurement | None
    grey: GreyLook
    findings: tuple[Finding, ...]
    options: Options

    @property
    def is_clear(self) -> bool:
        """Whether one end alone is as wide as the cannula."""
        return clear_entrance(self.entrances, self.options.cannula / 2) is not None


def look(
    scan: Volume | str | Path,
    threshold: float | None = None,
    *,
    cannula: float = 0.086,
    species: SpeciesName = "mouse",
    voxel: VoxelSize | None = None,
) -> Overview:
    """Return what `scan` shows at a first look, and the options with which to extract its network.

    Parameters
    ----------
    scan : Volume or path
        See `read_volume`.
    threshold : float, optional
        Grey level of the wall; proposed from the image where none is given.
    cannula : float
        Known inner diameter of the cannula, cm; 0 where there is none.
    species : str
        See `Options`.
    voxel : float or sequence of 3 floats, optional
        Voxel size in place of the file's, cm (z, y, x).

    Raises
    ------
    InputError
        As `read_volume` and `segment`.

    Examples
    --------
    >>> import numpy as np
    >>> import vasowave as vw
    >>> from vasowave.lung.read.volume import Volume
    >>> z, y, x = np.indices((60, 40, 40)) * 0.01  # cm
    >>> grey = np.random.default_rng(0).normal(20, 5, z.shape) + 100 * (np.hypot(y - 0.2, x - 0.2) < 0.05)
    >>> overview = vw.look(Volume(grey, (0.01,) * 3, (0, 0, 0)), cannula=0.1)
    >>> round(overview.options.threshold, -1), len(overview.loops)
    (60.0, 0)
    """
    with warnings.catch_warnings(record=True) as caught_warnings:
        warnings.simplefilter("always", VasowaveWarning)
        image = scan if isinstance(scan, Volume) else read_volume(scan, voxel)
        require_plausible(image, species)
    with written_in_the_world(image.frame), warnings.catch_warnings(record=True) as later_warnings:
        warnings.simplefilter("always", VasowaveWarning)
        volume = isotropic(image)
        levels = levels_of(volume)
        first = Options(
            threshold=levels.threshold if threshold is None else threshold,
            cannula=cannula,
            species=species,
            voxel=voxel,
        )
        overview = _seen(scan, image, volume, levels, first, later_warnings)
    return replace(overview, findings=tuple(dict.fromkeys((*found_in(caught_warnings), *overview.findings))))


def _seen(
    scan: Volume | str | Path,
    image: Volume,
    volume: Volume,
    levels: Levels,
    first: Options,
    caught_warnings: list[warnings.WarningMessage],
) -> Overview:
    lumen = without_strangers(segment(volume, first.threshold), volume.grey.shape)
    contrast = levels.lumen - levels.background
    if contrast < _LEAST_CONTRAST * lumen.noise:
        raise InputError(
            f"nothing stands out: the brightest piece lies {contrast / lumen.noise:.2g} SD of the noise above the "
            "rest; is this the image of a filled lung?"
        )
    loops, opening, closed = loops_of(lumen) if loop_count(lumen) > 0 else [], None, False
    if loops:
        opening = opening_threshold(lumen)
        smooth = _level_set(volume, first.threshold)
        closed = smooth is not None and loop_count(smooth) <= 0
        lumen = smooth if closed and smooth is not None else lumen
    volume = without_inclusions(volume, lumen.mask, lumen.corner, lumen.inclusions)
    ends = entrances(lumen, volume)
    if loops and not closed:
        ends = tuple(end for end in ends if not goes_on(lumen, end)) or ends
    shown = _First() if loops and not closed else _first_tree(lumen, ends, volume, first.cannula)
    unseen = [UNSEEN(diameter=first.cannula)] if shown.unseen else []
    unseen += [NO_TREE(problem=shown.problem)] if shown.problem else []
    first = first if not shown.unseen else replace(first, cannula=0.0)
    measured = shown.measured
    grey = GreyLook(*saturation(volume, lumen), None)
    if measured is not None:
        grey = grey_look(measured.tree, volume, lumen, shown.cannula, first.cannula / 2)
    names = () if measured is None else measured.network.name
    unseen += [UNLIKE(problem=wrong)] if (wrong := _wrong_size(shown, volume, first, ends)) else []
    inclusions = [] if measured is None else inclusion_doubts(measured, lumen)
    of_scale = grey_doubts(grey, names, [doubt.finding.code for doubt in inclusions])
    grey = grey if of_scale else replace(grey, offered=())
    findings = (*unseen, *(doubt.finding for doubt in of_scale), *found_in(caught_warnings))
    world = image.frame.world
    ends = tuple(Entrance(world(end.place), end.radius) for end in ends)
    return Overview(
        None if isinstance(scan, Volume) else Path(scan),
        "arrays" if isinstance(scan, Volume) else VOLUMES.of(source_of(Path(scan))[0]).title,
        image,
        histogram_of(image),
        levels,
        lumen,
        ends,
        tuple(loop._replace(place=world(loop.place)) for loop in loops),
        closed,
        opening,
        measured,
        grey,
        tuple(dict.fromkeys(findings)),
        _proposed(
            first, volume, ends, grey, closed, opening, "open" if loops and not closed and opening is None else "refuse"
        ),
    )


def _wrong_size(shown: "_First", volume: Volume, options: Options, ends: tuple[Entrance, ...]) -> str:
    """Return why the size of the voxels is wrong, by the first tree or, without one, by the widest end."""
    if shown.measured is None:
        if not ends or not ends[0].radius > 0:
            return ""
        size = np.array([ends[0].radius])
        network = Network(("widest end",), [-1], size, size)
        return wrong_size(network, 1.0, 0.0, options.species)
    scale = 1.0
    if shown.cannula is not None and options.cannula:
        try:
            scale = options.cannula / 2 / cannula_radius(shown.cannula, volume)
        except InputError:  # too little of it is seen
            return ""
    return wrong_size(shown.measured.network, scale, options.cannula / 2, options.species)


def _level_set(volume: Volume, threshold: float) -> Segmentation | None:
    try:
        front = level_set(volume, threshold)
    except InputError:
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)  # what the threshold's lumen has warned of
        return without_strangers(front, volume.grey.shape)


class _First(NamedTuple):
    """What is measured of a first tree from the widest end, None where there is none; its cannula's line, None where
    it has none, whether a cannula was looked for and not seen, and why there is no tree.
    """

    measured: Measurement | None = None
    cannula: Line | None = None
    unseen: bool = False
    problem: str = ""


def _first_tree(lumen: Segmentation, ends: tuple[Entrance, ...], volume: Volume, cannula: float) -> _First:
    """Return the first tree; where it shows no cannula, the whole of it."""
    if not ends:
        return _First()
    try:
        tree = tree_of(lumen, ends[0].place).tree
        if not cannula:
            return _First(measured_in(tree, volume))
        try:
            cut, line = without_cannula(tree, volume)
        except NoCannulaError:
            return _First(measured_in(tree, volume), unseen=True)
        return _First(measured_in(cut, volume), line)
    except InputError as error:
        return _First(problem=str(error))


def _proposed(
    first: Options,
    volume: Volume,
    ends: tuple[Entrance, ...],
    grey: GreyLook,
    closed: bool,
    opening: float | None,
    loops: Literal["open", "refuse"],
) -> Options:
    """Return the options with which to extract; loops are opened where neither contour nor threshold is rid of them."""
    threshold = opening if opening is not None and not closed else first.threshold
    pairs = grey.offered or None
    if pairs:
        threshold = levels_of(corrected(volume, pairs)).threshold
    return Options(
        root=None if not ends else np.round(ends[0].place, 5).tolist(),
        threshold=threshold,
        method="level-set" if closed else "threshold",
        cannula=first.cannula,
        species=first.species,
        voxel=first.voxel,
        grey=pairs,
        loops=loops,
    )
