"""The one way into files and folders: whole or not at all, and only where nobody else wrote meanwhile.

What is written stands first under a hidden name beside its place, is flushed to the disk, and then takes its place by
renaming (see `runtime.writing`). A link is replaced, never written through. Whoever writes into a folder is alone in it
(`alone_in`), and what was read before is compared with what is there, for an editor takes no lock.
"""

import errno
import os
import shutil
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from pathlib import Path

from vasowave.base.errors import InputError
from vasowave.base.runtime.locks import lock_open_file
from vasowave.base.runtime.writing import PART, Part, flush, open_regular, opened, put

FOLDER_LOCK = ".vasowave.lock"
"""A file in a folder of files that belong together, locked by whoever writes into them."""

_HELD = "held"  # a file in an unfinished folder, locked by the program that fills it
_FORGOTTEN = 3600.0  # s; an unfinished piece that is older belongs to no program that still runs
_BEGUN = 2.0  # s; a file that is younger may be about to be locked
_PATIENCE_SECONDS = 10.0  # to wait for another program that writes into the same folder
_POLL_SECONDS = 0.005  # between two tries
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
    errno.EMLINK: "the file has a second name elsewhere (a hard link); remove it, or put a copy in its place",
    errno.ENXIO: "it is a pipe or a device; remove it",
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
    write_files({Path(path): content})
    return Path(path)


def write_files(
    contents: Mapping[Path, bytes | str | None], contents_read: Mapping[Path, bytes | None] | None = None
) -> None:
    """Put several files in their places, all or none; None removes a file.

    Parameters
    ----------
    contents : mapping of Path to bytes, str or None
    contents_read : mapping of Path to bytes or None, optional
        What files held when they were read, from which the new contents were made.

    Raises
    ------
    InputError
        A file does not hold any more what was seen; something could not be written. All are as they were.
    """
    contents_read, before = contents_read or {}, dict[Path, bytes | None]()
    done, unfinished = list[Path](), dict[Path, Part]()
    with ExitStack() as stack:
        try:
            for path, content in contents.items():
                if content is not None:
                    unfinished[path] = stack.enter_context(Part(path))
                    unfinished[path].write(content.encode() if isinstance(content, str) else content)
                    unfinished[path].end()
            before |= {
                path: content_of(path) for path in {**contents, **contents_read} if contents_read or len(contents) > 1
            }
            if changed := [path for path, content in contents_read.items() if before[path] != content]:
                raise InputError(f"{changed[0]} was changed elsewhere meanwhile; nothing was written; do it again")
            for path in contents:
                done.append(path)
                unfinished[path].take_place() if path in unfinished else path.unlink(missing_ok=True)
            for folder in {path.parent for path in contents}:
                flush(folder)
        except OSError as error:
            for path in filter(before.__contains__, done):
                with suppress(OSError):
                    path.unlink(missing_ok=True) if (was := before[path]) is None else put(path, [was])
            raise not_written([*contents][max(0, len(done) - 1)], error) from None


def content_of(path: Path) -> bytes | None:
    """Return what a file holds, None where there is none; `InputError` where it cannot be read."""
    try:
        with opened(path, links=True) as handle, open(handle, "rb", closefd=False) as file:
            return file.read()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or 'cannot be read').lower()}") from None


@contextmanager
def link_without_signs(target: Path) -> Iterator[Path]:
    """Lend a link to a file or folder by a name without blanks and signs, which an address can hold."""
    with tempfile.TemporaryDirectory() as folder:
        link = Path(folder, "store")
        link.symlink_to(target.absolute(), target_is_directory=target.is_dir())
        yield link


@contextmanager
def in_words(path: Path) -> Iterator[None]:
    """Make an error of the system inside one of ours, which says why `path` could not be written."""
    try:
        yield
    except OSError as error:
        raise not_written(path, error) from None


def copy_file(source: Path, place: Path) -> None:
    """Put a file that is never changed in a further place; linked, where the file system can."""
    with in_words(place):
        place.unlink(missing_ok=True)
        try:
            os.link(source, place)
        except OSError:  # no links on this file system
            put(place, [source.read_bytes()])


def take_free_place(source: Path, place: Path) -> None:
    """Move a file to a place where none is; `FileExistsError` where one is."""
    try:
        os.link(source, place)  # unlike a renaming it never takes another's place
    except OSError:
        if os.path.lexists(place):
            raise
        os.rename(source, place)  # a file system without links


def remove_file(path: Path) -> None:
    """Remove a file, or the link in its place, if one is there; `InputError` where that fails."""
    with in_words(path):
        path.unlink(missing_ok=True)


def make_folder(folder: Path, mode: int = 0o777) -> Path:
    """Return a folder, made with those above it where it is missing; `InputError` where that fails."""
    with in_words(folder):
        folder.mkdir(mode, parents=True, exist_ok=True)
    return folder


class _Turn:
    """Whose turn it is among the threads of this program, and how often it entered."""

    def __init__(self) -> None:
        self.lock, self.depth = threading.RLock(), 0


_TURNS: dict[Path, _Turn] = {}


@contextmanager
def alone_in(folder: Path | None) -> Iterator[None]:
    """Be the only thread, and the only program, that writes into a folder, if one is named; within itself it is one.

    Raises
    ------
    InputError
        Another program writes into it for longer than one waits; the lock cannot be made, or is a link, a pipe or a
        device.
    """
    if folder is None:
        yield
        return
    turn = _TURNS.setdefault(folder.resolve(), _Turn())
    with turn.lock:
        turn.depth += 1
        try:
            with _program_alone(folder) if turn.depth == 1 and folder.is_dir() else nullcontext():
                yield
        finally:
            turn.depth -= 1


