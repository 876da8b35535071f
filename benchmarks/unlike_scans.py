"""A tree as a scanner shows it: signed distance from each outline, the nearest vessel's contrast, and artefacts."""

from dataclasses import replace

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree


def lumen_of(tree, kind, shape, rng):
    """Return the contrast of every voxel before blur, 0 to about 1."""
    distance, contrast = np.full(shape, 2.0, dtype=np.float32), np.zeros(shape, dtype=np.float32)
    farthest = max(vessel.way[-1] for vessel in tree)
    for number, vessel in enumerate(tree):
        plain = number == 0 or vessel.parent == -9
        levels = vessel.contrast * (1 - kind.fading * vessel.way / farthest)
        ends = not any(other.parent == number - 1 for other in tree[1:])
        _add(distance, contrast, vessel, levels, replace(kind, aspect=1.0, waves=0.0) if plain else kind, ends)
    lumen = np.clip(0.5 - distance, 0, 1) * contrast
    if kind.metal:
        _brighten(lumen, tree[0])
    for _ in range(kind.bubbles):
        _add_bubble(lumen, tree, rng)
    if kind.settled:
        lumen *= (1 - kind.settled * np.linspace(1, 0, shape[1], dtype=np.float32))[:, None]
    return lumen


def _brighten(lumen, cannula):
    """Make the cannula four times as bright as the agent."""
    places = np.argwhere(lumen > 0)
    near = cKDTree(cannula.axis).query(places)[0] < cannula.radius[0] + 1
    near &= places[:, 0] <= cannula.axis[-1, 0]  # whose axis begins at the border of the volume
    lumen[tuple(places[near].T)] *= 4


def _add_bubble(lumen, tree, rng):
    """Put a bubble of air into one of the vessels that are wider than most."""
    own = [vessel for vessel in tree[1:] if vessel.parent != -9]
    wide = [vessel for vessel in own if vessel.radius[60] >= np.median([one.radius[60] for one in own])]
    vessel = wide[int(rng.integers(len(wide)))]
    at = int(rng.integers(30, 90))
    radius = rng.uniform(0.5, 0.9) * vessel.radius[at]
    places = np.argwhere(lumen > 0)
    away = np.linalg.norm(places - vessel.axis[at], axis=1) - radius
    lumen[tuple(places.T)] *= np.clip(away + 0.5, 0, 1)


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
        angle = np.arctan2(y, x) - kind.twist * near / len(axis)
        value = rho - _outline(angle, radius[near], vessel, kind)
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


def artefacts(lumen, kind, rng):
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
    if kind.slope:
        added += np.linspace(-0.5, 0.5, shape[0], dtype=np.float32)[:, None, None] * np.float32(kind.slope)
    if kind.streaks:
        angle = np.arctan2(y, x)
        beams = sum(np.cos(order * angle + rng.uniform(0, 6)) for order in (9, 14, 23))
        added += (kind.streaks * beams * np.exp(-rho / rho.max())).astype(np.float32)
    if kind.metal:
        added += kind.metal * _bands(lumen, rho.max())
    if kind.hardening:
        shadow = lumen.sum(axis=2, keepdims=True)
        added -= (kind.hardening * shadow / max(float(shadow.max()), 1e-9)).astype(np.float32)
    return added


def _bands(lumen, farthest):
    """Return bright and dark bands around what is brighter than the agent, in its own slices."""
    found = np.zeros(lumen.shape, dtype=np.float32)
    for z in np.flatnonzero((lumen > 2).any(axis=(1, 2))):
        middle = np.argwhere(lumen[z] > 2).mean(axis=0)
        y, x = np.indices(lumen.shape[1:]) - middle[:, None, None]
        found[z] = np.cos(7 * np.arctan2(y, x)) * np.exp(-2 * np.hypot(y, x) / farthest)
    return found


def displaced(grey, kind, rng):
    """Return the volume as it is seen of an animal, or on a table, that moved once."""
    if kind.ghost:
        aside = np.round(rng.uniform(5, 9) * np.array([0.3, *_direction(rng)])).astype(int)
        grey = np.maximum(grey, kind.ghost * np.roll(grey, aside, axis=(0, 1, 2)))
    if kind.table:
        first = int(grey.shape[0] * rng.uniform(0.35, 0.65))
        aside = np.round(kind.table * _direction(rng)).astype(int)
        grey = np.concatenate([grey[:first], np.roll(grey[first:], aside, axis=(1, 2))])
    return grey


def _direction(rng):
    angle = rng.uniform(0, 2 * np.pi)
    return np.array([np.cos(angle), np.sin(angle)])


def framed(grey, tree, kind):
    """Return the volume padded by a frame of zeros."""
    width = [int(kind.frame * count) for count in grey.shape]
    for vessel in tree:
        vessel.axis[:] += width
    return np.pad(grey, [(w, w) for w in width])
