"""Where a posterior is searched: starts that the linear model chooses, in two halves that know nothing of each other.

The network in the frequency domain costs a tenth of a simulation. It looks at points of the prior, and climbs from the
best of them; the simulations climb on from there, and from one that lies far away although it is nearly as good.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.inference.discrepancy import Discrepancy
from vasowave.pulse.inference.mode import Climbed, climb
from vasowave.pulse.inference.simulations import Simulate

_SCREENED_POINTS = 200  # points of the prior that each half looks at
_BEST_POINTS = 10  # of them, among which the farthest from the best one is another start
_LINEAR_MODEL_RMS = 0.4  # mmHg, r.m.s., by which the linear model differs from simulations where it fits
_STEP_SD = 1e-3  # of the linear model's differences, in SD of the prior


class Screened(NamedTuple):
    """Draws of the prior, (point, unknown), and what the linear model makes of them, NaN where it has no answer."""

    points: np.ndarray
    outputs: np.ndarray


def screened(linear: Simulate, size: int, seed: int) -> tuple[Screened, Screened]:
    """Return what each half looks at, of a prior of so many unknowns."""
    halves = [np.random.default_rng([seed, 2 + half]).standard_normal((_SCREENED_POINTS, size)) for half in (0, 1)]
    first, second = (Screened(points, linear(points)) for points in halves)
    return first, second


def find_modes(
    simulate: Simulate,
    linear: Simulate,
    measured: np.ndarray,
    noise: Discrepancy,
    points: Sequence[np.ndarray],
    halves: Sequence[Screened],
) -> list[Climbed]:
    """Return the distinct modes that starts lead to, the likeliest first, and which halves of the starts found them.

    Parameters
    ----------
    simulate, linear : callable
    measured : array, shape (output,)
    noise : Discrepancy
    points : sequence of array, shape (unknown,)
        Starts that belong to neither half.
    halves : pair of Screened

    Raises
    ------
    NumericalError
        No start can be simulated.
    """
    modes: list[Climbed] = []
    failure: NumericalError | None = None
    wide = noise.widened(_LINEAR_MODEL_RMS)
    starts = [(point, frozenset[int]()) for point in points]
    for half, looked in enumerate(halves):
        starts += [(point, frozenset((half,))) for point in _chosen(linear, measured, wide, looked)]
    for start, found_by in starts:
        try:
            end = climb(simulate, measured, noise, start, modes, _STEP_SD, linear)
            if not any(mode.holds(end.middle, end.height) for mode in modes):
                end = climb(simulate, measured, noise, end.middle, modes)
        except NumericalError as error:
            failure = error
            continue
        modes = _merged(modes, replace(end, halves=found_by))
    if not modes and failure is not None:
        raise failure
    return sorted(modes, key=lambda mode: -mode.log_evidence(noise, measured))


def _chosen(linear: Simulate, measured: np.ndarray, noise: Discrepancy, looked: Screened) -> list[np.ndarray]:
    """Return two starts: the linear model's optimum above the best point, and the farthest of the next best points."""
    medians = np.zeros((1, looked.points.shape[1]))
    points, outputs = np.vstack([medians, looked.points]), np.vstack([linear(medians), looked.outputs])
    good = np.isfinite(outputs).all(axis=1)
    if not good.any():
        return [points[0]]
    points = points[good]
    heights = noise.log_likelihood(measured - outputs[good]) - 0.5 * (points**2).sum(axis=1)
    best = points[np.argsort(-heights)[:_BEST_POINTS]]
    farthest = best[np.argmax(((best - best[0]) ** 2).sum(axis=1))]
    return [climb(linear, measured, noise, best[0], step=_STEP_SD).middle, farthest]


def _merged(modes: list[Climbed], end: Climbed) -> list[Climbed]:
    """Return the modes with one more, or with the higher of two ends in one bowl."""
    for i, mode in enumerate(modes):
        higher, lower = (mode, end) if mode.height >= end.height else (end, mode)
        if higher.holds(lower.middle, lower.height):
            return [*modes[:i], replace(higher, halves=mode.halves | end.halves), *modes[i + 1 :]]
    return [*modes, end]
