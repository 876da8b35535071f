"""The table of animals: who belongs to which group, and which files hold what is known of it."""

import math
import re
import unicodedata
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Literal, cast

from vasowave.base import units
from vasowave.base.cures import UNKNOWN, NameGroups, SetCells, SetSetting, field_of
from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import NOWHERE, Finding, Place, error_kind, look_kind
from vasowave.base.io.columns import Columns, NoRowsError, number, read_columns, split_unit
from vasowave.base.sites import PULMONARY, SITES
from vasowave.pulse.inference.known_errors import SHARED_SOURCES, KnownErrors
from vasowave.pulse.model.blood import relative_to_usual
from vasowave.study.animal.result import TIDY_COLUMNS
from vasowave.study.cohort.variables import ALONE, GAPS, MISSPELT, Variable, likely_word
from vasowave.study.folder.animal_columns import COLUMNS, ERRORS, FILES, NUMBERS, REQUIRED_COLUMNS
from vasowave.study.folder.names import checked_name
from vasowave.study.folder.problems import UNREADABLE, StudyProblem, unreadable
from vasowave.study.folder.rows import AnimalRow
from vasowave.study.folder.synonyms import understood_title

_MIN_TITLE_SIMILARITY = 0.8  # share of letters in common with a title from which another is a slip
_MIN_CELL_VALUE, _MAX_CELL_VALUE = 1e-12, 1e12  # beyond what any number of the table can be in its unit
Say = Callable[[str, Finding], None]

MAX_ROWS = 10_000
"""Of a table of animals: a larger one holds something else, and would keep every look at a study busy."""
TOO_MANY = error_kind(
    "animals.too-many",
    "{rows} rows, and a study holds {most} at most; {remedy}",
    "name the table of animals, or split it",
)
NO_ANIMALS = error_kind(
    "animals.none",
    "no animals yet; {remedy}",
    "add one row per animal (animal, group, network file, recording file) and put the files into networks/ and "
    "recordings/",
)
UNKNOWN_COLUMN = error_kind(
    "animals.unknown-column", "unknown column{hint}; {remedy}", "give it another name if it is one of your own"
)
RESERVED = error_kind("animals.reserved", "is the name of a column of the tables of results; {remedy}", "rename it")
WRONG_TYPE = error_kind("animals.wrong-type", "{text}; {remedy}", "correct the cell")
COLUMN_TWICE = error_kind("animals.column-twice", "stands twice; {remedy}", "keep one")
NO_SIZE = error_kind(
    "animals.no-size", "'{text}' is beyond any size that this can have; {remedy}", "check its digits and its unit"
)
NO_COLUMN = error_kind(
    "animals.no-column", "no column '{name}'; {remedy}", "add it to the header; its cells may be filled later"
)
EMPTY_CELL = error_kind(
    "animals.empty-cell", "the cell is empty", "Fill it in.", SetCells("Fill the cell", (("{column}", UNKNOWN),))
)
NO_NETWORK = error_kind(
    "animals.no-network",
    "the cell is empty: a study fits a model to the vessels of a lung",
    "Name the file of its vessels. What a recording alone tells needs no study.",
    SetCells("Name its vessels", (("network", UNKNOWN),)),
)
UNKNOWN_GROUP = error_kind(
    "animals.unknown-group",
    "'{group}' is not a group of the study{hint}; {remedy}",
    "write one of its groups ({groups}), or add this one to them",
    NameGroups("{groups},{group}"),
    SetCells("Choose its group", (("group", UNKNOWN),)),
)
OTHER_WORD = error_kind("animals.other-word", "'{text}'{hint}; {remedy}", "write {words}")
IGNORED = look_kind(
    "animals.ignored",
    "has no meaning for an animal of kind '{kind}' and is ignored",
    "Empty the cell, or correct the kind.",
    SetCells("Empty the cell", (("{column}", ""),)),
)
_PUT_THERE = "put the file there, or correct its name"
_FILE = "'{name}' "
IS_FOLDER = error_kind("animals.file-is-folder", f"{_FILE}is a folder; {{remedy}}", "name a file inside it")
IS_DEVICE = error_kind(
    "animals.file-is-device", f"{_FILE}is a pipe or a device; {{remedy}}", "copy what it gives into a file"
)
NO_FOLDER = error_kind("animals.no-folder", f"{_FILE}does not exist, nor does its folder; {{remedy}}", _PUT_THERE)
NO_FILE = error_kind("animals.no-file", f"{_FILE}does not exist{{hint}}; {{remedy}}", _PUT_THERE)
NO_FILE_NAME = error_kind(
    "animals.no-file-name", f"{_FILE}is not a name of a file ({{why}}); {{remedy}}", "correct the name"
)
_NO_NUMBER = "'{text}' is not a number; {remedy}"
NO_NUMBER = error_kind("animals.no-number", _NO_NUMBER, "write one without its unit, or empty the cell")
DECIMAL_COMMA = error_kind("animals.decimal-comma", _NO_NUMBER, "write a decimal point instead of a comma")
NO_GAIN = error_kind(
    "animals.no-gain", "a gain of 0 leaves no flow; {remedy}", "leave the cell empty if it is not known"
)
NO_FREQUENCY = error_kind(
    "animals.no-frequency", "a damping needs its natural frequency in the column `{signal} cutoff [Hz]`; {remedy}",
    "fill that column, or leave this one empty",
)  # fmt: skip
NOT_POSITIVE = error_kind(
    "animals.not-positive", "{text} is not a positive {what}; {remedy}", "correct it, or empty the cell"
)
ANIMAL_TWICE = error_kind(
    "animals.twice",
    "'{name}' stands in line {other} already; {remedy}",
    "rename one; where one animal was measured twice, say so in a column of your own, and name that as the design's "
    "subject",
)
SMALL_GROUP = look_kind(
    "animals.small-group",
    "group '{group}' has one animal; a comparison needs two or more",
    "Add animals to the group.",
)

