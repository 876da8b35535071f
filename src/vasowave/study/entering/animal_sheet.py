"""A lab's own table of animals (ID, treatment, weight, sex): told from recordings, and its cells brought to rows."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from vasowave.base.errors import InputError
from vasowave.base.io.cells import GAPS
from vasowave.base.io.columns import Columns, number, read_columns, split_unit
from vasowave.catheter.read.subject_rows import sample_columns
from vasowave.catheter.signals.signal import ALIASES
from vasowave.study.cohort.variables import without_case
from vasowave.study.entering.grouping import is_reference, within, words
from vasowave.study.folder.animal_columns import COLUMNS, FILES, REQUIRED_COLUMNS
from vasowave.study.folder.animals import columns_of
from vasowave.study.folder.names import checked_name
from vasowave.study.folder.synonyms import Understood, resembling_column, understood_title

ANIMAL_WORDS = ("animal", "subject", "mouse", "rat", "pig", "rabbit", "dog", "tier", "maus", "ratte", "souris")
"""What titles call an animal."""
_ID_TITLES = ("animal id", "id", "animal no", "animal nr", "animal number", "name", *ANIMAL_WORDS)
_GROUP_TITLES = ("group", "treatment", "gruppe", "groupe", "grupo")
_MAX_GROUPS = 10  # of a table of animals: a column of more words names no groups


@dataclass(frozen=True)
class AnimalSheet:
    """The animals of a table, by the ID that it gives each, with the cells that a study's table takes.

    Attributes
    ----------
    file : Path
    rows : dict of str to dict of str to str
    passed_over : tuple of str
        Titles of columns that a study's table cannot have.
    taken : tuple of str
        What columns of other titles or units were taken for.
    """

    file: Path
    rows: Mapping[str, Mapping[str, str]]
    passed_over: tuple[str, ...] = ()
    taken: tuple[str, ...] = ()

    @property
    def groups(self) -> list[str]:
        """The groups that its animals are of, the reference first."""
        labels = dict.fromkeys(filter(None, (row.get("group", "") for row in self.rows.values())))
        return sorted(labels, key=lambda label: not is_reference(label))

    def row_of(self, names: Sequence[str]) -> Mapping[str, str]:
        """Return the cells of the animal that `animal_of` tells."""
        return self.rows.get(self.animal_of(names)[0], {})

    def animal_of(self, names: Sequence[str]) -> tuple[str, str]:
        """Return the ID that stands in the first name that has any, the longest, and that name; empty if two do.

        Names are those of the file and its folders, from within; a bare number counts in the first two.
        Where none does, ``Rat 8`` is the animal ``R08``, whose word for an animal begins alike; ``run 8`` is not.
        """
        for stands_in in (within, _begins_alike):
            for place, name in enumerate(names):
                hits = {key: len(words(key)) for key in self.rows
                        if stands_in(words(key), words(name)) and (place < 2 or not key.isdecimal())}  # fmt: skip
                best = [key for key, size in hits.items() if size == max(hits.values())]
                if best:
                    return (best[0], name) if len(best) == 1 else ("", "")
        return "", ""

    def guesses(self, rows: Iterable[Sequence[str]]) -> dict[str, str]:
        """Return the names that hold no ID as it is written, with the animal that they are taken for."""
        pairs = dict.fromkeys((name, key) for key, name in map(self.animal_of, rows) if key)
        return {name: key for name, key in pairs if not within(words(key), words(name))}


def _begins_alike(phrase: Sequence[str], many: Sequence[str]) -> bool:
    """Whether words with a number stand in `many`, a word for an animal shortened, the number with other zeros."""

    def alike(word: str, other_word: str) -> bool:
        if word.isdigit() and other_word.isdigit():
            return int(word) == int(other_word)
        short, long = sorted((word, other_word), key=len)
        return word == other_word or (long in ANIMAL_WORDS and not short.isdigit() and long.startswith(short))

    pieces = (many[i : i + len(phrase)] for i in range(len(many) - len(phrase) + 1))
    return any(map(str.isdigit, phrase)) and any(all(map(alike, phrase, piece)) for piece in pieces)


def animal_sheet(file: Path) -> AnimalSheet | None:
    """Return the table of animals that a file is, None if it is something else."""
    try:
        table = read_columns(file)
    except InputError:
        return None
    plain = [" ".join(words(name)) for name in table.names]
    column = next((plain.index(title) for title in _ID_TITLES if title in plain), None)
    if (
        column is None
        or len(plain) < 2
        or sample_columns(table)
        or {"pressure", "flow"} <= {ALIASES.get(title, title) for title in plain}
    ):
        return None
    keys = [row[column].strip() for row in table.cells]
    if not all(keys) or len(set(keys)) < len(keys):
        return None
    table, taken = _with_our_titles(table)
    titles, passed_over = _titles(file, table.names, table.units, column)
    rows = {key: {title: row[i].strip() for i, title in titles.items()} for key, row in zip(keys, table.cells)}
    rows, unified = _unified_groups(rows)
    group_words = {row["group"] for row in rows.values() if row.get("group")}
    if len(group_words) > _MAX_GROUPS or not all(map(_is_name, group_words)):
        rows = {key: {title: text for title, text in row.items() if title != "group"} for key, row in rows.items()}
        passed_over = (*passed_over, "group")
    alike = [f"'{title}' stays a column of your own, not {resembling}" for title in titles.values()
             if title not in COLUMNS and (resembling := resembling_column(title))]  # fmt: skip
    return AnimalSheet(file, rows, passed_over, (*taken, *alike, *unified))


def _unified_groups(rows: Mapping[str, Mapping[str, str]]) -> tuple[dict[str, dict[str, str]], list[str]]:
    """Return rows whose groups are spelled alike where only capitals or spaces differ, and what to say of it."""
    counts = Counter(row["group"] for row in rows.values() if row.get("group"))
    spellings: dict[str, str] = {}
    for word, _ in counts.most_common():
        spellings.setdefault(without_case(word), word)
    usual = {word: spellings[without_case(word)] for word in counts}
    remarks = [f"the group '{word}' was taken for '{common}'" for word, common in usual.items() if word != common]
    return {key: {**row, **({"group": usual[row["group"]]} if row.get("group") else {})}
            for key, row in rows.items()}, remarks  # fmt: skip


def _with_our_titles(table: Columns) -> tuple[Columns, tuple[str, ...]]:
    """Return a table whose columns of other titles or units are called as a study calls them, and what to say."""
    written = [title.strip() for title in table.titles or table.names]
    names, unit_names, cells = ([*row] for row in (table.names, table.units, zip(*table.cells, strict=True)))
    pairs = [*zip(names, unit_names, strict=True)]
    meant = {i: understood_title(*pair, cells[i]) for i, pair in enumerate(pairs)}
    remarks, used = [], set[str]()
    exact = [column is not None and pairs[i][0] == split_unit(column.column)[0] for i, column in meant.items()]
    for i, column in sorted(meant.items(), key=lambda entry: not exact[entry[0]]):
        if column is None or column.column in used:  # of 'wedge' and 'LAP' the first
            continue
        used.add(column.column)
        names[i], unit_names[i] = split_unit(column.column)
        if pairs[i] != (names[i], unit_names[i]):
            remarks.append(f"'{written[i]}' was taken for {column}")
        cells[i] = tuple(_converted(text, column) for text in cells[i])
    rows = tuple(zip(*cells, strict=True))
    return replace(table, names=tuple(names), units=tuple(unit_names), cells=rows), tuple(remarks)


def _converted(text: str, column: Understood) -> str:
    """Return the text of a number in a column's unit; other text as it is, but for words for no number."""
    if text.strip().upper() in GAPS:
        return ""
    unchanged = (column.factor, column.offset) == (1, 0)
    try:
        value = number(text)
    except ValueError:  # which is refused: who mends it must know that it is in another unit
        offset = f" plus {column.offset:.4g}" if column.offset else ""
        return text if unchanged else f"{text} times {column.factor:.4g}{offset}"
    return text if unchanged else f"{column.factor * value + column.offset:.12g}"


def _titles(
    file: Path, names: Sequence[str], unit_names: Sequence[str], key: int
) -> tuple[dict[int, str], tuple[str, ...]]:
    """Return the columns that a study's table can have, by their place, and the titles of the others."""
    titles: dict[int, str] = {}
    passed_over = []
    plain = [name.strip().casefold() for name in names]
    group = next((plain.index(title) for title in _GROUP_TITLES if title in plain), None)
    standard = {column.casefold(): column for column in COLUMNS}
    for i, (name, unit) in enumerate(zip(names, unit_names, strict=True)):
        title = "group" if i == group else f"{name.strip()} [{unit}]" if unit else name.strip()
        if i == key or not title or title.casefold() in (*FILES, "animal"):
            continue
        if i != group and any(p.error for p in columns_of(file, [*REQUIRED_COLUMNS, title])[2]):
            passed_over.append(title)
        else:
            titles[i] = standard.get(title.casefold(), title)
    return titles, tuple(passed_over)


def _is_name(text: str) -> bool:
    try:
        return checked_name(text) == text
    except InputError:
        return False
