"""What actions work on, and how a function becomes one: an action is a function that the page calls by a name."""

from collections.abc import Callable, Mapping
from dataclasses import make_dataclass
from inspect import Parameter, signature
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, get_type_hints

from vasowave.base.settings import settings_class
from vasowave.workbench.arrivals import Arrivals
from vasowave.workbench.desk import Desk
from vasowave.workbench.lungs import Lungs
from vasowave.workbench.recordings import Recordings
from vasowave.workbench.running import Runs

Function = TypeVar("Function", bound=Callable[..., Any])


class Workplace(NamedTuple):
    """What actions work on: the first argument of each."""

    desk: Desk
    recordings: Recordings
    runs: Runs
    lungs: Lungs
    arrivals: Arrivals

    @classmethod
    def around(cls, desk: Desk, image: Path | None = None) -> "Workplace":
        """Return what there is around a study, and an image that lies elsewhere."""
        return cls(desk, Recordings(), Runs(), Lungs(image), Arrivals(desk))


ACTIONS: dict[str, Callable[[Workplace, Mapping[str, Any]], Any]] = {}
"""By the name that the page gives; each takes the values of a message, and raises `InputError` for wrong ones."""


def action(name: str) -> Callable[[Function], Function]:
    """Let the page call a function; the annotations of its arguments say what it takes, as those of settings do."""

    def register(function: Function) -> Function:
        kinds = get_type_hints(function, include_extras=True)
        values = [*signature(function).parameters.values()][1:]
        fields = [
            (
                parameter.name,
                kinds[parameter.name],
                *([] if parameter.default is Parameter.empty else [parameter.default]),
            )
            for parameter in values
        ]
        message_class: Any = settings_class(make_dataclass(function.__name__, fields))
        ACTIONS[name] = lambda workplace, message: function(workplace, **vars(message_class(**message)))
        return function

    return register
