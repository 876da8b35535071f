"""Compiled loops of several rooms: over the points of a surface, the samples of a section, the voxels of an image."""

from typing import Any

import numpy as np
from numba import njit

from vasowave.base.runtime.kernels import kept

_OPTIONS: Any = {"nogil": True, "error_model": "numpy"}


@kept
@njit(**_OPTIONS)
def smoothed_plane(planes, order, down, across, weights, plane):
    """Write the middle one of `planes` into `plane`, smoothed along z, y and x by symmetric `weights`.

    Sums are made as SciPy's Gaussian filter makes them, from the farthest neighbors to the nearest.

    Parameters
    ----------
    planes : float32 array, shape (2 reach + 1, y, x)
    order : int array, shape (2 reach + 1,)
        Which plane stands how far before and beyond the middle one.
    down, across : int array, shape (y + 2 reach,), (x + 2 reach,)
        Which row and which column stands where, beyond the faces too.
    weights : float array, shape (reach + 1,)
        Of the middle, of its neighbors, and so on.
    plane : float32 array, shape (y, x)
    """
    reach, (height, width) = len(weights) - 1, plane.shape
    along_z, total, row = np.empty((height, width), dtype=np.float32), np.empty(width), np.empty(width + 2 * reach)
    for y in range(height):
        _begin(total, planes[order[reach], y], weights[0])
        for step in range(reach, 0, -1):
            _add(total, planes[order[reach - step], y], planes[order[reach + step], y], weights[step])
        along_z[y] = total
    for y in range(height):
        _begin(total, along_z[y], weights[0])
        for step in range(reach, 0, -1):
            _add(total, along_z[down[y + reach - step]], along_z[down[y + reach + step]], weights[step])
        for x in range(width):
            row[reach + x] = np.float32(total[x])
        for x in range(reach):
            row[x], row[width + reach + x] = row[reach + across[x]], row[reach + across[width + reach + x]]
        _begin(total, row[reach:], weights[0])
        for step in range(reach, 0, -1):
            _add(total, row[reach - step :], row[reach + step :], weights[step])
        plane[y] = total


@njit(**_OPTIONS)
def _begin(total, middle, weight):
    for x in range(len(total)):
        total[x] = np.float64(middle[x]) * weight


@njit(**_OPTIONS)
def _add(total, before, beyond, weight):
    for x in range(len(total)):
        total[x] += (np.float64(before[x]) + np.float64(beyond[x])) * weight


@kept
@njit(**_OPTIONS)
def encloses(mask):
    """Whether a connected `mask` (bool, shape (z, y, x), without voxels at the faces) encloses what is not its own.

    What touches a connected piece by faces, edges or corners is as many pieces, by faces, as what lies around it is.
    """
    rows, columns = mask.shape[2], mask.shape[1] * mask.shape[2]
    flat, shell, count, first = mask.ravel(), np.zeros(mask.size, dtype=np.bool_), 0, -1
    for voxel in range(len(flat)):
        if flat[voxel]:
            for z in (-columns, 0, columns):
                for y in (-rows, 0, rows):
                    for neighbor in range(voxel + z + y - 1, voxel + z + y + 2):
                        if not flat[neighbor] and not shell[neighbor]:
                            shell[neighbor], count = True, count + 1
                            first = neighbor if first < 0 else min(first, neighbor)
    waiting = [first]  # one that lies outside, for nothing of the mask comes before it
    shell[first] = False
    while len(waiting):
        voxel, count = waiting.pop(), count - 1
        for step in (-columns, -rows, -1, 1, rows, columns):
            neighbor = voxel + step
            if 0 <= neighbor < len(shell) and shell[neighbor]:
                shell[neighbor] = False
                waiting.append(neighbor)
    return count > 0


@kept
@njit(**_OPTIONS)
def enclosed_voxels(mask, voxels, stamps, reach_radii, min_directions, min_rim):
    """Return the voxels outside `mask` that meet it in so many of 26 directions, and at one end of each line at least,
    a list of z, y, x, and their number.

    They are looked for from its surface on, within `reach_radii` of its mean radius, which is twice its voxels over
    their free faces; behind them in the list stands what meets it in `min_rim` directions, from those on.

    Parameters
    ----------
    mask : bool array, shape (z, y, x)
    voxels : int array, shape (voxel, 3)
        Those of the mask.
    stamps : uint8 array, shape (z, y, x)
        Zeros; where they are never looked at, they take no memory.
    """
    enclosed, waiting, faces = [(0, 0, 0) for _ in range(0)], [(0, 0, 0) for _ in range(0)], 0
    for row in range(len(voxels)):
        place = int(voxels[row, 0]), int(voxels[row, 1]), int(voxels[row, 2])
        faces += _queue_neighbors(place, mask, stamps, 1, waiting)
    reach, seeds = reach_radii * 2 * len(voxels) / max(faces, 1), 0
    for stamp, directions in ((1, min_directions), (2, min_rim)):
        for row in range(len(enclosed)):
            _queue_neighbors(enclosed[row], mask, stamps, stamp, waiting)
        while len(waiting):
            place = waiting.pop()
            if _meets(place, mask, reach, 26 - directions, stamp == 1):
                enclosed.append(place)
                stamps[place] = 3
                _queue_neighbors(place, mask, stamps, stamp, waiting)
        if stamp == 1:
            seeds = len(enclosed)
    return enclosed, seeds


