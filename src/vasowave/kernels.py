"""Compiled functions, kept for all processes: compiled by the first, loaded by the others.

They are kept beside the package, or, where that cannot be written, among the user's cached files. A folder belongs to
the source of all that is compiled into a kernel and to the compiler, so that no older kernel is ever met in it.
"""

import hashlib
import inspect
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import IO, Any

import numba
from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile, _CacheLocator
from numba.misc.appdirs import user_cache_dir

from vasowave.locks import lock_open_file

_PATIENCE = 300.0  # s that a process waits while another compiles the same
_LOOK = 0.1  # s between two looks whether it is done
_OUTDATED = 30 * 24 * 3600.0  # s after which a folder of another source is removed


def kept(function: Any, *modules: ModuleType) -> Any:
    """Keep what is compiled of a function; `modules` are what it consists of beside its own.

    Where nothing can be written, it is compiled in every process.
    """
    sources = (sys.modules[function.py_func.__module__], *modules)
    folder = _folder("".join(map(_source, sources)))
    if folder is not None:
        function._cache = _KernelCache(function.py_func, folder)
    return function


@cache
def _source(module: ModuleType) -> str:
    return inspect.getsource(module)


def _folder(source: str) -> Path | None:
    """Return the folder of kernels with this source, made where it can be written; None where that is nowhere."""
    stamp = _digest(f"{numba.__version__} {sys.version} {source}")
    for place in _places():
        folder = place / f"kernels-{stamp}"
        try:
            if not folder.is_dir():
                folder.mkdir(parents=True)
                _tidy(place)
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError:
            continue
    return None


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _places() -> Iterator[Path]:
    chosen: str = vars(config).get("CACHE_DIR", "")  # the variable NUMBA_CACHE_DIR
    if chosen:
        yield Path(chosen)
    yield Path(__file__).parent / "__pycache__"
    yield Path(user_cache_dir("vasowave", appauthor=False))


def _tidy(place: Path) -> None:
    """Remove what older versions of the package left here long ago."""
    for folder in place.glob("kernels-*"):
        if time.time() - folder.stat().st_mtime > _OUTDATED:
            shutil.rmtree(folder, ignore_errors=True)


class _Folder(_CacheLocator):
    """Where one function's kernels lie."""

    def __init__(self, folder: Path, py_file: str) -> None:
        self._folder, self._py_file = folder, py_file

    def get_cache_path(self) -> str:
        return str(self._folder)

    def get_source_stamp(self) -> str:
        return self._folder.name

    def get_disambiguator(self) -> str:
        return ""

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> None:
        """Numba's search for places is not used."""


class _Kernel(CompileResultCacheImpl):
    def __init__(self, function: Any, folder: Path) -> None:
        self._lineno = function.__code__.co_firstlineno
        self._locator = _Folder(folder, inspect.getfile(function))
        self._filename_base = f"{function.__name__}.{sys.implementation.cache_tag}"


class _Clock:
    """How long this process has compiled, loaded, or waited for another to compile, s; what is within counts once."""

    def __init__(self) -> None:
        self.seconds, self._began, self._within = 0.0, 0.0, 0

    def start(self) -> None:
        if not self._within:
            self._began = time.monotonic()
        self._within += 1

    def stop(self) -> None:
        self._within -= 1
        if not self._within:
            self.seconds += time.monotonic() - self._began


_clock = _Clock()


def seconds_compiling() -> float:
    """Return how long this process has compiled or loaded kernels, or waited for another that compiled them, s."""
    return _clock.seconds


class _KernelCache(FunctionCache):
    """The kernels of one function in one folder; while one process compiles, others wait for what comes of it."""

    def __init__(self, function: Any, folder: Path) -> None:
        self._name, self._py_func, self._folder = repr(function), function, folder
        self._lock: IO[str] | None = None
        self._compiling = False
        self._impl, self._cache_path = _Kernel(function, folder), str(folder)
        self._cache_file = IndexDataCacheFile(str(folder), self._impl.filename_base, folder.name)
        self.enable()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the kernel, if it is there or another process is compiling it; else None, to be compiled and saved."""
        self._release()  # that of a compilation which failed
        _clock.start()
        self._compiling = True
        kernel = super().load_overload(sig, target_context)
        if kernel is None:
            self._lock = _waited_for(self._folder / f"{self._impl.filename_base}-{_digest(str(sig))}.lock")
            kernel = super().load_overload(sig, target_context)
        if kernel is not None:
            self._release()
        return kernel

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a kernel."""
        index = _waited_for(self._folder / f"{self._impl.filename_base}.lock")  # all kernels of a function are in one
        try:
            super().save_overload(sig, data)
        except OSError:  # a full disk: it serves this process all the same
            pass
        finally:
            if index is not None:
                index.close()
            self._release()

    def _release(self) -> None:
        if self._compiling:
            _clock.stop()
            self._compiling = False
        if self._lock is not None:
            self._lock.close()
            self._lock = None


def _waited_for(path: Path) -> IO[str] | None:
    """Return the locked file; None where no lock is to be had, which costs time and nothing else."""
    try:
        file = path.open("a", encoding="utf-8")
    except OSError:
        return None
    ends = time.monotonic() + _PATIENCE
    while time.monotonic() < ends:
        try:
            lock_open_file(file.fileno())
        except BlockingIOError:
            time.sleep(_LOOK)
        except OSError:  # this file system knows no locks
            break
        else:
            return file
    file.close()
    return None
