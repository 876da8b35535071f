"""What waveforms and calibrated models say: waves, impedance, compliance, and what changes along the tree."""

from vasowave.analysis.compliance import Compliance, compliance
from vasowave.analysis.impedance import InputImpedance, characteristic_impedances, fourier_series, impedance
from vasowave.analysis.operating import OperatingPoint, WavesAt, measured_operating_point, operating_point
from vasowave.analysis.stenosis import FittedStenosis, fit_stenosis
from vasowave.analysis.tree import pressure_drop, wave_speeds
from vasowave.analysis.waves import WAVES, WaveIntensity, largest_waves, named_waves, wave_intensity

__all__ = [
    "WAVES",
    "Compliance",
    "FittedStenosis",
    "InputImpedance",
    "OperatingPoint",
    "WaveIntensity",
    "WavesAt",
    "characteristic_impedances",
    "compliance",
    "fit_stenosis",
    "fourier_series",
    "impedance",
    "largest_waves",
    "measured_operating_point",
    "named_waves",
    "operating_point",
    "pressure_drop",
    "wave_intensity",
    "wave_speeds",
]
