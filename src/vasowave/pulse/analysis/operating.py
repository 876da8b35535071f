"""Area and wave speed about which waves are taken apart: those at one pressure, the same for measurement and models.

Characteristic impedance is measured while the vessel is under pressure, Z_c = ρ c/A. The area that goes with it is that
at the mean pressure, not the one of the image or at zero pressure.
"""

from typing import Literal, NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.walls import area, wave_speed

WavesAt = Literal["mean pressure", "paper"]
"""Where waves take area and wave speed from: at mean pressure, or as the paper does."""

_LOG_STIFFNESS_LIMITS = np.log([1e-6, 1e7])  # mmHg; from no stiffness at all to a rigid tube


class OperatingPoint(NamedTuple):
    """Cross-sectional area (cm²) and wave speed (cm/s) at one pressure."""

    area: float
    wave_speed: float


def measured_operating_point(
    Z_c: float, area: float, inertia: float, pressure: float, image_pressure: float = 0.0
) -> OperatingPoint:
    """Area and wave speed at `pressure` of a vessel whose characteristic impedance is known there (eqs. 3, 8, 31).

    The linear law (eq. 3) carries the measured area to that pressure. Its β is the one for which Z_c = ρ c/A there:
    (β + p_image)⁴/(β + p)³ = 2 (A_image Z_c)²/ρ.

    Parameters
    ----------
    Z_c : float
        mmHg s/ml.
    area : float
        Area in the image, cm².
    inertia : float
        Density, mmHg s²/cm², see `Blood.inertia`.
    pressure, image_pressure : float
        Transmural, mmHg.

    Raises
    ------
    InputError
        A value that is not positive (the image pressure may be 0).

    Examples
    --------
    >>> import vasowave as vw
    >>> from vasowave.pulse.analysis.operating import measured_operating_point
    >>> point = measured_operating_point(15.1, 0.0069, vw.Blood().inertia, pressure=15.5)
    >>> round(point.wave_speed)
    211
    """
    if not (min(Z_c, area, inertia, pressure) > 0 and image_pressure >= 0):
        raise InputError(
            f"Z_c {Z_c:g} mmHg s/ml, area {area:g} cm², density {inertia:g}, pressure {pressure:g} mmHg: all must be "
            "positive"
        )
    from scipy.optimize import brentq

    target = np.log(2 * (area * Z_c) ** 2 / inertia)

    def excess(log_beta: float) -> float:
        beta = np.exp(log_beta)
        return float(4 * np.log(beta + image_pressure) - 3 * np.log(beta + pressure) - target)

    low, high = _LOG_STIFFNESS_LIMITS
    inside = excess(low) < 0 < excess(high)
    beta = np.exp(brentq(excess, low, high) if inside else low if excess(low) >= 0 else high)
    stretched_area = area * ((beta + pressure) / (beta + image_pressure)) ** 2
    return OperatingPoint(float(stretched_area), float(stretched_area * Z_c / inertia))


def operating_point(model: Model, pressure: float) -> OperatingPoint:
    """Area and wave speed of a model's root vessel at `pressure`, mmHg (eqs. 31, 32)."""
    root = model.network.root
    A = np.broadcast_to(area(model.wall, pressure, model.area0), len(model.network))
    c = np.broadcast_to(wave_speed(model.wall, pressure, model.blood.inertia), len(model.network))
    return OperatingPoint(float(A[root]), float(c[root]))
