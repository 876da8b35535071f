"""What a command says of a study, printed as it is said, and said again at once while nothing has changed."""

import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer

from vasowave.base import io
from vasowave.base.runtime.thread_limits import cores
from vasowave.cli.progress import print_text, show_animals
from vasowave.cli.signatures import VERBOSE
from vasowave.study import folder as folders
from vasowave.study import running

_PRINT: dict[str, Callable[..., None]] = {"line": typer.echo, "text": print_text, "animals": show_animals,
          "count": lambda count: None}  # fmt: skip


class Answer:
    """What a command says to one question.

    Holds state because what was printed is kept for the next time.

    Parameters
    ----------
    command : str
    study : Path
        As it was typed.
    options : str
        That decide about what is said.
    """

    def __init__(self, command: str, study: Path, *options: str) -> None:

        place = os.path.realpath(study)  # of what was typed, which is said, too
        self._question = (command, place, str(study), *options, str(cores()), str(VERBOSE.get()))
        self._lines: list[tuple[str, Any]] = []

    def announce(self, kind: str, content: Any, next_time: str = "") -> None:
        """Print a ``line``, a ``text`` that a terminal does not break within words, or the rows of ``animals``; their
        ``count`` is only kept.
        """
        self._lines.append((kind, next_time or content))
        _PRINT[kind](content)

    def recalled(self) -> Sequence[tuple[str, Any]] | None:
        """Return what was said, if nothing has changed since."""
        lines: Sequence[tuple[str, Any]] | None = io.answer_to(self._question)
        return lines

    def repeated(self) -> bool:
        """Say again what was said, if nothing has changed since; return whether that is so."""
        lines = self.recalled()
        for kind, content in lines or ():
            self.announce(kind, content)
        return lines is not None

    @contextmanager
    def recorded(self, study: Path, ran: bool = False) -> Iterator[None]:
        """Keep what is said inside, if no warning is given and no file of the study changes meanwhile."""
        before, show, warned = running.basis_of_study(study), warnings.showwarning, []

        def shown(*warning: Any, **keywords: Any) -> None:
            warned.append(warning)
            show(*warning, **keywords)

        warnings.showwarning = shown
        try:
            yield
        finally:
            warnings.showwarning = show
        if before is not None and not warned and running.basis_of_study(study) == before:
            basis = running.with_outcome(before, folders.study_path(study).parent, ran)
            io.keep_answer(self._question, basis, self._lines)
