"""Everything that the page can change, each as one typed action over the functions that the command line calls.

Here: the stretch, zero and gains of an animal's row and the file of its beats; the file of edits that
`vasowave extract` reads, and the folder it writes; undoing, and the run. What the Study desk changes stands in
`study_actions`.
"""

import os
from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Ge, Gt, MaxLen

from vasowave.base.errors import InputError, did_you_mean
from vasowave.catheter.beats.edits import MAX_EDITS, BeatEdit, edits_text, read_edits, require_few
from vasowave.lung.places import written
from vasowave.study.entering.table import read_rows
from vasowave.workbench.desk import EDITS
from vasowave.workbench.lungs import LUNGS, Wishes, edits_of, lines_of
from vasowave.workbench.recordings import edits_file, mean_between, row_of
from vasowave.workbench.study_actions import Name, set_cells, write_cells
from vasowave.workbench.workplace import ACTIONS, Workplace, action

Time = Annotated[float, Ge(0)]
_MIN_SHARE = 0.01  # of what was read: two points of calibration nearer to each other than this tell no gain
_TIME_TOLERANCE = 1e-3  # s between two times that mean the same beat

Point = tuple[float, float, float]
_HEAD = "# Corrections of the tree; places are x y z as a viewer shows the image."
_NEW_TREE = ("root", "outlet")  # after which the axes are looked for anew
_Edit = Literal["root", "outlet", "remove", "cut", "merge", "move", "radius"]


@action("set-stretch")
def set_stretch(workplace: Workplace, animal: Name, start: Time | None = None, end: Time | None = None) -> str:
    """Average the beats of one stretch alone, s; nothing given is the whole recording."""
    start_text, end_text = ("" if time is None else f"{time:.10g}" for time in (start, end))
    return set_cells(workplace, animal, {"start [s]": start_text, "end [s]": end_text})


@action("set-zero")
def set_zero(workplace: Workplace, animal: Name, start: Time | None = None, end: Time | None = None) -> str:
    """Take the mean pressure of a stretch for the transducer's zero; without a stretch, none."""
    row, study = row_of(workplace.desk, animal)
    if start is None or end is None:
        return set_cells(workplace, animal, {"zero [mmHg]": ""})
    read = mean_between(workplace.recordings.opened(row, study).traces, "pressure", start, end)
    return set_cells(workplace, animal, {"zero [mmHg]": f"{read:.4g}"})


@action("set-gain")
def set_gain(
    workplace: Workplace, animal: Name, signal: Literal["pressure", "flow"], start: Time | None = None,
    end: Time | None = None, known: Annotated[float, Gt(0)] | None = None,
) -> str:  # fmt: skip
    """Say what the mean of a stretch was known to be, mmHg or ml/s: a point of calibration; without one, none."""
    row, study = row_of(workplace.desk, animal)
    title = f"{signal} gain [1]"
    if start is None or end is None or known is None:
        return set_cells(workplace, animal, {title: ""})
    read = mean_between(workplace.recordings.opened(row, study).traces, signal, start, end)
    above = row.calibration._replace(gain=1.0, flow_gain=1.0).corrected(signal, read)
    if not (above if signal == "pressure" else abs(above)) > _MIN_SHARE * abs(read):  # a probe may be mounted backward
        raise InputError(f"the {signal} that was read here, {above:.3g} above zero, is not above the zero; "
                         "say first where it is zero, or take another stretch")  # fmt: skip
    return set_cells(workplace, animal, {title: f"{known / above:.6g}"})


@action("edit-beats")
def edit_beats(
    workplace: Workplace, animal: Name,
    edits: Annotated[tuple[tuple[Literal["reject", "keep", "move"], Time, Time | None], ...], MaxLen(MAX_EDITS)] = (),
    forget: Annotated[tuple[float, ...], MaxLen(MAX_EDITS)] = (),
) -> str:  # fmt: skip
    """Decide on beats: `edits` are added, each in place of one near the same time; `forget` are taken back."""
    desk = workplace.desk
    row, _ = row_of(desk, animal)
    cell = os.path.relpath(row.beat_edits or edits_file(desk, animal), desk.folder).replace(os.sep, "/")
    path = desk.inside(cell)
    new_edits = [BeatEdit(*edit) for edit in edits]
    if any((edit.action == "move") != (edit.to is not None) for edit in new_edits):
        raise InputError("a beat is moved to a time, and rejected or kept without one")
    with desk.changing(f"beats of {animal}", path, desk.table) as change:
        gone = np.sort([-np.inf, *forget, *(edit.time for edit in new_edits), np.inf])
        before = read_edits(path) if path.is_file() else ()
        after = np.searchsorted(gone, [edit.time for edit in before])
        old_edits = [edit for edit, i in zip(before, after, strict=True)
                     if min(gone[i] - edit.time, edit.time - gone[i - 1]) > _TIME_TOLERANCE]  # fmt: skip
        require_few(path, len(old_edits) + len(new_edits))
        change.write(path, edits_text([*old_edits, *new_edits]))
        write_cells(desk, change, read_rows(desk.table), animal, {"beat edits": cell})
    return f"{len(old_edits) + len(new_edits)} edits in {cell}"


