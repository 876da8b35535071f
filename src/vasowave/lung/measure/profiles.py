"""Cross-sections of a vessel summed up: how much contrast agent, how bright in the middle, how round, how sharp.

The same sections laid beside the vessel, where nothing is, tell what noise alone adds to them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from vasowave.lung.kernels import in_tube
from vasowave.lung.read.volume import Volume
from vasowave.lung.sections import STEP, across, carried, disc, medians, sampled, tangents
from vasowave.lung.tree import Line

DISC, RING = 2.0, 7.0
"""A section is integrated up to DISC voxels beyond the radius, its background taken from there to RING voxels."""
CLEARANCE, DIRECTIONS, MIN_SECTION_SHARE = 1.0, 32, 0.3
"""Directions (of so many) in which a section comes within CLEARANCE voxels of another vessel are not measured; sections
of which less than MIN_SECTION_SHARE is left are not used."""
CORE = 0.6, 2.5
"""The middle of a section: within the radius less the second number, at least the first, voxels."""
BIN = 0.5
"""Width of the bins of distance from the axis in which the wall's slope is looked for, voxels."""
COPIES = 12
"""The sections are laid in so many directions beside their vessel."""
SECTION_STEP_VOXELS, SAMPLES_PER_RADIUS = 2.0, 4.0
"""One section in SECTION_STEP_VOXELS is enough, and one sample a voxel: neighbors share their noise. In vessels wider
than SAMPLES_PER_RADIUS voxels samples, and then sections, are so many to a radius, for their radii are sure."""
MIN_CLEAR_SHARE = 0.9
"""A section is used if so much of it is not a vessel."""
ORDERS, OVAL = np.array([2, 3, 4, 5]), 1.5
"""Waves around a section; an axis a little beside the middle has none of them, an oval the first, and in the third so
many times its square."""
SECTIONS_PER_SAMPLE, MIN_SECTIONS, MIN_EVIDENCE = 3.0, 4, 4.0
"""Neighboring sections share their noise: so many count as one. Fewer than the second tell nothing of an outline, nor
do waves whose square is less than so many times that of their noise, as in 99 of 100 round vessels."""
MIN_COPIES = 4
"""Fewer copies that lie clear of all vessels say nothing."""
Beside = Callable[[Line, np.ndarray, float, Volume, Line], float]
"""Tells what noise adds to sections, see `signal_beside`."""


@dataclass(frozen=True, eq=False)
class Profile:
    """Sections of one vessel; grey levels are those above each section's own background.

    Attributes
    ----------
    signal : float array, shape (section,)
        Integral of the grey level over the section, grey levels · cm². Blur and threshold do not change it.
    plateau : float array, shape (section,)
        Mean grey level in the middle.
    spread : float array, shape (2,)
        Mean square distances from the middle along the section's two main axes, weighted by grey level, cm²; NaN if no
        section is free of other vessels.
    slope : float
        Steepest fall of the grey level with the distance from the axis, grey levels per cm.
    run : float array, shape (section,)
        How far along the vessel each section lies, cm.
    rows : int array, shape (section,)
        The points of the vessel's line at which they lie.
    noise : float
        How much a section's signal scatters for noise of one grey level in each voxel, up to a factor, cm².
    rugged : float
        By what share of the radius the outline, as it is along all of the vessel, is neither round nor oval, beyond
        noise; 0 if no section is free of other vessels.
    sampling_blur : float
        Variance of the blur that interpolation between voxels adds at the wall, cm².
    radial : float array, shape (3, bin)
        Distance from the axis, cm; grey level there, the median of the sections' means; its standard error. NaN where
        no section shows it.
    """

    signal: np.ndarray
    plateau: np.ndarray
    spread: np.ndarray
    slope: float
    run: np.ndarray
    rows: np.ndarray
    noise: float = 1.0
    rugged: float = 0.0
    sampling_blur: float = 0.0
    radial: np.ndarray = field(default_factory=lambda: np.empty((3, 0)))


Look = Callable[[Line, np.ndarray, float, Volume, Sequence[Line]], Profile | None]
"""Sums up sections of a vessel, see `profile`."""


