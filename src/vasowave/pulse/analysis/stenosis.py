"""The coefficients of a stenosis from the pressures before and beyond it."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from vasowave.base.errors import InputError
from vasowave.pulse.analysis.impedance_spectrum import fourier_series
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.losses import STENOSIS, Stenosis


@dataclass(frozen=True)
class FittedStenosis:
    """Coefficients of a stenosis that two pressures show, with standard errors.

    Attributes
    ----------
    coefficients : Stenosis
        For ``narrowed(..., coefficients=...)``. Steady and pulsatile flow show the sum of the two viscous lengths
        alone, which keep the ratio of the sources. An inertia that noise hides is that of the narrow part's blood.
    viscous_ratio : float
        Viscous term over that of the sources.
    turbulent_sd, viscous_ratio_sd, inertial_sd : float
        Standard errors, by what the fit leaves.
    misfit : float
        Root mean square of what the fit leaves, mmHg.

    Examples
    --------
    >>> import numpy as np, vasowave as vw
    >>> angle = 2 * np.pi * np.arange(64) / 64
    >>> flow, slope = 0.1 + 0.08 * np.sin(angle), 0.08 * 2 * np.pi / 0.1 * np.cos(angle)
    >>> fall = 2.0 * flow + 300.0 * flow**2 + 0.002 * slope  # mmHg
    >>> before, size = vw.Recording(20.0 + fall, flow, 0.1), {"radius": 0.05, "area_lost": 0.8, "length": 0.05}
    >>> found = vw.fit_stenosis(before, np.full(64, 20.0), **size)
    >>> bool(found.misfit < 1e-10)
    True
    """

    coefficients: Stenosis
    viscous_ratio: float
    turbulent_sd: float
    viscous_ratio_sd: float
    inertial_sd: float
    misfit: float


def fit_stenosis(
    before: Recording,
    beyond: np.ndarray,
    *,
    radius: float,
    area_lost: float,
    length: float,
    blood: Blood | None = None,
    harmonics: int = 14,
) -> FittedStenosis:
    """Fit the coefficients of a stenosis to one cycle of the pressures at its two sides (least squares, none negative).

    Δp = K_v μU/D + ½K_t (A/A_s - 1)² ρ|U|U + K_u ρL dU/dt, see `Stenosis`; what vessel lies between the two catheters
    beside the narrowing must be short.

    Parameters
    ----------
    before : Recording
        Pressure before the narrowing, and the flow through it.
    beyond : array, shape (time,)
        Pressure beyond it, mmHg, evenly spaced over the same cycle.
    radius : float
        Of the vessel before the narrowing at mean pressure, cm.
    area_lost : float
        Share of its area that is closed, above 0 and below 1.
    length : float
        Of the narrow part, cm.
    blood : Blood, optional
    harmonics : int
        So many carry signal; the rest is left out as noise.

    Raises
    ------
    InputError
        Signals that are not finite or too short; no geometry; a flow of which nothing tells the terms apart; a fall of
        pressure that comes later than the flow.

    Examples
    --------
    >>> import numpy as np, vasowave as vw
    >>> angle = 2 * np.pi * np.arange(64) / 64
    >>> flow, slope = 0.1 + 0.08 * np.sin(angle), 0.08 * 2 * np.pi / 0.1 * np.cos(angle)
    >>> fall = 2.0 * flow + 300.0 * flow**2 + 0.002 * slope  # mmHg
    >>> before, size = vw.Recording(20.0 + fall, flow, 0.1), {"radius": 0.05, "area_lost": 0.8, "length": 0.05}
    >>> found = vw.fit_stenosis(before, np.full(64, 20.0), **size)
    >>> round(found.coefficients.turbulent, 2), round(found.coefficients.inertial, 2)
    (2.92, 0.4)
    """
    blood = Blood() if blood is None else blood
    _check(radius, area_lost, length)
    fall = _real(fourier_series(before.pressure, harmonics) - fourier_series(beyond, harmonics))
    terms = np.stack([_real(term) for term in _terms(before, radius, area_lost, length, blood, harmonics)], axis=1)
    scale = np.linalg.norm(terms, axis=0)
    if np.any(scale == 0) or np.linalg.cond(terms / scale) > _MAX_CONDITION_NUMBER:
        raise InputError("this flow does not tell the viscous, turbulent and inertial terms of a stenosis apart; give "
                         "one that pulses")  # fmt: skip
    terms /= scale
    factors, misfit = nnls(terms, fall)
    sd = misfit / np.sqrt(len(fall) - len(factors)) * np.sqrt(np.diag(np.linalg.inv(terms.T @ terms)))
    if np.linalg.lstsq(terms, fall, rcond=None)[0][2] < -_MAX_INERTIA_SD * sd[2]:
        raise InputError("the fall of pressure comes later than the flow, which no inertia explains; correct "
                         "the delay between the catheters and the flow")  # fmt: skip
    factors, sd = factors / scale, sd / scale
    return FittedStenosis(
        Stenosis(
            turbulent=float(factors[1]),
            length=float(factors[0] * STENOSIS.length),
            diameter=float(factors[0] * STENOSIS.diameter),
            inertial=float(factors[2]) or None,
        ),
        viscous_ratio=float(factors[0]),
        turbulent_sd=float(sd[1]),
        viscous_ratio_sd=float(sd[0]),
        inertial_sd=float(sd[2]),
        misfit=float(misfit),
    )


_MAX_CONDITION_NUMBER = 1e4  # condition number of the three terms from which nothing tells them apart
_MAX_INERTIA_SD = 4.0  # standard errors below zero from which an inertia is no noise


def _check(radius: float, area_lost: float, length: float) -> None:
    for name, value in (("radius", radius), ("length", length)):
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"{name} = {value:g} cm of a stenosis; give a positive number")
    if not 0 < area_lost < 1:
        raise InputError(f"a stenosis that closes {area_lost:g} of the area; give a share above 0 and below 1")


def _terms(
    recording: Recording, radius: float, area_lost: float, length: float, blood: Blood, harmonics: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the fall of pressure by each term, mmHg, with viscosity as in the sources and K_t = K_u = 1."""
    area = np.pi * radius**2
    narrow, velocity = (1.0 - area_lost) * area, recording.flow / area
    along = STENOSIS.viscous_length(length, 2.0 * np.sqrt(narrow / np.pi))
    share = min(1.0, area_lost / STENOSIS.least_lost)
    viscous = share * 8.0 * np.pi * blood.inertia * blood.viscosity * along / narrow**2
    turbulent = 0.5 * blood.inertia * (area / narrow - 1.0) ** 2 * np.abs(velocity) * velocity
    slope = 2j * np.pi / recording.period * np.arange(harmonics + 1) * fourier_series(velocity, harmonics)
    return (
        viscous * fourier_series(recording.flow, harmonics),
        fourier_series(turbulent, harmonics),
        blood.inertia * length * slope,
    )


def _real(amplitude: np.ndarray) -> np.ndarray:
    """Return as many real numbers, whose sum of squares is the mean square over a cycle."""
    pulse = amplitude[1:] / np.sqrt(2.0)
    return np.concatenate([amplitude.real[:1], pulse.real, pulse.imag])
