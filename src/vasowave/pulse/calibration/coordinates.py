"""Coordinates in which a search finds its way: what the data see, in place of the parameters' logarithms.

A recording shows how much the vessels are stretched at its mean pressure, the total resistance, and how that is shared
between its two parts. The stiffness of a stiffening wall at zero pressure, and the two parts apart, follow only from
all of these together, so that in their own logarithms the objective is a long curved valley.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import expit, logit

from vasowave.base.errors import NumericalError
from vasowave.pulse.calibration.parameters import ParameterSpace, trial

_DIFFERENCE_STEP = 1e-6
"""Step of the differences between the two sets of coordinates, which are smooth functions of each other."""
_TURN_SHARPNESS = 4.0  # of the turn from the strain to its distance from the largest; 1 takes 15 % more simulations
_AREA_STRAIN_LIMITS = 1e-4, 50.0  # area strains at mean pressure between which a search may go
_MAX_LOGARITHM = 12.0  # reach of the logarithm of the resistance and of the logit of its ratio


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Coordinates of the free parameters of a space.

    The stiffness becomes the logarithm of the area strain at mean pressure, where the law is proportional to its first
    parameter; near the largest strain of a law that has one, its distance from it takes the strain's place, so that no
    coordinate lies beyond; the two parts of the resistance (`ParameterSpace.shared`), if both are free, become the
    logarithm of the resistance and the logit of its ratio; all others are logarithms.

    Attributes
    ----------
    space : ParameterSpace
    pressure : float
        Mean pressure of the recording, mmHg.
    """

    space: ParameterSpace
    pressure: float

    @cached_property
    def strained(self) -> bool:
        """Whether the first parameter of the wall law is replaced by the strain."""
        wall = self.space.nominal[: len(self.space.law._fields)]
        with trial():
            single, doubled = (self.space.law.pressure_at(1.3, factor * wall[0], *wall[1:]) for factor in (1.0, 2.0))
            return bool(self.space.free[0] and self.pressure > 0 and np.isclose(doubled, 2 * single, rtol=1e-9))

    @cached_property
    def shared(self) -> tuple[int, int] | None:
        """Places of the two parts of the resistance among all parameters, if both are free."""
        places = [self.space.names.index(name) for name in self.space.shared]
        return (places[0], places[1]) if places and self.space.free[places].all() else None

    @cached_property
    def proximal(self) -> float:
        """Share of the first part in the nominal resistance."""
        return self.space.outlets.resistance_ratio()

    def of(self, x: np.ndarray) -> np.ndarray:
        """Return the coordinates of the logarithms `x` of the free parameters, shape (..., free).

        Raises
        ------
        NumericalError
            The law says nothing there.
        """
        values = self._values(x)
        coordinates = np.log(values)
        if self.strained:
            wall = self._wall(values)
            with trial():
                strain = np.asarray(self.space.law.ratio_at(self.pressure, *wall)) - 1.0
                excess = strain**-_TURN_SHARPNESS - self._largest_strain(wall) ** -_TURN_SHARPNESS
                coordinates[..., 0] = -np.log(excess) / _TURN_SHARPNESS
            if not np.isfinite(coordinates[..., 0]).all():
                raise NumericalError("the wall law has no strain at mean pressure there")
        if self.shared is not None:
            first, second = self.shared
            proximal, distal = self.proximal * values[..., first], (1 - self.proximal) * values[..., second]
            coordinates[..., first] = np.log(proximal + distal)
            coordinates[..., second] = logit(proximal / (proximal + distal))
        return coordinates[..., self.space.free]

    def logarithms(self, z: np.ndarray) -> np.ndarray:
        """Return the logarithms of the free parameters at the coordinates `z`; NaN where there are none.

        Only laws whose equations do not say up to which strain they hold leave places without parameters. Both have
        the shape (..., free).
        """
        values = self._values(z)
        if self.shared is not None:
            first, second = self.shared
            total, ratio = values[..., first].copy(), expit(np.log(values[..., second]))
            values[..., first] = total * ratio / self.proximal
            values[..., second] = total * (1 - ratio) / (1 - self.proximal)
        if self.strained:
            values[..., 0] = self._stiffness(np.log(values[..., 0]), values)
        return np.log(values[..., self.space.free])

    def _values(self, x: np.ndarray) -> np.ndarray:
        """Return all parameters, the free ones e to the `x`."""
        values = np.broadcast_to(self.space.nominal, (*x.shape[:-1], len(self.space.nominal))).copy()
        values[..., self.space.free] = np.exp(x)
        return values

    def _wall(self, values: np.ndarray) -> list[np.ndarray]:
        """Return the parameters of the wall law."""
        return [values[..., number] for number in range(len(self.space.law._fields))]

    def _stiffness(self, place: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the law's first parameter at the coordinate of the strain, NaN where there is none."""
        wall = self._wall(values)
        try:
            with trial():
                largest = self._largest_strain(wall)
                strain = (np.exp(-_TURN_SHARPNESS * place) + largest**-_TURN_SHARPNESS) ** (-1 / _TURN_SHARPNESS)
                unit = np.asarray(self.space.law.pressure_at(1.0 + strain, np.ones_like(place), *wall[1:]), dtype=float)
        except NumericalError:
            return np.full(place.shape, np.nan)
        with np.errstate(all="ignore"):
            return np.where((unit > 0) & np.isfinite(unit), self.pressure / unit, np.nan)

    def _largest_strain(self, wall: list[np.ndarray]) -> np.ndarray:
        """Return the strain that the law cannot reach, whatever its first parameter; infinite where there is none."""
        return np.asarray(self.space.law.limits(np.ones_like(wall[0]), *wall[1:])[1]) - 1.0

    def slopes(self, z: np.ndarray) -> np.ndarray:
        """Return the derivatives of `logarithms` by the coordinates, shape (free, free)."""
        steps = _DIFFERENCE_STEP * np.eye(len(z))
        return np.stack(
            [(self.logarithms(z + h) - self.logarithms(z - h)) / (2 * _DIFFERENCE_STEP) for h in steps], axis=1
        )

    @property
    def free(self) -> int:
        """The number of free parameters."""
        return int(np.count_nonzero(self.space.free))

    @property
    def log_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of the logarithms of the free parameters."""
        return self.space.log_bounds

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates between which a search may go; the bounds of the parameters are not all among them."""
        low, high = np.log(self.space.lower), np.log(self.space.upper)
        if self.strained:
            low[0], high[0] = np.log(_AREA_STRAIN_LIMITS)
        if self.shared is not None:
            low[list(self.shared)], high[list(self.shared)] = -_MAX_LOGARITHM, _MAX_LOGARITHM
        return low[self.space.free], high[self.space.free]
