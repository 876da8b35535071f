"""A wall law in a file of a user's own: read once, named by its content, and run from the bytes that were named.

A file that names a law may come from anybody, so nothing that lies beside it is ever on the path of imports. Only the
file of a law that it names is run: ``our_laws:Class`` is the class in ``our_laws.py`` beside it, from then on called
``our_laws@0123456789abcdef:Class``, by the beginning of the file's SHA-256. Other processes get the source, not the
place: a worker on another machine runs the same law. What a file names runs only where its user has allowed it.
"""

import hashlib
import linecache
import re
import sys
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from vasowave.base.cures import TrustPrograms
from vasowave.base.errors import InputError, VasowaveError
from vasowave.base.io.textfile import read_bytes
from vasowave.base.io.trusted import is_allowed
from vasowave.base.runtime.kept import BY_CONTENT

ALLOW = "read it, then allow it to run in this study"
"""What to do about a program that nobody has allowed to run."""

_INSTALLED = "@installed"
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

    @property
    def sha256(self) -> str:
        """The SHA-256 of the source."""
        return hashlib.sha256(self.source).hexdigest()


class Where(NamedTuple):
    """How names of laws are to be understood.

    Attributes
    ----------
    folder : Path or None
        Where their files lie; None: no file is looked for, and nothing is run for a name.
    typed : bool
        Whether a person has typed them: whoever names a program in a command or a script has asked for it. What files
        or stored results name runs where it is allowed only, see `io.trusted`.
    """

    folder: Path | None
    typed: bool = False


_TYPED = Where(Path(), typed=True)
_known: dict[str, LawFile] = {}
_folders: dict[str, set[Path]] = {}  # where a file of laws is named, by its name
_typed: set[bytes] = set()  # programs that a person has named
_where: ContextVar[Where] = ContextVar("where", default=_TYPED)


@contextmanager
def looking_in(folder: Path | None) -> Iterator[None]:
    """Understand names of laws as those that files in `folder` name, or results (None), not as typed ones."""
    token = _where.set(Where(folder))
    try:
        yield
    finally:
        _where.reset(token)


def named(wall: str) -> str:
    """Return a law's name with that of its file, if it has one here: ``our_laws@0123456789abcdef:Class``.

    Unless typed, the class of an installed module is called ``package.module@installed:Class``.
    """
    if not isinstance(wall, str):
        raise InputError(f"{wall!r} is not a name; write one name")
    stem, colon, attribute = (piece.strip() for piece in wall.partition(":"))
    where = _where.get()
    if not colon or "@" in stem:
        return wall
    module = stem.removesuffix(".py")
    if module.isidentifier() and where.folder is not None and (path := where.folder / f"{module}.py").is_file():
        if path.stat().st_size > _LARGEST:
            raise InputError(f"{path}: larger than {_LARGEST >> 20} MB; no wall law is")
        source = read_bytes(path)
        file = LawFile(f"{module}@{_digest(source)}", str(path.absolute()), source)
    elif where.typed or not stem:
        return wall
    elif where.folder is not None and not _is_installed(module):
        raise InputError(f"'{wall}': no such module is installed, and there is no {where.folder / module}.py")
    else:
        file = _installed(module)
    _know(file, where.folder)
    if where.typed:
        _typed.add(file.source)
    return f"{file.name}:{attribute}"


def _know(file: LawFile, folder: Path | None) -> None:
    _known[file.name] = file
    _folders.setdefault(file.name, set()).update([] if folder is None else [folder.absolute()])


def _installed(module: str) -> LawFile:
    """Return what stands for an installed module that files or stored results name."""
    return LawFile(f"{module}{_INSTALLED}", f"the installed module {module}", f"import {module}\n".encode())


def _is_installed(module: str) -> bool:
    try:
        return find_spec(module.partition(".")[0]) is not None  # of the first part: to find the others, it is run
    except (ImportError, ValueError):
        return False


def may_run(name: str) -> bool:
    """Whether the program of a law, by the name of its file, was typed by a person or is allowed where it is named.

    Of a folder that is being read it must be allowed for this one.
    """
    file, origin = _known.get(name), _where.get()
    if file is None:
        return False
    folders = _folders[name] if origin.typed or origin.folder is None else {origin.folder}
    return file.source in _typed or any(is_allowed(folder, file.source) for folder in folders)


