"""Everything that the page can change, each as one typed action over the functions that the command line calls."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from vasowave.errors import InputError, did_you_mean
from vasowave.settings import settings_class
from vasowave.workbench.desk import Desk
from vasowave.workbench.lung_actions import LUNG_ACTIONS
from vasowave.workbench.lungs import Lungs
from vasowave.workbench.recording_actions import RECORDING_ACTIONS
from vasowave.workbench.recordings import Recordings
from vasowave.workbench.running import Runs
from vasowave.workbench.study_actions import STUDY_ACTIONS


class Workplace(NamedTuple):
    """What actions work on."""

    desk: Desk
    recordings: Recordings
    runs: Runs
    lungs: Lungs


@settings_class
class Undo:
    """Take the last change back."""

    def do(self, at: Workplace) -> str:
        """Do it."""
        return f"undone: {at.desk.undo()}"


@settings_class
class Redo:
    """Make the change again that was taken back."""

    def do(self, at: Workplace) -> str:
        """Do it."""
        return f"done again: {at.desk.redo()}"


@settings_class
class Run:
    """Run the study, or go on with it."""

    def do(self, at: Workplace) -> str:
        """Do it."""
        at.runs.start(at.desk)
        return "the run begins"


@settings_class
class Stop:
    """Interrupt the run; what had finished is kept."""

    def do(self, at: Workplace) -> str:
        """Do it."""
        at.runs.stop(at.desk)
        return "the run is being stopped; what had finished is kept"


@settings_class
class AtEnd:
    """Say whether a run stops when the workbench ends."""

    stop: bool

    def do(self, at: Workplace) -> str:
        """Do it."""
        at.runs.stops_with_us = self.stop
        return f"a run {'stops' if self.stop else 'goes on'} when the workbench ends"


ACTIONS: Mapping[str, Callable[..., Any]] = {
    **STUDY_ACTIONS,
    **RECORDING_ACTIONS,
    **LUNG_ACTIONS,
    "undo": Undo,
    "redo": Redo,
    "run": Run,
    "stop": Stop,
    "at-end": AtEnd,
}
"""By the name that the page gives."""


def act(at: Workplace, asked: object) -> Any:
    """Do what the page asks, ``{"do": NAME, ...}``, and return what there is to say.

    Raises
    ------
    InputError
        No such action, a value that it does not take, or what the action itself refuses.
    """
    if not isinstance(asked, dict) or not isinstance(asked.get("do"), str):
        raise InputError("a message names what to do")
    kind = ACTIONS.get(asked["do"])
    if kind is None:
        raise InputError(f"there is no action '{asked['do'][:80]}'{did_you_mean(asked['do'][:80], ACTIONS)}")
    given = {str(key): value for key, value in asked.items() if key != "do"}
    return kind(**given).do(at)
