"""Kinds of volumes unlike those of the phantom, those kept unseen apart."""

from dataclasses import dataclass

SPACING = 0.0085
"""Voxel size, cm."""
CANNULA = 0.043 / SPACING
"""Inner radius of PE-90 tubing, voxels."""
BACKGROUND = 12.0
"""Grey level."""


@dataclass(frozen=True)
class Kind:
    """What a volume is like; see `KINDS`.

    Attributes
    ----------
    vessels, size : int
        Vessels of the tree, voxels along an edge.
    tortuosity : float
        Length of an axis over the distance of its ends.
    bend : float
        Least radius of curvature of an axis, in radii of its vessel; 0: as the tortuosity has it.
    arcs : bool
        Whether axes are straight pieces with arcs of `bend` radii between them; else they wave.
    taper : float
        Loss of radius along a vessel, as a share.
    aspect : float
        Small over large half axis of a section.
    waves : float
        Relative height of irregularities of the outline.
    fading, patches : float
        Share of the contrast lost from the root to the farthest tip; SD of a factor of each vessel's contrast.
    noise, grain, tails : float
        SD of the noise, grey levels; its length of correlation, voxels; degrees of freedom of Student's t (0: Gauss).
    contrast, psf, thinnest : float
        Grey levels between lumen and background; SD of the point-spread function and least radius, voxels.
    rings, cupping, hardening, streaks, slope : float
        Amplitudes of artefacts, grey levels: `slope` is that of the background across the volume.
    motion : float
        SD of a blur along y, voxels.
    frame : float
        Share of the width that is zero on every side.
    extra : str
        "touching", "crossing", "anastomosis", "vein", "bone", "parallel" (a vessel runs beside one), "tree" (another,
        which hangs together with nothing), or nothing.
    view : float
        Share of the tree's height that the field of view leaves out at the far end.
    slices : float
        Distance of slices over that of pixels.
    step, stenosis : float
        Share of its radius that a vessel loses at once in its middle; that it lacks over about two radii there.
    twist : float
        Angle by which sections turn along a vessel, rad.
    filling : float
        Contrast of one of the root's two subtrees over that of the rest.
    daughters : int
        Vessels that leave the root.
    bubbles : int
        Of air, half to nine tenths as wide as the wide vessels that they lie in.
    settled : float
        Share of the contrast that the agent has lost at the top of the volume, by settling along y.
    table : float
        Voxels by which the table moved aside, once, while the scan went on.
    ghost : float
        Contrast of the same animal seen a second time aside, as after a breath, over its own.
    metal : float
        Grey levels of the bands that a cannula of metal, four times as bright as the agent, throws.
    """

    vessels: int = 11
    size: int = 160
    tortuosity: float = 1.01
    bend: float = 0.0
    arcs: bool = False
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
    tails: float = 0.0
    contrast: float = 88.0
    psf: float = 0.8
    thinnest: float = 1.9
    streaks: float = 0.0
    slope: float = 0.0
    step: float = 0.0
    stenosis: float = 0.0
    twist: float = 0.0
    filling: float = 1.0
    daughters: int = 2
    bubbles: int = 0
    settled: float = 0.0
    table: float = 0.0
    ghost: float = 0.0
    metal: float = 0.0


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
    "irregular": Kind(waves=0.08),
    "patchy": Kind(patches=0.15),
    "crossing": Kind(extra="crossing"),
    "vein": Kind(extra="vein"),
    "bone": Kind(extra="bone"),
    "motion": Kind(motion=1.0),
    "hardening": Kind(hardening=10.0),
    "mixed": Kind(tortuosity=1.04, taper=0.2, aspect=0.85, fading=0.2, grain=1.0, slices=1.3),
    "fading 30 %": Kind(fading=0.3),
    "radius steps": Kind(step=0.2),
    "stenosis": Kind(stenosis=0.4),
    "streaks": Kind(streaks=6.0),
    "slope": Kind(slope=15.0),
    "slices 2.3": Kind(slices=2.3),
    "half filled": Kind(filling=0.75),
    "parallel": Kind(extra="parallel"),
    "trifurcation": Kind(vessels=10, daughters=3),
    "101 vessels": Kind(vessels=101, size=260, tortuosity=1.015),
    "thin twigs": Kind(vessels=41, thinnest=1.5),
    "twisted ovals": Kind(aspect=0.85, twist=3.0),
    "sharp": Kind(psf=0.5),
    "blurred": Kind(psf=1.3),
    "low contrast": Kind(contrast=60.0),
    "noise 10": Kind(noise=10.0),
    "heavy tails": Kind(tails=3.0),
    "bent and faded": Kind(tortuosity=1.05, fading=0.3, grain=1.0),
    "tapered and moved": Kind(taper=0.2, motion=0.8, cupping=10.0),
    "oval in a frame": Kind(aspect=0.85, frame=0.1, patches=0.1),
    "tight bends 1.05": Kind(tortuosity=1.05, bend=1.2),
    "tight bends 1.1": Kind(tortuosity=1.1, bend=1.2),
    "tight bends 1.2": Kind(tortuosity=1.2, bend=1.2),
    "tight bends 1.3": Kind(tortuosity=1.3, bend=1.2),
}
"""Constants may be chosen on these, seeds below 3000."""

UNSEEN = {
    "bent 1.1": Kind(tortuosity=1.1),
    "taper 15 %": Kind(taper=0.15),
    "fading 25 %": Kind(fading=0.25),
    "bent, tapering, fading": Kind(tortuosity=1.04, taper=0.15, fading=0.15),
    "bent trifurcation": Kind(vessels=10, daughters=3, tortuosity=1.05),
    "oval 0.8": Kind(aspect=0.8, twist=1.5),
    "coarse grain": Kind(grain=2.2, noise=5.0),
    "rings and cupping": Kind(rings=5.0, cupping=12.0),
    "faint rings": Kind(rings=3.0),
    "hard and streaked": Kind(hardening=15.0, streaks=4.0),
    "beaded": Kind(stenosis=0.2),
    "rough and noisy": Kind(waves=0.06, noise=8.0),
    "blurred along y": Kind(motion=1.3, psf=0.7),
    "31 vessels": Kind(vessels=31, tortuosity=1.02),
    "arcs 1.05": Kind(tortuosity=1.05, bend=1.2, arcs=True),
    "arcs 1.15": Kind(tortuosity=1.15, bend=1.2, arcs=True),
    "arcs 1.3": Kind(tortuosity=1.3, bend=1.2, arcs=True),
    "141 vessels": Kind(vessels=141, size=280, tortuosity=1.015),
    "bubbles": Kind(bubbles=3),
    "settled": Kind(settled=0.45),
    "table moved": Kind(table=3.0),
    "ghost": Kind(ghost=0.35),
    "strong ghost": Kind(ghost=0.7),
    "metal cannula": Kind(metal=30.0),
    "two trees": Kind(extra="tree"),
}
"""No constant is chosen on these kinds; of the others, seeds from 3000 on are unseen."""