_WITHOUT_GROUP = SetSetting("Groups {remaining}", "groups", "[{remaining}]")
EMPTY_GROUP = look_kind(
    "animals.empty-group",
    "group '{group}' has no animal",
    "Add animals to the group, or take it out of the groups.",
    _WITHOUT_GROUP,
)
GROUP_SLIP = look_kind(
    "animals.group-slip",
    "'{group}' in {animal} alone, '{common}' in {count}: did you mean '{common}'?",
    "If it is a slip, correct the cell and the groups of the study.",
    SetCells("It is {common}", (("group", "{common}"),)),
    _WITHOUT_GROUP,
)


def read_animals(
    path: Path, groups: Sequence[str] | None, subject: str = ""
) -> tuple[list[AnimalRow], list[StudyProblem]]:
    """Return the animals whose rows are understood, and everything that is wrong or odd in the table.

    Parameters
    ----------
    path : Path
        CSV. File names in it are relative to its folder.
    groups : sequence of str or None
        The labels that are known; None if they are not.
    subject : str
        The column that says which rows are of one animal, where there is one.
    """
    try:
        table = read_columns(path)
    except NoRowsError:
        return [], [StudyProblem(NO_ANIMALS().at(str(path)))]
    except InputError as error:
        return [], [unreadable(error)]
    if len(table.cells) > MAX_ROWS:
        return [], [StudyProblem(TOO_MANY(rows=len(table.cells), most=MAX_ROWS).at(str(path)))]
    titles = [f"{name} [{unit}]" if unit else name for name, unit in zip(table.names, table.units, strict=True)]
    where, lab_columns, problems = columns_of(path, titles)
    problems += [StudyProblem(suspicion.at(str(path))) for suspicion in table.suspicions]
    if any(problem.error for problem in problems):
        return [], problems
    rows = []
    for index in range(len(table.cells)):
        row, wrong = _row(table, index, where, lab_columns, groups)
        problems += wrong
        if row is not None:
            rows.append(row)
    problems += [*_duplicates(path, rows), *_slips(path, rows, subject)]
    complete = not any(problem.error for problem in problems)
    return rows, problems + (_group_sizes(path, rows, groups or ()) if complete else [])


def variables_of(rows: Sequence[AnimalRow]) -> tuple[Variable, ...]:
    """Return the columns that are the lab's own.

    Raises
    ------
    InputError
        A column of numbers or dates holds something else.
    """
    titles = dict.fromkeys(title for row in rows for title in row.lab_cells)
    return tuple(
        Variable.from_cells(title, {row.animal: row.lab_cells.get(title, "") for row in rows}) for title in titles
    )


