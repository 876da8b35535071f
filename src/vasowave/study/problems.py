"""What is wrong or odd about a study, with the place where a person mends it."""

from collections.abc import Iterable
from dataclasses import dataclass

from vasowave.errors import InputError


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong or odd.

    Attributes
    ----------
    place : str
        ``study.yaml, line 12, column 3`` or ``animals.csv, line 4, column 'group'``.
    message : str
        What is wrong and what to do.
    error : bool
        True if the study cannot run like this, False if it is only odd.
    """

    place: str
    message: str
    error: bool = True

    def __str__(self) -> str:
        return f"{self.place}: {self.message}"


def refuse(problems: Iterable[Problem]) -> None:
    """Raise one `InputError` that lists every error among `problems`."""
    errors = [str(problem) for problem in problems if problem.error]
    if len(errors) == 1:
        raise InputError(errors[0])
    if errors:
        raise InputError(f"{len(errors)} errors:\n" + "\n".join(f"  {error}" for error in errors))
