"""The densitometric radius: the grey level integrated over the cross-section, which hardly knows the threshold."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np

from vasowave.lung.measure.contrast import blur_of, contrasts
from vasowave.lung.measure.edges import Edge, beside_edge, second_edge
from vasowave.lung.measure.evening import Evened, evened_sections, moderated, unevenness
from vasowave.lung.measure.profiles import CLEARANCE, RING, Beside, Look, Profile, profile, signal_beside
from vasowave.lung.read.volume import Volume
from vasowave.lung.tree import Line, Tree, clear_stretches

MODEL = 0.006
"""Relative standard deviation of a radius for what no repetition shows: background, axis, sampling."""
WIDER = 1.25
"""A section that is not round reaches so much farther than its inscribed ball."""
WIDEST = 1.6
"""What is integrated reaches beyond at most so many inscribed radii."""
WINDOW = 0.25
"""Step of the radii beyond which sections reach, voxels."""
EDGE_ERROR, GUESSED_SHARE = 0.008, 0.3
"""Relative standard deviation of a radius that a second step beside the lumen changed; and that of the change, as a
share of it, where other vessels tell it."""


@dataclass(frozen=True, eq=False)
class Densitometry:
    """What the grey levels say of every vessel; NaN for vessels without a free stretch; shape (vessel,).

    Attributes
    ----------
    radius, sd : float array
        Radius of the circle of the section's area, cm, and its standard deviation: sections that differ or noise as it
        is beside the vessel, the error of the contrast, `MODEL`.
    contrast : float array
        Grey level of the lumen above the background.
    relative_contrast : float array
        The same as the vessel's own middle shows it, over that of the tree along the way: below 1 where partly filled.
    aspect : float array
        Small over large half axis of the section.
    taper, taper_sd : float array
        Fall of the radius along the vessel, cm/cm, as its sections show it, and its standard error.
    share : float array
        The radius over that of all that is brighter than the background: below 1 beside walls.
    wall : float array
        Thickness of the vessel's wall, cm; NaN where it is not seen.
    blur : float
        Standard deviation of the blur, cm.
    edge : Edge, optional
        What stands beside the lumen of all vessels.
    uneven : float array
        By what share the sections of a vessel differ beyond noise, or its outline is off a tube's; 0 where they do not.
    hidden_wall : float
        SD of the share by which walls too thin to be told from blur widen all radii; its mean is in `share`.
    """

    radius: np.ndarray
    sd: np.ndarray
    contrast: np.ndarray
    relative_contrast: np.ndarray
    aspect: np.ndarray
    taper: np.ndarray
    taper_sd: np.ndarray
    share: np.ndarray
    wall: np.ndarray
    uneven: np.ndarray
    blur: float
    edge: Edge | None = None
    hidden_wall: float = 0.0

    def of(self, rows: np.ndarray) -> "Densitometry":
        """Return the vessels `rows`."""
        arrays = (entry.name for entry in fields(self) if entry.name not in ("blur", "edge", "hidden_wall"))
        return replace(self, **{name: getattr(self, name)[rows] for name in arrays})

    def times(self, factor: float) -> "Densitometry":
        """Return the same with every length times `factor`."""
        lengths: dict[str, Any] = {name: getattr(self, name) * factor for name in ("radius", "sd", "wall", "blur")}
        return replace(self, **lengths)


def densitometry(
    tree: Tree, volume: Volume, inscribed: np.ndarray, profiler: Look = profile, noise_beside: Beside = signal_beside
) -> Densitometry:
    """Return the radius of every vessel from the area of its sections, ∫(g - background) dA / contrast.

    Blur conserves this integral, so neither blur nor threshold changes it. The contrast is each vessel's, see
    `contrasts`. A first look tells how far the sections have to reach (`windows`): the inscribed radius follows the
    threshold, and what is integrated must not.

    Parameters
    ----------
    tree : Tree
    volume : Volume
    inscribed : float array, shape (vessel,)
        First estimate of the radii, cm.
    profiler : callable
        What looks at the sections of a vessel, as `profile` does.
    noise_beside : callable
        What tells the noise beside a vessel, as `signal_beside` does.
    """
    window = windows(
        densitometric_radii(tree, volume, inscribed, inscribed, profiler), inscribed, float(volume.spacing[0])
    )
    looked = _looked(tree, volume, inscribed, window, profiler)
    noise = [
        np.nan if sections is None else noise_beside(line, sections.rows, reach, volume, tree.line)
        for line, sections, reach in zip(tree.lines, looked.profiles, window, strict=True)
    ]
    sections_evened = [evened if evened is None else evened.sections for evened in looked.evened]
    scatter, uneven = moderated(sections_evened, np.array(noise)), unevenness(sections_evened)
    columns = [
        _measured(*estimates, looked.blur)
        for estimates in zip(looked.evened, scatter, looked.contrast, looked.error, strict=True)
    ]
    radius, sd, relative_contrast, aspect, taper, taper_sd = np.array(columns).T
    same, unknown = np.ones(len(tree)), np.full(len(tree), np.nan)
    shape = relative_contrast, aspect, taper, taper_sd
    sd = np.hypot(sd, uneven * radius)  # where the lumen alone is seen, nobody knows: anywhere along the vessel
    plain = Densitometry(radius, sd, looked.contrast, *shape, same, unknown, uneven, looked.blur)
    return _within_edges(plain, looked.profiles, float(volume.spacing[0]))


def _within_edges(plain: Densitometry, profiles: Sequence[Profile | None], spacing: float) -> Densitometry:
    """Return the radii of the lumen alone, where a wall, or the shadow of a kernel, stands beside it."""
    even_radius = np.where(plain.uneven > 0, np.nan, plain.radius)  # clots, rims and neighbors are no walls of all
    edge, hidden = second_edge(profiles, even_radius, plain.aspect, spacing)
    if edge is None:
        share = np.full(len(profiles), 1 - hidden.widens)
        common_sd = float(np.hypot(hidden.sd, GUESSED_SHARE * hidden.widens))  # haze and wobble make blur grow, too
        return replace(plain, radius=plain.radius * share, sd=plain.sd * share, share=share, hidden_wall=common_sd)
    plain = replace(plain, edge=edge, blur=edge.blur * spacing)
    if edge.kind == "double":
        return plain
    share, wall = np.full(len(profiles), np.nan), np.full(len(profiles), np.nan)
    for row in np.flatnonzero(np.isfinite(plain.radius)).tolist():
        sections = profiles[row]
        fit = beside_edge(sections, float(plain.radius[row]), spacing, edge)
        if fit is not None and sections is not None:
            share[row] = fit[0] / densitometric_radius(sections, float(plain.contrast[row]))
            wall[row] = fit[1] if edge.kind == "wall" else np.nan
    thin_first = np.argsort(plain.radius)
    nearest = share[thin_first][np.isfinite(share[thin_first])][:3]
    guess = float(np.median(nearest)) if len(nearest) else 1 / edge.widens
    error = np.where(np.isfinite(share), EDGE_ERROR, GUESSED_SHARE * abs(guess - 1))
    share = np.where(np.isfinite(share), share, guess)
    sd = plain.radius * share * np.hypot(plain.sd / plain.radius, error)
    # The taper is that of all that is bright: what the area was moved by may move it as much.
    taper_sd = np.hypot(plain.taper_sd, np.abs(plain.taper * (1 / share**2 - 1)))
    return replace(plain, radius=plain.radius * share, sd=sd, taper_sd=taper_sd, share=share, wall=wall)


def densitometric_radii(
    tree: Tree, volume: Volume, inscribed: np.ndarray, window: np.ndarray, profiler: Look = profile
) -> np.ndarray:
    """Return the radius of `densitometry` alone, cm, NaN without sections; sections reach beyond radii of `window`."""
    looked = _looked(tree, volume, inscribed, window, profiler)
    return np.array(
        [
            np.nan if evened is None or not contrast > 0 else densitometric_radius(evened.sections, contrast)
            for evened, contrast in zip(looked.evened, looked.contrast, strict=True)
        ]
    )


class _Looked(NamedTuple):
    """Profiles of all vessels, the same evened, their contrast with its error, and the blur."""

    profiles: list[Profile | None]
    evened: list[Evened | None]
    contrast: np.ndarray
    error: np.ndarray
    blur: float


def _looked(tree: Tree, volume: Volume, inscribed: np.ndarray, window: np.ndarray, profiler: Look) -> _Looked:
    stretches, neighbors = (
        clear_stretches(tree),
        _neighbors(tree, window + (RING + CLEARANCE) * float(volume.spacing[0])),
    )
    profiles = [
        profiler(
            tree.lines[row],
            _clear_points(tree, row, stretches[row], inscribed[row]),
            window[row],
            volume,
            neighbors[row],
        )
        for row in range(len(tree))
    ]
    blur = blur_of(profiles, inscribed, float(volume.spacing[0]))
    contrast, error = contrasts(profiles, _ways(tree), blur)
    middles = [line.length / 2 for line in tree.lines]
    evened = [
        sections if sections is None else evened_sections(sections, middle)
        for sections, middle in zip(profiles, middles, strict=True)
    ]
    return _Looked(profiles, evened, contrast, error, blur)


def windows(radius: np.ndarray, inscribed: np.ndarray, spacing: float) -> np.ndarray:
    """Return the radii from which sections are to reach: `radius`, held to the `inscribed` one where it is far off.

    They come in steps, so that another vessel's edit, which moves every contrast by a hair, leaves them as they were.
    """
    held = np.clip(np.where(np.isfinite(radius), radius, inscribed), inscribed, WIDEST * inscribed)
    return np.asarray(np.ceil(held / (WINDOW * spacing)) * WINDOW * spacing)


def _neighbors(tree: Tree, reach: np.ndarray) -> list[list[Line]]:
    """Return the other vessels that may come within `reach` (cm, by vessel) of each vessel's axis."""
    low, high = (np.array([side(line.points, axis=0) for line in tree.lines]) for side in (np.min, np.max))
    wide = np.array([line.radius.max() for line in tree.lines])[:, None]
    neighbors = []
    for row, distance in enumerate(reach):
        in_reach = ((low - wide <= high[row] + distance) & (high + wide >= low[row] - distance)).all(axis=1)
        in_reach[row] = False
        neighbors.append([tree.lines[neighbor] for neighbor in np.flatnonzero(in_reach)])
    return neighbors