def _slips(path: Path, rows: Sequence[AnimalRow], subject: str) -> list[StudyProblem]:
    """Return what is wrong or looks like a slip in the columns that are the lab's own."""
    problems, groups = [], {row.animal: row.group for row in rows}
    subjects = {row.animal: row.lab_cells.get(subject, "") for row in rows}
    for title in dict.fromkeys(title for row in rows for title in row.lab_cells):
        if title in SHARED_SOURCES:  # animals that share nothing are no slip
            continue
        try:
            variable = Variable.from_cells(title, {row.animal: row.lab_cells.get(title, "") for row in rows})
            findings = variable.slips(groups, {} if title == subject else subjects)
        except InputError as error:
            findings = [WRONG_TYPE(text=str(error))]
        if title == subject:  # their names are alike, and one that stands once has one recording
            findings = [slip for slip in findings if slip.code not in (MISSPELT.code, ALONE.code)]
        problems += [_placed(slip.at(str(path), part=f"column '{title}'"), title, rows) for slip in findings]
    return problems


def _placed(slip: Finding, title: str, rows: Sequence[AnimalRow]) -> StudyProblem:
    """Return a slip with the lines of the rows that hold its word, if it is about one, or that hold none."""
    values = dict(slip.values)
    word = "" if slip.code == GAPS.code else values.get("rare", values.get("value"))
    is_of_rows = slip.code == GAPS.code or slip.place.animal
    lines = [row.line for row in rows if is_of_rows and row.lab_cells.get(title, "") == word]
    first, *further_lines = lines or [0]
    return StudyProblem(slip.at(line=first, animal=""), same=tuple(further_lines))


def columns_of(path: Path, titles: list[str]) -> tuple[dict[str, int], dict[str, int], list[StudyProblem]]:
    """Return where each known column stands, and each that is the lab's own."""
    standard_titles = {title.lower(): title for title in COLUMNS}
    plainly = {split_unit(title)[0].lower(): title for title in COLUMNS}
    where: dict[str, int] = {}
    lab_columns: dict[str, int] = {}
    problems = list[Finding]()
    for i, title in enumerate(titles):
        plain, location = title.lower(), f"header, column '{title}'"
        if plain not in standard_titles:
            name = split_unit(title)[0]
            meant = understood_title(*split_unit(title))
            matches = get_close_matches(name.lower(), plainly, n=1, cutoff=_MIN_TITLE_SIMILARITY)
            if meant or matches:
                hint = f" (did you mean '{meant.column if meant else plainly[matches[0]]}'?)"
                problems.append(UNKNOWN_COLUMN(hint=hint).at(str(path), part=location))
            elif name.lower() in (*TIDY_COLUMNS, "source") or not name:
                problems.append(RESERVED().at(str(path), part=location))
            elif plain in map(str.lower, lab_columns):
                problems.append(COLUMN_TWICE().at(str(path), part=location))
            else:
                lab_columns[title] = i
        elif standard_titles[plain] in where:
            problems.append(COLUMN_TWICE().at(str(path), part=location))
        else:
            where[standard_titles[plain]] = i
    problems += [NO_COLUMN(name=name).at(str(path), part="header") for name in REQUIRED_COLUMNS if name not in where]
    return where, lab_columns, list(map(StudyProblem, problems))


def _row(
    table: Columns, index: int, where: dict[str, int], lab_columns: dict[str, int], groups: Sequence[str] | None
) -> tuple[AnimalRow | None, list[StudyProblem]]:
    line = table.lines[index]
    cell = dict.fromkeys(COLUMNS, "") | {title: table.cells[index][i].strip() for title, i in where.items()}

    def place(title: str) -> Place:
        return Place(table.source, line, f"column '{title}'")

    row, wrong = read_row(cell, Path(table.source).parent, groups, place, line)
    carried = lab_columns | {title: i for title, i in where.items() if COLUMNS[title].is_covariate}
    further = {title: unicodedata.normalize("NFC", table.cells[index][i].strip()) for title, i in carried.items()}
    return row and replace(row, lab_cells=further), wrong


