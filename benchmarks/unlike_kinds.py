"""Kinds of volumes unlike those of the phantom, those kept unseen apart."""

from dataclasses import dataclass

SPACING = 0.0085
"""Voxel size, cm."""
CANNULA = 0.043 / SPACING
"""Inner radius of PE-90 tubing, voxels."""
BACKGROUND, CONTRAST, PSF, THINNEST = 12.0, 88.0, 0.8, 1.9
"""Grey levels; standard deviation of the point-spread function and least radius, voxels."""


@dataclass(frozen=True)
class Kind:
    """What a volume is like; see `KINDS`.

    Attributes
    ----------
    vessels, size : int
        Vessels of the tree, voxels along an edge.
    tortuosity : float
        Length of an axis over the distance of its ends.
    taper : float
        Loss of radius along a vessel, as a share.
    aspect : float
        Small over large half axis of a section.
    waves : float
        Relative height of irregularities of the outline.
    fading, patches : float
        Share of the contrast lost from the root to the farthest tip; SD of a factor of each vessel's contrast.
    noise, grain : float
        SD of the noise, grey levels, and its length of correlation, voxels.
    rings, cupping, hardening : float
        Amplitudes of artefacts, grey levels.
    motion : float
        SD of a blur along y, voxels.
    frame : float
        Share of the width that is zero on every side.
    extra : str
        "touching", "crossing", "anastomosis", "vein", "bone", or nothing.
    view : float
        Share of the tree's height that the field of view leaves out at the far end.
    slices : float
        Distance of slices over that of pixels.
    """

    vessels: int = 11
    size: int = 160
    tortuosity: float = 1.01
    taper: float = 0.0
    aspect: float = 1.0
    waves: float = 0.0
    fading: float = 0.0
    patches: float = 0.0
    noise: float = 6.0
    grain: float = 0.7
    rings: float = 0.0
    cupping: float = 0.0
    hardening: float = 0.0
    motion: float = 0.0
    frame: float = 0.0
    extra: str = ""
    view: float = 0.0
    slices: float = 1.0


KINDS = {
    "plain": Kind(),
    "bent 1.03": Kind(tortuosity=1.03),
    "bent 1.05": Kind(tortuosity=1.05),
    "bent 1.15": Kind(tortuosity=1.15),
    "bent 1.3": Kind(tortuosity=1.3),
    "taper 25 %": Kind(taper=0.25),
    "taper 40 %": Kind(taper=0.4),
    "oval 0.85": Kind(aspect=0.85),
    "oval 0.7": Kind(aspect=0.7),
    "fading 20 %": Kind(fading=0.2),
    "fading 40 %": Kind(fading=0.4),
    "rings": Kind(rings=8.0),
    "cupping": Kind(cupping=15.0),
    "grain": Kind(grain=1.5),
    "frame of zeros": Kind(frame=0.15),
    "touching": Kind(extra="touching"),
    "anastomosis": Kind(extra="anastomosis"),
    "cut by the view": Kind(view=0.12),
    "slices 1.7": Kind(slices=1.7),
    "61 vessels": Kind(vessels=61, size=220, tortuosity=1.015),
}
"""Constants may be chosen on these, seeds below 100."""

UNSEEN = {
    "irregular": Kind(waves=0.08),
    "patchy": Kind(patches=0.15),
    "crossing": Kind(extra="crossing"),
    "vein": Kind(extra="vein"),
    "bone": Kind(extra="bone"),
    "motion": Kind(motion=1.0),
    "hardening": Kind(hardening=10.0),
    "mixed": Kind(tortuosity=1.04, taper=0.2, aspect=0.85, fading=0.2, grain=1.0, slices=1.3),
}
"""No constant is chosen on these kinds; of the others, seeds from 1000 on are unseen."""
