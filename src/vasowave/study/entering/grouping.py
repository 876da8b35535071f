"""The group of a study to which a recording belongs, told by the names of files and folders, or proposed from them."""

import os
import re
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import NamedTuple

from vasowave.base.errors import InputError
from vasowave.study.folder.names import checked_name

_PLAIN = re.compile(r"[^\W\d_]+|\d+")
_WORD = re.compile(rf"[^\W_]+[+-]{{2,}}+(?![^\W_])|{_PLAIN.pattern}")
"""A genotype (Bmpr2+-), letters, or a number."""
_WILD_TYPE = "++"
_BETWEEN_MARKS = re.compile(r"(?:(?<=[+-]{2})|(?<![+-]))\+(?=\s*[^\W_])")  # not within a genotype
_REFERENCE = ("ctl", "ctrl", "control", "controls", "con", "wt", "wildtype", "wild", "sham", "normoxia", "normoxic",
              "normoxie", "nox", "nx", "veh", "vehicle", "placebo", "saline", "healthy", "naive", "baseline",
              "untreated", "kontrolle", "kontroll", "gesund", "contrôle", "controle", "témoin", "temoin",
              "controllo")  # fmt: skip
"""What groups are called that others are compared with."""

_NO_GROUP = ("m", "f", "male", "female", "mouse", "mice", "rat", "animal", "rec", "recording", "recordings", "data",
             "raw", "day", "week", "left", "right", "copy", "export", "labchart")  # fmt: skip
_MAX_GROUPS = 6  # groups that are proposed

Marks = Mapping[str, Sequence[str]]
"""Labels of groups, and what names that belong to them hold."""


class Proposal(NamedTuple):
    """Groups that names speak of, the reference first.

    Attributes
    ----------
    marks : dict of str to tuple of str
        Label, and the word that names hold.
    sizes : dict of str to int
        How many files each would have.
    where : str
        What the words are: ``names begin with``, ``folders are called`` …
    """

    marks: dict[str, tuple[str, ...]]
    sizes: dict[str, int]
    where: str

    def __str__(self) -> str:
        """Return the groups and their sizes in words."""
        *first, last = (f"{label} ({size} of them)" for label, size in self.sizes.items())
        return f"{self.where} {', '.join(first)} and {last}"


def words(name: str) -> list[str]:
    """Return words, numbers and genotypes of a name, in lower case: ``p_C6`` is p, c, 6; ``Bmpr2+-_1`` bmpr2+-, 1."""
    return [word.casefold() for word in _WORD.findall(name)]


def _plain_words(name: str) -> list[str]:
    """Return words and numbers of a name in which signs part them."""
    return [word.casefold() for word in _PLAIN.findall(name)]


def within(phrase: Sequence[str], many: Sequence[str]) -> bool:
    """Whether the words of `phrase` stand in `many`, in one piece; a label may be the beginning of a word."""
    size = len(phrase)
    return size > 0 and any(list(many[i : i + size]) == list(phrase) for i in range(len(many) - size + 1))


def told_group(file: Path, folder: Path, marks: Marks) -> str:
    """Return the group by which a file is named, or else the innermost folder that is; empty if none or two are.

    Folders that hold the study (`folder`) too say nothing: they hold all groups.
    """
    for name, reading in product(path_names(file, folder), (words, _plain_words)):
        name_words = reading(name)
        hits = {
            label: max(map(len, fit))
            for label, label_marks in marks.items()
            if (fit := _fitting(label_marks, name_words))
        }
        longest = max(hits.values(), default=0)
        best = [label for label, size in hits.items() if size == longest]
        if len(hits) == 1 or (hits and len(best) == 1 and _nested(best[0], hits, marks, name_words)):
            wild = reading is _plain_words and any(word.endswith(_WILD_TYPE) for word in words(name))
            return "" if wild and not is_reference(best[0]) else best[0]
        if hits:
            return ""
    return ""


