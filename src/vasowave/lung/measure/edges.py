"""What lies beside the lumen: walls, or the rings and shadows that a kernel of reconstruction leaves.

The mean grey level by the distance from the axis is a step that blur rounds. A wall of soft tissue is a second, lower
step at a distance that grows with the vessel; a kernel that sharpens leaves a shadow, and a wrong center of rotation
two edges, at a distance that all vessels share.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy.optimize import OptimizeResult, least_squares
from scipy.special import i0e

from vasowave.lung.measure.profiles import Profile


@dataclass(frozen=True)
class EdgeRules:
    """When a second step beside the lumen is believed; lengths in voxels, levels as shares of the contrast.

    Attributes
    ----------
    max_vessels, min_sections, min_bins, min_radius, min_thin_radius
        The widest vessels tell of all, each with so many sections and distances and so wide; a thinner one, down to the
        last radius, is then looked at by itself.
    inside, outside : float
        How far from the wall the profile is looked at.
    level_error : float
        Of a mean level, beside what noise explains: sections are not quite round, nor blur quite normal.
    core_depth, core_error : float
        So deep within the wall a mean level errs by this share of the scatter of the sections' plateaus, too: clots,
        bubbles and mixing change it, and not the edge.
    max_misfit, gross_misfit : float
        Mean squared misfit, variances, up to which one step explains the profiles; and from which a kernel may.
    min_gain, min_evidence : float
        A second step has to reduce chi² by so much, and by this factor too where it is no wall that explains all.
    min_shared : float
        And by so much without the vessel that shows it most, of three or more: clots dim few vessels, walls are of all.
    max_remaining : float
        Mean squared misfit, variances, of profiles that are explained: those of calcified rims are not.
    min_wall, max_wall : float
        Levels of soft tissue beside agent: 0.22 in an air-filled lung, more where agent is thin. What is brighter is
        a wall only if widths that grow with the vessels explain it better, by the gain, than one width of all.
    min_double : float
        What is fainter at one width of all vessels is the foot that a filter leaves beside an edge.
    min_shadow, max_shadow : float
        A shadow as deep is one of a kernel; a deeper one is of what lies beside the vessel, as fat or air.
    level_spread, width_spread, blur_spread : float
        Relative SD of a vessel's level, of its wall over the radius, and of its blur, about those of all vessels.
    hidden_level, hidden_widths
        Walls of this level and so many radii, from none to the first that never hides in blur.
    hidden_chance : float
        That a tree has such walls, before its vessels are looked at; all widths are as likely.
    brighter : float
        What so thin walls widen radii by, over what they do at that level: they may be as bright as 0.4.
    max_hidden_vessels, min_hidden_radius
        So many vessels tell of them, and so wide: thin ones show the blur without a wall.
    blur_error, noise_factor : float
        Of a vessel's blur, as a share of its variance; sections share their noise, which errors of levels do not know.
    step, blur_reach : float
        Of integrals over the distance from the axis, voxels; and how far they go, SD of the blur.
    """

    max_vessels: int = 6
    min_sections: int = 4
    min_bins: int = 10
    min_radius: float = 3.0
    min_thin_radius: float = 2.0
    inside: float = 5.0
    outside: float = 5.5
    level_error: float = 0.002
    core_depth: float = 2.5
    core_error: float = 0.7
    max_misfit: float = 0.25
    gross_misfit: float = 2.0
    min_gain: float = 1.3
    min_evidence: float = 15.0
    min_shared: float = 6.0
    max_remaining: float = 1.25
    min_wall: float = 0.06
    max_wall: float = 0.34
    min_double: float = 0.12
    min_shadow: float = 0.03
    max_shadow: float = 0.2
    level_spread: float = 0.03
    width_spread: float = 0.25
    blur_spread: float = 0.1
    hidden_level: float = 0.25
    hidden_widths: tuple[float, ...] = (0.0, 0.05, 0.1, 0.15, 0.2, 0.3)
    hidden_chance: float = 0.4
    brighter: float = 1.2
    max_hidden_vessels: int = 12
    min_hidden_radius: float = 2.5
    blur_error: float = 0.01
    noise_factor: float = 1.7
    step: float = 0.2
    blur_reach: float = 6.0


RULES = EdgeRules()


class Edge(NamedTuple):
    """The second step beside the lumen of all vessels.

    Attributes
    ----------
    level : float
        Over the contrast of the lumen; negative of a shadow.
    width : float
        Over the radius if `grows`, else voxels.
    grows : bool
        Whether it is as wide as the vessel's radius says, as walls are.
    blur : float
        SD of the blur, voxels.
    """

    level: float
    width: float
    grows: bool
    blur: float

    @property
    def kind(self) -> Literal["wall", "shadow", "double"]:
        """Soft tissue beside the lumen, the shadow of a kernel that sharpens, or what is neither."""
        if self.level < 0:
            return "shadow"
        return "wall" if self.grows else "double"

    @property
    def widens(self) -> float:
        """By what factor the radius of lumen and wall, as grey levels sum up, exceeds the lumen's."""
        return float(np.sqrt(1 + self.level * ((1 + self.width) ** 2 - 1))) if self.grows else 1.0


