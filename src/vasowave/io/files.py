"""The one way into files and folders: whole or not at all.

What is written stands first under a hidden name beside its place, is flushed to the disk, and then takes its place by
renaming. A link is replaced, never written through.
"""

import errno
import os
import shutil
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from vasowave.errors import InputError
from vasowave.runtime.kept import PART, put
from vasowave.runtime.locks import lock_open_file

_HELD = "held"  # a file in an unfinished folder, locked by the program that fills it
_FORGOTTEN = 3600.0  # s; an unfinished piece that is older belongs to no program that still runs
_FULL = {errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC)}
_REASONS = {
    errno.EFBIG: "it is larger than this system or its limits allow",
    errno.EROFS: "the disk is read-only; choose another place",
    errno.EACCES: "you have no permission to write there; choose another place",
    errno.EPERM: "you have no permission to write there; choose another place",
    errno.ENOENT: "its folder does not exist",
    errno.ENOTDIR: "something on the way to it is a file; choose another place",
    errno.EISDIR: "it is a folder; give the name of a file",
    errno.ELOOP: "it is a link; remove it",
    errno.ENAMETOOLONG: "its name is too long",
}


def write_file(path: Path, content: bytes | str) -> Path:
    """Put a file in its place, whole or not at all, and return its path.

    Parameters
    ----------
    path : Path
        What stands there is replaced; a link is replaced too, not followed.
    content : bytes or str
        Text is written as UTF-8.

    Raises
    ------
    InputError
        It could not be written; what stood there before still does.
    """
    path = Path(path)
    try:
        put(path, [content.encode() if isinstance(content, str) else content], 0o644)
        flush(path.parent)
    except OSError as error:
        raise not_written(path, error) from None
    return path


@contextmanager
def write_folder(folder: Path) -> Iterator[Path]:
    """Give an empty folder to fill; at the end everything in it moves into `folder`, or nothing does.

    Each file or folder replaces its namesake in one step, pages (``.html``) last, so that a page never speaks of what
    is not there yet. Whatever else `folder` holds stays.

    Raises
    ------
    InputError
        `folder` cannot be written; what stood there before still does.
    """
    folder = Path(folder)
    made = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        remove_parts(folder, _FORGOTTEN)
        with tempfile.TemporaryDirectory(prefix=PART, dir=folder) as name, _held(Path(name)):
            fresh, aside = Path(name) / "new", Path(name) / "old"
            fresh.mkdir()
            aside.mkdir()
            yield fresh
            for file in fresh.rglob("*"):
                flush(file)
            _move(fresh, folder, aside)
            flush(folder)
    except OSError as error:
        raise not_written(folder, error) from error
    finally:
        if made and folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()


def _move(fresh: Path, folder: Path, aside: Path) -> None:
    """Move all from `fresh` into `folder`, what is replaced to `aside`; undo it if a step fails."""
    done: list[str] = []
    try:
        for item in sorted(fresh.iterdir(), key=lambda path: (path.suffix == ".html", path.name)):
            done.append(item.name)
            if os.path.lexists(folder / item.name):
                os.replace(folder / item.name, aside / item.name)
            os.replace(item, folder / item.name)
    except OSError:
        for name in reversed(done):
            if not (fresh / name).exists():
                os.replace(folder / name, fresh / name)
            if os.path.lexists(aside / name):
                os.replace(aside / name, folder / name)
        raise


@contextmanager
def _held(part: Path) -> Iterator[None]:
    """Show others, as long as this program lives, that an unfinished folder is being filled."""
    with (part / _HELD).open("ab") as file:
        with suppress(OSError):  # a file system without locks
            lock_open_file(file.fileno())
        yield


def _is_left(part: Path) -> bool:
    """Whether an unfinished folder belonged to a program that has ended."""
    try:
        with (part / _HELD).open("rb+") as file:
            lock_open_file(file.fileno())
    except OSError:
        return False
    return True


def remove_parts(folder: Path, age: float = 0.0) -> None:
    """Remove what a killed program left unfinished in `folder`, if that is known or it is older than `age` (s)."""
    for rest in folder.glob(f"{PART}*"):
        if time.time() - rest.lstat().st_mtime < age and not _is_left(rest):
            continue
        if rest.is_dir() and not rest.is_symlink():
            shutil.rmtree(rest, ignore_errors=True)
        else:
            rest.unlink(missing_ok=True)


def check_folder(folder: Path, marks: Mapping[str, bytes]) -> None:
    """Raise `InputError`, before anything is computed, unless results may and can be written into `folder`.

    It must be missing, empty, or hold an earlier result, known by its `marks`: names of files and what they contain. An
    unfinished piece is a mark, too: of a program that was killed while it wrote here.
    """
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file; give the name of a folder")
    check_writable(folder)
    if not folder.exists():
        return
    there = [one.name for one in folder.iterdir()]
    unfinished = any(name.startswith(PART) for name in there)
    if there and not unfinished and not any(_has_mark(folder / name, mark) for name, mark in marks.items()):
        raise InputError(f"{folder} is not empty and not a vasowave result; give another folder or empty it first")


def check_writable(folder: Path) -> None:
    """Raise `InputError` now, not after hours, if nothing can be written into `folder`, which may have to be made."""
    place = next(one for one in (folder.absolute(), *folder.absolute().parents) if one.exists())
    try:
        with tempfile.TemporaryDirectory(prefix=PART, dir=place):
            pass
    except OSError as error:
        raise not_written(folder, error) from None


def check_file(path: Path, *endings: str) -> None:
    """Raise `InputError`, before anything is computed, if the file `path` cannot be written.

    Its name must have one of the `endings`, where any are given: they say what is written.
    """
    if path.is_dir():
        raise InputError(f"{path} is a folder; give the name of a file")
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}; make it first")
    if endings and path.suffix.lower() not in endings:
        raise InputError(f"{path}: the name of this file ends in {' or '.join(endings)}")
    check_writable(path.parent)


def made_inside(folder: Path, name: str) -> Path:
    """Return the folder `name` inside `folder`, made if missing.

    Raises
    ------
    InputError
        It is a link that leads out of `folder`, or cannot be made.
    """
    inner = folder / name
    try:
        inner.resolve().stat()
    except FileNotFoundError:
        pass
    except (OSError, RuntimeError) as error:  # of links in a circle, which the systems and versions call by many names
        raise InputError(f"{inner}: cannot be opened ({error}); is it a link to itself? Remove it") from None
    if not inner.resolve().is_relative_to(folder.resolve()):
        raise InputError(f"{inner} is a link that leads out of {folder}; put a folder in its place, or move the whole")
    try:
        inner.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise not_written(inner, error) from None
    return inner


def is_full(error: BaseException) -> bool:
    """Whether an error says that the disk, or the quota on it, is full."""
    return isinstance(error, OSError) and error.errno in _FULL


def not_written(path: Path, error: OSError) -> InputError:
    """Return the error that says why `path` could not be written, and what to do."""
    if is_full(error):
        return InputError(f"{path}: no space left; what had finished is kept, make room and run again")
    reason = _REASONS.get(error.errno or 0) or error.strerror or str(error)
    return InputError(f"{path}: cannot be written: {reason} (what had finished is kept)")


def flush(path: Path) -> None:
    """Wait until a file or folder is on the disk, not only in memory."""
    if path.is_symlink():
        return
    flags = os.O_RDONLY if path.is_dir() or os.name != "nt" else os.O_RDWR
    try:
        handle = os.open(path, flags)
    except PermissionError:  # Windows does not open folders
        return
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _has_mark(path: Path, mark: bytes) -> bool:
    return path.is_file() and mark in path.read_bytes()
