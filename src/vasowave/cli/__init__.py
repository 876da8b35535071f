"""The command line. Heavy modules are imported where they are used, so that help answers at once."""

import sys
import warnings

import typer

from vasowave.cli import extract, mouse  # noqa: F401  register their commands
from vasowave.cli.app import app


def run() -> None:
    """Run the command line; every error of ours becomes one readable message and exit status 1."""
    from vasowave.errors import VasowaveError, VasowaveWarning

    def show(message: Warning | str, category: type[Warning], *rest: object, **more: object) -> None:
        if issubclass(category, VasowaveWarning):
            typer.echo(f"Warning: {message}", err=True)

    warnings.showwarning = show
    try:
        app()
    except VasowaveError as error:
        typer.echo(f"Error: {error}", err=True)
        sys.exit(1)
    except KeyboardInterrupt:
        _interrupted()
    except SystemExit as end:
        if end.code == 130:  # Typer takes the interrupt for itself
            _interrupted()
        raise


def _interrupted() -> None:
    typer.echo("Interrupted; nothing was written.", err=True)
    sys.exit(130)


__all__ = ["app", "run"]