def _clear_points(tree: Tree, row: int, stretch: tuple[float, float], inscribed: float) -> np.ndarray:
    """Return the points of a vessel's line in its clear stretch, away from its ends."""
    line, (begin, end) = tree.lines[row], stretch
    tail = 1.3 * inscribed if row in tree.terminals else 1.5 * line.radius[-1]
    first = max(begin, 1.5 * line.radius[0] + 0.5 * inscribed)
    return np.flatnonzero((line.run > first) & (line.run < min(end, line.length - tail)))


def densitometric_radius(sections: Profile, contrast: float) -> float:
    """Return the radius of the circle of the sections' mean area, cm, for a lumen of `contrast` to its background.

    The mean is that of the middle half: neighbors disturb some sections, noise all.
    """
    cut = len(sections.signal) // 4
    middle = np.sort(sections.signal)[cut : len(sections.signal) - cut]
    return float(np.sqrt(max(middle.mean(), 0.0) / (np.pi * contrast)))


def section_radii(line: Line, volume: Volume) -> np.ndarray:
    """Return the radius of the circle of each section's area along `line`, cm; the contrast is that of all of it."""
    rows = np.arange(len(line))
    sections = profile(line, rows, WIDER * float(np.median(line.radius)), volume)
    if sections is None or len(sections.signal) != len(rows):
        return line.radius
    return np.asarray(np.sqrt(sections.signal / (np.pi * max(float(np.median(sections.plateau)), 1e-9))))


