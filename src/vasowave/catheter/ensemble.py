"""From the beats of a continuous recording to one averaged cycle, with the scatter of the beats around it.

Beats that a step or a breath lifts off the diastolic level of the others can be brought back to it.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vasowave.base.findings import Finding, Severity, note_kind, warn
from vasowave.base.settings import given_values
from vasowave.catheter.baseline.baseline import baseline_findings, find_baseline, with_comments
from vasowave.catheter.baseline.ventilation import Expiration, mark_inspiration
from vasowave.catheter.beats.cuts import Cuts
from vasowave.catheter.beats.edits import BeatEdit, judged, require_decisions, told
from vasowave.catheter.beats.prepared import Averaging, Prepared, prepare
from vasowave.catheter.beats.rejection import (
    cause,
    choose_run,
    lost_in_run,
    mark_settling,
    mark_steps,
    relax_criteria,
    relaxation_findings,
    summarize,
    unusual_beats,
)
from vasowave.catheter.beats.steadiness import unsteady
from vasowave.catheter.check.lags import clocks_apart
from vasowave.catheter.check.plausibility import check_flow, check_pressure, odd_values, resting_flow
from vasowave.catheter.signals.plateaus import plateau_findings, saturated
from vasowave.catheter.signals.raw import RawRecording
from vasowave.pulse.cycle.averaged import Beat, EnsembleAverage, Rejection
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.cycle.trend import Baseline
from vasowave.pulse.cycle.waveform import advance, close_cycle, foot_delay, harmonic_error, low_pass

ADVANCED = note_kind("recording.flow-advanced", "the flow was advanced by the estimated p-q delay of {delay:.2f} ms")
LOW_PASSED = note_kind("recording.low-passed", "harmonics above {harmonics} of the cycle were left out")
CLOSED = note_kind(
    "recording.closed", "{name}: a step of {percent:.2g} % of its range from end to start was spread over the cycle"
)


_MAX_OFF_BEAT_SHARE = 0.2  # share of long and short beats below which most are usual


def average_beats(
    raw: RawRecording, beats: int | None = None, averaging: Averaging | None = None, *, edits: Sequence[BeatEdit] = (),
    **settings: Any,
) -> EnsembleAverage:  # fmt: skip
    """Average consecutive beats of pressure and flow to one cycle, with the ECG as fiducial.

    Each beat, from one fiducial to the next, is brought to `samples` samples and thereby to the mean length. The drift
    of the diastolic level is followed over the whole recording, across gaps and beside the stretch that is read. Of all
    runs of beats that hold `beats` good ones, the run with the fewest rejected beats is averaged, the first of equals;
    over breaths (`reject_ventilation=False`), that of equals whose means are nearest to those of all good beats.
    The mean step from the cycle's end to its start is then spread over the cycle as a straight line of mean zero.

    Parameters
    ----------
    raw : RawRecording
    beats : int, optional
        Number of beats to average, 20 unless `averaging` says otherwise.
    averaging : Averaging, optional
        How beats are found, rejected and averaged.
    edits : sequence of BeatEdit
        What a person decided of single beats; it counts more than any rule.
    settings
        Those of `Averaging` by name, ``drift="warn"``, in place of what `averaging` says of them.

    Raises
    ------
    InputError
        An argument out of range; a recording with fewer than `beats` beats; a pressure or flow of impossible size.
    NumericalError
        No beats found, or fewer than `beats` good ones: the reasons are counted.

    Warns
    -----
    VasowaveWarning
        If the baseline moved by 0.3 mmHg or more, more than half of the beats in the averaged run were rejected, the
        ECG does not beat, or a value looks like a slip.

    Examples
    --------
    >>> import vasowave as vw
    >>> import numpy as np
    >>> from vasowave.catheter.synthetic import synthetic_raw_recording
    >>> raw = synthetic_raw_recording(vw.virtual_mouse(), np.random.default_rng(1), duration=6.0).raw
    >>> vw.average_beats(raw, 10).recording
    Recording(mPAP ... mmHg, CO ... ml/s, HR 53... ...)
    """
    options = given_values(Averaging, averaging, settings | ({} if beats is None else {"beats": beats}))
    require_decisions(edits)
    average = average_prepared(prepare(raw, options, edits), edits)
    for finding in average.findings[len(raw.notes) :]:
        if finding.severity is Severity.LOOK:
            warn(finding.at(raw.source))
    return average


def average_prepared(prepared: Prepared, edits: Sequence[BeatEdit] = ()) -> EnsembleAverage:
    """Return the average of beats that are cut already, after `edits`, without warnings; raises as `average_beats`."""
    prepared = prepared.with_moves(edits)
    raw, options, cut, heartbeats = prepared.raw, prepared.options, prepared.cut, prepared.heartbeats
    reasons, _ = judged(
        list(prepared.reasons), cut.starts, cut.ends, [edit for edit in edits if edit.action == "reject"]
    )
    shaped = np.array([not reason for reason in reasons])
    baseline, expiration = levelled(prepared, reasons)
    reasons, lost = judged(reasons, cut.starts, cut.ends, edits)
    of_length = np.array([reason is not None and cause(reason) == "length" for reason in reasons])
    clocks = clocks_apart(cut, ~of_length, heartbeats.fiducial == "ecg")
    good = reasons.count(None)
    reasons, over = relax_criteria(reasons, options.beats)
    good_beats = np.array([reason is None for reason in reasons])
    levels = np.stack(_levels(prepared, baseline)) if over or expiration.rests == "neither" else None
    used, run = choose_run(reasons, len(reasons) if "length" in over else options.beats, raw.source, clocks, levels)
    if over:
        baseline = replace(baseline, removed=baseline.removed and len(over) == 1)  # unlike beats share no level
        expiration = Expiration(error=float(cut.pressure[used].mean(axis=1).std()) * (len(over) == 1))
    chosen = _without_drift(cut.chosen(used), baseline)
    period = float(np.mean(chosen.ends - chosen.starts))
    lasts = chosen.ends - chosen.starts if "length" in over else None
    carried = int(prepared.raw.sampling_rate * period / 2)
    harmonics = None if options.harmonics is None else min(options.harmonics, carried)
    cycles, notes = _mean_cycles({"pressure": chosen.pressure, "flow": chosen.flow}, harmonics, lasts)
    check_pressure(cycles[0], raw.source)
    check_flow(cycles[1], raw.source)
    delay = foot_delay(cycles[0], cycles[1], period)
    deviations = [values[:, :-1].std(axis=0, ddof=1) for values in (chosen.pressure, chosen.flow)]
    if options.correct_delay:
        cycles[1], deviations[1] = (advance(values, delay / period) for values in (cycles[1], deviations[1]))
        lengths = chosen.ends - chosen.starts
        shifted = np.array([advance(close_cycle(beat)[0], delay / length)
                            for beat, length in zip(chosen.flow, lengths, strict=True)])  # fmt: skip
        chosen = chosen._replace(flow=np.column_stack([shifted, shifted[:, 0]]))
        notes.append(ADVANCED(delay=1e3 * delay))
    first, last = float(chosen.starts[0]), float(chosen.ends[-1])
    means = (float(cycles[0].mean()), float(cycles[1].mean()))
    unusual, moves = unusual_beats(reasons, cut.ends - cut.starts, prepared.means)
    findings = [
        *raw.notes, *summarize(heartbeats.fiducial, reasons, len(used), options.beats, first, last), *told(edits),
        *prepared.lost,
        *lost, *notes, *heartbeats.notes,
        *plateau_findings(prepared.plateaus, *_beating(baseline, cut.starts, reasons)),
        *baseline_findings(baseline, first, last, raw.every_comment),
        *unsteady(cut.chosen(shaped), np.isin(np.flatnonzero(shaped), used), good_beats[shaped], first, last),
        *saturated(raw, prepared.plateaus, period), *expiration.findings, *expiration.compared(*means), *prepared.signs,
        *odd_values(cycles[0], cycles[1], period, raw.site), *lost_in_run(reasons, run, len(used)),
        *clocks, *unusual, *relaxation_findings(over, good, len(used), expiration.error),
    ]  # fmt: skip
    errors = [harmonic_error(values[:, :-1]) for values in (chosen.pressure, chosen.flow)]
    mean_errors = (baseline.error_left(first, last), expiration.error, moves[0])
    errors[0][0] = np.linalg.norm([errors[0][0] * baseline.persistence, *mean_errors])
    errors[1][0] = np.linalg.norm([errors[1][0], resting_flow(cycles[1]), moves[1]])  # either level may be the zero
    return EnsembleAverage(
        Recording(cycles[0], cycles[1], period, raw.source, tuple(findings), errors[0], errors[1], site=raw.site,
                  flow_delay_sd=raw.flow_delay_sd),
        deviations[0],
        np.maximum(deviations[1], 0.0),
        _listed(cut.starts, cut.ends, set(used.tolist()), reasons),
        heartbeats.fiducial,
        delay,
        options.correct_delay,
        baseline,
        chosen.pressure,
        chosen.flow,
    )  # fmt: skip


def _without_drift(chosen: Cuts, baseline: Baseline) -> Cuts:
    """Return beats without the drift of their level, if it is to be removed."""
    if not baseline.removed:
        return chosen
    within = np.linspace(0, 1, chosen.pressure.shape[1])
    times = chosen.starts[:, None] + np.outer(chosen.ends - chosen.starts, within)
    return chosen._replace(pressure=chosen.pressure - baseline.drift_at(times))


def _mean_cycles(
    cuts: dict[str, np.ndarray], harmonics: int | None, lasts: np.ndarray | None = None
) -> tuple[list[np.ndarray], list[Finding]]:
    """Return the mean cycle of each signal, closed and smoothed, and what was done; beats weigh as they last, s."""
    cycles, notes = [], [] if harmonics is None else [LOW_PASSED(harmonics=harmonics)]
    for name, cut in cuts.items():
        cycle, step = close_cycle(np.average(cut, axis=0, weights=lasts))
        cycles.append(cycle if harmonics is None else low_pass(cycle, harmonics))
        notes.append(CLOSED(name=name, percent=100 * step))
    return cycles, notes


def _beating(baseline: Baseline, starts: np.ndarray, reasons: list[Rejection]) -> tuple[float, float]:
    """Return when the first and the last good beat are, those beside the stretch included, s."""
    good = starts[[not reason for reason in reasons]]
    outside = baseline.time[(baseline.time < starts[0]) | (baseline.time > starts[-1] + np.ptp(starts[:2]))]
    times = np.append(good, outside)
    return float(times.min()), float(times.max())


def _listed(starts: np.ndarray, ends: np.ndarray, used: set[int], reasons: list[Rejection]) -> tuple[Beat, ...]:
    beats = zip(starts.tolist(), ends.tolist(), reasons, strict=True)
    return tuple(Beat(start, end, i in used, reason) for i, (start, end, reason) in enumerate(beats))


def levelled(prepared: Prepared, reasons: list[Rejection]) -> tuple[Baseline, Expiration]:
    """Return the baseline, whether it is to be removed, and end-expiration; adds to `reasons` to reject beats."""
    options, cut = prepared.options, prepared.cut
    baseline = with_comments(_baseline(prepared, reasons), prepared.raw.every_comment)
    times = baseline.time[np.searchsorted(baseline.time, cut.starts)]
    mark_steps(reasons, [int(np.searchsorted(times, step.time)) for step in baseline.steps])
    if baseline.settling:
        mark_settling(reasons, np.flatnonzero(times < baseline.settling.until))
    levels, sample = _levels(prepared, baseline), 1.0 / prepared.raw.sampling_rate
    marked = reasons if options.reject_ventilation else [*reasons]
    expiration = mark_inspiration(marked, cut.starts, cut.ends, levels, prepared.shapes, sample)
    if not options.reject_ventilation:
        expiration = Expiration("neither" if expiration.rests else "")
    return replace(baseline, removed=options.drift == "remove" and baseline.sure and not baseline.own), expiration


def _levels(prepared: Prepared, baseline: Baseline) -> tuple[np.ndarray, np.ndarray]:
    """Return mean pressure, its drift removed, and mean flow of every beat, mmHg and ml/s."""
    (pressure, flow), cut = prepared.means, prepared.cut
    return pressure - baseline.mean_within(cut.starts, cut.ends, cut.pressure.shape[1]), flow


def _baseline(prepared: Prepared, reasons: Sequence[Rejection]) -> Baseline:
    """Return the baseline over the whole recording; over the stretch alone where the animal changes beside it."""
    good = ~np.array([bool(reason) for reason in reasons])
    off_beat = np.array([reason is not None and cause(reason) == "length" for reason in reasons])
    if off_beat.mean() < _MAX_OFF_BEAT_SHARE:  # the two beats after a long or a short one begin from another pressure
        good &= ~(np.append(False, off_beat[:-1]) | np.append([False, False], off_beat[:-2]))
    usable = np.ones(len(prepared.in_cut), dtype=bool)
    usable[prepared.in_cut] = good
    baseline = find_baseline(prepared.all_cuts, prepared.shapes[0], usable, prepared.options.zero_time)
    if not baseline.own or prepared.in_cut.all():
        return baseline
    stretch_baseline = find_baseline(prepared.cut, prepared.shapes[0], good, prepared.options.zero_time)
    return replace(stretch_baseline, elsewhere=baseline.own)
