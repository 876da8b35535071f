"""From the text of ``study.yaml`` to its settings, or to the list of everything that is wrong with it.

Of YAML only what a settings file needs is read: mappings, lists and text, which remember where they stand. A value
stays the text that was written (``1e-7`` and ``no`` are what they look like); what kind of value it should be is the
business of the settings. Anchors and aliases are refused.
"""

import errno
import os
import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, Place, error_kind
from vasowave.base.io.files import lies_inside
from vasowave.base.io.textfile import regular_file
from vasowave.base.settings import is_true, read_values, settings_of, unknown_word
from vasowave.pulse.model.law_files import is_unread, looking_in, named
from vasowave.pulse.model.laws import find_bed, find_law
from vasowave.study.animal.animal import known_parameters
from vasowave.study.folder.places import STUDY_FILE, YAML
from vasowave.study.folder.problems import StudyProblem
from vasowave.study.folder.settings import StudyFile

Path_ = tuple[str | int, ...]
_NULL_WORDS = ("", "~", "null", "Null", "NULL")
_MAX_NAME_LETTERS = 110  # letters of the longest name among results
_MAX_FILE_BYTES = 1 << 20  # bytes
_MAX_NESTING = 20  # nesting of a document, beyond any study's

NOT_UTF8 = error_kind("yaml.encoding", "not UTF-8 text; {remedy}", "save the file as UTF-8")
TOO_LARGE = error_kind(
    "yaml.too-large", "larger than 1 MiB, which no study file is; {remedy}", "leave nothing but settings in it"
)
TOO_DEEP = error_kind("yaml.too-deep", "nested too deeply to be a study file; {remedy}", "write lists of one level")
NO_MAPPING = error_kind("yaml.no-mapping", "{remedy}", "write lines of the form 'key: value'")
_YAML_REMEDY = "look for a missing colon, quotation mark or indentation"
SYNTAX = error_kind("yaml.syntax", "not valid YAML: {what}; {remedy}", _YAML_REMEDY)
TAB = error_kind("yaml.tab", "not valid YAML: {what} (indent with blanks, not with tabs); {remedy}", _YAML_REMEDY)
ALIAS = error_kind("yaml.alias", "this is an alias; {remedy}", "write the value out")
TABLE_OUTSIDE = error_kind(
    "study.table-outside", "'{name}' lies outside of the study, where nothing is written; {remedy}",
    "copy the table into the study's folder and name the copy here",
)  # fmt: skip
PATH_TOO_LONG = error_kind(
    "study.path-too-long", "its path has {length} letters, and those of its results would be too long for this system; "
    "{remedy}", "move the study, or give it and the folders above it shorter names",
)  # fmt: skip
NO_KEY = error_kind("yaml.no-key", "this cannot be a key; {remedy}", "write 'key: value'")
NO_VALUE = error_kind(
    "yaml.no-value", "'{key}' has no value; {remedy}",
    'a name that holds a comma stands in quotation marks, "HPH, drug": 1',
)  # fmt: skip
KEY_TWICE = error_kind("yaml.key-twice", "'{key}' stands a second time (first in line {first}); {remedy}", "keep one")


@dataclass(eq=False)
class Document:
    """The content of a YAML file.

    Holds state because places and problems are collected while it is read, and while its values are checked.

    Attributes
    ----------
    name : str
        What messages call the file.
    values : mapping
        Nested mappings and lists of text or None.
    problems : list of StudyProblem
        What could not be understood.
    """

    name: str
    values: dict[str, Any] = field(default_factory=dict)
    problems: list[StudyProblem] = field(default_factory=list)
    _keys: dict[Path_, tuple[int, int]] = field(default_factory=dict)
    _values: dict[Path_, tuple[int, int]] = field(default_factory=dict)

    @property
    def keys(self) -> frozenset[Path_]:
        """Paths of all keys."""
        return frozenset(self._keys)

    def place(self, path: Sequence[str | int], key: bool = False) -> Place:
        """Return where the value (or its key) at `path` stands, or the nearest thing around it."""
        first, second = (self._keys, self._values) if key else (self._values, self._keys)
        for length in range(len(path), -1, -1):
            keys = tuple(path[:length])
            mark = first.get(keys) or second.get(keys)
            if mark is not None:
                return _place(self.name, *mark)
        return Place(self.name)

    def note(self, finding: Finding, place: Place) -> None:
        """Add what was found at a place to the problems."""
        self.problems.append(StudyProblem(finding.placed(place)))


