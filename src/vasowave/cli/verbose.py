"""What --verbose adds on the standard error: with what a command ran, how long, in how much memory, where it failed."""

import platform
import sys
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager

import typer

from vasowave.errors import VasowaveError


@contextmanager
def told() -> Iterator[None]:
    """Say versions before what is done inside, and afterwards time, memory and the place of an error."""
    from vasowave.provenance import versions
    from vasowave.runtime.threads import threads

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
