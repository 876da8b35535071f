"""What of a recording enters a model, and what a fit compares: harmonics that carry signal, at the samples they need.

Above them a measured cycle holds rounding, smoothing or the noise of its beats, and a residual there is the
simulation's alone. It adds nothing to S, but a smooth model of the noise takes its smallness for evidence.

Where the pressure enters, the flow is compared. It is counted in mmHg, so that a pulse of flow is a pulse of pressure:
then all that is known of residuals holds for both.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, note_kind
from vasowave.pulse.calibration.sites import Sites, places_of
from vasowave.pulse.cycle.cycle import Inflow, InletPressure, Recording, resample, samples_needed
from vasowave.pulse.cycle.harmonics import HarmonicErrors, harmonic_errors
from vasowave.pulse.cycle.observation import Observation
from vasowave.pulse.cycle.response import second_order
from vasowave.pulse.cycle.waveform import amplitudes
from vasowave.pulse.model.linear import LinearSolution, linear_solution
from vasowave.pulse.model.model import Model
from vasowave.pulse.network.network import Network
from vasowave.pulse.noise.spectrum import SIZE_PRIOR
from vasowave.pulse.solver.result import Run, at_samples

MIN_HARMONICS = 8
"""Harmonics that are compared at least: with fewer, the parameters of a fit leave no residual to judge it by."""

_OWN_LEVEL = "the rounding and the own high-frequency level of the averaged cycle"
_COMPARED_TEXT = "harmonics 0 to {harmonics} of the {what} are compared ({samples} samples)"
_SIGNAL_END_TEXT = "signal stands out of {level} up to harmonic {signal}"
SIGNAL_OF_BEATS = note_kind(
    "fit.harmonics-with-signal", f"{_COMPARED_TEXT}: above them no signal stands out of {{level}}."
)
SIGNAL_OF_CYCLE = note_kind(
    "fit.harmonics-of-averaged-cycle",
    f"{SIGNAL_OF_BEATS.text} The scatter of its beats is not known, and smoothing hides it: fewer harmonics may be "
    "real; see how the answer moves with their number (`pressure_harmonics`).",
)
FEWEST_COMPARED = note_kind(
    "fit.harmonics-fewest", f"{_COMPARED_TEXT}: {_SIGNAL_END_TEXT}, and fewer leave nothing to judge a fit by."
)
AS_ASKED = note_kind("fit.harmonics-as-asked", f"{_COMPARED_TEXT}, as asked; {_SIGNAL_END_TEXT}.")
ABOVE_SIGNAL = note_kind(
    "fit.harmonics-above-signal",
    f"{_COMPARED_TEXT}, as asked; {_SIGNAL_END_TEXT}, and what lies above it is no evidence for or against a wall law.",
)

BY_PRESSURE = note_kind(
    "fit.driven-by-pressure",
    "The measured pressure enters the model, and the flow is compared: 1 ml/s of it counts as {scale:.4g} mmHg, the "
    "pulse of the pressure over that of the flow.",
)
NEITHER_EXACT = note_kind(
    "fit.flow-with-errors",
    "The measured flow enters the model with its error, which adds {error:.2g} mmHg (root mean square) to that of the "
    "pressure, {own:.2g} mmHg.",
)

Enters = Literal["flow", "pressure", "both"]
"""What is measured at the inlet and enters the model: the other is compared. With ``both`` the flow enters, and the
error of each counts."""

MAX_SAMPLES = 1024
"""The paper's number of samples; a longer recording is compared at these, which carry all its harmonics."""


class PassedOn(NamedTuple):
    """What the error of a flow adds to that of the pressure of a model, all by harmonic, mmHg.

    Attributes
    ----------
    error : array, shape (harmonic,)
        Standard error of the amplitudes.
    of_harmonic : array, shape (harmonic,)
        The part of it that the error in the same harmonic makes.
    modulus : array, shape (harmonic,)
        Of the pressure of the model.
    """

    error: np.ndarray
    of_harmonic: np.ndarray
    modulus: np.ndarray


