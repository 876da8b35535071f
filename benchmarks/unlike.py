"""Volumes unlike those of `vasowave.datasets.phantom`: vessels that bend, taper, fade, touch and are not round.

Nothing here is shared with that phantom: axes are random curves of given tortuosity, sections are given by their
outline, and every kind of volume breaks one assumption of the extraction. A tree grows in voxels; SPACING makes it cm.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from vasowave.imaging import Volume

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


@dataclass(frozen=True, eq=False)
class Vessel:
    """One tube: points of its axis (z, y, x, voxels), radius at each, and how far the root is at each."""

    axis: np.ndarray
    radius: np.ndarray
    way: np.ndarray
    parent: int
    turn: float = 0.0
    contrast: float = 1.0
    phases: np.ndarray = field(default_factory=lambda: np.zeros(4))

    @property
    def length(self):
        return float(np.linalg.norm(np.diff(self.axis, axis=0), axis=1).sum())


@dataclass(frozen=True, eq=False)
class Made:
    """A volume and what is true of it; lengths in cm, places z, y, x.

    Attributes
    ----------
    ends : float array, shape (vessel, 3)
        Where each vessel ends.
    parent, length, radius : array, shape (vessel,)
        Radius of a circle of the section's mean area, averaged along the vessel.
    root : float array, shape (3,)
        Outer end of the cannula.
    """

    volume: Volume
    ends: np.ndarray
    parent: np.ndarray
    length: np.ndarray
    radius: np.ndarray
    root: np.ndarray

    @property
    def terminals(self):
        return np.setdiff1d(np.arange(len(self.parent)), self.parent)


def make(kind, seed):
    """Return the volume of `kind` with this seed."""
    rng = np.random.default_rng([seed, 77])
    for _ in range(200):
        tree = _grown(kind, rng)
        if tree is not None:
            break
    else:
        raise RuntimeError(f"no tree of kind {kind} for seed {seed}")
    tree, shape = _placed(tree, kind, rng)
    grey, background = _lumen(tree, kind, shape, rng), np.zeros(shape, dtype=np.float32)
    grey = ndimage.gaussian_filter(grey, PSF)
    if kind.motion:
        grey = ndimage.gaussian_filter1d(grey, kind.motion, axis=1)
    background += BACKGROUND + _artefacts(grey, kind, rng)
    grain = ndimage.gaussian_filter(rng.standard_normal(shape, dtype=np.float32), kind.grain)
    grey = background + CONTRAST * grey + np.float32(kind.noise) * grain / grain.std()
    if kind.frame:
        grey = _framed(grey, tree, kind)
    return _made(grey, tree, kind)


def _made(grey, tree, kind):
    own = [vessel for vessel in tree[1:] if vessel.parent != -9]
    length = np.array([vessel.length for vessel in own])
    radius = np.array([_mean(vessel.radius, vessel.axis) for vessel in own])
    spacing = np.array([kind.slices, 1.0, 1.0]) * SPACING
    if kind.slices != 1:
        at = np.arange(0, grey.shape[0] - 1, kind.slices)
        low = np.floor(at).astype(int)
        share = (at - low)[:, None, None].astype(np.float32)
        grey = (1 - share) * grey[low] + share * grey[low + 1]
    ends = np.array([vessel.axis[-1] for vessel in own])
    if kind.view:
        inner = [vessel for row, vessel in enumerate(own) if any(other.parent == row for other in own)]
        least = max(vessel.axis[:, 0].max() + 2 * vessel.radius.max() for vessel in inner)
        last = int(max(grey.shape[0] * (1 - kind.view), least))
        grey = grey[:last]
        ends, length = _seen(own, last - 1, length)
    parent = np.array([vessel.parent for vessel in own])
    volume = Volume(grey, spacing, np.zeros(3))
    return Made(volume, ends * SPACING, parent, length * SPACING, radius * SPACING, tree[0].axis[0] * SPACING)


def _seen(vessels, last, length):
    """Return ends and lengths of vessels that the field of view cuts; inner vessels are never cut."""
    ends, length = [], length.copy()
    for row, vessel in enumerate(vessels):
        out = np.flatnonzero(vessel.axis[:, 0] > last)
        stop = out[0] if len(out) else len(vessel.axis)
        ends.append(vessel.axis[max(stop - 1, 1)])
        length[row] = replace(vessel, axis=vessel.axis[: max(stop, 2)]).length
    return np.array(ends), length


def _mean(values, axis):
    step = np.linalg.norm(np.diff(axis, axis=0), axis=1)
    return float((step * (values[1:] + values[:-1]) / 2).sum() / step.sum())


# Growing: a binary tree with Murray's radii, its axes random curves of given tortuosity.


def _grown(kind, rng):
    """Return the cannula and the vessels, parents first, or None where vessels would touch."""
    start, along = np.zeros(3), np.array([1.0, 0.0, 0.0])
    cannula = np.linspace(-22 * along, start, 45)
    root_radius = CANNULA * rng.uniform(1.18, 1.3)
    vessels = [_vessel(start, along, root_radius, 44.0, -1, 0.0, kind, rng)]
    open_ = [0]
    while len(vessels) < kind.vessels:
        row = max(open_, key=lambda at: vessels[at].radius[-1] * rng.uniform(0.85, 1.15))
        open_.remove(row)
        pair = _fork(vessels, row, kind, rng)
        if pair is None:
            return None
        open_ += [len(vessels), len(vessels) + 1]
        vessels += pair
    tube = Vessel(cannula, np.full(45, CANNULA), np.zeros(45), -2)
    return [tube, *vessels]


def _fork(vessels, row, kind, rng):
    parent = vessels[row]
    before = parent.axis[-1] - parent.axis[-6]
    before /= np.linalg.norm(before)
    share = rng.uniform(0.35, 0.65)
    radii = parent.radius[-1] * np.array([share, 1 - share]) ** (1 / 2.7)
    radii = np.maximum(radii, THINNEST / (1 - kind.taper))
    for _ in range(40):
        aside = np.cross(before, rng.normal(size=3))
        aside /= np.linalg.norm(aside)
        pair = []
        for side, radius, other in ((1, radii[0], radii[1]), (-1, radii[1], radii[0])):
            angle = np.radians(np.clip(rng.normal(38 * 2 * other / radii.sum(), 7), 20, 70))
            way = np.cos(angle) * before + side * np.sin(angle) * aside
            length = radius * rng.uniform(6.5, 12.0)
            pair.append(_vessel(parent.axis[-1], way, radius, length, row, parent.way[-1], kind, rng))
        if all(_clear(one, [*vessels, *pair], row) for one in pair):
            return pair
    return None


def _vessel(start, along, radius, length, parent, way, kind, rng):
    axis = _curve(start, along, length, radius, kind.tortuosity, rng)
    run = np.append(0, np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1)))
    radii = radius * (1 - kind.taper * run / run[-1])
    contrast = float(np.clip(1 + kind.patches * rng.standard_normal(), 0.65, 1.3)) if kind.patches else 1.0
    return Vessel(axis, radii, way + run, parent, rng.uniform(0, np.pi), contrast, rng.uniform(0, 2 * np.pi, 4))


def _curve(start, along, length, radius, tortuosity, rng):
    """Return a smooth random curve whose length over chord is `tortuosity`, bends no tighter than two radii."""
    t = np.linspace(0, 1, 121)
    u = np.cross(along, rng.normal(size=3))
    u /= np.linalg.norm(u)
    frame = np.array([u, np.cross(along, u)])
    waves = max(1.0, min(2.5, length / (5 * radius)))
    shape = sum(
        rng.normal(size=2)[:, None] / order**1.5 * np.sin(np.pi * order * t + rng.uniform(0, 0.4))
        for order in (1, waves, 2 * waves)
    )
    shape -= shape[:, :1] + (shape[:, -1:] - shape[:, :1]) * t
    low, high = 0.0, 2.0
    for _ in range(40):
        size = (low + high) / 2
        curve = np.outer(t, along) + size * shape.T @ frame
        ratio = np.linalg.norm(np.diff(curve, axis=0), axis=1).sum() / np.linalg.norm(curve[-1] - curve[0])
        low, high = (size, high) if ratio < tortuosity else (low, size)
    return start + length * curve


def _clear(vessel, others, row):
    """Whether `vessel` keeps clear of all but its parent and sister, and of these beyond the junction."""
    for number, other in enumerate(others):
        if other is vessel:
            continue
        reach = vessel.radius[0] + other.radius[0] + 2.5
        kin = number == row or other.parent == row
        far = np.linalg.norm(vessel.axis - vessel.axis[0], axis=1) > 1.6 * reach
        points = vessel.axis[far] if kin else vessel.axis
        if len(points) and cKDTree(other.axis).query(points)[0].min() < reach:
            return False
    return vessel.axis[:, 0].min() > -5


def _placed(tree, kind, rng):
    """Return the tree with its extras, moved into a volume, and the volume's shape."""
    tree = _with_extra(tree, kind, rng)
    points = np.concatenate([vessel.axis for vessel in tree])
    low, high = points.min(axis=0) - 14, points.max(axis=0) + 14
    shape = np.ceil(high - low).astype(int) + 1
    tree = [replace(vessel, axis=vessel.axis - low) for vessel in tree]
    return tree, tuple(int(count) for count in shape)


