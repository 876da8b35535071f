"""Where a run may be believed, in sentences; and the one case in which it may not at all."""

import math

from vasowave.errors import NumericalError
from vasowave.solver.extremes import Extreme, Extremes

GRID_SHARE = 0.01  # of the largest pressure: an estimated grid error above it is worth a sentence
COLLAPSED = -5.0  # mmHg: a wall so thin buckles long before, and neither law knows of it
OVERSTRAINED = 3.0  # area strain: twice the radius, at which arteries tear


def require_subcritical(mach: Extreme) -> None:
    """Raise `NumericalError` where the flow passes the wave speed: no wave then travels upstream to the inlet."""
    if mach.value >= 1.0:
        raise NumericalError(
            f"vessel '{mach.vessel}', t = {mach.time:.4g} s: the flow passes the wave speed (|u|/c = {mach.value:.2f}) "
            "where the conditions at the ends of vessels do not hold; check the units of flow and radius, or stiffen "
            "or widen this vessel"
        )


def notes_of(extremes: Extremes, largest_pressure: float, error_estimate: float = math.nan) -> tuple[str, ...]:
    """Return what a reader must know before believing the waves; empty where nothing is doubtful.

    Nothing of the grid where an accuracy was asked for and two grids tell that it was reached (`error_estimate`, mmHg).
    """
    notes = []
    error, low, strain = extremes.grid_error, extremes.lowest_pressure, extremes.area_strain
    doubtful = error.value > GRID_SHARE * largest_pressure or not math.isfinite(error.value)
    if doubtful and math.isnan(error_estimate):
        share = 100 * error.value / largest_pressure
        size = f"about {error.value:.2g} mmHg ({share:.1f} % of the largest pressure)" if share < 30 else "all meaning"
        notes.append(
            f"The answer depends on the grid: a wave too steep for its cells costs {size} by the end of vessel "
            f"'{error.vessel}' at t = {error.time:.4g} s. Simulate it with Numerics(accuracy=0.02), or with a smaller "
            "cell_size."
        )
    if low.value < COLLAPSED:
        notes.append(
            f"Vessel '{low.vessel}' would collapse: its transmural pressure falls to {low.value:.1f} mmHg at "
            f"t = {low.time:.4g} s, below the range of the wall law. Check the inflow for backflow and the resistance."
        )
    if strain.value > OVERSTRAINED:
        notes.append(
            f"Vessel '{strain.vessel}' is strained beyond what an artery survives: its area grows by "
            f"{100 * strain.value:.0f} % at t = {strain.time:.4g} s. Stiffen the wall, or check pressure and radius."
        )
    return tuple(notes)
