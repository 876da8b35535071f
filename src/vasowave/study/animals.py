"""The table of animals: who belongs to which group, and which files hold what is known of it."""

import math
import re
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, cast

from vasowave import units
from vasowave.columns import Columns, read_columns
from vasowave.errors import InputError, did_you_mean
from vasowave.study.names import checked_name
from vasowave.study.problems import Problem
from vasowave.study.rows import COLUMNS, NEEDED, AnimalRow

_NUMBERS = {
    "image pressure [mmHg]": "image_pressure",
    "period [s]": "period",
    "block": "block",
    "start [s]": "start",
    "end [s]": "end",
    "sampling rate [1/s]": "sampling_rate",
    "R_T [mmHg s/ml]": "R_T",
    "C_T [ml/mmHg]": "C_T",
    "tau [s]": "tau",
}
_RAW_ONLY = ("pressure channel", "flow channel", "ecg channel", "block", "start [s]", "end [s]", "sampling rate [1/s]")
_CYCLE_ONLY = ("flow", "period [s]")
Say = Callable[..., None]


def read_animals(path: Path, groups: Sequence[str] | None) -> tuple[list[AnimalRow], list[Problem]]:
    """Return the animals whose rows are understood, and everything that is wrong or odd in the table.

    Parameters
    ----------
    path : Path
        CSV. File names in it are relative to its folder.
    groups : sequence of str or None
        The labels that are known; None if they are not.
    """
    try:
        table = read_columns(path)
    except InputError as error:
        return [], [_unreadable(path, str(error))]
    titles = [f"{name} [{unit}]" if unit else name for name, unit in zip(table.names, table.units, strict=True)]
    where, problems = _columns(path, titles)
    problems += [Problem(str(path), suspicion, False) for suspicion in table.suspicions]
    if any(problem.error for problem in problems):
        return [], problems
    rows = []
    for number in range(len(table.cells)):
        row, wrong = _row(table, number, where, groups)
        problems += wrong
        if row is not None:
            rows.append(row)
    problems += _duplicates(path, rows)
    complete = not any(problem.error for problem in problems)
    return rows, problems + (_group_sizes(path, rows, groups or ()) if complete else [])


def _unreadable(path: Path, message: str) -> Problem:
    if "and no data" in message:
        return Problem(
            str(path),
            "no animals yet; add one row per animal (animal, group, network file, recording file) and put the files "
            "into networks/ and recordings/",
        )
    place, _, rest = message.partition(": ")
    return Problem(place, rest) if rest else Problem(str(path), message)


def _columns(path: Path, titles: list[str]) -> tuple[dict[str, int], list[Problem]]:
    """Return where each known column stands."""
    known = {title.lower(): title for title in COLUMNS}
    where: dict[str, int] = {}
    problems = []
    for i, title in enumerate(titles):
        plain = title.lower()
        if plain not in known:
            hint = did_you_mean(plain, known)
            problems.append(
                Problem(f"{path}, header, column '{title}'", f"unknown column{hint}; known: {', '.join(COLUMNS)}")
            )
        elif known[plain] in where:
            problems.append(Problem(f"{path}, header, column '{title}'", "stands twice; keep one"))
        else:
            where[known[plain]] = i
    problems += [Problem(f"{path}, header", f"no column '{name}'") for name in NEEDED if name not in where]
    return where, problems


def _row(
    table: Columns, number: int, where: dict[str, int], groups: Sequence[str] | None
) -> tuple[AnimalRow | None, list[Problem]]:
    line = table.lines[number]
    cell = dict.fromkeys(COLUMNS, "") | {title: table.cells[number][i].strip() for title, i in where.items()}
    place = f"{table.source}, line {line}, column '{{}}'".format
    return read_row(cell, Path(table.source).parent, groups, place, line)


def read_row(
    given: Mapping[str, str], folder: Path, groups: Sequence[str] | None, place: Callable[[str], str], line: int = 0
) -> tuple[AnimalRow | None, list[Problem]]:
    """Return one animal from the text of its cells, None if they hold an error, and everything wrong or odd.

    Parameters
    ----------
    given : mapping of str to str
        Cells by the titles of `COLUMNS`.
    folder : Path
        Where the names of files begin.
    groups : sequence of str or None
        The labels that are known; None if they are not.
    place : callable
        Returns the words that lead to the cell of a column.
    line : int
        Of the table.
    """
    cell = dict.fromkeys(COLUMNS, "") | dict(given)
    cell |= {title: unicodedata.normalize("NFC", cell[title]) for title in ("animal", "group")}
    wrong: list[Problem] = []

    def say(title: str, message: str, error: bool = True) -> None:
        wrong.append(Problem(place(title), message, error))

    kind = cell["kind"].lower() or _implied_kind(cell)
    _check_words(cell, kind, groups, say)
    files = _files(cell, kind, folder, say)
    numbers: dict[str, Any] = {field: _number(cell[title], title, say) for title, field in _NUMBERS.items()}
    if any(problem.error for problem in wrong):
        return None, wrong
    texts: dict[str, Any] = {t.replace(" ", "_"): cell[t] for t in COLUMNS if t.endswith((" unit", " channel"))}
    block = numbers.pop("block")
    row = AnimalRow(
        cell["animal"], cell["group"], files[0], tuple(files[1:]), line, cast(Literal["", "cycle", "raw"], kind),
        synthetic=cell["synthetic"].lower() == "yes", shared_recording=cell["shared recording"].lower() == "yes",
        block=None if block is None else int(block), **texts, **numbers,
    )  # fmt: skip
    return row, wrong