def _with_extra(tree, kind, rng):
    """Return the tree with what does not belong to it (parent -9)."""
    ends = [v for k, v in enumerate(tree) if k > 0 and not any(w.parent == k - 1 for w in tree)]
    if kind.extra in ("touching", "crossing"):
        one = ends[int(rng.integers(len(ends)))]
        at, reach = one.axis[80], one.radius[80]
        across = np.cross(one.axis[84] - one.axis[76], rng.normal(size=3))
        across /= np.linalg.norm(across)
        along = (one.axis[-1] - one.axis[60]) / np.linalg.norm(one.axis[-1] - one.axis[60])
        aside = np.cross(along, across)
        way = across if kind.extra == "crossing" else 0.9 * along + 0.45 * across
        middle = at + aside * (reach + 2.4) * (0.9 if kind.extra == "crossing" else 0.97)
        axis = middle + np.linspace(-24, 24, 121)[:, None] * way
        return [*tree, Vessel(axis, np.full(121, 2.4), np.full(121, one.way[80]), -9)]
    if kind.extra == "anastomosis":
        one, other = sorted(ends, key=lambda v: v.way[-1])[-2:]
        t = np.linspace(0, 1, 121)[:, None]
        bow = 6 * np.sin(np.pi * t) * np.array([1.0, 0, 0])
        axis = one.axis[90] * (1 - t) + other.axis[90] * t + bow
        return [*tree, Vessel(axis, np.full(121, 2.0), np.full(121, one.way[90]), -9)]
    if kind.extra in ("vein", "bone"):
        middle = np.mean([v.axis[60] for v in tree], axis=0)
        aside = rng.normal(size=3) * np.array([0.1, 1, 1])
        aside /= np.linalg.norm(aside)
        radius = 5.0 if kind.extra == "vein" else 9.0
        points = np.concatenate([v.axis for v in tree])
        far = ((points - middle) @ aside).max() + radius + 8
        axis = middle + far * aside + np.linspace(-25, 25, 121)[:, None] * np.array([1.0, 0.15, -0.1])
        return [*tree, Vessel(axis, np.full(121, radius), np.zeros(121), -9, contrast=1.0 if radius < 6 else 2.5)]
    return tree