@contextmanager
def _program_alone(folder: Path) -> Iterator[None]:
    path, ends = folder / FOLDER_LOCK, time.monotonic() + _PATIENCE_SECONDS
    with in_words(path):
        try:
            handle = open_regular(path, os.O_RDWR | os.O_CREAT)
        except PermissionError:  # made by another user of a folder that is shared
            handle = open_regular(path)
    try:
        while not _is_locked(handle):
            if time.monotonic() > ends:
                raise InputError(f"{folder}: another program is writing into it; try again")
            time.sleep(_POLL_SECONDS)
        remove_parts(folder, _FORGOTTEN)
        yield
    finally:
        os.close(handle)


def _is_locked(handle: int) -> bool:
    """Lock a file, if nobody else has it; a file system without locks lets everybody."""
    try:
        lock_open_file(handle)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


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
    made = not os.path.exists(folder)
    try:
        make_folder(folder)
        remove_parts(folder, _FORGOTTEN)
        with (
            tempfile.TemporaryDirectory(prefix=PART, dir=folder, ignore_cleanup_errors=True) as name,
            _held(Path(name)),
        ):
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
        if made:
            with suppress(OSError):  # it holds something
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
def _held(folder: Path) -> Iterator[None]:
    """Show others, as long as this program lives, that an unfinished folder is being filled."""
    with opened(folder / _HELD, os.O_RDWR | os.O_CREAT) as handle:
        _is_locked(handle)
        yield


def _is_left(path: Path) -> bool:
    """Whether an unfinished file or folder belonged to a program that has ended."""
    try:
        place = path / _HELD if path.is_dir() else path
        with opened(place, os.O_RDWR, links=not path.is_symlink()) as handle:
            lock_open_file(handle)
    except OSError:
        return False
    return True


def remove_parts(folder: Path, age: float = 0.0) -> None:
    """Remove what a killed program left unfinished in `folder`, if that is known or it is older than `age` (s)."""
    with suppress(OSError):  # what stays is removed another time
        for path in folder.glob(f"{PART}*"):
            since = time.time() - path.lstat().st_mtime
            if since < age and not ((since > _BEGUN or path.is_dir()) and _is_left(path)):
                continue
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)


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
    names = [entry.name for entry in folder.iterdir()]
    unfinished = any(name.startswith(PART) for name in names)
    if names and not unfinished and not any(_has_mark(folder / name, mark) for name, mark in marks.items()):
        raise InputError(f"{folder} is not empty and not a vasowave result; give another folder or empty it first")


def check_writable(folder: Path) -> None:
    """Raise `InputError` now, not after hours, if nothing can be written into `folder`, which may have to be made."""
    place = next(ancestor for ancestor in (folder.absolute(), *folder.absolute().parents) if os.path.exists(ancestor))
    remove_parts(place, _FORGOTTEN)
    with in_words(folder), Part(place / "tried"):
        pass


def check_file(path: Path, *endings: str) -> None:
    """Raise `InputError`, before anything is computed, if the file `path` cannot be written.

    Its name must have one of the `endings`, where any are given: they say what is written.
    """
    if path.is_dir():
        raise InputError(f"{path} is a folder; give the name of a file")
    if path.exists() and not path.is_file():
        raise InputError(f"{path} is a pipe or a device; give the name of a file")
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}; make it first")
    if endings and path.suffix.lower() not in endings:
        raise InputError(f"{path}: the name of this file ends in {' or '.join(endings)}")
    check_writable(path.parent)


def lies_inside(folder: Path, name: str) -> bool:
    """Whether a name, and all links on its way, stay inside a folder."""
    try:
        home, path = folder.resolve(), (folder / name).resolve()
    except (OSError, RuntimeError, ValueError):
        return False
    return path != home and path.is_relative_to(home)


def made_inside(folder: Path, name: str) -> Path:
    """Return the folder `name` inside `folder`, made if missing; `InputError` as `inside`, or if it cannot be made."""
    inner = make_folder(inside(folder, name))
    remove_parts(inner, _FORGOTTEN)
    return inner


def inside(folder: Path, name: str) -> Path:
    """Return the place of the folder `name` inside `folder`; `InputError` if it is a link that leads out of it."""
    inner = folder / name
    try:
        inner.resolve().stat()
    except FileNotFoundError:
        pass
    except (OSError, RuntimeError) as error:  # of links in a circle, which the systems and versions call by many names
        raise InputError(f"{inner}: cannot be opened ({error}); is it a link to itself? Remove it") from None
    if not inner.resolve().is_relative_to(folder.resolve()):
        raise InputError(f"{inner} is a link that leads out of {folder}; put a folder in its place, or move the whole")
    return inner


def check_home(file: Path, folders: int) -> None:
    """Raise `InputError` if one of the last `folders` on the way to a file is a link that leads out of what is above.

    A folder that was one when a run began may have been replaced since.
    """
    above = file.absolute().parents
    home = above[min(folders, len(above) - 1)]
    inside(home, str(above[0].relative_to(home)))


def is_full(error: BaseException) -> bool:
    """Whether an error, or what it came of, says that the disk, or the quota on it, is full."""
    before = error.__cause__ or error.__context__
    return (isinstance(error, OSError) and error.errno in _FULL) or (before is not None and is_full(before))


def not_written(path: Path, error: OSError) -> InputError:
    """Return the error that says why `path` could not be written, and what to do."""
    if is_full(error):
        return InputError(f"{path}: no space left; what had finished is kept, make room and run again")
    reason = _REASONS.get(error.errno or 0) or error.strerror or str(error)
    return InputError(f"{path}: cannot be written: {reason} (what had finished is kept)")


def _has_mark(path: Path, mark: bytes) -> bool:
    return path.is_file() and mark in path.read_bytes()
