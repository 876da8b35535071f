"""Where the blood enters and leaves: whether the places that the user gave can be meant."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import distance_transform_edt, gaussian_filter1d, label
from scipy.spatial import cKDTree

from vasowave.base.cures import VOXEL, SetOption, Visit
from vasowave.base.errors import InputError
from vasowave.base.findings import look_kind, note_kind, warn
from vasowave.lung.axes.paths import MinimalPaths, long_tips, minimal_paths
from vasowave.lung.lumen.segmentation import Segmentation
from vasowave.lung.measure.cannula import NO_CANNULA
from vasowave.lung.measure.contrast import BLUR, own_contrast
from vasowave.lung.measure.profiles import profile
from vasowave.lung.measure.radii import WIDER, densitometric_radius
from vasowave.lung.places import written
from vasowave.lung.read.volume import Volume
from vasowave.lung.tree import Line
from vasowave.pulse.network.network import Network
from vasowave.pulse.network.remarks import unlike_the_species

SCALE_LIMIT = 0.2
"""A cannula that is off by more than this share is no matter of scale: the root or the voxel size is wrong."""

END_RADII, END_VOXELS, SMOOTHING_VOXELS = 6.0, 12, 3.0
"""The end of a vessel is looked at along so many radii, at least so many voxels; its path is smoothed over voxels."""
_NEIGHBORHOOD_RADII = 3.0  # radii around an end within which the lumen is looked at, from half as far
CLEAR_RATIO, MAX_NAMED_ENDS = 0.85, 4
"""An end is clear if the next is narrower than this share of it; so many ends are named."""

ROOT_TAKEN = note_kind(
    "image.root-taken",
    "no root was given: the blood enters at {place} (x,y,z, cm), the one end as wide as the cannula "
    "(radius {radius:.3g} cm)",
)
WIDER_THAN_ROOT = look_kind(
    "image.wider-than-root",
    "vessel {vessel} (radius {radius:.3g} cm) is wider than the root ({root:.3g}): is the root where the blood enters?",
    "Set the root where the blood enters.",
    SetOption("Set the root", "root"),
    Visit("lung"),
)


@dataclass(frozen=True, eq=False)
class Entrance:
    """An end of the lumen where the blood may enter.

    Attributes
    ----------
    place : float array, shape (3,)
        z, y, x, cm, along the image's own axes.
    radius : float
        Of a circle of its sections' area, cm.
    """

    place: np.ndarray
    radius: float


def entrances(lumen: Segmentation, volume: Volume) -> tuple[Entrance, ...]:
    """Return the ends of `lumen`, found in the cubes of `volume`, the one with the widest sections first."""
    start = np.argwhere(lumen.mask)[0] * lumen.spacing + lumen.origin
    tip = int(np.argmax(minimal_paths(lumen, start).travelled))
    paths = minimal_paths(lumen, np.argwhere(lumen.mask)[tip] * lumen.spacing + lumen.origin)  # from an end, not a wall
    inside = cKDTree(paths.points)
    ends = [_entrance(path, volume) for path in _ways_from_ends(paths)]
    ends = [replace(end, place=paths.points[inside.query(end.place)[1]]) for end in ends]
    return tuple(sorted(ends, key=lambda end: -end.radius))


def goes_on(lumen: Segmentation, end: Entrance) -> bool:
    """Whether the lumen goes on to two sides of an end: a ring has such ends where the paths around it meet."""
    middle = np.round((end.place - lumen.origin) / lumen.spacing).astype(int)
    reach = int(np.ceil(_NEIGHBORHOOD_RADII * end.radius / lumen.spacing))
    low = np.maximum(middle - reach, 0)
    window = lumen.mask[tuple(slice(first, last) for first, last in zip(low, middle + reach + 1, strict=True))]
    distance = np.linalg.norm(np.moveaxis(np.indices(window.shape), 0, -1) + low - middle, axis=-1) * lumen.spacing
    pieces, _ = label(window & (distance < _NEIGHBORHOOD_RADII * end.radius))
    piece = pieces == pieces[tuple(middle - low)]
    return bool(label(piece & (distance > 0.5 * _NEIGHBORHOOD_RADII * end.radius))[1] > 1)


def _ways_from_ends(paths: MinimalPaths) -> list[Line]:
    """Return the path from each end of the lumen inward, as long as `END_RADII` says, without stairs."""
    tips, traces = long_tips(paths), []
    for tip in tips:
        rows = [tip]
        while paths.above[rows[-1]] >= 0:
            rows.append(int(paths.above[rows[-1]]))
        traces.append(rows)
    if traces:
        traces.append(traces[0][::-1])  # the end that all paths lead to
    lines = []
    for rows in traces:
        line = Line(paths.points[rows], paths.depth[rows] * paths.spacing)
        wide = float(line.radius[line.run < END_VOXELS * paths.spacing].max())
        line = line[line.run < max(END_RADII * wide, END_VOXELS * paths.spacing)]
        lines.append(Line(gaussian_filter1d(line.points, SMOOTHING_VOXELS, axis=0, mode="nearest"), line.radius))
    return lines


def _entrance(path: Line, volume: Volume) -> Entrance:
    """Return the end at which `path` begins; sections beyond its first ball and before its last say how wide it is."""
    wide, spacing = float(np.median(path.radius)), float(volume.spacing[0])
    inner = np.flatnonzero((path.run > 1.2 * wide) & (path.run < path.run[-1] - 0.3 * wide))
    sections = profile(path, inner, WIDER * wide, volume)
    if sections is None:
        return Entrance(_middle(path, wide, spacing), wide)
    contrast, _ = own_contrast(sections, BLUR * spacing)
    return Entrance(_middle(path, wide, spacing), densitometric_radius(sections, contrast))


def _middle(path: Line, wide: float, spacing: float) -> np.ndarray:
    """Return the middle of the flat end whose corner `path` begins at, a voxel inside."""
    begin, end = (path.points[min(int(np.searchsorted(path.run, radii * wide)), len(path) - 1)] for radii in (1.2, 2.5))
    along = (end - begin) / max(float(np.linalg.norm(end - begin)), 1e-12)
    return np.asarray(begin + along * ((path.points[0] - begin) @ along + spacing))


def clear_entrance(ends: Sequence[Entrance], cannula: float) -> Entrance | None:
    """Return the one end that is as wide as the `cannula` (radius, cm; 0 without one), None if it is not so clear."""
    if not cannula or not ends or abs(np.log(ends[0].radius / cannula)) > np.log1p(SCALE_LIMIT):
        return None
    return ends[0] if len(ends) == 1 or ends[1].radius < CLEAR_RATIO * ends[0].radius else None


def root_wanted(ends: Sequence[Entrance]) -> InputError:
    """Return the error that asks for the root and names the widest ends of the lumen."""
    places = "; ".join(f"{written(end.place)} (radius {end.radius:.2g})" for end in ends[:MAX_NAMED_ENDS])
    return InputError(
        f"where does the blood enter? Give the root as x,y,z in cm: the outer end of the cannula. The widest ends of "
        f"the lumen: {places}"
    )


def deepest_near(lumen: Segmentation, place: np.ndarray, reach: int = 6) -> np.ndarray:
    """Return the point of `lumen` farthest from its wall within `reach` voxels of `place`, z, y, x, cm."""
    low = np.round((place - lumen.origin) / lumen.spacing).astype(int) - reach
    window = tuple(slice(max(a, 0), max(a + 2 * reach + 1, 0)) for a in low)
    mask = np.pad(lumen.mask[window], 1)
    if not mask.any():
        return place
    deepest = np.unravel_index(np.argmax(distance_transform_edt(mask)), mask.shape)
    return (np.array([bounds.start for bounds in window]) + np.array(deepest) - 1) * lumen.spacing + lumen.origin


def require_reached(lumen: Segmentation, outlets: np.ndarray) -> None:
    """Raise `InputError` that names every outlet farther from the lumen than paths are drawn to."""
    voxels = np.argwhere(lumen.mask) * lumen.spacing + lumen.origin
    gap = cKDTree(voxels).query(outlets)[0] / lumen.spacing
    unreached = [f"{written(outlet)} ({voxels:.0f} voxels away)" for outlet, voxels in zip(outlets, gap) if voxels > 5]
    if unreached:
        raise InputError(
            f"{len(unreached)} of {len(outlets)} outlets (x,y,z, cm) do not lie at the lumen: {'; '.join(unreached)}; "
            "move them or lower the threshold"
        )


def wrong_size(network: Network, scale: float, cannula: float, species: str) -> str:
    """Return why the size of the voxels is wrong, and by what factor: by the cannula of that radius (cm; `scale` is its
    known over its measured one), or without one by the root that the species can have. Empty where it may be right.
    """
    if not cannula:
        return unlike_the_species(network, species)
    if abs(np.log(scale)) <= np.log1p(SCALE_LIMIT):
        return ""
    return (
        f"the cannula measures {cannula / scale:.4g} cm instead of {cannula:.4g} (radius): the voxel size is wrong "
        f"(times {scale:.3g} it would be right), or the root is not at the cannula's outer end, or there is no cannula "
        "in the image"
    )


def check_root(network: Network, scale: float, cannula: float, species: str) -> None:
    """Refuse what has a `wrong_size`; warn of a vessel wider than the root."""
    if wrong := wrong_size(network, scale, cannula, species):
        raise InputError(wrong, [NO_CANNULA] if cannula else [VOXEL])
    widest = int(np.argmax(network.radius))
    if network.radius[widest] > 1.15 * network.radius[network.root]:
        radius, root = float(network.radius[widest]), float(network.radius[network.root])
        warn(WIDER_THAN_ROOT(radius=radius, root=root).at(vessel=network.name[widest]), stacklevel=3)
