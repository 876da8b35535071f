"""The sections of a report with their tables, one file each: groups, data, models, laws, animals, methods."""

from vasowave.study.report.sections.animals import fit_sentences as fit_sentences
from vasowave.study.report.sections.data import data_section as data_section
from vasowave.study.report.sections.groups import groups_section as groups_section
from vasowave.study.report.sections.groups import primary_tables as primary_tables
from vasowave.study.report.sections.laws import laws_by_posterior as laws_by_posterior
from vasowave.study.report.sections.laws import preference_table as preference_table
from vasowave.study.report.sections.laws import selection_table as selection_table
from vasowave.study.report.sections.laws import sites_table as sites_table
from vasowave.study.report.sections.methods import methods_section as methods_section
from vasowave.study.report.sections.models import space_block as space_block
from vasowave.study.report.wording import median_iqr as median_iqr

__all__: list[str]
