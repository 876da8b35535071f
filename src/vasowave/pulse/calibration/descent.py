"""Many places led downhill on a model of the residuals that costs little, all at once.

Each is led by damped Gauss-Newton steps (Levenberg, Marquardt) in the coordinates that the data see; where such a step
leads no lower, as at the bounds of the parameters, in their logarithms. Places that meet go on as one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.pulse.calibration.coordinates import Coordinates


@dataclass(frozen=True)
class DescentRules:
    """How places are led.

    Attributes
    ----------
    max_steps : int
    gain : float
        Relative gain of S at which a place has arrived.
    damping, eased, raised, max_damping : float
        First damping, by what it is multiplied where a step gains and where it does not, and where a place stops.
    length : float
        Longest step, in the coordinates or in the logarithms.
    step : float
        Step of differences, likewise.
    met : float
        Distance at which two places go on as one, in the coordinates.
    inside : float
        Distance from the bounds at which a place begins, as a share of their span.
    """

    max_steps: int = 40
    gain: float = 1e-7
    damping: float = 1e-3
    eased: float = 0.2
    raised: float = 10.0
    max_damping: float = 1e3
    length: float = 1.0
    step: float = 1e-5
    met: float = 0.05
    inside: float = 1e-6


RULES = DescentRules()
Residuals = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Of coordinates and of the same places in logarithms, shapes (place, free); returns shape (place, row)."""


class Descent(NamedTuple):
    """Where places were led.

    Attributes
    ----------
    x : array, shape (end, free)
        Logarithms of the free parameters at the ends, the lowest first.
    z : array, shape (end, free)
        Their coordinates.
    S : array, shape (end,)
        Sums of squares there.
    end : int array, shape (place,)
        Which end each place came to; -1 where nothing is known of a place.
    """

    x: np.ndarray
    z: np.ndarray
    S: np.ndarray
    end: np.ndarray


def descend(residuals: Residuals, coordinates: Coordinates, starts: np.ndarray, limit: float) -> Descent:
    """Return where places, as logarithms, shape (place, free), are led; a sum of squares above `limit` is none."""
    low, high = coordinates.log_bounds
    inside = RULES.inside * (high - low)
    x = np.clip(starts, low + inside, high - inside)
    z, valid = _placed(coordinates, x)
    f = residuals(z, x)
    places = _Places(residuals, coordinates, x, z, f, np.sum(f**2, axis=1))
    valid &= limit > places.S
    leader = np.where(valid, np.arange(len(x)), -1)
    moving = changed = np.flatnonzero(valid)
    for _ in range(RULES.max_steps):
        places.differentiate(changed)
        moving, gained = places.step(moving)
        if not len(moving):
            break
        on = _met(z, places.S, moving[places.damping[moving] < RULES.max_damping], leader)
        changed, moving = np.intersect1d(moving[gained], on), on
    return _ends(x, z, places.S, leader)


