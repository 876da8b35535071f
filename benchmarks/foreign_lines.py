"""Center lines as other programs make them, of trees with known truth, and how long their vessels come out.

Usage: python benchmarks/foreign_lines.py FILE.jsonl [first seed, 9300] [kind …]

Every volume gives its lumen's surface as `extract` finds it, and lines in these ways:

vmtk       1/R-shortest ways along the Voronoi diagram of the surface (VMTK, Slicer), from the root to the point of the
           surface nearest to each end; they end a ball's radius before it, as Slicer's do
appended   the same with that point appended (VMTK's AppendEndPoints; the measured mouse lung)
curves     the first ones cut as VMTK's branch extractor does, joined at the middle of each junction, a point a radius
           (Slicer's curves)

and `extract` on the same volume. A line of FILE holds the errors of one volume's lengths as shares, and in SD; those of
"both doors" are the difference of an import and the extraction, in SD. What FILE holds is not run again.
"""

import json
import os
import sys
import time
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import Voronoi, cKDTree

from unlike import KINDS, SPACING, UNSEEN, make
from unlike_accuracy import pairing
from unlike_trees import grown, placed
from vasowave.base import VasowaveWarning
from vasowave.lung import Line, Options, Tree, distance_along, extract
from vasowave.lung.axes import cut_at_junctions
from vasowave.lung.exchange import as_extracted, merged
from vasowave.lung.lumen import segment, surface_points
from vasowave.lung.measure import measured_alone

THRESHOLD = 45.0


def true_tree(kind, seed):
    """Return the vessels of `make(kind, seed)` with their true axes and radii, cm."""
    rng = np.random.default_rng([seed, 77])
    tree = None
    while tree is None:
        tree = grown(kind, rng)
    tree, _ = placed(tree, kind, rng)
    own = [vessel for vessel in tree[1:] if vessel.parent != -9]
    lines = tuple(Line(vessel.axis * SPACING, vessel.radius * SPACING) for vessel in own)
    return Tree(lines, np.array([vessel.parent for vessel in own]))


def without_cannula(lumen, begin):
    """Return `lumen` cut flat where the root begins, as surfaces are before lines are drawn; the cannula is along z."""
    depth = np.clip((begin[0] - lumen.origin[0]) / lumen.spacing - np.arange(len(lumen.grey)), -0.5, 0.5) + 0.5
    low = lumen.grey.min()
    grey = (low + (1 - depth)[:, None, None] * (lumen.grey - low)).astype(lumen.grey.dtype)
    return replace(lumen, mask=grey > lumen.threshold, grey=grey)


