"""When each animal was recorded (pre and post; baseline and week 4), and which animal: told by names of recordings."""

import os
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from vasowave.study.cohort.effects import grouped
from vasowave.study.cohort.variables import BASELINE_WORDS
from vasowave.study.entering.animal_sheet import ANIMAL_WORDS
from vasowave.study.entering.grouping import path_names, words
from vasowave.study.folder.names import plain_name
from vasowave.study.report.wording import listed, some_of

_LATER = ("after", "post", "end", "final", "endpoint", "follow up", "nachher", "nach", "ende", "après", "apres",
          "después", "despues", "dopo", "na")  # fmt: skip
_UNITS = {
    "minute": "minutes minute min", "hour": "hours hour hrs hr h", "day": "days day d tage tag jours jour",
    "week": "weeks week wks wk w wochen woche semaines semaine", "month": "months month mo monate monat mois",
}  # fmt: skip
_UNIT_OF = {word: unit for unit, unit_words in _UNITS.items() for word in unit_words.split()}


def _any_of(vocabulary: Iterable[str]) -> str:
    longest_first = sorted(vocabulary, key=len, reverse=True)
    return "|".join(re.escape(word).replace(r"\ ", r"[\W_]*") for word in longest_first)


_BEGIN, _END = r"(?<![^\W\d_])", r"(?![^\W\d_])"
"""Digits may touch a word: R3pre."""
_NAMED = re.compile(rf"{_BEGIN}(?:{_any_of((*BASELINE_WORDS, *_LATER))}){_END}", re.IGNORECASE)
_UNIT = _any_of(_UNIT_OF)
_TIMED = re.compile(rf"{_BEGIN}(?:({_UNIT})[\W_]?(\d+)|(\d+)[\W_]?({_UNIT}))(?!\d){_END}", re.IGNORECASE)
_DATE = r"(?<!\d)(?:19|20)\d\d([-_.]?)[01]\d\1[0-3]\d(?!\d)|(?<!\d)\d\d?[-.]\d\d?[-.](?:19|20)\d\d"
_NO_ANIMAL = re.compile(rf"{_DATE}|\(\d+\)$")
"""A date, or the number of a copy, which recordings of one animal do not share."""
_MIN_COMPLETE = 0.75
"""Share of the animals from which on an occasion that some lack is one of all."""
_MAX_OCCASIONS = 8
_MAX_NAMES = 3  # animals, in a sentence


class _Mark(NamedTuple):
    """The occasion that a name speaks of: a word, or a number of units of time; the name without it; which name."""

    level: str
    unit: str
    remainder: str
    place: int


@dataclass(frozen=True)
class Occasions:
    """The animals and the occasions of some recordings, one entry for each.

    Attributes
    ----------
    subjects : tuple of str
        The animal, called as its first name calls it.
    levels : tuple of str
        The occasion; empty where a name tells none.
    column : str
        The title for them: ``occasion``, or the unit of numbers (``week``).
    files : tuple of Path
        The recordings, called as they would be without their occasions.
    clear : bool
        Whether all, or nearly all, animals have the same occasions, or at least the first.
    assumed : tuple of str
        Animals that were recorded once, of which no name says when: that counts as the first occasion.
    """

    subjects: tuple[str, ...]
    levels: tuple[str, ...]
    column: str
    files: tuple[Path, ...]
    clear: bool
    assumed: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Return the animals and their occasions in words."""
        names, counts = [*dict.fromkeys(self.subjects)], Counter(filter(None, self.levels))
        title = "" if self.column == "occasion" else f"{self.column} "
        order = sorted(counts, key=_by_time)
        occasions = listed([f"{title}{level} ({counts[level]})" for level in order])
        return f"{len(names)} animals ({some_of(names, _MAX_NAMES)}) with recordings at {occasions}"


def told_occasions(files: Sequence[Path], folder: Path, animals: Sequence[str]) -> Occasions | None:
    """Return the occasions that names of recordings, or else of their folders, speak of; None where they do not.

    Two animals or more must have been recorded on two occasions. Whatever stands in a name beside the occasion is the
    animal, ``Rat 3`` and ``R03`` the same one.

    Parameters
    ----------
    files : sequence of Path
    folder : Path
        Of the study: folders that hold it say nothing.
    animals : sequence of str
        The animal of each, where something else tells it.
    """
    names = [path_names(file, folder) for file in files]
    depth = max(map(len, names), default=0)
    readings = (_reading(files, names, animals, place) for place in range(depth))
    return min(filter(None, readings), key=lambda reading: not reading.clear, default=None)


def _by_time(level: str) -> tuple[bool, int]:
    """Return by what occasions are put in their order: words for what comes first, then numbers by size."""
    return level not in BASELINE_WORDS, int(level) if level.isdecimal() else 0


def is_occasion(name: str) -> bool:
    """Whether a name is that of an occasion and nothing else: ``baseline``."""
    mark = _mark(name, 0)
    return mark is not None and not mark.remainder


def _reading(
    files: Sequence[Path], names: Sequence[Sequence[str]], animals: Sequence[str], place: int
) -> Occasions | None:
    """Return what names say whose occasion stands in the file's name (place 0) or in a folder so far out."""
    marks = _marks(names, place)
    units = {mark.unit for mark in marks if mark}
    column = next(iter(units)) if len(units) == 1 and "" not in units else "occasion"
    levels = ["" if mark is None else mark.level if column != "occasion" else f"{mark.unit} {mark.level}".strip()
              for mark in marks]  # fmt: skip
    levels = _with_common_beginning(levels)
    remainders = [_without(of_file, mark) for of_file, mark in zip(names, marks, strict=True)]
    subjects = [text or _subject(of_file) for text, of_file in zip(animals, remainders, strict=True)]
    if _repeated(subjects, levels):
        subjects = [text or _subject(of_file, above=True) for text, of_file in zip(animals, remainders, strict=True)]
    if not all(subjects) or not _followed(subjects, levels):
        return None
    bare = [_unmarked(file, mark) for file, mark in zip(files, marks, strict=True)]
    first = {_key(name): name for name in reversed(subjects)}
    subjects = [first[_key(name)] for name in subjects]
    begun = any(mark and (not mark.unit or mark.level == "0") for mark in marks)  # 3 and 5 weeks may be two groups
    if not (begun and _complete(subjects, levels) and (all(animals) or not _repeated(subjects, levels))):
        return Occasions(tuple(subjects), tuple(levels), column, tuple(bare), False)
    beginning = next(filter(_begins, levels), "")
    unsaid = [subjects.count(name) == 1 and not level for name, level in zip(subjects, levels, strict=True)]
    assumed = [name for name, is_unsaid in zip(subjects, unsaid, strict=True) if is_unsaid and beginning]
    usual = max((len(words(name)) for name in {*subjects} - {*assumed}), default=0)
    if any(len(words(name)) > usual for name in assumed):  # more than an animal's name: perhaps another occasion
        return Occasions(tuple(subjects), tuple(levels), column, tuple(bare), False)
    levels = [beginning if is_unsaid else level for level, is_unsaid in zip(levels, unsaid, strict=True)]
    return Occasions(tuple(subjects), tuple(levels), column, tuple(bare), True, tuple(assumed))


