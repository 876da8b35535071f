"""Read one averaged cycle of pressure and flow from the files a lab has."""

import math
from collections.abc import Sequence
from dataclasses import replace
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.cures import UNKNOWN, SetCells
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, Severity, look_kind, note_kind, warn
from vasowave.base.settings import Positive, given_values, settings_class
from vasowave.base.sites import PULMONARY, SiteName
from vasowave.catheter.check.plausibility import (
    check_closure,
    check_flow,
    check_period,
    check_pressure,
    moves_at_ends,
    odd_values,
    repeats_first,
)
from vasowave.catheter.read.formats import check_sheet, check_subject, read_signals
from vasowave.catheter.read.gated import MAX_PHASES, MIN_PHASES, place_error
from vasowave.catheter.read.several_beats import beats_within, many_beats, mean_beat, several_finding
from vasowave.catheter.read.subject_rows import period_of_subject
from vasowave.catheter.read.velocity import flow_of_velocity
from vasowave.catheter.signals.raw import AS_READ, SensorCalibration
from vasowave.catheter.signals.signal import NAME_THE_RATE, RATE, Signal, even_step
from vasowave.pulse.cycle.cycle import MIN_SAMPLES, Recording, resample

_MAX_GATED_DIFFERENCE = 0.1  # of the period, between signals that were measured one after the other
_CHECKS = {"pressure": check_pressure, "flow": check_flow}


REPEATED = note_kind(
    "recording.last-sample-repeated",
    "the last sample of {quantity} repeats the first and was left out: {count} samples in {period:.6g} s",
)
IN_DOUBT = look_kind(
    "recording.last-sample-in-doubt",
    "the last sample of {quantity} equals the first where nothing moves, so that the times do not tell whether this "
    "sample is the next cycle's first. It was kept: the period is {period:.6g} s. Without it the period would be "
    "{other:.6g} s, {percent:.2g} % ({less:.2g} s) less; {remedy}",
    "say the period",
    SetCells("Period {period:.6g} s", (("period [s]", "{period:.6g}"),)),
    SetCells("Period {other:.6g} s", (("period [s]", "{other:.6g}"),)),
)
IN_DOUBT_UNTIMED = look_kind(
    "recording.last-sample-untimed",
    "the last sample of {quantity} equals the first where nothing moves, so that nothing tells whether this sample is "
    "the next cycle's first. It was kept: {count} samples in {period:.6g} s. Without it they would be {percent:.2g} % "
    "further apart; {remedy}",
    "give a column of times beside the period, or remove the sample",
)
FEW_PHASES = note_kind(
    "recording.few-phases",
    "the cycle of {quantity} has {count} samples, which carry {harmonics} harmonics; between them it was interpolated",
)
PERIODS_DIFFER = look_kind(
    "recording.periods-differ",
    "pressure and flow were measured apart: the pressure's cycle lasts {pressure:.4g} s, that of the flow {flow:.4g} s "
    "({percent:.2g} % apart). The flow was put onto the cycle of the pressure, and its mean kept",
    "Give signals of one heart rate, if there are any.",
)
ASSUMED_UNIT = note_kind("recording.assumed-unit", "{quantity} is assumed to be in {unit}; {name} names no unit")


@settings_class
class CycleForm:
    """What files of some forms are asked for; see `read_recording`."""

    site: SiteName = PULMONARY
    """The artery; its titles and pressures are then looked for."""
    sheet: str = ""
    """Of a workbook; by default the first that holds pressure and flow."""
    flow_diameter: Positive | None = None
    """Diameter of the vessel, mm, where a velocity was recorded in place of the flow."""
    subject_row: str = ""
    """Of a table with a row a subject: whose cycle to read."""


