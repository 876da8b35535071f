"""The whole way from an image to a checked network."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vasowave.base.errors import VasowaveWarning
from vasowave.base.findings import Finding, found_in, warn
from vasowave.base.settings import given_values
from vasowave.lung.axes.starts import Settled, settled_before
from vasowave.lung.axes.vessels import tree_of
from vasowave.lung.entrances import (
    ROOT_TAKEN,
    check_root,
    clear_entrance,
    deepest_near,
    entrances,
    require_reached,
    root_wanted,
)
from vasowave.lung.kept.profiles import Profiles
from vasowave.lung.kept.stages import Keys, Stages, image_key, keys_of, volume_key
from vasowave.lung.lumen.inclusions import without_inclusions
from vasowave.lung.lumen.segmentation import Segmentation
from vasowave.lung.lumen.strangers import without_strangers
from vasowave.lung.lumen.surface import surface_points
from vasowave.lung.measure.cannula import scale_of, tip_sd, without_cannula
from vasowave.lung.measure.grey_levels import corrected
from vasowave.lung.measure.measurement import (
    Measurement,
    filled_at,
    measured_in,
    with_common_error,
    with_errors,
    with_wider_radii,
)
from vasowave.lung.measure.spread import Elsewhere, elsewhere, with_spread
from vasowave.lung.options import Options
from vasowave.lung.places import VoxelSize, written, written_in_the_world
from vasowave.lung.read.files import read_volume
from vasowave.lung.read.plausible import require_plausible
from vasowave.lung.read.volume import Volume, is_cubic, isotropic
from vasowave.lung.revise.edits import edited, edited_alike, with_radii
from vasowave.lung.revise.junctions import with_junctions_at
from vasowave.lung.revise.parts import scaled, wanted_part
from vasowave.lung.supplied import Given, given
from vasowave.lung.tree import Line, Tree
from vasowave.lung.witness.doubts import Doubt, is_doubt, ranked, warn_of
from vasowave.lung.witness.faults import fault_doubts, faults_beside, inclusion_shares
from vasowave.lung.witness.grey import common_to_radii, grey_doubts, grey_look
from vasowave.lung.witness.loops import loop_doubts, told_loops
from vasowave.lung.witness.skeleton import Thinned, skeleton_branches, thinned
from vasowave.lung.witness.topology import apart_doubts
from vasowave.lung.witness.witness import doubts_about, surface_misfit
from vasowave.pulse.network.network import Network


@dataclass(frozen=True, eq=False)
class Extraction:
    """A network, and what is needed to review it.

    Attributes
    ----------
    measured : Measurement
        Of the kept part, its coordinates in the world, multiplied by `factor`.
    scale : float
        Known over measured diameter of the cannula; 1 without a cannula. Applied only if `options.scale` says so.
    factor : float
        What the coordinates were multiplied with.
    lumen : Segmentation
        Along the image's own axes, see `Frame`.
    image : Volume
        As read, not resampled.
    source : Path, optional
        Where the image was read from.
    root : float array, shape (3,)
        Where the blood enters, z, y, x, cm, in the world.
    options : Options
    misfit : float array, shape (vessel,)
        How far the lumen is from a round tube, as a share of the radius, see `surface_misfit`.
    doubts : tuple of Doubt
        What contradicts the answer or is left open, by vessel, the gravest first.
    notes : tuple of Finding
        The warnings of this extraction, first the gravest of the doubts.
    """

    measured: Measurement
    scale: float
    factor: float
    lumen: Segmentation
    image: Volume
    source: Path | None
    root: np.ndarray
    options: Options
    misfit: np.ndarray
    doubts: tuple[Doubt, ...] = ()
    notes: tuple[Finding, ...] = ()

    @property
    def network(self) -> Network:
        """The vessels' lengths and radii."""
        return self.measured.network

    @property
    def tree(self) -> Tree:
        """The vessels in space."""
        return self.measured.tree


