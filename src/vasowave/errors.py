"""What can go wrong, as one tree.

::

    VasowaveError
    ├── InputError(ValueError)         a file, table, argument or configuration is wrong
    └── NumericalError(RuntimeError)   the input is fine, but no trustworthy number came out

    VasowaveWarning(UserWarning)       a number came out, and somebody should look at it

Every message says what is wrong, where, and what to do next.
"""

from collections.abc import Iterable
from difflib import get_close_matches


class VasowaveError(Exception):
    """Base of every error that vasowave raises on purpose."""


class InputError(VasowaveError, ValueError):
    """A file, a table, an argument or a configuration is wrong."""


class NumericalError(VasowaveError, RuntimeError):
    """The computation could not produce a number that can be trusted."""


class VasowaveWarning(UserWarning):
    """A result exists, but something about it needs a look."""


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return ``" (did you mean 'x'?)"`` for the known word nearest to `word`, or an empty string."""
    near = get_close_matches(word, list(known), n=1, cutoff=0.6)
    return f" (did you mean '{near[0]}'?)" if near else ""
