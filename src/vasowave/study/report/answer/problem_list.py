"""Problems that must be looked at; routine notes are none of them."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from vasowave.base.findings import Finding, Severity
from vasowave.study.cohort.cohort import Cohort
from vasowave.study.cohort.missing import Missing, PressureRank
from vasowave.study.cohort.primary import Primary
from vasowave.study.cohort.unused import unused_columns
from vasowave.study.cohort.votes import MAX_RESIDUAL_RATIO, is_lone
from vasowave.study.figures.matplotlib_style import short
from vasowave.study.report.answer.marks import MAX_NAMES, shortened
from vasowave.study.report.blocks import Block, Notice, Remarks
from vasowave.study.report.wording import OF_FLOW, number, span

_MAX_FAILURES = 8  # told one by one


_NONE = "All fits succeeded; none leaves 10 % of the pulse pressure unexplained, or twice what the best law leaves."
_NONE_BY_LAW = "Nothing failed, and by the {law} wall no problem was found; what another law has stands beside."
_OF_ANIMALS = {"blood": "its viscosity follows the hematocrit and the temperature of an animal that has its own"}
_NONE_OF_ONE = (
    "Nothing failed. One wall law was fitted, so that nothing shows whether another would meet the data better."
)


def problems(cohort: Cohort, primary: Primary) -> list[str]:
    """Return what is wrong: animals lost and what that may do to the comparison by the primary law, laws that failed or
    miss their data, a primary law that overstrains vessels, searches that found their optimum only once.
    """
    sentences = [f"{failure.animal} failed, {failure}" for failure in cohort.failures[:_MAX_FAILURES]]
    if len(cohort.failures) > _MAX_FAILURES:
        sentences.append(f"{len(cohort.failures) - _MAX_FAILURES} more failures stand in the table Failures.")
    if not cohort.single:
        sentences += [missing_text(missing, primary.law, cohort.repeated) for missing in primary.missing]
    interrupted = [result.name for result in cohort.results if result.interrupted]
    if interrupted:
        sentences.append(f"Interrupted: not all fits of {shortened(interrupted)} had finished.")
    if differing := cohort.differing_settings:
        words = ", ".join(f"{key} ({_OF_ANIMALS[key]})" if key in _OF_ANIMALS else key for key in differing)
        sentences.append(f"The animals were not all analyzed with the same settings: {words}.")
    return [*sentences, *_sites(cohort), *of_models(cohort, [primary.law])]


def of_models(cohort: Cohort, walls: Sequence[str]) -> list[str]:
    """Return what is wrong with fits: vessels that the walls overstrain, data that a law misses, a lone optimum."""
    missed = cohort.misfits[cohort.misfits["missed"]].groupby("wall", sort=False) if cohort.walls else ()
    misses = [
        _miss(str(wall), rows, OF_FLOW if cohort.law(str(wall)).compared == "flow" else "") for wall, rows in missed
    ]
    return [*overstrained(cohort, walls), *misses, *_alone(cohort)]


def _sites(cohort: Cohort) -> list[str]:
    """Say of which animals a further site speaks against the others, once for all laws that say so."""
    doubts = {
        (result.name, doubt.code): f"{short(result.name, 40)}, {law} wall: {doubt}"
        for result in cohort.results
        for law, fitted in result.laws.items()
        for doubt in fitted.site_doubts
    }
    return list(doubts.values())


def overstrained(cohort: Cohort, walls: Sequence[str]) -> list[str]:
    """Say of which animals laws explain the data by vessels that are strained beyond what an artery survives."""
    table = cohort.misfits
    table = table[table["wall"].isin(list(walls)) & table["growth"].notna()]
    return [
        f"By the {wall} wall vessels of {shortened(rows['animal'].tolist())} are strained beyond what an artery "
        f"survives: an area grows by up to {number(float(rows['growth'].max()))} %. Do not use its numbers there."
        for wall, rows in table.groupby("wall", sort=False)
    ]


def missing_text(missing: Missing, law: str, repeated: bool) -> str:
    """Say who is missing from the comparison of the groups, and what that may do to it; `repeated`: of recordings."""
    many, names = len(missing.animals) > 1, shortened(list(missing.animals))
    scope = f"by the {law} wall" if law and not missing.lost else "of the groups"
    return (
        f"The comparison {scope} misses {len(missing.animals)} of {missing.count} "
        f"{'recordings' if repeated else 'animals'} of {missing.group} ({names}). "
        f"{_standing(missing, 'they' if many else 'it')}"
    )


def _standing(missing: Missing, pronoun: str) -> str:
    if missing.standing is PressureRank.UNKNOWN:
        unknown = "its pressure is not known" if pronoun == "it" else "their pressures are not all known"
        reason = unknown if missing.others else "no animal of the group is left"
        return (
            f"Whether {pronoun} {'was' if pronoun == 'it' else 'were'} sicker than the others cannot be said: {reason}."
        )
    pressures, other_pressures = (span(np.array(values)) for values in (missing.pressures, missing.others))
    high = missing.standing in (PressureRank.ABOVE, PressureRank.HIGHER)
    return (
        f"Measured mPAP {pressures} mmHg, {missing.standing} ({other_pressures} mmHg): {missing.group} looks "
        f"{'healthier' if high else 'sicker'} there than it is, if pressure tells how sick an animal is."
    )


def problem_blocks(cohort: Cohort, primary: Primary) -> list[Block]:
    """Return the problems as an alarm, and quietly where routine notes stand."""
    sentences = problems(cohort, primary)
    warned = {result.name: result.looks for result in cohort.results}
    looks = _looks(warned)
    unused = [
        str(finding) for finding in unused_columns(cohort.variables, cohort.design, cohort.members, list(cohort.groups))
    ]
    doubted = _doubted_posteriors(cohort, primary.law)
    doubts = _looks(doubted)
    notices = {
        "Problems": sentences,
        "Recordings to look at": looks,
        "Animals to look at": unused,
        f"Posteriors to look at ({primary.law} wall)": doubts,
    }
    blocks = [Notice(title, items) for title, items in notices.items() if items]
    count = sum(finding not in result.looks for result in cohort.results for finding in result.findings)
    count -= sum(map(len, doubted.values()))
    none = [] if blocks else [_none(cohort, primary.law)]
    notes = [f"{count} routine notes stand with the animals in the supplement."] if count else []
    return [*blocks, *([Remarks("Checks", [*none, *notes])] if none or notes else [])]


def _none(cohort: Cohort, law: str) -> str:
    """Say that there is no problem, with any law or with the one that answers."""
    if overstrained(cohort, [wall for wall in cohort.walls if wall != law]):
        return _NONE_BY_LAW.format(law=law)
    return _NONE if len(cohort.walls) > 1 else _NONE_OF_ONE


def _doubted_posteriors(cohort: Cohort, law: str) -> dict[str, list[Finding]]:
    """Return what asks for a look in the posteriors whose numbers are the answers, by animal."""
    drawn = {result.name: result.laws[law].posterior for result in cohort.results if law in result.laws}
    findings = {name: [finding for finding in posterior.findings if finding.severity == Severity.LOOK]
             for name, posterior in drawn.items() if posterior is not None}  # fmt: skip
    return {name: doubts for name, doubts in findings.items() if doubts}


def _looks(warned: Mapping[str, Sequence[Finding]]) -> list[str]:
    """Return the warnings of recordings and networks: each with its animal, those of a kind that many have once."""
    of_kind: dict[str, list[tuple[str, str]]] = {}
    for name, findings in warned.items():
        for finding in findings:
            of_kind.setdefault(finding.code, []).append((short(name, 40), str(finding)))
    sentences = []
    for pairs in of_kind.values():
        if len(pairs) <= MAX_NAMES:
            sentences += [f"{name}: {text}" for name, text in pairs]
        else:
            sentences.append(
                f"{shortened(list(dict.fromkeys(name for name, _ in pairs)))}; of {pairs[0][0]}: {pairs[0][1]}"
            )
    return sentences


def _miss(wall: str, rows: pd.DataFrame, of_flow: str) -> str:
    worst = rows.iloc[int(rows["RMSE"].to_numpy().argmax())]
    against = (
        f"{number(float(worst['over best']), 2)} times what the best law leaves"
        if worst["over best"] > MAX_RESIDUAL_RATIO
        else f"{number(100 * float(worst['share']), 2)} % of the pulse pressure"
    )
    return (
        f"The {wall} wall misses the data of {shortened(rows['animal'].tolist())}: it leaves up to "
        f"{number(float(worst['RMSE']), 2)} mmHg{of_flow}, {against}. Do not use its "
        "numbers there: answer by another law, or leave such animals out and say so."
    )


def _alone(cohort: Cohort) -> list[str]:
    """Name searches of several starts of which only one came to the best optimum."""
    sentences = []
    for wall in cohort.walls:
        names = [result.name for result in cohort.calibrated(wall) if is_lone(result.laws[wall].calibration)]
        if names:
            sentences.append(
                f"Only one start reached the best optimum ({wall} wall): {shortened(names)}. Others may be better: "
                "raise `starts`."
            )
    return sentences
