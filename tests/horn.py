"""A cone and what theory says of waves and of a steady flow in it, for the tests of vessels that taper."""

import numpy as np
from scipy.integrate import solve_ivp

from vasowave.pulse.cycle import Inflow
from vasowave.pulse.network import Network

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


def steady_inlet(law, parameters, blood, flow, period, outlet, length, radius, stiffness):
    """Inlet pressure of a steady flow, from q = const and dp/dx of eq. 2 with A = A0(x) R(p; θ(x)), by Runge and Kutta.

    `radius` and `stiffness` are functions of x; p is a pressure, so that stiffness multiplies the law's pressures.
    """
    k0, k1 = blood.friction.coefficients(blood.viscosity, period)
    first, *others = parameters  # the first is the law's pressure, pure numbers do not change

    def area(x, p):
        return np.pi * radius(x) ** 2 * float(law.ratio_at(p, first * stiffness(x), *others))

    def slope(x, p):
        A, h = area(x, p[0]), 1e-5
        by_place = (area(x + h, p[0]) - area(x - h, p[0])) / (2 * h)
        by_pressure = (area(x, p[0] + h) - area(x, p[0] - h)) / (2 * h)
        drag = (k0 + k1 * np.sqrt(A)) / A
        # (q²/A)' + A/ρ p' = -drag q, with A' = by_place + by_pressure p'
        return [((flow / A) ** 2 * by_place - drag * flow) / (A / blood.inertia - (flow / A) ** 2 * by_pressure)]

    return float(solve_ivp(slope, [length, 0.0], [outlet], rtol=1e-10, atol=1e-10).y[0, -1])
