"""What follows from a point without a simulation: wave speed, stiffness, resistance and compliance of the beds."""

import numpy as np

from vasowave.descriptions import Quantity
from vasowave.model import Model
from vasowave.walls import stiffness, wave_speed

QUANTITIES = {
    "stiffness": Quantity("mmHg", "β(0)", "stiffness of the root at zero pressure, as of a linear wall", "24"),
    "wave_speed": Quantity("cm/s", "c", "wave speed in the root at the measured mean pressure", "31, 32"),
    "R_T": Quantity("mmHg s/ml", "R_T", "total resistance of the vascular beds", "11"),
    "a": Quantity("1", "a = R_1/R_T", "resistance ratio", "7"),
    "C_p": Quantity("ml/mmHg", "C_p", "weighted compliance of the vascular beds", "30"),
}
"""Derived quantities by name."""


def derived(model: Model, mean_pressure: float) -> dict[str, float]:
    """Return the quantities of a model; the wave speed at `mean_pressure` (mmHg)."""
    root = model.network.root
    wall = type(model.wall)(*(value[root] for value in model.wall))
    return {
        "stiffness": float(stiffness(wall)),
        "wave_speed": float(wave_speed(wall, mean_pressure, model.blood.inertia)),
        "R_T": model.outlets.total_resistance(),
        "a": model.outlets.resistance_ratio(),
        "C_p": float(np.sum(model.outlets.weighted_compliance())),
    }
