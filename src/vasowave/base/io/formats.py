"""The registry of formats: what each is called, how a file of it is known, and who reads it."""

import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from threading import RLock
from typing import Any, Generic, TypeVar

from vasowave.base.io.textfile import look


@dataclass(frozen=True)
class Format:
    """One kind of file.

    Attributes
    ----------
    name : str
        What results and descriptions call it.
    title : str
        What people call it.
    suffixes : tuple of str
        What names of such files end in, lower case.
    sniff : callable, optional
        Tells from a file's path and its first bytes whether it is one; without it, the name tells.
    read : callable
        Returns what such a file holds; the registry says what it takes and gives.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    sniff: Callable[[Path, bytes], bool] | None
    read: Callable[..., Any]


F = TypeVar("F", bound=Format)


class Registry(Generic[F]):
    """The formats of one kind of content.

    Parameters
    ----------
    package : str
        Every module in it registers its formats when it is imported, which happens when the first file is met.
    fallback : str
        Name of the format that a file has which no other knows, by its content or by its suffix.
    """

    def __init__(self, package: str, fallback: str) -> None:
        self._package, self._fallback = package, fallback
        self._formats: dict[str, F] = {}
        self._complete, self._loading, self._lock = False, False, RLock()

    def register(self, form: F) -> F:
        """Add a format; one of the same name is replaced. A file is asked of the newest first, ours last of all."""
        if self._is_ours(form) and form.name in self._formats and not self._is_ours(self._formats[form.name]):
            return form  # ours are found when the first file is met, which may be after a user's own
        self._formats.pop(form.name, None)
        self._formats[form.name] = form
        return form

    def _is_ours(self, form: Format) -> bool:
        return getattr(form.read, "__module__", "").startswith(f"{self._package.partition('.')[0]}.")

    def remove(self, name: str) -> None:
        """Forget a format."""
        del self._formats[name]

    def __iter__(self) -> Iterator[F]:
        """Go through all formats, the newest first."""
        with self._lock:  # another thread waits until all are there
            if not (self._complete or self._loading):
                self._load()
        newest_first = list(self._formats.values())[::-1]
        return iter(sorted(newest_first, key=self._is_ours))

    def _load(self) -> None:
        self._loading = True
        try:
            for module in pkgutil.iter_modules(import_module(self._package).__path__):
                import_module(f"{self._package}.{module.name}")
            self._complete = True
        finally:
            self._loading = False

    def __getitem__(self, name: str) -> F:
        """Return a format by its name."""
        return next(form for form in self if form.name == name)

    @property
    def suffixes(self) -> tuple[str, ...]:
        """What names of files end in that may be of use."""
        return tuple(sorted({suffix for form in self for suffix in form.suffixes}))

    def start(self, path: Path) -> bytes:
        """Return the first bytes of a file."""
        return look(path).start

    def known(self, path: Path) -> F | None:
        """Return the format that a file's content shows; None if it shows none.

        Raises
        ------
        InputError
            The file cannot be read.
        """
        sniffers = [(form, form.sniff) for form in self if form.sniff is not None]
        start = self.start(path) if sniffers else b""
        return next((form for form, sniff in sniffers if sniff(path, start)), None)

    def of(self, path: str | Path) -> F:
        """Return the format of a file: by its content, else by its suffix, else the fallback.

        Raises
        ------
        InputError
            The file cannot be read.
        """
        path = Path(path)
        by_suffix = (form for form in self if path.name.lower().endswith(form.suffixes))
        return self.known(path) or next(by_suffix, None) or self[self._fallback]
