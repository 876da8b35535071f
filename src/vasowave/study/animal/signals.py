"""Waves and impedance at the inlet of the root, of measured or simulated waveforms, as labelled data."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from vasowave.pulse.analysis.impedance_spectrum import characteristic_impedances, fourier_series, impedance
from vasowave.pulse.analysis.operating import WavesAt, measured_operating_point, operating_point
from vasowave.pulse.analysis.waves import named_waves, wave_intensity
from vasowave.pulse.calibration.result import CalibratedModel
from vasowave.pulse.cycle.averaged import EnsembleAverage
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.model.nominal import Nominal
from vasowave.pulse.network.network import Network
from vasowave.study.animal.labelled import labelled

_WAVE_COLUMNS = {
    "start [s]": ("wave_start", "s"),
    "peak time [s]": ("wave_time", "s"),
    "duration [s]": ("wave_duration", "s"),
    "peak [W/cm2/s2]": ("wave_peak", "W/cm2/s2"),
    "area [W/cm2/s]": ("wave_area", "W/cm2/s"),
    "pressure change [mmHg]": ("wave_pressure_change", "mmHg"),
}
_FIRST_NOISE_HARMONIC = 20
"""Harmonics of the flow above this one are taken for noise where no beats tell it."""
_MIN_SIGNAL_TO_NOISE = 2.0
"""A harmonic is reliable if its flow is this many times the noise."""


@dataclass(frozen=True, eq=False)
class Station:
    """Pressure, flow, area and wave speed at one place over one cycle."""

    recording: Recording
    """Pressure (mmHg) and flow (ml/s) at the same times."""
    area: float | np.ndarray
    wave_speed: float | np.ndarray
    """cm² and cm/s. Shape (time,)."""
    taken: str
    """At which pressure these were taken."""


def measured_station(
    recording: Recording, network: Network, nominal: Nominal, inertia: float, waves_at: WavesAt = "mean pressure"
) -> Station:
    """Return the measured waveforms, with area and wave speed from Z_c (eq. 8): neither was measured.

    At mean pressure the linear law carries the area of the image there; the paper takes A0 and c = A0 Z_c/ρ.
    """
    count = max(len(recording.pressure), len(recording.flow))
    even = recording if len(recording.pressure) == len(recording.flow) else recording.resampled(count)
    area, Z_c = float(network.area[network.root]), nominal.characteristic_impedance
    if waves_at == "paper":
        return Station(even, area, area * Z_c / inertia, "zero pressure")
    point = measured_operating_point(Z_c, area, inertia, recording.mean_pressure, network.pressure)
    return Station(even, *point, "mean pressure")


def simulated_station(fit: CalibratedModel, waves_at: WavesAt = "mean pressure") -> Station:
    """Return the calibrated model's waveforms where the catheter was, with area and wave speed from the wall law.

    Those at the measured mean pressure; the paper takes those of each instant.
    """
    network = fit.model.network
    inlet = fit.simulation.sel(vessel=network.name[network.root], station="inlet")
    pressure, flow, area, speed = (inlet[name].to_numpy() for name in ("pressure", "flow", "area", "wave_speed"))
    source = f"{fit.wall} wall calibrated to {fit.recording.source}"
    wedge = fit.recording.wedge_pressure
    recording = Recording(pressure, flow, fit.recording.period, source, wedge_pressure=wedge)
    if waves_at == "paper":
        return Station(recording, area, speed, "each instant")
    return Station(recording, *operating_point(fit.model, fit.recording.mean_pressure), "mean pressure")


def waves_dataset(station: Station, inertia: float) -> xr.Dataset:
    """Return separated waves, time-normalized intensity, I_R and the single waves (eqs. 15 to 17)."""
    recording = station.recording
    period = recording.period
    waves = wave_intensity(recording.pressure, recording.flow, period, station.area, station.wave_speed, inertia)
    named = named_waves(waves, period)
    area = station.area
    variables = {
        "pressure": labelled("time", recording.pressure, "mmHg", "pressure"),
        "p_plus": labelled("time", waves.forward_pressure, "mmHg", "forward pressure wave (eq. 15)"),
        "p_minus": labelled("time", waves.backward_pressure, "mmHg", "backward pressure wave (eq. 15)"),
        "q_plus": labelled("time", area * waves.forward_velocity, "ml/s", "flow of the forward wave, A u+ (eq. 15)"),
        "q_minus": labelled("time", area * waves.backward_velocity, "ml/s", "flow of the backward wave, A u- (eq. 15)"),
        "WI_plus": labelled("time", waves.forward_intensity, "W/cm2/s2", "forward wave intensity (eq. 16)"),
        "WI_minus": labelled("time", waves.backward_intensity, "W/cm2/s2", "backward wave intensity (eq. 16)"),
        "I_R": labelled((), waves.reflection_coefficient, "1", "reflection coefficient (eq. 17)"),
        "drift": labelled((), waves.drift, "mmHg", "p+ after one period minus p+ at its start"),
        "wave_name": xr.Variable("wave", named["wave"].to_numpy(object), {"long_name": "kind of wave"}),
    }
    for column, (name, unit) in _WAVE_COLUMNS.items():
        variables[name] = labelled("wave", named[column].to_numpy(float), unit, f"{column.split(' [')[0]} of the wave")
    time = recording.time
    return xr.Dataset(
        variables,
        coords={
            "time": labelled("time", time, "s", "time"),
            "normalized_time": labelled("time", time / period, "1", "time/T"),
        },
        attrs={
            "period": period,
            "smoothing": "none",
            "amplitude": "largest minus smallest value in the cycle",
            "area_and_wave_speed_at": station.taken,
        },
    )


def impedance_dataset(station: Station, harmonics: int, noise: float) -> xr.Dataset:
    """Return the impedance spectrum (eqs. 18, 19) and several estimates of Z_c (eq. 8)."""
    recording = station.recording
    last_harmonic = min(harmonics, (len(recording.pressure) - 1) // 2)
    spectrum = impedance(
        recording.pressure, recording.flow, recording.period, last_harmonic, _MIN_SIGNAL_TO_NOISE * noise
    )
    amplitude = np.abs(fourier_series(recording.flow, last_harmonic))
    estimates = characteristic_impedances(recording, (4, min(10, last_harmonic)), _MIN_SIGNAL_TO_NOISE * noise)
    per = "harmonic"
    return xr.Dataset(
        {
            "modulus": labelled(per, spectrum.modulus, "mmHg s/ml", "impedance modulus |Z| (eq. 19)"),
            "phase": labelled(per, spectrum.phase, "rad", "impedance phase (eq. 19)"),
            "flow_amplitude": labelled(per, amplitude, "ml/s", "amplitude of the flow harmonic (eq. 18)"),
            "reliable": labelled(per, (~spectrum.at_noise).astype(np.int8), "1", "whether the flow is above the noise"),
            "Z_c": labelled("estimator", estimates.to_numpy(float), "mmHg s/ml", "characteristic impedance (eq. 8)"),
            "flow_noise": labelled((), noise, "ml/s", "noise of a flow harmonic"),
        },
        coords={
            "harmonic": ("harmonic", np.arange(last_harmonic + 1), {"units": "1"}),
            "frequency": labelled("harmonic", spectrum.frequency, "Hz", "frequency"),
            "estimator": ("estimator", np.array(estimates.index, dtype=object)),
        },
    )


def flow_noise(recording: Recording, beats: EnsembleAverage | None) -> float:
    """Amplitude of the noise in one harmonic of the averaged flow, ml/s.

    From the scatter of the averaged beats, spread evenly over the harmonics; where no beats are known, the largest
    harmonic above the 20th; zero where the recording carries none.
    """
    if beats is not None:
        count = sum(beat.averaged for beat in beats.beats)
        variance = float(np.mean(beats.flow_sd**2)) / max(1, count)
        return float(np.sqrt(2 * variance / (len(beats.flow_sd) // 2)))
    carried = (len(recording.flow) - 1) // 2
    beyond = np.abs(fourier_series(recording.flow, carried))[_FIRST_NOISE_HARMONIC + 1 :]
    return float(beyond.max()) if len(beyond) else 0.0
