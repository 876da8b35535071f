"""Columns that look like units or confounders and that the design does not name, against the groups."""

import re
import unicodedata
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from vasowave.base.cures import SetSetting
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind
from vasowave.pulse.inference.known_errors import SHARED_SOURCES
from vasowave.study.cohort.design import Design, laid_out
from vasowave.study.cohort.effects import grouped
from vasowave.study.cohort.guard import RULES, rate_of_blocks
from vasowave.study.cohort.variables import Variable


@dataclass(frozen=True)
class UnusedRules:
    """The differences from which on a column that no design names is a finding.

    Attributes
    ----------
    share : float
        Of a word, between two groups.
    distance : float
        Of the means of two groups, in SD within groups.
    words : int
        Of a column that are named one by one.
    rows : int
        Of which false positives are counted; of more animals some units, whole.
    letters : int
        Of words that titles hold as they are; longer ones may be joined with others.
    """

    share: float = 0.3
    distance: float = 1.0
    words: int = 4
    rows: int = 400
    letters: int = 3


COLUMNS = UnusedRules()


class Role(Enum):
    """The part of a column in a study, by words of its title in the languages of labs."""

    COVARIATE = (
        "sex sexe sexo sesso gender geschlecht geslacht strain stamm souche cepa ceppo breed race age alter edad eta "
        "leeftijd weight gewicht poids peso bodymass mass masse bw birth born dob geburt naissance nacimiento size"
    )
    UNIT = (
        "litter wurf portee camada nest dam sire mother mutter parent family familie cage kafig kooi jaula gabbia pen "
        "housing batch lot charge lote partie lotto shipment delivery lieferung vendor supplier operator operateur "
        "operatrice operador operatore experimenter experimentator surgeon chirurg chirurgien technician untersucher "
        "investigator observer room rig setup session run day tag jour dia giorno dag date datum fecha data"
    )
    SUBJECT = (
        "mouse maus souris raton topo muis rat ratte pig schwein subject subjekt sujet patient individual tier animal "
        "id eartag chip"
    )


AS_GROUP = look_kind(
    "design.column-is-group",
    "'{column}' goes with the group ({table}): no analysis can tell the two apart; {remedy}",
    "write so with the results, or add animals that are alike in it",
)
UNEQUAL = look_kind(
    "design.column-unequal",
    "'{column}' differs between the groups ({table}) and is not in the design: what differs may be due to it; {remedy}",
    "name it under covariates, unless the disease itself changes it",
    SetSetting("Adjust the groups for {column}", "design.covariates", "[{covariates}]"),
)
_ALIKE_TEXT = (
    "'{column}' is not in the design ({table}), and animals of one {column} may be alike: if they share {percent:.0f} "
    "% of the variance, {rate:.0f} of 100 studies without any effect show one, where 5 should; {remedy}"
)
UNIT = look_kind("design.unit-unused", _ALIKE_TEXT, "name it under blocks")
UNIT_CONFOUNDED = look_kind(
    "design.unit-confounded",
    _ALIKE_TEXT,
    "no analysis can correct that: write so with the results, or add animals of others",
)
AGAIN = look_kind(
    "design.subject-unused",
    "'{column}' has one word in several rows, which count as different animals: {table}; {remedy}",
    "if they are of one animal, name the column as subject of the design, and the column that says before or after as "
    "its occasion (or crossover: true where it was in one group after the other); if numbers begin anew in each group, "
    "give each animal a word of its own",
    SetSetting("Recordings of one {column} are of one animal", "design.subject", "{column}"),
)