def profile(
    line: Line, sections: np.ndarray, radius: float, volume: Volume, neighbors: Sequence[Line] = ()
) -> Profile | None:
    """Return what the `sections` (points of `line`) of a vessel of about `radius` (cm) show; None without sections.

    Directions in which one of the `neighbors` comes into a section are left out together with their opposites.
    """
    if len(sections) == 0:
        return None
    spacing = volume.spacing[0]
    inner, outer = radius + DISC * spacing, radius + RING * spacing
    u, v = across(tangents(line.points, 4)[sections])
    grid = disc(outer, STEP * spacing)
    places = line.points[sections, None] + grid[:, :1] * u[:, None] + grid[:, 1:] * v[:, None]
    grey = sampled(volume.grey, places, volume.origin, spacing)
    rho = np.hypot(*grid.T)
    within, core = rho <= inner, rho <= max(CORE[0] * spacing, radius - CORE[1] * spacing)
    foreign = np.zeros(places.shape[:2], dtype=bool)
    for neighbor in neighbors:
        foreign |= in_tube(places, line.points[sections], neighbor.points, neighbor.radius + CLEARANCE * spacing)
    valid, ring = _seen(grid, within, foreign)
    good = (valid.sum(axis=1) >= MIN_SECTION_SHARE * within.sum()) & ring.any(axis=1)
    if not good.any():
        return None
    background = medians(grey[good], ring[good])
    above, valid = grey[good] - background[:, None], valid[good]
    area = within.sum() * (STEP * spacing) ** 2
    signal = np.maximum((above * valid).sum(axis=1) / valid.sum(axis=1) * area, 0.0)
    is_complete = valid[:, within].all(axis=1)
    complete_sections = above[is_complete]
    spread = (
        _spread(complete_sections[:, within].mean(axis=0), grid[within])
        if len(complete_sections)
        else np.full(2, np.nan)
    )
    bins = (rho / (BIN * spacing)).astype(int)
    steepest = _slope(above, valid, bins, BIN * spacing)
    radial = _radial(above, valid | (ring[good] & (rho > inner)), bins, rho)
    # The integral's own noise, and that of the background's median (π/2 as much as of a mean) over its area.
    noise = np.sqrt(area + np.pi / 2 * area**2 / (np.mean(ring[good].sum(axis=1)) * (STEP * spacing) ** 2))
    plateau = above[:, core].mean(axis=1)
    rows = sections[good]
    rugged = _rugged(complete_sections[:, within], grid[within], _turns(line, rows[is_complete]))
    rim = np.abs(rho - radius) < spacing
    outward = (grid[rim, :1] * u[good][:, None] + grid[rim, 1:] * v[good][:, None]) / rho[rim, None]
    sampling = _sampling_blur((places[good][:, rim] - volume.origin) / spacing, outward) * spacing**2
    return Profile(
        signal, plateau, spread, steepest, line.run[rows], rows, float(noise), rugged, float(sampling), radial
    )