class _Bins(NamedTuple):
    """Mean profile of one vessel: distance from the axis, level, its error; radius to begin with; lengths in voxels."""

    distance: np.ndarray
    level: np.ndarray
    error: np.ndarray
    radius: float
    contrast: float


class HiddenWall(NamedTuple):
    """Walls that are too thin to be told from blur: by what share they widen all radii, and the SD of that."""

    widens: float = 0.0
    sd: float = 0.0


def second_edge(
    profiles: Sequence[Profile | None], radius: np.ndarray, aspect: np.ndarray, spacing: float
) -> tuple[Edge | None, HiddenWall]:
    """Return what stands beside the lumen of the widest vessels, None where one rounded step explains their profiles;
    and then the walls that hide in that step.

    Parameters
    ----------
    profiles : sequence of Profile or None
    radius : float array, shape (vessel,)
        To begin with, cm.
    aspect : float array, shape (vessel,)
        Least over greatest width of the sections.
    spacing : float
        Voxel size, cm.
    """
    min_radius = min(RULES.min_radius, RULES.min_hidden_radius) * spacing
    widest = [row for row in np.argsort(-np.nan_to_num(radius)).tolist() if radius[row] >= min_radius]
    shown = ((row, _bins(profiles[row], float(radius[row]), spacing)) for row in widest)
    bins = {row: vessel for row, vessel in shown if vessel is not None}
    wide = [vessel for vessel in bins.values() if vessel.radius >= RULES.min_radius][: RULES.max_vessels]
    if not wide:
        return None, HiddenWall()
    if edge := _edge(wide, _fitted(wide, None)):
        return edge, HiddenWall()
    rows = list(bins)[: RULES.max_hidden_vessels]
    sampling = [sections.sampling_blur / spacing**2 for row in rows if (sections := profiles[row]) is not None]
    return None, _hidden([bins[row] for row in rows], np.nan_to_num(aspect[rows], nan=1.0), np.array(sampling))


def _hidden(vessels: Sequence[_Bins], aspect: np.ndarray, sampling: np.ndarray) -> HiddenWall:
    """Return what walls widen radii by, the mean over no wall and all widths by their chances; and its SD with a wall.

    A wall makes the step smoother, the more the wider the vessel; the image's blur is the same for all. Sections that
    are not round (`aspect`), and their `sampling` (variance, voxels²), blur the step too, and are known.
    """
    fits = [_fitted(vessels, None, second_step=(RULES.hidden_level, width)) for width in RULES.hidden_widths]
    plain, widths = fits[0], np.array(RULES.hidden_widths)
    errors = np.sqrt(np.diag(np.linalg.pinv(plain.jac.T @ plain.jac))[1::4])
    excess = []
    for fit in fits:
        radius, blur = fit.x[0::4], fit.x[1::4]
        variance = blur**2 - (radius * (1 - aspect) / (1 + aspect)) ** 2 / 2 - sampling
        sd = np.hypot(RULES.noise_factor * 2 * plain.x[1::4] * errors, RULES.blur_error * blur**2)
        off = (variance - np.average(variance, weights=sd**-2)) / sd
        count = len(vessels)  # few vessels hardly show how much their blur scatters: Student's t
        scatter = count * np.log1p((off**2).sum() / max(count - 1, 1))
        excess.append(2 * fit.cost / RULES.noise_factor**2 + scatter)
    fine = np.linspace(0, widths[-1], 61)
    chance = np.exp(-np.interp(fine**2, widths**2, np.array(excess) - excess[0]) / 2)
    wider = np.interp(fine, widths, [1 - np.median(fit.x[0::4] / plain.x[0::4]) for fit in fits])
    odds = RULES.hidden_chance / (1 - RULES.hidden_chance) * chance.mean()
    widens = float(odds / (1 + odds) * np.average(wider, weights=chance))
    off_sd = np.sqrt(np.average((RULES.brighter * wider - widens) ** 2, weights=chance))
    return HiddenWall(widens, float(off_sd))


