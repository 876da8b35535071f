"""Where a run may be believed: what its waves reach at most, as findings; and the one case in which not at all."""

import math
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import NumericalError
from vasowave.base.findings import Finding, FindingKind, Value, look_kind
from vasowave.pulse.model import walls
from vasowave.pulse.model.model import Model
from vasowave.pulse.solver.grid import Grid
from vasowave.pulse.solver.grid_error import Judged

GRID_SHARE = 0.01  # of the largest pressure: an estimated grid error above it is worth a finding
SETTLED_SHARE = 0.002  # likewise: above it, cells that were chosen by the wave length are halved
_MEANINGLESS = 30.0  # % of the largest pressure: a larger error is not a number that means anything
OVERSTRAINED = 3.0  # area strain: twice the radius, at which arteries tear
_GRID = (
    "The answer depends on the grid: a wave too steep for its cells costs {} by the end of vessel '{{vessel}}' at "
    "t = {{time:.4g}} s. {{remedy}}"
)
_FINER = "Ask for an accuracy of the simulation, as of 0.02, or for shorter cells."
ON_GRID = look_kind(
    "solver.depends-on-grid", _GRID.format("about {value:.2g} mmHg ({percent:.1f} % of the largest pressure)"), _FINER
)
ON_GRID_ALONE = look_kind("solver.depends-on-grid-alone", _GRID.format("all meaning"), _FINER)
COLLAPSES = look_kind(
    "solver.vessel-collapses",
    "Vessel '{vessel}' would collapse: its transmural pressure falls to {value:.1f} mmHg at t = {time:.4g} s, "
    "below the range of the wall law. {remedy}",
    "Check the inflow for backflow and the resistance.",
)
STRAINED = look_kind(
    "solver.vessel-overstrained",
    "Vessel '{vessel}' is strained beyond what an artery survives: its area grows by {percent:.0f} % at "
    "t = {time:.4g} s. {remedy}",
    "Stiffen the wall, or check pressure and radius.",
)

BED_SHARE = 0.005  # of the impedance at the signal's harmonics: a larger error of the function that is stepped is told
BED_MISSED = look_kind(
    "solver.bed-approximated",
    "The bed behind vessel '{vessel}' is stepped as a function that misses its impedance by up to {percent:.2g} % at "
    "the harmonics 1 to 10. {remedy}",
    "Give its spectrum at more harmonics, or its widest vessels as vessels of the network; the noise of a measured "
    "spectrum is smoothed and needs no remedy.",
)

REYNOLDS = 10.0, 1000.0  # U D/ν of the largest flow, of which Young and Tsai measured narrowings
OUTSIDE_RANGE = look_kind(
    "solver.stenosis-beyond-its-source",
    "The flow before '{vessel}' reaches a Reynolds number of {value:.3g}; a narrowing's coefficients were measured "
    "from {low:.3g} to {high:.3g}. {remedy}",
    "Check flow and radius; other coefficients may hold there.",
)


class Extreme(NamedTuple):
    """The most extreme value of one quantity, the vessel that has it and the time, s."""

    value: float
    vessel: str
    time: float


class Extremes(NamedTuple):
    """The most extreme values in all vessels.

    Attributes
    ----------
    steepness : Extreme
        Largest share of a vessel's pulse pressure that lies within one cell, 1: |∂p/∂t| dx/c over the range of p.
    lowest_pressure : Extreme
        Transmural, at the output times, mmHg.
    area_strain : Extreme
        Largest area over that of the network, minus 1, at the output times.
    grid_error : Extreme
        Error of the pressure, mmHg: what the cells' dispersion leaves by the end of a vessel, summed from the root and
        over echoes, and what a straight line across a cell misses of the pressure where drag bends it; or, where it is
        more, what another grid shows of how a shape bends within cells.
    """

    steepness: Extreme
    lowest_pressure: Extreme
    area_strain: Extreme
    grid_error: Extreme


