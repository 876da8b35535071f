"""A flow that was recorded as a velocity, as by Doppler: times the area of the vessel."""

import math

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind

FLOW_OF_VELOCITY = look_kind(
    "recording.flow-of-velocity",
    "the flow is the velocity times {area:.4g} cm² (a diameter of {diameter:.4g} mm), as if it were the mean over the "
    "cross-section. {remedy}",
    "Of a velocity on the axis or the edge of a Doppler spectrum say its share: a flow gain of 0.5 (a parabola) to 1 "
    "(flat); an error of the diameter counts twice in the flow.",
)
_DIAMETERS_MM = 0.05, 100.0


def flow_of_velocity(velocity: np.ndarray, diameter: float) -> tuple[np.ndarray, Finding]:
    """Return flow, ml/s, of a mean velocity, cm/s, in a vessel of a diameter, mm, and what is to be known of it."""
    if not _DIAMETERS_MM[0] <= diameter <= _DIAMETERS_MM[1]:
        raise InputError(f"a diameter of {diameter:g} mm is no artery's; give it in mm")
    area = math.pi * (diameter / 10.0) ** 2 / 4.0
    return velocity * area, FLOW_OF_VELOCITY(area=area, diameter=diameter)
