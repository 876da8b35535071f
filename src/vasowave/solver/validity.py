"""Where a run may be believed, as findings; and the one case in which it may not at all."""

import math

from vasowave.errors import NumericalError
from vasowave.findings import Finding, Kind, Value, look_kind
from vasowave.solver.extremes import Extreme, Extremes

GRID_SHARE = 0.01  # of the largest pressure: an estimated grid error above it is worth a finding
SETTLED_SHARE = 0.002  # likewise: above it, cells that were chosen by the wave length are halved
_MEANINGLESS = 30.0  # % of the largest pressure: a larger error is no number that means anything
OVERSTRAINED = 3.0  # area strain: twice the radius, at which arteries tear

_GRID = (
    "The answer depends on the grid: a wave too steep for its cells costs {} by the end of vessel '{{vessel}}' at "
    "t = {{time:.4g}} s. {{remedy}}"
)
_FINER = "Ask for an accuracy of the simulation (accuracy=0.02 of Numerics, --accuracy 0.02), or for shorter cells."
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
    percent, found = 100 * error.value / largest_pressure, []
    doubtful = error.value > GRID_SHARE * largest_pressure or not math.isfinite(error.value)
    if doubtful and math.isnan(error_estimate):
        sized = percent < _MEANINGLESS
        found.append(_of(ON_GRID, error, percent=percent) if sized else _of(ON_GRID_ALONE, error))
    if low.value < lowest:
        found.append(_of(COLLAPSES, low))
    if strain.value > OVERSTRAINED:
        found.append(_of(STRAINED, strain, percent=100 * strain.value))
    return tuple(found)


def _of(which: Kind, extreme: Extreme, **values: Value) -> Finding:
    return which(value=extreme.value, time=extreme.time, **values).at(vessel=extreme.vessel)
