"""What the Study desk can change: the study file, and rows, cells and columns of the table of animals."""

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any

from annotated_types import MaxLen, MinLen

from vasowave.base.errors import InputError
from vasowave.base.io.spreadsheet import WORKBOOKS
from vasowave.base.species import SpeciesName
from vasowave.study.entering.adding import Added, add_files
from vasowave.study.entering.grouping import parsed_groups, regrouped
from vasowave.study.entering.setting_values import check_cells, row_of
from vasowave.study.entering.table import Rows, check_written, read_rows, written_rows
from vasowave.study.entering.template import new_study, with_groups, with_values
from vasowave.study.folder.animal_columns import COLUMNS, FILES
from vasowave.study.folder.animals import read_animals
from vasowave.study.folder.names import checked_name
from vasowave.study.running.programs import programs_of, trust_study
from vasowave.workbench.desk import Change, Desk, unchanged
from vasowave.workbench.workplace import Workplace, action

Name = Annotated[str, MinLen(1), MaxLen(500)]


@action("new-study")
def new(workplace: Workplace, groups: tuple[Name, ...] = ("CTL", "HPH"), species: SpeciesName = "mouse") -> str:
    """Make a study in the folder that is open."""
    new_study(workplace.desk.folder, [checked_name(group.strip()) for group in groups], species)
    return "a new study"


@action("add-files")
def add(
    workplace: Workplace,
    files: Annotated[list[Name], MinLen(1), MaxLen(10_000)],
    group: str = "",
    species: SpeciesName = "mouse",
) -> Mapping[str, Any]:
    """Write a row for every recording among files that were dropped into the study; a new one is of a species."""
    desk = workplace.desk
    if not desk.file.exists():
        new_study(desk.folder, species=species)
    places = [desk.inside(file) for file in files]
    with desk.changing("add files", desk.table, desk.file) as change:
        added = add_files(desk.folder, places, group=group)
        change.read_again()
    return _told(added)


def _told(added: Added) -> dict[str, Any]:
    """Return the outcome of adding files as the page shows it."""
    names = [row["animal"] for row in added.rows]
    return {"animals": names, "said": [*added.said, *(f"not added: {reason}" for reason in added.refused)]}


@action("add-arrivals")
def add_arrivals(workplace: Workplace) -> Mapping[str, Any]:
    """Write rows of the files that were saved beside the recordings of the study since it was opened."""
    added = workplace.arrivals.add() if workplace.desk.file.exists() else None
    return _told(added) if added is not None else {"animals": [], "said": []}


@action("set-cells")
def set_cells(
    workplace: Workplace,
    animal: Name,
    cells: dict[Name, Annotated[str, MaxLen(2000)]],
    was: dict[str, str] | None = None,
) -> str:
    """Write cells of one animal; `was` is what the page showed in them."""
    desk, cells = workplace.desk, {title: " ".join(text.split()) for title, text in cells.items()}
    with desk.changing(f"{', '.join(cells)} of {animal}", desk.table) as change:
        table = read_rows(desk.table)
        row, titles = row_of(table, desk.table, animal), {*COLUMNS, *table.titles}
        unchanged(animal, {title: text for title, text in (was or {}).items() if title in titles}, row)
        check_cells(table, desk.table, animal, cells)
        for title in FILES:
            if cells.get(title):
                desk.inside(cells[title])
        write_cells(desk, change, table, animal, cells)
    return f"{animal}: {', '.join(f'{title} {text}' for title, text in cells.items())}"


def write_cells(desk: Desk, change: Change, table: Rows, animal: str, cells: Mapping[str, str]) -> None:
    """Write cells into a table that was just read."""
    row_of(table, desk.table, animal).update(cells)
    change.write(desk.table, written_rows(table, ()))


@action("use-network")
def use_network(workplace: Workplace, network: Name) -> Mapping[str, Any]:
    """Choose a network for every animal that has none, or whose file is not there."""
    desk = workplace.desk
    if not desk.inside(network).is_file():
        raise InputError(f"there is no file {network} in this study")
    with desk.changing(f"network {network}", desk.table) as change:
        table = read_rows(desk.table)
        lacking = [row for row in table.rows if not (desk.folder / (row.get("network") or ".")).is_file()]
        for row in lacking:
            row["network"] = network
        change.write(desk.table, written_rows(table, ()))
    names = [row["animal"] for row in lacking]
    return {"animals": names, "said": [f"{network} is the network of: {', '.join(names) or 'no animal more'}"]}


