"""Comments of a recording: which speak of an intervention, and which stretch is read because of them."""

import re
from collections.abc import Sequence
from itertools import pairwise

from vasowave.base.cures import STRETCH
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.catheter.signals.channels import Comment
from vasowave.catheter.signals.gaps import Span

_MIN_STRETCH_S, _MIN_STRETCH_SHARE = 3.0, 0.05
"""A stretch between interventions is read by default if it lasts so many s, and this share of the recording."""

_STEP_DISTANCE_S = 5.0  # s around a comment, in which a step of the pressure may be what it speaks of
_MAX_LISTED_COMMENTS = 8  # comments in a text

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
_STRETCH_REMEDY = "If another part is the animal's, choose its stretch."
INTERVENTION = look_kind(
    "recording.intervention",
    "'{text}' is noted at {time:.4g} s, so that what is {side} it was read, {start:.4g} to {end:.4g} s. {remedy}",
    _STRETCH_REMEDY,
    STRETCH,
)
INTERVENTION_WITHIN = look_kind(
    "recording.intervention-within",
    "'{text}' is noted at {time:.4g} s, within the stretch that is read: beats before and after it may differ. "
    "{remedy}",
    _STRETCH_REMEDY,
    STRETCH,
)


def is_intervention(text: str) -> bool:
    """Whether a comment speaks of a drug, a dose, a gas or a manoeuvre."""
    return _INTERVENTION.search(text) is not None


def listed(comments: Sequence[Comment]) -> str:
    """Return comments in a line: their times and texts."""
    suffix = f" and {len(comments) - _MAX_LISTED_COMMENTS} more" if len(comments) > _MAX_LISTED_COMMENTS else ""
    return (
        ", ".join(f"'{comment.text}' at {comment.time:.4g} s" for comment in comments[:_MAX_LISTED_COMMENTS]) + suffix
    )


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
    comments = sorted((comment for comment in comments if comment.text), key=lambda comment: comment.time)
    acts = [comment for comment in comments if is_intervention(comment.text) and 0 < comment.time < lasts]
    findings = [COMMENTS(listed=listed(comments))] if comments else []
    edges = [0.0, *(comment.time for comment in acts), lasts]
    stretches = [Span(*ends) for ends in pairwise(edges)]
    if start is None and end is None:
        longest = max(stretches, key=lambda candidate: candidate.end - candidate.start)
        enough = max(_MIN_STRETCH_S, _MIN_STRETCH_SHARE * lasts)
        stretch = next((candidate for candidate in stretches if candidate.end - candidate.start >= enough), longest)
        if acts:
            act = next((comment for comment in reversed(acts) if comment.time <= stretch.start), acts[0])
            side = "after" if act.time <= stretch.start else "before"
            findings.append(INTERVENTION(text=act.text, time=act.time, side=side, start=stretch.start, end=stretch.end))
        return stretch, stretch, findings
    span = Span(start or 0.0, lasts if end is None else end)
    inside = [comment for comment in acts if span.start < comment.time < span.end]
    findings += [INTERVENTION_WITHIN(text=comment.text, time=comment.time) for comment in inside]
    around = [candidate for candidate in stretches if candidate.end > span.start and candidate.start < span.end]
    return span, Span(around[0].start, around[-1].end) if around else span, findings


def near(comments: Sequence[Comment], time: float) -> Comment | None:
    """Return the comment beside which something happened at a time, s; None if there is none."""
    matches = [comment for comment in comments if comment.text and abs(comment.time - time) <= _STEP_DISTANCE_S]
    return min(matches, key=lambda comment: abs(comment.time - time), default=None)
