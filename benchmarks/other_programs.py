"""Center lines of one lumen by another program; run in that program's own environment, see `unlike_others.py`.

Usage: python other_programs.py kimimaro|scikit-image|vmtk [lumen.npz] [lines.npz]
In: mask, grey and threshold on one grid, root and ends (z, y, x, voxels of the grid). Out: points, the radius at each
(voxels) and the row of the next point toward the root, -1 at the root; CPU seconds.
"""

import sys
import time

import numpy as np

KIMIMARO = {"scale": 1.5, "const": 4, "pdrf_scale": 100000, "pdrf_exponent": 4}
"""Its published parameters, its constant in voxels."""
TICK = 6
"""Twigs shorter than so many voxels are removed, by kimimaro's own function."""


def by_kimimaro(given):
    import kimimaro

    (skeleton,) = kimimaro.skeletonize(
        given["mask"].astype(np.uint8), teasar_params=KIMIMARO, dust_threshold=0, progress=False, parallel=1
    ).values()
    skeleton = kimimaro.postprocess(skeleton, dust_threshold=0, tick_threshold=TICK)
    return rooted(skeleton.vertices, skeleton.radius, skeleton.edges, given["root"])


def by_scikit_image(given):
    """Lee's thinning; twigs shorter than the radius at their junction + 4 voxels are removed."""
    from scipy import ndimage
    from scipy.spatial import cKDTree
    from skimage.morphology import skeletonize

    points = np.argwhere(skeletonize(given["mask"]))
    radius = ndimage.distance_transform_edt(given["mask"])[tuple(points.T)]
    return rooted(points, radius, cKDTree(points).query_pairs(1.8, output_type="ndarray"), given["root"], twigs=4)


def by_vmtk(given):
    """Its lines from the root to each true end, on the iso-surface of the same grey levels."""
    import vtk
    from vmtk import vmtkcenterlines, vmtkmarchingcubes
    from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

    grey = np.pad(given["grey"], 1, constant_values=float(given["grey"].min()))
    image = vtk.vtkImageData()
    image.SetDimensions(*grey.shape[::-1])
    image.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(grey).ravel(), deep=True))
    cubes = vmtkmarchingcubes.vmtkMarchingCubes()
    cubes.Image, cubes.Level = image, float(given["threshold"])
    cubes.Execute()
    lines = vmtkcenterlines.vmtkCenterlines()
    lines.Surface, lines.SeedSelectorName, lines.AppendEndPoints = cubes.Surface, "pointlist", 1
    lines.SourcePoints = (given["root"][::-1] + 1).tolist()
    lines.TargetPoints = (given["ends"][:, ::-1] + 1).ravel().tolist()
    lines.Execute()
    found = lines.Centerlines
    points = vtk_to_numpy(found.GetPoints().GetData())[:, ::-1] - 1
    radius = vtk_to_numpy(found.GetPointData().GetArray("MaximumInscribedSphereRadius"))
    lines = []
    for row in range(found.GetNumberOfCells()):
        ids = found.GetCell(row).GetPointIds()  # the next cell takes its place
        lines.append(np.array([ids.GetId(k) for k in range(ids.GetNumberOfIds())]))
    gaps = [np.linalg.norm(points[line[[0, -1]]] - given["root"], axis=1) for line in lines]
    return points, radius, [line if near < far else line[::-1] for line, (near, far) in zip(lines, gaps, strict=True)]


def rooted(points, radius, edges, root, twigs=None):
    """Return the tree of shortest ways to the end nearest to `root`."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    far = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    graph = coo_array((far, edges.T), shape=(len(points),) * 2).tocsr()
    ends = np.flatnonzero(np.bincount(edges.ravel().astype(int), minlength=len(points)) == 1)
    start = int(ends[np.argmin(np.linalg.norm(points[ends] - root, axis=1))])
    way, above = dijkstra(graph, directed=False, indices=start, return_predecessors=True)
    kept = np.isfinite(way)
    if twigs is not None:
        kept = without_twigs(points, radius, way, above, start, twigs)
    rows, new = np.flatnonzero(kept), np.full(len(points), -1)
    new[rows] = np.arange(len(rows))
    return points[rows], radius[rows], np.where(rows == start, -1, new[np.maximum(above[rows], 0)])


def without_twigs(points, radius, way, above, start, least):
    leaf = np.isfinite(way)
    leaf[above[above >= 0]] = False
    kept = np.zeros(len(points), dtype=bool)
    kept[start] = True
    for tip in sorted(np.flatnonzero(leaf), key=lambda at: -way[at]):
        run, at = [], tip
        while not kept[at]:
            run.append(at)
            at = above[at]
        if way[tip] - way[at] > radius[at] + least:
            kept[run] = True
    return kept


def main():
    program, source, target = sys.argv[1:]
    with np.load(source) as file:
        given = dict(file)
    begin = time.process_time()
    points, radius, way = {"kimimaro": by_kimimaro, "scikit-image": by_scikit_image, "vmtk": by_vmtk}[program](given)
    cost = time.process_time() - begin
    if program == "vmtk":
        rows, ends = np.concatenate(way), np.cumsum([len(line) for line in way])
        np.savez(target, points=points[rows], radius=radius[rows], line_ends=ends, cost=cost)
    else:
        np.savez(target, points=points, radius=radius, above=way, cost=cost)


if __name__ == "__main__":
    main()