@action("add-column")
def add_column(workplace: Workplace, title: Annotated[str, MinLen(1), MaxLen(100)]) -> str:
    """Give the table a column of the lab's own: sex, weight [g], date."""
    title, table = " ".join(title.split()), workplace.desk.table
    if not title or not title.isprintable():
        raise InputError("a column has a title")
    if title.casefold() in map(str.casefold, COLUMNS):
        raise InputError(f"'{title}' is not a column of your own: it has a meaning here, and stands among all columns")
    with workplace.desk.changing(f"column {title}", table) as change:
        old_rows = read_rows(table)
        new_rows = replace(old_rows, titles=(*old_rows.titles, title))
        change.write(table, written_rows(new_rows, ()))
        check_written(table, new_rows)
        wrong = [
            problem
            for problem in read_animals(table, None)[1]
            if problem.error and f"column '{title}'" in problem.place.part
        ]
        if wrong:
            raise InputError(f"{title}: {wrong[0].finding}")
    return f"a column '{title}' of your own"


@action("remove-column")
def remove_column(workplace: Workplace, title: Name) -> str:
    """Take a column of the lab's own out of the table, with what stands in it."""
    table = workplace.desk.table
    with workplace.desk.changing(f"remove column {title}", table) as change:
        old_rows = read_rows(table)
        if title in COLUMNS or title not in old_rows.titles:
            raise InputError(f"there is no column '{title}' of your own in {table.name}")
        titles = tuple(heading for heading in old_rows.titles if heading != title)
        rows = tuple({heading: text for heading, text in row.items() if heading != title} for row in old_rows.rows)
        change.write(table, written_rows(replace(old_rows, rows=rows, titles=titles), ()))
    return f"column '{title}' removed"


@action("remove-animal")
def remove_animal(workplace: Workplace, animal: Name) -> str:
    """Take the row of an animal out of the table; its files stay."""
    with workplace.desk.changing(f"remove {animal}", workplace.desk.table) as change:
        table = read_rows(workplace.desk.table)
        rows = tuple(row for row in table.rows if row["animal"] != animal)
        if len(rows) == len(table.rows):
            raise InputError(f"there is no animal '{animal}' in {workplace.desk.table.name}")
        change.write(workplace.desk.table, written_rows(replace(table, rows=rows), ()))
    return f"{animal} removed from the table; its files stay"


@action("trust-programs")
def trust(workplace: Workplace, programs: dict[Name, Annotated[str, MaxLen(200)]]) -> str:
    """Allow the programs of the study to run, by the names of their files and the SHA-256 of what the page showed."""
    programs_by_name = {program.name: program for program in programs_of(workplace.desk.folder)}
    wrong = [
        name
        for name, digest in programs.items()
        if name not in programs_by_name or programs_by_name[name].sha256 != digest
    ]
    if wrong:
        raise InputError("a program was changed meanwhile; read it again, nothing was allowed")
    allowed = trust_study(workplace.desk.folder, [programs_by_name[name] for name in programs])
    return f"allowed to run in this study: {', '.join(program.name for program in allowed)}"


@action("set-setting")
def set_setting(workplace: Workplace, key: Annotated[str, MaxLen(100)], value: Annotated[str, MaxLen(2000)]) -> str:
    """Write one key of study.yaml."""
    if not re.fullmatch(r"\w+(\.\w+)?", key) or "\n" in value:
        raise InputError(f"'{key}: {value}' is not a key with a value")
    with workplace.desk.changing(f"{key}: {value}", workplace.desk.file) as change:
        change.write(workplace.desk.file, with_values(workplace.desk.file, {tuple(key.split(".")): value}))
    return f"{key}: {value}"


@action("set-groups")
def set_groups(workplace: Workplace, groups: list[Name]) -> str:
    """Name the groups of the study, the reference first (CTL, or CTL=wt where names hold another word).

    Animals that are of none of them get the one that the names of their files hold.
    """
    desk, marks = workplace.desk, parsed_groups(",".join(groups))
    with desk.changing("groups", desk.file, desk.table) as change:
        change.write(desk.file, with_groups(desk.file, list(marks)))
        table = read_rows(desk.table)
        animals = [] if desk.table.name.lower().endswith(WORKBOOKS) else regrouped(table.rows, marks, desk.folder)
        if animals:
            change.write(desk.table, written_rows(table, ()))
    counts = ", ".join(f"{label} ({sum(row.get('group') == label for row in table.rows)})" for label in marks)
    return f"groups: {counts}" + (f"; by the names of their files: {', '.join(animals)}" if animals else "")
