"""
Three wall laws
===============

What the laws say of the same wall: equal stiffness at small strain, different fates above.
"""

import matplotlib.pyplot as plt
import numpy as np

import vasowave as vw
from vasowave.pulse.model import PowerWall

pressure = np.linspace(0, 40, 200)
laws = {
    "linear": vw.LinearWall(beta=60.0),
    "tangent": vw.TangentWall(p1=30.0 / np.pi * 2, gamma=2.0),
    "power, m = 2": PowerWall(beta=60.0, m=2.0),
}
figure, axes = plt.subplots(1, 2, figsize=(7, 3), layout="constrained")
for name, wall in laws.items():
    axes[0].plot(vw.walls.area(wall, pressure, 1.0), pressure, label=name)
    axes[1].plot(pressure, vw.walls.wave_speed(wall, pressure, vw.Blood().inertia), label=name)
    print(f"{name}: β at zero pressure {vw.walls.stiffness(wall):.0f} mmHg")
axes[0].set(xlabel="A/A0", ylabel="pressure [mmHg]")
axes[1].set(xlabel="pressure [mmHg]", ylabel="wave speed [cm/s]")
axes[0].legend()