def read_recording(
    *paths: str | Path,
    period: float | None = None,
    pressure_unit: str | None = None,
    flow_unit: str | None = None,
    wedge_pressure: float = 0.0,
    calibration: SensorCalibration = AS_READ,
    **form: Any,
) -> Recording:
    """Read one averaged cycle from one table, or from one file of pressure and one of flow.

    Parameters
    ----------
    *paths : path
        One CSV, TSV, blank-separated or ``.mat`` file with the columns (variables) ``time [s]``, ``pressure [mmHg]``,
        ``flow [ml/s]`` (or t, p, q) in any unit that the header names; or two files, the first with pressure, the
        second with flow, each of one column (headerless or titled) with or without a time column. The two may be
        sampled at different rates. A last sample that repeats the first is dropped; where the signals
        rest there it may be one by chance and is kept, with a warning, unless times and period tell.
    period : float, optional
        Period T, s. Needed where there is no time column; where there is one it must agree.
    pressure_unit, flow_unit : str, optional
        Unit of columns whose header has none. A headerless column or a ``.mat`` variable without either is taken to be
        in mmHg or ml/s, and the recording's notes say so.
    wedge_pressure : float
        Pressure behind the vascular beds, mmHg, see `Recording`.
    calibration : SensorCalibration
        Zeros and gains of the instruments.
    **form
        ``site``, the artery, whose titles and pressures are then looked for; ``sheet`` of a workbook, by default the
        first that holds pressure and flow; ``flow_diameter`` of the vessel, mm, where a velocity was recorded in place
        of the flow; ``subject_row``, a name in the row whose numbered samples (``p_0``, ``p_1`` … ``q_0`` …) are read,
        with the period by its ``heart rate`` or ``period [s]``, where none is given.

    Raises
    ------
    InputError
        File, line and column of: a gap, uneven sampling, too few samples, a missing column, a missing or wrong unit;
        also a period that is missing or contradicts the times, a mean pressure that looks like kPa, flow of the wrong
        sign, a cycle that does not close, a ``.mat`` file that cannot be read.

    Warns
    -----
    VasowaveWarning
        If a value is possible, yet more likely a slip (for example 10 ml/s in an animal of 500 beats/min); if nothing
        tells whether the last sample is the next cycle's first.

    Examples
    --------
    >>> import vasowave as vw
    >>> from pathlib import Path
    >>> mouse = vw.virtual_mouse()
    >>> rows = (f"{t:.6f},{p:.6f},{q:.6f}" for t, p, q in zip(mouse.time, mouse.pressure, mouse.flow))
    >>> _ = Path("cycle.csv").write_text("\\n".join(["time [s],pressure [mmHg],flow [ml/s]", *rows, ""]))
    >>> vw.read_recording("cycle.csv")
    Recording(mPAP ... mmHg, CO 0.180 ml/s, HR 533/min, 512 pressure and 512 flow samples, cycle.csv)
    """
    if len(paths) not in (1, 2):
        raise InputError(f"{len(paths)} files given; a recording is one table, or one file of pressure and one of flow")
    asked = given_values(CycleForm, None, form)
    site, sheet, flow_diameter, subject = asked.site, asked.sheet, asked.flow_diameter, asked.subject_row
    check_sheet(paths, sheet)
    check_subject(paths, subject)
    if subject and period is None:
        period = next(filter(None, (period_of_subject(Path(path), subject, sheet) for path in paths)), None)
    second = "velocity" if flow_diameter is not None else "flow"
    if len(paths) == 1:
        signals = read_signals(paths[0], {"pressure": pressure_unit, second: flow_unit}, site, sheet, subject)
    else:
        signals = [
            *read_signals(paths[0], {"pressure": pressure_unit}, site, sheet, subject),
            *read_signals(paths[1], {second: flow_unit}, site, sheet, subject),
        ]
    signals = [_as_flow(signal, flow_diameter) for signal in signals]
    calibration = SensorCalibration(*calibration)
    signals = [replace(signal, values=calibration.corrected(signal.quantity, signal.values)) for signal in signals]
    recording = _assemble(signals, period, len(paths) == 1, site)
    notes = (*recording.notes, *calibration.notes())
    return replace(recording, wedge_pressure=wedge_pressure, notes=notes)


def _as_flow(signal: Signal, diameter: float | None) -> Signal:
    if signal.quantity != "velocity" or diameter is None:
        return signal
    flow, made = flow_of_velocity(signal.values, diameter)
    return replace(signal, quantity="flow", values=flow, notes=(*signal.notes, made))


