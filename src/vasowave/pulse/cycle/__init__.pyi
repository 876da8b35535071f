"""One cycle of pressure and flow, with its harmonics, its errors and what was observed beside it."""

from vasowave.pulse.cycle.averaged import EnsembleAverage as EnsembleAverage
from vasowave.pulse.cycle.averaged import one_cycle as one_cycle
from vasowave.pulse.cycle.cycle import Inflow as Inflow
from vasowave.pulse.cycle.cycle import InletPressure as InletPressure
from vasowave.pulse.cycle.cycle import Recording as Recording
from vasowave.pulse.cycle.cycle import resample as resample
from vasowave.pulse.cycle.cycle import samples_needed as samples_needed
from vasowave.pulse.cycle.harmonics import harmonic_errors as harmonic_errors
from vasowave.pulse.cycle.observation import Observation as Observation
from vasowave.pulse.cycle.trend import Baseline as Baseline
from vasowave.pulse.cycle.trend import LevelStep as LevelStep
from vasowave.pulse.cycle.ventricular import PressureVolume as PressureVolume
from vasowave.pulse.cycle.ventricular import VentricularPressure as VentricularPressure
from vasowave.pulse.cycle.waveform import amplitudes as amplitudes
from vasowave.pulse.cycle.waveform import cycle_foot as cycle_foot
from vasowave.pulse.cycle.waveform import harmonic_error as harmonic_error

__all__: list[str]
