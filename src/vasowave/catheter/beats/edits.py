"""Decisions of a person about single beats: a small table that the average follows and a reader understands."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple, cast, get_args

import numpy as np

from vasowave.base.errors import InputError, did_you_mean
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.base.io.columns import NoRowsError, read_columns
from vasowave.base.stores import stored
from vasowave.pulse.cycle.averaged import Rejection

Action = Literal["reject", "keep", "move"]

EDITED = note_kind(
    "recording.beats-edited", "by hand {rejected} beats were rejected, {kept} kept, and {moved} begun at another time"
)
WITHOUT_BEAT = look_kind(
    "recording.edit-without-beat",
    "'{action}' at {time:g} s of the edited beats meets no beat",
    "Remove its line, or correct its time.",
)
MAX_EDITS = 100_000
"""Of one recording: a mouse's beats in three hours."""

_BY_HAND = note_kind("beat.hand", "rejected by hand")
_HEADER_LINE = "# What a person decided of single beats; times in s since the start of the block, within the beat."


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


@stored("edits of beats", "edits/*.csv")
def read_edits(path: str | Path) -> tuple[BeatEdit, ...]:
    """Return the edits of a file, a CSV with the columns ``action``, ``time [s]`` and ``to [s]``.

    Raises
    ------
    InputError
        The file, line and column of what is wrong; more than `MAX_EDITS`.

    Examples
    --------
    >>> from pathlib import Path
    >>> import vasowave as vw
    >>> _ = Path("mouse.edits.csv").write_text("action,time [s],to [s]\\nreject,1.25,\\n", encoding="utf-8")
    >>> vw.read_edits("mouse.edits.csv")
    (BeatEdit(action='reject', time=1.25, to=None),)
    """
    try:
        table = read_columns(path)
    except NoRowsError:
        return ()
    action, time = table.require("action"), table.require("time")
    to = table.find("to")
    require_few(path, len(table.lines))
    edits = []
    for line, cells in zip(table.lines, table.cells, strict=True):
        word, target = cells[action].strip(), cells[to].strip() if to is not None else ""
        if slip := _slip(word, bool(target)):
            raise InputError(f"{path}, line {line}: {slip}")
        edits.append(BeatEdit(cast(Action, word), _seconds(path, line, "time [s]", cells[time]),
                              _seconds(path, line, "to [s]", target) if target else None))  # fmt: skip
    return tuple(edits)


def require_few(path: str | Path, count: int) -> None:
    """Raise `InputError` if a file would hold more edits than `MAX_EDITS`."""
    if count > MAX_EDITS:
        raise InputError(
            f"{path}: {count} edits of beats; at most {MAX_EDITS}; average a shorter stretch, and decide on its beats "
            "alone"
        )


def edits_text(edits: Sequence[BeatEdit]) -> str:
    """Return the file of edits, in the order of their times."""
    rows = [
        f"{edit.action},{edit.time:.10g},{'' if edit.to is None else f'{edit.to:.10g}'}"
        for edit in sorted(edits, key=lambda edit: edit.time)
    ]
    return "\n".join([_HEADER_LINE, "action,time [s],to [s]", *rows, ""])


def moved(times: np.ndarray, edits: Sequence[BeatEdit]) -> tuple[np.ndarray, list[Finding]]:
    """Return the beginnings of the beats with those moved that a person moved, and which moves meet none."""
    times, lost, moves = times.copy(), [], [edit for edit in edits if edit.to is not None]
    reach = 0.5 * float(np.median(np.diff(times))) if moves else 0.0
    for edit in moves:
        assert edit.to is not None
        after = min(max(int(np.searchsorted(times, edit.time)), 1), len(times) - 1)  # times stay in their order
        i = after - 1 if edit.time - times[after - 1] <= times[after] - edit.time else after
        below = times[i - 1] if i > 0 else -np.inf
        above = times[i + 1] if i + 1 < len(times) else np.inf
        if abs(times[i] - edit.time) > reach or not below < edit.to < above:
            lost.append(WITHOUT_BEAT(action=edit.action, time=edit.time))
        else:
            times[i] = edit.to
    return times, lost


def require_decisions(edits: Sequence[BeatEdit]) -> None:
    """Raise `InputError` if one of them decides nothing: an unknown action, or a move that leads nowhere."""
    for edit in edits:
        if slip := _slip(str(edit.action), edit.to is not None):
            raise InputError(f"{edit}: {slip}")


def _slip(action: str, has_target: bool) -> str:
    """Return what is wrong with a decision, empty if nothing is."""
    actions = get_args(Action)
    if action not in actions:
        return f"'{action}' is no action{did_you_mean(action, actions)}; there are: {', '.join(actions)}"
    if action == "move" and not has_target:
        return "a move needs 'to', the time at which the beat begins"
    return f"'{action}' leaves empty the time of a move, 'to'" if action != "move" and has_target else ""


def judged(
    reasons: list[Rejection], starts: np.ndarray, ends: np.ndarray, edits: Sequence[BeatEdit]
) -> tuple[list[Rejection], list[Finding]]:
    """Return why each beat is rejected when a person has spoken too, and which edits meet no beat."""
    reasons, lost = list(reasons), []
    for edit in edits:
        if edit.to is not None:
            continue
        i = int(np.searchsorted(starts, edit.time, side="right")) - 1  # the last that has begun
        if i < 0 or edit.time >= ends[i]:
            lost.append(WITHOUT_BEAT(action=edit.action, time=edit.time))
        else:
            reasons[i] = _BY_HAND() if edit.action == "reject" else None
    return reasons, lost


def told(edits: Sequence[BeatEdit]) -> list[Finding]:
    """Return a note of how many beats a person decided on, if there are any."""
    counts = [sum(edit.action == action for edit in edits) for action in get_args(Action)]
    return [EDITED(rejected=counts[0], kept=counts[1], moved=counts[2])] if edits else []


def _seconds(path: str | Path, line: int, title: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not (np.isfinite(value) and value >= 0):
        raise InputError(f"{path}, line {line}, column '{title}': '{text}' is not a time in seconds")
    return value