def find_extremes(grid: Grid, period: float, p: np.ndarray, judged: Judged) -> Extremes:
    """Return the extremes of the waves of pressure (mmHg, shape (sample, station, vessel)) on a grid, as `judged`."""
    network = grid.model.network
    wall, area0 = grid.at_stations
    widest = walls.area(wall, p.max(axis=0), area0)  # a larger pressure is a larger area
    strain = np.asarray(widest / walls.area(wall, network.pressure, area0)) - 1.0

    def at_stations(values: np.ndarray, samples: np.ndarray, sign: float = 1.0) -> Extreme:
        station, vessel = np.unravel_index(np.argmax(sign * values), values.shape)
        time = float(samples[station, vessel] * period / len(p))
        return Extreme(float(values[station, vessel]), network.name[vessel], time)

    def in_vessels(values: np.ndarray, times: np.ndarray) -> Extreme:
        vessel = np.argmax(values)
        return Extreme(float(values[vessel]), network.name[vessel], float(times[vessel]))

    return Extremes(
        in_vessels(judged.steepness, judged.steepest),
        at_stations(p.min(axis=0), p.argmin(axis=0), -1.0),
        at_stations(strain, p.argmax(axis=0)),
        in_vessels(judged.error, judged.worst),
    )


def require_subcritical(mach: Extreme) -> None:
    """Raise `NumericalError` where the flow passes the wave speed: no wave then travels upstream to the inlet."""
    if mach.value >= 1.0:
        raise NumericalError(
            f"vessel '{mach.vessel}', t = {mach.time:.4g} s: the flow passes the wave speed (|u|/c = {mach.value:.2f}) "
            "where the conditions at the ends of vessels do not hold; check the units of flow and radius, or stiffen "
            "or widen this vessel"
        )


def notes_of(
    extremes: Extremes, largest_pressure: float, lowest: float, error_estimate: float = math.nan
) -> tuple[Finding, ...]:
    """Return what a reader must know before believing the waves; empty where nothing is doubtful.

    `largest_pressure` is the largest magnitude, `lowest` what the wall law holds down to, mmHg. Nothing of the grid
    where an accuracy was asked for and two grids tell that it was reached (`error_estimate`, mmHg).
    """
    error, low, strain = extremes.grid_error, extremes.lowest_pressure, extremes.area_strain
    percent, findings = 100 * error.value / largest_pressure, []
    doubtful = error.value > GRID_SHARE * largest_pressure or not math.isfinite(error.value)
    if doubtful and math.isnan(error_estimate):
        sized = percent < _MEANINGLESS
        findings.append(_of(ON_GRID, error, percent=percent) if sized else _of(ON_GRID_ALONE, error))
    if low.value < lowest:
        findings.append(_of(COLLAPSES, low))
    if strain.value > OVERSTRAINED:
        findings.append(_of(STRAINED, strain, percent=100 * strain.value))
    return tuple(findings)


def notes_of_narrowings(model: Model, area: np.ndarray, flow: np.ndarray) -> tuple[Finding, ...]:
    """Return where the flow before a narrowing leaves the range of its source, by area (cm²) and flow at outlets.

    Both have the shape (time, vessel). Reynolds numbers are those of the largest flow in the cycle.
    """
    findings, (low, high) = [], REYNOLDS
    for row in np.flatnonzero(model.narrowings):
        before = np.flatnonzero(model.network.end == model.network.start[row])[0]
        diameter = np.sqrt(4.0 * area[:, before] / np.pi)
        speed = np.abs(flow[:, before]) / area[:, before]
        reynolds = float(np.max(speed * diameter)) / model.blood.viscosity
        if not low <= reynolds <= high:
            findings.append(OUTSIDE_RANGE(value=reynolds, low=low, high=high).at(vessel=model.network.name[row]))
    return tuple(findings)


def notes_of_beds(model: Model, period: float) -> tuple[Finding, ...]:
    """Return what a reader must know of beds that are stepped as functions near to them: of the worst of them."""
    missed = model.outlets.misfit(period)
    worst = int(np.argmax(missed))
    if not missed[worst] > BED_SHARE:
        return ()
    name = model.network.name[model.network.terminals[worst]]
    return (BED_MISSED(percent=100 * float(missed[worst])).at(vessel=name),)


def _of(kind: FindingKind, extreme: Extreme, **values: Value) -> Finding:
    return kind(value=extreme.value, time=extreme.time, **values).at(vessel=extreme.vessel)