@njit(**_OPTIONS)
def _queue_neighbors(place, mask, stamps, stamp, waiting):
    """Put the face neighbors outside `mask` with a lower stamp into `waiting`, and return how many lie outside."""
    outside = 0
    for axis in range(3):
        for step in (-1, 1):
            z, y, x = place[0] + step * (axis == 0), place[1] + step * (axis == 1), place[2] + step * (axis == 2)
            if 0 <= z < mask.shape[0] and 0 <= y < mask.shape[1] and 0 <= x < mask.shape[2] and not mask[z, y, x]:
                outside += 1
                if stamps[z, y, x] < stamp:
                    stamps[z, y, x] = stamp
                    waiting.append((z, y, x))
    return outside


@njit(**_OPTIONS)
def _meets(place, mask, reach, max_misses, lines_too):
    """Whether all but `max_misses` of 26 directions from `place` meet `mask` within `reach`, voxels; and `lines_too`
    at one end at least, for clefts between vessels are open at both.
    """
    misses, is_open = 0, np.zeros(27, dtype=np.bool_)
    for direction in range(27):
        dz, dy, dx = direction // 9 - 1, direction // 3 % 3 - 1, direction % 3 - 1
        length = np.sqrt(dz * dz + dy * dy + dx * dx)
        z, y, x = place
        met = direction == 13  # the voxel itself
        for _ in range(int(reach / max(length, 1.0))):
            z, y, x = z + dz, y + dy, x + dx
            if met or not (0 <= z < mask.shape[0] and 0 <= y < mask.shape[1] and 0 <= x < mask.shape[2]):
                break
            met = mask[z, y, x]
        is_open[direction] = not met
        misses += not met
        if misses > max_misses or (lines_too and not met and is_open[26 - direction]):
            return False
    return True


@kept
@njit(**_OPTIONS)
def in_tube(places, middles, points, reach):
    """Return which places lie in a tube: nearer to the nearest point of its axis than the reach of that point.

    Parameters
    ----------
    places : float array, shape (section, sample, 3)
    middles : float array, shape (section, 3)
        What the places of a section lie around.
    points : float array, shape (point, 3)
        Of the axis.
    reach : float array, shape (point,)

    Returns
    -------
    bool array, shape (section, sample)
    """
    inside = np.zeros(places.shape[:2], dtype=np.bool_)
    farthest, gaps, away = reach.max(), np.empty(len(points)), np.empty(places.shape[1])
    for section in range(len(places)):  # few points come near to a section, and few of its samples near to these
        _distances(points, middles[section], gaps)
        _distances(places[section], middles[section], away)
        candidates = np.flatnonzero(gaps <= (away.max() + farthest) * (1 + 1e-9))
        if len(candidates) == 0:
            continue
        least_away = (gaps[candidates].min() - farthest) * (1 - 1e-9)
        for sample in range(len(away)):
            if away[sample] < least_away:
                continue
            smallest_square, nearest = np.inf, candidates[0]
            z, y, x = places[section, sample, 0], places[section, sample, 1], places[section, sample, 2]
            for point in candidates:
                square = (z - points[point, 0]) ** 2 + (y - points[point, 1]) ** 2 + (x - points[point, 2]) ** 2
                if square < smallest_square:
                    smallest_square, nearest = square, point
            inside[section, sample] = np.sqrt(smallest_square) < reach[nearest]
    return inside


@njit(**_OPTIONS)
def _distances(points, place, distance):
    for row in range(len(points)):
        z, y, x = points[row, 0] - place[0], points[row, 1] - place[1], points[row, 2] - place[2]
        distance[row] = np.sqrt(z * z + y * y + x * x)


@kept
@njit(**_OPTIONS)
def ahead_of(points, place, axis, reach, wide):
    """Return how far those of `points` lie ahead of `place` along `axis` that lie within `reach`, and `wide` aside."""
    distances = []
    for row in range(len(points)):
        z, y, x = points[row, 0] - place[0], points[row, 1] - place[1], points[row, 2] - place[2]
        ahead = z * axis[0] + y * axis[1] + x * axis[2]
        if 0 < ahead < reach:
            z, y, x = z - ahead * axis[0], y - ahead * axis[1], x - ahead * axis[2]
            if z * z + y * y + x * x < wide * wide:
                distances.append(ahead)
    return np.array(distances)


@kept
@njit(**_OPTIONS)
def summed_on_pieces(place, normal, share, gap, weight, places):
    """Return the sums of w·j·jᵀ and of -w·j·gap over the feet on each piece, by its first place.

    j says how a gap changes with the coordinates of the piece's two nodes and its two radii; w is the foot's weight.
    """
    squares, pull, change = np.zeros((places, 8, 8)), np.zeros((places, 8)), np.empty(8)
    for foot in range(len(place)):
        for end in range(2):
            fraction = share[foot] if end else 1 - share[foot]
            change[6 + end] = -fraction
            for k in range(3):
                change[3 * end + k] = -fraction * normal[foot, k]
        for row in range(8):
            weighted = weight[foot] * change[row]
            pull[place[foot], row] -= weighted * gap[foot]
            for column in range(8):
                squares[place[foot], row, column] += weighted * change[column]
    return squares, pull
