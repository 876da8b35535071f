"""What waveforms and calibrated models say: waves, impedance, compliance."""

from vasowave.analysis.compliance import Compliance, compliance
from vasowave.analysis.impedance import InputImpedance, fourier_series, impedance
from vasowave.analysis.waves import WaveIntensity, wave_intensity

__all__ = [
    "Compliance",
    "InputImpedance",
    "WaveIntensity",
    "compliance",
    "fourier_series",
    "impedance",
    "wave_intensity",
]
