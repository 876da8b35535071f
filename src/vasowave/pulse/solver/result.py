"""A finished simulation as bare arrays."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vasowave.base.findings import Finding
from vasowave.pulse.cycle.cycle import resample
from vasowave.pulse.model import walls
from vasowave.pulse.model.model import Model
from vasowave.pulse.solver.grid import Grid
from vasowave.pulse.solver.grid_error import judge
from vasowave.pulse.solver.middles import Middles, find_middles
from vasowave.pulse.solver.periodic import Convergence
from vasowave.pulse.solver.state import Scale, State
from vasowave.pulse.solver.validity import (
    OVERSTRAINED,
    SETTLED_SHARE,
    Extreme,
    Extremes,
    find_extremes,
    notes_of,
    notes_of_beds,
    notes_of_narrowings,
)

_AT_ONCE = 200_000  # values of a wave that are worked on together: more leave the processor's cache
_BENT = 0.45  # change of the logarithm of the radius along a vessel up to which waves tell the error of a taper


@dataclass(frozen=True, eq=False)
class Run:
    """A finished simulation as bare arrays.

    Attributes
    ----------
    grid : Grid
    period : float
        s.
    steps : int
        Steps per cycle.
    samples : int
        Output times per cycle.
    at_inlet : array, shape (kind, step)
        Area (cm²), flow (ml/s) and, where walls are viscous, their viscous pressure (mmHg): at the root's inlet at
        every step.
    recorded : array, shape (kind, step, vessel, 3)
        The same at inlet, middle, outlet, at every step or every k-th, so that the samples can be made of them; k such
        that a front may not pass between two unseen.
    cells : array, shape (kind, sample, slot)
        The same in every slot; no samples unless every cell was asked for.
    end : State
        State at the end of the cycle.
    convergence : Convergence
    scale : Scale
        Of the variables, in which the convergence was judged.
    courant : float
        Largest Courant number of the last cycle.
    mach : Extreme
        Largest |u|/c of the last cycle.
    volume_error : float
        Inflow minus outflow minus what was stored over the last cycle, as a share of the mean |inflow|.
    tolerance : float
        mmHg.
    error_estimate : float
        Of the pressures, mmHg, where an accuracy was asked for; else NaN.
    two_grids : Extreme, optional
        Largest error of the pressures that another grid shows, mmHg, where one was looked at.
    """

    grid: Grid
    period: float
    steps: int
    samples: int
    at_inlet: np.ndarray
    recorded: np.ndarray
    cells: np.ndarray
    end: State
    convergence: Convergence
    scale: Scale
    courant: float
    mach: Extreme
    volume_error: float
    tolerance: float
    error_estimate: float = math.nan
    two_grids: Extreme | None = None

    @property
    def model(self) -> Model:
        """The model that was simulated."""
        return self.grid.model

    @cached_property
    def stations(self) -> np.ndarray:
        """`recorded` at the output times, shape (kind, sample, vessel, 3)."""
        return at_samples(self.recorded, self.samples, axis=1)

    @cached_property
    def middles(self) -> Middles:
        """What one cell misses of the middles of vessels along which much pressure is lost."""
        return find_middles(self.model, self.period, self.recorded)

    @cached_property
    def extremes(self) -> Extremes:
        """What the waves reach at most, at the output times; how steep and wrong they are, at all recorded."""
        judged = judge(self.grid, self.period, self.steps, self.recorded[0], self.middles)
        reached = find_extremes(self.grid, self.period, self.pressure, judged)
        shown = self.two_grids
        return (
            reached if shown is None or shown.value < reached.grid_error.value else reached._replace(grid_error=shown)
        )

    @cached_property
    def largest_pressure(self) -> float:
        """Largest magnitude of the pressure at the output times, mmHg."""
        return float(np.maximum(np.max(self.pressure), -np.min(self.pressure)))

    @property
    def settled(self) -> bool:
        """Whether the estimated error of the grid is far below what a note says."""
        return bool(self.extremes.grid_error.value <= SETTLED_SHARE * self.largest_pressure)

    @cached_property
    def notes(self) -> tuple[Finding, ...]:
        """What a reader must know before believing the waves."""
        lowest = self.model.wall.law().lowest
        of_waves = notes_of(self.extremes, self.largest_pressure, lowest, self.error_estimate)
        at_outlets = self.recorded[0, :, :, 2], self.recorded[1, :, :, 2]
        of_parts = *notes_of_beds(self.model, self.period), *notes_of_narrowings(self.model, *at_outlets)
        return *of_waves, *of_parts

    @cached_property
    def pressure(self) -> np.ndarray:
        """Pressure at inlet, middle and outlet, mmHg, shape (sample, station, vessel)."""
        area = np.moveaxis(self.stations[0], 1, -1)
        wall, area0 = self.grid.at_stations
        elastic = in_blocks(lambda values: walls.pressure(wall, values, area0), area)
        return with_viscous(elastic, np.moveaxis(self.stations, 2, -1))

    def inlet_pressure(self, samples: int) -> np.ndarray:
        """Pressure at the root's inlet, mmHg, at `samples` evenly spaced times of the cycle."""
        wall, area0 = self.model.at(self.model.network.root, 0.0)
        pressure = walls.pressure(wall, self.at_inlet[0], area0)
        return at_samples(with_viscous(pressure, self.at_inlet), samples)


