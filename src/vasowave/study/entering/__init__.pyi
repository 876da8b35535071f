"""Entering animals: files sorted into a table, groups, templates, checks."""

from vasowave.study.entering.added_rows import told_network as told_network
from vasowave.study.entering.adding import add_files as add_files
from vasowave.study.entering.checking import check_study as check_study
from vasowave.study.entering.grouping import is_reference as is_reference
from vasowave.study.entering.grouping import parsed_groups as parsed_groups
from vasowave.study.entering.grouping import proposed_groups as proposed_groups
from vasowave.study.entering.grouping import told_group as told_group
from vasowave.study.entering.occasions import told_occasions as told_occasions
from vasowave.study.entering.setting_values import remove_animals as remove_animals
from vasowave.study.entering.setting_values import set_values as set_values
from vasowave.study.entering.sorting import files_in as files_in
from vasowave.study.entering.table import RecordingIndex as RecordingIndex
from vasowave.study.entering.table import Rows as Rows
from vasowave.study.entering.table import read_rows as read_rows
from vasowave.study.entering.table import seen_from as seen_from
from vasowave.study.entering.table import written_rows as written_rows
from vasowave.study.entering.template import FOLDERS as FOLDERS
from vasowave.study.entering.template import new_study as new_study
from vasowave.study.entering.template import schema_text as schema_text
from vasowave.study.entering.template import study_text as study_text
from vasowave.study.entering.template import with_groups as with_groups
from vasowave.study.entering.template import with_values as with_values
from vasowave.study.entering.template import write_virtual_study as write_virtual_study
from vasowave.study.entering.template import written as written

__all__: list[str]
