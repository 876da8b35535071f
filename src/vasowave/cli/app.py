"""The command that all commands hang on."""

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

WRONG_INPUT, FAILED = 1, 3
"""Exit status: a file, an option or a study is wrong; the input is fine, but (an animal's) numbers did not come out."""

_WITH_SETTINGS = ("fit", "extract")


class Commands(TyperGroup):
    """The commands. Options made from settings are made when a command is called: to load them takes seconds."""

    def resolve_command(self, ctx: Any, args: list[str]) -> tuple[str | None, Any, list[str]]:
        """Return name, command and the arguments that follow."""
        name, command, rest = super().resolve_command(ctx, args)
        if name in _WITH_SETTINGS:
            from vasowave.cli.options import with_settings

            command = with_settings(name, command)
        return name, command, rest


app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    help="From one animal's vessels and one catheter recording to a calibrated, explained pulse-wave model.",
    epilog="Exit status: 0 done; 1 the input or a command is wrong; 3 done, but animals failed; 130 interrupted. "
    "Example: vasowave fit network.csv recording.txt --output my-mouse",
)


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"vasowave {version('vasowave')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and leave.")
    ] = False,
) -> None:
    """Take the options that stand before a command."""
