"""One animal from its recording to everything the study asks of it, as one labelled result."""

from vasowave.study.animal.animal import Animal as Animal
from vasowave.study.animal.animal import Calibration as Calibration
from vasowave.study.animal.animal import Settings as Settings
from vasowave.study.animal.datasets import beats_dataset as beats_dataset
from vasowave.study.animal.datasets import posterior_result as posterior_result
from vasowave.study.animal.datasets import recording_dataset as recording_dataset
from vasowave.study.animal.datasets import recording_with_scatter as recording_with_scatter
from vasowave.study.animal.failure import Failure as Failure
from vasowave.study.animal.failure import Stage as Stage
from vasowave.study.animal.failure import as_plain as as_plain
from vasowave.study.animal.failure import attempted as attempted
from vasowave.study.animal.failure import from_plain as from_plain
from vasowave.study.animal.files import failures_in as failures_in
from vasowave.study.animal.files import from_bytes as from_bytes
from vasowave.study.animal.files import read_result as read_result
from vasowave.study.animal.files import to_bytes as to_bytes
from vasowave.study.animal.files import write_result as write_result
from vasowave.study.animal.known_errors import effects_on_fit as effects_on_fit
from vasowave.study.animal.law_result import LawResult as LawResult
from vasowave.study.animal.law_result import Measured as Measured
from vasowave.study.animal.law_result import PosteriorResult as PosteriorResult
from vasowave.study.animal.pipeline import analyze as analyze
from vasowave.study.animal.pipeline import result_of as result_of
from vasowave.study.animal.quantities import derived_of as derived_of
from vasowave.study.animal.quantities import errors_of as errors_of
from vasowave.study.animal.quantities import quantities_of as quantities_of
from vasowave.study.animal.reading import autocorrelation as autocorrelation
from vasowave.study.animal.reading import fitted_decay as fitted_decay
from vasowave.study.animal.reading import from_foot as from_foot
from vasowave.study.animal.reading import impedance_error as impedance_error
from vasowave.study.animal.result import AnimalResult as AnimalResult
from vasowave.study.animal.result import FitPlots as FitPlots
from vasowave.study.animal.result import check_law_names as check_law_names
from vasowave.study.animal.result import network_dataset as network_dataset
from vasowave.study.animal.result import network_of as network_of
from vasowave.study.animal.signals import Station as Station
from vasowave.study.animal.signals import flow_noise as flow_noise
from vasowave.study.animal.signals import measured_station as measured_station
from vasowave.study.animal.signals import waves_dataset as waves_dataset
from vasowave.study.animal.stored import stored_inflow as stored_inflow
from vasowave.study.animal.stored import stored_law as stored_law
from vasowave.study.animal.stored import stored_model as stored_model
from vasowave.study.animal.stored import stored_recording as stored_recording
from vasowave.study.animal.stored import stored_sites as stored_sites

__all__: list[str]
