"""Tubes around axes: rings of points, joined by quadrilaterals."""

import numpy as np

from vasowave.imaging.tree import distance_along

SIDES = 16
"""Points of a ring."""


def points_at(axis: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return the points at these shares (0 to 1) of the length of `axis`, shape (place, 3)."""
    run = distance_along(axis)
    return np.column_stack([np.interp(share * run[-1], run, axis[:, i]) for i in range(3)])


def ring_directions(points: np.ndarray) -> np.ndarray:
    """Return unit vectors from an axis to the points of its rings, shape (place, side, 3).

    The rings stand across the axis and do not twist: each frame is the one before, turned into its own plane.
    """
    tangent = np.gradient(points, axis=0)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-300)
    across = np.zeros_like(points)
    normal = np.eye(3)[int(np.argmin(np.abs(tangent[0])))]
    for place, along in enumerate(tangent):
        normal = normal - np.dot(normal, along) * along
        normal = normal / np.linalg.norm(normal)
        across[place] = normal
    other = np.cross(tangent, across)
    turn = 2 * np.pi * np.arange(SIDES) / SIDES
    return np.cos(turn)[None, :, None] * across[:, None] + np.sin(turn)[None, :, None] * other[:, None]


def quadrilaterals(places: int, first: int) -> np.ndarray:
    """Return the corners of the faces between `places` rings, whose points are numbered from `first`; (face, 4)."""
    ring, side = np.meshgrid(np.arange(places - 1), np.arange(SIDES), indexing="ij")
    here, there = ring * SIDES, (ring + 1) * SIDES
    after = (side + 1) % SIDES
    corners = np.stack([here + side, here + after, there + after, there + side], axis=-1)
    return first + corners.reshape(-1, 4)
