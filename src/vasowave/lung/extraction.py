"""The whole way from an image to a checked network."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

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
from vasowave.lung.kept.stages import Stages, image_key, keys_of, volume_key
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
from vasowave.lung.revise.edits import Edit, edited, edited_alike, with_radii
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


def _found_in(image: Volume, key: str, options: Options, report: Callable[[str], None], stages: Stages) -> Extraction:
    """Return the extraction without its source; all is computed along the image's axes, and turned at the end."""
    volume = image if is_cubic(image) else stages.kept("cubes", key, lambda: isotropic(image))
    inputs = given(image, volume, options)
    report("lumen")
    lumen = stages.kept("lumen", keys_of(key, inputs, options).lumen, lambda: _lumen(inputs, options))
    rooted_inputs = _entered(inputs, lumen, options)  # it leaves the lumen as it is, and so its key
    keys = keys_of(key, rooted_inputs, options)
    if options.mask is None:
        lumen = without_strangers(lumen, volume.grey.shape, rooted_inputs.root)
    volume = without_inclusions(volume, lumen.mask, lumen.corner, lumen.inclusions)
    root = np.asarray(rooted_inputs.root)
    level_set = options.method == "threshold" and options.mask is None
    loops = stages.kept(
        "loops", keys.loops, lambda: told_loops(lumen, options.loops, rooted_inputs.outlets is not None, level_set)
    )
    report("axes")
    settled_tree, cannula = stages.kept("axes", keys.axes, lambda: _tree(lumen, root, rooted_inputs, options))
    unedited, tree = settled_tree.tree, edited(settled_tree.tree, rooted_inputs.edits)
    report("radii")
    profiler = Profiles(stages.stored("profiles", keys.profiles))
    measured = measured_in(tree, volume, profiler, profiler.beside)
    scale = 1.0 if cannula is None else scale_of(cannula, volume, options.cannula / 2)
    check_root(measured.network, scale, options.cannula / 2, options.species)
    report("uncertainty")
    inside = deepest_near(lumen, root)  # a place near the wall is outside the lumen at a higher threshold
    alternatives = stages.kept(
        "elsewhere",
        keys.elsewhere,
        lambda: elsewhere(unedited, volume, inside, options.threshold, rooted_inputs.segmenter),
    )
    skeleton, surface = stages.kept("witness", keys.witness, lambda: _witness(lumen, root))
    if tree is not unedited:
        settled_tree = settled_before(tree, settled_tree, surface, lumen.spacing, lumen.roughness, profiler.recalled)
    begin_sd = 0.0
    if cannula is not None:
        begins = cannula, unedited.lines[unedited.root]
        begin_sd = profiler.recalled(("tip", *begins), lambda: tip_sd(*begins, volume))
    open_sd = np.hypot(settled_tree.open_sd, begin_sd * (np.arange(len(tree)) == tree.root))
    measured = with_spread(
        measured, _edited_too(unedited, alternatives, rooted_inputs.edits), open_sd, volume, profiler
    )
    measured = with_radii(measured, rooted_inputs.edits)
    stages.keep("profiles", keys.profiles, profiler.used)
    report("witness")
    all_ends = rooted_inputs.outlets is None and not rooted_inputs.edits
    misfit = surface_misfit(measured.tree, measured.network.radius, surface, lumen.spacing)
    ends = None if all_ends else np.array([tree.lines[row].points[-1] for row in tree.terminals])
    branches = skeleton_branches(skeleton, ends)
    doubts = doubts_about(measured, lumen, branches, misfit, settled_tree.place_sd, all_ends)
    doubts += tuple(loop_doubts(measured.tree, measured.network.name, loops))
    doubts += tuple(apart_doubts(measured.tree, measured.network.name, lumen))
    levels = stages.kept("grey", keys.grey, lambda: grey_look(unedited, volume, lumen, cannula, options.cannula / 2))
    measured = with_wider_radii(measured, inclusion_shares(measured, lumen) / 2)
    faults = fault_doubts(measured, volume, lumen)
    fault_codes = [fault.doubt.finding.code for fault in faults]
    of_scale = grey_doubts(levels, measured.network.name, fault_codes)
    faults = faults_beside(faults, bool(levels.offered)) if of_scale else faults
    doubts += (*of_scale, *(fault.doubt for fault in faults))
    hidden_sd = 0.0 if measured.grey is None else measured.grey.hidden_wall
    common_sd = max([hidden_sd, *(fault.common_sd for fault in faults)])
    measured = with_common_error(measured, max(common_sd, common_to_radii(levels, fault_codes)))
    factor, world = scale if options.scale == "cannula" else 1.0, image.frame.world
    measured = replace(measured, tree=measured.tree.moved(world))
    full_measurement = scaled(with_junctions_at(measured, options.junction), factor)
    selection = wanted_part(full_measurement, options.generations, options.vessels, options.min_radius)
    relevant_doubts = (
        doubt for doubt in doubts if not doubt.vessels or set(doubt.vessels) & set(selection.network.name)
    )
    doubts = ranked((replace(doubt, places=world(doubt.places)) for doubt in relevant_doubts), measured.network)
    warn_of(doubts)
    misfit = misfit[[measured.network.name.index(name) for name in selection.network.name]]
    selection = with_errors(filled_at(selection, options.pressure))
    return Extraction(selection, scale, factor, lumen, image, None, world(root), options, misfit, doubts)


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


def _lumen(inputs: Given, options: Options) -> Segmentation:
    return inputs.segmenter(inputs.volume, options.threshold, inputs.seed)


def _tree(lumen: Segmentation, root: np.ndarray, inputs: Given, options: Options) -> tuple[Settled, Line | None]:
    """Return the tree without its cannula, and the cannula's line if there is one."""
    if inputs.outlets is not None:
        require_reached(lumen, inputs.outlets)
    settled_tree = tree_of(lumen, root, inputs.outlets)
    tree, cannula = without_cannula(settled_tree.tree, inputs.volume) if options.cannula else (settled_tree.tree, None)
    return replace(settled_tree, tree=tree), cannula


def _witness(lumen: Segmentation, root: np.ndarray) -> tuple[Thinned, np.ndarray]:
    """Return the skeleton of the lumen, and the points of its surface."""
    surface = surface_points(lumen)
    return thinned(lumen, root, surface), surface


def _edited_too(tree: Tree, alternatives: tuple[Elsewhere, ...], edits: tuple[Edit, ...]) -> tuple[Elsewhere, ...]:
    """Return the tree at other thresholds after the edits of `tree`."""
    _, *after = edited_alike((tree, *(alternative.tree for alternative in alternatives)), edits)
    return tuple(
        replace(alternative, tree=edited_tree) for alternative, edited_tree in zip(alternatives, after, strict=True)
    )
