"""The folder of a study: its settings, its table of animals, its design."""

from vasowave.study.folder.animal_columns import COLUMNS as COLUMNS
from vasowave.study.folder.animal_columns import ERRORS as ERRORS
from vasowave.study.folder.animals import read_animals as read_animals
from vasowave.study.folder.animals import read_row as read_row
from vasowave.study.folder.animals import variables_of as variables_of
from vasowave.study.folder.designing import understood as understood
from vasowave.study.folder.names import MAX_NAME_LETTERS as MAX_NAME_LETTERS
from vasowave.study.folder.names import checked_name as checked_name
from vasowave.study.folder.names import plain_name as plain_name
from vasowave.study.folder.places import RESULTS as RESULTS
from vasowave.study.folder.places import STUDY_FILE as STUDY_FILE
from vasowave.study.folder.places import YAML as YAML
from vasowave.study.folder.places import study_path as study_path
from vasowave.study.folder.problems import UNREADABLE as UNREADABLE
from vasowave.study.folder.problems import StudyProblem as StudyProblem
from vasowave.study.folder.problems import by_kind as by_kind
from vasowave.study.folder.problems import refuse as refuse
from vasowave.study.folder.reading import home_of as home_of
from vasowave.study.folder.reading import parse_document as parse_document
from vasowave.study.folder.reading import parse_settings as parse_settings
from vasowave.study.folder.reading import read_document as read_document
from vasowave.study.folder.reading import read_settings as read_settings
from vasowave.study.folder.reading import too_long as too_long
from vasowave.study.folder.reading import validated as validated
from vasowave.study.folder.settings import BloodSection as BloodSection
from vasowave.study.folder.settings import StudyFile as StudyFile
from vasowave.study.folder.settings import animal_settings as animal_settings
from vasowave.study.folder.study import Study as Study

__all__: list[str]
