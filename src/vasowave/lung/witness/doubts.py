"""A doubt about an answer: what contradicts it, how grave that is, where, and which vessels it concerns."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Literal

import numpy as np

from vasowave.base.findings import Finding, FindingKind, Severity, kind, note_kind, warn
from vasowave.pulse.network.network import Network

About = Literal["topology", "length", "radius", "loop"]
FIRST = 5
"""So many doubts are said at once; the others stand in the page and in extraction.json."""


class Grade(StrEnum):
    """How grave a doubt is, the gravest first."""

    WRONG = "wrong"
    """The answer contradicts the image: do not use what is named."""
    LOOK = "look"
    """The image shows what the answer does not explain: look before you use it."""
    UNCERTAIN = "uncertain"
    """A number is known no better than its SD says, and the SD goes on with it."""


_SEVERITIES = {Grade.WRONG: Severity.ERROR, Grade.LOOK: Severity.LOOK, Grade.UNCERTAIN: Severity.NOTE}
_CODES: set[str] = set()
_GRADES = {severity: grade for grade, severity in _SEVERITIES.items()}


def doubt_kind(code: str, grade: Grade, text: str, remedy: str = "") -> FindingKind:
    """Declare a kind of finding that a doubt is made of; its text begins with the grade, unless that is what every
    warning asks for: a look. Raises as `kind`.
    """
    _CODES.add(code)
    return kind(code, _SEVERITIES[grade], text if grade is Grade.LOOK else f"{grade}: {text}", remedy)


def is_doubt(finding: Finding) -> bool:
    """Whether a finding is that of a doubt, or says how many more there are."""
    return finding.code in _CODES


MORE = note_kind(
    "witness.more",
    "further doubts in review.html and extraction.json: {count} ({wrong} wrong, {look} to look at, {uncertain} "
    "uncertain as the SD says)",
)
_CODES.add(MORE.code)


@dataclass(frozen=True, eq=False)
class Doubt:
    """One thing in the image that the answer does not explain, or one number that it does not settle.

    Attributes
    ----------
    about : "topology", "length", "radius" or "loop"
        What may be wrong; "loop": whatever depends on where a ring of the lumen is cut.
    finding : Finding
        What was seen and what to do.
    vessels : tuple of str
        Names of the vessels that may be wrong.
    places : float array, shape (place, 3)
        Where, z, y, x, cm; may be empty.
    flow : float
        Share of the mean flow (eq. 11) that passes at least one of the vessels; NaN before `ranked`.
    """

    about: About
    finding: Finding
    vessels: tuple[str, ...] = ()
    places: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    flow: float = np.nan

    @property
    def text(self) -> str:
        """The finding in words."""
        return str(self.finding)

    @property
    def grade(self) -> Grade:
        """How grave it is."""
        return _GRADES[self.finding.severity]


def ranked(doubts: Iterable[Doubt], network: Network) -> tuple[Doubt, ...]:
    """Return the doubts with their share of the flow, the gravest first, of one grade the largest share first."""
    graded = [replace(doubt, flow=_flow(doubt.vessels, network)) for doubt in doubts]
    return tuple(sorted(graded, key=lambda doubt: (list(Grade).index(doubt.grade), -doubt.flow)))


def warn_of(doubts: tuple[Doubt, ...]) -> None:
    """Warn of the first of the `ranked` doubts, and say how many more there are."""
    for doubt in doubts[:FIRST]:
        warn(doubt.finding)
    if grades := [doubt.grade for doubt in doubts[FIRST:]]:
        warn(MORE(count=len(grades), **{grade.value: grades.count(grade) for grade in Grade}))


def gravest(doubts: Iterable[Doubt], vessel: str) -> Grade | None:
    """Return the gravest grade that a doubt gives a vessel; None without a doubt."""
    grades = {doubt.grade for doubt in doubts if vessel in doubt.vessels}
    return next((grade for grade in Grade if grade in grades), None)


def _flow(vessels: tuple[str, ...], network: Network) -> float:
    rows = {network.name.index(name) for name in vessels}
    if not rows:
        return 1.0
    return float(sum(network.flow_fraction[row] for row in rows if not _above(row, network) & rows))


def _above(row: int, network: Network) -> set[int]:
    """Return all rows between a vessel and the root."""
    rows, ancestor = set(), int(network.parent[row])
    while ancestor >= 0:
        rows.add(ancestor)
        ancestor = int(network.parent[ancestor])
    return rows
