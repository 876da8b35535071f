"""Animals of a study: their results, the comparison of groups, figures, report and exchange."""

from vasowave.study.animal.animal import Animal as Animal
from vasowave.study.animal.animal import Settings as Settings
from vasowave.study.animal.pipeline import analyze as analyze
from vasowave.study.animal.result import AnimalResult as AnimalResult
from vasowave.study.animal.stored import stored_model as stored_model
from vasowave.study.cohort.design import Design as Design
from vasowave.study.cohort.variables import Variable as Variable
from vasowave.study.door.fit import Fit as Fit
from vasowave.study.door.fit import calibrate as calibrate
from vasowave.study.exchange.export import export_model as export_model
from vasowave.study.exchange.openbf_reading import read_openbf as read_openbf
from vasowave.study.exchange.svzerod_reading import read_svzerod as read_svzerod
from vasowave.study.report.settings import ReportSettings as ReportSettings
from vasowave.study.report.write import write_report as write_report
from vasowave.study.results.results import read_results as read_results
from vasowave.study.running.plan import read_study as read_study
from vasowave.study.running.planning import plan as plan
from vasowave.study.running.programs import trust_study as trust_study
from vasowave.study.running.runs import run_study as run_study
from vasowave.study.running.status import study_status as study_status

__all__: list[str]
