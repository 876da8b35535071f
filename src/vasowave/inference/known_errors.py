"""Errors that a lab knows of image, probe and transducer: one list, of which priors, columns and keys are made."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, Any, NamedTuple, get_type_hints

import numpy as np
from annotated_types import Ge, Le

from vasowave.model.blood import Blood
from vasowave.network.network import Network
from vasowave.recording import Recording
from vasowave.settings import settings_class, settings_of

SHARED = {
    "image": "Animals whose vessels come from one image or one calibration of it have the same word here; empty: by "
    "equal networks. The error of an image moves them together.",
    "probe": "Animals whose flow one probe measured have the same word; empty: each animal has its own error.",
    "calibration": "Animals that were recorded after one calibration of the pressure, likewise.",
}
"""What animals may share with its errors: column of the table of animals and meaning."""


SOURCES = ("recording", *reversed(SHARED), "model", "prior")
"""Where the variance of an estimate comes from: errors of measurement; zero of the pressure; gain and delay of the flow
probe; geometry; discrepancy and structure; parameters that the data leave where they were."""


class Seen(NamedTuple):
    """What was measured of an animal."""

    network: Network
    recording: Recording
    blood: Blood


@dataclass(frozen=True, eq=False)
class Kind:
    """An unknown that an error is of.

    Attributes
    ----------
    unit, meaning : str
        Of the unknown; `unit` is that of the error, too, where it is not a share.
    usual : float
        SD that posteriors assume where nothing is said.
    source : str
        Where it comes from: a key of `SHARED`, or ``model``, of which every animal has its own.
    positive : bool
        Whether the error is the SD of a logarithm.
    without : callable
        Returns what would have been seen without the error, from what was seen and the unknown's value.
    center : callable
        Returns the unknown's median; 0 of a positive one where an animal does not have it.
    """

    unit: str
    meaning: str
    usual: float
    source: str
    positive: bool
    without: Callable[[Seen, float], Seen]
    center: Callable[[Seen], float]


def _one(_: Seen) -> float:
    return 1.0


def _none(_: Seen) -> float:
    return 0.0


def _wider(seen: Seen, factor: float) -> Seen:
    return seen._replace(network=seen.network.resized(radius=seen.network.radius * factor))


def _longer(seen: Seen, factor: float) -> Seen:
    return seen._replace(network=seen.network.resized(length=seen.network.length * factor))


def _filled(seen: Seen, pressure: float) -> Seen:
    return seen._replace(network=seen.network.resized(pressure=pressure))


def _more_flow(seen: Seen, factor: float) -> Seen:
    return seen._replace(recording=replace(seen.recording, flow=seen.recording.flow * factor))


def _later_flow(seen: Seen, delay: float) -> Seen:
    """Return what was seen with its flow as late as it was in truth: the probe showed it `delay` too late."""
    flow, period = seen.recording.flow, seen.recording.period
    turned = np.fft.rfft(flow) * np.exp(2j * np.pi * np.arange(len(flow) // 2 + 1) * delay / period)
    return seen._replace(recording=replace(seen.recording, flow=np.fft.irfft(turned, len(flow))))


def _lower_pressure(seen: Seen, zero: float) -> Seen:
    return seen._replace(recording=replace(seen.recording, pressure=seen.recording.pressure - zero))


def _thicker(seen: Seen, factor: float) -> Seen:
    return seen._replace(blood=replace(seen.blood, viscosity=seen.blood.viscosity * float(factor)))


def _same(seen: Seen, _: float) -> Seen:
    return seen


_Share = Annotated[float, Ge(0), Le(2)]
_SD = Annotated[float, Ge(0)]


@settings_class
class KnownErrors:
    """How far image, probe and transducer may be wrong: the SD of each error. Where nothing is said fits take the
    number for exact, and posteriors assume what is usual; a column of the table of animals of the same name takes the
    place of a key here.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.KnownErrors(flow_gain_sd=0.07).flow_gain_sd
    0.07
    """

    radius_scale_sd: Annotated[_Share | None, Kind("1", "factor of all radii", 0.05, "image", True, _wider, _one)] = (
        None
    )
    """Of a factor common to all radii, as a share: threshold and voxel size of the image. Usual: 0.05."""
    length_scale_sd: Annotated[
        _Share | None, Kind("1", "factor of all lengths", 0.05, "image", True, _longer, _one)
    ] = None
    """Likewise of lengths. Usual: 0.05."""
    k_sd: Annotated[
        _Share | None, Kind("1", "exponent of a stiffness ∝ radius^-k", 0.5, "model", False, _same, _none)
    ] = None
    """Of the exponent k of a wall stiffness that varies with the radius, β ∝ (r/r_root)^-k, around 0. Usual: 0.5; in
    pulmonary arteries distensibility is nearly uniform (k = 0), down the systemic ones k near 0.7 is usual."""
    image_pressure_sd: Annotated[
        _Share | None,
        Kind("mmHg", "pressure at which the image was taken", 0.3, "image", True, _filled,
             lambda seen: seen.network.pressure),
    ] = None  # fmt: skip
    """Of the pressure at which the image was taken, as a share of it, where it is known. Usual: 0.3."""
    flow_gain_sd: Annotated[
        _Share | None, Kind("1", "true over measured flow", 0.0, "probe", True, _more_flow, _one)
    ] = None
    """Of the gain of the flow probe, as a share. Usual: 0, the probe is taken to be calibrated."""
    flow_delay_sd: Annotated[
        _SD | None, Kind("s", "delay of the measured flow", 0.0, "probe", False, _later_flow, _none)
    ] = None
    """Of the time by which the flow was recorded too late (or too early) beside the pressure, s. Usual: 0."""
    zero_sd: Annotated[
        _SD | None, Kind("mmHg", "zero of the pressure", 0.5, "calibration", False, _lower_pressure, _none)
    ] = None
    """Of the zero of the pressure, mmHg. Usual: 0.5, for a transducer that was zeroed before it recorded; more for
    averaged cycles whose drift nobody saw."""
    viscosity_sd: Annotated[
        _Share | None, Kind("1", "true over assumed viscosity", 0.0, "model", True, _thicker, _one)
    ] = None
    """Of the viscosity of the blood, as a share: hematocrit and temperature. Usual: 0."""

    def sd(self, name: str) -> float:
        """Return the SD of an unknown: what is said, else what is usual."""
        said = getattr(self, f"{name}_sd")
        return kinds()[name].usual if said is None else float(said)

    def said(self) -> dict[str, float]:
        """Return the errors that are said to be there, by unknown."""
        values = {name: getattr(self, f"{name}_sd") for name in kinds()}
        return {name: float(value) for name, value in values.items() if value}


@cache
def kinds() -> dict[str, Kind]:
    """Return what can be wrong, by the name of the unknown."""
    hints: dict[str, Any] = get_type_hints(KnownErrors, include_extras=True)
    return {
        name.removesuffix("_sd"): next(one for one in hints[name].__metadata__ if isinstance(one, Kind))
        for name in settings_of(KnownErrors)
    }


def columns() -> dict[str, tuple[str, str]]:
    """Return the column of the table of animals for every error, and what it holds, by the setting's name."""
    found = {}
    for name, one in settings_of(KnownErrors).items():
        kind = kinds()[name.removesuffix("_sd")]
        unit = "" if kind.positive or kind.unit == "1" else f" [{kind.unit}]"
        found[name] = (f"{name.replace('_', ' ')}{unit}", f"SD {one.meaning[0].lower()}{one.meaning[1:]}")
    return found