def read_row(
    cells: Mapping[str, str], folder: Path, groups: Sequence[str] | None, place: Callable[[str], Place], line: int = 0
) -> tuple[AnimalRow | None, list[StudyProblem]]:
    """Return one animal from the text of its cells, None if they hold an error, and everything wrong or odd.

    Parameters
    ----------
    cells : mapping of str to str
        Cells by the titles of `COLUMNS`.
    folder : Path
        Where the names of files begin.
    groups : sequence of str or None
        The labels that are known; None if they are not.
    place : callable
        Returns the place of the cell of a column.
    line : int
        Of the table.
    """
    cell = dict.fromkeys(COLUMNS, "") | dict(cells)
    cell |= {title: unicodedata.normalize("NFC", cell[title]) for title in ("animal", "group")}
    wrong: list[StudyProblem] = []

    def note(title: str, finding: Finding) -> None:
        wrong.append(StudyProblem(finding.placed(place(title)), also=(cell["animal"],)))

    kind = cell["kind"].lower() or _implied_kind(cell)
    _check_words(cell, kind, groups, note)
    files = _files(cell, folder, note)
    numbers: dict[str, Any] = {field: _number(cell[title], title, note) for title, field in NUMBERS.items()}
    if any(problem.error for problem in wrong):
        return None, wrong
    texts: dict[str, Any] = {
        field_of(title): cell[title]
        for title in COLUMNS
        if title.endswith((" unit", " channel")) or title in ("sheet", "subject row", "site")
    }
    further_files: dict[str, Any] = {
        field_of(title): folder / cell[title] if cell[title] else None for title in _further_files()
    }
    block, after = numbers.pop("block"), numbers.pop("zero_after")
    known_errors = {name: value for name in ERRORS.values() if (value := numbers.pop(name)) is not None}
    if after is not None:
        drift = after - (numbers["zero"] or 0.0)
        numbers["zero"] = (numbers["zero"] or 0.0) + drift / 2
        known_errors.setdefault("zero_sd", abs(drift) / math.sqrt(12))
    for signal in ("pressure", "flow"):
        if numbers[f"{signal}_damping"] and not numbers[f"{signal}_cutoff"]:
            note(f"{signal} damping [1]", NO_FREQUENCY(signal=signal))
            return None, wrong
    title = "animal"
    try:
        KnownErrors(**known_errors)
        title = "hematocrit [1]"
        relative_to_usual(numbers["hematocrit"])
        title = "temperature [°C]"
        relative_to_usual(None, numbers["temperature"])
    except InputError as error:
        note(title, UNREADABLE(text=str(error)))
        return None, wrong
    row = AnimalRow(
        cell["animal"], cell["group"], files[0], tuple(files[1:]), line, cast(Literal["", "cycle", "raw"], kind),
        synthetic=cell["synthetic"].lower() == "yes", shared_recording=cell["shared recording"].lower() == "yes",
        block=None if block is None else int(block), errors=known_errors, **further_files, **texts, **numbers,
    )  # fmt: skip
    return row, wrong


def read_half_row(
    cells: Mapping[str, str], folder: Path, groups: Sequence[str]
) -> tuple[AnimalRow | None, list[StudyProblem]]:
    """Return `read_row` of a row whose network and group may still be empty: what its recording tells needs neither."""
    filled = {**cells, "network": cells.get("recording", ""), "group": groups[0]}
    return read_row(filled, folder, None, lambda _: NOWHERE)


def _implied_kind(cell: Mapping[str, str]) -> str:
    """Return the kind of recording that the other columns speak of, empty if they speak of none."""
    kinds = {column.scope for title, column in COLUMNS.items() if cell[title]}
    return next((kind for kind in ("cycle", "raw") if kind in kinds), "")


def _check_words(cell: Mapping[str, str], kind: str, groups: Sequence[str] | None, report: Say) -> None:
    for title in REQUIRED_COLUMNS:
        if not cell[title]:
            report(title, NO_NETWORK() if title == "network" else EMPTY_CELL(column=title))
    try:
        checked_name(cell["animal"] or "empty")
    except InputError as error:
        report("animal", UNREADABLE(text=str(error)))
    if cell["group"] and groups is not None and cell["group"] not in groups:
        hint = did_you_mean(cell["group"], groups)
        report("group", UNKNOWN_GROUP(group=cell["group"], hint=hint, groups=", ".join(groups)))
    if kind not in ("", "cycle", "raw"):
        hint = did_you_mean(kind, ("cycle", "raw"))
        report("kind", OTHER_WORD(text=cell["kind"], hint=hint, words="cycle or raw"))
    if cell["site"] and cell["site"] not in (PULMONARY, *SITES):
        hint = did_you_mean(cell["site"], (PULMONARY, *SITES))
        report("site", OTHER_WORD(text=cell["site"], hint=hint, words=", ".join((PULMONARY, *SITES))))
    for title in ("synthetic", "shared recording"):
        if cell[title].lower() not in ("", "no", "yes"):
            report(title, OTHER_WORD(text=cell[title], hint="", words="yes or no"))
    ignored_kind = {"raw": "cycle", "cycle": "raw"}.get(kind)
    for title, column in COLUMNS.items():
        if cell[title] and column.scope == ignored_kind:
            report(title, IGNORED(kind=kind, column=title))
    for title, quantity in (("pressure unit", "pressure"), ("flow unit", "flow"), ("volume unit", "volume")):
        try:
            if cell[title]:
                velocity = quantity == "flow" and cell["flow diameter [mm]"]
                units.factor(cell[title], "velocity" if velocity else quantity)
        except InputError as error:
            report(title, UNREADABLE(text=str(error)))