def proposed_groups(files: Sequence[Path], folder: Path) -> Proposal | None:
    """Return the groups that the names of files, or of their folders, speak of; None if they do not.

    Some, two or more, words of the same place in every name share the files among them, each in the mean two or more.
    Words that tell the group of every file come before those that leave some in doubt (LE in ``LE pig``, beside pig).
    """
    stems = [_letters(file.stem) for file in files]
    folders = [path_names(file, folder)[1:] for file in files]
    shortest, depth = min(map(len, stems), default=0), min(map(len, folders), default=0)
    sources = [("names begin with" if i == 0 else "names hold", [stem[i] for stem in stems]) for i in range(shortest)]
    sources += [("folders are called", [names[i] for names in folders]) for i in range(depth)]
    sources += [("names end with", [stem[-1] for stem in stems])] if shortest else []
    good = [(where, group_words) for where, group_words in sources if _shares(group_words)]
    good.sort(key=lambda source: not any(is_reference(word) for word in source[1]))
    proposals = [_proposal(*source) for source in good]
    sure = [proposal for proposal in proposals if all(told_group(file, folder, proposal.marks) for file in files)]
    return next(iter([*sure, *proposals]), None)


def parsed_groups(text: str) -> dict[str, tuple[str, ...]]:
    """Return labels and marks of ``WT,HOX`` or ``control=WT,hypoxic=HOX+SUHX``.

    Raises
    ------
    InputError
        A label that cannot be one, or one that stands twice.
    """
    marks: dict[str, tuple[str, ...]] = {}
    for entry in text.split(","):
        label, separator, mark_text = entry.partition("=")
        name = checked_name(label.strip())
        if name in marks:
            raise InputError(f"group '{name}' stands twice in '{text}'; keep one")
        marks[name] = tuple(mark.strip() for mark in _BETWEEN_MARKS.split(mark_text)) if separator else (name,)
    return marks


def path_names(file: Path, folder: Path) -> list[str]:
    """Return the stem of a file and the names of its folders, from within, up to those that hold the study too."""
    place, root = Path(os.path.abspath(file)), Path(os.path.abspath(folder))
    shared = {root, *root.parents}
    return [place.stem, *(parent.name for parent in place.parents if parent not in shared)]


def _fitting(marks: Sequence[str], name_words: Sequence[str]) -> list[list[str]]:
    return [words(mark) for mark in marks if within(words(mark), name_words)]


def _nested(best: str, hits: Mapping[str, int], marks: Marks, name_words: Sequence[str]) -> bool:
    """Whether all that fits is a part of what fits best: ``HOX`` in ``HOX Su``."""
    longest = max(_fitting(marks[best], name_words), key=len)
    return all(within(phrase, longest) for label in hits for phrase in _fitting(marks[label], name_words))


def _letters(stem: str) -> list[str]:
    return [word for word in _WORD.findall(stem) if not word.isdigit()]


def _shares(group_words: Sequence[str]) -> bool:
    """Whether words share the files among them as groups do."""
    kinds = {word.casefold() for word in group_words}
    if not all(_letters(word) for word in group_words) or any(
        set(words(word)) & set(_NO_GROUP) for word in group_words
    ):
        return False
    return 2 <= len(kinds) <= min(_MAX_GROUPS, (len(group_words) + 1) // 2)


def is_reference(word: str) -> bool:
    """Whether a word names a group that others are compared with, as ctl, wt, sham or Bmpr2++ do."""
    return word.endswith(_WILD_TYPE) or bool(set(words(word)) & set(_REFERENCE))


def _proposal(where: str, group_words: Sequence[str]) -> Proposal:
    first = {word.casefold(): word for word in reversed(group_words)}
    sizes = {
        first[kind]: sum(word.casefold() == kind for word in group_words)
        for kind in dict.fromkeys(map(str.casefold, group_words))
    }
    order = sorted(sizes, key=lambda label: not is_reference(label))
    labels = {label: checked_name(" ".join(re.sub(r"[^\w .,+()-]", " ", label).split())) for label in order}
    return Proposal(
        {labels[label]: (label,) for label in order}, {labels[label]: sizes[label] for label in order}, where
    )


def regrouped(rows: Sequence[dict[str, str]], marks: Marks, folder: Path) -> list[str]:
    """Write the groups that names of recordings tell into rows of no such group; return the animals.

    Parameters
    ----------
    rows : sequence of dict
        Of a study's table of animals; they are changed.
    marks : mapping
        The labels of the groups, and what names that belong to them hold.
    folder : Path
        Of the study.
    """
    changed = []
    for row in rows:
        label = told_group(folder / row["recording"], folder, marks) if row.get("recording") else ""
        if label and row.get("group") not in marks:
            row["group"] = label
            changed.append(row["animal"])
    return changed
