"""Compiled functions, kept for all processes of one user: compiled by the first, loaded by the others.

A kernel is machine code, and loading it means running what a file says. So kernels lie in a folder that only their user
may read or write, are read only from files that are the user's own, and only if they match the SHA-256 in front of
them (see `kept`). A damaged one is compiled anew. A folder belongs to the source of all that is compiled into a kernel
and to the compiler, so that no older kernel is ever met in it. Before all that, those are looked at that came with the
package (see `shipped`).
"""

import inspect
import logging
import os
import pickle
import platform
import shutil
import stat
import sys
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, BinaryIO

import llvmlite
import numba
import numpy as np
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from vasowave.base.runtime.kept import BY_CONTENT, digest_of, keep, recall
from vasowave.base.runtime.locks import lock_open_file
from vasowave.base.runtime.shipped import for_level, shipped_folder
from vasowave.base.runtime.writing import Part, open_regular

_PATIENCE = 300.0  # s that a process waits while another compiles the same
_LOOK = 0.1  # s between two looks whether it is done
_OUTDATED = 30 * 24 * 3600.0  # s after which a folder of another source is removed
_DIGITS = 16  # of a digest, in the names of folders and files
_PACKAGE = __name__.partition(".")[0]
_IN_STAMP = (_PACKAGE, "numpy", "builtins", "math", "typing", "types")
"""What a law's file may be made of for its kernels to be kept: a folder's stamp holds the versions of these."""
_OTHERS = stat.S_IRWXG | stat.S_IRWXO
_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def kept(function: Any, *modules: ModuleType) -> Any:
    """Keep what is compiled of a function; `modules` are what it consists of beside its own.

    Where no private folder can be had, what did not come with the package is compiled in every process.
    """
    stamp = _stamp(*map(_source, (sys.modules[function.py_func.__module__], *modules)))
    folder, shipped = _folder(stamp), shipped_folder(stamp)
    if folder is not None or shipped is not None:
        function._cache = _Kernels(function.py_func, folder, shipped)
    return function


def is_known(cls: type) -> bool:
    """Whether the names of folder and file say all that a class is made of: it is ours, or a law's that uses no more.

    A law's module is named by its content; what else such a file has imported could change unseen.
    """
    module = sys.modules.get(cls.__module__)
    if not cls.__module__.startswith(BY_CONTENT) or module is None:
        return cls.__module__.partition(".")[0] == _PACKAGE
    used = {_home(value) for value in vars(module).values()} - {cls.__module__}
    return {name.partition(".")[0] for name in used} <= {*_IN_STAMP}


