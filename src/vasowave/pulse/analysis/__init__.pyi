"""What waveforms and calibrated models say: waves, impedance, compliance, and what changes along the tree."""

from vasowave.pulse.analysis.attribution import Attribution as Attribution
from vasowave.pulse.analysis.attribution import attribute_change as attribute_change
from vasowave.pulse.analysis.compliances import Compliance as Compliance
from vasowave.pulse.analysis.compliances import compliance as compliance
from vasowave.pulse.analysis.compliances import series_parallel as series_parallel
from vasowave.pulse.analysis.ejection import CycleIndices as CycleIndices
from vasowave.pulse.analysis.ejection import beat_indices as beat_indices
from vasowave.pulse.analysis.ejection import cycle_indices as cycle_indices
from vasowave.pulse.analysis.impedance_spectrum import InputImpedance as InputImpedance
from vasowave.pulse.analysis.impedance_spectrum import characteristic_impedances as characteristic_impedances
from vasowave.pulse.analysis.impedance_spectrum import fourier_series as fourier_series
from vasowave.pulse.analysis.impedance_spectrum import impedance as impedance
from vasowave.pulse.analysis.loops import PressureVolumeLoop as PressureVolumeLoop
from vasowave.pulse.analysis.loops import cut_loops as cut_loops
from vasowave.pulse.analysis.operating import OperatingPoint as OperatingPoint
from vasowave.pulse.analysis.operating import WavesAt as WavesAt
from vasowave.pulse.analysis.operating import measured_operating_point as measured_operating_point
from vasowave.pulse.analysis.operating import operating_point as operating_point
from vasowave.pulse.analysis.prediction import Prediction as Prediction
from vasowave.pulse.analysis.prediction import predict as predict
from vasowave.pulse.analysis.sensitivity_table import COLUMNS as COLUMNS
from vasowave.pulse.analysis.sensitivity_table import Sensitivity as Sensitivity
from vasowave.pulse.analysis.shear import regional_loads as regional_loads
from vasowave.pulse.analysis.shear import vessel_loads as vessel_loads
from vasowave.pulse.analysis.shear import wall_shear as wall_shear
from vasowave.pulse.analysis.stenosis import FittedStenosis as FittedStenosis
from vasowave.pulse.analysis.stenosis import fit_stenosis as fit_stenosis
from vasowave.pulse.analysis.stenosis_ranking import rank_stenoses as rank_stenoses
from vasowave.pulse.analysis.tree import pressure_drop as pressure_drop
from vasowave.pulse.analysis.tree import wave_speeds as wave_speeds
from vasowave.pulse.analysis.uncertain import UncertainModel as UncertainModel
from vasowave.pulse.analysis.uncertain import uncertain_model as uncertain_model
from vasowave.pulse.analysis.uncertain_loads import load_intervals as load_intervals
from vasowave.pulse.analysis.ventricle_coupling import Coupling as Coupling
from vasowave.pulse.analysis.ventricle_coupling import coupling as coupling
from vasowave.pulse.analysis.ventricular_function import VENTRICULAR as VENTRICULAR
from vasowave.pulse.analysis.ventricular_function import VentricularFunction as VentricularFunction
from vasowave.pulse.analysis.ventricular_function import pressure_volume as pressure_volume
from vasowave.pulse.analysis.waves import WAVES as WAVES
from vasowave.pulse.analysis.waves import WaveIntensity as WaveIntensity
from vasowave.pulse.analysis.waves import largest_waves as largest_waves
from vasowave.pulse.analysis.waves import named_waves as named_waves
from vasowave.pulse.analysis.waves import wave_intensity as wave_intensity

__all__: list[str]
