"""What the shell says of findings and errors: below each, the commands that mend it."""

import os
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from vasowave.base.cures import (
    FLOW_GAIN,
    FLOW_ZERO,
    UNKNOWN,
    Cure,
    NameGroups,
    RemoveAnimal,
    RunAgain,
    SetCells,
    SetOption,
    SetSetting,
    ShiftFlowZero,
    Tidy,
    TrustPrograms,
    TurnFlow,
    Visit,
    field_of,
    in_row,
)
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, Severity, sentence
from vasowave.cli.signatures import OPTIONS, TYPED, VERBOSE
from vasowave.study import entering
from vasowave.study import folder as folders
from vasowave.study import report as reports

_MAX_COMMANDS = 3  # below a finding
_MAX_NAMES = 3  # of animals in a line
_MAX_FILES = 12  # in a command
_PLACES = "sheet", "subject row", "pressure channel"  # which tell a recording from others of its file
VALUE = "VALUE"
"""Stands in a command for what only a person knows."""


@dataclass(frozen=True)
class Shell:
    """What commands are typed about: a study, or single files where there is none.

    Attributes
    ----------
    study : Path or None
    rows : mapping
        Cells of the table of animals, by animal.
    """

    study: Path | None = None
    rows: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    def below(self, cures: Iterable[Cure], animals: Sequence[str] = ()) -> str:
        """Return the lines of the commands that mend a finding about some animals, each begun anew; may be empty."""
        cures = tuple(cures)
        further = [(cure, names) for cure in cures if (names := self._left_out(cure, animals))]
        commands = dict.fromkeys(filter(_typable, (self.command(cure, animals) for cure in cures)))
        commands |= dict.fromkeys(self.command(cure, names) for cure, names in further)
        return "".join(f"\n    {command}" for command in list(commands)[:_MAX_COMMANDS])

    def command(self, cure: Cure, animals: Sequence[str] = ()) -> str:
        """Return one cure as a command; as what to write into a file where no command does it."""
        animal = animals[0] if animals else ""
        row, study = self.rows.get(animal, {}), shlex.quote(str(self.study or "STUDY"))
        if self.study is None and isinstance(cure, ShiftFlowZero | TurnFlow):
            if (typed := _typed_cells()) is None:
                return ""
            row = typed
        match in_row(cure, row):
            case SetCells(_, cells):
                options = _options_of_add(cells, row)
                if not options and self.study is None:
                    return ""
                if not options:
                    texts = [f"{title}={text.replace(UNKNOWN, VALUE)}" for title, text in cells]
                    of_animals = [f"--animal {shlex.quote(name)}" for name in animals]
                    return " ".join(
                        ["vasowave set", study, *map(shlex.quote, texts), *(of_animals or ["--animal NAME"])]
                    )
                if self.study is None:
                    return " ".join(options)
                files = [_typed_path(self.study / file) for file in self._files(cure, animals)]
                rows_of_file = [
                    other_row for other_row in self.rows.values() if other_row.get("recording") == row.get("recording")
                ]
                titles = _PLACES[: 2 + (len(rows_of_file) > 1)]
                places = [title for title in titles if row.get(title) and title not in dict(cells)]
                options += [_option(title, row[title]) for title in places]  # without which another row is meant
                return " ".join(["vasowave add", study, *(files or ["FILE"]), *options])
            case SetSetting(_, key, text):
                text = text.replace(UNKNOWN, VALUE)
                if self.study is not None:
                    return f"vasowave set {study} {shlex.quote(f'{key}={text}')}"
                if key.startswith("design."):  # of groups, which one recording has none of
                    return ""
                if text in ("true", "false"):
                    return f"--{'' if text == 'true' else 'no-'}{_hyphened(key.rpartition('.')[2])}"
                return f"--{_hyphened(key.rpartition('.')[2])}={shlex.quote(text.strip('[]').replace(' ', ''))}"
            case SetOption(_, "unit", text):  # of lengths: another --unit is that of pressure and flow
                return f"vasowave tidy FILE --unit={text.replace(UNKNOWN, VALUE)} -o network.csv"
            case SetOption(_, name, text):
                return f"--{_hyphened(name)}={text.replace(UNKNOWN, VALUE)}"
            case Visit():
                return f"vasowave open {study if self.study is not None else 'FILE'}"
            case RemoveAnimal():
                return f"vasowave set {study} --animal {shlex.quote(animal) if animal else 'NAME'} --remove"
            case NameGroups(groups):
                names = shlex.quote(groups.replace(", ", ",")) if groups != UNKNOWN else "REFERENCE,OTHER"
                return f"vasowave add {study} FILES --groups {names}"
            case Tidy("centerlines"):
                return "vasowave centerlines FILE --unit mm -o FOLDER"
            case Tidy():
                return "vasowave tidy FILE -o network.csv"
            case TrustPrograms():
                return f"vasowave check {study} --trust" if self.study is not None else "--trust"
            case RunAgain():
                return f"vasowave run {study}"
        return ""

    def _together(self, cure: Cure, animals: Sequence[str]) -> list[str]:
        """Return the first animal, and others that the same cells mend and that have files alone."""
        alone = [name for name in animals[:_MAX_FILES] if not any(map(self._row(name).get, _PLACES))]
        first = in_row(cure, self._row(animals[0])) if animals else None
        alike = [name for name in alone if in_row(cure, self._row(name)) == first]
        return [*dict.fromkeys((*animals[:1], *(alike if alone[:1] == [*animals[:1]] else [])))]

    def _left_out(self, cure: Cure, animals: Sequence[str]) -> list[str]:
        """Return the animals of which the command of cells that `add` writes says nothing."""
        row = self._row(animals[0]) if animals else {}
        match in_row(cure, row):
            case SetCells(_, cells) if self.study is not None and _options_of_add(cells, row):
                together = self._together(cure, animals)
                return [name for name in animals if name not in together and self._row(name)]
        return []

    def _files(self, cure: Cure, animals: Sequence[str]) -> list[str]:
        """Return the files of the animals that a cure mends together."""
        rows = [self._row(name) for name in self._together(cure, animals)]
        return [*dict.fromkeys(row[title] for row in rows for title in ("recording", "flow") if row.get(title))]

    def _row(self, animal: str) -> Mapping[str, str]:
        return self.rows.get(animal, {})


