"""At which part of the breath the pressures of a study's recordings are averaged, and whether that is the same one."""

from collections import Counter
from collections.abc import Mapping

import numpy as np

from vasowave.base.cures import AVERAGE_BREATHS
from vasowave.base.findings import Finding, look_kind
from vasowave.catheter.baseline.ventilation import BREATH_MOVES, BREATH_MOVES_FLOW, NO_PLATEAU
from vasowave.catheter.beats.rejection import OVER_BREATHS
from vasowave.pulse.cycle.cycle import Recording
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


def different_breaths(recordings: Mapping[str, Recording], subjects: Mapping[str, str]) -> list[Finding]:
    """Return a finding if recordings, by their names, and their animals are averaged at different parts of breaths."""
    offsets = {name: offset for name, cycle in recordings.items() if (offset := _offset(cycle)) is not None}
    named = {place: [name for name, offset in offsets.items() if np.sign(offset) == place] for place in _PLACES}
    named = {place: names for place, names in named.items() if names}
    if len(named) < 2:
        return []
    places = listed([f"{_PLACES[place]} of {some_of(names, _MAX_NAMES)}" for place, names in named.items()])
    counts = Counter(subject for names in named.values() for subject in {subjects[name] for name in names})
    torn = some_of([subject for subject, count in counts.items() if count > 1], _MAX_NAMES)
    paired = f", also between recordings of one animal ({torn})" if torn else ""
    return [DIFFERENT_BREATHS(places=places, size=max(offsets.values()) - min(offsets.values()), subjects=paired)]


def _offset(recording: Recording) -> float | None:
    """Return how far the mean pressure stands above that over whole breaths, mmHg; None where no breath moves it."""
    values = {note.code: dict(note.values) for note in recording.notes}
    moved = values.get(BREATH_MOVES.code) or values.get(BREATH_MOVES_FLOW.code)
    if moved:
        return float(moved["pressure"]) - float(moved["breath_pressure"])
    return 0.0 if {NO_PLATEAU.code, OVER_BREATHS.code} & {*values} else None