@dataclass(frozen=True, eq=False)
class Compared:
    """What enters a model, and what a fit compares of it: the pressure, or the flow counted in mmHg.

    Attributes
    ----------
    recording : Recording
        As it was given.
    samples : int
        N, evenly spaced over the cycle: 2 n + 1 carry n harmonics.
    choice : {"signal", "given", "all"}
        How the number was chosen: by the signal, by hand, or as all that the recording holds.
    errors : HarmonicErrors
        Modulus and standard error of the harmonics of what is compared, mmHg.
    sites : Sites, optional
        What was observed elsewhere.
    enters : {"flow", "pressure", "both"}
        What enters the model; see `Enters`.
    passed_on : PassedOn, optional
        What the error of the flow that enters adds to that of the pressure.
    response : (float, float)
        Lag (s) and inertia (s²) of what the pressure was recorded through; see `second_order`.
    """

    recording: Recording
    samples: int
    choice: str
    errors: HarmonicErrors
    sites: Sites | None = None
    enters: Enters = "flow"
    passed_on: PassedOn | None = None
    response: tuple[float, float] = 0.0, 0.0

    @property
    def harmonics(self) -> int:
        """The highest harmonic that is compared."""
        return self.samples // 2

    @property
    def what(self) -> Literal["pressure", "flow"]:
        """What is compared."""
        return "flow" if self.enters == "pressure" else "pressure"

    @property
    def unit(self) -> str:
        """Its unit, of which one counts as `scale` mmHg."""
        return "ml/s" if self.what == "flow" else "mmHg"

    @property
    def scale(self) -> float:
        """What one unit of it counts as, mmHg: 1 of the pressure, the pulse of the pressure over that of the flow."""
        return flow_scale(self.recording) if self.what == "flow" else 1.0

    @cached_property
    def measured(self) -> np.ndarray:
        """What is compared as it was measured, mmHg, shape (N,)."""
        return resample(self.signal_of(self.recording), self.samples)

    def signal_of(self, recording: Recording) -> np.ndarray:
        """Return what is compared of a recording at its own samples, mmHg."""
        return self.scale * recording.flow if self.what == "flow" else recording.pressure

    def driven_by(self, recording: Recording) -> Inflow | InletPressure:
        """Return what of a recording enters the model."""
        if self.what == "flow":
            return InletPressure(recording.pressure, recording.period)
        return recording.inflow

    @property
    def driven(self) -> Inflow | InletPressure:
        """What enters the model."""
        return self.driven_by(self.recording)

    @property
    def per_pressure(self) -> float:
        """What the mean of what is compared changes with 1 mmHg of mean pressure, mmHg; to first order."""
        if self.what == "pressure":
            return 1.0
        recording = self.recording
        return self.scale * recording.cardiac_output / (recording.mean_pressure - recording.wedge_pressure)

    def mean_state(self, residual: np.ndarray) -> tuple[float, float]:
        """Return mean pressure (mmHg) and flow (ml/s) at the inlet of the simulation that left a residual."""
        simulated = float(np.mean(self.measured - residual))
        if self.what == "flow":
            return self.recording.mean_pressure, simulated / self.scale
        return simulated, self.recording.cardiac_output

    @property
    def time(self) -> np.ndarray:
        """Times of the samples, s, shape (N,)."""
        return np.arange(self.samples) * (self.recording.period / self.samples)

    def simulated(self, run: Run) -> np.ndarray:
        """Return what is compared at the inlet of a simulation, mmHg, shape (N,), in the same harmonics."""
        return self.sampled(self.at_inlet(run, run.steps))

    def at_inlet(self, run: Run, samples: int) -> np.ndarray:
        """Return what is compared at the inlet of a simulation, mmHg, at `samples` times of the cycle."""
        if self.what == "flow":
            return self.scale * at_samples(run.at_inlet[1], samples)
        return run.inlet_pressure(samples)

    def of_linear(self, solved: LinearSolution, inlet: int) -> np.ndarray:
        """Return the harmonics of what is compared by the linear model, mmHg; `inlet` is the row of the root."""
        return self.scale * solved.flow[:, inlet] if self.what == "flow" else solved.pressure[:, inlet]

    def sampled(self, signal: np.ndarray) -> np.ndarray:
        """Return what is known at every step of a cycle, in the same harmonics, shape (N,), as it is recorded."""
        if self.choice == "all":  # sample by sample, as the paper: a cycle that is not periodic has no harmonics
            return self.behind(at_samples(signal, self.samples), self.response)
        return self.behind(resample(signal, self.samples), self.response)

    def behind(self, values: np.ndarray, response: Sequence[float] | np.ndarray) -> np.ndarray:
        """Return samples of a cycle, shape (N, ...), behind a response."""
        if not np.any(response):
            return values
        lag, inertia = response
        passed = second_order(lag, inertia, np.arange(len(values) // 2 + 1) / self.recording.period)
        return np.fft.irfft((np.fft.rfft(values, axis=0).T * passed).T, len(values), axis=0)

    def error_power(self) -> np.ndarray:
        """Mean square of the measurement's error in harmonics 0 … n, mmHg²; their sum is its own."""
        power = _first(self.errors.error, self.harmonics + 1) ** 2
        return power if self.passed_on is None else power + self.passed_on.error**2

    def with_flow_error(self, model: Model) -> "Compared":
        """Return the same with the error of the flow as a model passes it on to the pressure, if it counts.

        By the linear model: |Z_k| times the standard error of each amplitude but the mean's, which moves the state
        about which is linearized, and so all amplitudes. That these move together is left out: it is known to first
        order only, and would be taken for knowledge.
        """
        if self.enters != "both":
            return self
        count, root, inflow = self.harmonics + 1, model.network.root, self.recording.inflow
        error = _first(harmonic_errors(self.recording, "flow").error, count)
        solved, shifted = (
            linear_solution(model, Inflow(inflow.flow + change, inflow.period), self.harmonics)
            for change in (0.0, error[0])
        )
        impedance = _first(np.abs(solved.input_impedance[:, root]), count)
        impedance[0] = 0.0
        moved = _first(np.abs(shifted.pressure - solved.pressure)[:, root], count)
        moved[1:] /= np.sqrt(2.0)  # of an amplitude that is known, where others have two parts
        of_harmonic, modulus = impedance * error, np.abs(_first(solved.pressure[:, root], count))
        total = np.hypot(of_harmonic, moved)
        of_harmonic[0] = moved[0]
        return replace(self, passed_on=PassedOn(total, of_harmonic, modulus))

    def spectrum(self, residual: np.ndarray) -> pd.DataFrame:
        """What the measurement, its error and a residual (mmHg, shape (N,)) are in each harmonic.

        Returns
        -------
        DataFrame
            Indexed by ``harmonic`` (0, the mean, to n), all in mmHg: ``measured_modulus``, ``measurement_error`` (the
            expected modulus of the error, root mean square), ``residual_modulus``, and ``discrepancy``, what the
            residual has beyond that error: √(residual² - error²), 0 where the error is larger. What the parameters of a
            fit could imitate is in none of them.
        """
        measured, residual_modulus = (np.abs(amplitudes(values)) for values in (self.measured, residual))
        error = self.error_power()
        error[1:] *= 2.0  # of a cosine and a sine
        return pd.DataFrame(
            {
                "measured_modulus": measured,
                "measurement_error": np.sqrt(error),
                "residual_modulus": residual_modulus,
                "discrepancy": np.sqrt(np.maximum(residual_modulus**2 - error, 0.0)),
            },
            index=pd.RangeIndex(len(measured), name="harmonic"),
        )

    def findings(self) -> list[Finding]:
        """Return which harmonics are compared, and why, and what enters the model if it is not the flow alone."""
        notes = [self._harmonics_compared()]
        if self.what == "flow":
            notes.append(BY_PRESSURE(scale=self.scale))
        if self.passed_on is not None:
            pressure_error = _first(self.errors.error, self.harmonics + 1) ** 2
            of_flow = self.error_power() - pressure_error
            notes.append(NEITHER_EXACT(error=float(np.sqrt(of_flow.sum())), own=float(np.sqrt(pressure_error.sum()))))
        return notes

    def _harmonics_compared(self) -> Finding:
        signal, beats = self.errors.with_signal, self.errors.source == "beats"
        if self.choice == "signal" and signal >= self.harmonics:
            kind = SIGNAL_OF_BEATS if beats else SIGNAL_OF_CYCLE
        elif self.choice == "signal":
            kind = FEWEST_COMPARED
        else:
            kind = AS_ASKED if self.harmonics <= signal else ABOVE_SIGNAL
        level = "the scatter of the beats" if beats else _OWN_LEVEL
        return kind(harmonics=self.harmonics, samples=self.samples, signal=signal, level=level, what=self.what)


def flow_scale(recording: Recording) -> float:
    """Return the pulse of the pressure over that of the flow, mmHg s/ml."""
    return recording.pulse_pressure / float(np.ptp(recording.flow))


def _first(values: np.ndarray, count: int) -> np.ndarray:
    """Return so many values of harmonics; those beyond what is known are as the last that is."""
    return np.pad(values[:count], (0, max(0, count - len(values))), mode="edge")


def compared_part(recording: Recording, harmonics: int | str = "signal", enters: Enters | None = None) -> Compared:
    """Return what a fit compares of a recording.

    Parameters
    ----------
    recording : Recording
    harmonics : {"signal", "all"} or int
        Those that carry signal, all that the recording holds (at most 1024 samples), or up to a number.
    enters : {"flow", "pressure", "both"}
        What enters the model, by default the flow.

    Raises
    ------
    InputError
        Neither, or more harmonics than the recording holds.
    """
    harmonics = checked_harmonics(harmonics)
    errors, signal = harmonic_errors(recording), recording.pressure
    if enters == "pressure":
        scale, (modulus, error, source) = flow_scale(recording), harmonic_errors(recording, "flow")
        errors, signal = HarmonicErrors(scale * modulus, scale * error, source), recording.flow
    held = (len(signal) - 1) // 2
    if harmonics == "all":
        samples, choice = min(samples_needed(signal), MAX_SAMPLES), "all"
    elif isinstance(harmonics, str):
        count = max(MIN_HARMONICS, errors.with_signal)
        samples, choice = 2 * min(count, held, (MAX_SAMPLES - 1) // 2) + 1, "signal"
    elif harmonics > held:
        raise InputError(
            f"{recording.source}: {len(signal)} samples hold {held} harmonics, {harmonics} cannot be compared; give "
            "fewer, or 'all'"
        )
    else:
        samples, choice = 2 * harmonics + 1, "given"
    return Compared(recording, samples, choice, errors, enters=enters or "flow")


def checked_harmonics(value: int | str) -> int | str:
    """Return "signal", "all" or a number of harmonics from 8 to 511; raise `InputError` for anything else."""
    if value in ("signal", "all"):
        return value
    number = int(value) if str(value).isdecimal() else 0
    if not MIN_HARMONICS <= number < MAX_SAMPLES // 2:
        raise InputError(f"'{value}': give 'signal', 'all', or a number of harmonics from {MIN_HARMONICS} to 511")
    return number


def sites_of(observations: Sequence[Observation], network: Network, compared: Compared) -> Sites | None:
    """Return the sites of a network; None where nothing was observed.

    Raises
    ------
    InputError
        A vessel that the network does not have, a place beyond its end, a site that is none.
    """
    if not observations:
        return None
    places = places_of(observations, network, compared.recording.period)
    pulse = compared.recording.pulse_pressure
    return Sites(tuple(observations), places, compared.samples, pulse, SIZE_PRIOR[0] * pulse)