def _measured(evened: Evened | None, scatter: float, contrast: float, error: float, blur: float) -> tuple[float, ...]:
    """Return radius, its standard deviation, the vessel's own plateau over `contrast`, aspect, taper and its error."""
    if evened is None or not contrast > 0:
        return (np.nan,) * 6
    radius = densitometric_radius(evened.sections, contrast)
    differ = scatter / max(float(np.mean(evened.sections.signal)), 1e-12)
    relative = np.sqrt(0.25 * (differ**2 + (error / contrast) ** 2) + evened.error**2 + MODEL**2)
    axis_share = 1 - np.exp(-(radius**2) / (2 * blur**2))
    large, small = evened.sections.spread - blur**2
    aspect = float(np.sqrt(np.clip(small / large, 0, 1))) if large > 0 else np.nan
    plateau = float(np.mean(evened.sections.plateau))
    relative_contrast = plateau / (contrast * max(axis_share, 0.05))
    return radius, radius * float(relative), relative_contrast, aspect, radius * evened.taper, radius * evened.taper_sd


def _ways(tree: Tree) -> np.ndarray:
    """Return the distance from the root of each vessel's middle."""
    begin = np.zeros(len(tree))
    for row, parent in enumerate(tree.parent):
        begin[row] = begin[parent] + tree.lines[parent].length if parent >= 0 else 0.0
    return begin + np.array([line.length / 2 for line in tree.lines])