@dataclass(eq=False)
class _Places:
    """Places on their way: logarithms, coordinates, residuals, their sums of squares, derivatives and damping."""

    residuals: Residuals
    coordinates: Coordinates
    x: np.ndarray
    z: np.ndarray
    f: np.ndarray
    S: np.ndarray

    def __post_init__(self) -> None:
        self.by_z, self.by_x = np.zeros((2, *self.f.shape, self.x.shape[1]))
        self.damping = np.full(len(self.x), RULES.damping)

    def differentiate(self, rows: np.ndarray) -> None:
        """Renew the derivatives by the coordinates and by the logarithms, shape (place, row, free)."""
        if not len(rows):
            return
        z, f, free = self.z[rows], self.f[rows], self.z.shape[1]
        moved = (z[:, np.newaxis] + RULES.step * np.eye(free)).reshape(-1, free)
        logarithms = self.coordinates.logarithms(moved)
        values = self.residuals(moved, logarithms).reshape(len(rows), free, -1)
        turned = (logarithms.reshape(len(rows), free, free) - self.x[rows, np.newaxis]) / RULES.step
        valid = np.isfinite(turned).all(axis=(1, 2))[:, np.newaxis, np.newaxis]
        by_z = np.where(valid, (values - f[:, np.newaxis]) / RULES.step, 0.0)
        by_x = np.linalg.solve(np.where(valid, turned, np.eye(free)), by_z)
        self.by_z[rows], self.by_x[rows] = by_z.transpose(0, 2, 1), by_x.transpose(0, 2, 1)

    def step(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Move places that a step may lower; return which those are, and whether it did."""
        bounds, f, damping = self.coordinates.log_bounds, self.f[rows], self.damping[rows]
        held = _held(self.by_x[rows], self.x[rows], f, bounds)
        in_x, foretold = _steps(self.by_x[rows], f, damping, held)
        going = foretold > RULES.gain * self.S[rows]
        rows, in_x = rows[going], in_x[going]
        gained = np.zeros(len(rows), bool)
        if not len(rows):
            return rows, gained
        in_z, _ = _steps(self.by_z[rows], f[going], damping[going], np.zeros(in_x.shape, bool))
        through = self.coordinates.logarithms(self.z[rows] + in_z)
        for proposed in (np.where(np.isfinite(through), through, self.x[rows]), self.x[rows] + in_x):
            behind = np.flatnonzero(~gained)
            if len(behind):
                gained[behind] = self._move(rows[behind], np.clip(proposed[behind], *bounds))
        self.damping[rows] *= np.where(gained, RULES.eased, RULES.raised)
        return rows, gained

    def _move(self, rows: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Move the places to logarithms that are lower; return which."""
        z, valid = _placed(self.coordinates, x)
        f = self.residuals(z, x)
        S = np.where(valid, np.sum(f**2, axis=1), np.inf)
        lower = self.S[rows] > S
        rows = rows[lower]
        self.x[rows], self.z[rows], self.f[rows], self.S[rows] = x[lower], z[lower], f[lower], S[lower]
        return np.asarray(lower)


def _placed(coordinates: Coordinates, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the coordinates of places, and which of them have any."""
    try:
        return coordinates.of(x), np.ones(len(x), bool)
    except NumericalError:
        z = np.array([_place(coordinates, row) for row in x])
        valid = np.isfinite(z).all(axis=1)
        return np.where(valid[:, np.newaxis], z, 0.0), valid


def _place(coordinates: Coordinates, x: np.ndarray) -> np.ndarray:
    try:
        return coordinates.of(x)
    except NumericalError:
        return np.full(len(x), np.nan)


def _met(z: np.ndarray, S: np.ndarray, moving: np.ndarray, leader: np.ndarray) -> np.ndarray:
    """Return which places go on: of those that meet the lowest. The others follow it, in `leader`."""
    going: list[int] = []
    for row in moving[np.argsort(S[moving], kind="stable")]:
        ahead = next((leads for leads in going if np.max(np.abs(z[row] - z[leads])) < RULES.met), None)
        if ahead is None:
            going.append(int(row))
        else:
            leader[leader == row] = ahead
    return np.array(sorted(going), dtype=int)


def _ends(x: np.ndarray, z: np.ndarray, S: np.ndarray, leader: np.ndarray) -> Descent:
    rows = np.unique(leader[leader >= 0])
    rows = _met(z, S, rows, leader)
    rows = rows[np.argsort(S[rows], kind="stable")]
    number = {int(row): place for place, row in enumerate(rows)}
    return Descent(x[rows], z[rows], S[rows], np.array([number.get(int(row), -1) for row in leader]))


def _held(by_x: np.ndarray, x: np.ndarray, f: np.ndarray, bounds: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Return which logarithms are at their bound and would leave it downhill."""
    uphill = np.einsum("prf,pr->pf", by_x, f)
    return ((x <= bounds[0]) & (uphill > 0)) | ((x >= bounds[1]) & (uphill < 0))


def _steps(jacobian: np.ndarray, f: np.ndarray, damping: np.ndarray, held: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return damped Gauss-Newton steps, and by what they lower S to first order; held parameters do not move.

    None is longer than `RULES.length` in a coordinate.
    """
    jacobian = np.where(held[:, np.newaxis], 0.0, jacobian)
    normal = jacobian.transpose(0, 2, 1) @ jacobian
    diagonal = np.einsum("pff->pf", normal)
    scale = diagonal + 1e-9 * diagonal.max(axis=1, keepdims=True) + 1e-300
    damped = normal + (damping[:, np.newaxis] * scale + held)[..., np.newaxis] * np.eye(held.shape[1])
    uphill = (f[:, np.newaxis] @ jacobian).transpose(0, 2, 1)
    steps = -np.linalg.solve(damped, uphill)
    longest = np.max(np.abs(steps), axis=1, keepdims=True)
    steps = steps * np.minimum(1.0, RULES.length / np.maximum(longest, 1e-300))
    lowered = -(2.0 * uphill + normal @ steps).transpose(0, 2, 1) @ steps
    return steps[..., 0], lowered[:, 0, 0]
