"""Reading and writing files of any content: text, tables, workbooks, columns with units."""

from vasowave.base.io.answers import answer_to as answer_to
from vasowave.base.io.answers import basis_of as basis_of
from vasowave.base.io.answers import keep_answer as keep_answer
from vasowave.base.io.columns import NoRowsError as NoRowsError
from vasowave.base.io.columns import read_columns as read_columns
from vasowave.base.io.files import FOLDER_LOCK as FOLDER_LOCK
from vasowave.base.io.files import alone_in as alone_in
from vasowave.base.io.files import check_file as check_file
from vasowave.base.io.files import check_folder as check_folder
from vasowave.base.io.files import content_of as content_of
from vasowave.base.io.files import lies_inside as lies_inside
from vasowave.base.io.files import made_inside as made_inside
from vasowave.base.io.files import not_written as not_written
from vasowave.base.io.files import remove_parts as remove_parts
from vasowave.base.io.files import write_file as write_file
from vasowave.base.io.files import write_files as write_files
from vasowave.base.io.files import write_folder as write_folder
from vasowave.base.io.formats import Format as Format
from vasowave.base.io.formats import Registry as Registry
from vasowave.base.io.matlab import read_mat as read_mat
from vasowave.base.io.reserved import SLOT as SLOT
from vasowave.base.io.textfile import LONGEST_LINE as LONGEST_LINE
from vasowave.base.io.textfile import look as look
from vasowave.base.io.textfile import read_lines as read_lines
from vasowave.base.io.trusted import is_allowed as is_allowed

__all__: list[str]
