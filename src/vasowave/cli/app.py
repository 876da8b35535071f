"""The command that all commands hang on."""

import platform
import sys
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from vasowave.base.errors import VasowaveError
from vasowave.base.runtime.thread_limits import threads
from vasowave.cli.signatures import OPTIONS, TYPED, VERBOSE

WRONG_INPUT, FAILED = 1, 3
"""Exit status: a file, a value or a study is wrong; the input is fine, but (an animal's) numbers did not come out.

2 is Click's own, for a command line that it does not understand, 130 an interruption.
"""

_WITH_SETTINGS = ("add", "fit", "indices", "loops", "posterior", "extract")


class Commands(TyperGroup):
    """The commands. Options made from settings are made when a command is called: to load them takes seconds."""

    def resolve_command(self, ctx: Any, args: list[str]) -> tuple[str | None, Any, list[str]]:
        """Return name, command and the arguments that follow."""
        name, command, arguments = super().resolve_command(ctx, args)
        if name in _WITH_SETTINGS:
            from vasowave.cli.options import with_settings

            command = with_settings(name, command)
        if command is not None:
            _refuse_repeated(ctx, command, arguments)
            OPTIONS.set(frozenset(option for parameter in command.params for option in
                                  (*parameter.opts, *parameter.secondary_opts)))  # fmt: skip
        return name, command, arguments

    def invoke(self, ctx: Any) -> Any:
        """Run a command; with --verbose say with what, for how long, and where in the program an error arose."""
        VERBOSE.set(bool(ctx.params.get("verbose")))
        TYPED.set(None)
        if not VERBOSE.get():
            return super().invoke(ctx)
        with verbose_report():
            return super().invoke(ctx)


def _refuse_repeated(ctx: Any, command: Any, arguments: list[str]) -> None:
    """Refuse an option of one value that was typed twice, of which Click would take the last without a word."""
    context = command.make_context(command.name, [*arguments], parent=ctx, resilient_parsing=True)
    _, _, order = command.make_parser(context).parse_args([*arguments])
    for option, count in Counter(parameter for parameter in order if parameter.param_type_name == "option").items():
        if count > 1 and not (option.multiple or option.is_flag or option.count):
            context.fail(f"{option.opts[0]} is given {count} times and takes one value; give it once")


app: typer.Typer = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    help="From one animal's vessels and one catheter recording to a calibrated, explained pulse-wave model.",
    epilog="Exit status: 0 done; 1 the input is wrong; 2 the command line is; 3 the input is fine, but numbers (of an "
    "animal) did not come out; 130 interrupted. "
    "Example: vasowave fit network.csv recording.txt --output my-mouse",
)


def _show_version(requested: bool) -> None:
    if requested:
        from importlib.metadata import version

        typer.echo(f"vasowave {version('vasowave')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and leave.")
    ] = False,
    verbose: Annotated[
        bool, typer.Option("--verbose", "-v", help="Say versions, time and memory, and where an error arose.")
    ] = False,
) -> None:
    """Take the options that stand before a command."""


@contextmanager
def verbose_report() -> Iterator[None]:
    """Say versions before what is done inside, and afterwards time, memory and the place of an error."""
    from vasowave.base.software import versions

    used = ", ".join(f"{name} {number}" for name, number in versions().items())
    typer.echo(f"Python {platform.python_version()}, {used}; {platform.platform()}, {threads()} threads", err=True)
    wall, processor = time.monotonic(), time.process_time()
    try:
        yield
    except VasowaveError:
        traceback.print_exc()
        raise
    finally:
        passed, worked = time.monotonic() - wall, time.process_time() - processor
        typer.echo(f"{passed:.1f} s, {worked:.1f} s of the processor{_memory()}", err=True)


def _memory() -> str:
    """Return the most memory that the process had at once, in words; empty where the system does not say."""
    try:
        import resource
    except ImportError:  # Windows
        return ""
    unit = 1 if sys.platform == "darwin" else 1024
    return f", {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 2**20:.0f} MB at most"