def _edge(vessels: Sequence[_Bins], plain: OptimizeResult) -> Edge | None:
    """Return the second step of the `vessels`, None where the fit of a `plain` one explains them."""
    misfit = 2 * plain.cost / sum(len(vessel.level) for vessel in vessels)
    if misfit < RULES.max_misfit:
        return None
    starts = [
        (True, (0.2, 0.3)),
        *([(True, (0.5, 0.3)), (False, (-0.1, 2.5)), (False, (0.4, 2.5))] if misfit > RULES.gross_misfit else []),
    ]
    fits = sorted(
        ((grows, _fitted(vessels, Edge(*start, grows, 1.0))) for grows, start in starts),
        key=lambda pair: pair[1].cost,
    )
    grows, best = fits[0]
    level, width = best.x[:2]
    remaining = misfit * best.cost / plain.cost
    explains = grows and level > 0 and remaining < RULES.max_remaining
    gains = np.add.reduceat(plain.fun**2 - best.fun**2, np.cumsum([0, *(len(vessel.level) for vessel in vessels[:-1])]))
    shared = gains.sum() - gains.max() if len(gains) > 2 else gains.sum()
    has_evidence = gains.sum() > RULES.min_evidence and shared > RULES.min_shared
    is_seen = has_evidence and (explains or best.cost * RULES.min_gain < plain.cost)
    if not is_seen or level < -RULES.max_shadow:
        return None
    if -RULES.min_shadow < level < (RULES.min_wall if grows else RULES.min_double):
        return None
    unlike = all(fit.cost > RULES.min_gain * best.cost for law, fit in fits if not law)
    is_wall = bool(grows and (level <= RULES.max_wall or (len(fits) > 1 and unlike)))
    if grows and not is_wall:
        width *= float(np.median(best.x[2::4]))  # radii, voxels
    return Edge(float(level), float(width), is_wall, float(np.median(best.x[3::4])))


def beside_edge(sections: Profile | None, radius: float, spacing: float, edge: Edge) -> tuple[float, float] | None:
    """Return radius and width of the second step of one vessel, cm, drawn to what all vessels show.

    None where the profile does not show them.
    """
    bins = _bins(sections, radius, spacing) if radius >= RULES.min_thin_radius * spacing else None
    if bins is None:
        return None
    width, size = _fitted([bins], edge, drawn=True).x[1:3]
    return float(size) * spacing, float(width * size if edge.grows else width) * spacing


def _bins(sections: Profile | None, radius: float, spacing: float) -> _Bins | None:
    if sections is None or len(sections.signal) < RULES.min_sections:
        return None
    distance, level, error = sections.radial
    distance, size = distance / spacing, radius / spacing
    in_reach = (distance > size - RULES.inside) & (distance < size + RULES.outside) & np.isfinite(level)
    contrast = float(np.median(sections.plateau))
    if in_reach.sum() < RULES.min_bins or not contrast > 0:
        return None
    core = np.where(distance < size - RULES.core_depth, RULES.core_error * np.std(sections.plateau), 0.0)
    error = np.hypot(np.hypot(error, RULES.level_error * contrast), core)
    return _Bins(distance[in_reach], level[in_reach], error[in_reach], size, contrast)


