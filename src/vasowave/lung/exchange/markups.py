"""Curves of 3D Slicer (.mrk.json), one for each branch, with a radius at every control point."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.errors import InputError, of_file
from vasowave.base.io.textfile import read_bytes
from vasowave.base.stores import parsed
from vasowave.lung.axes.skeleton import Skeleton
from vasowave.lung.exchange.formats import LINES, LinesFormat
from vasowave.lung.exchange.merging import rooted
from vasowave.lung.tree import Line


def read_markups(path: Path, unit: float) -> Skeleton:
    """Return the tree of the curves in a markups file; the first point of the first curve is its root.

    A curve joins the tree where its first point lies within the radius of an earlier curve's point.

    Raises
    ------
    InputError
        No JSON, no curve, a curve without a radius at each of its points.
    """
    try:
        curves = parsed(read_bytes(path))["markups"]
        lines = [_line(path, curve, unit) for curve in curves if curve["type"].endswith("Curve")]
    except InputError:
        raise
    except (ValueError, KeyError, TypeError, AttributeError, IndexError, OverflowError, RecursionError) as error:
        raise InputError(f"{path}: not a markups file of 3D Slicer ({error!r})") from None
    if not lines:
        raise InputError(f"{path}: no curve in it; export centerline curves")
    return tree_of(path, lines)


def tree_of(path: Path, lines: Sequence[Line]) -> Skeleton:
    """Return the tree of lines, a branch each, of which one joins an earlier one within the radius of its point."""
    all_points = lines[0].then(*lines[1:])
    edges, begin = [], 0
    for line in lines:
        rows = begin + np.arange(len(line))
        edges.append(np.column_stack([rows[:-1], rows[1:]]))
        if begin:
            gap = np.linalg.norm(all_points.points[:begin] - line.points[0], axis=1)
            nearest = int(np.argmin(gap))
            if gap[nearest] <= all_points.radius[nearest]:
                edges.append(np.array([[nearest, begin]]))
        begin += len(line)
    with of_file(path):
        return rooted(all_points, np.concatenate(edges), 0)


def _line(path: Path, curve: dict[str, Any], unit: float) -> Line:
    points = unit * np.array([point["position"] for point in curve["controlPoints"]], dtype=float).reshape(-1, 3)
    if curve.get("coordinateSystem", "LPS") == "RAS":
        points = points * [-1, -1, 1]
    measurements = [
        measurement for measurement in curve.get("measurements", []) if "radius" in measurement["name"].lower()
    ]
    radius = (
        unit * np.array(measurements[0].get("controlPointValues", []), dtype=float) if measurements else np.empty(0)
    )
    if not np.isfinite(points).all():
        raise InputError(f"{path}: a position that is not finite; export the curves again")
    if len(points) < 2 or radius.shape != (len(points),) or not (np.isfinite(radius).all() and (radius > 0).all()):
        raise InputError(f"{path}: a curve without a positive radius at each of its points; export them with radii")
    return Line(points[:, ::-1], radius)


LINES.register(
    LinesFormat(
        "slicer", "curves of 3D Slicer", (".json",), None, lambda path, unit, cut: read_markups(path, unit), "ball"
    )
)
