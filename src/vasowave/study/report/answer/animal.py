"""The answers of one animal's recording and model: numbers with their intervals, one sentence for each question."""

from collections.abc import Mapping, Sequence
from itertools import zip_longest

import numpy as np
import xarray as xr

from vasowave.pulse.analysis.ventricle_coupling import UNLIKE
from vasowave.pulse.quantities import COUPLING, INDICES, MEASURED, question_of
from vasowave.study.animal.result import AnimalResult
from vasowave.study.cohort.primary import Family
from vasowave.study.report.answer.effects import Called
from vasowave.study.report.answer.marks import Marks
from vasowave.study.report.wording import listed, number, value_text, with_interval

_OF_LOOPS = ("loops_E_es", "loops_E_a", "loops_coupling", "loops_PRSW", "loops_EF", "loops_tau_weiss")
_BESIDE = ("R_T",)  # is no question of its own to groups, whose PVR is measured; a mouse's small vessels have both


def animal_answers(
    result: AnimalResult, law: str, family: Family, called: Called, marks: Marks | None = None
) -> list[tuple[str, str]]:
    """Return question and answer: what was measured, then what the wall law says, with marks behind its numbers."""
    answers = [("Pressure and flow", _measured(result)), *_coupled(result, called), *_by_loops(result, called)]
    by_question: dict[str, list[str]] = {}
    for name in family.quantities if law else ():
        if name not in MEASURED:
            by_question.setdefault(question_of(name), []).append(name)
    quantities = result.laws[law].answers if law else {}
    for question, names in by_question.items():
        companions = _BESIDE if question == question_of(*_BESIDE) else ()
        present = [name for name in dict.fromkeys((*companions, *names)) if name in quantities]
        if present:
            soft = _softness(quantities["stiffness"]) if "stiffness" in present else ""
            text = _listed(
                present, quantities, called, [marks.of_quantity(name, [result]) if marks else "" for name in present]
            )
            answers.append((question, f"{text} ({result.laws[law].origin}).{soft}"))
    return answers


def _listed(
    names: Sequence[str], quantities: Mapping[str, xr.DataArray], called: Called, marks: Sequence[str] = ()
) -> str:
    pairs = zip_longest(names, marks, fillvalue="")
    text = listed([f"{called(name)} {value_text(quantities[name])}{mark}" for name, mark in pairs])
    return f"{text[0].upper()}{text[1:]}"


def _softness(beta: xr.DataArray) -> str:
    """Say what the stiffness means: of any law β(0) is pressure over relative growth of the radius near zero."""
    low, high = (100 / float(beta.attrs.get(f"interval_{end}", np.nan)) for end in ("high", "low"))
    share = number(100 / float(beta), 2) if np.isnan(low + high) else with_interval(100 / float(beta), low, high)
    return f" So a large artery grows by {share} % in radius with the first mmHg."


def _coupled(result: AnimalResult, called: Called) -> list[tuple[str, str]]:
    """Return what the pressure in the ventricle tells, where it was recorded."""
    data: Mapping[str, xr.DataArray] = result.measured.quantities.data_vars  # type: ignore[assignment]
    if not all(name in data for name in COUPLING):
        return []
    ratio = data["coupling"]
    low, high = (float(ratio.attrs.get(f"interval_{end}", np.nan)) for end in ("low", "high"))
    judged = "By this beat the ventricle is stiffer than its load" if low > 1 else "By this beat its load is stiffer"
    judged = judged if low > 1 or high < 1 else "Whether it keeps up with its load is open"
    if any(finding.code == UNLIKE.code for finding in result.findings):
        judged = "No usual heart makes this pressure from this flow, so these numbers may be far off"
    return [(question_of("coupling"), f"{_listed(COUPLING, data, called)}. {judged}.")]


def _by_loops(result: AnimalResult, called: Called) -> list[tuple[str, str]]:
    """Return what loops of pressure and volume tell of the ventricle, where they were recorded."""
    data: Mapping[str, xr.DataArray] = result.measured.quantities.data_vars  # type: ignore[assignment]
    present = [name for name in _OF_LOOPS if name in data]
    return [(question_of(present[0]), f"{_listed(present, data, called)}.")] if present else []


def _measured(result: AnimalResult) -> str:
    data = result.measured.quantities
    text = {name: value_text(data[name]) for name in INDICES}
    counted_from = "0 mmHg, for no wedge pressure is given"
    if "wedge_pressure" in result.recording:
        counted_from = f"a wedge pressure of {number(float(result.recording['wedge_pressure']), 2)} mmHg"
    return (
        f"Mean pressure {text['mPAP']} (systolic {text['sPAP']}, diastolic {text['dPAP']}) at {text['CO']} and "
        f"{text['HR']}: vascular resistance PVR {text['PVR']}, counted from {counted_from}."
    )
