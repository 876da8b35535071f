"""Findings about data and models, as values: a code and numbers. Text is written from them, in one place each.

A kind of finding is declared beside the code that finds it. Calling it with its values makes a finding::

    RANG = look_kind("recording.catheter-rings", "its catheter rang at {frequency:.0f} Hz", "Flush it.")
    notes.append(RANG(frequency=310.0))

Nobody looks into a text: what is done about a finding follows from its code and its severity. What a person can do is
the remedy, a sentence that names no command, function or button, and the cures, which each door writes in its own way.
A text that holds the remedy within itself takes it from the kind, as ``{remedy}``.
"""

import json
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from string import Formatter
from typing import Any, NamedTuple

from vasowave.base.cures import Cure, arguments, filled
from vasowave.base.errors import VasowaveWarning, printable
from vasowave.base.stores import parsed_as

Value = float | int | str | bool

_SHORT = 80  # letters of a text that are shown where many findings may be


class Severity(StrEnum):
    """The action that a finding asks for."""

    NOTE = "note"
    """Nothing; it says how a number came about."""
    LOOK = "look"
    """A look: the data may not be what they are taken for."""
    ERROR = "error"
    """A correction: it cannot go on like this."""


class Place(NamedTuple):
    """The place of a finding; what is clear, or does not apply, is empty.

    Attributes
    ----------
    file : str
    line : int
        Counted from 1.
    part : str
        Of the line or the file: ``column 'group'``, ``header``.
    animal : str
    vessel : str
    law : str
        Name of a wall law.
    """

    file: str = ""
    line: int = 0
    part: str = ""
    animal: str = ""
    vessel: str = ""
    law: str = ""

    def __str__(self) -> str:
        """Return the words that lead there in a file."""
        fragments = (self.file, f"line {self.line}" if self.line else "", self.part)
        where = ", ".join(filter(None, fragments))
        return f"{where} ('{self.animal}')" if where and self.animal else where or self.animal


NOWHERE = Place()


@dataclass(frozen=True)
class FindingKind:
    """One kind of finding.

    Attributes
    ----------
    code : str
        ``room.what``; it is stored and never changes its meaning.
    severity : Severity
    text : str
        A format string of the values, the parts of the place, and ``remedy``.
    remedy : str
        What a person can do about it, a format string of the values; empty where there is nothing to do.
    cures : tuple of Cure
        The same as what a door can do; texts in them are format strings of the values.
    """

    code: str
    severity: Severity
    text: str
    remedy: str = ""
    cures: tuple[Cure, ...] = ()

    def __call__(self, **values: Value) -> "Finding":
        """Return a finding of this kind."""
        return Finding(self.code, tuple(values.items()))


ITSELF = "It says itself what to do."
"""Remedy of a kind that passes on the text of an error."""

KINDS: dict[str, FindingKind] = {}
"""All kinds by code, as the modules that declare them are loaded."""


def note_kind(code: str, text: str) -> FindingKind:
    """Declare a kind of finding that asks for nothing; raises as `kind`."""
    return kind(code, Severity.NOTE, text)


def look_kind(code: str, text: str, remedy: str, *cures: Cure) -> FindingKind:
    """Declare a kind of finding that asks for a look; raises as `kind`."""
    return kind(code, Severity.LOOK, text, remedy, *cures)


def error_kind(code: str, text: str, remedy: str, *cures: Cure) -> FindingKind:
    """Declare a kind of finding that must be corrected; raises as `kind`."""
    return kind(code, Severity.ERROR, text, remedy, *cures)


def kind(code: str, severity: Severity, text: str, remedy: str = "", *cures: Cure) -> FindingKind:
    """Declare a kind of finding.

    Raises
    ------
    ValueError
        The code is taken.
    """
    if code in KINDS:
        raise ValueError(f"the code '{code}' is declared twice")
    KINDS[code] = FindingKind(code, severity, text, remedy, cures)
    return KINDS[code]


