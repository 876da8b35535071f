"""Cures, as values: what a person can do about a finding or an error, without a word of where it is done.

Each door writes them in one place: `argument` as what a Python function takes, `vasowave.cli.cures` as commands,
`vasowave.workbench.cures` as buttons. A report has the sentence of the remedy alone.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, TypeAlias

UNKNOWN = "…"
"""Stands for what only a person knows."""


@dataclass(frozen=True)
class SetCells:
    """Write cells of the animal in the table of animals; options and arguments of the same names serve one recording.

    Attributes
    ----------
    label : str
        What that is, in a few words.
    cells : tuple of (str, str)
        Titles and texts, format strings of the finding's values; an empty text empties the cell.
    """

    label: str
    cells: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class ShiftFlowZero:
    """Take the level at which the flow rests now, ml/s as it is read now, for its zero."""

    level: str


@dataclass(frozen=True)
class TurnFlow:
    """Turn the sign of the flow, of a probe that was mounted backward."""


@dataclass(frozen=True)
class SetSetting:
    """Write a setting of the study, by its key (``section.key``); options and arguments serve one animal."""

    label: str
    key: str
    text: str = UNKNOWN


@dataclass(frozen=True)
class SetOption:
    """Say something about an image or a network when it is read: ``voxel``, ``cannula``."""

    label: str
    name: str
    text: str = UNKNOWN


@dataclass(frozen=True)
class Visit:
    """Look at the animal's recording, or the lung: ``recording``, ``lung``."""

    desk: str


@dataclass(frozen=True)
class RemoveAnimal:
    """Take the row of the first animal that it concerns out of the table; its files stay."""


@dataclass(frozen=True)
class NameGroups:
    """Name the groups of the study, the reference first, as names of files hold them: ``CTL,HPH``, ``CTL=wt``."""

    groups: str = UNKNOWN


@dataclass(frozen=True)
class Tidy:
    """Let a table of vessels be written from a file that is none as it stands: ``tidy``, ``centerlines``."""

    tool: str = "tidy"


@dataclass(frozen=True)
class TrustPrograms:
    """Allow the programs that the study brings along."""


@dataclass(frozen=True)
class RunAgain:
    """Run the study again; what is kept is not computed twice."""


Cure: TypeAlias = (
    SetCells | ShiftFlowZero | TurnFlow | SetSetting | SetOption | Visit | RemoveAnimal | NameGroups | Tidy
    | TrustPrograms | RunAgain
)  # fmt: skip

_MAX_ARGUMENTS = 3  # below an error
_ARGUMENTS = frozenset({
    "start [s]", "end [s]", "block", "sampling rate [1/s]", "period [s]", "pressure channel", "flow channel",
    "ecg channel", "pressure unit", "flow unit", "sheet", "subject row", "flow diameter [mm]",
    "volume channel", "volume unit", "volume delay [s]",
})  # fmt: skip
"""Columns that functions which read a recording take as arguments."""

FLOW_ZERO, FLOW_GAIN = "flow zero [ml/s]", "flow gain [1]"


def stretch(start: str = UNKNOWN, end: str = UNKNOWN) -> SetCells:
    """Return the cure that averages one stretch alone, s."""
    label = "Choose a stretch" if UNKNOWN in (start, end) else f"Average {start} to {end} s"
    return SetCells(label, (("start [s]", start), ("end [s]", end)))


STRETCH = stretch()
VOXEL = SetOption("Give the size of a voxel, cm", "voxel")
AVERAGE_BREATHS = SetSetting("Average over the breath", "averaging.reject_ventilation", "false")
ZERO_TIME = SetSetting("Say when the zero was right", "averaging.zero_time")


def filled(cure: Cure, values: Mapping[str, Any]) -> Cure:
    """Return a cure with the values of its finding in the place of their names."""
    texts: dict[str, Any] = {}
    for field in fields(cure):
        content = getattr(cure, field.name)
        texts[field.name] = (
            content.format(**values)
            if isinstance(content, str)
            else tuple((title.format(**values), text.format(**values)) for title, text in content)
        )
    return replace(cure, **texts)


def in_row(cure: Cure, cells: Mapping[str, str]) -> Cure:
    """Return a cure of the flow as cells of a row that may have a zero and a gain of its flow already."""
    gain, zero = (_number(cells.get(title, ""), default) for title, default in ((FLOW_GAIN, 1.0), (FLOW_ZERO, 0.0)))
    match cure:
        case TurnFlow():
            return SetCells("Turn the flow", ((FLOW_GAIN, f"{-gain:.6g}"),))
        case ShiftFlowZero(level):
            flow_zero = zero + float(level) / gain
            return SetCells(f"Flow zero at {flow_zero:.4g} ml/s", ((FLOW_ZERO, f"{flow_zero:.6g}"),))
    return cure


def field_of(title: str) -> str:
    """Return the name of a column of the table without its unit, as options and arguments have it."""
    return title.partition(" [")[0].replace(" ", "_")


def argument(cure: Cure) -> str:
    """Return a cure as what a function of the package takes, or as what to call; empty where there is nothing."""
    match cure:
        case ShiftFlowZero(level):
            return _of_sensor(f"flow_zero={float(level):.6g}")
        case TurnFlow():
            return _of_sensor("flow_gain=-1")
        case SetCells(_, (("kind", "raw"),)):
            return "average_beats(read_raw_recording(path))"
        case SetCells(_, cells) if all(title in _ARGUMENTS for title, _ in cells):
            return ", ".join(f"{field_of(title).removesuffix('_channel')}={_literal(text)}" for title, text in cells)
        case SetSetting(_, key, text):
            return f"{key.rpartition('.')[2]}={_literal(text)}"
        case SetOption(_, name, text):
            return f"{name}={_literal(text)}"
        case Visit("recording"):
            return "average_beats(recording).plot()"
        case Tidy("tidy"):
            return "tidy(network)"
        case TrustPrograms():
            return "trust_study(folder)"
        case RunAgain():
            return "run_study(study)"
    return ""


def _of_sensor(argument: str) -> str:
    return f"recording.calibrated({argument}), of a cycle calibration=SensorCalibration({argument})"


def arguments(cures: Iterable[Cure]) -> list[str]:
    """Return what Python offers for a finding or an error, the first few."""
    return [*dict.fromkeys(filter(None, map(argument, cures)))][:_MAX_ARGUMENTS]


def _literal(text: str) -> str:
    if text in ("true", "false"):
        return text.title()
    numbers = text.strip("[]").split(",")
    return text if text == UNKNOWN or all(_number(number) is not None for number in numbers) else repr(text)


def _number(text: str, default: Any = None) -> Any:
    try:
        return float(text)
    except ValueError:
        return default
