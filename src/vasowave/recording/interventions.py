"""Comments of a recording: which speak of an intervention, and which stretch is read because of them."""

import re
from collections.abc import Sequence
from itertools import pairwise

from vasowave.findings import Finding, look_kind, note_kind
from vasowave.recording.channels import Comment
from vasowave.recording.gaps import Span

_SHORTEST, _SHORTEST_SHARE = 3.0, 0.05
"""A stretch between interventions is read by default if it lasts so many s, and this share of the recording."""

_NEAR = 5.0  # s around a comment, in which a step of the pressure may be what it speaks of
_LISTED = 8  # comments in a text

_DOSES = r"\d\s*(?:[muµμn]g|g/kg|mcg|ml|[µμu]l|i?u|[mµμun]?mol)(?:\s*/|\b)|(?:\d|fi)\s*%?\s*o2|%\s*(?:o2|co2|n2)"
_ACTS = (
    r"\b(?:inje[ck]|bolus|infus|inhal|hypox|hyperox|hypercap|anox|occlu|clamp|ligat|ligier|embol|constrict|stimul|"
    r"pacing|paced|exercise|wash\s?-?out|vehicle|saline|dose|drug|h[ae]+morrh|transfus|peep|recruit)|"
    r"\bi\.?\s?[vp]\.?\b|\bno\b(?:\s*\d|$)|\b(?:after|post|nach)\b"
)
_DRUGS = (
    r"(?:afil|entan|iguat|prost|prost[ae]nil|cyclin|drenalin|ephrine|utamine|opamine|olol|dipine|prusside|nitrite|"
    r"nitric oxide|acetylcholin|l-name|u-?46619|endothelin|serotonin|isoprenalin|heparin|ketamin|isofluran)e?\b"
)
_INTERVENTION = re.compile(f"{_DOSES}|{_ACTS}|{_DRUGS}", re.IGNORECASE)

COMMENTS = note_kind("recording.comments", "comments in the recording: {listed}")
_CHOOSE = (
    "To read another stretch: `start` and `end` (vasowave add and fit: --start, --end; a study's table: 'start [s]')."
)
INTERVENTION = look_kind(
    "recording.intervention",
    "'{text}' is noted at {time:.4g} s, so that what is {side} it was read, {start:.4g} to {end:.4g} s. {remedy}",
    _CHOOSE,
)
INTERVENTION_WITHIN = look_kind(
    "recording.intervention-within",
    "'{text}' is noted at {time:.4g} s, within the stretch that is read: beats before and after it may differ. "
    "{remedy}",
    _CHOOSE,
)


def is_intervention(text: str) -> bool:
    """Whether a comment speaks of a drug, a dose, a gas or a manoeuvre."""
    return _INTERVENTION.search(text) is not None


def listed(comments: Sequence[Comment]) -> str:
    """Return comments in a line: their times and texts."""
    more = f" and {len(comments) - _LISTED} more" if len(comments) > _LISTED else ""
    return ", ".join(f"'{one.text}' at {one.time:.4g} s" for one in comments[:_LISTED]) + more


def comment_findings(
    comments: Sequence[Comment], lasts: float, start: float | None, end: float | None
) -> tuple[Span, Span, list[Finding]]:
    """Return the stretch to read, the longest around it without an intervention, and what is to be said.

    Where nobody names a stretch, the first between two interventions that is long enough is read: the animal as it was.

    Parameters
    ----------
    comments : sequence of Comment
    lasts : float
        Length of the recording, s.
    start, end : float, optional
        The stretch that was asked for, s.
    """
    comments = sorted((one for one in comments if one.text), key=lambda one: one.time)
    acts = [one for one in comments if is_intervention(one.text) and 0 < one.time < lasts]
    found = [COMMENTS(listed=listed(comments))] if comments else []
    edges = [0.0, *(one.time for one in acts), lasts]
    parts = [Span(*ends) for ends in pairwise(edges)]
    if start is None and end is None:
        longest = max(parts, key=lambda one: one.end - one.start)
        enough = max(_SHORTEST, _SHORTEST_SHARE * lasts)
        part = next((one for one in parts if one.end - one.start >= enough), longest)
        if acts:
            act = next((one for one in reversed(acts) if one.time <= part.start), acts[0])
            side = "after" if act.time <= part.start else "before"
            found.append(INTERVENTION(text=act.text, time=act.time, side=side, start=part.start, end=part.end))
        return part, part, found
    asked = Span(start or 0.0, lasts if end is None else end)
    inside = [one for one in acts if asked.start < one.time < asked.end]
    found += [INTERVENTION_WITHIN(text=one.text, time=one.time) for one in inside]
    around = [one for one in parts if one.end > asked.start and one.start < asked.end]
    return asked, Span(around[0].start, around[-1].end) if around else asked, found


def near(comments: Sequence[Comment], time: float) -> Comment | None:
    """Return the comment beside which something happened at a time, s; None if there is none."""
    beside = [one for one in comments if one.text and abs(one.time - time) <= _NEAR]
    return min(beside, key=lambda one: abs(one.time - time), default=None)