@dataclass(frozen=True, repr=False)
class Finding:
    """One thing that was noticed.

    Attributes
    ----------
    code : str
        Of its kind.
    values : tuple of (str, value)
        Numbers and names that its text is made of.
    place : Place
    raised_cures : tuple of Cure
        Where they are not those of its kind alone, as of an error that a reader raised.
    """

    code: str
    values: tuple[tuple[str, Value], ...] = ()
    place: Place = NOWHERE
    raised_cures: tuple[Cure, ...] = field(default=(), compare=False)

    @property
    def room(self) -> str:
        """The first half of its code: what it is about."""
        return self.code.partition(".")[0]

    @property
    def severity(self) -> Severity:
        """The action that it asks for."""
        return _kind_of(self).severity

    @property
    def remedy(self) -> str:
        """What a person can do about it, in words that fit every door; empty where there is nothing to do."""
        return printable(_formatted(_kind_of(self).remedy, self))

    @property
    def advice(self) -> str:
        """Its remedy where the text does not hold it, else empty."""
        kind = _kind_of(self)
        held = kind.remedy is ITSELF or "remedy" in _names_in(kind.text) or _STORED_TEXT in dict(self.values)
        return "" if held else self.remedy

    @property
    def cures(self) -> tuple[Cure, ...]:
        """What a door can do about it."""
        values = self.place._asdict() | dict(self.values)
        try:
            return self.raised_cures or tuple(filled(cure, values) for cure in _kind_of(self).cures)
        except LookupError:  # stored by a version that gave other values
            return ()

    def at(self, file: str | None = None, **place: Any) -> "Finding":
        """Return the finding with the file that it was noticed in, or another part of its place."""
        place |= {} if file is None else {"file": file}
        return replace(self, place=self.place._replace(**place))

    def placed(self, place: Place) -> "Finding":
        """Return the finding at a place; what that leaves open, as a vessel, stays as it is."""
        return replace(
            self, place=self.place._replace(**{field: value for field, value in place._asdict().items() if value})
        )

    def inside(self, folder: str) -> "Finding":
        """Return the finding with file names as seen from a folder, given with its last separator."""
        values = tuple(
            (name, value.replace(folder, "") if isinstance(value, str) else value) for name, value in self.values
        )
        return replace(self, values=values).at(self.place.file.replace(folder, ""))

    def __reduce__(self) -> tuple[Any, ...]:
        """Take its kind along: where it is unpickled, the module that declares it may not be loaded."""
        return _with_kind, (_kind_of(self), self.values, self.place, self.raised_cures)

    def __repr__(self) -> str:
        """Return one line: its code and the beginning of its text."""
        text = str(self)
        return f"Finding({self.code}: {text if len(text) <= _SHORT else f'{text[:_SHORT]}...'})"

    def __str__(self) -> str:
        """Return its text; of the place it holds what the text of its kind asks for."""
        kind, values = _kind_of(self), dict(self.values)
        if _STORED_TEXT in values:
            return printable(str(values[_STORED_TEXT]))
        return printable(_formatted(kind.text, self))


def _formatted(text: str, finding: Finding) -> str:
    """Return a text of a kind with the values of a finding and the parts of its place."""
    values = finding.place._asdict() | dict(finding.values)
    remedy = _kind_of(finding).remedy.format(**values) if "remedy" in _names_in(text) else ""
    return text.format(**values | {"remedy": remedy})


OTHER = kind("other", Severity.LOOK, "{text}", ITSELF)
"""A warning that has no kind of its own yet."""


class FindingWarning(VasowaveWarning):
    """A warning that carries a finding."""

    def __init__(self, finding: Finding) -> None:
        offered = " or ".join(arguments(finding.cures))
        text = sentence(finding) + (f" [{offered}]" if offered else "")
        super().__init__(f"{finding.place}: {text}" if finding.place.file else text)
        self.finding = finding


def warn(finding: Finding, stacklevel: int = 2) -> None:
    """Warn of a finding, as of a line of the caller's caller by default."""
    warnings.warn(FindingWarning(finding), stacklevel=stacklevel + 1)


