"""The beats of a recording brought to one diastolic level, and which of them a step or a breath lifts off it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vasowave.recording.baseline import Baseline, find_baseline
from vasowave.recording.rejection import Rejection, mark_inspiration, mark_steps

if TYPE_CHECKING:
    from vasowave.recording.prepared import Prepared


def levelled(prepared: "Prepared", reasons: list[Rejection]) -> Baseline:
    """Return the baseline, and whether it is to be removed; more reasons to reject beats are added to `reasons`."""
    how, cut = prepared.how, prepared.cut
    baseline = _baseline(prepared, reasons)
    here = baseline.time[np.searchsorted(baseline.time, cut.starts)]
    mark_steps(reasons, [int(np.searchsorted(here, step.time)) for step in baseline.steps])
    if how.reject_ventilation:
        pressure, flow = prepared.means
        level = pressure - baseline.mean_within(cut.starts, cut.ends, cut.pressure.shape[1])
        mark_inspiration(reasons, (level, flow), prepared.shapes)
    return replace(baseline, removed=how.drift == "remove" and baseline.sure and not baseline.own)


def _baseline(prepared: "Prepared", reasons: Sequence[Rejection]) -> Baseline:
    """Return the baseline over the whole recording; over the stretch alone where the animal changes beside it."""
    good = ~np.array([bool(reason) for reason in reasons])
    usable = np.ones(len(prepared.own), dtype=bool)
    usable[prepared.own] = good
    whole = find_baseline(prepared.every, prepared.shapes[0], usable, prepared.how.zero_time)
    if not whole.own or prepared.own.all():
        return whole
    here = find_baseline(prepared.cut, prepared.shapes[0], good, prepared.how.zero_time)
    return replace(here, elsewhere=whole.own)
