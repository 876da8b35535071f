"""Center lines as other programs make them, of trees with known truth, and how long their vessels come out.

Usage: python benchmarks/foreign_lines.py FILE.jsonl [volumes a kind, 1] [first seed, 1000] [kind …]

Every volume gives its lumen's surface as `extract` finds it, and lines in these ways:

vmtk       1/R-shortest ways along the Voronoi diagram of the surface (VMTK, Slicer), from the root to the point of the
           surface nearest to each end; they end a ball's radius before it, as Slicer's do
appended   the same with that point appended (VMTK's AppendEndPoints; the measured mouse lung)
exact      the true axes, each from the root to an end
curves     the first ones cut as VMTK's branch extractor does, joined at the middle of each junction, a point a radius
           (Slicer's curves)

Errors of the lengths in percent by the rule that cuts lines, and the share within 2 SD.
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
from unlike_trees import grown, placed
from vasowave.errors import VasowaveWarning
from vasowave.imaging.lumen.segmentation import segment
from vasowave.imaging.lumen.surface import surface_points
from vasowave.imaging.tree import Line, Tree, distance_along

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


def ways_to_root(tree):
    """Return for each terminal the rows from the root to it."""
    for row in tree.terminals:
        way = [row]
        while tree.parent[way[-1]] >= 0:
            way.append(int(tree.parent[way[-1]]))
        yield way[::-1]


def exact_lines(tree):
    """Return the true axes, one line from the root to each end."""
    lines = []
    for way in ways_to_root(tree):
        first, *rest = (tree.lines[row] for row in way)
        lines.append(first.then(*(line[1:] for line in rest)))
    return lines


def without_cannula(lumen, begin):
    """Return `lumen` cut flat where the root begins, as surfaces are before lines are drawn; the cannula is along z."""
    depth = np.clip((begin[0] - lumen.origin[0]) / lumen.spacing - np.arange(len(lumen.grey)), -0.5, 0.5) + 0.5
    low = lumen.grey.min()
    grey = (low + (1 - depth)[:, None, None] * (lumen.grey - low)).astype(lumen.grey.dtype)
    return replace(lumen, mask=grey > lumen.threshold, grey=grey)


def voronoi_lines(lumen, begin, ends, appended):
    """Return VMTK's lines: ways along the Voronoi diagram of the surface, of least length over radius.

    The diagram's vertices that lie in the lumen are the centers of balls; a line runs from the ball that touches the
    surface at the source to that at the target.
    """
    surface = surface_points(lumen)
    diagram = Voronoi(surface + np.random.default_rng(0).normal(scale=1e-4 * lumen.spacing, size=surface.shape))
    voxel = np.round((diagram.vertices - lumen.origin) / lumen.spacing)
    inside = ((voxel >= 0) & (voxel < lumen.mask.shape)).all(axis=1)
    inside[inside] = lumen.mask[tuple(voxel[inside].astype(int).T)]
    radius = cKDTree(surface).query(diagram.vertices)[0]
    inside &= radius > 0.7 * lumen.spacing
    edges = []
    for ridge in diagram.ridge_vertices:
        corners = np.array(ridge)
        edges.append(np.column_stack([corners, np.roll(corners, 1)]))
        if len(ridge) > 4:  # ways also cross the diagram's polygons
            edges.append(np.column_stack([corners, np.roll(corners, len(ridge) // 2)]))
    edges = np.concatenate(edges)
    edges = edges[(edges >= 0).all(axis=1) & inside[edges].all(axis=1)]
    far = np.linalg.norm(diagram.vertices[edges[:, 0]] - diagram.vertices[edges[:, 1]], axis=1)
    cost = np.maximum(far, 1e-9) / radius[edges].mean(axis=1)
    graph = coo_array((cost, edges.T), shape=(len(radius),) * 2).tocsr()
    seeds = surface[cKDTree(surface).query(np.vstack([begin, ends]))[1]]
    poles = [_pole(diagram, surface, seed, inside, radius) for seed in seeds]
    _, above = dijkstra(graph, directed=False, indices=poles[0], return_predecessors=True)
    lines = []
    for pole, seed in zip(poles[1:], seeds[1:], strict=True):
        way = [pole]
        while above[way[-1]] >= 0:
            way.append(int(above[way[-1]]))
        if way[-1] != poles[0]:
            raise ValueError("an end is not joined to the root")
        line = Line(diagram.vertices[way[::-1]], radius[way[::-1]])
        if appended:
            line = line.then(Line(seed[None], line.radius[-1:]))
            line = Line(seeds[:1], line.radius[:1]).then(line)
        lines.append(line)
    return lines


def _pole(diagram, surface, seed, inside, radius):
    """Return the center of the largest ball in the lumen that touches the surface at `seed`."""
    cell = diagram.regions[diagram.point_region[int(cKDTree(surface).query(seed)[1])]]
    own = [row for row in cell if row >= 0 and inside[row]]
    return max(own, key=lambda row: radius[row])


def slicer_curves(lines, step):
    """Return Slicer's curves of `lines` as one tree: points at about `step` radii, branches joined at one point each."""
    from vasowave.imaging.axes.skeleton import cut_at_junctions
    from vasowave.imaging.exchange.merging import merged

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
