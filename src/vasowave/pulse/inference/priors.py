"""What is assumed before the recording is seen: priors of parameters, geometry, structure, and of the model's error."""

from collections.abc import Mapping
from dataclasses import field
from typing import Annotated

from annotated_types import Ge, Gt, Le

from vasowave.base.settings import Positive, settings_class
from vasowave.pulse.inference.known_errors import KnownErrors
from vasowave.pulse.noise.spectrum import SIZE_PRIOR

Spread = Annotated[float, Ge(0), Le(2)]


@settings_class
class Priors(KnownErrors):
    """Priors of one animal, with the errors that are known. All are normal, of logarithms where a number is positive;
    an SD of 0 fixes it.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Priors(radius_scale_sd=0.1, parameters={"c1": (1.0, 0.3)}).radius_scale_sd
    0.1
    """

    parameters: Mapping[str, tuple[Positive, Spread]] = field(default_factory=dict)
    """Median (in the unit of the parameter) and SD of the logarithm of single parameters of the model, in place of the
    nominal value and the parameter's own (`descriptions.Parameter.spread`)."""
    radius: Spread = 0.05
    """SD of the logarithm of each vessel's own error, where the network has no ``radius_sd`` (cm)."""
    length: Spread = 0.05
    """As `radius`, of lengths."""
    taper: Spread = 0.3
    """SD of what a vessel's radius falls from inlet to outlet, as a share of its radius, around 0, before its taper was
    measured; only where the network has one."""
    taper_scale: Spread = 0.1
    """SD of a factor common to all measured tapers, around 1: blur, and contrast that fades along a vessel."""
    wedge: Annotated[float, Ge(0)] = 0.0
    """SD of the pressure behind the vascular beds around the recording's wedge pressure, mmHg."""
    discrepancy: tuple[Annotated[float, Gt(0), Le(0.2)], Spread] = SIZE_PRIOR
    """Median, as a share of the pulse pressure, and SD of the logarithm of the standard deviation of what no parameters
    of the model explain."""
