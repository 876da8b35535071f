"""Errors that a lab knows of image, probe and transducer: one list, of which priors, columns and keys are made."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, Any, Literal, NamedTuple, Self, get_type_hints

import numpy as np
from annotated_types import Ge, Le

from vasowave.base.settings import settings_class, settings_of
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.cycle.harmonics import harmonic_errors
from vasowave.pulse.cycle.response import second_order
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.network.network import Network, measured_falls

SHARED_SOURCES = {
    "image": "Animals whose vessels come from one image or one calibration of it have the same word here; empty: by "
    "equal networks. The error of an image moves them together.",
    "probe": "Animals whose flow one probe measured have the same word; empty: each animal has its own error.",
    "calibration": "Animals that were recorded after one calibration of the pressure, likewise.",
}
"""What animals may share with its errors: column of the table of animals and meaning."""


SOURCES = ("recording", *reversed(SHARED_SOURCES), "model", "prior")
"""Where the variance of an estimate comes from: errors of measurement; zero of the pressure; gain and delay of the flow
probe; geometry; discrepancy and structure; parameters that the data leave where they were."""


class Observed(NamedTuple):
    """What was measured of an animal; and the lag, s, that its pressure had before it was undone."""

    network: Network
    recording: Recording
    blood: Blood
    lag: float = 0.0


@dataclass(frozen=True, eq=False)
class ErrorKind:
    """An unknown that an error is of.

    Attributes
    ----------
    unit, meaning : str
        Of the unknown; `unit` is that of the error, too, where it is not a share.
    usual : float
        SD that is assumed where nothing is said.
    source : str
        Where it comes from: a key of `SHARED_SOURCES`, or ``model``, of which every animal has its own.
    positive : bool
        Whether the error is the SD of a logarithm.
    without : callable
        Returns what would have been seen without the error, from what was seen and the unknown's value.
    center : callable
        Returns the unknown's median; 0 of a positive one where an animal does not have it.
    single : callable
        Returns whether posteriors know it vessel by vessel, so that none in common is usual there.
    of_image : callable
        Returns the SD that the measurement of a network tells in place of the usual one, None where it tells none.
    common : callable
        Returns the part of it that vessels have in common: posteriors, in which each vessel has an error of its own,
        take it in place of a smaller usual one.
    """

    unit: str
    meaning: str
    usual: float
    source: str
    positive: bool
    without: Callable[[Observed, float], Observed]
    center: Callable[[Observed], float]
    single: Callable[[Network], bool] = lambda _: False
    of_image: Callable[[Network], float | None] = lambda _: None
    common: Callable[[Network], float] = lambda _: 0.0


_WORDS = {
    "radius_scale": "radii {} %", "length_scale": "lengths {} %", "k": "exponent of stiffness along the tree {}",
    "taper": "taper of vessels {} %", "image_pressure": "pressure of the image {} %",
    "flow_gain": "gain of the flow {} %", "flow_delay": "delay of the flow {} s",
    "zero": "zero of the pressure {} mmHg", "flow_zero": "zero of the flow {} ml/s",
    "pressure_lag": "lag of the pressure {} s",
    "pressure_inertia": "inertia of the catheter {} s²", "flow_lag": "lag of the flow {} s",
    "pressure_gain": "gain of the pressure {} %", "viscosity": "viscosity of blood {} %",
}  # fmt: skip


class AssumedError(NamedTuple):
    """An error that the fits of an animal allow for; ``str`` of it says what it is: ``radii 5 %``.

    Attributes
    ----------
    name : str
        A key of `kinds`.
    sd, unit : float, str
        SD and its unit, ``1`` of a share; 0 where the lab says that there is none.
    source : str
        ``lab`` (the study, its practice, or the animal's row tells it), ``image`` (its network does), ``usual`` (nobody
        does).
    """

    name: str
    sd: float
    unit: str
    source: Literal["usual", "lab", "image"]

    def __str__(self) -> str:
        return self.among([self])

    def among(self, errors: Sequence["AssumedError"]) -> str:
        """Return what this error is in several animals: ``delay of the flow 0.0031 to 0.0036 s``."""
        words = _WORDS[self.name]
        scale = 100 if "%" in words else 1
        low, high = (f"{scale * choose(error.sd for error in errors):.3g}" for choose in (min, max))
        return words.format(low if low == high else f"{low} to {high}")


def _one(_: Observed) -> float:
    return 1.0


def _none(_: Observed) -> float:
    return 0.0


def _wider(observed: Observed, factor: float) -> Observed:
    return observed._replace(network=observed.network.resized(radius=observed.network.radius * factor))


def _longer(observed: Observed, factor: float) -> Observed:
    return observed._replace(network=observed.network.resized(length=observed.network.length * factor))


def _filled(observed: Observed, pressure: float) -> Observed:
    return observed._replace(network=observed.network.resized(pressure=pressure))


def _more_flow(observed: Observed, factor: float) -> Observed:
    return observed._replace(recording=replace(observed.recording, flow=observed.recording.flow * factor))


def _later_flow(observed: Observed, delay: float) -> Observed:
    """Return what was seen with its flow as late as it was in truth: the probe showed it `delay` too late."""
    flow, period = observed.recording.flow, observed.recording.period
    turned = np.fft.rfft(flow) * np.exp(2j * np.pi * np.arange(len(flow) // 2 + 1) * delay / period)
    return observed._replace(recording=replace(observed.recording, flow=np.fft.irfft(turned, len(flow))))


def _lower_flow(observed: Observed, zero: float) -> Observed:
    return observed._replace(recording=replace(observed.recording, flow=observed.recording.flow - zero))


def _sooner_pressure(observed: Observed, lag: float) -> Observed:
    return _passed(observed, "pressure", (lag, 0.0))._replace(lag=lag)


def _sooner_flow(observed: Observed, lag: float) -> Observed:
    return _passed(observed, "flow", (lag, 0.0))


def _calmer_pressure(observed: Observed, inertia: float) -> Observed:
    """Return what was seen without inertia; the lag of the same response may have been undone before."""
    return _passed(observed, "pressure", (observed.lag, inertia), observed.lag)


def _passed(observed: Observed, signal: str, response: tuple[float, float], undone: float = 0.0) -> Observed:
    """Return a signal without a response whose lag was `undone`, up to the last harmonic that carries signal."""
    values, period = getattr(observed.recording, signal), observed.recording.period
    counted = np.minimum(np.arange(len(values) // 2 + 1), harmonic_errors(observed.recording, signal).with_signal)
    turned = second_order(undone, 0.0, counted / period) / second_order(*response, counted / period)
    changed: dict[str, Any] = {signal: np.fft.irfft(np.fft.rfft(values) * turned, len(values))}
    return observed._replace(recording=replace(observed.recording, **changed))


def _lower_pressure(observed: Observed, zero: float) -> Observed:
    return observed._replace(recording=replace(observed.recording, pressure=observed.recording.pressure - zero))


def _more_pressure(observed: Observed, factor: float) -> Observed:
    return observed._replace(recording=replace(observed.recording, pressure=observed.recording.pressure * factor))


def _thicker(observed: Observed, factor: float) -> Observed:
    return observed._replace(blood=replace(observed.blood, viscosity=observed.blood.viscosity * float(factor)))


def _of_radii(network: Network) -> float | None:
    """Return the root mean square of the SD of the radii, as shares of them, or what the image says of all alike,
    where the larger exceeds what is usual.

    A smaller one knows of threshold and noise, and not of the size of the voxels or of what became of the lung.
    """
    spread = _common_to_radii(network)
    if network.radius_sd is not None and np.isfinite(network.radius_sd).any():
        spread = max(spread, float(np.sqrt(np.nanmean((network.radius_sd / network.radius) ** 2))))
    return spread if spread > _RADIUS_SD else None


def _common_to_radii(network: Network) -> float:
    """Return the SD of the factor of all radii that the image of a network tells, 0 where it tells none."""
    shares = np.zeros(1) if network.radius_scale_sd is None else network.radius_scale_sd
    return float(np.nan_to_num(shares).max())


def _of_tapers(network: Network) -> float | None:
    """Return how far measured tapers may be wrong all alike: their common factor, and the mean of their SD."""
    if network.taper is None or not np.isfinite(network.taper).any():
        return None
    falls, errors = measured_falls(network, _TAPER_SD)
    return float(np.sqrt(np.mean((_TAPER_FACTOR_SD * falls) ** 2 + errors**2)))


def _same(observed: Observed, _: float) -> Observed:
    return observed


_RADIUS_SD = 0.05  # usual SD of a common factor of all radii
_TAPER_SD, _TAPER_FACTOR_SD = 0.3, 0.1
"""SD of a vessel's fall before it is measured, and of the measured ones' common factor."""

_Share = Annotated[float, Ge(0), Le(2)]
_SD = Annotated[float, Ge(0)]


@settings_class
class KnownErrors:
    """How far image, probe and transducer may be wrong: the SD of each error. Where nothing is said the usual SD is
    assumed, in fits and posteriors; 0 says that a number is exact. A column of the table of animals of the same name
    takes the place of a key here.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.KnownErrors(flow_gain_sd=0.07).flow_gain_sd
    0.07
    """

    radius_scale_sd: Annotated[
        _Share | None,
        ErrorKind(
            "1",
            "factor of all radii",
            _RADIUS_SD,
            "image",
            True,
            _wider,
            _one,
            of_image=_of_radii,
            common=_common_to_radii,
        ),
    ] = None
    """Of a factor common to all radii, as a share: threshold and voxel size of the image. Usual: 0.05, for fits the
    root mean square of the network's ``radius_sd`` where that is larger; its ``radius_scale_sd``, likewise."""
    length_scale_sd: Annotated[
        _Share | None, ErrorKind("1", "factor of all lengths", 0.05, "image", True, _longer, _one)
    ] = None
    """Likewise of lengths. Usual: 0.05."""
    k_sd: Annotated[
        _Share | None, ErrorKind("1", "exponent of a stiffness ∝ radius^-k", 0.5, "model", False, _same, _none)
    ] = None
    """Of the exponent k of a wall stiffness that varies with the radius, β ∝ (r/r_root)^-k, around 0. Usual: 0.5; in
    pulmonary arteries distensibility is nearly uniform (k = 0), down the systemic ones k near 0.7 is usual."""
    taper_sd: Annotated[
        _Share | None, ErrorKind("1", "fall of all radii along their vessels", 0.1, "image", False, _same, _none,
                            lambda network: _of_tapers(network) is not None, _of_tapers)
    ] = None  # fmt: skip
    """Of what the radius of all vessels falls from inlet to outlet alike, as a share of it, and nobody knows. Usual:
    0.1; less where the network's ``taper`` is measured, whose errors posteriors know vessel by vessel."""
    image_pressure_sd: Annotated[
        _Share | None,
        ErrorKind("mmHg", "pressure at which the image was taken", 0.3, "image", True, _filled,
             lambda observed: observed.network.pressure),
    ] = None  # fmt: skip
    """Of the pressure at which the image was taken, as a share of it, where it is known. Usual: 0.3."""
    flow_gain_sd: Annotated[
        _Share | None, ErrorKind("1", "true over measured flow", 0.05, "probe", True, _more_flow, _one)
    ] = None
    """Of the gain of the flow probe, as a share. Usual: 0.05: makers of transit-time probes state ±10 %."""
    flow_delay_sd: Annotated[
        _SD | None, ErrorKind("s", "delay of the measured flow", 0.0, "probe", False, _later_flow, _none)
    ] = None
    """Of the time by which the flow was recorded too late (or too early) beside the pressure, s. Usual: 0, and the
    error of its place where a scanner gated it apart from the pressure."""
    zero_sd: Annotated[
        _SD | None, ErrorKind("mmHg", "zero of the pressure", 0.5, "calibration", False, _lower_pressure, _none)
    ] = None
    """Of the zero of the pressure, mmHg. Usual: 0.5, for a transducer that was zeroed before it recorded; more for
    averaged cycles whose drift nobody saw."""
    flow_zero_sd: Annotated[
        _SD | None, ErrorKind("ml/s", "zero of the flow", 0.0, "probe", False, _lower_flow, _none)
    ] = None
    """Of the zero of the flow, ml/s. Usual: 0."""
    pressure_lag_sd: Annotated[
        _SD | None, ErrorKind("s", "lag of the pressure", 0.0, "calibration", False, _sooner_pressure, _none)
    ] = None
    """Of the lag τ of a filter of first order in the pressure's amplifier, whose cut-off frequency is 1/(2π τ), s:
    0.003 where it may be 50 Hz. Usual: 0."""
    pressure_inertia_sd: Annotated[
        _SD | None, ErrorKind("s2", "inertia of the catheter", 0.0, "calibration", False, _calmer_pressure, _none)
    ] = None
    """Of the inertia θ that lets a fluid-filled catheter ring with the natural frequency 1/(2π √θ), s²: 7e-6 where that
    may be 60 Hz. Its damping ratio ζ is a lag τ = 2ζ√θ: `pressure_lag_sd` of 0.003 beside it. Usual: 0."""
    flow_lag_sd: Annotated[_SD | None, ErrorKind("s", "lag of the flow", 0.0, "probe", False, _sooner_flow, _none)] = (
        None
    )
    """Likewise of the flow meter's filter, s. Usual: 0."""
    pressure_gain_sd: Annotated[
        _Share | None, ErrorKind("1", "true over measured pressure", 0.0, "calibration", True, _more_pressure, _one)
    ] = None
    """Of the gain of the pressure, as a share. Usual: 0."""
    viscosity_sd: Annotated[
        _Share | None, ErrorKind("1", "true over assumed viscosity", 0.0, "model", True, _thicker, _one)
    ] = None
    """Of the viscosity of the blood, as a share: hematocrit and temperature. Usual: 0."""

    def allowing_for(self, recording: Recording) -> Self:
        """Return the errors with the place of the flow of a recording, where it was gated apart from the pressure."""
        if recording.flow_delay_sd <= (self.flow_delay_sd or 0.0):
            return self
        return replace(self, flow_delay_sd=recording.flow_delay_sd)

    def sd(self, name: str, network: Network | None = None) -> float:
        """Return the SD of an unknown of posteriors: what is said, else what the network's image tells, or is usual."""
        value, kind = getattr(self, f"{name}_sd"), kinds()[name]
        if value is not None or network is None:
            return kind.usual if value is None else float(value)
        return 0.0 if kind.single(network) else max(kind.usual, kind.common(network))

    def assumed(self, network: Network) -> tuple[AssumedError, ...]:
        """Return the errors that fits of a network allow for, and those of which the lab says that there are none."""
        errors = []
        for name, kind in kinds().items():
            sds = {"lab": getattr(self, f"{name}_sd"), "image": kind.of_image(network), "usual": kind.usual or None}
            source: Any = next((origin for origin, sd in sds.items() if sd is not None), "")
            if source and (name != "image_pressure" or network.pressure):
                unit = "1" if kind.positive else kind.unit
                errors.append(AssumedError(name, float(sds[source] or 0.0), unit, source))
        return tuple(errors)


@cache
def kinds() -> dict[str, ErrorKind]:
    """Return what can be wrong, by the name of the unknown."""
    hints: dict[str, Any] = get_type_hints(KnownErrors, include_extras=True)
    return {
        name.removesuffix("_sd"): next(
            metadata for metadata in hints[name].__metadata__ if isinstance(metadata, ErrorKind)
        )
        for name in settings_of(KnownErrors)
    }


def columns() -> dict[str, tuple[str, str]]:
    """Return the column of the table of animals for every error, and what it holds, by the setting's name."""
    titles = {}
    for name, setting in settings_of(KnownErrors).items():
        kind = kinds()[name.removesuffix("_sd")]
        unit = "" if kind.positive or kind.unit == "1" else f" [{kind.unit}]"
        titles[name] = (f"{name.replace('_', ' ')}{unit}", f"SD {setting.meaning[0].lower()}{setting.meaning[1:]}")
    return titles
