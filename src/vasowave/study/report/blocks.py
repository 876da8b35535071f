"""The parts of a report, before it is a page or a PDF: sections of sentences, tables, figures and warnings."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

import pandas as pd

from vasowave.study.figures.matplotlib_style import style
from vasowave.study.figures.rendering import lettered, svg
from vasowave.study.report.wording import Row, table_rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Item = TypeVar("Item")
REPORT, SUPPLEMENT = "report", "supplement"
"""Names of the two documents, and of their files."""


@dataclass(frozen=True)
class Paragraph:
    """One paragraph of text."""

    text: str


@dataclass(frozen=True)
class Heading:
    """A heading below that of the section."""

    text: str


@dataclass(frozen=True)
class Bullets:
    """A list of sentences."""

    items: Sequence[str]


@dataclass(frozen=True)
class Answers:
    """Questions, each with its answer in one sentence or two."""

    items: Sequence[tuple[str, str]]


@dataclass(frozen=True)
class Notice:
    """Problems that must be considered, set apart as an alarm."""

    title: str
    items: Sequence[str]


@dataclass(frozen=True)
class Remarks:
    """Remarks that are good to know, set apart quietly."""

    title: str
    items: Sequence[str]


@dataclass(frozen=True, eq=False)
class Table:
    """A table of text cells; the first column names the rows."""

    name: str
    """Of its files; empty for a table that gets none."""
    caption: str
    header: Row
    rows: Sequence[Row]
    note: str = ""
    """What marks and abbreviations mean."""
    data: pd.DataFrame | None = None
    """The same in full precision, units in the column names."""

    @classmethod
    def from_frame(cls, name: str, caption: str, data: pd.DataFrame, note: str = "", digits: int = 3) -> "Table":
        """Return the table of a data frame, its numbers written as people do."""
        return cls(name, caption, *table_rows(data, digits), note, data)

    @classmethod
    def from_items(
        cls, name: str, caption: str, items: Iterable[Item], columns: Mapping[str, Callable[[Item], str]],
        note: str = "", data: pd.DataFrame | None = None,
    ) -> "Table":  # fmt: skip
        """Return the table with a row for each item; by the title of each column what writes its cell."""
        rows = [tuple(cell(item) for cell in columns.values()) for item in items]
        return cls(name, caption, tuple(columns), rows, note, data)

    def hiding(self, *columns: str) -> "Table":
        """Return the table without columns on the page; its data keep them."""
        visible = [place for place, cell in enumerate(self.header) if cell not in columns]
        rows = [tuple(row[place] for place in visible) for row in self.rows]
        return replace(self, header=tuple(self.header[place] for place in visible), rows=rows)


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure, or what makes it, with its caption; it is drawn once, whoever asks, perhaps in another process.

    A page shows `narrow` in its place on a phone.
    """

    name: str
    caption: str
    figure: "Figure | Callable[[], Figure]"
    narrow: "Figure | None" = None

    @cached_property
    def svg(self) -> str:
        """The figure as SVG text, its panels lettered."""
        return drawn(self.figure)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height, in."""
        return size_of(self.svg)

    def keep(self, text: str) -> None:
        """Take what another process drew for `svg`."""
        self.__dict__["svg"] = text


def drawn(figure: "Figure | Callable[[], Figure]") -> str:
    """Return a figure as SVG text, its panels lettered."""
    with style():
        made = figure() if callable(figure) else figure
    lettered(made)
    return svg(made)


def size_of(text: str) -> tuple[float, float]:
    """Return width and height of SVG text, in."""
    width, height = re.findall(r'(?:width|height)="([\d.]+)pt"', text[text.index("<svg") :])[:2]
    return float(width) / 72, float(height) / 72


@dataclass(frozen=True)
class RotatingView:
    """Networks that a page turns in space, where scripts run; paper and a page without scripts have their figures."""

    name: str
    caption: str
    data: dict[str, Any]
    """What ``space.js`` draws, as JSON writes it."""


@dataclass(frozen=True)
class Fold:
    """Blocks that a page shows when asked for, and paper always."""

    title: str
    blocks: Sequence["Block"]


@dataclass(frozen=True)
class OnScreen:
    """Blocks that a page shows and paper leaves out; they are the page's alone, or files hold the same."""

    blocks: Sequence["Block"]


@dataclass(frozen=True)
class SideBySide:
    """Blocks side by side where there is room, else one after the other."""

    left: Sequence["Block"]
    right: Sequence["Block"]

    @property
    def blocks(self) -> Sequence["Block"]:
        """All of them in order."""
        return [*self.left, *self.right]


Block = (
    Paragraph
    | Heading
    | Bullets
    | Answers
    | Notice
    | Remarks
    | Table
    | Drawing
    | RotatingView
    | Fold
    | OnScreen
    | SideBySide
)


@dataclass(frozen=True, eq=False)
class Section:
    """A section, with the name that links lead to."""

    name: str
    title: str
    blocks: Sequence[Block]


@dataclass(frozen=True, eq=False)
class Report:
    """A whole document."""

    name: str
    """Of its files, and of the template of its page."""
    title: str
    subtitle: str
    synthetic: str
    """In words what was not measured, empty if all was."""
    sections: Sequence[Section]
    provenance: dict[str, str] = field(default_factory=dict)
    records: dict[str, pd.DataFrame] = field(default_factory=dict)
    """Tables that become files only."""
    glossary: dict[str, str] = field(default_factory=dict)
    """Symbol to meaning."""
    animals: Mapping[str, str] = field(default_factory=dict)
    """Of every recording by name the animal that it is of, which a reader may pick."""

    def tables(self) -> list[Table]:
        """Return all tables that have files."""
        return [block for block in self._blocks() if isinstance(block, Table) and block.name]

    def drawings(self) -> list[Drawing]:
        """Return all figures."""
        return [block for block in self._blocks() if isinstance(block, Drawing)]

    def answers(self) -> list[tuple[str, str]]:
        """Return all questions with their answers."""
        return [item for block in self._blocks() if isinstance(block, Answers) for item in block.items]

    def spaces(self) -> list[RotatingView]:
        """Return what turns in space."""
        return [block for block in self._blocks() if isinstance(block, RotatingView)]

    def _blocks(self) -> Iterator[Block]:
        for section in self.sections:
            yield from _unfolded(section.blocks)


def _unfolded(blocks: Sequence[Block]) -> Iterator[Block]:
    for block in blocks:
        yield block
        if isinstance(block, Fold | OnScreen | SideBySide):
            yield from _unfolded(block.blocks)
