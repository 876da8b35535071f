"""Cells of the table of animals as the workbench writes them: nothing that no cell of its column can hold."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from vasowave.errors import InputError, did_you_mean
from vasowave.io.files import write_file
from vasowave.study.animals import read_row
from vasowave.study.rows import COLUMNS, FILES
from vasowave.study.table import Rows, read_rows, written_rows
from vasowave.workbench.desk import Desk, unchanged


def set_cells(desk: Desk, animal: str, cells: Mapping[str, str], was: Mapping[str, str]) -> str:
    """Write cells of one animal; `was` is what the page showed in them."""
    with desk.changing(f"{', '.join(cells)} of {animal}", desk.table):
        table = read_rows(desk.table)
        known = dict.fromkeys((*COLUMNS, *table.titles))
        unknown = next((title for title in cells if title not in known), None)
        if unknown is not None:
            raise InputError(f"there is no column '{unknown}'{did_you_mean(unknown, known)}")
        row = _row(table.rows, animal, desk.table)
        unchanged(animal, {title: text for title, text in was.items() if title in known}, row)
        _check(desk, {**row, **cells}, cells, table.rows, animal)
        write_cells(desk, table, animal, cells)
    return f"{animal}: {', '.join(f'{title} {text}' for title, text in cells.items())}"


def write_cells(desk: Desk, table: Rows, animal: str, cells: Mapping[str, str]) -> None:
    """Write cells into a table that was just read."""
    row = _row(table.rows, animal, desk.table)
    row.update({title: " ".join(text.split()) for title, text in cells.items()})
    write_file(desk.table, written_rows(table, ()))


def _row(rows: tuple[dict[str, str], ...], animal: str, table: Path) -> dict[str, str]:
    found = [row for row in rows if row["animal"] == animal]
    if len(found) != 1:
        why = "there is no animal" if not found else "two rows are called"
        raise InputError(f"{why} '{animal}' in {table.name}")
    return found[0]


def _check(
    desk: Desk, row: Mapping[str, str], cells: Mapping[str, str], rows: Sequence[Mapping[str, str]], animal: str
) -> None:
    """Refuse a value that no cell of the column can hold; what may be lacking for a while may be empty."""
    from vasowave.findings import Place

    _, wrong = read_row(row, desk.folder, None, lambda title: Place(part=title))
    mine = [one for one in wrong if one.error and cells.get(one.place.part)]
    if mine:
        raise InputError(f"{mine[0].place.part}: {mine[0].finding}")
    name = cells.get("animal", animal)
    if not name or any(one["animal"].casefold() == name.casefold() for one in rows if one["animal"] != animal):
        raise InputError(f"'{name}': an animal has a name that no other has")
    for title in FILES:
        if cells.get(title):
            desk.inside(cells[title])
