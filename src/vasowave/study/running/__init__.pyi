"""From a study to its results: the plan, processes or a cluster, progress, report."""

from vasowave.study.running.basis import basis_of_study as basis_of_study
from vasowave.study.running.basis import with_outcome as with_outcome
from vasowave.study.running.engine import Job as Job
from vasowave.study.running.engine import Progress as Progress
from vasowave.study.running.engine import run_jobs as run_jobs
from vasowave.study.running.executors import compile_beside as compile_beside
from vasowave.study.running.executors import dask_cluster as dask_cluster
from vasowave.study.running.executors import process_pool as process_pool
from vasowave.study.running.plan import RECORD as RECORD
from vasowave.study.running.plan import declare as declare
from vasowave.study.running.plan import inspect_study as inspect_study
from vasowave.study.running.plan import read_declared as read_declared
from vasowave.study.running.plan import read_study as read_study
from vasowave.study.running.planning import published_spreads as published_spreads
from vasowave.study.running.programs import NOT_RUN as NOT_RUN
from vasowave.study.running.programs import programs_of as programs_of
from vasowave.study.running.programs import trust_study as trust_study
from vasowave.study.running.reporting import ONE_BY_ONE as ONE_BY_ONE
from vasowave.study.running.reporting import REPORT_FOLDER as REPORT_FOLDER
from vasowave.study.running.reporting import missing_of as missing_of
from vasowave.study.running.reporting import report_study as report_study
from vasowave.study.running.run_state import STATUS as STATUS
from vasowave.study.running.run_state import Ended as Ended
from vasowave.study.running.run_state import RunRecord as RunRecord
from vasowave.study.running.run_state import ask_to_stop as ask_to_stop
from vasowave.study.running.run_state import record_end as record_end
from vasowave.study.running.run_state import run_status as run_status
from vasowave.study.running.run_state import running as running
from vasowave.study.running.runs import Done as Done
from vasowave.study.running.runs import analyze_study as analyze_study
from vasowave.study.running.runs import run_alone as run_alone
from vasowave.study.running.runs import run_study as run_study
from vasowave.study.running.single_animal import SENTENCE_QUANTITIES as SENTENCE_QUANTITIES
from vasowave.study.running.single_animal import animal_alone as animal_alone
from vasowave.study.running.single_animal import fit_sentences as fit_sentences
from vasowave.study.running.single_animal import nothing_left as nothing_left
from vasowave.study.running.single_animal import one_row as one_row
from vasowave.study.running.single_animal import option_of as option_of
from vasowave.study.running.status import AnimalStatus as AnimalStatus
from vasowave.study.running.status import StudyStatus as StudyStatus
from vasowave.study.running.status import fit_status as fit_status
from vasowave.study.running.status import outdated as outdated
from vasowave.study.running.status import searches_of as searches_of
from vasowave.study.running.status import study_status as study_status

__all__: list[str]
