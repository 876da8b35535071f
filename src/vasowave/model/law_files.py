"""A wall law in a file of a user's own: read once, named by its content, and run from the bytes that were named.

A study may come from anybody, so nothing that lies beside it is ever on the path of imports. Only the file of a law
that it names is run: ``our_laws:Class`` is the class in ``our_laws.py`` beside the study, and from then on is called
``our_laws@0123456789abcdef:Class``, by the beginning of the file's SHA-256. Other processes get the source, not the
place: a worker on another machine runs the same law.
"""

import hashlib
import linecache
import re
import sys
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from vasowave.errors import InputError, VasowaveError
from vasowave.io.textfile import read_bytes
from vasowave.runtime.kept import BY_CONTENT

_LARGEST = 1 << 20  # bytes; no law is longer
_NUMBAS_PLACE = re.compile(r'File "([^"]*)", line (\d+)')


class LawFile(NamedTuple):
    """The source of laws, wherever it lies.

    Attributes
    ----------
    name : str
        ``our_laws@`` and the beginning of the SHA-256.
    path : str
        Where it was read.
    source : bytes
    """

    name: str
    path: str
    source: bytes


_known: dict[str, LawFile] = {}
_folder: ContextVar[Path | None] = ContextVar("folder", default=Path())


@contextmanager
def looking_in(folder: Path | None) -> Iterator[None]:
    """Let laws be named that lie in `folder`, in place of the folder one is in; None: no file is run for a name."""
    token = _folder.set(folder)
    try:
        yield
    finally:
        _folder.reset(token)


def named(wall: str) -> str:
    """Return a law's name with that of its file, if it has one here: ``our_laws@0123456789abcdef:Class``."""
    if not isinstance(wall, str):
        raise InputError(f"{wall!r} is no name; write one name")
    stem, colon, attribute = wall.partition(":")
    stem, folder = stem.removesuffix(".py"), _folder.get()
    if not (colon and stem.isidentifier() and folder is not None and (folder / f"{stem}.py").is_file()):
        return wall
    path = (folder / f"{stem}.py").absolute()
    source = read_bytes(path)
    if len(source) > _LARGEST:
        raise InputError(f"{path}: larger than {_LARGEST >> 20} MB; no wall law is")
    name = f"{stem}@{_digest(source)}"
    _known[name] = LawFile(name, str(path), source)
    return f"{name}:{attribute}"


def is_unread(wall: str) -> bool:
    """Whether a name was only read back, from results: to read them nothing is run."""
    stem, colon, _ = wall.partition(":")
    return bool(colon) and (_folder.get() is None or ("@" in stem and stem not in _known))


def plain(wall: str) -> str:
    """Return a law's name as a person writes it, without what stands for its file's content."""
    return re.sub(r"@[0-9a-f]*:", ":", wall)


def file_behind(module: str) -> str:
    """Return the name of the file behind a module that was made of one, else the module's own."""
    return next((name for name in _known if module == _module_name(name)), module)


def remember(walls: Iterable[str], folders: Iterable[Path]) -> None:
    """Know the files of these laws, where one with the content that is named lies in a folder; nothing is run."""
    for wall in walls:
        stem, _, digest = wall.partition(":")[0].partition("@")
        for path in (folder / f"{stem}.py" for folder in folders if digest and stem.isidentifier()):
            if path.is_file() and (name := f"{stem}@{_digest(source := read_bytes(path))}") == f"{stem}@{digest}":
                _known.setdefault(name, LawFile(name, str(path.absolute()), source))


def _digest(source: bytes) -> str:
    return hashlib.sha256(source).hexdigest()[:16]


def _module_name(name: str) -> str:
    return f"{BY_CONTENT}{name.rpartition('@')[2]}"


def files_of(walls: Iterable[str]) -> tuple[LawFile, ...]:
    """Return the files of those laws that lie in one, for `learn` in another process."""
    names = dict.fromkeys(wall.partition(":")[0] for wall in walls)
    return tuple(_known[name] for name in names if name in _known)


def learn(files: Iterable[LawFile]) -> None:
    """Know these files by their names; nothing is run before a law is asked for."""
    _known.update({file.name: file for file in files})


def module_of(name: str, wall: str) -> ModuleType:
    """Return the module of a file by its name, run when it is first asked for.

    Raises
    ------
    InputError
        The file is not here, or cannot be run: says which line and why.
    """
    if name not in _known and (folder := _folder.get()) is not None:
        remember([wall], [folder])
    file = _known.get(name)
    if file is None:
        raise InputError(
            f"'{plain(wall)}': its file {name.partition('@')[0]}.py, as it was when it was used, is not here. "
            "What is stored can be read; to simulate or fit with the law, read the study that names it, or put the "
            "file into the folder you are in"
        )
    key = _module_name(name)
    if key not in sys.modules:
        sys.modules[key] = _run(key, file)
    return sys.modules[key]


def _run(key: str, file: LawFile) -> ModuleType:
    module = ModuleType(key)
    module.__file__ = file.path
    text = file.source.decode("utf-8", errors="replace")
    linecache.cache[file.path] = (len(text), None, text.splitlines(keepends=True), file.path)  # for messages
    sys.modules[key] = module  # while it runs: a class looks for its module
    try:
        exec(compile(file.source, file.path, "exec", dont_inherit=True), vars(module))
    except (Exception, SystemExit) as error:
        raise blamed(error) or InputError(f"{file.path}: {_words(error)}; correct the law") from None
    finally:
        del sys.modules[key]
    return module


@contextmanager
def in_words() -> Iterator[None]:
    """Turn an error that arose in the file of a law into one that says where; a context, or a decorator."""
    try:
        yield
    except (VasowaveError, MemoryError):
        raise
    except (Exception, SystemExit) as error:
        said = blamed(error)
        if said is None:
            raise
        raise said from error


def blamed(error: BaseException) -> InputError | None:
    """Return what is wrong with the file of a law, if an error arose there."""
    paths = {file.path: file.path for file in _known.values()}
    if isinstance(error, SyntaxError) and error.filename in paths:
        return InputError(f"{error.filename}, line {error.lineno}: {error.msg}; correct the law")
    found: BaseException | None = error
    while found is not None:
        for frame in reversed(traceback.extract_tb(found.__traceback__)):
            if frame.filename in paths:
                return InputError(f"{frame.filename}, line {frame.lineno}: {_words(error)}; correct the law")
        for place, line in _NUMBAS_PLACE.findall(str(found)):
            path = next((path for path in paths if Path(path).name == Path(place).name), None)
            if path:
                why = "the compiler of the solver cannot translate it"
                return InputError(f"{path}, line {line}: {why} ({_words(error)}); see docs/walls.md")
        found = found.__cause__ or found.__context__
    return None


def _words(error: BaseException) -> str:
    """Return an error in one short line."""
    if isinstance(error, ModuleNotFoundError):
        return f"{error}; a law is one file, which may use what is installed, but no file beside it"
    lines = [line for line in str(error).splitlines() if line.strip()]
    return f"{type(error).__name__}: {lines[0].strip()[:200]}" if lines else type(error).__name__
