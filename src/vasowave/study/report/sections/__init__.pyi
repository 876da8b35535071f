"""The sections of a report, one file each; on the page: summary, data, models, groups, animals, methods."""

from vasowave.study.report.sections.animals import fit_sentences as fit_sentences
from vasowave.study.report.sections.data import data_section as data_section
from vasowave.study.report.sections.groups import groups_section as groups_section
from vasowave.study.report.sections.methods import methods_section as methods_section
from vasowave.study.report.sections.models import space_block as space_block

__all__: list[str]