@action("edit-tree")
def edit_tree(
    workplace: Workplace, image: Name, action: _Edit, point: Point, to: Point | None = None,
    radius: Annotated[float, Gt(0)] | None = None,
) -> str:  # fmt: skip
    """Write one edit; places are x, y, z in cm along the image's axes, a radius is in cm.

    Where the vessels are known, the edit is tried at once: one that cannot be made is refused, and the file stays.
    """
    if (action == "move") != (to is not None) or (action == "radius") != (radius is not None):
        raise InputError("a move has a place to go to, a radius its size, and other edits have neither")
    desk, lungs = workplace.desk, workplace.lungs
    numbers = [_numbers(workplace, image, point)]
    numbers += [] if to is None else [_numbers(workplace, image, to)]
    numbers += [] if radius is None else [f"{radius:.6g}"]
    line = " ".join([action, *numbers])
    path, wishes = edits_of(desk, image), lungs.finds(desk, image)
    with desk.changing(f"{line} in {path.name}", path) as change:
        lines = [text for text in lines_of(path) if not (action == "root" and text.split()[:1] == ["root"])]
        change.write(path, "\n".join([*(lines or [_HEAD]), *_unit_cm(lines), line, ""]))
        if wishes is not None and action not in _NEW_TREE:
            lungs.extracted(desk, image, wishes)
    return f"{line}, in {EDITS}/{path.name}"


@action("forget-edit")
def forget_edit(
    workplace: Workplace, image: Name, line: Annotated[int, Ge(1)], text: Annotated[str, MaxLen(2000)]
) -> str:
    """Take one line out of the file of edits; `text` is what the page showed in it."""
    path = edits_of(workplace.desk, image)
    with workplace.desk.changing(f"forget '{text}' of {path.name}", path) as change:
        lines = lines_of(path)
        if line > len(lines) or lines[line - 1] != text:
            raise InputError(f"{path.name} was changed elsewhere meanwhile; look at it, then change it again")
        change.write(path, "\n".join([*lines[: line - 1], *lines[line:], ""]))
    return f"without '{text}'"


@action("write-lung")
def write_lung(workplace: Workplace, image: Name, wishes: dict[str, Any]) -> str:
    """Write network, lines, mask and page of an image's vessels, as `vasowave extract` does."""
    workplace.lungs.write(workplace.desk, image, Wishes(**wishes))
    return f"{LUNGS}/{image}/network.csv is written; choose it as the network of an animal"


def _unit_cm(lines: list[str]) -> list[str]:
    """Return the line that makes cm the unit, where another one holds at the end."""
    units = [words[1] for line in lines if (words := line.split("#")[0].split())[:1] == ["unit"] and len(words) == 2]
    return ["unit cm"] if units and units[-1] != "cm" else []


def _numbers(workplace: Workplace, image: str, point: Point) -> str:
    return written(workplace.lungs.own(workplace.desk, image, point)[::-1] + 0.0).replace(",", " ")


@action("undo")
def undo(workplace: Workplace) -> str:
    """Take the last change back."""
    return f"undone: {workplace.desk.undo()}"


@action("redo")
def redo(workplace: Workplace) -> str:
    """Make the change again that was taken back."""
    return f"done again: {workplace.desk.redo()}"


@action("run")
def run(workplace: Workplace) -> str:
    """Run the study, or go on with it."""
    workplace.runs.start(workplace.desk)
    return "the run begins"


@action("stop")
def stop(workplace: Workplace) -> str:
    """Ask the run to stop, wherever it runs; a second time, some seconds later, end it at once."""
    return workplace.runs.stop(workplace.desk)


@action("at-end")
def at_end(workplace: Workplace, stop: bool) -> str:
    """Say whether a run stops when the workbench ends."""
    workplace.runs.stops_with_us = stop
    return f"a run {'stops' if stop else 'goes on'} when the workbench ends"


def act(workplace: Workplace, message: object) -> Any:
    """Do what the page asks, ``{"do": NAME, ...}``, and return what there is to say.

    Raises
    ------
    InputError
        No such action, a value that it does not take, or what the action itself refuses.
    """
    if not isinstance(message, dict) or not isinstance(message.get("do"), str):
        raise InputError("a message names what to do")
    function = ACTIONS.get(message["do"])
    if function is None:
        raise InputError(f"there is no action '{message['do'][:80]}'{did_you_mean(message['do'][:80], ACTIONS)}")
    return function(workplace, {str(key): value for key, value in message.items() if key != "do"})
