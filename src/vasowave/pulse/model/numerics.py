"""How finely and how long to simulate."""

import math
from typing import Annotated

from annotated_types import Ge

from vasowave.base.errors import InputError
from vasowave.base.settings import Positive, settings_class

_FEW = 4  # steps a sample, above which a multiple of the samples costs little
_MANY = 16  # steps a sample, above which one of twice the samples does
_FRONT = 4  # steps in which a front as steep as cells can carry passes


@settings_class
class Resolution:
    """How finely the model is simulated."""

    cell_size: Positive | None = None
    """Longest cell, cm; by default a thirty-second of the shortest wave length that matters, and 0.1 or more. A vessel
    shorter than that has one cell if little pressure is lost in it, else two or more."""
    tolerance: Positive = 1e-4
    """Largest change from cycle to cycle that counts as periodic, mmHg. The paper's criterion is a squared change
    below 1e-8, here asked of every cell and every outlet."""
    most_cycles: Annotated[int, Ge(2)] = 60
    """Cycles after which a state that is still not periodic is an error."""
    cycles_from_rest: Annotated[int, Ge(1)] | None = None
    """Exactly this many cycles from rest, periodic or not (the paper's practice: 8)."""


@settings_class
class Numerics(Resolution):
    """How finely and how long to simulate; the defaults take cells and steps from the waves.

    ``Numerics(accuracy=0.02)`` is the ordinary way to ask where the default may not do: cells and steps follow from it.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Numerics(accuracy=0.02).samples  # mmHg asked for; cells and steps follow
    512
    """

    accuracy: Positive | None = None
    """Largest error of pressure at inlet, middle and outlet of every vessel that space and time steps may leave, mmHg.
    It is estimated from two grids and reported; what cannot be reached is an error."""
    samples: Annotated[int, Ge(1)] = 512
    """Evenly spaced output times per cycle."""
    steps_per_cycle: Annotated[int, Ge(1)] | None = None
    """Time steps a cycle, a multiple of a quarter of `samples`, or from rest of `samples`; by default chosen from the
    wave speeds met."""
    most_steps: Annotated[int, Ge(1)] = 100_000
    """A model that asks for more steps a cycle is an error, which says which vessel asks for them."""
    every_cell: bool = False
    """Return every cell instead of inlet, middle and outlet of each vessel."""

    def __post_init__(self) -> None:
        """Check what belongs together."""
        if self.accuracy is not None and (self.steps_per_cycle is not None or self.cycles_from_rest is not None):
            raise InputError("accuracy chooses steps and cycles: leave steps_per_cycle and cycles_from_rest out")
        steps = self.steps_per_cycle
        if steps is not None and (steps < self.samples or steps % self._unit):
            raise InputError(
                f"steps_per_cycle {steps} is less than samples {self.samples} or no multiple of {self._unit}; "
                f"take {self.steps_for(steps)}"
            )

    @property
    def _unit(self) -> int:
        """Of what steps are a multiple."""
        return self.samples if self.samples % 4 or self.cycles_from_rest is not None else self.samples // 4

    def steps_for(self, demand: float) -> int:
        """Return the least steps a cycle that serve a demand and the samples.

        They are a multiple of the samples or, where that would cost much and the cycle is periodic, so that what lies
        between two steps is known, of a quarter of them; where it costs little, of twice as many.
        """
        unit = self._unit_at(demand)
        return max(self.samples, math.ceil(demand / unit) * unit)

    @property
    def largest_steps(self) -> int:
        """The most steps a cycle that serve the samples and stay within `most_steps`."""
        unit = self._unit_at(self.most_steps)
        return max(self.samples, self.most_steps // unit * unit)

    def _unit_at(self, steps: float) -> int:
        if steps <= _FEW * self.samples:
            return self._unit
        return 2 * self.samples if steps > _MANY * self.samples else self.samples

    def kept_every(self, steps: int) -> int:
        """Return from how many steps one is kept: all samples are among those, and no front passes between two."""
        among = self.samples if steps % self.samples == 0 else 1
        max_stride = min(_FRONT, steps // self.samples)
        return next(stride for stride in range(max_stride, 0, -1) if steps % (stride * among) == 0)