def _with_common_beginning(levels: Sequence[str]) -> list[str]:
    """Return occasions with one word for the first: ``baseline`` and ``vor`` are the same, by the word of most."""
    counts = Counter(level for level in levels if level in BASELINE_WORDS)
    return [max(counts, key=lambda word: counts[word]) if level in counts else level for level in levels]


def _marks(names: Sequence[Sequence[str]], place: int) -> list[_Mark | None]:
    """Return the occasion of each recording at a place, or else that of a file that is called after the first one.

    Beside names that tell the first occasion, what others have more than their animals is an occasion, too. So are
    folders beside one that is called after the first occasion and nothing else, whatever they are called.
    """
    marks = [_mark(of_file[place], place) if place < len(of_file) else None for of_file in names]
    if place == 0:
        return _beside_first(names, marks)
    parents = {tuple(of_file[place + 1 :]) for of_file, mark in zip(names, marks, strict=True)
              if mark and not mark.remainder and mark.level in BASELINE_WORDS}  # fmt: skip
    return [
        _Mark(" ".join(words(of_file[place])), "", "", place) if tuple(of_file[place + 1 :]) in parents
        else mark or _of_first(of_file[0])
        for of_file, mark in zip(names, marks, strict=True)
    ]  # fmt: skip


def _beside_first(names: Sequence[Sequence[str]], marks: Sequence[_Mark | None]) -> list[_Mark | None]:
    """Return the marks, and those of files called like an animal at the first occasion and some word: ``R1 drug``.

    The word stands beside two animals or more, or beside one that has no other recording than the first.
    """
    first = {(*of_file[1:], mark.remainder) for of_file, mark in zip(names, marks, strict=True)
             if mark and mark.level in BASELINE_WORDS and words(_NO_ANIMAL.sub(" ", mark.remainder))}  # fmt: skip
    longest_first = sorted(first, key=lambda called: len(called[-1]), reverse=True)
    candidates = [mark or next(filter(None, (_occasion_beside(of_file, called) for called in longest_first)), None)
             for of_file, mark in zip(names, marks, strict=True)]  # fmt: skip
    counts = Counter(level for level, _ in {(mark.level, _key(mark.remainder)) for mark in candidates if mark})
    several = {level for level, count in counts.items() if count > 1}
    followed = {_key(mark.remainder) for mark in candidates if mark and mark.level in several - {*BASELINE_WORDS}}
    levelled = [mark if mark is None or mark in marks or mark.level in several or _key(mark.remainder) not in followed
              else None for mark in candidates]  # fmt: skip
    levels = {mark.level for mark in levelled if mark and mark not in marks}
    return [mark or _at_level(of_file[0], levels) for of_file, mark in zip(names, levelled, strict=True)]


