"""Random trees: Murray's radii, axes that are random curves of given tortuosity, and what lies beside them."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial import cKDTree

from unlike_kinds import CANNULA


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


def grown(kind, rng):
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
        open_ += range(len(vessels), len(vessels) + len(pair))
        vessels += pair
    vessels = [
        replace(vessel, contrast=vessel.contrast * _filling(vessels, row, kind)) for row, vessel in enumerate(vessels)
    ]
    tube = Vessel(cannula, np.full(45, CANNULA), np.zeros(45), -2)
    return [tube, *vessels]


def _filling(vessels, row, kind):
    """Return how much of the contrast the vessel `row` has: what lies beyond the root's first daughter has less."""
    while vessels[row].parent > 0:
        row = vessels[row].parent
    return kind.filling if row == 1 else 1.0


def _fork(vessels, row, kind, rng):
    parent = vessels[row]
    before = parent.axis[-1] - parent.axis[-6]
    before /= np.linalg.norm(before)
    share = rng.uniform(0.35, 0.65)
    radii = parent.radius[-1] * np.array([share, 1 - share]) ** (1 / 2.7)
    radii = np.maximum(radii, kind.thinnest / (1 - kind.taper) / (1 - kind.step))
    for _ in range(40):
        aside = np.cross(before, rng.normal(size=3))
        aside /= np.linalg.norm(aside)
        pair = []
        for side, radius, other in ((1, radii[0], radii[1]), (-1, radii[1], radii[0])):
            angle = np.radians(np.clip(rng.normal(38 * 2 * other / radii.sum(), 7), 20, 70))
            way = np.cos(angle) * before + side * np.sin(angle) * aside
            length = radius * rng.uniform(6.5, 12.0)
            pair.append(_vessel(parent.axis[-1], way, radius, length, row, parent.way[-1], kind, rng))
        if row == 0 and kind.daughters == 3:
            radius = radii.min()
            way = before + 0.15 * rng.normal(size=3)
            length = radius * rng.uniform(6.5, 12.0)
            pair.append(
                _vessel(parent.axis[-1], way / np.linalg.norm(way), radius, length, row, parent.way[-1], kind, rng)
            )
        if all(_clear(one, [*vessels, *pair], row) for one in pair):
            return pair
    return None


def _vessel(start, along, radius, length, parent, way, kind, rng):
    axis = _axis(start, along, length, radius, kind, rng)
    run = np.append(0, np.cumsum(np.linalg.norm(np.diff(axis, axis=0), axis=1)))
    radii = radius * (1 - kind.taper * run / run[-1])
    from_middle = run - run[-1] / 2
    radii *= 1 - kind.step / (1 + np.exp(-4 * from_middle / radius))
    radii *= 1 - kind.stenosis * np.exp(-((from_middle / radius) ** 2))
    contrast = float(np.clip(1 + kind.patches * rng.standard_normal(), 0.65, 1.3)) if kind.patches else 1.0
    return Vessel(axis, radii, way + run, parent, rng.uniform(0, np.pi), contrast, rng.uniform(0, 2 * np.pi, 4))


def _axis(start, along, length, radius, kind, rng):
    """Return the axis of a vessel by its kind: a random curve as it comes, one with tight bends, or arcs."""
    if kind.arcs:
        return _arcs(start, along, length, radius, kind, rng)
    if not kind.bend:
        waves = max(1.0, min(2.5, length / (5 * radius)))
        return _curve(start, along, length, kind.tortuosity, waves, rng)
    curves = [
        _curve(start, along, length, kind.tortuosity, waves, rng)
        for waves in np.geomspace(0.7, 5, 12)
        for _ in range(4)
    ]
    return min(curves, key=lambda one: abs(np.log(_tightest(one) / (kind.bend * radius))))


def _tightest(axis):
    """Return the least radius of curvature of `axis`, without its ends."""
    tangent = np.gradient(axis, axis=0)
    step = np.linalg.norm(tangent, axis=1)
    turn = np.linalg.norm(np.gradient(tangent / step[:, None], axis=0), axis=1) / step
    return 1 / turn[6:-6].max()


def _arcs(start, along, length, radius, kind, rng):
    """Return straight pieces with arcs of `kind.bend` radii between them, in random planes, by turns to and fro."""
    count, fine = int(rng.integers(2, 4)), 600
    middles = (np.arange(count) + rng.uniform(0.25, 0.75, count)) / count * length
    planes = [np.cross(along, rng.normal(size=3)) for _ in range(count)]
    planes = [(-1) ** k * plane / np.linalg.norm(plane) for k, plane in enumerate(planes)]
    at = (np.arange(fine) + 0.5) / fine * length
    low, high = 0.0, 2.4
    for _ in range(30):
        angle = (low + high) / 2
        tangent, points = along / np.linalg.norm(along), [start]
        for run in at:
            for middle, plane in zip(middles, planes, strict=True):
                if abs(run - middle) < angle * kind.bend * radius / 2:
                    tangent = tangent + np.cross(plane, tangent) * length / fine / (kind.bend * radius)
                    tangent = tangent / np.linalg.norm(tangent)
            points.append(points[-1] + tangent * length / fine)
        ratio = length / np.linalg.norm(points[-1] - start)
        low, high = (angle, high) if ratio < kind.tortuosity else (low, angle)
    return np.array(points)[::5]


def _curve(start, along, length, tortuosity, waves, rng):
    """Return a smooth random curve whose length over chord is `tortuosity`."""
    t = np.linspace(0, 1, 121)
    u = np.cross(along, rng.normal(size=3))
    u /= np.linalg.norm(u)
    frame = np.array([u, np.cross(along, u)])
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


def placed(tree, kind, rng):
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
    if kind.extra == "tree":
        other = None
        while other is None:
            other = grown(replace(kind, extra="", vessels=5), rng)
        width = max(v.axis[:, 1].max() for v in tree) - min(v.axis[:, 1].min() for v in other)
        aside = np.array([4.0, width + 14.0, 0.0])
        return [*tree, *(replace(v, axis=v.axis + aside, parent=-9) for v in other)]
    if kind.extra == "parallel":
        one = max(ends, key=lambda vessel: vessel.length)
        along = (one.axis[-1] - one.axis[50]) / np.linalg.norm(one.axis[-1] - one.axis[50])
        others = cKDTree(np.concatenate([v.axis for v in tree if v is not one]))
        ways = np.cross(along, rng.normal(size=(16, 3)))
        ways *= (one.radius[80] + 2.4 + 3.0) / np.linalg.norm(ways, axis=1, keepdims=True)
        aside = max(ways, key=lambda way: others.query(one.axis[50:] + way)[0].min())
        return [*tree, Vessel(one.axis[50:] + aside, np.full(71, 2.4), np.full(71, one.way[80]), -9)]
    if kind.extra in ("vein", "bone"):
        middle = np.mean([v.axis[len(v.axis) // 2] for v in tree], axis=0)
        aside = rng.normal(size=3) * np.array([0.1, 1, 1])
        aside /= np.linalg.norm(aside)
        radius = 5.0 if kind.extra == "vein" else 9.0
        points = np.concatenate([v.axis for v in tree])
        far = ((points - middle) @ aside).max() + radius + 8
        axis = middle + far * aside + np.linspace(-25, 25, 121)[:, None] * np.array([1.0, 0.15, -0.1])
        return [*tree, Vessel(axis, np.full(121, radius), np.zeros(121), -9, contrast=1.0 if radius < 6 else 2.5)]
    return tree
