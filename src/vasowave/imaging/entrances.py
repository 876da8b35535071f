"""Where the blood enters and leaves: whether the places that the user gave can be meant."""

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from vasowave.errors import InputError
from vasowave.findings import look_kind, warn
from vasowave.imaging.axes.paths import long_tips, minimal_paths, paths_to
from vasowave.imaging.lumen.segmentation import Segmentation
from vasowave.imaging.places import written
from vasowave.network.network import Network
from vasowave.network.remarks import unlike_the_species

SCALE_LIMIT = 0.2
"""A cannula that is off by more than this share is no matter of scale: the root or the voxel size is wrong."""

WIDER_THAN_ROOT = look_kind(
    "image.wider-than-root",
    "vessel {vessel} (radius {radius:.3g} cm) is wider than the root ({root:.3g}): is the root where the blood enters?",
    "Set the root with `root` or an edit.",
)


def root_wanted(lumen: Segmentation) -> InputError:
    """Return the error that asks for the root and names the widest ends of the lumen."""
    start = np.argwhere(lumen.mask)[0] * lumen.spacing + lumen.origin
    ways = minimal_paths(lumen, start)
    paths = paths_to(ways, long_tips(ways))
    inner = np.zeros(len(paths.above), dtype=bool)
    inner[paths.above[paths.above >= 0]] = True
    ends = []
    for tip in np.flatnonzero(~inner | (paths.above < 0)):
        ball = np.linalg.norm(paths.line.points - paths.line.points[tip], axis=1) < 12 * lumen.spacing
        ends.append((float(np.median(paths.line.radius[ball])), tip))
    ends.sort(reverse=True)
    places = "; ".join(f"{written(paths.line.points[tip])} (radius {radius:.2g})" for radius, tip in ends[:4])
    return InputError(
        f"where does the blood enter? Give the root as x,y,z in cm: the outer end of the cannula. The widest ends of "
        f"the lumen: {places}"
    )


def deepest_near(lumen: Segmentation, place: np.ndarray, reach: int = 6) -> np.ndarray:
    """Return the point of `lumen` farthest from its wall within `reach` voxels of `place`, z, y, x, cm."""
    low = np.round((place - lumen.origin) / lumen.spacing).astype(int) - reach
    window = tuple(slice(max(a, 0), max(a + 2 * reach + 1, 0)) for a in low)
    near = np.pad(lumen.mask[window], 1)
    if not near.any():
        return place
    deepest = np.unravel_index(np.argmax(distance_transform_edt(near)), near.shape)
    return (np.array([one.start for one in window]) + np.array(deepest) - 1) * lumen.spacing + lumen.origin


def require_reached(lumen: Segmentation, outlets: np.ndarray) -> None:
    """Raise `InputError` that names every outlet farther from the lumen than paths are drawn to."""
    voxels = np.argwhere(lumen.mask) * lumen.spacing + lumen.origin
    gap = cKDTree(voxels).query(outlets)[0] / lumen.spacing
    far = [f"{written(outlet)} ({voxels:.0f} voxels away)" for outlet, voxels in zip(outlets, gap) if voxels > 5]
    if far:
        raise InputError(
            f"{len(far)} of {len(outlets)} outlets (x,y,z, cm) do not lie at the lumen: {'; '.join(far)}; move them or "
            "lower the threshold"
        )


def check_root(network: Network, scale: float, cannula: float, species: str) -> None:
    """Refuse a wrong cannula, or without one a root that the species cannot have; warn of a vessel wider than it."""
    if not cannula and (wrong := unlike_the_species(network, species)):
        raise InputError(wrong)
    if cannula and abs(np.log(scale)) > np.log1p(SCALE_LIMIT):
        measured = cannula / scale
        raise InputError(
            f"the cannula measures {measured:.4g} cm instead of {cannula:.4g} (radius): the voxel size "
            "is wrong, or the root is not at the cannula's outer end, or there is no cannula in the image"
        )
    widest = int(np.argmax(network.radius))
    if network.radius[widest] > 1.15 * network.radius[network.root]:
        radius, root = float(network.radius[widest]), float(network.radius[network.root])
        warn(WIDER_THAN_ROOT(radius=radius, root=root).at(vessel=network.name[widest]), stacklevel=3)
