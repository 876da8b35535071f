"""What `import vasowave` offers, and where each name lives; `__init__.py` finds it here when it is asked for."""

from vasowave import walls as walls
from vasowave.analysis import compliance as compliance
from vasowave.analysis import impedance as impedance
from vasowave.analysis import wave_intensity as wave_intensity
from vasowave.animal.animal import Animal as Animal
from vasowave.animal.animal import Settings as Settings
from vasowave.animal.pipeline import analyze as analyze
from vasowave.animal.stored import stored_model as stored_model
from vasowave.blood import Blood as Blood
from vasowave.blood import BoundaryLayer as BoundaryLayer
from vasowave.blood import Poiseuille as Poiseuille
from vasowave.blood import PowerLaw as PowerLaw
from vasowave.calibration import Search as Search
from vasowave.calibration import profile_likelihood as profile_likelihood
from vasowave.datasets import control_network as control_network
from vasowave.datasets import virtual_mouse as virtual_mouse
from vasowave.exchange import export_model as export_model
from vasowave.exchange import read_openbf as read_openbf
from vasowave.inference import Posterior as Posterior
from vasowave.inference import Priors as Priors
from vasowave.inference import posterior as posterior
from vasowave.interactive import Fit as Fit
from vasowave.interactive import calibrate as calibrate
from vasowave.model import Model as Model
from vasowave.network import Network as Network
from vasowave.network_formats import read_network as read_network
from vasowave.nominal import Nominal as Nominal
from vasowave.nominal import estimate_nominal as estimate_nominal
from vasowave.outlets import ImpedanceSpectrum as ImpedanceSpectrum
from vasowave.outlets import Windkessel as Windkessel
from vasowave.recording import EnsembleAverage as EnsembleAverage
from vasowave.recording import Inflow as Inflow
from vasowave.recording import RawRecording as RawRecording
from vasowave.recording import Recording as Recording
from vasowave.recording import average_beats as average_beats
from vasowave.recording import describe_recording as describe_recording
from vasowave.recording import read_raw_recording as read_raw_recording
from vasowave.recording import read_recording as read_recording
from vasowave.report.write import write_report as write_report
from vasowave.selection import Comparing as Comparing
from vasowave.selection import compare_models as compare_models
from vasowave.solver import Numerics as Numerics
from vasowave.solver import simulate as simulate
from vasowave.solver import sweep as sweep
from vasowave.study.plan import read_study as read_study
from vasowave.study.results import read_results as read_results
from vasowave.study.running import run_study as run_study
from vasowave.tidying import tidy as tidy
from vasowave.vessel_table import write_network as write_network
from vasowave.walls import LinearWall as LinearWall
from vasowave.walls import TangentWall as TangentWall

__version__: str
__all__: list[str]
