"""The cannula of known diameter: where it ends in the root vessel, and the scale it gives."""

import numpy as np

from vasowave.base.cures import SetOption
from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, warn
from vasowave.lung.measure.contrast import BLUR, own_contrast
from vasowave.lung.measure.profiles import profile
from vasowave.lung.measure.radii import densitometric_radius, section_radii
from vasowave.lung.read.volume import Volume
from vasowave.lung.tree import Line, Tree

MIN_STEP_SHARE = 0.03
"""The radius changes at the tip by at least this share."""
MARGIN_POINTS = 4
"""Fewest points on either side of the tip."""
NOISE_LENGTH_VOXELS = 2 * np.sqrt(np.pi) * BLUR
"""Voxels along which the errors of sections are alike: the integral scale of noise that is as blurred as the image."""
NO_CANNULA = SetOption("There is no cannula", "cannula", "0")
_ELSE = "or the root is not at the cannula's outer end"
_NONE = "if there is none in the image, say so, and give the root where the network begins"


class NoCannulaError(InputError):
    """The root vessel shows no cannula."""


def cannula_tip(line: Line, radius: np.ndarray) -> int:
    """Return the point at which the cannula ends in the root's `line`: the change point of `radius`.

    A constant (tubing) before the tip and a straight line (a vessel that narrows) from there on are fitted by least
    squares to the points outside both ends' inscribed balls.

    Parameters
    ----------
    line : Line
    radius : float array, shape (point,)
        Radius of the circle of each section's area, cm.

    Raises
    ------
    NoCannulaError
        A line too short, or one whose radius steps by less than 3 %: no cannula can be told from the vessel.
    """
    places, misfits, steps = _candidates(line, radius)
    best = int(np.argmin(misfits))
    tubing_radius, vessel_radius = steps[best]
    if abs(vessel_radius - tubing_radius) < MIN_STEP_SHARE * tubing_radius:
        raise NoCannulaError(
            f"no cannula found: where the root's radius changes most it steps only from {tubing_radius:.4g} to "
            f"{vessel_radius:.4g} cm; {_NONE}; {_ELSE}",
            [NO_CANNULA],
        )
    return int(places[best])


def tip_sd(cannula: Line, root: Line, volume: Volume) -> float:
    """Return the standard deviation of the place where the cannula ends, cm: what noise of the sections leaves open.

    Every point is as likely to be the tip as the misfit of the two stretches that it parts says: `cannula` and `root`,
    what `without_cannula` made of the root.
    """
    line = cannula[:-1].then(root)
    places, misfits, _ = _candidates(line, section_radii(line, volume))
    run = line.run[places]
    independent = np.ptp(run) / (NOISE_LENGTH_VOXELS * float(volume.spacing[0]))
    likely = np.exp(-independent / 2 * (misfits / max(misfits.min(), np.finfo(float).tiny) - 1))
    return float(np.sqrt(np.cov(run, aweights=likely, ddof=0)))


def _candidates(line: Line, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[tuple[float, float]]]:
    """Return every point that may be the tip, the squared misfit with it, and both radii there."""
    run, typical = line.run, np.median(line.radius)
    inner = np.flatnonzero((run > 1.2 * typical) & (run < run[-1] - 1.2 * typical))
    if len(inner) < 3 * MARGIN_POINTS:
        raise NoCannulaError(
            "the root vessel is too short to show where the cannula ends; give the outlets, if false branches cut it; "
            f"{_NONE}; {_ELSE}",
            [NO_CANNULA],
        )
    values, along = radius[inner], run[inner]
    fits = [_fit(values, along, tip) for tip in range(MARGIN_POINTS, len(values) - MARGIN_POINTS)]
    return (
        inner[MARGIN_POINTS:-MARGIN_POINTS],
        np.array([misfit for misfit, *_ in fits]),
        [(tubing_radius, vessel_radius) for _, tubing_radius, vessel_radius in fits],
    )


def _fit(radius: np.ndarray, run: np.ndarray, tip: int) -> tuple[float, float, float]:
    """Return the squared misfit of a constant before `tip` and a line after it, and both radii at the tip."""
    slope, start = np.polyfit(run[tip:] - run[tip], radius[tip:], 1)
    residual = radius[tip:] - start - slope * (run[tip:] - run[tip])
    tubing_radius = float(radius[:tip].mean())
    return float(((radius[:tip] - tubing_radius) ** 2).sum() + (residual**2).sum()), tubing_radius, float(start)


def without_cannula(tree: Tree, volume: Volume) -> tuple[Tree, Line]:
    """Return `tree` with its root cut at the cannula's tip, and the cannula's line from its outer end to the tip."""
    line = tree.lines[tree.root]
    tip = cannula_tip(line, section_radii(line, volume))
    lines = list(tree.lines)
    lines[tree.root] = line[tip:]
    return tree.with_lines(lines), line[: tip + 1]


def cannula_radius(line: Line, volume: Volume) -> float:
    """Return the densitometric radius of the cannula's `line`, cm, by the contrast of its own middle.

    Raises
    ------
    InputError
        If the line has no stretch clear of its outer end and its tip.
    """
    run, typical = line.run, float(np.median(line.radius))
    free = np.flatnonzero((run > 1.2 * typical) & (run < run[-1] - 0.5 * typical))
    sections = profile(line, free, typical, volume)
    if sections is None:
        raise InputError(f"the cannula shows only {run[-1]:.3g} cm, too little to measure its radius; {_ELSE}")
    contrast, _ = own_contrast(sections, BLUR * float(volume.spacing[0]))
    return densitometric_radius(sections, contrast)


OTHER_SCALE = look_kind(
    "image.cannula-scale",
    "the cannula measures {measured:.4g} cm instead of {known:.4g}: its scale differs by {percent:+.1f} % from the "
    "file's voxel size, which was used; {remedy}",
    "check the spacing",
)


def scale_of(cannula: Line, volume: Volume, known_radius: float) -> float:
    """Return the known over the measured radius of the `cannula`.

    Warns
    -----
    VasowaveWarning
        They differ by more than 1 %.
    """
    measured = cannula_radius(cannula, volume)
    scale = known_radius / measured
    if abs(scale - 1) > 0.01:
        warn(OTHER_SCALE(measured=float(measured), known=float(known_radius), percent=float(100 * (scale - 1))))
    return scale