def voronoi_lines(lumen, begin, ends):
    """Return VMTK's lines: ways along the Voronoi diagram of the surface, of least length over radius.

    The diagram's vertices that lie in the lumen are the centers of balls; a line runs from the ball that touches the
    surface at the source to that at the target. Returned bare, and with these points of the surface appended.
    """
    surface = surface_points(lumen)
    diagram = Voronoi(surface + np.random.default_rng(0).normal(scale=1e-4 * lumen.spacing, size=surface.shape))
    voxel = np.round((diagram.vertices - lumen.origin) / lumen.spacing)
    inside = ((voxel >= 0) & (voxel < lumen.mask.shape)).all(axis=1)
    inside[inside] = lumen.mask[tuple(voxel[inside].astype(int).T)]
    radius = cKDTree(surface).query(diagram.vertices)[0]
    inside &= radius > 0.7 * lumen.spacing
    pairs = []
    for ridge in diagram.ridge_vertices:
        corners = np.array(ridge)
        pairs.append(np.column_stack([corners, np.roll(corners, 1)]))
        if len(ridge) > 4:  # ways also cross the diagram's polygons
            pairs.append(np.column_stack([corners, np.roll(corners, len(ridge) // 2)]))
    edges = np.concatenate(pairs)
    edges = edges[(edges >= 0).all(axis=1) & inside[edges].all(axis=1)]
    far = np.linalg.norm(diagram.vertices[edges[:, 0]] - diagram.vertices[edges[:, 1]], axis=1)
    cost = np.maximum(far, 1e-9) / radius[edges].mean(axis=1)
    graph = coo_array((cost, edges.T), shape=(len(radius),) * 2).tocsr()
    seeds = surface[cKDTree(surface).query(np.vstack([begin, ends]))[1]]
    poles = [_pole(diagram, surface, seed, inside, radius) for seed in seeds]
    _, above = dijkstra(graph, directed=False, indices=poles[0], return_predecessors=True)
    bare, appended = [], []
    for pole, seed in zip(poles[1:], seeds[1:], strict=True):
        way = [pole]
        while above[way[-1]] >= 0:
            way.append(int(above[way[-1]]))
        if way[-1] != poles[0]:
            raise ValueError("an end is not joined to the root")
        line = Line(diagram.vertices[way[::-1]], radius[way[::-1]])
        bare.append(line)
        appended.append(Line(seeds[:1], line.radius[:1]).then(line, Line(seed[None], line.radius[-1:])))
    return bare, appended


def _pole(diagram, surface, seed, inside, radius):
    """Return the center of the largest ball in the lumen that touches the surface at `seed`."""
    cell = diagram.regions[diagram.point_region[int(cKDTree(surface).query(seed)[1])]]
    own = [row for row in cell if row >= 0 and inside[row]]
    return max(own, key=lambda row: radius[row])


def slicer_curves(lines, step):
    """Return Slicer's curves of `lines` as one tree: points at about `step` radii, branches joined at one point."""
    tree = cut_at_junctions(merged(lines, "identical"), 0.3)
    left = []
    for row in range(len(tree)):
        sisters = [one for one in tree.daughters(int(tree.parent[row])) if one != row] if row else []
        line = tree.lines[row]
        out = 0
        for sister in sisters:
            other = tree.lines[sister]
            gap, nearest = cKDTree(other.points).query(line.points)
            out = max(out, int(np.flatnonzero(gap <= other.radius[nearest]).max(initial=0)))
        left.append(min(out, len(line) // 2))
    cut = list(tree.lines)
    for row in range(len(tree)):
        daughters = tree.daughters(row)
        if len(daughters):
            middle = np.mean([tree.lines[one].points[left[one]] for one in daughters] + [cut[row].points[-1]], axis=0)
            cut[row] = cut[row].then(Line(middle[None], cut[row].radius[-1:]))
            for one in daughters:
                own = tree.lines[one][left[one] :]
                cut[one] = Line(middle[None], own.radius[:1]).then(own)
    return Tree(tuple(_resampled(line, step) for line in cut), tree.parent)


def _resampled(line, step):
    run = distance_along(line.points)
    at = np.linspace(0, run[-1], max(3, round(run[-1] / (step * line.typical_radius))) + 1)
    return Line.of(
        np.column_stack([*(np.interp(at, run, line.points[:, k]) for k in range(3)), np.interp(at, run, line.radius)])
    )


def outcome(name, seed):
    """Return the errors of all lines of one volume, and of its extraction."""
    kind = (KINDS | UNSEEN)[name]
    made, true = make(kind, seed), true_tree(kind, seed)
    root, begin = made.root + np.array([0.02, 0, 0]), true.lines[0].points[0]
    lumen = without_cannula(segment(made.volume, THRESHOLD, root), begin)
    bare, appended = voronoi_lines(lumen, begin, made.ends[made.terminals])
    surface, found = surface_points(lumen), {"kind": name, "seed": seed}
    ours = extract(made.volume, Options(root.tolist(), made.ends[made.terminals].tolist(), THRESHOLD)).measured
    own = pairing(made, ours.tree)
    found["extract"] = errors(made, ours, own)
    trees = {
        "vmtk": cut_at_junctions(merged(bare)),
        "appended": cut_at_junctions(merged(appended)),
        "curves": slicer_curves(bare, 1.0),
    }
    for lines, tree in trees.items():
        for given in (None, surface):
            start = time.process_time()
            alike = measured_alone(*as_extracted(tree, given, "ball" if lines == "curves" else "auto"))
            cost, order = time.process_time() - start, pairing(made, alike.tree)
            name = f"{lines}{'' if given is None else ', surface'}"
            found[name] = errors(made, alike, order) | {"cost": cost}
            if own is not None and order is not None:
                gap = alike.network.length[order] - ours.network.length[own]
                both = np.hypot(alike.length_sd[order], ours.length_sd[own])
                found[name]["both doors"] = (gap / both).tolist()
    for cut in ("tube", "identical"):
        raw = cut_at_junctions(merged(bare, cut))
        found[f"vmtk, cut {cut}"] = errors(made, measured_alone(raw), pairing(made, raw))
    return found


def errors(made, measured, order):
    """Return the errors of lengths and radii as shares, and of lengths in SD."""
    if order is None:
        return {"right": False}
    length = measured.network.length[order] - made.length
    radius = measured.network.radius[order] / made.radius - 1
    deviations = length / measured.length_sd[order]
    return {
        "right": True,
        "length": (length / made.length).tolist(),
        "sd": deviations.tolist(),
        "radius": radius.tolist(),
    }


def table(results):
    """Return a row for each kind of lines: errors in percent, median / 95th percentile, and the shares within 2 SD."""
    rows = ["| lines | right | length | within 2 SD | both doors within 2 SD | CPU-s |", "|---|---|---|---|---|---|"]
    for name in [key for key in results[0] if key not in ("kind", "seed")]:
        runs = [one[name] for one in results if name in one]
        good = [one for one in runs if one["right"]]
        size = 100 * np.abs(np.concatenate([one["length"] for one in good]))
        inside = [_inside(good, key) for key in ("sd", "both doors")]
        cost = np.median([one["cost"] for one in good if "cost" in one] or [np.nan])
        rows.append(
            f"| {name} | {len(good)} of {len(runs)} | {np.median(size):.1f} / {np.quantile(size, 0.95):.1f} | "
            f"{inside[0]} | {inside[1]} | {'' if np.isnan(cost) else f'{cost:.1f}'} |"
        )
    return "\n".join(rows)


def _inside(runs, key):
    values = np.concatenate([one.get(key, []) for one in runs])
    return f"{100 * np.mean(np.abs(values) <= 2):.0f} %" if np.isfinite(values).any() else ""


def main():
    warnings.simplefilter("ignore", VasowaveWarning)
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    path, words = Path(sys.argv[1]), sys.argv[2:]
    first = next((int(word) for word in words if word.isdigit()), 9300)
    kinds = [word for word in words if not word.isdigit()] or list(UNSEEN)[:10]
    stored = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    done = {(one["kind"], one["seed"]) for one in stored}
    for row, name in enumerate(kinds):
        if (name, first + row) not in done:
            stored.append(outcome(name, first + row))
            with path.open("a") as file:
                file.write(json.dumps(stored[-1]) + "\n")
            print(name, flush=True)
    print(table(stored))


if __name__ == "__main__":
    main()