def role_of(title: str) -> Role | None:
    """Return the part that a column has by its title; None if no word of it tells."""
    plain = unicodedata.normalize("NFKD", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", title)).casefold()
    title_words = re.findall("[a-z]+", "".join(letter for letter in plain if not unicodedata.combining(letter)))

    def means(title_word: str, word: str) -> bool:
        if title_word == word or len(word) <= COLUMNS.letters:  # days are a duration
            return title_word == word
        return title_word.startswith(word) or (len(word) > COLUMNS.letters + 1 and title_word.endswith(word))

    return next(
        (
            role
            for role in Role
            if any(means(title_word, word) for title_word in title_words for word in role.value.split())
        ),
        None,
    )


def unused_columns(
    variables: Mapping[str, Variable], design: Design, members: Mapping[str, str], groups: Sequence[str]
) -> list[Finding]:
    """Return what stands in columns that look like units or confounders and that the design does not name.

    Parameters
    ----------
    variables : mapping of str to Variable
        By name.
    design : Design
    members : mapping of str to str
        The group of every row.
    groups : sequence of str
        In their order, the reference first.
    """
    subjects = variables[design.subject].levels if design.subject and design.subject in variables else {}
    first = {subjects.get(row, row): row for row in [*members][::-1]}  # a row of each animal
    rows = {row: members[row] for row in members if first[subjects.get(row, row)] == row}
    findings: list[Finding] = []
    for name, variable in variables.items():
        role = role_of(name)
        if name.lower() in (*design.terms, *SHARED_SOURCES) or (role is Role.SUBJECT and design.subject):
            continue
        if role is Role.SUBJECT:
            column_findings = _again(variable)
        else:
            words = {group: [variable.levels[row] for row in rows if rows[row] == group and row in variable.values]
                     for group in groups}  # fmt: skip
            words = {group: group_words for group, group_words in words.items() if group_words}
            column_findings = _in_groups(variables, variable, design, rows, words) if len(words) > 1 else iter(())
        findings += (finding.at(part=f"column '{variable.label}'") for finding in column_findings)
    return findings


def _in_groups(
    variables: Mapping[str, Variable], variable: Variable, design: Design, rows: Mapping[str, str],
    words: Mapping[str, Sequence[str]],
) -> Iterator[Finding]:  # fmt: skip
    """Return what is odd of a column whose words stand in several groups: of a covariate, or of units of animals."""
    role, counts = role_of(variable.name), Counter(word for group_words in words.values() for word in group_words)
    is_label = variable.kind == "category" or (role is Role.UNIT and variable.kind != "date")  # numbers of cages too
    if len(counts) < 2 or (max(counts.values()) == 1 and is_label):
        return iter(())  # one word in all animals, or one for each, as of a tag
    one_each = all(len({*group_words}) == 1 for group_words in words.values())
    if role is not Role.COVARIATE and max(counts.values()) > 1 and not one_each:
        unit = role is Role.UNIT or _nested(variable, words, counts)
        return _of_unit(variables, variable, design, rows, words) if unit else iter(())
    return _of_covariate(variable, words, design.covariates) if role is not None else iter(())


def _again(variable: Variable) -> Iterator[Finding]:
    """Yield which words of a column stand in several rows."""
    rows = grouped(variable.levels, variable.levels.__getitem__)
    again = [f"'{word}' in {', '.join(names)}" for word, names in rows.items() if len(names) > 1]
    if again:
        ellipsis = ["…"] if len(again) > COLUMNS.words else []
        yield AGAIN(column=variable.name, table="; ".join(again[: COLUMNS.words] + ellipsis))


def _of_covariate(
    variable: Variable, words: Mapping[str, Sequence[str]], covariates: Sequence[str]
) -> Iterator[Finding]:
    """Yield that words or numbers of the first group are not those of another; `covariates` are in the design."""
    if all(len({*group_words}) == 1 for group_words in words.values()):
        table = ", ".join(f"all {group} are {group_words[0]}" for group, group_words in words.items())
    elif variable.kind == "category":
        table = "; ".join(f"{group}: {_counted(group_words)}" for group, group_words in words.items())
    else:
        ends = {group: [word for word in variable.order if word in group_words] for group, group_words in words.items()}
        table = "; ".join(
            f"{group}: {group_words[0]} to {group_words[-1]} {variable.unit}".rstrip()
            for group, group_words in ends.items()
        )
    if variable.kind == "category":
        shares = [
            np.array([group_words.count(word) / len(group_words) for word in variable.order])
            for group_words in words.values()
        ]
        disjoint = any(not (shares[0] * sample).any() for sample in shares[1:])
        unequal = any(np.abs(shares[0] - sample).max() >= COLUMNS.share for sample in shares[1:])
    else:
        size = {word: variable.numbers[row] for row, word in variable.levels.items()}
        numbers, *samples = (np.array([size[word] for word in group_words]) for group_words in words.values())
        distances = np.array([_distance(numbers, sample) for sample in samples])
        disjoint = any(
            (numbers.max() < sample.min() or sample.max() < numbers.min()) and distance >= 2 * COLUMNS.distance
            for sample, distance in zip(samples, distances, strict=True)
        )
        unequal = bool((distances >= COLUMNS.distance).any())
    if disjoint:
        yield AS_GROUP(column=variable.name, table=table)
    elif unequal:
        yield UNEQUAL(column=variable.name, table=table, covariates=", ".join([*covariates, variable.name]))


def _nested(variable: Variable, words: Mapping[str, Sequence[str]], counts: Mapping[str, int]) -> bool:
    """Whether a column is of units by its words alone: several in each group, most of several animals, of one group."""
    several = sum(count for count in counts.values() if count > 1)
    return (
        variable.kind == "category"
        and 2 * several > sum(counts.values())
        and min(len({*group_words}) for group_words in words.values()) > 1
        and sum(len({*group_words}) for group_words in words.values()) == len(counts)
    )


def _of_unit(
    variables: Mapping[str, Variable], variable: Variable, design: Design, rows: Mapping[str, str],
    words: Mapping[str, Sequence[str]],
) -> Iterator[Finding]:  # fmt: skip
    """Yield how often a study finds what is not there if animals of one unit are alike, where that is too often."""
    table, before = [], set[str]()
    for group, group_words in words.items():
        units = {*group_words}
        label = " other" if len(units) == 1 else " others"
        new = "" if not before else " of the same" if units <= before else label if not before & units else ""
        named = f" ({', '.join(dict.fromkeys(group_words))})" if len(units) <= COLUMNS.words else ""
        table.append(f"{len(group_words)} {group} from {len(units)}{new}{named}")
        before |= units
    counted = variable.order[:: -(-len(rows) // COLUMNS.rows)]
    members = {row: group for row, group in rows.items() if variable.levels.get(row) in counted}
    try:
        layout = laid_out(design, variables, members, list(words))
    except InputError:  # which is told of the design itself
        return
    if not layout.contrasts:
        return
    rate = rate_of_blocks(layout, [variable.levels[row] for row in layout.animals], RULES.quantities)
    if rate > RULES.tolerable:
        kind = UNIT if _fits_as_block(variables, variable, design, rows, list(words)) else UNIT_CONFOUNDED
        yield kind(column=variable.name, table=", ".join(table), percent=100 * RULES.block_share, rate=100 * rate)


def _fits_as_block(
    variables: Mapping[str, Variable], variable: Variable, design: Design, rows: Mapping[str, str],
    groups: Sequence[str],
) -> bool:  # fmt: skip
    """Whether a design that names the column as a block can tell units from animals, and still compares something."""
    animals: dict[str, set[str]] = {}
    for row in rows:
        if row in variable.levels:
            animals.setdefault(variable.levels[row], set()).add(row)
    group_animals = [{row for row in rows if rows[row] == group} for group in groups]
    if all(len(unit_animals) == 1 or unit_animals in group_animals for unit_animals in animals.values()):
        return False
    try:
        name = variable.name.lower()  # as designs write it
        with_unit = replace(design, blocks=(*design.blocks, name))
        return bool(laid_out(with_unit, {**variables, name: variable}, rows, groups).contrasts)
    except InputError:
        return False


def _counted(words: Sequence[str]) -> str:
    counts = Counter(words)
    named = [f"{count} {word}" for word, count in counts.items()]
    return ", ".join(named) if len(named) <= COLUMNS.words else f"{len(words)} animals of {len(named)}"


def _distance(first: np.ndarray, second: np.ndarray) -> float:
    """Return how far means are apart, in the SD within both groups."""
    squares = ((first - first.mean()) ** 2).sum() + ((second - second.mean()) ** 2).sum()
    within = np.sqrt(squares / max(len(first) + len(second) - 2, 1))
    return float(abs(first.mean() - second.mean()) / max(within, 1e-300))
