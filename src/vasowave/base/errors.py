"""The errors of the package, as one tree.

::

    VasowaveError
    ├── InputError(ValueError)         a file, table, argument or configuration is wrong
    └── NumericalError(RuntimeError)   the input is fine, but no trustworthy number came out

    VasowaveWarning(UserWarning)       a number came out, and somebody should look at it

Every message says what is wrong, where, and what to do next.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from difflib import get_close_matches

from vasowave.base.cures import Cure, arguments

EXTRAS = "`uv tool install '.[imaging,pdf,workbench]'` in a copy of the repository"
"""How a program gets the libraries that not everybody needs."""


_UNSEEN = re.compile("[\0-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


def printable(text: str) -> str:
    """Return a text that steers no terminal: names in files from elsewhere may hold signs that do."""
    return _UNSEEN.sub("?", text)


class VasowaveError(Exception):
    """Base of every error that vasowave raises on purpose.

    Parameters
    ----------
    text : str
        What is wrong, where, and what to do next, in words that fit every door.
    cures : sequence of Cure
        The same as what a door can do; Python shows them below the error.
    """

    def __init__(self, text: object = "", cures: Sequence[Cure] = ()) -> None:
        super().__init__(text)
        self.cures: tuple[Cure, ...] = tuple(cures)
        for line in arguments(self.cures):
            self.add_note(line)

    def __str__(self) -> str:
        """Return what is wrong, where, and what to do next."""
        return printable(super().__str__())


class InputError(VasowaveError, ValueError):
    """A file, a table, an argument or a configuration is wrong."""


class NumericalError(VasowaveError, RuntimeError):
    """The computation could not produce a number that can be trusted."""


class VasowaveWarning(UserWarning):
    """A result exists, but something about it needs a look."""


@contextmanager
def of_file(path: object) -> Iterator[None]:
    """Put the name of a file before the errors of code that does not know it."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{path}: {error}", error.cures) from None


def did_you_mean(word: str, words: Iterable[str]) -> str:
    """Return ``" (did you mean 'x'?)"`` for the known word nearest to `word`, or an empty string."""
    by_letters = {candidate.casefold(): candidate for candidate in words}
    matches = get_close_matches(word.casefold(), list(by_letters), n=1, cutoff=0.6)
    return f" (did you mean '{by_letters[matches[0]]}'?)" if matches else ""
