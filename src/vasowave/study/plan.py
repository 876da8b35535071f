"""A study as its two files describe it: settings and animals."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from vasowave.cohort.design import Layout, laid_out
from vasowave.cohort.freedom import FEW, degrees_left
from vasowave.cohort.told import untold_findings
from vasowave.cohort.variables import Variable
from vasowave.errors import InputError
from vasowave.findings import Finding, look_kind
from vasowave.settings import AT_ODDS
from vasowave.study.animals import read_animals, variables_of
from vasowave.study.problems import Problem, refuse
from vasowave.study.reading import read_settings, study_path
from vasowave.study.rows import AnimalRow
from vasowave.study.settings import StudyFile
from vasowave.study.subjects import subject_problems

_LEAST_LEFT = 1 / 3  # of the animals
FEW_LEFT = look_kind(
    "design.few-left", "of {animals} animals {left} are left to tell how animals scatter: intervals will be wide, and "
    "what differs may not be shown; {remedy}", "name fewer covariates and blocks, or add animals",
)  # fmt: skip
FEW_DEGREES = look_kind(
    "design.few-degrees", "{effects}: the design leaves {freedom} degrees of freedom at most, so that with {rows} "
    "comparisons an effect is shown only where it is about {times:.2g} times its standard error ({many:.2g} times with "
    "many animals); {remedy}", "name fewer covariates, blocks, quantities or contrasts, or add animals",
)  # fmt: skip
ONE_OCCASION = look_kind(
    "design.one-occasion", "no {subject} was recorded at two levels of {occasion}, so that it is compared between "
    "animals and not within them", "check the two columns, or name {occasion} as factor",
)  # fmt: skip
SAME_OCCASION = look_kind(
    "design.same-occasion", "{subject} {names} has more than one recording at one level of {occasion}: they count as "
    "repeats of it", "check the two columns if that is not meant",
)  # fmt: skip
RESULTS = "results"
"""Folder of the results, beside the study file."""


@dataclass(frozen=True)
class Study:
    """A study that can be run.

    Attributes
    ----------
    path : Path
        The study file.
    settings : StudyFile
    animals : tuple of AnimalRow
    """

    path: Path
    settings: StudyFile
    animals: tuple[AnimalRow, ...]

    @property
    def folder(self) -> Path:
        """The folder of the study file."""
        return self.path.parent

    @property
    def table(self) -> Path:
        """The table of animals."""
        return self.folder / self.settings.animals

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """The columns of the table that are the lab's own, each of one type."""
        return variables_of(self.animals)

    @cached_property
    def layout(self) -> Layout | None:
        """The design applied to the animals, None where groups of independent animals are compared; see `laid_out`."""
        design, members = self.settings.design, {row.animal: row.group for row in self.animals}
        groups = [group for group in self.settings.groups if group in members.values()]
        return None if design.plain else laid_out(design, {one.name: one for one in self.variables}, members, groups)

    @property
    def results(self) -> Path:
        """The folder of the results."""
        return self.folder / RESULTS


def inspect_study(path: Path) -> tuple[Study | None, list[Problem]]:
    """Return the study (None if there are errors) and everything that is wrong or odd in its two files.

    Animals with an error in their row are left out of a study with errors.

    Raises
    ------
    InputError
        There is no study file.
    """
    path = study_path(Path(path))
    settings, document = read_settings(path)
    groups = settings.groups if settings else None
    name = settings.animals if settings else document.values.get("animals") or StudyFile.animals
    rows, wrong = read_animals(path.parent / str(name), groups, (settings.design.subject or "") if settings else "")
    problems = [*document.problems, *wrong]
    if settings is None:
        return None, problems
    study = Study(path, settings, tuple(rows))
    if not any(problem.error for problem in problems):
        place = document.place(("design",), key=True)._asdict()
        try:
            problems += [Problem(found.at(**place)) for found in _odd_in(study)]
        except InputError as error:
            problems.append(Problem(AT_ODDS(text=str(error)).at(**place)))
        problems += subject_problems(study)
    return study, problems


def _odd_in(study: Study) -> Iterator[Finding]:
    """Yield what is odd in the design of a study."""
    layout, design = study.layout, study.settings.design
    if layout is None:
        return
    yield from untold_findings(layout.contrasts, layout.untold)
    left = layout.left_for_scatter(design.blocks)
    if left < _LEAST_LEFT * len(study.animals):
        yield FEW_LEFT(animals=len(layout.animals), left=left)
    yield from _few_degrees(study, layout)
    if design.subject and design.occasion:
        known = {one.name: one for one in study.variables}[design.occasion].levels
        times = Counter(zip(layout.subject, (known[animal] for animal in layout.animals), strict=True))
        if len({subject for subject, _ in times}) == len(times):
            yield ONE_OCCASION(subject=design.subject, occasion=design.occasion)
        if again := sorted({subject for (subject, _), count in times.items() if count > 1}):
            yield SAME_OCCASION(subject=design.subject, occasion=design.occasion, names=", ".join(again))


def _few_degrees(study: Study, layout: Layout) -> Iterator[Finding]:
    """Yield which comparisons few degrees of freedom are left for, and how large effects must then be."""
    from scipy.special import ndtri, stdtrit

    rows = len(study.settings.report.quantities) * len(layout.contrasts)
    left: dict[int, list[str]] = {}
    for contrast in layout.contrasts:
        left.setdefault(degrees_left(layout, study.settings.design.blocks, contrast), []).append(contrast.text)
    for freedom, effects in left.items():
        if freedom < FEW and rows:
            side = 1 - 0.025 / rows  # Bonferroni's bound: the rows are judged together
            times, many = (float(one) for one in (stdtrit(max(freedom, 1), side), ndtri(side)))
            yield FEW_DEGREES(effects="; ".join(effects), freedom=freedom, rows=rows, times=times, many=many)


def read_study(path: Path) -> Study:
    """Read ``study.yaml`` (or the folder that holds it) and its table of animals.

    Raises
    ------
    InputError
        Everything that is wrong in them, at once, with file, line and column.

    Examples
    --------
    >>> import vasowave as vw
    >>> from pathlib import Path
    >>> mouse = vw.virtual_mouse()
    >>> rows = (f"{t:.6f},{p:.6f},{q:.6f}" for t, p, q in zip(mouse.time, mouse.pressure, mouse.flow))
    >>> _ = Path("cycle.csv").write_text("\\n".join(["time [s],pressure [mmHg],flow [ml/s]", *rows, ""]))
    >>> vw.write_network(vw.control_network(), "lung.csv")
    >>> _ = Path("animals.csv").write_text("animal,group,network,recording\\nmouse 6,CTL,lung.csv,cycle.csv\\n")
    >>> _ = Path("study.yaml").write_text("groups: [CTL]\\ncalibration: {walls: [linear], starts: 1}\\n")
    >>> [row.animal for row in vw.read_study("study.yaml").animals]
    ['mouse 6']
    """
    study, problems = inspect_study(path)
    refuse(problems)
    assert study is not None
    return study
