"""The command `vasowave extract`, run in this process."""

import warnings

from typer.testing import CliRunner

from vasowave.base import VasowaveWarning
from vasowave.cli import app


def run(*arguments):
    """Run `vasowave extract` and return (result, messages of its warnings)."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", VasowaveWarning)
        result = CliRunner().invoke(app, ["extract", *map(str, arguments)])
    return result, [str(note.message) for note in told if issubclass(note.category, VasowaveWarning)]
