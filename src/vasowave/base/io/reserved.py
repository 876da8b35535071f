"""Texts in a file that has its room from the beginning, so that they can be written when a disk is full, too.

Each has a slot, a page of memory, which is overwritten in place: a check sum, the text, blanks. Whoever reads one that
is being written, or was damaged, finds an empty one.
"""

import os
import zlib
from contextlib import suppress
from io import FileIO
from pathlib import Path

from vasowave.base.runtime.writing import open_regular, put

SLOT = 4096
"""Bytes."""


def reserve(path: Path, slots: int) -> FileIO:
    """Return a new file of empty slots, open; where there is no room for one, that of before. Raises `OSError`."""
    try:
        put(path, [b" " * (SLOT * slots)], 0o644)
    except OSError:
        with suppress(OSError):
            return opened(path, slots)
        raise
    return opened(path, slots)


def opened(path: Path, slots: int, flags: int = os.O_RDWR) -> FileIO:
    """Return a file of slots that is there, open; `OSError` if it is none: a link, a pipe, another size."""
    file = FileIO(open_regular(path, flags), "rb" if flags == os.O_RDONLY else "rb+")
    if os.fstat(file.fileno()).st_size == SLOT * slots:
        return file
    file.close()
    raise OSError(f"{path}: no file of {slots} slots")


def write_slot(file: FileIO, slot: int, text: str) -> None:
    """Overwrite a text (ASCII) and wait until it is on the disk; `OSError` where that fails."""
    line = f"{zlib.crc32(text.encode()):08x} {text}".encode("ascii")
    if len(line) > SLOT:
        raise OSError("a text longer than its slot")
    file.seek(slot * SLOT)
    file.write(line.ljust(SLOT))
    os.fsync(file.fileno())


def read_slots(path: Path, slots: int) -> list[str]:
    """Return the text of every slot, empty where there is none, or no file."""
    content = b""
    with suppress(OSError), opened(path, slots, os.O_RDONLY) as file:
        content = file.read()
    pieces = (content[slot * SLOT : (slot + 1) * SLOT].rstrip().partition(b" ") for slot in range(slots))
    return [text.decode("ascii", "replace") if check == b"%08x" % zlib.crc32(text) else "" for check, _, text in pieces]
