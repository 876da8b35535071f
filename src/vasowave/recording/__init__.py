"""From files of pressure and flow to one averaged cycle and its hemodynamic indices."""

from vasowave.recording.averaged import Beat, EnsembleAverage
from vasowave.recording.beats import Beats, find_beats
from vasowave.recording.catheter import (
    Catheter,
    LowPass,
    correct_catheter,
    ringing,
    second_order,
    suspect_catheter,
    without_delays,
)
from vasowave.recording.cycle import Inflow, InletPressure, Recording, resample, samples_needed
from vasowave.recording.describe import FileDescription, describe_recording
from vasowave.recording.edits import BeatEdit, read_edits
from vasowave.recording.ensemble import average_beats, one_cycle
from vasowave.recording.harmonics import HarmonicErrors, harmonic_errors
from vasowave.recording.observation import Observation
from vasowave.recording.prepared import Averaging
from vasowave.recording.raw import RawRecording
from vasowave.recording.read import read_recording
from vasowave.recording.read_raw import Reading, read_raw_recording
from vasowave.recording.read_sites import read_sites
from vasowave.recording.trend import Baseline, LevelStep
from vasowave.recording.ventricle import VentricularPressure, read_ventricle
from vasowave.recording.wedge import read_wedge

__all__ = [
    "Averaging",
    "Baseline",
    "Beat",
    "BeatEdit",
    "Beats",
    "Catheter",
    "EnsembleAverage",
    "FileDescription",
    "HarmonicErrors",
    "Inflow",
    "InletPressure",
    "LevelStep",
    "LowPass",
    "Observation",
    "RawRecording",
    "Reading",
    "Recording",
    "VentricularPressure",
    "average_beats",
    "correct_catheter",
    "describe_recording",
    "find_beats",
    "harmonic_errors",
    "one_cycle",
    "read_edits",
    "read_raw_recording",
    "read_recording",
    "read_sites",
    "read_ventricle",
    "read_wedge",
    "resample",
    "ringing",
    "samples_needed",
    "second_order",
    "suspect_catheter",
    "without_delays",
]
