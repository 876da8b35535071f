"""The table of animals as rows of text, written back as they were, and which recordings it has already."""

import csv
import io
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from vasowave.base.errors import InputError
from vasowave.base.io.cells import is_row, separator_of, split_cells
from vasowave.base.io.columns import read_columns
from vasowave.base.io.textfile import look, read_lines
from vasowave.catheter.read.describe import describe_recording
from vasowave.study.cohort.effects import grouped
from vasowave.study.entering.sorting import Recorded
from vasowave.study.folder.animal_columns import COLUMNS, REQUIRED_COLUMNS


@dataclass(frozen=True)
class Rows:
    """The titles and rows of a table, and the comments at its head."""

    comments: tuple[str, ...]
    titles: tuple[str, ...]
    rows: tuple[dict[str, str], ...]


def read_rows(path: Path) -> Rows:
    """Return the table as it stands; a table that is absent or empty has no titles.

    Raises
    ------
    InputError
        It cannot be read.
    """
    if not path.exists():
        return Rows((), (), ())
    lines = [text for block in read_lines(path) for text in block.texts]
    comments = tuple(text.rstrip("\r") for text in lines if text.lstrip().startswith("#"))
    row_texts = [text for text in lines if is_row(text)]
    if len(row_texts) < 2:
        cells = split_cells(path, len(lines), row_texts[0], separator_of(row_texts[0])) if row_texts else []
        return Rows(comments, tuple(map(_title, cells)), ())
    table = read_columns(path)
    titles = [f"{name} [{unit}]" if unit else name for name, unit in zip(table.names, table.units, strict=True)]
    named = tuple(map(_title, titles))
    return Rows(comments, named, tuple(dict(zip(named, row, strict=True)) for row in table.cells))


def written_rows(table: Rows, new: Sequence[dict[str, str]]) -> str:
    """Return the text of a table with new rows below the old ones; columns that are needed are always there."""
    rows = [*table.rows, *new]
    used = [title for title in COLUMNS if title in REQUIRED_COLUMNS or any(row.get(title) for row in rows)]
    used += dict.fromkeys(title for row in rows for title, text in row.items() if text and title not in COLUMNS)
    header = [*table.titles, *(title for title in used if title not in table.titles)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([row.get(title, "") for title in header] for row in rows)
    return "\n".join([*table.comments, text.getvalue()])


def check_written(path: Path, table: Rows) -> None:
    """Raise `InputError` if a table that was just written, whose last title is new, is not read as it was meant."""
    titles = read_rows(path).titles[: len(table.titles)]
    if titles != table.titles:
        raise InputError(f"the title '{table.titles[-1]}' would be read as '{titles[-1]}'; write it like that")


def _title(written: str) -> str:
    exact = {title.casefold(): title for title in COLUMNS}
    return exact.get(written.strip().casefold(), written.strip())


class RecordingIndex:
    """The recordings that the table has, by place, by the name of a file that is gone, and by content.

    Holds state because a recording that was looked up counts as one that the table has.
    """

    def __init__(self, folder: Path, rows: Sequence[dict[str, str]]) -> None:
        self.folder = folder
        files = [(folder / row["recording"], row) for row in rows if row.get("recording")]
        self.by_place = grouped(
            ((file.resolve(), key, row) for file, row in files for key in _keys_in_file(row)), lambda entry: entry[:2]
        )
        self.lost: dict[str, dict[str, str]] = {file.name: row for file, row in files if not file.exists()}
        self.by_content: dict[tuple[str, str, str], str] = {
            (_digest(file), key, sheet): row["animal"]
            for file, row in files if file.is_file() for key in _keys_in_file(row) for sheet in {_sheet(row), ""}
        }  # fmt: skip

    def row_of(self, recorded: Recorded) -> dict[str, str] | None:
        """Return the row of a recording; that of a file that is gone if it had the same name."""
        file = recorded.files[0]
        row = _of_sheet([row for *_, row in self.by_place.get((file.resolve(), recorded.in_file), [])], recorded)
        if row is None and file.name in self.lost:
            row = self.lost.pop(file.name)
            row["recording"] = seen_from(self.folder, file)
            if len(recorded.files) == 2:
                row["flow"] = seen_from(self.folder, recorded.files[1])
        return row

    def twin_of(self, recorded: Recorded) -> str:
        """Return the animal whose recording has the same bytes; else remember this one."""
        digest = _digest(recorded.files[0]), recorded.in_file, recorded.sheet.casefold()
        if digest in self.by_content:
            return self.by_content[digest]
        self.by_content[digest] = recorded.files[0].name
        return ""


def _keys_in_file(row: Mapping[str, str]) -> set[str]:
    """Return by what an animal is found in its file, whatever the case: its row there; the channel of its pressure."""
    subject, channel = (row.get(title, "").strip().casefold() for title in ("subject row", "pressure channel"))
    return {subject, subject or channel}


def _sheet(row: Mapping[str, str]) -> str:
    return row.get("sheet", "").strip().casefold()


def _of_sheet(rows: Sequence[dict[str, str]], recorded: Recorded) -> dict[str, str] | None:
    """Return the row of the sheet that was named; a row without a sheet is of the one that is read without a name."""
    by_sheet, named = {_sheet(row): row for row in reversed(rows)}, recorded.sheet.casefold()
    if named in by_sheet or not named:
        return by_sheet.get(named) or next(iter(rows), None)
    try:
        is_first = describe_recording(recorded.files[0]).used.sheet.casefold() in (named, "")
    except InputError:  # of no sheet without a name
        is_first = True
    return by_sheet.get("") if is_first else None


def _digest(file: Path) -> str:
    try:
        return look(file).sha256
    except InputError:
        return str(file)


def seen_from(folder: Path, file: Path) -> str:
    """Return the name of a file as the table writes it, whatever links lead to the folder or the file."""
    paths, real = [], folder.resolve()
    for place, start in ((file.absolute(), folder.absolute()), (file.absolute(), real), (file.resolve(), real)):
        try:
            paths.append(Path(os.path.relpath(place, start)))
        except ValueError:  # another drive
            continue
    right = (path for path in paths if (folder / path).exists() and (folder / path).samefile(file))
    return next(right, file.resolve()).as_posix()