def _at_level(name: str, levels: Iterable[str]) -> _Mark | None:
    """Return what a name says that holds the occasion of others, as of an animal whose first one is missing."""
    for level in sorted(levels, key=len, reverse=True):
        hit = re.search(
            r"(?<![^\W_])" + r"[\W_]*".join(map(re.escape, words(level))) + r"(?![^\W_])", name, re.IGNORECASE
        )
        animal = (name[: hit.start()] + name[hit.end() :]).strip(" _-.") if hit else ""
        if animal:
            return _Mark(level, "", animal, 0)
    return None


def _occasion_beside(of_file: Sequence[str], called: Sequence[str]) -> _Mark | None:
    """Return what a name says beside that of an animal, which stands in the same folders; None without a word."""
    name, animal = (_NO_ANIMAL.sub(" ", text) for text in (of_file[0], called[-1]))
    last = r"\d" if animal.rstrip(" _-.")[-1:].isdigit() else r"[^\W\d_]"
    hit = re.search(r"(?<![^\W_])" + r"[\W_]*".join(map(re.escape, words(animal))) + f"(?!{last})", name, re.IGNORECASE)
    if hit is None or tuple(of_file[1:]) != tuple(called[:-1]):
        return None
    level = " ".join(re.sub(r"[\s_]+", " ", name[: hit.start()] + " " + name[hit.end() :]).strip(" -.,").split())
    level = re.sub(r"^[(\[]([^()\[\]]*)[)\]]$", r"\1", level)
    return _Mark(level.casefold(), "", hit[0], 0) if any(map(str.isalpha, level)) else None


def _of_first(name: str) -> _Mark | None:
    mark = _mark(name, 0)
    return mark if mark and _begins(mark.level) else None


def _without(of_file: Sequence[str], mark: _Mark | None) -> list[str]:
    """Return the names of a recording without its occasion."""
    return [mark.remainder if mark and place == mark.place else name for place, name in enumerate(of_file)]


def _mark(name: str, place: int) -> _Mark | None:
    """Return the one occasion of a name; of a word and a time the word."""
    hits = [*_NAMED.finditer(name)] or [*_TIMED.finditer(name)]
    if len(hits) != 1:
        return None
    hit = hits[0]
    unbracketed = re.sub(r"[(\[]\s*[)\]]", " ", name[: hit.start()] + " " + name[hit.end() :])
    remainder = re.sub(r"[ _]*\s[ _]*", " ", unbracketed).strip(" _")
    if hit.re is _NAMED:
        return _Mark(" ".join(words(hit[0])), "", remainder, place)
    unit, count = (hit[1] or hit[4]).casefold(), int(hit[2] or hit[3])
    animal_needed = len(unit) == 1  # D1 may be a dog; R3 D1 is not
    if animal_needed and not any(map(str.isdigit, words(remainder))):
        return None
    return _Mark(str(count), _UNIT_OF[unit], remainder, place)


def _subject(names: Sequence[str], above: bool = False) -> str:
    """Return the first name that has words; with the next `above` it."""
    plain = [_NO_ANIMAL.sub(" ", name) for name in names]
    speaking = [name.strip() for name in plain if words(name)]
    return plain_name(" ".join(speaking[1::-1] if above else speaking[:1])) if speaking else ""


def _key(subject: str) -> tuple[str, ...]:
    """Return the words of an animal's name in which spellings are alike: Rat 3, R03 and r3."""
    short = (word[0] if word in ANIMAL_WORDS else word for word in words(subject))
    return tuple(str(int(word)) if word.isdecimal() else word for word in short)


def _of_subjects(subjects: Sequence[str], levels: Sequence[str]) -> list[list[str]]:
    """Return the occasions of each animal."""
    pairs = grouped(zip(map(_key, subjects), levels, strict=True), lambda pair: pair[0])
    return [[level for _, level in of_subject if level] for of_subject in pairs.values()]


def _repeated(subjects: Sequence[str], levels: Sequence[str]) -> bool:
    return any(len(set(have)) < len(have) for have in _of_subjects(subjects, levels))


def _followed(subjects: Sequence[str], levels: Sequence[str]) -> bool:
    """Whether two animals or more have two occasions or more."""
    several = [have for have in _of_subjects(subjects, levels) if len(set(have)) > 1]
    return len(several) > 1 and len({*levels}) <= _MAX_OCCASIONS


def _begins(level: str) -> bool:
    return level in BASELINE_WORDS or level == "0"


def _complete(subjects: Sequence[str], levels: Sequence[str]) -> bool:
    """Whether most animals have all occasions, those aside that were recorded once, at the first one."""
    of_subjects, levels_used = _of_subjects(subjects, levels), {*filter(None, levels)}
    followed = [have for have in of_subjects if len(have) > 1 or not all(map(_begins, have))]
    return sum({*have} == levels_used for have in followed) >= _MIN_COMPLETE * len(followed)


def _unmarked(file: Path, mark: _Mark | None) -> Path:
    """Return a file as it would be called without its occasion."""
    path = Path(os.path.abspath(file))
    if mark is None:
        return path
    if mark.place == 0:
        return path.with_name(f"{mark.remainder or '_'}{path.suffix}")
    folders = [*path.parts]
    folders[-1 - mark.place : len(folders) - mark.place] = [mark.remainder] if mark.remainder else []
    return Path(*folders)
