"""At which part of the breath the pressures of a study's recordings are averaged, and whether that is the same one."""

from collections.abc import Mapping

from vasowave.base.cures import AVERAGE_BREATHS
from vasowave.base.findings import Finding, look_kind
from vasowave.catheter.baseline.ventilation import BREATH_MOVES, BREATH_MOVES_FLOW, NO_PLATEAU
from vasowave.catheter.beats.rejection import OVER_BREATHS
from vasowave.pulse.cycle.cycle import Recording
from vasowave.study.cohort.effects import grouped
from vasowave.study.report.wording import listed, some_of

DIFFERENT_BREATHS = look_kind(
    "check.breaths-differ",
    "mean pressures are those of different parts of the breath: {places}. That alone makes them differ by up to "
    "{size:.2g} mmHg{subjects}",
    "Average all recordings over the breath.",
    AVERAGE_BREATHS,
)
_PLACES = {0: "over whole breaths", -1: "at the lower end", 1: "at the upper end"}
_MAX_NAMES = 3  # recordings, in a sentence


def different_breaths(recordings: Mapping[str, Recording], subjects: Mapping[str, str]) -> list[Finding]:
    """Return a finding if the pressures of recordings, by their names, stand at different parts of the breath.

    Only breaths that move a mean count; `subjects` is the animal of each recording, where it has several.
    """
    offsets = {name: offset for name, recording in recordings.items() if (offset := _offset(recording)) is not None}
    places = {name: (offset > 0) - (offset < 0) for name, offset in offsets.items()}
    if len({*places.values()}) < 2:
        return []
    at_places = [f"{phrase} of {some_of([name for name in places if places[name] == place], _MAX_NAMES)}"
                 for place, phrase in _PLACES.items() if place in places.values()]  # fmt: skip
    of_subjects = grouped(places, lambda name: subjects.get(name, name))
    torn = [subject for subject, names in of_subjects.items() if len({places[name] for name in names}) > 1]
    paired = f", also between recordings of one animal ({some_of(torn, _MAX_NAMES)})" if torn else ""
    size = max(offsets.values()) - min(offsets.values())
    return [DIFFERENT_BREATHS(places=listed(at_places), size=size, subjects=paired)]


def _offset(recording: Recording) -> float | None:
    """Return how far the mean pressure stands above that over whole breaths, mmHg; None where no breath moves it."""
    values = {note.code: dict(note.values) for note in recording.notes}
    for code in (BREATH_MOVES.code, BREATH_MOVES_FLOW.code):
        if code in values:
            return float(values[code]["pressure"]) - float(values[code]["breath_pressure"])
    return 0.0 if {NO_PLATEAU.code, OVER_BREATHS.code} & {*values} else None