def read_document(path: Path) -> Document:
    """Read a YAML file; what is wrong with it stands in its `problems`.

    Raises
    ------
    InputError
        The file cannot be read at all, or is no YAML by its name.
    """
    if path.is_file() and path.suffix.lower() not in YAML:
        typed = shlex.quote(str(path))
        raise InputError(
            f"{path}: a study is a folder or its {STUDY_FILE}; `vasowave new FOLDER` makes one, `vasowave add {typed}` "
            f"in it takes up files, and `vasowave open {typed}` shows a recording or an image"
        )
    try:
        with (path if path.is_dir() or not path.exists() else regular_file(path)).open("rb") as file:
            raw = file.read(_MAX_FILE_BYTES + 1)
    except OSError as error:
        reason = "is a folder" if path.is_dir() else (error.strerror or "cannot be read").lower()
        around = next((parent for parent in path.absolute().parents[1:] if (parent / path.name).is_file()), None)
        advice = f"the study is {around}" if around else "`vasowave new FOLDER` makes a new study"
        raise InputError(f"{path}: {reason}; {advice}") from None
    return parse_document(raw, str(path))


def parse_document(raw: bytes, name: str) -> Document:
    """Return the content of a YAML text; never raises."""
    import yaml

    document = Document(name)
    if len(raw) > _MAX_FILE_BYTES:
        document.note(TOO_LARGE(), Place(name))
        return document
    try:
        root = yaml.compose(raw.decode("utf-8-sig"), Loader=yaml.SafeLoader)
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        document.note(NOT_UTF8(), Place(name, line))
        return document
    except RecursionError:
        document.note(TOO_DEEP(), Place(name))
        return document
    except yaml.YAMLError as error:
        _say_syntax(document, error)
        return document
    if root is None:
        return document
    values = _Builder(document).build(root, ())
    if isinstance(values, dict):
        document.values = values
    elif not document.problems:
        document.note(NO_MAPPING(), Place(name, 1))
    return document


def _say_syntax(document: Document, error: Exception) -> None:
    mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    where = _place(document.name, mark.line + 1, mark.column + 1) if mark else Place(document.name)
    problem = getattr(error, "problem", None) or getattr(error, "reason", None) or "cannot be understood"
    tab = mark and mark.buffer and mark.buffer[mark.pointer] == "\t"
    document.note((TAB if tab else SYNTAX)(what=problem), where)


def _place(name: str, line: int, column: int) -> Place:
    return Place(name, line, f"column {column}")


class _Builder:
    """Turns nodes into values; keeps their places and what is wrong with them.

    Holds state because a node that was met before is an alias.
    """

    def __init__(self, document: Document) -> None:
        self.document = document
        self.seen: set[int] = set()

    def build(self, node: Any, path: Path_) -> Any:
        import yaml

        if id(node) in self.seen:  # the node stands elsewhere, so its place is that of the key
            self.document.note(ALIAS(), self.document.place(path))
            return node.value if isinstance(node, yaml.ScalarNode) else None
        self.seen.add(id(node))
        self.document._values[path] = _mark(node)
        if len(path) > _MAX_NESTING:
            self.document.note(TOO_DEEP(), self.document.place(path))
            return None
        if isinstance(node, yaml.MappingNode):
            return self._mapping(node, path)
        if isinstance(node, yaml.SequenceNode):
            return [self.build(item, (*path, i)) for i, item in enumerate(node.value)]
        plain_nothing = node.style is None and node.value in _NULL_WORDS
        return None if plain_nothing else node.value

    def _mapping(self, node: Any, path: Path_) -> dict[str, Any]:
        import yaml

        mapping: dict[str, Any] = {}
        for key, value in node.value:
            key_path = (*path, key.value if isinstance(key, yaml.ScalarNode) else "?")
            if not isinstance(key, yaml.ScalarNode):
                self.document._values.setdefault(key_path, _mark(key))
                self.document.note(NO_KEY(), self.document.place(key_path))
                continue
            if value.start_mark.index == key.end_mark.index:  # {HPH, drug: 1} are two names, the first without a value
                self.document.note(NO_VALUE(key=key.value), _place(self.document.name, *_mark(key)))
                continue
            if key.value in mapping:
                first = self.document._keys[key_path][0]
                self.document.note(KEY_TWICE(key=key.value, first=first), _place(self.document.name, *_mark(key)))
                continue
            self.document._keys[key_path] = _mark(key)
            mapping[key.value] = self.build(value, key_path)
        return mapping


