"""A trial of a search: whatever a law, a model or the solver says of numbers that cannot be, the trial has failed."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from vasowave.errors import NumericalError, VasowaveError

IMPOSSIBLE = (VasowaveError, ArithmeticError, ValueError)
"""What numbers that cannot be may end in; the last two come from laws of users, built-in ones return NaN."""


@contextmanager
def trial() -> Iterator[None]:
    """Raise `NumericalError`, with the reason, for whatever parameters that cannot be end in inside the block."""
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused where it is used
            yield
    except NumericalError:
        raise
    except VasowaveError as error:
        raise NumericalError(str(error)) from error
    except IMPOSSIBLE as error:
        raise NumericalError(f"these parameters make no model ({type(error).__name__}: {error})") from error
