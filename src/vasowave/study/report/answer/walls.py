"""The answer to 'Which wall?': by the posteriors where there are any, else by the residuals, pooled over animals."""

from collections import Counter

import numpy as np
import pandas as pd

from vasowave.base.descriptions import CLEAR_EVIDENCE_RATIO
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.votes import differences, enough
from vasowave.study.cohort.walls import Evidence, Exponent, evidences, exponent_of
from vasowave.study.report.wording import listed, number, with_interval

_LOOKS_LIKE = "Errors of the geometry, a taper or a stiffness that changes along the tree can look like curvature."
_STILL_LOOKS_LIKE = "Image and structure count as unknown in this; a taper can still look like another wall."
_MOST_RATIOS = 4
"""Animals up to which the ratio of each is written."""


def wall_answer(cohort: Cohort, law: str) -> tuple[str, str]:
    """Return question and answer."""
    weighed = [evidence for evidence in evidences(cohort, law) if evidence.ratios or not evidence.enough]
    sentences = [_evidence(evidence, law, cohort) for evidence in weighed]
    by_residuals = _by_residuals(cohort, law, {evidence.wall for evidence in weighed})
    exponents = [(wall, exponent) for wall in cohort.walls if (exponent := exponent_of(cohort, wall)) is not None]
    of_fits = (bool(by_residuals) and bool(cohort.compared)) or any(not exponent.drawn for _, exponent in exponents)
    caveat = [_LOOKS_LIKE] if of_fits else [_STILL_LOOKS_LIKE] if sentences or exponents else []
    if len(cohort.walls) < 2:
        sentences.append(f"Only the {law} wall was fitted; nothing is known of others.")
    return "Which wall?", " ".join(
        [
            *sentences,
            *by_residuals,
            *(_exponent(wall, exponent, cohort.repeated) for wall, exponent in exponents),
            *caveat,
        ]
    )


def _evidence(evidence: Evidence, law: str, cohort: Cohort) -> str:
    """Say what the evidences of one pair of laws come to, and how many animals are clear."""
    if not evidence.enough:
        return _too_few(law, evidence.wall, len(evidence.ratios), evidence.unusable)
    side, (favorable, contrary) = evidence.side, evidence.clear
    better, worse = (evidence.wall, law) if side < 0 else (law, evidence.wall)
    n = len(evidence.ratios)
    if side:
        verdict = f"The posteriors speak for the {better} wall against the {worse} wall"
    elif favorable and contrary:
        verdict = f"The animals differ between the {law} and the {evidence.wall} wall"
    else:
        verdict = f"The posteriors do not decide between the {law} and the {evidence.wall} wall"
    ratios = np.array(list(evidence.ratios.values())) ** (-1.0 if side < 0 else 1.0)
    counts = [f"for the {name} law in {count} of {n} animals"
              for name, count in ((law, favorable), (evidence.wall, contrary)) if count]  # fmt: skip
    cleared = listed(counts) if counts else f"in none of {n} animals"
    clear = "" if cohort.single else f"; {CLEAR_EVIDENCE_RATIO:g} times or more {cleared}"
    text = f"{verdict}: by their evidences the recording is {_times(ratios)} as likely under the {better} law as "
    text += f"under the other{clear}."
    left_out = [f"{count} of {len(cohort.results)} animals with {reason}"
                for reason, count in Counter(evidence.left_out.values()).items()]  # fmt: skip
    return f"{text} Not counted are {listed(left_out)}." if left_out else text


def _too_few(law: str, wall: str, weighed: int, left_out: int) -> str:
    """Say why two walls are not weighed against each other."""
    remain = f"the {weighed} that remain are too few" if weighed > 1 else "too few remain"
    of_count = "" if weighed + left_out == 1 else f" of {left_out} of {weighed + left_out} animals"
    return (
        f"Not decided between the {law} and the {wall} wall: a fit{of_count} must not be used, for it strains a vessel "
        f"beyond what an artery survives or no wall meets the data{f'; {remain}' if of_count else ''}."
    )