def _mark(node: Any) -> tuple[int, int]:
    return node.start_mark.line + 1, node.start_mark.column + 1


def home_of(folder: Path) -> Path | None:
    """Return the study that a folder lies in, None if in none."""
    places = (folder.absolute(), *folder.absolute().parents)
    return next((place for place in places if (place / STUDY_FILE).is_file()), None)


def read_settings(path: Path) -> tuple[StudyFile | None, Document]:
    """Return the settings (None if there are errors) and the document, whose `problems` hold what is wrong."""
    document = read_document(path)
    with looking_in(path.parent):
        settings = validated(document)
    if settings is not None and not lies_inside(path.parent, settings.animals):
        document.note(TABLE_OUTSIDE(name=settings.animals), document.place(("animals",)))
    if (length := too_long(path.parent)) is not None:
        document.note(PATH_TOO_LONG(length=length), Place(str(path)))
    return None if document.problems else settings, document


def too_long(folder: Path) -> int | None:
    """Return the length of a study's path, in letters, if this system has no room below it for names of results."""
    place, name = folder.absolute(), _MAX_NAME_LETTERS * "x"
    for longest in (place / name, place / name / name):
        try:
            os.lstat(longest)
        except OSError as error:
            if error.errno == errno.ENAMETOOLONG:
                return len(str(place))
    return None


def parse_settings(raw: bytes, name: str = STUDY_FILE) -> tuple[StudyFile | None, list[StudyProblem]]:
    """Return the settings (None if there are errors) and what is wrong; never raises."""
    document = parse_document(raw, name)
    return validated(document), document.problems


def validated(document: Document) -> StudyFile | None:
    """Return the settings a document holds; what is wrong is added to its problems, and then None is returned."""
    # A section whose lines are all commented out is an empty one, not a wrong one.
    known_settings = settings_of(StudyFile)
    empty = [
        key
        for key, value in document.values.items()
        if value is None and key in known_settings and known_settings[key].section
    ]
    document.problems += _unknown_parameters(document)
    settings = read_values(StudyFile, {key: value for key, value in document.values.items() if key not in empty})
    if isinstance(settings, list):
        for keys, of_key, wrong in settings:
            document.note(wrong, document.place(keys, key=of_key))
        return None
    return None if document.problems else settings


def _unknown_parameters(document: Document) -> list[StudyProblem]:
    """Return the parameters under ``bounds`` and ``fixed`` that no wall law of the study, nor any of ours, has."""
    calibration = document.values.get("calibration")
    if not isinstance(calibration, dict):
        return []
    walls = calibration.get("walls")
    names = [wall for wall in map(_named, walls) if _is_found(find_law, wall)] if isinstance(walls, list) else []
    beds = _named(calibration.get("beds", "windkessel"))
    unread = any(map(is_unread, (beds, *map(_named, walls if isinstance(walls, list) else ()))))
    viscous = is_true(calibration.get("viscous"))
    known_names = known_parameters(names, beds if _is_found(find_bed, beds) else "windkessel", viscous)
    problems = []
    for section in ("bounds", "fixed"):
        section_values = calibration.get(section)
        for name in section_values if isinstance(section_values, dict) else ():
            if name not in known_names and not (unread and "." in name):
                keys = ["calibration", section]
                unknown = unknown_word(keys, name, known_names)
                problems.append(StudyProblem(unknown.placed(document.place([*keys, name], key=True))))
    return problems


def _named(name: Any) -> str:
    try:
        return named(str(name))
    except InputError:
        return str(name)


def _is_found(find: Callable[[str], Any], name: Any) -> bool:
    try:
        find(str(name))
    except InputError:
        return False
    return True
