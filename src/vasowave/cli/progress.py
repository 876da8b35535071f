"""Tables of the work that is to be done, and signs of life while it is done."""

import shutil
import textwrap
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager

import typer
from rich.console import Console

from vasowave.base.errors import printable
from vasowave.base.runtime.thread_limits import cores
from vasowave.pulse import model as laws
from vasowave.study import folder as folders
from vasowave.study import results

SAY = 60.0
"""Seconds between the lines that long work writes where there is no terminal."""


def show_animals(rows: "Sequence[Sequence[str]]") -> None:
    """Print what was read of every animal, a row of cells each."""
    for line in results.overview_lines(rows, terminal_width()):
        typer.echo(line)


def work_of(read: "Sequence[results.AnimalRead]", settings: "folders.StudyFile") -> str:
    """Return how much there is to do, in words."""
    seconds = results.expected_seconds(read, settings, cores())
    walls, starts = settings.calibration.walls, settings.calibration.starts
    rows = "Recordings" if settings.design.subject else "Animals"
    return (
        f"{rows} {len(read)}; wall laws {', '.join(map(laws.plain, walls))}; {starts} starts of each fit: roughly "
        f"{rough_time(seconds)} with the report here ({cores()} cores), less where results are kept."
    )


def rough_time(seconds: float) -> str:
    """Return a time to one or two digits, in the unit that people take for it."""
    if seconds < 95:
        return f"{max(10, round(seconds, -1)):.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 95 * 60 else f"{seconds / 3600:.1f} h"


def print_table(rows: Sequence[tuple[str, ...]], left_aligned: tuple[int, ...], remarks: Iterable[str] = ()) -> None:
    """Print rows, of which some columns are words, and remarks below them."""
    for line in results.aligned(rows, left_aligned):
        typer.echo(line)
    for remark in remarks:
        print_text(remark)


def terminal_width() -> int:
    """Return the columns of the terminal, 80 where there is none."""
    return shutil.get_terminal_size((80, 24)).columns


def print_text(text: str, err: bool = False) -> None:
    """Print a sentence in lines that a terminal does not break within words; whole where there is no terminal."""
    console, text = Console(stderr=err), printable(text)
    lines = [
        line
        for paragraph in text.split("\n")  # the commands below a finding stand in lines of their own
        for line in textwrap.wrap(paragraph, max(20, terminal_width()), subsequent_indent="  ", break_long_words=False,
                                  break_on_hyphens=False)
    ]  # fmt: skip
    typer.echo("\n".join(lines) if console.is_terminal else text, err=err)


@contextmanager
def waiting(doing: str) -> Iterator[None]:
    """Show on a terminal that what is inside goes on; elsewhere, in a line a minute (`alive`)."""
    console = Console(stderr=True)
    with console.status(f"{doing} …") if console.is_terminal else alive(doing):
        yield


def time_left(seconds: float) -> str:
    """Say how long work may still take."""
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 1.5 * size:
            return f"about {seconds / size:.0f} {unit} left"
    return f"about {seconds:.0f} s left"


@contextmanager
def alive(doing: str | Callable[[], str], interval: float = SAY) -> Iterator[None]:
    """Write a line a minute to the standard error while what is inside goes on, if there is no terminal.

    Logs of clusters show by it that a program lives.

    Parameters
    ----------
    doing : str or callable
        What is being done, or what returns it.
    interval : float
        s between lines.
    """
    if Console(stderr=True).is_terminal:
        yield
        return
    begun, ended = time.monotonic(), threading.Event()

    def repeat() -> None:
        while not ended.wait(interval):
            text = doing if isinstance(doing, str) else doing()
            typer.echo(f"{(time.monotonic() - begun) / 60:.0f} min: {text}", err=True)

    teller = threading.Thread(target=repeat, daemon=True)
    teller.start()
    try:
        yield
    finally:
        ended.set()
        teller.join()