def _seen(grid: np.ndarray, within: np.ndarray, foreign: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which samples count for each section, and which for its background, without `foreign` ones."""
    angle = np.arctan2(grid[:, 1], grid[:, 0]) / (2 * np.pi)
    direction = (np.floor(angle * DIRECTIONS + 0.5) % (DIRECTIONS // 2)).astype(int)
    lost = np.zeros((len(foreign), DIRECTIONS // 2), dtype=bool)
    section, sample = np.nonzero(foreign & within)
    lost[section, direction[sample]] = True
    return within & ~lost[:, direction], ~within & ~foreign


def _spread(weight: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """Return the mean square distances of `grid` from its middle along the main axes, the larger first."""
    weight = np.maximum(weight, 0.0) / max(float(np.maximum(weight, 0.0).sum()), 1e-12)
    away = grid - weight @ grid
    return np.linalg.eigvalsh((away * weight[:, None]).T @ away)[::-1]


def _turns(line: Line, rows: np.ndarray) -> np.ndarray:
    """Return by what angle the sections at `rows` are turned against ones that turn no more than the axis does."""
    axes = tangents(line.points, 4)[rows]
    (u, v), (steady, _) = across(axes), carried(axes)
    return np.arctan2((steady * v).sum(axis=1), (steady * u).sum(axis=1))


def _rugged(levels: np.ndarray, grid: np.ndarray, turns: np.ndarray) -> float:
    """Return `Profile.rugged`: an outline r = R(1 + ε cos nθ) has ∫ g ρ² exp(inθ) dA / ∫ g ρ² dA = 2ε."""
    if len(levels) < MIN_SECTIONS:
        return 0.0
    square = (grid**2).sum(axis=1)
    waves = square[:, None] * np.exp(1j * np.outer(np.arctan2(grid[:, 1], grid[:, 0]), ORDERS))
    sections = levels @ waves * np.exp(-1j * np.outer(turns, ORDERS)) / max(2 * float((levels @ square).mean()), 1e-12)
    mean = sections.mean(axis=0)
    mean[2] -= OVAL * mean[0] ** 2
    squares, noise = np.abs(mean) ** 2, sections.var(axis=0) * SECTIONS_PER_SAMPLE / len(sections)
    is_seen = squares.sum() > MIN_EVIDENCE * noise.sum()  # that it is no circle; what makes it no oval may be little
    return float(np.sqrt(max((squares - noise)[1:].sum(), 0.0))) if is_seen else 0.0


def _sampling_blur(places: np.ndarray, directions: np.ndarray) -> float:
    """Return `Profile.sampling_blur`, voxels²: what lies t from one voxel and 1 - t from the next is their mean, which
    has a variance of t(1 - t) along that axis.
    """
    share = places - np.floor(places)
    return float((directions**2 * share * (1 - share)).sum(axis=-1).mean())


def _slope(above: np.ndarray, valid: np.ndarray, bins: np.ndarray, width: float) -> float:
    """Return the steepest fall of the mean grey level from bin to bin of `width`, grey levels per cm."""
    chosen = np.broadcast_to(bins, above.shape)[valid]
    mean = np.bincount(chosen, above[valid]) / np.maximum(np.bincount(chosen), 1)
    return float(np.max(mean[:-2] - mean[2:], initial=0.0) / (2 * width))


def _radial(above: np.ndarray, valid: np.ndarray, bins: np.ndarray, rho: np.ndarray) -> np.ndarray:
    """Return `Profile.radial`: a neighbor comes into few sections, and the median does not know it."""
    count = int(bins.max()) + 1
    cell = (np.arange(len(above))[:, None] * count + bins)[valid]
    shape = (len(above), count)
    weight = np.bincount(cell, minlength=len(above) * count).reshape(shape)
    total = np.bincount(cell, above[valid], len(above) * count).reshape(shape)
    chosen = weight > 0.5 * weight.max(axis=0)
    mean = total / np.maximum(weight, 1)
    level, spread = np.full(count, np.nan), np.full(count, np.nan)
    for place in np.flatnonzero(chosen.sum(axis=0) >= 2):
        values = mean[chosen[:, place], place]
        level[place], spread[place] = np.median(values), 1.25 * np.std(values) / np.sqrt(len(values))
    distance = np.bincount(bins, rho) / np.maximum(np.bincount(bins), 1)
    return np.array([distance, level, spread])


def signal_beside(line: Line, sections: np.ndarray, radius: float, volume: Volume, vessels: Line) -> float:
    """Return the standard deviation of the mean signal of sections beside a vessel, grey levels · cm²; NaN if unknown.

    It holds whatever the image has of noise: grain of any length, rings that run along a vessel, streaks. The scatter
    of a vessel's own sections does not show what they have in common. `vessels` are the points of all of them; for the
    rest see `profile`.
    """
    spacing = float(volume.spacing[0])
    inner, outer = radius + DISC * spacing, radius + RING * spacing
    rows = sections[:: round(max(SECTION_STEP_VOXELS, radius / (SAMPLES_PER_RADIUS * spacing)))]
    u, v = (axis[rows] for axis in across(tangents(line.points, 4)))
    grid = disc(outer, max(spacing, radius / SAMPLES_PER_RADIUS))
    within = np.hypot(*grid.T) <= inner
    area, means = np.pi * inner**2, []
    for angle in 2 * np.pi * np.arange(COPIES) / COPIES:
        centers = line.points[rows] + (2 * inner + spacing) * (np.cos(angle) * u + np.sin(angle) * v)
        places = centers[:, None] + grid[:, :1] * u[:, None] + grid[:, 1:] * v[:, None]
        voxels = (places - volume.origin) / spacing
        clear = ~in_tube(places, centers, vessels.points, vessels.radius + spacing) & _inside(voxels, volume.grey.shape)
        good = (clear & within).sum(axis=1) >= MIN_CLEAR_SHARE * within.sum()
        if good.sum() < max(0.5 * len(rows), 1) or not (clear[good] & ~within).any(axis=1).all():
            continue
        grey = sampled(volume.grey, places[good], volume.origin, spacing)
        disc_mean = _mean(grey, clear[good] & within)
        background = medians(grey, clear[good] & ~within)
        means.append(float(np.mean(disc_mean - background)) * area)
    return float(np.median(np.abs(means))) / 0.6745 if len(means) >= MIN_COPIES else np.nan


def reach_beside(radius: float, spacing: float) -> float:
    """Return how far from a vessel's axis the walls lie that matter to the sections beside it, cm."""
    return 2 * (radius + DISC * spacing) + spacing + radius + RING * spacing + spacing


def _inside(voxels: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    return np.asarray(((voxels >= 0) & (voxels <= np.array(shape) - 1)).all(axis=-1))


def _mean(values: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    return np.asarray((values * chosen).sum(axis=1) / chosen.sum(axis=1))