def is_unread(wall: str) -> bool:
    """Whether a name is only read, and what it names not run: of results, or a program that nobody has allowed."""
    stem, colon, _ = wall.partition(":")
    return bool(colon) and (_where.get().folder is None or ("@" in stem and not may_run(stem)))


def plain(wall: str) -> str:
    """Return a law's name as a person writes it, without what stands for its file's content."""
    return re.sub(r"@\w*:", ":", wall)


def file_behind(module: str) -> str:
    """Return the name of the file behind a module that was made of one, else the module's own."""
    return next((name for name in _known if module in (_module_name(name), name.removesuffix(_INSTALLED))), module)


def remember(walls: Iterable[str], folders: Iterable[Path]) -> None:
    """Know the files of these laws, where one with the content that is named lies in a folder; nothing is run."""
    for stem, _, digest in (wall.partition(":")[0].partition("@") for wall in walls if ":" in wall):
        for folder in folders:
            path = folder / f"{stem}.py"
            if digest in ("", _INSTALLED[1:]):
                _know(_installed(stem), folder)
            elif stem.isidentifier() and path.is_file() and path.stat().st_size <= _LARGEST:
                source = read_bytes(path)
                if _digest(source) == digest:
                    _know(LawFile(f"{stem}@{digest}", str(path.absolute()), source), folder)


def _digest(source: bytes) -> str:
    return hashlib.sha256(source).hexdigest()[:16]


def _module_name(name: str) -> str:
    return f"{BY_CONTENT}{name.replace('@', '_')}"


def files_of(walls: Iterable[str]) -> tuple[LawFile, ...]:
    """Return the files of those laws that lie in one, for `learn` in another process."""
    names = dict.fromkeys(wall.partition(":")[0] for wall in walls)
    return tuple(_known[name] for name in names if name in _known)


def learn(files: Iterable[LawFile]) -> None:
    """Know these files, which may run where they come from, by their names; nothing is run before it is asked for."""
    for file in files:
        _know(file, None)
        _typed.add(file.source)


def module_of(name: str, wall: str) -> ModuleType:
    """Return the module of a file by its name, run when it is first asked for.

    Raises
    ------
    InputError
        The file is not here, or cannot be run: says which line and why.
    """
    if name not in _known and (folder := _where.get().folder) is not None:
        remember([wall], [folder])
    file = _known.get(name)
    if file is None:
        raise InputError(
            f"'{plain(wall)}': its file {name.partition('@')[0]}.py, as it was when it was used, is not here. "
            "What is stored can be read; to simulate or fit with the law, begin where its file lies, or put the "
            "file into the folder you are in"
        )
    if not may_run(name):
        raise InputError(f"'{plain(wall)}' is a program, {file.path}, and nobody has allowed it to run; {ALLOW}",
                         [TrustPrograms()])  # fmt: skip
    if name.endswith(_INSTALLED):
        try:
            return import_module(name.removesuffix(_INSTALLED))
        except Exception as error:
            raise InputError(f"'{plain(wall)}': {file.path} cannot be loaded: {_words(error)}") from None
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
        input_error = blamed(error)
        if input_error is None:
            raise
        raise input_error from error


def blamed(error: BaseException) -> InputError | None:
    """Return what is wrong with the file of a law, if an error arose there."""
    paths = {file.path: file.path for file in _known.values()}
    if isinstance(error, SyntaxError) and error.filename in paths:
        return InputError(f"{error.filename}, line {error.lineno}: {error.msg}; correct the law")
    cause: BaseException | None = error
    while cause is not None:
        for frame in reversed(traceback.extract_tb(cause.__traceback__)):
            if frame.filename in paths:
                return InputError(f"{frame.filename}, line {frame.lineno}: {_words(error)}; correct the law")
        for place, line in _NUMBAS_PLACE.findall(str(cause)):
            path = next((path for path in paths if Path(path).name == Path(place).name), None)
            if path:
                reason = "the compiler of the solver cannot translate it"
                return InputError(f"{path}, line {line}: {reason} ({_words(error)}); see docs/walls.md")
        cause = cause.__cause__ or cause.__context__
    return None


def _words(error: BaseException) -> str:
    """Return an error in one short line."""
    if isinstance(error, ModuleNotFoundError):
        return f"{error}; a law is one file, which may use what is installed, but no file beside it"
    lines = [line for line in str(error).splitlines() if line.strip()]
    return f"{type(error).__name__}: {lines[0].strip()[:200]}" if lines else type(error).__name__
