"""Options of a command, one for every setting, with the default and the meaning that the setting itself states."""

import inspect
from typing import Any

import typer
from typer.main import get_command

_OF_FITS = ("walls", "beds", "starts", "method", "paper_bounds", "bounds", "model_selection", "selection_optima",
            "waves_at", "inference", "pdf", "law", "quantities")  # fmt: skip
"""Settings of a fit and its report that a posterior does not know."""


def with_settings(name: str, command: Any) -> Any:
    """Return a command with an option for every setting; its function is called with them as one mapping, `given`."""
    function = command.callback.__wrapped__
    own = [one for one in inspect.signature(function).parameters.values() if one.name != "given"]
    options = _options_of(name)

    def called(**arguments: Any) -> None:
        given = {key: arguments.pop(key) for key in options}
        function(**arguments, given={key: value for key, value in given.items() if value not in (None, [])})

    parameters = [inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=kind)
                  for key, kind in options.items()]  # fmt: skip
    called.__signature__ = inspect.Signature([*own, *parameters])  # type: ignore[attr-defined]
    called.__annotations__ = {one.name: one.annotation for one in [*own, *parameters]}
    called.__doc__ = function.__doc__
    single = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    single.command(name, epilog=command.epilog)(called)
    return get_command(single)


def _options_of(name: str) -> dict[str, Any]:
    """Return the options of a command; what studies need takes seconds to load, and images need none of it."""
    if name == "extract":
        from vasowave.cli.image_options import image_options

        return image_options()
    from vasowave.cli.row_options import row_options

    if name == "add":
        return row_options()
    from vasowave.cli.study_options import study_options

    return row_options() | study_options(_OF_FITS if name == "posterior" else ())


def flag(name: Any) -> str:
    """Return the option of a setting."""
    return f"--{str(name).replace('_', '-')}"


def help_of(meaning: str) -> str:
    """Return a setting's meaning as a terminal shows it."""
    return meaning.replace("[", r"\[")
