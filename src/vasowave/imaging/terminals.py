"""Where terminal vessels end: on the lumen's surface, straight ahead of their axis."""

from dataclasses import replace

import numpy as np

from vasowave.imaging.tree import Tree, distance_along


def with_ends_at_the_surface(tree: Tree, surface: np.ndarray) -> Tree:
    """Return `tree` with the last radius of every terminal replaced by its axis, prolonged to the surface.

    Within a radius of a blind end a center path turns to its farthest corner. The end is the median of the
    surface's points ahead that lie within half a radius of the axis; a terminal without such points keeps its end.

    Parameters
    ----------
    tree : Tree
    surface : float array, shape (corner, 3)
        Points of the lumen's surface, cm (see `Paths`).
    """
    lines = list(tree.lines)
    for row in set(range(len(lines))) - set(tree.parent.tolist()):
        lines[row] = _prolonged(lines[row], surface)
    return replace(tree, lines=tuple(lines))


def _prolonged(line: np.ndarray, surface: np.ndarray) -> np.ndarray:
    run = distance_along(line)
    radius = float(np.median(line[run > 0.5 * run[-1], 3]))
    kept = line[run <= max(run[-1] - radius, 0.5 * run[-1])]
    straight = line[: len(kept)][run[: len(kept)] >= run[len(kept) - 1] - 2.5 * radius, :3]
    if len(straight) < 3:
        return line
    axis = np.linalg.svd(straight - straight.mean(axis=0), full_matrices=False)[2][0]
    axis *= np.sign(axis @ (straight[-1] - straight[0]))
    ahead = (surface - kept[-1, :3]) @ axis
    aside = np.linalg.norm(surface - kept[-1, :3] - ahead[:, None] * axis, axis=1)
    cap = ahead[(ahead > 0) & (ahead < 3 * radius) & (aside < 0.5 * radius)]
    if len(cap) < 3:
        return line
    far = float(np.median(cap))
    steps = max(2, round(far / (run[-1] / (len(run) - 1))))
    along = np.linspace(0, far, steps + 1)[1:]
    added = kept[-1, :3] + along[:, None] * axis
    return np.concatenate([kept, np.column_stack([added, np.minimum(kept[-1, 3], far - along)])])
