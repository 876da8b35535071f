"""The animals that were read, and the work that a study is: the table that a person looks at before it runs."""

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from vasowave.study import folder as folders

if TYPE_CHECKING:
    from vasowave.study.animal.animal import Animal
    from vasowave.study.folder.settings import StudyFile

_LINEAR_SECONDS, _LAW_SECONDS, _START_SECONDS = 0.8, 2.6, 0.02
"""CPU for a fit of the linear law and of another in a network of 21 vessels, everything else of the analysis included,
and for each start, s: one tree leads all starts. Of virtual mice 0.7 and 2, with twenty starts 0.9 and 2.5; of three
mice of the demo both laws take 3.7 to 7.2."""

_RAW_SECONDS = 0.4
"""CPU for reading a continuous recording, s."""

_POSTERIOR_SECONDS = 6.0
"""CPU for one posterior of a wall law in such a network, s: 3 to 4 of the linear law, 7 to 8 of others."""

_PAGE_SECONDS, _CYCLE_DRAWN, _RAW_DRAWN = 4.0, 2.0, 3.7
"""CPU for the report, and for each animal in it, s: six cycles take 16, the twelve recordings of the demo 48."""

_BEGIN_SECONDS = 5.0
"""Until the processes of a run have read the program and its kernels, s."""

_TIMED_VESSELS = 21  # of the network for which the seconds were measured


class AnimalRead(NamedTuple):
    """The content of the files of one animal.

    `duration` (s) and `beats` (averaged, found) are those of a continuous recording; 0 of an averaged cycle. Heart rate
    in beats/min, mean pressure in mmHg, mean flow in ml/s; `drift` in mmHg over the recording.
    """

    animal: str
    group: str
    vessels: int
    kind: str
    duration: float
    beats: tuple[int, int]
    heart_rate: float
    mean_pressure: float
    mean_flow: float
    drift: float

    def row(self) -> tuple[str, ...]:
        """Return the cells of `HEADER`."""
        raw = self.kind == "raw"
        return (
            self.animal, self.group, f"{self.vessels}", "raw" if raw else "cycle",
            f"{self.duration:.3g}" if raw else "", f"{self.beats[0]}/{self.beats[1]}" if raw else "",
            f"{self.heart_rate:.0f}", f"{self.mean_pressure:.1f}", f"{self.mean_flow:.3f}",
            f"{self.drift:+.1f}" if raw else "",
        )  # fmt: skip


HEADER = (
    ("animal", ""), ("group", ""), ("vessels", ""), ("kind", ""), ("length", "s"), ("beats", "used"), ("HR", "1/min"),
    ("mPAP", "mmHg"), ("CO", "ml/s"), ("drift", "mmHg"),
)  # fmt: skip
"""Titles of the columns, and below them units."""

_WORD_COLUMNS = (0, 1, 3)  # columns of words


def read_of(animal: "Animal") -> AnimalRead:
    """Return what was read of an animal."""
    indices, beats, raw = animal.recording.indices(), animal.beats, animal.raw
    used = (sum(beat.averaged for beat in beats.beats), len(beats.beats)) if beats else (0, 0)
    return AnimalRead(
        animal.name, animal.group, len(animal.network), "raw" if raw else "cycle", raw.duration if raw else 0.0, used,
        indices["HR"], indices["mPAP"], indices["CO"], beats.baseline.size if beats and beats.baseline.sure else 0.0,
    )  # fmt: skip


def overview_lines(rows: Sequence[Sequence[str]], width: int) -> list[str]:
    """Return a table of the rows of what was read in lines of at most `width` characters.

    Where a table does not fit, every animal has a paragraph.
    """
    lines = aligned([*zip(*HEADER, strict=True), *rows], _WORD_COLUMNS)
    widest = max(map(len, lines))
    if widest <= width:
        return [*lines[:2], "-" * widest, *lines[2:], ""]
    return [line for row in rows for line in _paragraph(row, width)] + [""]


def aligned(rows: Sequence[Sequence[str]], left_aligned: Sequence[int]) -> list[str]:
    """Return rows of cells as lines; the columns in `left_aligned` are aligned there, the others on the right."""
    columns = []
    for i, column in enumerate(zip(*rows, strict=True)):
        size = max(map(len, column))
        columns.append([cell.ljust(size) if i in left_aligned else cell.rjust(size) for cell in column])
    return ["  ".join(row).rstrip() for row in zip(*columns, strict=True)]


def _paragraph(row: Sequence[str], width: int) -> list[str]:
    animal, group, *cells = row
    facts = [f"{title} {cell}{f' {unit}' if unit not in ('', 'used') else ''}"
             for (title, unit), cell in zip(HEADER[2:], cells, strict=True) if cell]  # fmt: skip
    facts = [fact.replace(" ", "\N{NO-BREAK SPACE}") for fact in facts]
    lines = textwrap.wrap(f"{animal} ({group}): {', '.join(facts)}", width, subsequent_indent="  ",
                          break_long_words=False, break_on_hyphens=False)  # fmt: skip
    return [line.replace("\N{NO-BREAK SPACE}", " ") for line in lines]


def expected_seconds(read: Sequence[AnimalRead], settings: "StudyFile", cores: int) -> float:
    """Return roughly how long a run of these animals with its report takes on so many cores, s, without compiling."""
    analysis = folders.animal_settings(settings)
    of_laws = sum(_LINEAR_SECONDS if wall == "linear" else _LAW_SECONDS for wall in analysis.walls)
    of_laws += _START_SECONDS * analysis.starts * len(analysis.walls)
    of_laws += _POSTERIOR_SECONDS * len(analysis.sampled_walls)
    drawn = sum(_RAW_SECONDS + _RAW_DRAWN if animal.kind == "raw" else _CYCLE_DRAWN for animal in read)
    parallel = drawn + sum(of_laws * animal.vessels / _TIMED_VESSELS for animal in read)
    return _BEGIN_SECONDS + _PAGE_SECONDS + parallel / max(1, min(cores, len(read)))
