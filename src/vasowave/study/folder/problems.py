"""Problems of a study, with the place where a person mends it."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from vasowave.base.errors import InputError, VasowaveError
from vasowave.base.findings import ITSELF, NOWHERE, OTHER, Finding, Place, Severity, error_kind, sentence
from vasowave.study.report.wording import some_of

_MAX_NAMES = 3  # animals with the same problem, in a sentence

UNREADABLE = error_kind("study.unreadable", "{text}", ITSELF)
"""An error of what reads a file or a word: its text says what to do, and it brings its cures."""


@dataclass(frozen=True)
class StudyProblem:
    """One thing that is wrong or odd.

    Attributes
    ----------
    finding : Finding
        What is wrong and what to do; its place is where a person mends it.
    files : tuple of str
        Files of the animal, which may stand in the text.
    same : tuple of int
        Further lines of the table with the same problem.
    also : tuple of str
        Animals that it concerns beside the one of its place.
    """

    finding: Finding
    files: tuple[str, ...] = ()
    same: tuple[int, ...] = ()
    also: tuple[str, ...] = ()

    @property
    def place(self) -> Place:
        """The place where a person mends it."""
        return self.finding.place

    @property
    def animals(self) -> tuple[str, ...]:
        """The animals that it concerns, none if it concerns all."""
        return tuple(dict.fromkeys(filter(None, (self.place.animal, *self.also))))

    @property
    def error(self) -> bool:
        """True if the study cannot run like this, False if it is only odd."""
        return self.finding.severity is Severity.ERROR

    def __str__(self) -> str:
        names = some_of([*self.animals[1:]], _MAX_NAMES)
        at_lines = f"line{'s' if len(self.same) > 1 else ''} {', '.join(map(str, self.same))}"
        lines = f" (the same in {': '.join(filter(None, (at_lines, names)))})"
        return ": ".join(filter(None, (str(self.place), sentence(self.finding)))) + (lines if self.same else "")


def unreadable(error: VasowaveError, place: Place = NOWHERE, files: Iterable[Path] = ()) -> StudyProblem:
    """Return the problem that an error is."""
    finding = replace(UNREADABLE(text=str(error)), raised_cures=error.cures)
    return StudyProblem(finding.placed(place), tuple(map(str, files)))


def one_per_cause(problems: Iterable[StudyProblem]) -> list[StudyProblem]:
    """Return the problems; those that differ in line, animal or file alone are one, at the place of the first."""
    groups: dict[Finding, list[StudyProblem]] = {}
    for problem in problems:
        cause = problem.finding.at(line=0, animal="")
        for file in problem.files:
            cause = cause.inside(file)
        groups.setdefault(cause, []).append(problem)
    return [_joined(*group) for group in groups.values()]


def by_kind(problems: Iterable[StudyProblem]) -> list[list[StudyProblem]]:
    """Return the problems in groups, errors first: oddities of one kind and remedy that animals have are together.

    An animal stands once in a group: what its pressure and its flow have, or two wall laws, is told apart.
    """
    groups: dict[tuple[object, ...], list[StudyProblem]] = {}
    counts = Counter[tuple[object, ...]]()
    for number, problem in enumerate(sorted(problems, key=lambda problem: not problem.error)):
        finding = problem.finding
        alone = problem.error or not problem.animals or finding.code == OTHER.code
        about = [dict(finding.values).get(name) for name in ("what", "signal", "parameter", "law")]
        kind = (finding.code, finding.remedy, finding.place.law, *about)
        counts[kind, problem.animals] += 1
        groups.setdefault((number,) if alone else (*kind, counts[kind, problem.animals]), []).append(problem)
    return list(groups.values())


def _joined(first: StudyProblem, *duplicates: StudyProblem) -> StudyProblem:
    lines = dict.fromkeys(problem.place.line for problem in duplicates)
    also = (name for problem in (first, *duplicates) for name in problem.animals)
    return replace(first, same=tuple(line for line in lines if line not in (0, first.place.line)), also=tuple(also))


def refuse(problems: Iterable[StudyProblem]) -> None:
    """Raise one `InputError` that lists every error among `problems`."""
    errors = [problem for problem in one_per_cause(problems) if problem.error]
    if len(errors) == 1:
        raise InputError(str(errors[0]), errors[0].finding.cures)
    if errors:
        raise InputError(f"{len(errors)} errors:\n" + "\n".join(f"  {error}" for error in errors))
