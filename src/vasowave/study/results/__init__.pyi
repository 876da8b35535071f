"""Stored results of a study: what is computed already, and what they hold."""

from vasowave.study.results.attribution import attributed as attributed
from vasowave.study.results.loading import animal_key as animal_key
from vasowave.study.results.loading import file_hashes as file_hashes
from vasowave.study.results.loading import load_animal as load_animal
from vasowave.study.results.loading import load_recording as load_recording
from vasowave.study.results.loading import read_stretch as read_stretch
from vasowave.study.results.overview import AnimalRead as AnimalRead
from vasowave.study.results.overview import aligned as aligned
from vasowave.study.results.overview import expected_seconds as expected_seconds
from vasowave.study.results.overview import overview_lines as overview_lines
from vasowave.study.results.physiology import blood_findings as blood_findings
from vasowave.study.results.physiology import physiology_findings as physiology_findings
from vasowave.study.results.physiology import tell_blood as tell_blood
from vasowave.study.results.results import INDEX as INDEX
from vasowave.study.results.results import Results as Results
from vasowave.study.results.results import read_results as read_results
from vasowave.study.results.results import write_results as write_results
from vasowave.study.results.store import LOCK as LOCK
from vasowave.study.results.store import SEARCHES as SEARCHES
from vasowave.study.results.store import Journal as Journal
from vasowave.study.results.store import ResultStore as ResultStore
from vasowave.study.results.store import holder as holder
from vasowave.study.results.store import locked as locked
from vasowave.study.results.store import read_journal as read_journal

__all__: list[str]
