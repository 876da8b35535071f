"""What was found in files, remembered for as long as they stay as they are."""

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterable
from dataclasses import is_dataclass
from functools import wraps
from pathlib import Path
from threading import Lock, RLock
from typing import Any, NamedTuple, TypeVar, cast
from weakref import WeakValueDictionary

MOST = 256 << 20
"""Bytes that are remembered of all files together; what was found last is kept, whatever its size."""

YOUNG = 2.0
"""A file that was written in the last seconds may change within its time's resolution, and is read again."""

Read = TypeVar("Read", bound=Callable[..., Any])
Made = TypeVar("Made")


class _Found(NamedTuple):
    mark: tuple[int, ...]
    value: Any
    size: int


_found: OrderedDict[Hashable, _Found] = OrderedDict()
_held = [0]
"""Bytes of all that is found: a sum at every look would grow with what is remembered."""
_readings: WeakValueDictionary[Hashable, Any] = WeakValueDictionary()
"""A lock for everything that is being looked up now."""
_lock = Lock()


def remembered(read: Read) -> Read:
    """Return a reader of files, ``read(path, ...)``, that does not read again what has not changed.

    A file is the same for as long as its path, size and times are. What is found must not be changed by anybody. The
    argument `progress` tells nothing of what is found; it is given by its name.
    """

    @wraps(read)
    def recalled(path: Path, *arguments: Any, progress: Any = None) -> Any:
        keywords = {} if progress is None else {"progress": progress}
        mark = _mark(Path(path))
        if mark is None:
            return read(path, *arguments, **keywords)
        key = (read.__module__, read.__qualname__, str(path), *arguments)
        return _recalled(key, mark, lambda: read(path, *arguments, **keywords), lambda: _mark(Path(path)) == mark)

    return cast(Read, recalled)


def made_once(key: Callable[[], Hashable], make: Callable[[], Made]) -> Made:
    """Return what `make` returned before under a key, which holds everything that decides about it.

    It is forgotten as what is `remembered`, must not be changed by anybody, and does not count if the key is another
    when it is made.
    """
    now = key()
    return cast(Made, _recalled(now, (), make, lambda: key() == now))


def _recalled(key: Hashable, mark: tuple[int, ...], make: Callable[[], Any], is_still: Callable[[], bool]) -> Any:
    with _lock:
        alone = _readings.setdefault(key, RLock())
    with alone:  # so that no two threads read the same
        with _lock:
            entry = _found.pop(key, None)
            _held[0] -= 0 if entry is None else entry.size
        if is_new := entry is None or entry.mark != mark:
            value = make()
            entry = _Found(mark, value, _size(value))
        if not is_new or is_still():
            with _lock:
                _found[key] = entry
                _held[0] += entry.size
                while len(_found) > 1 and _held[0] > MOST:
                    _held[0] -= _found.popitem(last=False)[1].size
    return entry.value


def marks_of(files: Iterable[Path]) -> tuple[Hashable, ...]:
    """Return what changes with any of some files: an argument of a reader that looks into them beside its own."""
    return tuple(_mark(file) or time.perf_counter_ns() for file in files)


def _mark(path: Path) -> tuple[int, ...] | None:
    """Return what changes with a file, None if it is too young to tell, or no file."""
    try:
        about = path.stat()
    except (OSError, ValueError):
        return None
    if not path.is_file() or time.time_ns() - about.st_mtime_ns < YOUNG * 1e9:
        return None
    return about.st_dev, about.st_ino, about.st_size, about.st_mtime_ns, about.st_ctime_ns


def _size(value: Any) -> int:
    """Return about how many bytes a value takes."""
    if isinstance(size := getattr(value, "nbytes", None), int):  # of an array or a dataset
        return size
    if isinstance(value, (str, bytes)):
        return 50 + len(value)
    if isinstance(value, dict):
        value = tuple(value.values())
    elif is_dataclass(value) or hasattr(value, "__dict__"):
        value = tuple(vars(value).values())
    if not isinstance(value, (tuple, list)):
        return 50
    if value and isinstance(value[0], (str, int, float)):
        return 60 * len(value)
    return 50 + sum(map(_size, value))