def _fitted(
    vessels: Sequence[_Bins], edge: Edge | None, drawn: bool = False, second_step: tuple[float, float] = (0.0, 0.0)
) -> OptimizeResult:
    """Return SciPy's fit of level and width of the second step, then of radius, blur, contrast and background of each
    vessel. Without an `edge`, with which it begins, without the first two: of one step alone, or with a wall of the
    level and width of `second_step`; `drawn`, a vessel's numbers are drawn to it.
    """
    grows, shared = edge is None or edge.grows, slice(2 if edge is None else 0, None)
    begin, lowest, highest, scale = (values[shared] for values in _bounds(vessels, edge))
    ends = np.cumsum([0, *(len(bins.level) for bins in vessels)])
    places, values, spread = _drawn_to(edge) if drawn and edge is not None else (np.zeros(0, dtype=int), 0.0, 1.0)

    def evaluated(unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x = unknowns if edge is not None else np.concatenate([second_step, unknowns])
        residual, jacobian = np.zeros(ends[-1]), np.zeros((ends[-1], len(x)))
        for index, bins in enumerate(vessels):
            rows, columns = slice(ends[index], ends[index + 1]), slice(2 + 4 * index, 6 + 4 * index)
            model, common, single = _modeled(bins, x[:2], x[columns], grows)
            residual[rows] = (model - bins.level) / bins.error
            jacobian[rows, :2], jacobian[rows, columns] = common / bins.error[:, None], single / bins.error[:, None]
        prior = np.eye(len(x))[places] / np.reshape(spread, (-1, 1))
        return np.append(residual, (x[places] - values) / spread), np.vstack([jacobian, prior])[:, shared]

    return least_squares(lambda x: evaluated(x)[0], begin, lambda x: evaluated(x)[1], (lowest, highest), x_scale=scale,
                         max_nfev=40, ftol=1e-4)  # fmt: skip


def _bounds(vessels: Sequence[_Bins], edge: Edge | None) -> list[np.ndarray]:
    """Return begin, least and greatest value, and scale of all unknowns."""
    grows = edge is not None and edge.grows
    start = (0.0, 0.5) if edge is None else (edge.level, edge.width)
    low, high = ((-0.4, 0.05), (0.7, 1.0)) if grows else ((-0.4, 0.5), (0.7, 4.0))
    begin = [(bins.radius, 0.9, bins.contrast, 0.0) for bins in vessels]
    lower = [(0.5 * bins.radius, 0.4, 0.3 * bins.contrast, -0.5 * bins.contrast) for bins in vessels]
    upper = [(1.5 * bins.radius, 3.0, 3.0 * bins.contrast, 0.5 * bins.contrast) for bins in vessels]
    scales = (0.1, 0.1 if grows else 1.0), [(0.1, 0.1, 5.0, 1.0)] * len(vessels)
    pairs = ((np.clip(start, np.add(low, 1e-6), np.subtract(high, 1e-6)), begin), (low, lower), (high, upper), scales)
    return [np.concatenate([shared, np.ravel(single)]) for shared, single in pairs]


def _drawn_to(edge: Edge) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return places among the unknowns of one vessel, values and SD of level, width and blur."""
    values = np.array([edge.level, edge.width, edge.blur])
    shares = (RULES.level_spread, RULES.width_spread if edge.grows else RULES.level_spread, RULES.blur_spread)
    return np.array([0, 1, 3]), values, np.abs(values) * shares


def _modeled(
    bins: _Bins, step: np.ndarray, vessel: np.ndarray, grows: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the levels of a vessel, and how they change with the shared and with its own numbers."""
    (level, width), (radius, sigma, contrast, background) = step, vessel
    outer = radius * (1 + width) if grows else radius + width
    disc, rim = _blurred(bins, sigma, radius)
    wide, outer_rim = _blurred(bins, sigma, outer) if level else (disc, rim)
    shape = (1 - level) * disc + level * wide
    softer = (1 - level) * _blurred(bins, sigma + 0.01, radius)[0]
    if level:
        softer += level * _blurred(bins, sigma + 0.01, outer)[0]
    outward, sideways = ((1 + width), radius) if grows else (1.0, 1.0)
    shared = np.column_stack([contrast * (wide - disc), contrast * level * sideways * outer_rim])
    moved = contrast * ((1 - level) * rim + level * outward * outer_rim)
    single = np.column_stack([moved, contrast * (softer - shape) / 0.01, shape, np.ones_like(shape)])
    return background + contrast * shape, shared, single


def _blurred(bins: _Bins, sigma: float, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a disc of height 1 and `radius`, blurred by `sigma`, at the distances of `bins`; and its change by radius.

    A ring at s gives (s/σ²) exp(-(s² + ρ²)/2σ²) I0(sρ/σ²) at ρ; rings well within the nearest bin give nothing.
    """
    distance = bins.distance[:, None]
    nearest = min(max(0.0, float(bins.distance[0]) - RULES.blur_reach * sigma), 0.9 * radius)
    steps = max(int(np.ceil((radius - nearest) / RULES.step)), 2)
    edges = np.linspace(nearest, radius, steps + 1)
    middles = np.append((edges[1:] + edges[:-1]) / 2, radius)
    density = middles / sigma**2 * np.exp(-((middles - distance) ** 2) / (2 * sigma**2))
    density = density * i0e(middles * distance / sigma**2)
    return density[:, :-1].sum(axis=1) * (edges[1] - edges[0]), density[:, -1]
