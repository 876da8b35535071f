"""Text files and spreadsheets in blocks of lines: any size in bounded memory, any usual encoding."""

import codecs
import hashlib
import io
import stat
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple, TypeVar

from vasowave.base.errors import InputError
from vasowave.base.io.remembered import remembered
from vasowave.base.io.spreadsheet import is_workbook, sheet_named

LONGEST_LINE = 1_000_000
"""No table has a longer line, in characters."""

_BLOCK = 1 << 20  # letters that are read at a time
_START = 1 << 18  # bytes that are looked at; a table of one cycle or of a network is no longer

_GZIP = b"\x1f\x8b"  # its first bytes

T = TypeVar("T")

Progress = Callable[[float], None]
"""Is called with the fraction of a file that was read, 0 to 1."""


class Lines(NamedTuple):
    """Consecutive lines of a file, without their line ends.

    Attributes
    ----------
    first : int
        Number of the first, counted from 1.
    texts : list of str
    cut : bool
        Whether the last of them ends the file without a line end, as in a file that was cut off.
    """

    first: int
    texts: list[str]
    cut: bool = False

    def hold(self, sign: str) -> bool:
        """Whether a sign occurs in any of them."""
        return any(sign in text for text in self.texts)


def regular_file(path: str | Path) -> Path:
    """Return `path` if it is a file that ends; `InputError` for what is missing, a folder, a pipe or a device."""
    path = Path(path)
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "is not a name of a file"
        raise InputError(f"{path}: {reason.lower()}") from None
    if stat.S_ISDIR(mode):
        raise InputError(f"{path}: is a folder")
    if not stat.S_ISREG(mode):
        raise InputError(f"{path}: is a pipe or a device, not a file; copy its content into a file first")
    return path


class Look(NamedTuple):
    """What a file looks like from outside: its first bytes, all of a short one, and the SHA-256 of all."""

    start: bytes
    sha256: str
    size: int

    @property
    def whole(self) -> bool:
        """Whether the first bytes are all."""
        return self.size == len(self.start)


@remembered
def look(path: str | Path) -> Look:
    """Return what a file looks like; `InputError` if it cannot be read."""

    def looked(file: BinaryIO) -> Look:
        start = file.read(_START)
        digest, size = hashlib.sha256(start), len(start)
        while block := file.read(_START):
            digest.update(block)
            size += len(block)
        return Look(start, digest.hexdigest(), size)

    return _opened(path, looked)


def read_start(path: str | Path, count: int = 4096) -> bytes:
    """Return the first bytes of a file."""
    return _opened(path, lambda file: file.read(count))


def read_bytes(path: str | Path) -> bytes:
    """Return the content of a file; `InputError` if it cannot be read."""
    return _opened(path, lambda file: file.read())


def _opened(path: str | Path, use: Callable[[BinaryIO], T]) -> T:
    path = regular_file(path)
    try:
        with path.open("rb") as file:
            return use(file)
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or 'cannot be read').lower()}") from None


def read_lines(path: str | Path, progress: Progress | None = None, sheet: str = "") -> Iterator[Lines]:
    """Yield the lines of a text file, or the rows of a spreadsheet, in blocks of about a megabyte.

    UTF-8, UTF-16 with its mark, and else cp1252; line ends of every system. Of a workbook the sheet that is named, or
    the first visible one, its cells separated by tabs.

    Raises
    ------
    InputError
        A file that cannot be read, is none, is not text, or has a line above a million characters.
    """
    path = regular_file(path)
    glance = look(path)
    content = sheet_named(path, sheet).content.encode() if is_workbook(glance.start) else None
    if sheet and content is None:
        raise InputError(f"{path}: is not a workbook and has no sheet '{sheet}'; leave the sheet out")
    start = content if content is not None else glance.start if glance.whole else None
    try:
        with io.BytesIO(start) if start is not None else path.open("rb") as file:
            encoding = "utf-8" if content is not None else _encoding(path, file)
            file.seek(0)
            stream = io.TextIOWrapper(file, encoding, errors="replace")
            number, remainder = 1, ""
            while text := stream.read(_BLOCK):
                *texts, remainder = (remainder + text).split("\n")
                _check_length(path, number, [*texts, remainder])
                if texts:
                    yield Lines(number, texts, False)
                number += len(texts)
                if progress:
                    progress(min(file.tell() / max(len(content or b"") or glance.size, 1), 1.0))
            if remainder:
                yield Lines(number, [remainder], True)
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or 'cannot be read').lower()}") from None


def _check_length(path: Path, number: int, texts: list[str]) -> None:
    if max(map(len, texts)) > LONGEST_LINE:
        line = number + next(i for i, text in enumerate(texts) if len(text) > LONGEST_LINE)
        raise _too_long(path, line)


def _too_long(path: Path, line: int) -> InputError:
    return InputError(f"{path}, line {line}: longer than {LONGEST_LINE} characters; not a table, export it again")


def _encoding(path: Path, file: BinaryIO) -> str:
    """Return how the whole file is encoded; `InputError` if it is not text."""
    start = file.read(2)
    if start in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        return "utf-16"
    file.seek(0)
    decoder = codecs.getincrementaldecoder("utf-8")()
    encoding = "utf-8-sig"
    while block := file.read(_BLOCK):
        if b"\0" in block:
            advice = "packed by gzip; unpack it" if start == _GZIP else "not a text file; export it as CSV first"
            raise InputError(f"{path}: {advice}")
        try:
            decoder.decode(block)
        except UnicodeDecodeError:
            encoding = "cp1252"
    return encoding
