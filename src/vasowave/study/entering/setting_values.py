"""Settings and cells of a study that is there, written into its two files; comments and order stay."""

import unicodedata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from vasowave.base.cures import field_of
from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import Place
from vasowave.base.io.files import alone_in, content_of, write_files
from vasowave.base.io.spreadsheet import WORKBOOKS
from vasowave.study.entering.table import Rows, read_rows, written_rows
from vasowave.study.entering.template import with_values
from vasowave.study.folder.animal_columns import COLUMNS
from vasowave.study.folder.animals import read_row
from vasowave.study.folder.places import study_path
from vasowave.study.folder.reading import read_settings
from vasowave.study.folder.settings import StudyFile


def set_values(study: Path, values: Mapping[str, str], animals: Sequence[str] = ()) -> Path:
    """Write settings of a study, or cells of some of its animals; return the file that changed.

    Parameters
    ----------
    study : Path
        Its folder or its study file.
    values : mapping of str to str
        By key of the study file (``averaging.reject_ventilation``), as YAML; of `animals` by column of the table, with
        or without its unit, empty to clear the cell.
    animals : sequence of str
        Whose cells are meant.

    Raises
    ------
    InputError
        No study, no such key, column or animal, or a value that it cannot have; nothing is written then.
    """
    if animals:
        return _rewritten(study, lambda file: _with_cells(file, values, animals), in_table=True)
    return _rewritten(study, lambda file: _with_settings(file, values))


def remove_animals(study: Path, animals: Sequence[str]) -> Path:
    """Take the rows of animals out of the table of a study, and return it; raises as `set_values`."""

    def without(file: Path) -> str:
        table = _writable(file)
        rows = [row_of(table, file, animal) for animal in animals]
        return written_rows(replace(table, rows=tuple(row for row in table.rows if row not in rows)), ())

    return _rewritten(study, without, in_table=True)


def _rewritten(study: Path, content_of_file: Callable[[Path], str], in_table: bool = False) -> Path:
    """Write the study file or the table anew, while nobody else does, and return it."""
    path = study_path(Path(study))
    with alone_in(path.parent):
        settings, _ = read_settings(path)
        file = path.parent / (settings or StudyFile()).animals if in_table else path
        before = content_of(file)
        write_files({file: content_of_file(file)}, {file: before})
    return file


def _with_settings(path: Path, values: Mapping[str, str]) -> str:
    for key, text in values.items():
        section, _, name = key.rpartition(".")
        if "." in section:
            raise InputError(f"'{key}' stands in a setting that is written as a whole: {section}={{{name}: {text}}}")
    try:
        return with_values(path, {tuple(key.split(".")): text for key, text in values.items()})
    except InputError as error:
        wrong_before = any(problem.error for problem in read_settings(path)[1].problems)
        advice = "; the file had an error before, which is to be corrected in it" if wrong_before else ""
        raise InputError(f"nothing was written, for then it would be said: {error}{advice}", error.cures) from None


def _with_cells(file: Path, values: Mapping[str, str], animals: Sequence[str]) -> str:
    table, titles = _writable(file), {field_of(title): title for title in COLUMNS}
    values = {titles.get(title, title): text for title, text in values.items()}
    for animal in animals:
        check_cells(table, file, animal, values)
        row_of(table, file, animal).update(values)
    return written_rows(table, ())


def _writable(file: Path) -> Rows:
    if file.name.lower().endswith(WORKBOOKS):
        raise InputError(f"{file}: a workbook is changed by the program that wrote it")
    return read_rows(file)


def row_of(table: Rows, file: Path, animal: str) -> dict[str, str]:
    """Return the cells of an animal of a table that was read from a file; `InputError` unless one row is its."""
    matches = [row for row in table.rows if row["animal"] == animal]
    if len(matches) != 1:
        names = [row["animal"] for row in table.rows]
        if matches:
            raise InputError(f"two rows are called '{animal}' in {file.name}; rename one of them in the file")
        raise InputError(f"there is no animal '{animal}' in {file.name}{did_you_mean(animal, names)}")
    return matches[0]


def check_cells(table: Rows, file: Path, animal: str, cells: Mapping[str, str]) -> None:
    """Raise `InputError` at a column that a table lacks, and a value that no cell of its column can hold."""
    titles = dict.fromkeys((*COLUMNS, *table.titles))
    unknown = next((title for title in cells if title not in titles), None)
    if unknown is not None:
        raise InputError(f"there is no column '{unknown}'{did_you_mean(unknown, [*titles, *map(field_of, titles)])}")
    row = row_of(table, file, animal)
    _, wrong = read_row({**row, **cells}, file.parent, None, lambda title: Place(part=title))
    mine = [problem for problem in wrong if problem.error and cells.get(problem.place.part)]
    if mine:
        raise InputError(f"{mine[0].place.part}: {mine[0].finding}")
    name = cells.get("animal", animal)
    if not name or any(_alike(row["animal"], name) for row in table.rows if row["animal"] != animal):
        raise InputError(f"'{name}': an animal has a name that no other has")


def _alike(name: str, other_name: str) -> bool:
    """Whether two names differ by capitals, blanks or the way in which accents are written alone."""
    plain = [" ".join(unicodedata.normalize("NFC", text).casefold().split()) for text in (name, other_name)]
    return plain[0] == plain[1]
