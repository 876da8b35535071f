"""What is wrong or odd about a study, with the place where a person mends it."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

from vasowave.errors import InputError
from vasowave.findings import Finding

_ROW = re.compile(r", line (\d+)(?: \('.*'\))?")


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong or odd.

    Attributes
    ----------
    place : str
        ``study.yaml, line 12, column 3`` or ``animals.csv, line 4, column 'group'``.
    message : str or Finding
        What is wrong and what to do.
    error : bool
        True if the study cannot run like this, False if it is only odd.
    file : str
        The file that the message speaks of, where that is not the place.
    """

    place: str
    message: str | Finding
    error: bool = True
    file: str = ""

    def __str__(self) -> str:
        return ": ".join(part for part in (self.place, self.file, str(self.message)) if part)


def one_per_cause(problems: Iterable[Problem]) -> list[Problem]:
    """Return the problems; those that differ in line, animal or file alone are one, at the place of the first."""
    groups: dict[tuple[str, str | Finding, bool], list[Problem]] = {}
    for problem in problems:
        groups.setdefault((_ROW.sub("", problem.place), problem.message, problem.error), []).append(problem)
    return [_joined(group) for group in groups.values()]


def _joined(group: list[Problem]) -> Problem:
    first, rest = group[0], [match[1] for one in group[1:] if (match := _ROW.search(one.place))]
    if len(group) == 1 or not rest:
        return first
    more = "the same in line" + ("s " if len(rest) > 1 else " ") + ", ".join(rest)
    return replace(first, message=f"{first.message} ({more})")


def refuse(problems: Iterable[Problem]) -> None:
    """Raise one `InputError` that lists every error among `problems`."""
    errors = [str(problem) for problem in one_per_cause(problems) if problem.error]
    if len(errors) == 1:
        raise InputError(errors[0])
    if errors:
        raise InputError(f"{len(errors)} errors:\n" + "\n".join(f"  {error}" for error in errors))