def _implied_kind(cell: Mapping[str, str]) -> str:
    """Return the kind of recording that the other columns speak of, empty if they speak of none."""
    if any(cell[title] for title in _CYCLE_ONLY):
        return "cycle"
    return "raw" if any(cell[title] for title in _RAW_ONLY) else ""


def _check_words(cell: Mapping[str, str], kind: str, groups: Sequence[str] | None, say: Say) -> None:
    for title in NEEDED:
        if not cell[title]:
            say(title, "the cell is empty")
    try:
        checked_name(cell["animal"] or "empty")
    except InputError as error:
        say("animal", str(error))
    if cell["group"] and groups is not None and cell["group"] not in groups:
        hint = did_you_mean(cell["group"], groups)
        say("group", f"'{cell['group']}' is not a group of the study{hint}; its groups: {', '.join(groups)}")
    if kind not in ("", "cycle", "raw"):
        say("kind", f"'{cell['kind']}'{did_you_mean(kind, ('cycle', 'raw'))}; write cycle or raw")
    for title in ("synthetic", "shared recording"):
        if cell[title].lower() not in ("", "no", "yes"):
            say(title, f"'{cell[title]}'; write yes or no")
    for title in {"raw": _CYCLE_ONLY, "cycle": _RAW_ONLY}.get(kind, ()):
        if cell[title]:
            say(title, f"has no meaning for an animal of kind '{kind}' and is ignored", False)
    for title, quantity in (("pressure unit", "pressure"), ("flow unit", "flow")):
        try:
            if cell[title]:
                units.factor(cell[title], quantity)
        except InputError as error:
            say(title, str(error))


def _files(cell: Mapping[str, str], kind: str, folder: Path, say: Say) -> list[Path]:
    """Return the files of the network and of the recording."""
    titles = ["network", "recording", "flow"] if cell["flow"] and kind == "cycle" else ["network", "recording"]
    files = [folder / cell[title] for title in titles]
    for title, file in zip(titles, files, strict=True):
        try:
            if cell[title] and not file.is_file():
                say(title, f"'{cell[title]}' {_missing(file)}")
        except (OSError, ValueError) as error:
            say(title, f"'{cell[title]}' is no name of a file ({error})")
    return files


def _number(text: str, title: str, say: Say) -> float | None:
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        comma = "; write a decimal point instead of a comma" if re.fullmatch(r"-?\d+,\d+", text) else ""
        say(title, f"'{text}' is not a number{comma}")
        return None
    lowest = 0.0 if title == "start [s]" else 5e-324
    if not (math.isfinite(value) and value >= lowest) or (title == "block" and value != int(value)):
        say(title, f"{text} is not a positive {'whole ' if title == 'block' else ''}number")
        return None
    return value


def _missing(file: Path) -> str:
    if file.is_dir():
        return "is a folder"
    if file.exists():
        return "is a pipe or a device; copy what it gives into a file"
    if not file.parent.is_dir():
        return "does not exist, nor does its folder"
    hint = did_you_mean(file.name, [beside.name for beside in file.parent.iterdir()])
    return f"does not exist{hint}"


def _duplicates(path: Path, rows: Sequence[AnimalRow]) -> list[Problem]:
    duplicates = []
    first: dict[str, AnimalRow] = {}
    for row in rows:
        other = first.setdefault(row.animal.casefold(), row)
        if other is not row:
            place = f"{path}, line {row.line}, column 'animal'"
            duplicates.append(Problem(place, f"'{row.animal}' stands in line {other.line} already; rename one"))
    return duplicates


def _group_sizes(path: Path, rows: Sequence[AnimalRow], groups: Sequence[str]) -> list[Problem]:
    problems = []
    for label in groups:
        size = sum(row.group == label for row in rows)
        if size < 2:
            many = "no animal" if size == 0 else "one animal"
            problems.append(Problem(str(path), f"group '{label}' has {many}; a comparison needs two or more", False))
    return problems
