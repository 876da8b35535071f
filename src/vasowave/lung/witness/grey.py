"""Doubts about all radii at once: a grey scale that is clipped, flat at one end, or bent."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vasowave.base.errors import InputError
from vasowave.lung.lumen.segmentation import Segmentation
from vasowave.lung.measure.cannula import cannula_radius
from vasowave.lung.measure.grey_levels import GreyScale, corrected, grey_scale
from vasowave.lung.measure.profiles import RING
from vasowave.lung.options import grey_text
from vasowave.lung.read.volume import Volume, part_of
from vasowave.lung.tree import Line, Tree
from vasowave.lung.witness.doubts import Doubt, Grade, doubt_kind

MAX_CLIPPED_SHARE = 0.05
"""A lumen with a larger share of voxels at its highest grey level is cut off there."""
MAX_BEND, SURE_BEND, MIN_FLATNESS = 0.035, 0.06, 0.4
"""A scale that is off by more than the first share of the contrast is bent (radii are off by about half as much), by
more than the second whatever the cannula says; an end flatter than the third of the mean slope is flat."""
MAX_AGREEING_ERROR, MAX_LINEAR_ERROR = 0.02, 0.01
"""A correction is right if the cannula then has its known radius within the first share; a bend is none if it has it
within the second as the image is, and not after a correction."""

CLIPPED_SD, FLAT_SD = 0.1, 0.05
"""Common error of all radii where the grey scale is cut off or flat, as a share of them."""
NOISE_MOVED = {"image.filtered", "image.sharpened", "image.doubled-edges", "image.inclusions"}
"""Faults with which the noise says nothing of the scale: levels of clots are none of agent and wall."""

LINEAR = "export the image on a linear scale, or give its linear levels (option 'grey')"
IMAGE_CLIPPED = doubt_kind(
    "image.clipped",
    Grade.WRONG,
    "{share:.0%} of the lumen's voxels have its highest grey level ({level:g}): what is brighter was cut off, and all "
    "radii are too large: {remedy}",
    "export the image with a wider window, or with 16 bits",
)
IMAGE_FLAT = doubt_kind(
    "image.flat-grey-scale",
    Grade.LOOK,
    "the grey scale is nearly flat at one end: noise there is {flatness:.0%} of what it is on average, so the image "
    "was windowed or saturates, and all radii may be off; {way}",
    LINEAR,
)
IMAGE_BENT = doubt_kind(
    "image.bent-grey-scale",
    Grade.LOOK,
    "the grey scale is bent by {bend:+.0%} of the contrast, as the noise at each grey level shows, so all radii are "
    "off; {way}",
    LINEAR,
)


@dataclass(frozen=True, eq=False)
class GreyLook:
    """What there is to say of the grey levels of an image.

    Attributes
    ----------
    saturated : float
        Share of the lumen's voxels at its highest grey level.
    highest : float
        That level.
    scale : GreyScale, optional
        None where noise does not show it.
    offered : tuple of (float, float)
        Measured and linear levels: a correction on which noise and cannula agree; empty without one.
    contradicted : bool
        Whether the cannula says that the scale is linear.
    """

    saturated: float
    highest: float
    scale: GreyScale | None
    offered: tuple[tuple[float, float], ...] = ()
    contradicted: bool = False


def grey_look(tree: Tree, volume: Volume, lumen: Segmentation, cannula: Line | None, known_radius: float) -> GreyLook:
    """Return what `volume` (cubes) and the `cannula` of `known_radius` (cm) say of the grey scale."""
    share, highest = saturation(volume, lumen)
    scale = grey_scale(tree, volume)
    if scale is None or cannula is None or share > MAX_CLIPPED_SHARE:
        return GreyLook(share, highest, scale)
    try:
        region = _around(cannula, volume)
        before, after = (
            abs(float(np.log(cannula_radius(cannula, image) / known_radius)))
            for image in (region, corrected(region, scale.pairs))
        )
    except InputError:  # too little of the cannula is seen
        return GreyLook(share, highest, scale)
    offered = scale.pairs if _is_off(scale) and after < MAX_AGREEING_ERROR else ()
    return GreyLook(
        share,
        highest,
        scale,
        offered,
        before < MAX_LINEAR_ERROR and after > MAX_AGREEING_ERROR and abs(scale.bend) < SURE_BEND,
    )


def _around(line: Line, volume: Volume) -> Volume:
    """Return the part of `volume` that the sections of `line` reach into: a whole image takes seconds to correct."""
    reach = float(np.median(line.radius)) + (RING + 2) * volume.spacing
    low = np.floor((line.points.min(axis=0) - reach - volume.origin) / volume.spacing).astype(int)
    high = np.ceil((line.points.max(axis=0) + reach - volume.origin) / volume.spacing).astype(int) + 1
    return part_of(volume, low, high)


def saturation(volume: Volume, lumen: Segmentation) -> tuple[float, float]:
    """Return the share of the lumen's voxels at its highest grey level, and that level.

    0 in a mask of two levels, and in an image without noise and of decimal numbers, where equal levels are no sign.
    """
    box = tuple(slice(a, a + n) for a, n in zip(lumen.corner, lumen.mask.shape, strict=True))
    grey = volume.grey[box][lumen.mask]
    highest, lowest = float(grey.max()), float(volume.grey.min())
    levels = volume.grey[box]
    mask = bool(((levels == highest) | (levels == lowest)).all())
    made = lumen.noise == 0 and not np.array_equal(grey, np.round(grey))
    if mask or made:
        return 0.0, highest
    return float(np.mean(grey >= highest - 1e-6 * (highest - lowest))), highest


def common_to_radii(observation: GreyLook, faults: Sequence[str] = ()) -> float:
    """Return the SD of the factor that the grey scale leaves open of all radii, as a share.

    0 where it is linear, and where `faults` (codes) moved the noise, which then tells nothing of it.
    """
    if observation.saturated > MAX_CLIPPED_SHARE:
        return CLIPPED_SD
    if observation.scale is None or observation.contradicted or not _is_off(observation.scale):
        return 0.0
    if NOISE_MOVED & set(faults):
        return 0.0
    return max(abs(observation.scale.bend) / 2, FLAT_SD if observation.scale.flatness < MIN_FLATNESS else 0.0)


def grey_doubts(observation: GreyLook, vessels: Sequence[str], faults: Sequence[str] = ()) -> list[Doubt]:
    """Return the gravest thing that the grey levels say against the radii of all `vessels`, if there is one.

    A filter, by its code among `faults`, moves the noise too, which then says nothing of the scale.
    """
    names = tuple(vessels)
    if observation.saturated > MAX_CLIPPED_SHARE:
        return [Doubt("radius", IMAGE_CLIPPED(share=observation.saturated, level=observation.highest), names)]
    scale = observation.scale
    if scale is None or observation.contradicted or not _is_off(scale) or NOISE_MOVED & set(faults):
        return []
    remedy = LINEAR
    if observation.offered:
        pairs = grey_text(observation.offered)
        remedy = f"with it corrected, grey {pairs}, the cannula has its known diameter: extract again so"
    if scale.flatness < MIN_FLATNESS:
        return [Doubt("radius", IMAGE_FLAT(flatness=scale.flatness, way=remedy), names)]
    return [Doubt("radius", IMAGE_BENT(bend=scale.bend, way=remedy), names)]


def _is_off(scale: GreyScale) -> bool:
    return abs(scale.bend) > MAX_BEND or scale.flatness < MIN_FLATNESS
