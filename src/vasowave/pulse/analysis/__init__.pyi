"""What waveforms and calibrated models say: waves, impedance, compliance, and what changes along the tree."""

from vasowave.pulse.analysis.compliances import Compliance as Compliance
from vasowave.pulse.analysis.compliances import compliance as compliance
from vasowave.pulse.analysis.compliances import series_parallel as series_parallel
from vasowave.pulse.analysis.impedance_spectrum import InputImpedance as InputImpedance
from vasowave.pulse.analysis.impedance_spectrum import characteristic_impedances as characteristic_impedances
from vasowave.pulse.analysis.impedance_spectrum import fourier_series as fourier_series
from vasowave.pulse.analysis.impedance_spectrum import impedance as impedance
from vasowave.pulse.analysis.operating import OperatingPoint as OperatingPoint
from vasowave.pulse.analysis.operating import WavesAt as WavesAt
from vasowave.pulse.analysis.operating import measured_operating_point as measured_operating_point
from vasowave.pulse.analysis.operating import operating_point as operating_point
from vasowave.pulse.analysis.stenosis import FittedStenosis as FittedStenosis
from vasowave.pulse.analysis.stenosis import fit_stenosis as fit_stenosis
from vasowave.pulse.analysis.tree import pressure_drop as pressure_drop
from vasowave.pulse.analysis.tree import wave_speeds as wave_speeds
from vasowave.pulse.analysis.ventricle_coupling import Coupling as Coupling
from vasowave.pulse.analysis.ventricle_coupling import coupling as coupling
from vasowave.pulse.analysis.waves import WAVES as WAVES
from vasowave.pulse.analysis.waves import WaveIntensity as WaveIntensity
from vasowave.pulse.analysis.waves import largest_waves as largest_waves
from vasowave.pulse.analysis.waves import named_waves as named_waves
from vasowave.pulse.analysis.waves import wave_intensity as wave_intensity

__all__: list[str]
