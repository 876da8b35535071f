"""What is noticed of data and models, as values: a code and numbers. Text is written from them, in one place each.

A kind of finding is declared beside the code that finds it. Calling it with its values makes a finding::

    RANG = kind("recording.catheter-rings", Severity.LOOK, "its catheter rang at {frequency:.0f} Hz", remedy="flush it")
    notes.append(RANG(frequency=310.0))

Nobody looks into a text: what is done about a finding follows from its code and its severity.
"""

import json
import warnings
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum

from vasowave.errors import VasowaveWarning

Value = float | int | str | bool


class Severity(StrEnum):
    """What a finding asks of a person."""

    NOTE = "note"
    """Nothing; it says how a number came about."""
    LOOK = "look"
    """A look: the data may not be what they are taken for."""


@dataclass(frozen=True)
class Kind:
    """One kind of finding.

    Attributes
    ----------
    code : str
        ``room.what``; it is stored and never changes its meaning.
    severity : Severity
    text : str
        A format string of the values.
    remedy : str
        What a person can do about it, for the table in the docs; empty where there is nothing to do.
    """

    code: str
    severity: Severity
    text: str
    remedy: str = ""

    def __call__(self, **values: Value) -> "Finding":
        """Return a finding of this kind."""
        return Finding(self.code, tuple(values.items()))


KINDS: dict[str, Kind] = {}
"""All kinds by code, as the modules that declare them are loaded."""


def kind(code: str, severity: Severity, text: str, remedy: str = "") -> Kind:
    """Declare a kind of finding.

    Raises
    ------
    ValueError
        The code is taken.
    """
    if code in KINDS:
        raise ValueError(f"the code '{code}' is declared twice")
    KINDS[code] = Kind(code, severity, text, remedy)
    return KINDS[code]


@dataclass(frozen=True)
class Finding:
    """One thing that was noticed.

    Attributes
    ----------
    code : str
        Of its kind.
    values : tuple of (str, value)
        Numbers and names that its text is made of.
    file : str
        The file that it was noticed in; empty where it is clear.
    """

    code: str
    values: tuple[tuple[str, Value], ...] = ()
    file: str = ""

    @property
    def severity(self) -> Severity:
        """What it asks of a person."""
        return KINDS[self.code].severity

    def at(self, file: str) -> "Finding":
        """Return the finding with the file that it was noticed in."""
        return replace(self, file=file)

    def inside(self, folder: str) -> "Finding":
        """Return the finding with file names as seen from a folder, given with its last separator."""
        seen = tuple((name, one.replace(folder, "") if isinstance(one, str) else one) for name, one in self.values)
        return replace(self, values=seen, file=self.file.replace(folder, ""))

    def __str__(self) -> str:
        """Return its text, without the file."""
        return KINDS[self.code].text.format(**dict(self.values))


OTHER = kind("other", Severity.LOOK, "{text}")
"""A warning that has no kind of its own yet."""


class FindingWarning(VasowaveWarning):
    """A finding on its way to whoever listens."""

    def __init__(self, finding: Finding) -> None:
        super().__init__(f"{finding.file}: {finding}" if finding.file else str(finding))
        self.finding = finding


def warn(finding: Finding, stacklevel: int = 2) -> None:
    """Warn of a finding, as of a line of the caller's caller by default."""
    warnings.warn(FindingWarning(finding), stacklevel=stacklevel + 1)


def finding_of(warning: Warning | str) -> Finding:
    """Return the finding that a warning carries; another warning's text becomes one."""
    return warning.finding if isinstance(warning, FindingWarning) else OTHER(text=str(warning))


def texts(findings: Iterable[Finding]) -> list[str]:
    """Return the texts of findings."""
    return [str(one) for one in findings]


def as_json(findings: Iterable[Finding]) -> str:
    """Return findings as a JSON list; each has its text too, for programs that know no codes."""
    rows = [
        {"code": one.code, "severity": one.severity, "text": str(one), "values": dict(one.values)}
        | ({"file": one.file} if one.file else {})
        for one in findings
    ]
    return json.dumps(rows, ensure_ascii=False)


def from_json(text: str) -> tuple[Finding, ...]:
    """Return the findings of a JSON list; of a code that this program does not know, the text."""
    return tuple(
        Finding(row["code"], tuple(row["values"].items()), row.get("file", ""))
        if row["code"] in KINDS
        else Finding(OTHER.code, (("text", row["text"]),), row.get("file", ""))
        for row in json.loads(text)
    )