# Rendering: signed distance from each outline, the nearest vessel's contrast, and what a scanner adds.


def _lumen(tree, kind, shape, rng):
    """Return the contrast of every voxel before blur, 0 to about 1."""
    distance, contrast = np.full(shape, 2.0, dtype=np.float32), np.zeros(shape, dtype=np.float32)
    farthest = max(vessel.way[-1] for vessel in tree)
    for number, vessel in enumerate(tree):
        plain = number == 0 or vessel.parent == -9
        levels = vessel.contrast * (1 - kind.fading * vessel.way / farthest)
        ends = not any(other.parent == number - 1 for other in tree[1:])
        _add(distance, contrast, vessel, levels, replace(kind, aspect=1.0, waves=0.0) if plain else kind, ends)
    return np.clip(0.5 - distance, 0, 1) * contrast


def _add(distance, contrast, vessel, levels, kind, is_end):
    run = np.append(0, np.cumsum(np.linalg.norm(np.diff(vessel.axis, axis=0), axis=1)))
    at = np.linspace(0, run[-1], int(run[-1] / 0.25) + 2)
    axis = np.stack([np.interp(at, run, vessel.axis[:, k]) for k in range(3)], axis=1)
    radius, level = np.interp(at, run, vessel.radius), np.interp(at, run, levels)
    tangent = np.gradient(axis, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    u = _carried(tangent)
    for rows in np.array_split(np.arange(len(axis)), max(1, int(run[-1] / (3 * radius[0])))):
        reach = radius[rows].max() * 1.5 + 3
        low = np.maximum(np.floor(axis[rows].min(axis=0) - reach).astype(int), 0)
        high = np.minimum(np.ceil(axis[rows].max(axis=0) + reach).astype(int) + 1, distance.shape)
        box = tuple(slice(a, b) for a, b in zip(low, high, strict=True))
        voxels = np.stack(np.meshgrid(*map(np.arange, low, high), indexing="ij"), axis=-1).reshape(-1, 3)
        near = rows[cKDTree(axis[rows]).query(voxels)[1]]
        away = voxels - axis[near]
        rho = np.linalg.norm(away, axis=1)
        x, y = (away * u[near]).sum(axis=1), (away * np.cross(tangent[near], u[near])).sum(axis=1)
        value = rho - _outline(np.arctan2(y, x), radius[near], vessel, kind)
        if is_end and rows[-1] == len(axis) - 1:
            value = np.maximum(value, (voxels - axis[-1]) @ tangent[-1])
        if rows[0] == 0 and vessel.parent < 0:
            value = np.maximum(value, -(voxels - axis[0]) @ tangent[0])
        value = value.reshape(distance[box].shape)
        nearer = value < distance[box]
        distance[box][nearer] = value[nearer]
        contrast[box][nearer] = level[near].reshape(value.shape)[nearer]


def _outline(angle, radius, vessel, kind):
    """Return the outline's radius in the directions `angle`; its mean square is that of a circle of `radius`."""
    turned = angle - vessel.turn
    a, b = 1 / np.sqrt(kind.aspect), np.sqrt(kind.aspect)
    shape = a * b / np.hypot(b * np.cos(turned), a * np.sin(turned))
    if kind.waves:
        orders = np.arange(2, 6)
        waves = 1 + kind.waves * np.sin(angle[:, None] * orders + vessel.phases).sum(axis=1) / np.sqrt(2)
        shape = shape * waves / np.sqrt(1 + kind.waves**2)
    # A voxel's share falls linearly over a voxel at the wall, which adds 1/12 to the mean square radius.
    return np.sqrt(np.maximum((radius * shape) ** 2 - 1 / 12, 0.01))


def _carried(tangent):
    """Return a unit vector across each tangent that turns as little as it can along the axis."""
    u = np.cross(tangent[0], np.eye(3)[np.argmin(np.abs(tangent[0]))])
    found = []
    for along in tangent:
        u = u - along * (u @ along)
        u /= np.linalg.norm(u)
        found.append(u)
    return np.array(found)


def _artefacts(lumen, kind, rng):
    """Return what the scanner adds to the background, grey levels."""
    shape = lumen.shape
    y, x = np.indices(shape[1:]) - (np.array(shape[1:])[:, None, None] - 1) / 2
    rho = np.hypot(y, x)
    added = np.zeros(shape, dtype=np.float32)
    if kind.cupping:
        added += (kind.cupping * (rho / rho.max()) ** 2).astype(np.float32)
    if kind.rings:
        profile = ndimage.gaussian_filter1d(rng.standard_normal(int(rho.max()) + 2), 0.7)
        added += (kind.rings * np.interp(rho, np.arange(len(profile)), profile / profile.std())).astype(np.float32)
    if kind.hardening:
        shadow = lumen.sum(axis=2, keepdims=True)
        added -= (kind.hardening * shadow / max(float(shadow.max()), 1e-9)).astype(np.float32)
    return added


def _framed(grey, tree, kind):
    """Return the volume padded by a frame of zeros."""
    width = [int(kind.frame * count) for count in grey.shape]
    for vessel in tree:
        vessel.axis[:] += width
    return np.pad(grey, [(w, w) for w in width])