class _Last(Enum):
    """What the last sample of a signal is."""

    OWN = "a sample of its own"
    NEXT = "the first one of the next cycle"
    UNTOLD = "one or the other"


def _assemble(signals: list[Signal], period: float | None, together: bool, site: SiteName) -> Recording:
    """Check both signals and make the recording; `together` says that they come from one table."""
    for signal in signals:
        _check(signal, swapped_files=not together)
    if period is not None:
        check_period(period, "period")
    lasts = _last_samples(signals, period)
    cycles = [signal.values[:-1] if last is _Last.NEXT else signal.values for signal, last in zip(signals, lasts)]
    periods = [_period(signal, len(cycle), period) for signal, cycle in zip(signals, cycles)]
    periods, delay_sd, gated = _one_period(signals, cycles, periods, together)
    remarks = [*gated, *_said_of_last(signals, lasts, periods)]
    cycles, cycle_period, several = _one_beat(signals, cycles, periods)
    notes = [note for signal, cycle in zip(signals, cycles) for note in _notes_of(signal, cycle)]
    for i, (signal, cycle) in enumerate(zip(signals, cycles)):
        if len(cycle) < MIN_SAMPLES:
            cycles[i] = resample(cycle, len(cycle) * -(-MIN_SAMPLES // len(cycle)))
            notes.append(FEW_PHASES(quantity=signal.quantity, count=len(cycle), harmonics=(len(cycle) - 1) // 2))
    odd = [*remarks, *several, *odd_values(cycles[0], cycles[1], cycle_period, site)]
    for finding in odd:
        if finding.severity is Severity.LOOK:
            warn(finding.at(signals[0].file), stacklevel=3)
    source = " and ".join(dict.fromkeys(Path(signal.file).name for signal in signals))
    return Recording(cycles[0], cycles[1], cycle_period, source, (*notes, *odd), site=site, flow_delay_sd=delay_sd)


def _one_period(
    signals: Sequence[Signal], cycles: Sequence[np.ndarray], periods: list[float], together: bool
) -> tuple[list[float], float, list[Finding]]:
    """Return periods of two signals, that of the pressure for a flow which was gated apart, the SD of its place, s."""
    differ, phases = abs(periods[0] - periods[1]) / min(periods), min(map(len, cycles))
    if differ <= 0.01:
        return periods, 0.0, []
    if together or differ > _MAX_GATED_DIFFERENCE or phases >= MAX_PHASES:
        raise InputError(
            f"{signals[0].file} lasts {periods[0]:.5g} s and {signals[1].file} {periods[1]:.5g} s; "
            "pressure and flow must be of one cycle"
        )
    difference = PERIODS_DIFFER(pressure=periods[0], flow=periods[1], percent=100 * differ)
    return [periods[0]] * 2, periods[0] * place_error(phases), [difference]


def _one_beat(
    signals: Sequence[Signal], cycles: list[np.ndarray], periods: Sequence[float]
) -> tuple[list[np.ndarray], float, list[Finding]]:
    """Return one beat of each signal and its period, s: the mean of several where times tell how long each lasts."""
    untimed = all(signal.time is None for signal in signals)  # whose period may be that of one or of all
    if untimed and (count := many_beats(cycles[0], cycles[1])):
        raise InputError(
            f"{signals[0].file}: its {len(cycles[0])} samples hold about {count} beats, not one cycle of "
            f"{periods[0]:g} s: it is a continuous recording; leave the period out and {NAME_THE_RATE}",
            [RATE],
        )
    beats = beats_within(cycles[0], cycles[1], math.inf if untimed else periods[0])
    if beats <= 1:
        return cycles, periods[0], []
    if untimed:
        raise InputError(
            f"{signals[0].file}: the table holds {beats} beats, and nothing tells whether the period of "
            f"{periods[0]:g} s is that of one or of all; cut exactly one cycle, or add a column of time"
        )
    averaged, period = [mean_beat(cycle, beats) for cycle in cycles], periods[0] / beats
    several = several_finding(beats, period, max(unlike for _, unlike in averaged))
    return [mean for mean, _ in averaged], period, [several]


def _notes_of(signal: Signal, cycle: np.ndarray) -> list[Finding]:
    """Return what was noted of a signal when it was read, of the ends of its cycle, and of a unit that is assumed."""
    notes = [*signal.notes, *check_closure(cycle, signal.quantity, signal.file)]
    if signal.assumed_unit:
        name = Path(signal.file).name
        notes.append(ASSUMED_UNIT(quantity=signal.quantity, unit=signal.assumed_unit, name=name))
    return notes


def _check(signal: Signal, swapped_files: bool) -> None:
    """Refuse a signal of too few samples, or that can be neither in its unit nor of its kind."""
    if len(signal.values) < MIN_PHASES:
        raise InputError(
            f"{signal.places[-1]}: the file ends after {len(signal.values)} samples of {signal.quantity}; "
            f"at least {MIN_PHASES} a cycle are needed"
        )
    try:
        _CHECKS[signal.quantity](signal.values, signal.file)
    except InputError as error:
        hint = "; of two files the first must hold pressure, the second flow" if swapped_files else ""
        raise InputError(f"{error}{hint}", error.cures) from None


def _last_samples(signals: Sequence[Signal], period: float | None) -> list[_Last]:
    """Return what the last sample of each signal is.

    A flow that rests may end where it began by chance, so signals of equal length decide together, and one that rests
    is as the other, which the same program wrote. Where both times and period are given, these decide.
    """
    kinds = [_last_sample(signal, period) for signal in signals]
    surest = next(kind for kind in (_Last.OWN, _Last.NEXT, _Last.UNTOLD) if kind in kinds)
    alike = len(signals[0].values) == len(signals[1].values)
    return [surest if alike or kind is _Last.UNTOLD else kind for kind in kinds]


def _last_sample(signal: Signal, period: float | None) -> _Last:
    if signal.time is not None and period is not None:
        lasts = signal.time[-1] - signal.time[0]
        step = lasts / (len(signal.time) - 1)
        return _Last.NEXT if abs(lasts - period) < abs(lasts + step - period) else _Last.OWN
    if not repeats_first(signal.values):
        return _Last.OWN
    return _Last.NEXT if moves_at_ends(signal.values) else _Last.UNTOLD


def _said_of_last(signals: Sequence[Signal], lasts: Sequence[_Last], periods: Sequence[float]) -> list[Finding]:
    """Return what was done with last samples that are the first again, once where both signals have as many."""
    findings = []
    alike = len(signals[0].values) == len(signals[1].values)
    for signal, last, period in list(zip(signals, lasts, periods))[: 1 if alike else None]:
        quantity = "pressure and flow" if alike else signal.quantity
        count = len(signal.values)
        if last is _Last.NEXT:
            findings.append(REPEATED(quantity=quantity, count=count - 1, period=period))
        elif last is _Last.UNTOLD and signal.time is None:
            findings.append(IN_DOUBT_UNTIMED(quantity=quantity, count=count, period=period, percent=100 / (count - 1)))
        elif last is _Last.UNTOLD:
            step = period / count
            findings.append(
                IN_DOUBT(quantity=quantity, period=period, other=period - step, percent=100 / count, less=step)
            )
    return findings


def _period(signal: Signal, count: int, period: float | None) -> float:
    """Return the period of a cycle of so many samples from the times, checked against the one given."""
    if signal.time is None:
        if period is None:
            raise InputError(
                f"{signal.file}: no time column; give its period in s, or of a continuous one {NAME_THE_RATE}",
                [SetCells("Give the period", (("period [s]", UNKNOWN),)), RATE],
            )
        return period
    step = even_step(signal.time, signal.quantum, signal.file, signal.places.__getitem__)
    measured = step * count
    if period is None:
        check_period(measured, f"{signal.file}, time column")
        return measured
    if abs(measured - period) > 0.5 * step + signal.quantum:
        raise InputError(
            f"{signal.file}: the time column covers {measured:.6g} s, the period given is {period:.6g} s; "
            "correct one of them"
        )
    return period