def extract(
    image: Volume | str | Path,
    options: Options | None = None,
    progress: Callable[[str], None] | None = None,
    stages: Stages | None = None,
    **settings: Any,
) -> Extraction:
    """Return the vessel network in `image`.

    Parameters
    ----------
    image : Volume or path
        See `read_volume`.
    options : Options, optional
    progress : callable, optional
        Called with the name of each stage as it begins.
    stages : Stages, optional
        What an earlier extraction kept; what still holds is not computed again, and the result is the same.
    settings
        Those of `Options` by name, ``root=(0.3, 0.2, 0.1)``, in place of what `options` says of them.

    Raises
    ------
    InputError
        As `read_volume`, `read_labels`, `read_edits`, `segment`, `tree_of`; no root; a lumen that closes loops, if
        `options.loops` is "refuse"; a cannula that is off by more than 20 %.

    Warns
    -----
    VasowaveWarning
        The cannula contradicts the file's voxel size by more than 1 %; at another threshold vessels are not in the
        lumen; the lumen closes loops; a vessel wider than the root; the gravest doubts of the witness, first.

    Examples
    --------
    >>> import numpy as np
    >>> import vasowave as vw
    >>> from vasowave.lung.read.volume import Volume
    >>> z, y, x = np.indices((90, 60, 30)) * 0.002  # cm
    >>> side = np.where(z < 0.09, 0.0, 0.5 * (z - 0.09))  # a vessel that divides at z = 0.09 cm
    >>> axis = np.minimum(np.abs(y - 0.06 - side), np.abs(y - 0.06 + side))
    >>> grey = 200.0 * ((np.hypot(axis, x - 0.03) < 0.011) & (z < 0.17))
    >>> scan = Volume(grey, (0.002,) * 3, (0, 0, 0))
    >>> extraction = vw.extract(scan, root=(0.0, 0.06, 0.03), threshold=100, species="other", cannula=0)
    >>> len(extraction.network), bool(np.allclose(extraction.network.radius, 0.011, atol=0.001))
    (3, True)
    """
    report, merged_options = progress or (lambda stage: None), given_values(Options, options, settings)
    notes: tuple[Finding, ...] = ()
    try:
        with warnings.catch_warnings(record=True) as caught_warnings:
            warnings.simplefilter("always", VasowaveWarning)
            extraction = _extracted(image, merged_options, report, stages or Stages())
    finally:  # an error is easier to understand with the warnings that led to it
        # What is gravest comes first: doubts of the witness, in their order, before what was noticed on the way.
        notes = tuple(sorted(dict.fromkeys(found_in(caught_warnings)), key=lambda note: not is_doubt(note)))
        for note in notes:
            warn(note)
    return replace(extraction, notes=notes)


def _extracted(
    source: Volume | str | Path, options: Options, report: Callable[[str], None], stages: Stages
) -> Extraction:
    report("image")
    image, key = _image(source, options.voxel, stages)
    require_plausible(image, options.species)
    if options.grey is not None:
        image, key = corrected(image, options.grey), f"{key} {options.grey}"
    with written_in_the_world(image.frame):
        extraction = _found_in(image, key, options, report, stages)
    return replace(extraction, source=None if isinstance(source, Volume) else Path(source))


class _Ground(NamedTuple):
    """What all stages after the lumen stand on; places along the image's axes, the volume without dark inclusions."""

    volume: Volume
    inputs: Given
    lumen: Segmentation
    root: np.ndarray
    options: Options
    stages: Stages
    keys: Keys


class _Axes(NamedTuple):
    """The vessels before and after edits, and the line of the cannula if there is one."""

    settled: Settled
    tree: Tree
    cannula: Line | None


def _found_in(image: Volume, key: str, options: Options, report: Callable[[str], None], stages: Stages) -> Extraction:
    """Return the extraction without its source; all is computed along the image's axes, and turned at the end."""
    ground = _grounded(image, key, options, report, stages)
    level_set, is_guided = options.method == "threshold" and options.mask is None, ground.inputs.outlets is not None
    loops = stages.kept(
        "loops", ground.keys.loops, lambda: told_loops(ground.lumen, options.loops, is_guided, level_set)
    )
    report("axes")
    settled_tree, cannula = stages.kept("axes", ground.keys.axes, lambda: _tree(ground))
    axes = _Axes(settled_tree, edited(settled_tree.tree, ground.inputs.edits), cannula)
    report("radii")
    profiler = Profiles(stages.stored("profiles", ground.keys.profiles))
    measured = measured_in(axes.tree, ground.volume, profiler, profiler.beside)
    scale = 1.0 if axes.cannula is None else scale_of(axes.cannula, ground.volume, options.cannula / 2)
    check_root(measured.network, scale, options.cannula / 2, options.species)
    report("uncertainty")
    alternatives = _alternatives(ground, axes)
    skeleton, surface = stages.kept("witness", ground.keys.witness, lambda: _witness(ground.lumen, ground.root))
    axes = _settled_again(ground, axes, surface, profiler)
    measured = with_spread(measured, alternatives, _open_sd(ground, axes, profiler), ground.volume, profiler)
    measured = with_radii(measured, ground.inputs.edits)
    stages.keep("profiles", ground.keys.profiles, profiler.used)
    report("witness")
    misfit = surface_misfit(measured.tree, measured.network.radius, surface, ground.lumen.spacing)
    doubts = _doubts_of_tree(ground, axes, measured, misfit, skeleton, loops)
    measured, doubts_of_image = _with_faults(ground, axes, measured)
    return _in_the_world(ground, image, measured, scale, misfit, (*doubts, *doubts_of_image))


