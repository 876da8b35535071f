"""What is wrong or odd in the design of a study, at the rows that it concerns, and the design in words.

Also what the rows of one animal say of it: a property that differs between them, an occasion that is missing.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from operator import attrgetter

import numpy as np

from vasowave.base.cures import SetSetting
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, Place, error_kind, look_kind
from vasowave.base.settings import AT_ODDS
from vasowave.study.cohort.contrast import MIN_FREEDOM, untold_findings
from vasowave.study.cohort.degrees import degrees_left
from vasowave.study.cohort.design import Layout
from vasowave.study.cohort.effects import grouped
from vasowave.study.cohort.unused import unused_columns
from vasowave.study.cohort.variables import BASELINE_WORDS
from vasowave.study.folder.problems import StudyProblem
from vasowave.study.folder.rows import AnimalRow
from vasowave.study.folder.study import Study
from vasowave.study.report.wording import listed, some_of

_MIN_ANIMAL_SHARE = 1 / 3  # of the animals
_MAX_NAMED_ANIMALS = 3  # animals, in a sentence
_MAX_WIDENING = 1.5  # times, of an interval by covariates
FEW_LEFT = look_kind(
    "design.few-left", "of {animals} animals {left} are left to tell how animals scatter: intervals will be wide, and "
    "what differs may not be shown; {remedy}", "name fewer covariates and blocks, or add animals",
)  # fmt: skip
FEW_DEGREES = look_kind(
    "design.few-degrees",
    "{effects}: the design may leave as few as {freedom} degrees of freedom (more, where rows or blocks scatter "
    "little); with {rows} comparisons an effect is then shown only where it is about {times:.3g} times its standard "
    "error ({many:.2g} times with many animals); {remedy}",
    "name fewer covariates, blocks, quantities or contrasts, or add animals",
)
COSTLY = look_kind(
    "design.costly-covariates",
    "{effects}: adjusted for {columns} the interval is {factor:.2g} times as wide, since the groups differ in it; "
    "{remedy}",
    "leave out a covariate that the disease itself changes (as the weight of sick animals), or add animals alike in it",
)  # fmt: skip
SEVERAL_GROUPS = error_kind(
    "design.several-groups", "{subject} {rows}: an animal is of one group; {remedy}",
    "correct the cells, and give animals of two groups two names. If an animal was in one group after the other, write "
    "crossover: true under design", SetSetting("It was in one after the other", "design.crossover", "true"),
)  # fmt: skip
SUBJECT_ONCE = look_kind(
    "design.subject-once", "no {subject} has two rows, so that no recordings are of one animal; {remedy}",
    "correct the column, or take subject out of the design",
)  # fmt: skip
ONE_OCCASION = look_kind(
    "design.one-occasion", "no {subject} was recorded at two levels of {occasion}, so that it is compared between "
    "animals and not within them; {remedy}", "check the two columns, or name the occasion as factor",
)  # fmt: skip
SAME_OCCASION = look_kind(
    "design.same-occasion", "{subject} {rows}: these recordings count as repeats of one occasion; {remedy}",
    "check the cells if that is not meant",
)  # fmt: skip


def design_problems(study: Study, place: Place, complete: bool) -> Iterator[StudyProblem]:
    """Yield what is wrong or odd in the design of a study.

    Parameters
    ----------
    study : Study
    place : Place
        Of the design in the study file, for what concerns no row.
    complete : bool
        Whether all rows of the table are there; without some, only what is wrong in the others is looked for.
    """
    try:
        mixed = several_groups(study)
        yield from mixed
        if complete and not mixed:
            yield from _odd(study, place) if study.layout is not None else ()
            members = {row.animal: row.group for row in study.animals}
            for finding in unused_columns(study.lab_columns, study.settings.design, members, study.settings.groups):
                yield StudyProblem(finding.at(str(study.table)))
    except InputError as error:
        if complete:
            yield StudyProblem(AT_ODDS(text=str(error)).placed(place))


def understood(study: Study, complete: bool) -> str:
    """Return the design in words, as the program understands it; empty without one, or if it is wrong.

    Parameters
    ----------
    study : Study
    complete : bool
        Whether all rows of the table are there.
    """
    try:
        if several_groups(study) or study.layout is None:
            return ""
    except InputError:  # which `design_problems` says
        return ""
    without = "" if complete else "without the rows that have errors, "
    return f"{without}{study.layout.text}{_first_word(study)}{_repeats(study)}"


def several_groups(study: Study) -> list[StudyProblem]:
    """Return an error for the subjects that stand in several groups, unless the design says that they do; raises as
    `variables_of`.
    """
    design = study.settings.design
    mixed = {name: rows for name, rows in rows_of_subjects(study).items() if len({row.group for row in rows}) > 1}
    if not mixed or design.crossover:
        return []
    members = {name: grouped(rows, attrgetter("group")).items() for name, rows in mixed.items()}
    places = [
        f"'{name}' is in {listed([f'{group} ({_lines(rows)})' for group, rows in by_group])}"
        for name, by_group in members.items()
    ]
    first = next(iter(mixed.values()))
    differing_row = next(row for row in first if row.group != first[0].group)
    finding = SEVERAL_GROUPS(subject=str(design.subject), rows=some_of(places, _MAX_NAMED_ANIMALS))
    return [
        _placed(
            study, finding, differing_row.line, str(design.subject), (row for rows in mixed.values() for row in rows)
        )
    ]


def _odd(study: Study, place: Place) -> Iterator[StudyProblem]:
    """Yield what is odd in a design that can be applied."""
    design, layout = study.settings.design, study.layout
    assert layout is not None
    of_all = [*untold_findings(layout.contrasts, layout.untold)]
    animals_left = layout.left_for_scatter(design.blocks)
    if animals_left < _MIN_ANIMAL_SHARE * len(study.animals):
        of_all.append(FEW_LEFT(animals=len(layout.animals), left=animals_left))
    of_all += [*_few_degrees(study, layout), *_costly(layout, design.covariates)]
    yield from (StudyProblem(finding.placed(place)) for finding in of_all)
    if design.subject and not design.occasion and not layout.repeated:
        yield _placed(study, SUBJECT_ONCE(subject=design.subject), 0, design.subject)
    if design.subject and design.occasion:
        yield from _odd_occasions(study, design.subject, design.occasion)
    rows_by_subject = rows_of_subjects(study)
    yield from _varying(study, rows_by_subject)
    yield from _missing(study, rows_by_subject)


def _few_degrees(study: Study, layout: Layout) -> Iterator[Finding]:
    """Yield which comparisons few degrees of freedom are left for, and how large effects must then be."""
    from scipy.special import ndtri, stdtrit

    rows = len(study.settings.report.quantities) * len(layout.contrasts)
    effects_by_freedom: dict[int, list[str]] = {}
    for contrast in layout.contrasts:
        effects_by_freedom.setdefault(degrees_left(layout, study.settings.design.blocks, contrast), []).append(
            contrast.text
        )
    for freedom, effects in effects_by_freedom.items():
        if freedom < MIN_FREEDOM and rows:
            side = 1 - 0.025 / rows  # Bonferroni's bound: the rows are judged together
            times, many = (float(quantile) for quantile in (stdtrit(max(freedom, 1), side), ndtri(side)))
            yield FEW_DEGREES(effects="; ".join(effects), freedom=freedom, rows=rows, times=times, many=many)


def _costly(layout: Layout, covariates: Sequence[str]) -> Iterator[Finding]:
    """Yield which comparisons covariates widen, by least squares with one variance."""
    if not covariates or layout.repeated:
        return
    counts, inverse = np.bincount(layout.cell, minlength=len(layout.cells)), np.linalg.pinv(layout.fixed)
    for contrast in layout.contrasts:
        in_use = contrast.weights != 0
        plain = float((contrast.weights[in_use] ** 2 / counts[in_use]).sum())
        factor = float(np.linalg.norm(contrast.weights @ layout.means @ inverse)) / np.sqrt(plain)
        if factor > _MAX_WIDENING:
            yield COSTLY(effects=contrast.text, columns=listed(list(covariates)), factor=factor)


def _odd_occasions(study: Study, subject: str, occasion: str) -> Iterator[StudyProblem]:
    """Yield what is odd of subjects and their occasions."""
    when = study.lab_columns[occasion].levels
    times: dict[tuple[str, str], list[AnimalRow]] = {}
    for name, rows in rows_of_subjects(study).items():
        for row in rows:
            if row.animal in when:
                times.setdefault((name, when[row.animal]), []).append(row)
    if len({name for name, _ in times}) == len(times):
        yield _placed(study, ONE_OCCASION(subject=subject, occasion=occasion), 0, occasion)
    again = {key: rows for key, rows in times.items() if len(rows) > 1}
    if again:
        places = [f"'{name}' stands at {occasion} {time} in {_lines(rows)}" for (name, time), rows in again.items()]
        finding = SAME_OCCASION(subject=subject, occasion=occasion, rows=some_of(places, _MAX_NAMED_ANIMALS))
        second = next(iter(again.values()))[1]
        yield _placed(study, finding, second.line, occasion, (row for rows in again.values() for row in rows))


def _lines(rows: Sequence[AnimalRow]) -> str:
    return f"line{'s' if len(rows) > 1 else ''} {listed([str(row.line) for row in rows])}"


def _placed(study: Study, finding: Finding, line: int, column: str, rows: Iterable[AnimalRow] = ()) -> StudyProblem:
    location = f"column '{column}'"
    return StudyProblem(finding.at(str(study.table), line=line, part=location), also=tuple(row.animal for row in rows))


def _first_word(study: Study) -> str:
    """Say which level others are compared with where they are words, whose order is that of the table."""
    second = study.lab_columns.get(study.settings.design.second or "")
    if second is None or second.kind != "category":
        return ""
    first = second.order[0]
    if first.casefold() in BASELINE_WORDS:
        return f" Others are compared with '{first}', which says that it came first."
    return (f" '{first}' is the first {second.name} in the table, so others are compared with it; "
            "put a row of another first to turn that round.")  # fmt: skip


def _repeats(study: Study) -> str:
    """Say how several recordings of one animal are understood where the design names no occasion."""
    design = study.settings.design
    if not design.subject or study.layout is None or not study.layout.repeated:
        return ""
    if design.crossover:
        return f" A {design.subject} in several groups is compared with itself."
    if design.second:
        return ""
    return (f" Recordings of one {design.subject} count as repeats of each other. If they were made at different "
            "times, name the column of the times as occasion.")  # fmt: skip


VARIES = error_kind(
    "design.varies-within", "{subject} {name} has {said}, where others have one word in all rows; {remedy}",
    "correct the cell, or take the column out of the design",
)  # fmt: skip
NO_OCCASION = look_kind(
    "design.missing-occasion", "{subject} {names} {have} no recording at {occasion} '{level}', as others have; "
    "{remedy}", "check the columns if there is one",
)  # fmt: skip


def rows_of_subjects(study: Study) -> dict[str, list[AnimalRow]]:
    """Return the rows of each subject; none where the design names no subject or the table has no such column."""
    column = study.lab_columns.get(study.settings.design.subject or "")
    subjects = {} if column is None else column.levels
    return grouped((row for row in study.animals if row.animal in subjects), lambda row: subjects[row.animal])


def _varying(study: Study, rows_by_subject: Mapping[str, Sequence[AnimalRow]]) -> Iterator[StudyProblem]:
    """Yield animals whose rows differ in a category that is one for each of most animals, and so their property."""
    design = study.settings.design
    for column in (variable for variable in study.variables if variable.name in (*design.covariates, *design.blocks)):
        if column.kind != "category" and not (column.name in design.blocks and column.kind == "number"):
            continue
        several = {name: rows for name, rows in rows_by_subject.items() if len(rows) > 1}
        words_by_animal = {
            name: {row.line: column.levels[row.animal] for row in rows if row.animal in column.levels}
            for name, rows in several.items()
        }
        varying = [name for name, words in words_by_animal.items() if len(set(words.values())) > 1]
        if 2 * len(varying) >= len(several):  # an operator, a day: no property of an animal
            continue
        for name in varying:
            first = next(iter(words_by_animal[name]))
            words = " and ".join(
                f"{column.name} '{word}' in line {line}" for line, word in words_by_animal[name].items()
            )
            finding = VARIES(subject=str(design.subject), name=name, said=words)
            yield StudyProblem(finding.at(str(study.table), line=first, part=f"column '{column.label}'"),
                          also=tuple(row.animal for row in rows_by_subject[name]))  # fmt: skip


def _missing(study: Study, rows_by_subject: Mapping[str, Sequence[AnimalRow]]) -> Iterator[StudyProblem]:
    """Yield animals without an occasion that others of their group have, a problem for each occasion."""
    design = study.settings.design
    times = study.lab_columns.get(design.occasion or "")
    if times is None:
        return
    levels = {name: {times.levels.get(row.animal) for row in rows} for name, rows in rows_by_subject.items()}
    if max(map(len, levels.values()), default=0) < 2:
        return
    for level in times.order:
        if sum(level in occasions for occasions in levels.values()) < 2:  # a word that stands alone is a slip itself
            continue
        groups = {row.group for name, rows in rows_by_subject.items() if level in levels[name] for row in rows}
        lacking = [
            name for name, rows in rows_by_subject.items() if level not in levels[name] and rows[0].group in groups
        ]
        if lacking:
            lines = [row.line for name in lacking for row in rows_by_subject[name]]
            finding = NO_OCCASION(subject=str(design.subject), names=", ".join(lacking), level=level,
                                have="has" if len(lacking) == 1 else "have", occasion=times.name)  # fmt: skip
            place = {"line": lines[0], "part": f"column '{times.label}'"}
            yield StudyProblem(finding.at(str(study.table), **place), same=tuple(lines[1:]))
