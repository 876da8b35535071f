"""Everything that the page can change, each as one typed action over the functions that the command line calls.

Here: the stretch, zero and gains of an animal's row and the file of its beats; the file of edits that
`vasowave extract` reads, and the folder it writes; undoing, and the run. What the Study desk changes stands in
`study_actions`.
"""

import os
from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Ge, Gt, MaxLen

from vasowave.errors import InputError, did_you_mean
from vasowave.imaging.places import written
from vasowave.recording import read_edits
from vasowave.recording.edits import MOST_EDITS, BeatEdit, edits_text, require_few
from vasowave.study.table import read_rows
from vasowave.workbench.desk import EDITS
from vasowave.workbench.lungs import LUNGS, Wishes, edits_of, lines_of
from vasowave.workbench.recordings import edits_file, mean_between, row_of
from vasowave.workbench.study_actions import Name, set_cells, write_cells
from vasowave.workbench.workplace import ACTIONS, Workplace, action

Time = Annotated[float, Ge(0)]
_APART = 0.01  # of what was read: two points of calibration nearer to each other than this tell no gain
_SAME = 1e-3  # s between two times that mean the same beat

Point = tuple[float, float, float]
_HEAD = "# Corrections of the tree; places are x y z as a viewer shows the image."
_NEW_TREE = ("root", "outlet")  # after which the axes are looked for anew
_Edit = Literal["root", "outlet", "remove", "cut", "merge", "move", "radius"]


@action("set-stretch")
def set_stretch(at: Workplace, animal: Name, start: Time | None = None, end: Time | None = None) -> str:
    """Average the beats of one stretch alone, s; nothing given is the whole recording."""
    start_text, end_text = ("" if one is None else f"{one:.10g}" for one in (start, end))
    return set_cells(at, animal, {"start [s]": start_text, "end [s]": end_text})


@action("set-zero")
def set_zero(at: Workplace, animal: Name, start: Time | None = None, end: Time | None = None) -> str:
    """Take the mean pressure of a stretch for the transducer's zero; without a stretch, none."""
    row, _ = row_of(at.desk, animal)
    if start is None or end is None:
        return set_cells(at, animal, {"zero [mmHg]": ""})
    read = mean_between(at.recordings.opened(row).traces, "pressure", start, end)
    return set_cells(at, animal, {"zero [mmHg]": f"{read:.4g}"})


@action("set-gain")
def set_gain(
    at: Workplace, animal: Name, signal: Literal["pressure", "flow"], start: Time | None = None,
    end: Time | None = None, known: Annotated[float, Gt(0)] | None = None,
) -> str:  # fmt: skip
    """Say what the mean of a stretch was known to be, mmHg or ml/s: a point of calibration; without one, none."""
    row, _ = row_of(at.desk, animal)
    title = f"{signal} gain [1]"
    if start is None or end is None or known is None:
        return set_cells(at, animal, {title: ""})
    read = mean_between(at.recordings.opened(row).traces, signal, start, end)
    above = read - row.calibration[0 if signal == "pressure" else 3]
    if not (above if signal == "pressure" else abs(above)) > _APART * abs(read):  # a probe may be mounted backward
        raise InputError(f"the {signal} that was read here, {above:.3g} above zero, is not above the zero; "
                         "say first where it is zero, or take another stretch")  # fmt: skip
    return set_cells(at, animal, {title: f"{known / above:.6g}"})


@action("edit-beats")
def edit_beats(
    at: Workplace, animal: Name,
    edits: Annotated[tuple[tuple[Literal["reject", "keep", "move"], Time, Time | None], ...], MaxLen(MOST_EDITS)] = (),
    forget: Annotated[tuple[float, ...], MaxLen(MOST_EDITS)] = (),
) -> str:  # fmt: skip
    """Decide on beats: `edits` are added, each in place of one near the same time; `forget` are taken back."""
    desk = at.desk
    row, _ = row_of(desk, animal)
    cell = os.path.relpath(row.beat_edits or edits_file(desk, animal), desk.folder).replace(os.sep, "/")
    path = desk.inside(cell)
    given = [BeatEdit(*one) for one in edits]
    if any((one.action == "move") != (one.to is not None) for one in given):
        raise InputError("a beat is moved to a time, and rejected or kept without one")
    with desk.changing(f"beats of {animal}", path, desk.table) as change:
        gone = np.sort([-np.inf, *forget, *(one.time for one in given), np.inf])
        before = read_edits(path) if path.is_file() else ()
        after = np.searchsorted(gone, [one.time for one in before])
        kept = [one for one, i in zip(before, after, strict=True)
                if min(gone[i] - one.time, one.time - gone[i - 1]) > _SAME]  # fmt: skip
        require_few(path, len(kept) + len(given))
        change.write(path, edits_text([*kept, *given]))
        write_cells(desk, change, read_rows(desk.table), animal, {"beat edits": cell})
    return f"{len(kept) + len(given)} edits in {cell}"