def _options_of_add(cells: Iterable[tuple[str, str]], row: Mapping[str, str]) -> list[str]:
    """Return the options of `add` that write cells of a row; none where it does not write all of them."""
    settled = {"group"} if row.get("group") else set()  # which adding does not change
    options = ["" if title in settled else _option(title, text) for title, text in cells]
    adds_row = row and "sheet" in dict(cells)  # adding another sheet does
    return options if all(options) and not adds_row else []


def _typable(command: str) -> bool:
    """Whether there is a command and, where it is options to add, the command that runs has them."""
    options = {word.partition("=")[0] for word in command.split() if word.startswith("--")}
    return bool(command) and (not command.startswith("--") or options <= (OPTIONS.get() or options))


def _typed_path(path: Path) -> str:
    """Return a path as it is typed: ``lab/a.txt`` for ``study/../lab/a.txt``, unless a link leads elsewhere."""
    plain = Path(os.path.normpath(path))
    return shlex.quote(str(plain if plain.resolve() == path.resolve() else path))


def _typed_cells() -> dict[str, str] | None:
    """Return zero and gain of the flow as they were typed; None of a command that has no such options."""
    options = TYPED.get()
    if options is None:
        return None
    return {title: str(options.get(field_of(title), "")) for title in (FLOW_ZERO, FLOW_GAIN)}


def _option(title: str, text: str) -> str:
    """Return the option that writes a cell; empty where none does."""
    from vasowave.cli.options import CELLS, CELLS_OF

    typed = VALUE if text == UNKNOWN else shlex.quote(text)
    signal, _, option = title.rpartition(" ")
    if option in CELLS_OF and signal:
        return f"--{option} {signal}={typed}"
    return f"--{_hyphened(field_of(title))}={typed}" if text and title in (*CELLS, "group", "network") else ""


def _hyphened(name: str) -> str:
    return name.replace("_", "-")


def shell_of(study: Path) -> Shell:
    """Return what commands about a study are typed about."""
    path = folders.study_path(study)
    try:
        settings = folders.read_settings(path)[0]
        rows = entering.read_rows(path.parent / settings.animals).rows if settings is not None else ()
    except InputError:  # which the check itself says
        rows = ()
    return Shell(path.parent, {row.get("animal", ""): row for row in rows})


def problem_lines(problems: "Iterable[folders.StudyProblem]", shell: Shell) -> list[str]:
    """Return problems of a study with the commands that mend them; what many animals have, of the first of them.

    Where the user asked for details (-v), each is by itself.
    """
    groups = [[problem] for problem in problems] if VERBOSE.get() else folders.by_kind(problems)
    return [_problem_line(group, shell) for group in groups]


def _problem_line(group: "Sequence[folders.StudyProblem]", shell: Shell) -> str:
    first = group[0]
    grade = {Severity.NOTE: "note", Severity.LOOK: "warning"}.get(first.finding.severity, "error")
    names = list(dict.fromkeys(name for problem in group for name in problem.animals))
    text = str(first)
    if len(group) > 1:
        place = f"{first.place.file}: " if first.place.file else ""
        noun = "recordings" if any(row.get("subject") for row in shell.rows.values()) else "animals"
        animals = f"{len(names)} {noun} ({reports.some_of(names, _MAX_NAMES)})"
        text = f"{place}{animals}, of the first: {sentence(first.finding)}"
    return f"{grade}: {text}{code_of(first.finding)}{shell.below(first.finding.cures, first.animals)}"


def code_of(finding: Finding) -> str:
    """Return the code of a finding where the user asked for details (-v), else nothing."""
    return f" [{finding.code}]" if VERBOSE.get() else ""
