"""What a lab knows of its animals beside the recordings: columns of their table, each of one type."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from difflib import get_close_matches
from typing import Any, Literal

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind
from vasowave.base.io.columns import split_unit

_MAX_MEDIAN_RATIO = 5.0
"""Ratio to the median: no weight or age of animals that one compares, but a slip of the decimal point."""
BASELINE_WORDS = ("before", "pre", "baseline", "base", "basal", "bl", "vorher", "vor", "prä", "basis", "ausgangswert",
                  "avant", "antes", "prima", "voor")  # fmt: skip
"""Words for what comes first, of occasions and second factors: other levels are compared with it."""
_MIN_WORD_SIMILARITY = 0.7  # share of letters that two words have in common where one is a slip

CONSTANT = look_kind(
    "variable.constant", "'{value}' in all animals; {remedy}", "it tells nothing about differences; remove the column"
)
MISSPELT = look_kind(
    "variable.misspelt", "'{rare}' in {animal} alone, '{common}' in {count}: did you mean '{common}'?",
    "Correct the cell.",
)  # fmt: skip
SAME_WORD = look_kind(
    "variable.same-word", "'{rare}' in {animals} and '{common}' in {count} count as two, though only capitals or "
    "spaces differ: did you mean '{common}'?", "Write one of them everywhere.",
)  # fmt: skip
ALONE = look_kind(
    "variable.one-animal", "'{value}' in {animal} alone: one animal does not show how far such animals differ",
    "Correct the cell if it is a slip.",
)  # fmt: skip
FAR_OFF = look_kind(
    "variable.far-off", "{value:g} in {animal} is {factor:.3g} times the median: a slip of the decimal point?",
    "Correct the cell if it is one.",
)  # fmt: skip
GAPS = look_kind(
    "variable.gaps", "empty in {count} of {all} rows ({animals}); {remedy}",
    "a design that names this column leaves them out: fill the cells",
)  # fmt: skip


@dataclass(frozen=True)
class Variable:
    """One column that a lab has of its animals: sex, litter, weight [g], day of birth.

    Attributes
    ----------
    name, unit : str
        The unit is empty where the title has none.
    kind : {"number", "category", "date"}
    values : dict of str to float or str
        By animal; a date as YYYY-MM-DD. Animals whose cell is empty are absent.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Variable.from_cells("weight [g]", {"CTL 1": "24.1", "CTL 2": "22", "HPH 1": ""}).values
    {'CTL 1': 24.1, 'CTL 2': 22.0}
    """

    name: str
    unit: str
    kind: Literal["number", "category", "date"]
    values: Mapping[str, Any]

    @classmethod
    def from_cells(cls, title: str, cells: Mapping[str, str]) -> "Variable":
        """Return the column of a title and the text of every animal's cell.

        A title with a unit, or most of whose cells are numbers, is one of numbers; likewise of dates (YYYY-MM-DD).

        Raises
        ------
        InputError
            A cell of such a column is neither; it names the animal.
        """
        name, unit = split_unit(title)
        filled = {animal: text.strip() for animal, text in cells.items() if text.strip()}
        unit = "" if "[" not in title else unit
        for kind, read in (("number", _number), ("date", _date)):
            values = {animal: read(text) for animal, text in filled.items()}
            good = sum(value is not None for value in values.values())
            if (unit and kind == "number") or 2 * good > len(filled):
                for animal, value in values.items():
                    if value is None:
                        expected = "a number" if kind == "number" else "a date (YYYY-MM-DD)"
                        raise InputError(f"'{filled[animal]}' of {animal} is not {expected}, as the others are")
                return cls(name, unit, kind, values)  # type: ignore[arg-type]
        return cls(name, unit, "category", filled)

    @property
    def label(self) -> str:
        """The title of the column: ``weight [g]``."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    @property
    def numbers(self) -> dict[str, float]:
        """The values as numbers: of dates, days since the first. Empty for categories."""
        if self.kind == "category":
            return {}
        if self.kind == "number":
            return {animal: float(value) for animal, value in self.values.items()}
        days = {animal: date.fromisoformat(value).toordinal() for animal, value in self.values.items()}
        return {animal: float(day - min(days.values())) for animal, day in days.items()}

    def titled(self, level: str) -> str:
        """Return a level with the name of the column; of occasions, which `add` names so, the level alone."""
        return level if self.name == "occasion" else f"{self.name} {level}"

    @property
    def levels(self) -> dict[str, str]:
        """The values as categories, numbers as people write them."""
        return {animal: f"{value:g}" if self.kind == "number" else str(value) for animal, value in self.values.items()}

    @property
    def order(self) -> list[str]:
        """Its different levels: numbers and dates from low to high, categories as they come in the table.

        A word that says what came first (`BASELINE_WORDS`) is first, wherever it stands.
        """
        levels = dict.fromkeys(self.levels.values())
        if self.kind == "number":
            return sorted(levels, key=float)
        return (
            sorted(levels)
            if self.kind == "date"
            else sorted(levels, key=lambda level: level.casefold() not in BASELINE_WORDS)
        )

    def slips(self, animals: Mapping[str, str], subjects: Mapping[str, str] | None = None) -> list[Finding]:
        """Return what looks like a slip of the pen.

        Parameters
        ----------
        animals : mapping of str to str
            Those of the table, with their groups.
        subjects : mapping of str to str, optional
            Which animal each row is of, where several may be of one: words are counted by these.
        """
        empty = [name for name in animals if name not in self.values]
        gaps = [GAPS(count=len(empty), all=len(animals), animals=", ".join(empty[:4]))] if empty else []
        findings: list[Finding] = gaps if self.values else []
        if len(set(self.levels.values())) == 1 and len(self.values) > 1:
            return [*findings, CONSTANT(value=next(iter(self.levels.values())))]
        return findings + (self._odd_words(subjects or {}) if self.kind == "category" else self._far_off())

    def _odd_words(self, subjects: Mapping[str, str]) -> list[Finding]:
        owners: dict[str, dict[str, str]] = {}  # of each word: its subjects, and a row of each
        for animal, value in self.values.items():
            owners.setdefault(value, {}).setdefault(subjects.get(animal) or animal, animal)
        counts = Counter({value: len(subject_rows) for value, subject_rows in owners.items()})
        findings, twins = [], set[str]()
        for value in sorted(counts, key=lambda word: counts[word]):
            same = [
                candidate
                for candidate in counts
                if without_case(candidate) == without_case(value) and candidate not in (value, *twins)
            ]
            if same:
                twins.add(value)
                common = max(same, key=lambda word: counts[word])
                finding = SAME_WORD(rare=value, animals=", ".join([*owners[value]][:4]), common=common,
                                 count=counts[common])  # fmt: skip
                findings.append(finding.at(animal=next(iter(owners[value].values()))))
        rare = [value for value, count in counts.items() if count == 1 and value not in twins]
        if 2 * len(rare) > len(counts):  # names of animals, tags
            return findings
        for value in rare:
            ((subject, animal),) = owners[value].items()
            match = likely_word(value, [candidate for candidate in counts if counts[candidate] > 1])
            alone = ALONE(value=value, animal=subject)
            slip = MISSPELT(rare=value, animal=subject, common=match, count=counts[match]) if match else alone
            findings.append(slip.at(animal=animal))
        return findings

    def _far_off(self) -> list[Finding]:
        values = self.numbers if self.kind == "number" else {}
        if len(values) < 4 or min(values.values()) <= 0:
            return []
        middle = float(np.median([*values.values()]))
        spread = float(np.median(np.abs(np.log(np.array([*values.values()]) / middle))))
        return [FAR_OFF(value=value, animal=animal, factor=value / middle) for animal, value in values.items()
                if abs(math.log(value / middle)) > max(math.log(_MAX_MEDIAN_RATIO), 6 * spread)]  # fmt: skip


def without_case(word: str) -> str:
    """Return a word without capitals and blanks, in which spellings of one word are alike."""
    return "".join(word.casefold().split())


def likely_word(word: str, candidates: Sequence[str]) -> str:
    """Return the word that is meant perhaps: one of nearly the same letters, or one that it lengthens or cuts."""
    originals = {without_case(candidate): candidate for candidate in candidates}
    plain = without_case(word)
    longer = [spelling for spelling in originals if spelling.startswith(plain) or plain.startswith(spelling)]
    close = get_close_matches(plain, originals, n=1, cutoff=_MIN_WORD_SIMILARITY if len(word) > 2 else 1.0)
    for spelling in (*close, *longer):
        if not (_letters(spelling) == _letters(plain) and spelling != plain):  # L1 and L2 are two litters
            return originals[spelling]
    return ""


def _letters(word: str) -> str:
    return "".join(letter for letter in word if not letter.isdigit())


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _date(text: str) -> str | None:
    try:
        return date.fromisoformat(text).isoformat()
    except ValueError:
        return None