def _grounded(image: Volume, key: str, options: Options, report: Callable[[str], None], stages: Stages) -> _Ground:
    """Return the lumen in cubes, without strangers and inclusions, and the root."""
    volume = image if is_cubic(image) else stages.kept("cubes", key, lambda: isotropic(image))
    inputs = given(image, volume, options)
    report("lumen")
    lumen = stages.kept(
        "lumen", keys_of(key, inputs, options).lumen, lambda: inputs.segmenter(volume, options.threshold, inputs.seed)
    )
    inputs = _entered(inputs, lumen, options)  # it leaves the lumen as it is, and so its key
    if options.mask is None:
        lumen = without_strangers(lumen, volume.grey.shape, inputs.root)
    volume = without_inclusions(volume, lumen.mask, lumen.corner, lumen.inclusions)
    return _Ground(volume, inputs, lumen, np.asarray(inputs.root), options, stages, keys_of(key, inputs, options))


def _alternatives(ground: _Ground, axes: _Axes) -> tuple[Elsewhere, ...]:
    """Return the tree at the other thresholds, after its edits."""
    inputs, unedited = ground.inputs, axes.settled.tree
    inside = deepest_near(ground.lumen, ground.root)  # a place near the wall is outside the lumen at a higher threshold
    alternatives = ground.stages.kept(
        "elsewhere",
        ground.keys.elsewhere,
        lambda: elsewhere(unedited, ground.volume, inside, ground.options.threshold, inputs.segmenter),
    )
    _, *after = edited_alike((unedited, *(alternative.tree for alternative in alternatives)), inputs.edits)
    return tuple(replace(alternative, tree=tree) for alternative, tree in zip(alternatives, after, strict=True))


def _settled_again(ground: _Ground, axes: _Axes, surface: np.ndarray, profiler: Profiles) -> _Axes:
    """Return the `axes` whose edited junctions are settled as the others are."""
    tree, unedited, lumen = axes.tree, axes.settled, ground.lumen
    if tree is unedited.tree:
        return axes
    settled_tree = settled_before(tree, unedited, surface, lumen.spacing, lumen.roughness, profiler.recalled)
    return axes._replace(settled=replace(settled_tree, tree=unedited.tree))


def _open_sd(ground: _Ground, axes: _Axes, profiler: Profiles) -> np.ndarray:
    """Return the SD of the lengths for where vessels meet, and where the root leaves the cannula, cm."""
    begin_sd, unedited = 0.0, axes.settled.tree
    if axes.cannula is not None:
        begins = axes.cannula, unedited.lines[unedited.root]
        begin_sd = profiler.recalled(("tip", *begins), lambda: tip_sd(*begins, ground.volume))
    return np.hypot(axes.settled.open_sd, begin_sd * (np.arange(len(axes.tree)) == axes.tree.root))


def _doubts_of_tree(
    ground: _Ground, axes: _Axes, measured: Measurement, misfit: np.ndarray, skeleton: Thinned, loops: np.ndarray
) -> tuple[Doubt, ...]:
    """Return what speaks against the vessels."""
    all_ends, names = ground.inputs.outlets is None and not ground.inputs.edits, measured.network.name
    ends = None if all_ends else np.array([axes.tree.lines[row].points[-1] for row in axes.tree.terminals])
    branches = skeleton_branches(skeleton, ends)
    return (
        *doubts_about(measured, ground.lumen, branches, misfit, axes.settled.place_sd, all_ends),
        *loop_doubts(measured.tree, names, loops),
        *apart_doubts(measured.tree, names, ground.lumen),
    )


