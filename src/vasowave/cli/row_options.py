"""Options of `add`, `fit` and `posterior` that say of a recording what a table of animals says in its columns."""

from typing import Annotated, Any

import typer

from vasowave.cli.options import help_of
from vasowave.study.rows import COLUMNS

_PLAIN = {
    "period": "period [s]",
    "wedge": "wedge [mmHg]",
    "block": "block",
    "start": "start [s]",
    "end": "end [s]",
    "sampling_rate": "sampling rate [1/s]",
}
_SEVERAL = {
    "channel": ("pressure", "flow", "ecg"),
    "unit": ("pressure", "flow"),
}
_MEANINGS = {
    "channel": "Title of the channel of pressure, flow or ecg, where titles and units leave more than one answer; may "
    "be repeated: --channel pressure='PA 2'.",
    "unit": "Unit of pressure or flow, where the file names none; may be repeated: --unit flow=ml/min.",
}


def row_options() -> dict[str, Any]:
    """Return the annotation of every option."""
    plain = {
        name: Annotated[
            str | None,
            typer.Option(f"--{name.replace('_', '-')}", metavar="VALUE", help=help_of(f"{COLUMNS[title]} ({title})"),
                         rich_help_panel="recording"),
        ]
        for name, title in _PLAIN.items()
    }  # fmt: skip
    several = {
        name: Annotated[
            list[str] | None,
            typer.Option(f"--{name}", metavar="NAME=VALUE", help=_MEANINGS[name], rich_help_panel="recording"),
        ]
        for name in _SEVERAL
    }
    return several | plain


def row_cells(given: dict[str, Any]) -> dict[str, str]:
    """Take these options out of `given` and return the cells that they stand for.

    Raises
    ------
    InputError
        A channel or unit of something else than pressure, flow or ECG.
    """
    cells = {title: given.pop(name).strip() for name, title in _PLAIN.items() if name in given}
    for option, names in _SEVERAL.items():
        for text in given.pop(option, []):
            name, _, value = (part.strip() for part in text.partition("="))
            if name not in names or not value:
                from vasowave.errors import InputError, did_you_mean

                raise InputError(f"--{option} {text}: write {' or '.join(f'{one}=…' for one in names)}"
                                 f"{did_you_mean(name, names)}")  # fmt: skip
            cells[f"{name} {option}"] = value
    return cells