def difference(run: Run, reference: Run) -> Extreme:
    """Return the largest error of a run's pressures that another on half or twice its cells shows, mmHg.

    Of order 1, for shapes bend and walls give way within the cells, it is the whole difference.
    """
    distance = np.abs(run.pressure - reference.pressure)
    sample, station, vessel = np.unravel_index(np.argmax(distance), distance.shape)
    name, time = run.model.network.name[vessel], float(sample * run.period / len(distance))
    return Extreme(float(distance[sample, station, vessel]), name, time)


def needs_two_grids(run: Run) -> bool:
    """Whether what a run says of its own error leaves out what may be most of it.

    Its waves do not show how a shape bends within the cells, nor how far cells of a wall that gives way are from the
    linear theory by which they were chosen.
    """
    shape = run.model.profile
    bent = shape is not None and (shape.pieces > 1 or float(np.max(shape.bend)) > _BENT)
    return bent or _strain(run) > OVERSTRAINED


def _strain(run: Run) -> float:
    """Return the largest area in the middle of a vessel over that of the image, minus 1."""
    model = run.model
    area = model.image_area(np.arange(len(model.network)), np.full(len(model.network), 0.5))
    return float(np.max(run.recorded[0, :, :, 1].max(axis=0) / area)) - 1.0


def with_viscous(pressure: walls.Values, kinds: np.ndarray) -> np.ndarray:
    """Return the pressure of a wall, mmHg, from that of its law and what was seen of it, shape (kind, ...)."""
    return np.asarray(pressure + kinds[2]) if len(kinds) > 2 else np.asarray(pressure)


def at_samples(signal: np.ndarray, samples: int, axis: int = 0) -> np.ndarray:
    """Return what is known at evenly spaced times of a cycle, along an axis, at `samples` others."""
    signal = np.moveaxis(signal, axis, 0)
    if len(signal) % samples == 0:
        return np.moveaxis(signal[:: len(signal) // samples], 0, axis)
    chosen = np.empty((samples, *signal.shape[1:]))
    widest = int(np.argmax(signal.shape[1:])) + 1 if signal.ndim > 1 else 0
    if not widest:
        return resample(signal, samples)
    block = max(1, _AT_ONCE * signal.shape[widest] // max(1, signal.size))
    for first in range(0, signal.shape[widest], block):
        window = (*(slice(None),) * widest, slice(first, first + block))
        chosen[window] = resample(signal[window], samples)
    return np.moveaxis(chosen, 0, axis)


def in_blocks(function: Callable[[np.ndarray], walls.Values], values: np.ndarray) -> np.ndarray:
    """Return a function of values, whose times stand on the first axis, from a few times after another."""
    result = np.empty_like(values)
    block = max(1, _AT_ONCE * len(values) // max(1, values.size))
    for first in range(0, len(values), block):
        result[first : first + block] = function(values[first : first + block])
    return result
