"""What of a recording a fit compares: the harmonics of its pressure that carry signal, at the few samples they need.

Above them a measured cycle holds rounding, smoothing or the noise of its beats, and a residual there is the
simulation's alone. It adds nothing to S, but a smooth model of the noise takes its smallness for evidence.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from vasowave.errors import InputError
from vasowave.findings import Finding, note_kind
from vasowave.recording import HarmonicErrors, Recording, harmonic_errors, resample, samples_needed
from vasowave.recording.waveform import amplitudes
from vasowave.solver.result import Run, at_samples

if TYPE_CHECKING:
    from vasowave.calibration.sites import Sites

FEWEST = 8
"""Harmonics that are compared at least: with fewer, the parameters of a fit leave no residual to judge it by."""

_OWN_LEVEL = "the rounding and the own high-frequency level of the averaged cycle"
_COMPARED = "harmonics 0 to {harmonics} of the pressure are compared ({samples} samples)"
_ENDS = "signal stands out of {level} up to harmonic {signal}"
SIGNAL_OF_BEATS = note_kind("fit.harmonics-with-signal", f"{_COMPARED}: above them no signal stands out of {{level}}.")
SIGNAL_OF_CYCLE = note_kind(
    "fit.harmonics-of-averaged-cycle",
    f"{SIGNAL_OF_BEATS.text} The scatter of its beats is not known, and smoothing hides it: fewer harmonics may be "
    "real; see how the answer moves with their number (`pressure_harmonics`).",
)
FEWEST_COMPARED = note_kind("fit.harmonics-fewest", f"{_COMPARED}: {_ENDS}, and fewer leave nothing to judge a fit by.")
AS_ASKED = note_kind("fit.harmonics-as-asked", f"{_COMPARED}, as asked; {_ENDS}.")
ABOVE_SIGNAL = note_kind(
    "fit.harmonics-above-signal",
    f"{_COMPARED}, as asked; {_ENDS}, and what lies above it is no evidence for or against a wall law.",
)

MOST_SAMPLES = 1024
"""The paper's number of samples; a longer recording is compared at these, which carry all its harmonics."""


@dataclass(frozen=True, eq=False)
class Compared:
    """The pressure that a fit compares.

    Attributes
    ----------
    recording : Recording
        As it was given.
    samples : int
        N, evenly spaced over the cycle: 2 n + 1 carry n harmonics.
    choice : {"signal", "given", "all"}
        How the number was chosen: by the signal, by hand, or as all that the recording holds.
    errors : HarmonicErrors
        Modulus and standard error of the harmonics of the measured pressure, mmHg.
    sites : Sites, optional
        What was observed elsewhere.
    """

    recording: Recording
    samples: int
    choice: str
    errors: HarmonicErrors
    sites: "Sites | None" = None

    @property
    def harmonics(self) -> int:
        """The highest harmonic that is compared."""
        return self.samples // 2

    @cached_property
    def pressure(self) -> np.ndarray:
        """Measured pressure, mmHg, shape (N,)."""
        return resample(self.recording.pressure, self.samples)

    @property
    def time(self) -> np.ndarray:
        """Times of the samples, s, shape (N,)."""
        return np.arange(self.samples) * (self.recording.period / self.samples)

    def simulated(self, run: Run) -> np.ndarray:
        """Pressure at the inlet of a simulation, mmHg, shape (N,), in the same harmonics."""
        return self.sampled(run.inlet_pressure(run.steps))

    def sampled(self, signal: np.ndarray) -> np.ndarray:
        """Return what is known at every step of a cycle, in the same harmonics, shape (N,)."""
        if self.choice == "all":  # sample by sample, as the paper: a cycle that is not periodic has no harmonics
            return at_samples(signal, self.samples)
        return resample(signal, self.samples)

    def error_power(self) -> np.ndarray:
        """Mean square of the measurement's error in harmonics 0 … n, mmHg², shape (harmonic,); their sum is its own."""
        known = self.errors.error[: self.harmonics + 1] ** 2
        return np.pad(known, (0, self.harmonics + 1 - len(known)), mode="edge")

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
        measured, left = (np.abs(amplitudes(values)) for values in (self.pressure, residual))
        error = self.error_power()
        error[1:] *= 2.0  # of a cosine and a sine
        return pd.DataFrame(
            {
                "measured_modulus": measured,
                "measurement_error": np.sqrt(error),
                "residual_modulus": left,
                "discrepancy": np.sqrt(np.maximum(left**2 - error, 0.0)),
            },
            index=pd.RangeIndex(len(measured), name="harmonic"),
        )

    def finding(self) -> Finding:
        """Return which harmonics are compared, and why."""
        signal, beats = self.errors.with_signal, self.errors.source == "beats"
        if self.choice == "signal" and signal >= self.harmonics:
            which = SIGNAL_OF_BEATS if beats else SIGNAL_OF_CYCLE
        elif self.choice == "signal":
            which = FEWEST_COMPARED
        else:
            which = AS_ASKED if self.harmonics <= signal else ABOVE_SIGNAL
        level = "the scatter of the beats" if beats else _OWN_LEVEL
        return which(harmonics=self.harmonics, samples=self.samples, signal=signal, level=level)


def compared_part(recording: Recording, harmonics: int | str = "signal") -> Compared:
    """Return what a fit compares of a recording.

    Parameters
    ----------
    recording : Recording
    harmonics : {"signal", "all"} or int
        Those that carry signal, all that the recording holds (at most 1024 samples), or up to a number.

    Raises
    ------
    InputError
        Neither, or more harmonics than the recording holds.
    """
    harmonics = checked_harmonics(harmonics)
    errors = harmonic_errors(recording)
    held = (len(recording.pressure) - 1) // 2
    if harmonics == "all":
        return Compared(recording, min(samples_needed(recording.pressure), MOST_SAMPLES), "all", errors)
    if isinstance(harmonics, str):
        wanted = max(FEWEST, errors.with_signal)
        return Compared(recording, 2 * min(wanted, held, (MOST_SAMPLES - 1) // 2) + 1, "signal", errors)
    if harmonics > held:
        raise InputError(
            f"{recording.source}: {len(recording.pressure)} samples hold {held} harmonics, {harmonics} cannot be "
            "compared; give fewer, or 'all'"
        )
    return Compared(recording, 2 * harmonics + 1, "given", errors)


def checked_harmonics(value: int | str) -> int | str:
    """Return "signal", "all" or a number of harmonics from 8 to 511; raise `InputError` for anything else."""
    if value in ("signal", "all"):
        return value
    number = int(value) if str(value).isdecimal() else 0
    if not FEWEST <= number < MOST_SAMPLES // 2:
        raise InputError(f"'{value}': give 'signal', 'all', or a number of harmonics from {FEWEST} to 511")
    return number