def _times(ratios: np.ndarray) -> str:
    """Return how many times, of each animal or, of many, the median and the range."""
    if len(ratios) <= _MOST_RATIOS:
        return f"{listed([_ratio(ratio) for ratio in ratios])} times"
    ends = f"{_ratio(ratios.min())} to {_ratio(ratios.max())}"
    return f"{_ratio(float(np.median(ratios)))} times (median; {ends})"


def _ratio(value: float) -> str:
    return "over 1000" if value > 1000 else number(float(value), 2) if value >= 1e-3 else "under 0.001"


def _by_residuals(cohort: Cohort, law: str, answered: set[str]) -> list[str]:
    """Say what AICc says of the laws of which no posterior does."""
    if len(cohort.walls) < 2 or answered >= {wall for wall in cohort.walls if wall != law}:
        return []
    if not cohort.compared:
        return [] if answered else ["The laws were not compared by their residuals."]
    table = differences(cohort.ballots, law)
    if not len(table):
        return ["No noise model of the residuals could be kept, so they prefer no law."]
    table = table[~table["wall"].isin(answered)]
    return _residuals(table, law) if len(table) else []


def _residuals(table: pd.DataFrame, law: str) -> list[str]:
    """Say between which laws the residuals decide, by AICc; the supplement has its table."""
    sentences, undecided = [], dict[str, list[str]]()
    for _, row in table.iterrows():
        wall, preferred, weighed, left_out = (row[label] for label in ("wall", "speaks for", "n", "left out"))
        source = (
            f"AICc of {weighed}{f' of {weighed + left_out}' if left_out else ''} animals" if weighed > 1 else "AICc"
        )
        if not enough(weighed, left_out):
            sentences.append(_too_few(law, wall, weighed, left_out))
        elif preferred:
            worse = wall if preferred == law else law
            sentences.append(f"The residuals speak for the {preferred} wall against the {worse} wall ({source}).")
        else:
            undecided.setdefault(source, [law]).append(wall)
    return sentences + [
        f"The residuals do not decide between {listed([f'the {wall}' for wall in walls])} wall ({source})."
        for source, walls in undecided.items()
    ]


def _exponent(wall: str, exponent: Exponent, repeated: bool) -> str:
    """Say how the wall stiffens where a law has a parameter for it."""
    verdict = {1: "The wall stiffens more than a linear one", -1: "The wall stiffens less than a linear one",
               0: "It is open whether the wall stiffens more or less than a linear one"}[exponent.side]  # fmt: skip
    ends = [(end, count) for end, count in (("lower", exponent.below), ("upper", exponent.above)) if count]
    source = f"{wall} law{', posteriors' if exponent.drawn else ''}"
    about = [source, f"{exponent.linear:g} is linear"]
    if exponent.animals > 1:
        bounds = [f"{count} beyond the {end} bound of the search" for end, count in ends]
        firsts = ", the first recording of each" if repeated else ""
        about.append(f"{exponent.animals} animals pooled{firsts}" + (f", of them {listed(bounds)}" if bounds else ""))
    else:
        about += [f"the search stopped at its {end} bound" for end, _ in ends]
    about += [f"{exponent.left_out} not counted, whose fits must not be used"] if exponent.left_out else []
    return f"{verdict}: {_range(exponent)} ({'; '.join(about)})."


def _range(exponent: Exponent) -> str:
    if np.isfinite(exponent.high) and exponent.low > 0:
        return f"{exponent.name} = {with_interval(exponent.value, exponent.low, exponent.high)}"
    if np.isfinite(exponent.high):
        return f"{exponent.name} is at most {number(exponent.high, 2)} (95 %)"
    return (
        f"{exponent.name} is at least {number(exponent.low, 2)} (95 %)"
        if exponent.low > 0
        else f"{exponent.name} is not determined"
    )