def _home(value: Any) -> str:
    """Return the name of the module that a value is or comes from, empty if that is not known."""
    if value is None or isinstance(value, bool | int | float | str | tuple | dict):
        return "builtins"
    return str(value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", ""))


@cache
def _source(module: ModuleType) -> str:
    return inspect.getsource(module)


def _stamp(*sources: str) -> str:
    """Return what tells kernels of these sources from others; of NumPy, Numba asks for the first two numbers only."""
    numpy = np.__version__.split(".")[:2]
    return digest_of(numba.__version__, llvmlite.__version__, numpy, sys.implementation.cache_tag, sources)[:_DIGITS]


def _folder(stamp: str) -> Path | None:
    """Return the private folder of the kernels of a stamp, made where that is possible; None where it is nowhere."""
    for place in _places():
        folder = place / f"kernels-{stamp}"
        try:
            if not folder.is_dir():
                place.mkdir(parents=True, exist_ok=True)
                folder.mkdir(mode=0o700, exist_ok=True)
                _tidy(place)
            if not _is_private(folder):
                continue
            with Part(folder / "tried"):
                return folder
        except OSError:
            continue
    return None


def _is_private(folder: Path) -> bool:
    """Whether a folder is the user's own, and nobody else may look into it; no link counts."""
    about = folder.lstat()
    return stat.S_ISDIR(about.st_mode) and (os.name == "nt" or _is_own(about, _OTHERS))


def _is_own(about: os.stat_result, forbidden: int) -> bool:
    return about.st_uid == os.geteuid() and not about.st_mode & forbidden


def _places() -> Iterator[Path]:
    chosen: str = vars(numba.config).get("CACHE_DIR", "")  # the variable NUMBA_CACHE_DIR
    if chosen:
        yield Path(chosen)
    home, system = Path(os.path.expanduser("~")), platform.system()
    folders = {"Windows": home / "AppData" / "Local", "Darwin": home / "Library" / "Caches"}
    variable = os.environ.get("LOCALAPPDATA" if system == "Windows" else "XDG_CACHE_HOME", "")
    place = Path(variable) if variable else folders.get(system, home / ".cache")
    if place.is_absolute():  # no home, or a variable that means the folder where one happens to be
        yield place / "vasowave"


def _tidy(place: Path) -> None:
    """Remove what older versions of the package left here long ago."""
    for folder in place.glob("kernels-*"):
        if time.time() - folder.stat().st_mtime > _OUTDATED:
            shutil.rmtree(folder, ignore_errors=True)


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


class _Kernels:
    """The kernels of one function, a file each; while one process compiles, others wait for what comes of it.

    This is what Numba asks of a cache: `load_overload` before it compiles, `save_overload` afterwards.
    """

    def __init__(self, function: Any, folder: Path | None, shipped: Path | None) -> None:
        self.cache_path, self._folder, self._shipped = str(folder or shipped), folder, shipped
        self._name = f"{function.__name__}.{sys.implementation.cache_tag}"
        self._lock: BinaryIO | None = None
        self._compiling = False

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the kernel, if it is there or another process is compiling it; else None, to be compiled and saved."""
        self._release()  # that of a compilation which failed
        target_context.refresh()
        _clock.start()
        self._compiling = True
        target = target_context.codegen().magic_tuple()
        kernel = None
        if self._shipped is not None:
            kernel = _load_or_log(self._shipped / self._name_of(sig, for_level(target)), target_context, is_own=False)
        if kernel is None and self._folder is not None:
            file = self._folder / self._name_of(sig, target)
            kernel, _ = _loaded(file, target_context)
            if kernel is None:
                self._lock = _waited_for(file.with_suffix(".lock"))
                kernel = _load_or_log(file, target_context)
        if kernel is not None:
            self._release()
        return kernel

    def save_overload(self, sig: Any, kernel: Any) -> None:
        """Keep a kernel."""
        try:
            is_whole = not kernel.library.has_dynamic_globals and all(map(is_known, _classes(sig)))
            if is_whole and self._folder is not None:
                name = self._name_of(sig, kernel.codegen.magic_tuple())
                keep(self._folder / name, name, dumps(kernel._reduce()))
        except OSError:  # a full disk: it serves this process all the same
            pass
        finally:
            self._release()

    def _name_of(self, sig: Any, target: tuple[str, str, str]) -> str:
        """Return the file's name of the kernel for these types on this kind of processor."""
        modules = [cls.__module__ for cls in _classes(sig)]
        return f"{self._name}-{digest_of(repr(sig), modules, target)[:_DIGITS]}.kernel"

    def _release(self) -> None:
        if self._compiling:
            _clock.stop()
            self._compiling = False
        if self._lock is not None:
            self._lock.close()
            self._lock = None


def _classes(kinds: Any) -> Iterator[type]:
    """Go through the classes among types."""
    if (of_class := getattr(kinds, "instance_class", None)) is not None:
        yield of_class
    for kind in kinds if hasattr(kinds, "__iter__") else ():
        yield from _classes(kind)


def _load_or_log(file: Path, target_context: Any, is_own: bool = True) -> Any:
    """Return the kernel in a file, or None; one of no use is logged."""
    kernel, damaged = _loaded(file, target_context, is_own)
    if damaged:
        logging.getLogger(__name__).warning("%s: a compiled function was damaged; it is compiled anew.", file)
    return kernel


def _loaded(file: Path, target_context: Any, is_own: bool = True) -> tuple[Any, bool]:
    """Return the kernel in a file, or None, and whether a file is there that is of no use; `is_own` if the user's."""
    try:
        with os.fdopen(open_regular(file, links=not is_own), "rb") as opened:  # installers link what they install
            is_trusted = os.name == "nt" or not is_own or _is_own(os.fstat(opened.fileno()), _OTHERS_WRITE)
            packed = recall(opened, file.name) if is_trusted else None
    except FileNotFoundError:
        return None, False
    except OSError:
        return None, True
    if packed is None:
        return None, True
    try:
        return CompileResult._rebuild(target_context, *pickle.loads(packed)), False
    except MemoryError:
        raise
    except Exception:  # whole, but of another making than the stamp could tell: any error means the same
        return None, True


def _waited_for(path: Path) -> BinaryIO | None:
    """Return the locked file; None where no lock is to be had, which costs time and nothing else."""
    try:
        file = os.fdopen(open_regular(path, os.O_RDWR | os.O_CREAT), "rb+")
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
