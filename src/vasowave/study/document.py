"""A YAML file as plain values that remember where they stand.

Only what a settings file needs: mappings, lists and text. A value stays the text that was written (``1e-7`` and ``no``
are what they look like); what kind of value it should be is the model's business. Anchors and aliases are refused.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from vasowave.errors import InputError
from vasowave.study.problems import Problem

Path_ = tuple[str | int, ...]
_NOTHING = ("", "~", "null", "Null", "NULL")
_DEEPEST = 20  # nesting of a document, beyond any study's


@dataclass(eq=False)
class Document:
    """The content of a YAML file; filled while it is read.

    Attributes
    ----------
    name : str
        What messages call the file.
    values : mapping
        Nested mappings and lists of text or None.
    problems : list of Problem
        What could not be understood.
    """

    name: str
    values: dict[str, Any] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    _keys: dict[Path_, tuple[int, int]] = field(default_factory=dict)
    _values: dict[Path_, tuple[int, int]] = field(default_factory=dict)

    def place(self, path: Sequence[str | int], key: bool = False) -> str:
        """Return the words that lead to the value (or its key) at `path`, or to the nearest thing around it."""
        first, second = (self._keys, self._values) if key else (self._values, self._keys)
        for length in range(len(path), -1, -1):
            at = tuple(path[:length])
            mark = first.get(at) or second.get(at)
            if mark is not None:
                return f"{self.name}, line {mark[0]}, column {mark[1]}"
        return self.name


def read_document(path: Path) -> Document:
    """Read a YAML file; what is wrong with it stands in its `problems`.

    Raises
    ------
    InputError
        The file cannot be read at all.
    """
    try:
        raw = path.read_bytes()
    except OSError as error:
        reason = "is a folder" if path.is_dir() else (error.strerror or "cannot be read").lower()
        raise InputError(f"{path}: {reason}; `vasowave new FOLDER` makes a new study") from None
    return parse_document(raw, str(path))


def parse_document(raw: bytes, name: str) -> Document:
    """Return the content of a YAML text; never raises."""
    import yaml

    document = Document(name)
    try:
        root = yaml.compose(raw.decode("utf-8-sig"), Loader=yaml.SafeLoader)
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        document.problems.append(Problem(f"{name}, line {line}", "not UTF-8 text; save the file as UTF-8"))
        return document
    except RecursionError:
        document.problems.append(Problem(name, "nested too deeply to be a study file"))
        return document
    except yaml.YAMLError as error:
        document.problems.append(_syntax(name, error))
        return document
    if root is None:
        return document
    values = _Builder(document).build(root, ())
    if isinstance(values, dict):
        document.values = values
    elif not document.problems:
        document.problems.append(Problem(f"{name}, line 1", "expected lines of the form 'key: value'"))
    return document


def _syntax(name: str, error: Exception) -> Problem:
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    where = f"{name}, line {mark.line + 1}, column {mark.column + 1}" if mark else name
    what = getattr(error, "problem", None) or getattr(error, "reason", None) or "cannot be understood"
    tab = " (indent with blanks, not with tabs)" if "\\t" in str(what) else ""
    return Problem(where, f"not valid YAML: {what}{tab}; look for a missing colon, quotation mark or indentation")


class _Builder:
    """Turns nodes into values; keeps their places and what is wrong with them."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.seen: set[int] = set()

    def build(self, node: Any, path: Path_) -> Any:
        import yaml

        if id(node) in self.seen:  # the node stands elsewhere, so its place is that of the key
            self._problem(path, "this is an alias; write the value out")
            return node.value if isinstance(node, yaml.ScalarNode) else None
        self.seen.add(id(node))
        self.document._values[path] = _mark(node)
        if len(path) > _DEEPEST:
            self._problem(path, "nested too deeply to be a study file")
            return None
        if isinstance(node, yaml.MappingNode):
            return self._mapping(node, path)
        if isinstance(node, yaml.SequenceNode):
            return [self.build(item, (*path, i)) for i, item in enumerate(node.value)]
        plain_nothing = node.style is None and node.value in _NOTHING
        return None if plain_nothing else node.value

    def _mapping(self, node: Any, path: Path_) -> dict[str, Any]:
        import yaml

        mapping: dict[str, Any] = {}
        for key, value in node.value:
            here = (*path, key.value if isinstance(key, yaml.ScalarNode) else "?")
            if not isinstance(key, yaml.ScalarNode):
                self.document._values.setdefault(here, _mark(key))
                self._problem(here, "this cannot be a key; write 'key: value'")
                continue
            if key.value in mapping:
                first = self.document._keys[here][0]
                place = "{}, line {}, column {}".format(self.document.name, *_mark(key))
                message = f"'{key.value}' stands a second time (first in line {first}); keep one"
                self.document.problems.append(Problem(place, message))
                continue
            self.document._keys[here] = _mark(key)
            mapping[key.value] = self.build(value, here)
        return mapping

    def _problem(self, path: Path_, message: str) -> None:
        self.document.problems.append(Problem(self.document.place(path), message))


def _mark(node: Any) -> tuple[int, int]:
    return node.start_mark.line + 1, node.start_mark.column + 1
