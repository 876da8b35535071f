"""What the Recording desk can change: the stretch, zero and gains of an animal's row, and the file of its beats."""

import os
from dataclasses import field
from typing import TYPE_CHECKING, Annotated, Literal

from annotated_types import Ge, Gt, MaxLen, MinLen

from vasowave.errors import InputError
from vasowave.io.files import made_inside, write_file
from vasowave.recording import read_edits
from vasowave.recording.edits import BeatEdit, edits_text
from vasowave.settings import settings_class
from vasowave.study.table import read_rows
from vasowave.workbench.cells import set_cells, write_cells
from vasowave.workbench.recordings import edits_file, mean_between, row_of

if TYPE_CHECKING:
    from vasowave.workbench.actions import Workplace

Name = Annotated[str, MinLen(1), MaxLen(500)]
_Time = Annotated[float, Ge(0)]
_APART = 0.01  # of what was read: two points of calibration nearer to each other than this tell no gain
_SAME = 1e-3  # s between two times that mean the same beat


@settings_class
class SetStretch:
    """Average the beats of one stretch alone, s; nothing given is the whole recording."""

    animal: Name
    start: Annotated[float, Ge(0)] | None = None
    end: Annotated[float, Ge(0)] | None = None

    def do(self, at: "Workplace") -> str:
        """Do it."""
        written = ("" if one is None else f"{one:.10g}" for one in (self.start, self.end))
        return set_cells(at.desk, self.animal, dict(zip(("start [s]", "end [s]"), written, strict=True)), {})


@settings_class
class SetZero:
    """Take the mean pressure of a stretch for the transducer's zero; without a stretch, none."""

    animal: Name
    start: Annotated[float, Ge(0)] | None = None
    end: Annotated[float, Ge(0)] | None = None

    def do(self, at: "Workplace") -> str:
        """Do it."""
        row, _ = row_of(at.desk, self.animal)
        if self.start is None or self.end is None:
            return set_cells(at.desk, self.animal, {"zero [mmHg]": ""}, {})
        read = mean_between(at.recordings.opened(row).traces, "pressure", self.start, self.end)
        return set_cells(at.desk, self.animal, {"zero [mmHg]": f"{read:.4g}"}, {})


@settings_class
class SetGain:
    """Say what the mean of a stretch was known to be, mmHg or ml/s: a point of calibration; without one, none."""

    animal: Name
    signal: Literal["pressure", "flow"]
    start: Annotated[float, Ge(0)] | None = None
    end: Annotated[float, Ge(0)] | None = None
    known: Annotated[float, Gt(0)] | None = None

    def do(self, at: "Workplace") -> str:
        """Do it."""
        row, _ = row_of(at.desk, self.animal)
        title = f"{self.signal} gain [1]"
        if self.start is None or self.end is None or self.known is None:
            return set_cells(at.desk, self.animal, {title: ""}, {})
        read = mean_between(at.recordings.opened(row).traces, self.signal, self.start, self.end)
        above = read - (row.calibration[0] if self.signal == "pressure" else 0.0)
        if not above > _APART * abs(read):
            raise InputError(f"the {self.signal} that was read here, {above:.3g} above zero, is not above the zero; "
                             "say first where it is zero, or take another stretch")  # fmt: skip
        return set_cells(at.desk, self.animal, {title: f"{self.known / above:.6g}"}, {})


@settings_class
class EditBeats:
    """Decide on beats: `edits` are added, each in place of one near the same time; `forget` are taken back."""

    animal: Name
    edits: list[tuple[Literal["reject", "keep", "move"], _Time, _Time | None]] = field(default_factory=list)
    forget: list[float] = field(default_factory=list)

    def do(self, at: "Workplace") -> str:
        """Do it."""
        desk = at.desk
        row, _ = row_of(desk, self.animal)
        cell = os.path.relpath(row.beat_edits or edits_file(desk, self.animal), desk.folder).replace(os.sep, "/")
        path = desk.inside(cell)
        given = [BeatEdit(*one) for one in self.edits]
        if any((one.action == "move") != (one.to is not None) for one in given):
            raise InputError("a beat is moved to a time, and rejected or kept without one")
        with desk.changing(f"beats of {self.animal}", path, desk.table):
            gone = [*self.forget, *(one.time for one in given)]
            before = read_edits(path) if path.is_file() else ()
            kept = [one for one in before if all(abs(one.time - time) > _SAME for time in gone)]
            made_inside(desk.folder, str(path.parent.relative_to(desk.folder)))
            write_file(path, edits_text([*kept, *given]))
            table = read_rows(desk.table)
            write_cells(desk, table, self.animal, {"beat edits": cell})
        return f"{len(kept) + len(given)} edits in {cell}"


RECORDING_ACTIONS = {
    "set-stretch": SetStretch, "set-zero": SetZero, "set-gain": SetGain, "edit-beats": EditBeats
}  # fmt: skip
"""By the name that the page gives."""
