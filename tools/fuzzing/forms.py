"""What the fuzzer knows of one format."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

Mutate = Callable[[bytes, np.random.Generator], bytes]


class Form(NamedTuple):
    """How sound files are made, one of them damaged, and all of them read.

    Attributes
    ----------
    write : callable
        Writes the sound files into an empty folder.
    opened : str
        What is opened in the folder; "." is the folder itself.
    damaged : str
        The file in it that is damaged.
    mutate : callable
        From sound bytes and a generator to damaged ones.
    read : callable
        From the path that is opened to what the reader returns.
    structure : callable
        From that to what must not change without a word: counts, parents, rates.
    values : callable
        From that to its numbers, a list of arrays.
    notes : callable
        From that to what the reader says of it.
    text : bool
        Whether a person could read the file: then no change of structure may go unsaid.
    exact : bool
        Whether it has a check sum, or belongs to something that has: then no change at all may go unsaid.
    """

    write: Callable[[Path], object]
    opened: str
    damaged: str
    mutate: Mutate
    read: Callable[[Path], Any]
    structure: Callable[[Any], object]
    values: Callable[[Any], list[Any]]
    notes: Callable[[Any], set[str]] = lambda found: set()
    text: bool = False
    exact: bool = False
