"""At which part of the breath the pressures of a study's recordings are averaged, and whether that is the same one."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from vasowave.base.cures import AVERAGE_BREATHS
from vasowave.base.findings import look_kind
from vasowave.catheter.baseline.ventilation import BREATH_MOVES, BREATH_MOVES_FLOW, NO_PLATEAU
from vasowave.catheter.beats.rejection import OVER_BREATHS
from vasowave.pulse.cycle.cycle import Recording
from vasowave.study.folder.problems import StudyProblem
from vasowave.study.folder.rows import AnimalRow
from vasowave.study.folder.study import Study
from vasowave.study.report.wording import listed, some_of

DIFFERENT_BREATHS = look_kind(
    "check.breaths-differ",
    "mean pressures are those of different parts of the breath: {places}. That alone makes them differ by up to "
    "{size:.2g} mmHg{subjects}",
    "Average all recordings over the breath.",
    AVERAGE_BREATHS,
)
_PLACES = {-1: "at the lower end", 0: "over whole breaths", 1: "at the upper end"}
_MAX_NAMES = 3  # recordings, in a sentence


def different_breaths(study: Study, animals: Sequence[tuple[AnimalRow, Recording]]) -> list[StudyProblem]:
    """Return what is to be said where recordings are averaged at different parts of the breath."""
    offsets = [(row, offset) for row, recording in animals if (offset := _offset(recording)) is not None]
    rows_at = {place: [row for row, offset in offsets if np.sign(offset) == place] for place in _PLACES}
    places = [f"{phrase} of {some_of([row.animal for row in rows_at[place]], _MAX_NAMES)}"
              for place, phrase in _PLACES.items() if rows_at[place]]  # fmt: skip
    if len(places) < 2:
        return []
    column = study.settings.design.subject or ""
    counts = Counter(subject for rows in rows_at.values() for subject in {row.lab_cells.get(column) for row in rows})
    torn = some_of([subject for subject, count in counts.items() if subject and count > 1], _MAX_NAMES)
    paired = f", also between recordings of one animal ({torn})" if torn else ""
    size = float(np.ptp([offset for _, offset in offsets]))
    finding = DIFFERENT_BREATHS(places=listed(places), size=size, subjects=paired)
    return [StudyProblem(finding.at(str(study.table), part="column 'recording'"))]


def _offset(recording: Recording) -> float | None:
    """Return how far the mean pressure stands above that over whole breaths, mmHg; None where no breath moves it."""
    values = {note.code: dict(note.values) for note in recording.notes}
    if {NO_PLATEAU.code, OVER_BREATHS.code} & {*values}:
        return 0.0
    moved = values.get(BREATH_MOVES.code) or values.get(BREATH_MOVES_FLOW.code)
    return float(moved["pressure"]) - float(moved["breath_pressure"]) if moved else None
