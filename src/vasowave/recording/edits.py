"""Decisions of a person about single beats: a small table that the average follows and a reader understands."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple, cast, get_args

import numpy as np

from vasowave.errors import InputError, did_you_mean
from vasowave.findings import Finding, look_kind, note_kind
from vasowave.io.columns import NoRowsError, read_columns
from vasowave.recording.rejection import Rejection

Action = Literal["reject", "keep", "move"]

EDITED = note_kind(
    "recording.beats-edited", "by hand {rejected} beats were rejected, {kept} kept, and {moved} begun at another time"
)
WITHOUT_BEAT = look_kind(
    "recording.edit-without-beat",
    "'{action}' at {time:g} s of the edited beats meets no beat",
    "Remove its line, or correct its time.",
)
_BY_HAND = note_kind("beat.hand", "rejected by hand")
_HEAD = "# What a person decided of single beats; times in s since the start of the block, within the beat."


class BeatEdit(NamedTuple):
    """One decision.

    Attributes
    ----------
    action : {"reject", "keep", "move"}
        Leave the beat out; average it although a rule rejects it; begin it at another time.
    time : float
        A time within the beat, s since the start of the block; of a move, the beginning that was found.
    to : float, optional
        Where a moved beat begins, s.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.BeatEdit("reject", 3.21)
    BeatEdit(action='reject', time=3.21, to=None)
    """

    action: Action
    time: float
    to: float | None = None


def read_edits(path: Path) -> tuple[BeatEdit, ...]:
    """Return the edits of a file, a CSV with the columns ``action``, ``time [s]`` and ``to [s]``.

    Raises
    ------
    InputError
        The file, line and column of what is wrong.

    Examples
    --------
    >>> from pathlib import Path
    >>> import vasowave as vw
    >>> _ = Path("mouse.edits.csv").write_text("action,time [s],to [s]\\nreject,1.25,\\n", encoding="utf-8")
    >>> vw.read_edits(Path("mouse.edits.csv"))
    (BeatEdit(action='reject', time=1.25, to=None),)
    """
    try:
        table = read_columns(path)
    except NoRowsError:
        return ()
    action, time = table.require("action"), table.require("time")
    to = table.find("to")
    edits = []
    for line, cells in zip(table.lines, table.cells, strict=True):
        word, target = cells[action].strip(), cells[to].strip() if to is not None else ""
        if slip := _slip(word, bool(target)):
            raise InputError(f"{path}, line {line}: {slip}")
        edits.append(BeatEdit(cast(Action, word), _seconds(path, line, "time [s]", cells[time]),
                              _seconds(path, line, "to [s]", target) if target else None))  # fmt: skip
    return tuple(edits)


def edits_text(edits: Sequence[BeatEdit]) -> str:
    """Return the file of edits, in the order of their times."""
    rows = [
        f"{one.action},{one.time:.10g},{'' if one.to is None else f'{one.to:.10g}'}"
        for one in sorted(edits, key=lambda one: one.time)
    ]
    return "\n".join([_HEAD, "action,time [s],to [s]", *rows, ""])


def moved(times: np.ndarray, edits: Sequence[BeatEdit]) -> tuple[np.ndarray, list[Finding]]:
    """Return the beginnings of the beats with those moved that a person moved, and which moves meet none."""
    times, lost = times.copy(), []
    for one in edits:
        if one.to is None:
            continue
        i = int(np.argmin(np.abs(times - one.time)))
        below = times[i - 1] if i > 0 else -np.inf
        above = times[i + 1] if i + 1 < len(times) else np.inf
        if abs(times[i] - one.time) > 0.5 * float(np.median(np.diff(times))) or not below < one.to < above:
            lost.append(WITHOUT_BEAT(action=one.action, time=one.time))
        else:
            times[i] = one.to
    return times, lost


def require_decisions(edits: Sequence[BeatEdit]) -> None:
    """Raise `InputError` if one of them decides nothing: an unknown action, or a move that leads nowhere."""
    for one in edits:
        if slip := _slip(str(one.action), one.to is not None):
            raise InputError(f"{one}: {slip}")


def _slip(action: str, has_target: bool) -> str:
    """Return what is wrong with a decision, empty if nothing is."""
    known = get_args(Action)
    if action not in known:
        return f"'{action}' is no action{did_you_mean(action, known)}; there are: {', '.join(known)}"
    if action == "move" and not has_target:
        return "a move needs 'to', the time at which the beat begins"
    return f"'{action}' leaves empty the time of a move, 'to'" if action != "move" and has_target else ""


def judged(
    reasons: list[Rejection], starts: np.ndarray, ends: np.ndarray, edits: Sequence[BeatEdit]
) -> tuple[list[Rejection], list[Finding]]:
    """Return why each beat is rejected when a person has spoken too, and which edits meet no beat."""
    reasons, lost = list(reasons), []
    for one in edits:
        if one.to is not None:
            continue
        hit = np.flatnonzero((starts <= one.time) & (one.time < ends))
        if not len(hit):
            lost.append(WITHOUT_BEAT(action=one.action, time=one.time))
        else:
            reasons[int(hit[0])] = _BY_HAND() if one.action == "reject" else None
    return reasons, lost


def told(edits: Sequence[BeatEdit]) -> list[Finding]:
    """Return a note of how many beats a person decided on, if there are any."""
    counts = [sum(one.action == action for one in edits) for action in get_args(Action)]
    return [EDITED(rejected=counts[0], kept=counts[1], moved=counts[2])] if edits else []


def _seconds(path: Path, line: int, title: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not (np.isfinite(value) and value >= 0):
        raise InputError(f"{path}, line {line}, column '{title}': '{text}' is no time in seconds")
    return value