def _with_faults(ground: _Ground, axes: _Axes, measured: Measurement) -> tuple[Measurement, list[Doubt]]:
    """Return `measured` with the errors that systematic faults of the image leave, and what speaks against it."""
    lumen, volume, known_radius = ground.lumen, ground.volume, ground.options.cannula / 2
    levels = ground.stages.kept(
        "grey", ground.keys.grey, lambda: grey_look(axes.settled.tree, volume, lumen, axes.cannula, known_radius)
    )
    measured = with_wider_radii(measured, inclusion_shares(measured, lumen) / 2)
    faults = fault_doubts(measured, volume, lumen)
    fault_codes = [fault.doubt.finding.code for fault in faults]
    of_scale = grey_doubts(levels, measured.network.name, fault_codes)
    faults = faults_beside(faults, bool(levels.offered)) if of_scale else faults
    hidden_sd = 0.0 if measured.grey is None else measured.grey.hidden_wall
    common_sd = max([hidden_sd, *(fault.common_sd for fault in faults)])
    measured = with_common_error(measured, max(common_sd, common_to_radii(levels, fault_codes)))
    return measured, [*of_scale, *(fault.doubt for fault in faults)]


def _in_the_world(
    ground: _Ground, image: Volume, measured: Measurement, scale: float, misfit: np.ndarray, doubts: tuple[Doubt, ...]
) -> Extraction:
    """Return the part that is wanted, as it lies in the world, and warn of its doubts."""
    options, world = ground.options, image.frame.world
    factor = scale if options.scale == "cannula" else 1.0
    measured = replace(measured, tree=measured.tree.moved(world))
    full_measurement = scaled(with_junctions_at(measured, options.junction), factor)
    selection = wanted_part(full_measurement, options.generations, options.vessels, options.min_radius)
    names = selection.network.name
    relevant_doubts = (doubt for doubt in doubts if not doubt.vessels or set(doubt.vessels) & set(names))
    doubts = ranked((replace(doubt, places=world(doubt.places)) for doubt in relevant_doubts), measured.network)
    warn_of(doubts)
    misfit = misfit[[measured.network.name.index(name) for name in names]]
    selection = with_errors(filled_at(selection, options.pressure))
    root = world(ground.root)
    return Extraction(selection, scale, factor, ground.lumen, image, None, root, options, misfit, doubts)


def _image(source: Volume | str | Path, voxel: VoxelSize | None, stages: Stages) -> tuple[Volume, str]:
    """Return the image as read and its key, which nobody asks for where nothing is kept."""
    if isinstance(source, Volume):
        return source, volume_key(source) if stages.parent else ""
    key = image_key(Path(source), voxel) if stages.parent else ""
    if key is not None:
        return stages.kept("image", key, lambda: read_volume(source, voxel)), key
    image = read_volume(source, voxel)
    return image, volume_key(image)


def _entered(inputs: Given, lumen: Segmentation, options: Options) -> Given:
    """Return what was said, with the root: the cannula's end where none was given and one end alone can be it."""
    if inputs.root is not None:
        return inputs
    ends = entrances(lumen, inputs.volume)
    clear = clear_entrance(ends, options.cannula / 2)
    if clear is None:
        raise root_wanted(ends)
    warn(ROOT_TAKEN(place=written(clear.place), radius=clear.radius))
    return replace(inputs, root=clear.place)


def _tree(ground: _Ground) -> tuple[Settled, Line | None]:
    """Return the tree without its cannula, and the cannula's line if there is one."""
    outlets = ground.inputs.outlets
    if outlets is not None:
        require_reached(ground.lumen, outlets)
    settled_tree = tree_of(ground.lumen, ground.root, outlets)
    tree, cannula = settled_tree.tree, None
    if ground.options.cannula:
        tree, cannula = without_cannula(tree, ground.inputs.volume)
    return replace(settled_tree, tree=tree), cannula


def _witness(lumen: Segmentation, root: np.ndarray) -> tuple[Thinned, np.ndarray]:
    """Return the skeleton of the lumen, and the points of its surface."""
    surface = surface_points(lumen)
    return thinned(lumen, root, surface), surface