def finding_of(warning: Warning | str) -> Finding:
    """Return the finding that a warning carries; another warning's text becomes one."""
    return warning.finding if isinstance(warning, FindingWarning) else OTHER(text=str(warning))


def found_in(caught: Iterable[warnings.WarningMessage]) -> tuple[Finding, ...]:
    """Return the findings of our own among warnings that were recorded."""
    return tuple(finding_of(warning.message) for warning in caught if issubclass(warning.category, VasowaveWarning))


def shared(by_law: Mapping[str, Sequence[Finding]]) -> list[Finding]:
    """Return findings about wall laws: what several laws all share once, what is of one with its law."""
    common = [
        finding
        for finding in next(iter(by_law.values()), ())
        if all(finding in law_findings for law_findings in by_law.values())
    ]
    common = common if len(by_law) > 1 else []
    specific_findings = [
        finding.at(law=law) for law, findings in by_law.items() for finding in findings if finding not in common
    ]
    return list(dict.fromkeys([*common, *specific_findings]))


def sentence(finding: Finding) -> str:
    """Return the text of a finding with its remedy, as a report has it."""
    text, advice = str(finding), finding.advice
    if not advice:
        return text
    return f"{text}{'' if text[-1:] in '.?!' else '.'} {advice[0].upper()}{advice[1:]}"


def texts(findings: Iterable[Finding]) -> list[str]:
    """Return the sentences of findings; that of one law begins with its name."""
    return [
        f"{finding.place.law} wall{_OF_ROOM.get(finding.room, '')}: {sentence(finding)}"
        if finding.place.law
        else sentence(finding)
        for finding in findings
    ]


_OF_ROOM = {"posterior": ", posterior"}


def as_json(findings: Iterable[Finding]) -> str:
    """Return findings as a JSON list; each has its text too, for programs that know no codes."""
    rows = [
        {"code": finding.code, "severity": finding.severity, "text": str(finding), "values": dict(finding.values)}
        | {name: value for name, value in finding.place._asdict().items() if value}
        for finding in findings
    ]
    return json.dumps(rows, ensure_ascii=False)


def from_json(text: str) -> tuple[Finding, ...]:
    """Return the findings of a JSON list; one whose kind is not declared here keeps its code, severity and text.

    One of a kind that asks for other values here, as it was stored by another version, keeps its text.

    Raises
    ------
    ValueError
        They are none, or cannot be put into words.
    """
    try:
        findings = tuple(_stored(row) for row in parsed_as(list[dict[str, Any]], text))
        for finding in findings:
            str(finding), hash(finding)
    except (ArithmeticError, LookupError, AttributeError, TypeError) as error:
        raise ValueError(f"a finding without its values ({error})") from None
    return findings


def _stored(row: Mapping[str, Any]) -> Finding:
    code, values = row["code"], row["values"]
    place = {name: value for name, value in row.items() if name in Place._fields}
    if code not in KINDS:
        _STORED[code] = FindingKind(code, Severity(row["severity"]), "{text}")
        values = values | {"text": row["text"]}
    elif _names_in(KINDS[code].text + KINDS[code].remedy) - {*values, *Place._fields, "remedy"}:
        values = values | {_STORED_TEXT: row["text"]}
    return Finding(code, tuple(values.items()), Place(**place))


def _names_in(text: str) -> set[str]:
    return {name for _, name, *_ in Formatter().parse(text) if name}


_STORED_TEXT = "text as stored"
_STORED: dict[str, FindingKind] = {}
"""Kinds that results and other processes speak of, of modules that are not loaded, or of another version."""


def _with_kind(
    kind: FindingKind, values: tuple[tuple[str, Value], ...], place: Place, cures: tuple[Cure, ...]
) -> Finding:
    if kind.code not in KINDS:
        _STORED[kind.code] = kind
    return Finding(kind.code, values, place, cures)


def _kind_of(finding: Finding) -> FindingKind:
    return KINDS.get(finding.code) or _STORED[finding.code]
