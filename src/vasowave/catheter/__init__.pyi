"""From files of pressure and flow to one averaged cycle and its hemodynamic indices."""

from vasowave.catheter.beats.beats import Beats as Beats
from vasowave.catheter.beats.beats import find_beats as find_beats
from vasowave.catheter.beats.edits import BeatEdit as BeatEdit
from vasowave.catheter.beats.edits import read_edits as read_edits
from vasowave.catheter.beats.prepared import Averaging as Averaging
from vasowave.catheter.check.catheter import Catheter as Catheter
from vasowave.catheter.check.catheter import LowPass as LowPass
from vasowave.catheter.check.catheter import correct_catheter as correct_catheter
from vasowave.catheter.check.catheter import ringing as ringing
from vasowave.catheter.check.catheter import suspect_catheter as suspect_catheter
from vasowave.catheter.check.catheter import without_delays as without_delays
from vasowave.catheter.ensemble import average_beats as average_beats
from vasowave.catheter.ensemble import average_prepared as average_prepared
from vasowave.catheter.read.describe import FileDescription as FileDescription
from vasowave.catheter.read.describe import describe_recording as describe_recording
from vasowave.catheter.read.read import read_recording as read_recording
from vasowave.catheter.read.read_raw import Reading as Reading
from vasowave.catheter.read.read_raw import read_raw_recording as read_raw_recording
from vasowave.catheter.read.site_files import read_sites as read_sites
from vasowave.catheter.read.ventricle import read_ventricle as read_ventricle
from vasowave.catheter.read.wedge import read_wedge as read_wedge
from vasowave.catheter.signals.raw import RawRecording as RawRecording
from vasowave.catheter.synthetic import Disturbances as Disturbances
from vasowave.catheter.synthetic import SyntheticRecording as SyntheticRecording
from vasowave.catheter.synthetic import synthetic_raw_recording as synthetic_raw_recording
from vasowave.catheter.synthetic_files import SYNTHETIC_NOTICE as SYNTHETIC_NOTICE
from vasowave.catheter.synthetic_files import labchart_text as labchart_text
from vasowave.catheter.synthetic_files import table_text as table_text
from vasowave.pulse.cycle.averaged import Beat as Beat
from vasowave.pulse.cycle.averaged import EnsembleAverage as EnsembleAverage
from vasowave.pulse.cycle.averaged import one_cycle as one_cycle
from vasowave.pulse.cycle.cycle import Inflow as Inflow
from vasowave.pulse.cycle.cycle import InletPressure as InletPressure
from vasowave.pulse.cycle.cycle import Recording as Recording
from vasowave.pulse.cycle.cycle import resample as resample
from vasowave.pulse.cycle.cycle import samples_needed as samples_needed
from vasowave.pulse.cycle.harmonics import HarmonicErrors as HarmonicErrors
from vasowave.pulse.cycle.harmonics import harmonic_errors as harmonic_errors
from vasowave.pulse.cycle.observation import Observation as Observation
from vasowave.pulse.cycle.response import second_order as second_order
from vasowave.pulse.cycle.trend import Baseline as Baseline
from vasowave.pulse.cycle.trend import LevelStep as LevelStep
from vasowave.pulse.cycle.ventricular import VentricularPressure as VentricularPressure

__all__: list[str]
