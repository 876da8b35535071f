"""A cone and what theory says of waves in it, for the tests of vessels that taper."""

import numpy as np

from vasowave.network.network import Network
from vasowave.recording import Inflow

LENGTH, RADIUS, FALL, BETA = 2.0, 0.04, 0.6, 4000.0
TUBE = Network(("only",), [-1], [LENGTH], [RADIUS])
FLOW = Inflow(1e-5 * (1 + np.cos(2 * np.pi * np.arange(64) / 64) + 0.5 * np.sin(6 * np.pi * np.arange(64) / 64)), 0.05)


def horn_impedance(omega, speed, density, load):
    """Input impedance of a cone without friction, from the spherical waves in it (Webster's horn equation)."""
    wide, thin = RADIUS * (1 + FALL / 2), RADIUS * (1 - FALL / 2)
    far = LENGTH * wide / (wide - thin)  # distance of the inlet from the cone's tip
    k = omega / speed

    def waves(x):
        """Pressure and flow of both spherical waves at a distance x from the tip, the flow away from the heart."""
        area = np.pi * (wide * x / far) ** 2
        p = np.array([np.exp(1j * k * x), np.exp(-1j * k * x)]) / x
        slope = np.array([(1j * k - 1 / x), (-1j * k - 1 / x)]) * p
        return p, area / (1j * omega * density) * slope  # q = -A/(iωρ) dp/ds, and s runs against x

    p, q = waves(far - LENGTH)
    ratio = -(p[0] - load * q[0]) / (p[1] - load * q[1])
    p, q = waves(far)
    return (p[0] + ratio * p[1]) / (q[0] + ratio * q[1])
