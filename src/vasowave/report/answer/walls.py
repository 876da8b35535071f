"""The answer to 'Which wall?': by the posteriors where there are any, else by the residuals, pooled over animals."""

import numpy as np
import pandas as pd

from vasowave.cohort.cohort import Cohort
from vasowave.cohort.votes import differences
from vasowave.cohort.walls import CLEAR, Evidence, Exponent, evidences, exponent_of
from vasowave.report.wording import listed, number, with_interval

_LOOKS_LIKE = "Errors of the geometry, a taper or a stiffness that changes along the tree can look like curvature."
_STILL_LOOKS_LIKE = "Image and structure count as unknown in this; a taper can still look like another wall."
_MOST_RATIOS = 4
"""Animals up to which the ratio of each is written."""


def wall_answer(cohort: Cohort, law: str) -> tuple[str, str]:
    """Return question and answer."""
    weighed = [one for one in evidences(cohort, law) if one.ratios]
    said = [_evidence(one, law, cohort) for one in weighed]
    by_residuals = _by_residuals(cohort, law, {one.wall for one in weighed})
    exponents = [(wall, one) for wall in cohort.walls if (one := exponent_of(cohort, wall)) is not None]
    of_fits = (bool(by_residuals) and bool(cohort.compared)) or any(not one.drawn for _, one in exponents)
    caveat = [_LOOKS_LIKE] if of_fits else [_STILL_LOOKS_LIKE] if said or exponents else []
    if len(cohort.walls) < 2:
        said.append(f"Only the {law} wall was fitted; nothing is known of others.")
    return "Which wall?", " ".join(
        [*said, *by_residuals, *(_exponent(*one, cohort.repeated) for one in exponents), *caveat]
    )


def _evidence(one: Evidence, law: str, cohort: Cohort) -> str:
    """Say what the evidences of one pair of laws come to, and how many animals are clear."""
    side, (favorable, contrary) = one.side, one.clear
    better, worse = (one.wall, law) if side < 0 else (law, one.wall)
    n = len(one.ratios)
    if side:
        verdict = f"The posteriors speak for the {better} wall against the {worse} wall"
    elif favorable and contrary:
        verdict = f"The animals differ between the {law} and the {one.wall} wall"
    else:
        verdict = f"The posteriors do not decide between the {law} and the {one.wall} wall"
    ratios = np.array(list(one.ratios.values())) ** (-1.0 if side < 0 else 1.0)
    clear = "" if cohort.single else f"; {_clear(favorable, contrary, n, law, one.wall)}"
    said = f"{verdict}: by their evidences the recording is {_times(ratios)} as likely under the {better} law as "
    said += f"under the other{clear}."
    if not one.untrusted:
        return said
    untrusted = f"{len(one.untrusted)} of {len(cohort.results)} animals"
    return f"{said} Not counted are {untrusted} with a posterior that cannot be trusted."


def _times(ratios: np.ndarray) -> str:
    """Return how many times, of each animal or, of many, the median and the range."""
    if len(ratios) <= _MOST_RATIOS:
        return f"{listed([_ratio(one) for one in ratios])} times"
    ends = f"{_ratio(ratios.min())} to {_ratio(ratios.max())}"
    return f"{_ratio(float(np.median(ratios)))} times (median; {ends})"


def _ratio(value: float) -> str:
    return "over 1000" if value > 1000 else number(float(value), 2) if value >= 1e-3 else "under 0.001"


def _clear(favorable: int, contrary: int, n: int, law: str, wall: str) -> str:
    counts = [f"for the {name} law in {count} of {n} animals"
              for name, count in ((law, favorable), (wall, contrary)) if count]  # fmt: skip
    return f"{CLEAR:g} times or more {listed(counts) if counts else f'in none of {n} animals'}"


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
    decided, undecided = table[table["speaks for"] != ""], table[table["speaks for"] == ""]
    said = [
        f"The residuals speak for the {row['speaks for']} wall against the "
        f"{row['wall'] if row['speaks for'] == law else law} wall (AICc)."
        for _, row in decided.iterrows()
    ]
    if len(undecided):
        walls = listed([f"the {wall}" for wall in (law, *undecided["wall"])])
        said.append(f"The residuals do not decide between {walls} wall (AICc).")
    return said


def _exponent(wall: str, one: Exponent, repeated: bool) -> str:
    """Say how the wall stiffens where a law has a parameter for it."""
    verdict = {1: "The wall stiffens more than a linear one", -1: "The wall stiffens less than a linear one",
               0: "It is open whether the wall stiffens more or less than a linear one"}[one.side]  # fmt: skip
    ends = [(end, count) for end, count in (("lower", one.below), ("upper", one.above)) if count]
    source = f"{wall} law{', posteriors' if one.drawn else ''}"
    about = [source, f"{one.linear:g} is linear"]
    if one.animals > 1:
        bounds = [f"{count} beyond the {end} bound of the search" for end, count in ends]
        firsts = ", the first recording of each" if repeated else ""
        about.append(f"{one.animals} animals pooled{firsts}" + (f", of them {listed(bounds)}" if bounds else ""))
    else:
        about += [f"the search stopped at its {end} bound" for end, _ in ends]
    return f"{verdict}: {_range(one)} ({'; '.join(about)})."


def _range(one: Exponent) -> str:
    if np.isfinite(one.high) and one.low > 0:
        return f"{one.name} = {with_interval(one.value, one.low, one.high)}"
    if np.isfinite(one.high):
        return f"{one.name} is at most {number(one.high, 2)} (95 %)"
    return f"{one.name} is at least {number(one.low, 2)} (95 %)" if one.low > 0 else f"{one.name} is not determined"
