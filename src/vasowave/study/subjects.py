"""What the rows of one animal say of it: a property that differs between them, an occasion that is missing."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from vasowave.findings import error_kind, look_kind
from vasowave.study.problems import Problem
from vasowave.study.rows import AnimalRow

if TYPE_CHECKING:
    from vasowave.study.plan import Study

VARIES = error_kind(
    "design.varies-within", "{subject} {name} has {said}, where others have one word in all rows; {remedy}",
    "correct the cell, or take the column out of the design",
)  # fmt: skip
NO_OCCASION = look_kind(
    "design.missing-occasion", "{subject} {names} {have} no recording at {occasion} '{level}', as others have; "
    "{remedy}", "check the columns if there is one",
)  # fmt: skip


def rows_of_subjects(study: "Study") -> dict[str, list[AnimalRow]]:
    """Return the rows of each subject; none where the design names no subject or the table has no such column."""
    known = next((one.levels for one in study.variables if one.name == study.settings.design.subject), {})
    found: dict[str, list[AnimalRow]] = {}
    for row in study.animals:
        if row.animal in known:
            found.setdefault(known[row.animal], []).append(row)
    return found


def subject_problems(study: "Study") -> list[Problem]:
    """Return what is wrong or odd about the rows of each subject of a study's design."""
    own = rows_of_subjects(study)
    return [*_varying(study, own), *_missing(study, own)]


def _varying(study: "Study", own: Mapping[str, Sequence[AnimalRow]]) -> Iterator[Problem]:
    """Yield animals whose rows differ in a category that is one for each of most animals, and so their property."""
    design = study.settings.design
    for column in (one for one in study.variables if one.name in (*design.covariates, *design.blocks)):
        if column.kind != "category" and not (column.name in design.blocks and column.kind == "number"):
            continue
        several = {name: rows for name, rows in own.items() if len(rows) > 1}
        said = {
            name: {row.line: column.levels[row.animal] for row in rows if row.animal in column.levels}
            for name, rows in several.items()
        }
        varying = [name for name, words in said.items() if len(set(words.values())) > 1]
        if 2 * len(varying) >= len(several):  # an operator, a day: no property of an animal
            continue
        for name in varying:
            first = next(iter(said[name]))
            words = " and ".join(f"{column.name} '{word}' in line {line}" for line, word in said[name].items())
            found = VARIES(subject=str(design.subject), name=name, said=words)
            yield Problem(found.at(str(study.table), line=first, part=f"column '{column.label}'"),
                          also=tuple(row.animal for row in own[name]))  # fmt: skip


def _missing(study: "Study", own: Mapping[str, Sequence[AnimalRow]]) -> Iterator[Problem]:
    """Yield animals without an occasion that others of their group have, a problem for each occasion."""
    design = study.settings.design
    times = {one.name: one for one in study.variables}.get(design.occasion or "")
    if times is None:
        return
    levels = {name: {times.levels.get(row.animal) for row in rows} for name, rows in own.items()}
    if max(map(len, levels.values()), default=0) < 2:
        return
    for level in times.order:
        if sum(level in seen for seen in levels.values()) < 2:  # a word that stands alone is a slip of its own
            continue
        there = {row.group for name, rows in own.items() if level in levels[name] for row in rows}
        lacking = [name for name, rows in own.items() if level not in levels[name] and rows[0].group in there]
        if lacking:
            lines = [row.line for name in lacking for row in own[name]]
            found = NO_OCCASION(subject=str(design.subject), names=", ".join(lacking), level=level,
                                have="has" if len(lacking) == 1 else "have", occasion=times.name)  # fmt: skip
            place = {"line": lines[0], "part": f"column '{times.label}'"}
            yield Problem(found.at(str(study.table), **place), same=tuple(lines[1:]))