def _further_files() -> list[str]:
    """Return the columns of files beside those of vessels and recording."""
    return [title for title in FILES if title not in ("network", "recording", "flow")]


def _files(cell: Mapping[str, str], folder: Path, report: Say) -> list[Path]:
    """Return the files of the network and of the recording."""
    titles = ["network", "recording", "flow"] if cell["flow"] else ["network", "recording"]
    files = [folder / cell[title] for title in titles]
    for title in [*titles, *_further_files()]:
        file = folder / cell[title]
        try:
            if cell[title] and not file.is_file():
                report(title, _missing(file, cell[title]))
        except (OSError, ValueError) as error:
            report(title, NO_FILE_NAME(name=cell[title], why=str(error)))
    return files


def _number(text: str, title: str, report: Say) -> float | None:
    if not text:
        return None
    try:
        value = number(text)
    except ValueError:
        report(title, (DECIMAL_COMMA if re.fullmatch(r"-?\d+,\d+", text) else NO_NUMBER)(text=text))
        return None
    if not (math.isfinite(value) and value >= COLUMNS[title].minimum) or (title == "block" and value != int(value)):
        report(title, NOT_POSITIVE(text=text, what="whole number" if title == "block" else "number"))
        return None
    if value and not _MIN_CELL_VALUE < abs(value) < _MAX_CELL_VALUE:
        report(title, NO_SIZE(text=text))
        return None
    if title == "flow gain [1]" and value == 0:
        report(title, NO_GAIN())
        return None
    return value


def _missing(file: Path, name: str) -> Finding:
    if file.is_dir():
        return IS_FOLDER(name=name)
    if file.exists():
        return IS_DEVICE(name=name)
    if not file.parent.is_dir():
        return NO_FOLDER(name=name)
    return NO_FILE(name=name, hint=did_you_mean(file.name, [sibling.name for sibling in file.parent.iterdir()]))


def _duplicates(path: Path, rows: Sequence[AnimalRow]) -> list[StudyProblem]:
    duplicates = []
    first: dict[str, AnimalRow] = {}
    for row in rows:
        earlier = first.setdefault(row.animal.casefold(), row)
        if earlier is not row:
            twice = ANIMAL_TWICE(name=row.animal, other=earlier.line)
            duplicates.append(StudyProblem(twice.at(str(path), line=row.line, part="column 'animal'")))
    return duplicates


def _likely_group(label: str, sizes: Mapping[str, int]) -> str:
    """Return the group that is meant perhaps by one of a row, or of two where the other has three times as many or
    the same letters in another order."""
    count = sizes[label]
    if count > 2:
        return ""
    enough = 2 if count == 1 else 3 * count
    is_swapped = {group: sorted(group.casefold()) == sorted(label.casefold()) for group in sizes if group != label}
    return likely_word(label, [group for group, swapped in is_swapped.items() if swapped or sizes[group] >= enough])


def _group_sizes(path: Path, rows: Sequence[AnimalRow], groups: Sequence[str]) -> list[StudyProblem]:
    sizes = Counter(row.group for row in rows)
    problems = []
    for label in groups:
        remaining = ", ".join(group for group in groups if group != label)
        rows_of_group = [row for row in rows if row.group == label]
        if not rows_of_group:
            problems.append(StudyProblem(EMPTY_GROUP(group=label, remaining=remaining).at(str(path))))
        elif common := _likely_group(label, sizes):
            names = tuple(row.animal for row in rows_of_group)
            finding = GROUP_SLIP(
                group=label, animal=" and ".join(names), common=common, count=sizes[common], remaining=remaining
            ).at(str(path), line=rows_of_group[0].line, part="column 'group'")
            problems.append(StudyProblem(finding, also=names))
        elif len(rows_of_group) == 1:
            problems.append(StudyProblem(SMALL_GROUP(group=label).at(str(path))))
    return problems
