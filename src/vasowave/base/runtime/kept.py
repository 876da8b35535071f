"""Finished work kept in files, and found again by what went into it: animals, stages of an extraction, kernels.

A key is a digest of everything that enters a computation, the program among it. So nothing that is kept is ever out of
date, and what is damaged, or not there, is made anew: a kept file saves time only.
"""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from vasowave.base.runtime.writing import put

PACKAGE = Path(__file__).parents[2]

BY_CONTENT = "vasowave_law_"
"""Beginning of the names of modules that go on with a digest of their source; see `model.law_files`."""

_SEAL = hashlib.sha256().digest_size
_PRIVATE_MODE = 0o600  # what is loaded and run is its user's alone


def digest_of(*values: Any) -> str:
    """Return the SHA-256 of values: arrays, dataclasses, numbers, text, mappings, sequences, in one another.

    A field of a dataclass that is not compared does not count; a function or class counts by its name.
    """
    digest = hashlib.sha256()
    for piece in _pieces(values):
        digest.update(piece)
    return digest.hexdigest()


def _pieces(value: Any) -> Iterator[bytes | np.ndarray]:
    """Yield what makes `value` another one: kinds, shapes and contents."""
    if isinstance(value, np.ndarray):
        yield f"{value.dtype.str}{value.shape}".encode()
        yield np.ascontiguousarray(value).reshape(-1).view(np.uint8)
    elif is_dataclass(value) and not isinstance(value, type):
        yield type(value).__name__.encode()
        yield from _pieces([getattr(value, entry.name) for entry in fields(value) if entry.compare])
    elif isinstance(value, Mapping):
        yield b"{"
        yield from _pieces(sorted(value.items()))
    elif isinstance(value, tuple | list):
        yield f"({len(value)}".encode()
        for element in value:
            yield from _pieces(element)
    else:
        plain = value.item() if isinstance(value, np.generic) else value
        yield f"{getattr(plain, '__qualname__', None) or repr(plain)};".encode()


@cache
def program(folder: str = "", without: tuple[str, ...] = (), libraries: tuple[str, ...] = ()) -> str:
    """Return the digest of the package's sources and tables, and of the versions of libraries.

    Parameters
    ----------
    folder : str
        The folder of the package that counts; by default all of it.
    without : tuple of str
        Folders in it that do not count, such as ``part/room``.
    libraries : tuple of str
    """
    root, digest = PACKAGE / folder, hashlib.sha256()
    outside = tuple(f"{name}/" for name in without)
    for name in libraries:
        digest.update(f"{name} {_version(name)}\n".encode())
    for file in sorted(root.rglob("*")):
        inside = file.relative_to(root)
        if file.suffix in (".py", ".csv") and not inside.as_posix().startswith(outside):
            digest.update(f"{inside.as_posix()}\n".encode() + file.read_bytes())
    return digest.hexdigest()


def _version(library: str) -> str:
    try:
        return version(library)
    except PackageNotFoundError:
        return "absent"


def keep(path: Path, key: str, *pieces: bytes | np.ndarray) -> None:
    """Write `pieces` behind `key` and the SHA-256 of both, as `put` does; arrays are flat and of bytes."""
    seal = hashlib.sha256(key.encode())
    for piece in pieces:
        seal.update(piece)
    put(path, (seal.digest(), key.encode(), *pieces), _PRIVATE_MODE)


def recall(file: BinaryIO, key: str) -> np.ndarray | None:
    """Return the bytes that `keep` wrote under `key`; None where another key stands there, or anything is damaged.

    The key is compared before the rest is read.
    """
    seal, head = file.read(_SEAL), file.read(len(key.encode()))
    if head != key.encode():
        return None
    content = np.fromfile(file, np.uint8)
    digest = hashlib.sha256(head)
    digest.update(content)
    return content if digest.digest() == seal else None
