"""The command line. Commands call the faces of the parts, which load what is asked for: help answers at once."""

import sys
import threading
import warnings
from typing import TYPE_CHECKING, NoReturn

import typer

from vasowave.base.errors import InputError, VasowaveError, VasowaveWarning
from vasowave.base.findings import finding_of, sentence
from vasowave.base.runtime.interrupts import interrupt_main, is_interrupt
from vasowave.base.runtime.memory import is_starved
from vasowave.base.runtime.thread_limits import spare_threads
from vasowave.cli.app import FAILED, WRONG_INPUT, app
from vasowave.cli.cures import Shell, code_of

# The order of import is the order of the help.
# isort: off
from vasowave.cli import study, workbench, fit, simulate, predict, extract  # noqa: F401  they register their commands
# isort: on

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

_INTERRUPTED = 130  # exit status after Ctrl-C
_AGAIN = 0.02  # s after which an interruption that was lost comes again


def run() -> None:
    """Run the command line; every error of ours becomes one readable message and its exit status."""

    def show(message: Warning | str, category: type[Warning], *args: object, **kwargs: object) -> None:
        if issubclass(category, VasowaveWarning):
            finding = finding_of(message)
            place = f"{finding.place}: " if finding.place.file else ""
            below = code_of(finding) + Shell().below(finding.cures)
            typer.echo(f"Warning: {place}{sentence(finding)}{below}", err=True)

    warnings.showwarning = show
    sys.unraisablehook = interrupt_again
    spare_threads()
    try:
        app()
    except VasowaveError as error:
        typer.echo(f"Error: {error}{Shell().below(error.cures)}", err=True)
        sys.exit(WRONG_INPUT if isinstance(error, InputError) else FAILED)
    except Exception as error:
        if is_interrupt(error):
            _leave_interrupted()
        if not is_starved(error):
            raise
        typer.echo(
            "Error: out of memory; what had finished is kept; give this program more of it and run again", err=True
        )
        sys.exit(FAILED)
    except SystemExit as leaving:
        if leaving.code == _INTERRUPTED:
            _leave_interrupted()
        raise


def _leave_interrupted() -> NoReturn:
    typer.echo("Interrupted; nothing half-written was left.", err=True)
    sys.exit(_INTERRUPTED)


def interrupt_again(lost: "UnraisableHookArgs") -> None:
    """Interrupt the program once more if Ctrl-C fell into a destructor, where Python drops every exception."""
    if issubclass(lost.exc_type, KeyboardInterrupt):
        threading.Timer(_AGAIN, interrupt_main).start()
    else:
        sys.__unraisablehook__(lost)
