"""How a lack of memory shows."""

import errno

_SIGNS = (
    "failed to map segment",  # a library that could not be loaded
    "cannot allocate memory",
    "unable to allocate",
    "can't start new thread",
    "can't allocate lock",
    "without setting an exception",  # compiled code that met it
)


def is_starved(error: BaseException | None) -> bool:
    """Whether an error says, in one of its many ways, that there was no memory left."""
    if error is None:
        return False
    if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno == errno.ENOMEM):
        return True
    words = str(error).lower()
    return any(sign in words for sign in _SIGNS) or is_starved(error.__cause__ or error.__context__)
