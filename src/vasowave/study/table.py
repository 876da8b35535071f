"""The table of animals as rows of text that are written back as they were: columns, order and comments are kept."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vasowave.io.columns import is_row, read_columns, separator_of, split_cells
from vasowave.io.textfile import read_lines
from vasowave.study.rows import COLUMNS, NEEDED


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
    kept = [text for text in lines if is_row(text)]
    if len(kept) < 2:
        cells = split_cells(path, len(lines), kept[0], separator_of(kept[0])) if kept else []
        return Rows(comments, tuple(map(_title, cells)), ())
    table = read_columns(path)
    titles = [f"{name} [{unit}]" if unit else name for name, unit in zip(table.names, table.units, strict=True)]
    named = tuple(map(_title, titles))
    return Rows(comments, named, tuple(dict(zip(named, row, strict=True)) for row in table.cells))


def written_rows(table: Rows, new: Sequence[dict[str, str]]) -> str:
    """Return the text of a table with new rows below the old ones; columns that are needed are always there."""
    rows = [*table.rows, *new]
    used = [title for title in COLUMNS if title in NEEDED or any(row.get(title) for row in rows)]
    header = [*table.titles, *(title for title in used if title not in table.titles)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([row.get(title, "") for title in header] for row in rows)
    return "\n".join([*table.comments, text.getvalue()])


def _title(written: str) -> str:
    exact = {title.casefold(): title for title in COLUMNS}
    return exact.get(written.strip().casefold(), written.strip())