@action("edit-tree")
def edit_tree(
    at: Workplace, image: Name, action: _Edit, point: Point, to: Point | None = None,
    radius: Annotated[float, Gt(0)] | None = None,
) -> str:  # fmt: skip
    """Write one edit; places are x, y, z in cm along the image's axes, a radius is in cm.

    Where the vessels are known, the edit is tried at once: one that cannot be made is refused, and the file stays.
    """
    if (action == "move") != (to is not None) or (action == "radius") != (radius is not None):
        raise InputError("a move has a place to go to, a radius its size, and other edits have neither")
    desk, lungs = at.desk, at.lungs
    numbers = [_numbers(at, image, point)]
    numbers += [] if to is None else [_numbers(at, image, to)]
    numbers += [] if radius is None else [f"{radius:.6g}"]
    line = " ".join([action, *numbers])
    path, wishes = edits_of(desk, image), lungs.finds(desk, image)
    with desk.changing(f"{line} in {path.name}", path) as change:
        lines = [one for one in lines_of(path) if not (action == "root" and one.split()[:1] == ["root"])]
        change.write(path, "\n".join([*(lines or [_HEAD]), *_unit_cm(lines), line, ""]))
        if wishes is not None and action not in _NEW_TREE:
            lungs.extracted(desk, image, wishes)
    return f"{line}, in {EDITS}/{path.name}"


@action("forget-edit")
def forget_edit(at: Workplace, image: Name, line: Annotated[int, Ge(1)], text: Annotated[str, MaxLen(2000)]) -> str:
    """Take one line out of the file of edits; `text` is what the page showed in it."""
    path = edits_of(at.desk, image)
    with at.desk.changing(f"forget '{text}' of {path.name}", path) as change:
        lines = lines_of(path)
        if line > len(lines) or lines[line - 1] != text:
            raise InputError(f"{path.name} was changed elsewhere meanwhile; look at it, then change it again")
        change.write(path, "\n".join([*lines[: line - 1], *lines[line:], ""]))
    return f"without '{text}'"


@action("write-lung")
def write_lung(at: Workplace, image: Name, wishes: dict[str, Any]) -> str:
    """Write network, lines, mask and page of an image's vessels, as `vasowave extract` does."""
    at.lungs.write(at.desk, image, Wishes(**wishes))
    return f"{LUNGS}/{image}/network.csv is written; choose it as the network of an animal"


def _unit_cm(lines: list[str]) -> list[str]:
    """Return the line that makes cm the unit, where another one holds at the end."""
    units = [words[1] for line in lines if (words := line.split("#")[0].split())[:1] == ["unit"] and len(words) == 2]
    return ["unit cm"] if units and units[-1] != "cm" else []


def _numbers(at: Workplace, image: str, point: Point) -> str:
    return written(at.lungs.own(at.desk, image, point)[::-1] + 0.0).replace(",", " ")


@action("undo")
def undo(at: Workplace) -> str:
    """Take the last change back."""
    return f"undone: {at.desk.undo()}"


@action("redo")
def redo(at: Workplace) -> str:
    """Make the change again that was taken back."""
    return f"done again: {at.desk.redo()}"


@action("run")
def run(at: Workplace) -> str:
    """Run the study, or go on with it."""
    at.runs.start(at.desk)
    return "the run begins"


@action("stop")
def stop(at: Workplace) -> str:
    """Ask the run to stop, wherever it runs; a second time, some seconds later, end it at once."""
    return at.runs.stop(at.desk)


@action("at-end")
def at_end(at: Workplace, stop: bool) -> str:
    """Say whether a run stops when the workbench ends."""
    at.runs.stops_with_us = stop
    return f"a run {'stops' if stop else 'goes on'} when the workbench ends"


def act(at: Workplace, asked: object) -> Any:
    """Do what the page asks, ``{"do": NAME, ...}``, and return what there is to say.

    Raises
    ------
    InputError
        No such action, a value that it does not take, or what the action itself refuses.
    """
    if not isinstance(asked, dict) or not isinstance(asked.get("do"), str):
        raise InputError("a message names what to do")
    wanted = ACTIONS.get(asked["do"])
    if wanted is None:
        raise InputError(f"there is no action '{asked['do'][:80]}'{did_you_mean(asked['do'][:80], ACTIONS)}")
    return wanted(at, {str(key): value for key, value in asked.items() if key != "do"})
