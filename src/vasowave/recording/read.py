"""Read one averaged cycle of pressure and flow from the files a lab has."""

from dataclasses import replace
from pathlib import Path

from vasowave.errors import InputError
from vasowave.findings import Finding, note_kind, warn
from vasowave.recording.cycle import FEWEST_SAMPLES, Recording
from vasowave.recording.formats import read_signals
from vasowave.recording.plausibility import (
    check_closure,
    check_flow,
    check_period,
    check_pressure,
    odd_values,
    repeats_first,
)
from vasowave.recording.signal import Signal, even_step

_CHECKS = {"pressure": check_pressure, "flow": check_flow}


REPEATED = note_kind("recording.repeated-sample", "the last sample of {quantity} repeats the first and was left out")
ASSUMED_UNIT = note_kind("recording.assumed-unit", "{quantity} is assumed to be in {unit}; {name} names no unit")


def read_recording(
    *paths: str | Path,
    period: float | None = None,
    pressure_unit: str | None = None,
    flow_unit: str | None = None,
    wedge_pressure: float = 0.0,
) -> Recording:
    """Read one averaged cycle from one table, or from one file of pressure and one of flow.

    Parameters
    ----------
    *paths : path
        One CSV, TSV, blank-separated or ``.mat`` file with the columns (variables) ``time [s]``, ``pressure [mmHg]``,
        ``flow [ml/s]`` (or t, p, q) in any unit that the header names; or two files, the first with pressure, the
        second with flow, each of one column (headerless or titled) with or without a time column. The two may be
        sampled at different rates. A last sample that repeats the first is recognized and dropped.
    period : float, optional
        Period T, s. Needed where there is no time column; where there is one it must agree.
    pressure_unit, flow_unit : str, optional
        Unit of columns whose header has none. A headerless column or a ``.mat`` variable without either is taken to be
        in mmHg or ml/s, and the recording's notes say so.
    wedge_pressure : float
        Pressure behind the vascular beds, mmHg, see `Recording`.

    Raises
    ------
    InputError
        File, line and column of: a gap, uneven sampling, too few samples, a missing column, a missing or wrong unit;
        also a period that is missing or contradicts the times, a mean pressure that looks like kPa, flow of the wrong
        sign, a cycle that does not close, a ``.mat`` file that cannot be read.

    Warns
    -----
    VasowaveWarning
        If a value is possible, yet more likely a slip (for example 10 ml/s in an animal of 500 beats/min).

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
    if len(paths) == 1:
        signals = read_signals(paths[0], {"pressure": pressure_unit, "flow": flow_unit})
    else:
        signals = read_signals(paths[0], {"pressure": pressure_unit}) + read_signals(paths[1], {"flow": flow_unit})
    recording = _assemble(signals, period, together=len(paths) == 1)
    return replace(recording, wedge_pressure=wedge_pressure)


def _assemble(signals: list[Signal], period: float | None, together: bool) -> Recording:
    """Check both signals and make the recording; `together` says that they come from one table."""
    for signal in signals:
        if len(signal.values) < FEWEST_SAMPLES:
            raise InputError(
                f"{signal.places[-1]}: the file ends after {len(signal.values)} samples of {signal.quantity}; "
                f"at least {FEWEST_SAMPLES} a cycle are needed"
            )
        _check_units(signal, swapped_files=not together)
    if period is not None:
        check_period(period, "period")
    repeated = _last_repeats_first(signals, period)
    periods = [_period(signal, drop, period) for signal, drop in zip(signals, repeated)]
    if abs(periods[0] - periods[1]) > 0.01 * min(periods):
        raise InputError(
            f"{signals[0].file} lasts {periods[0]:.5g} s and {signals[1].file} {periods[1]:.5g} s; "
            "pressure and flow must be of one cycle"
        )
    notes: list[Finding] = []
    cycles = []
    for signal, drop in zip(signals, repeated):
        notes += signal.notes
        values = signal.values[:-1] if drop else signal.values
        notes += check_closure(values, signal.quantity, signal.file)
        if drop:
            notes.append(REPEATED(quantity=signal.quantity))
        if signal.assumed_unit:
            name = Path(signal.file).name
            notes.append(ASSUMED_UNIT(quantity=signal.quantity, unit=signal.assumed_unit, name=name))
        cycles.append(values)
    odd = odd_values(cycles[0], cycles[1], periods[0])
    for one in odd:
        warn(one.at(signals[0].file), stacklevel=3)
    source = " and ".join(dict.fromkeys(Path(signal.file).name for signal in signals))
    return Recording(cycles[0], cycles[1], periods[0], source, (*notes, *odd))


def _check_units(signal: Signal, swapped_files: bool) -> None:
    try:
        _CHECKS[signal.quantity](signal.values, signal.file)
    except InputError as error:
        hint = "; of two files the first must hold pressure, the second flow" if swapped_files else ""
        raise InputError(f"{error}{hint}") from None


def _last_repeats_first(signals: list[Signal], period: float | None) -> list[bool]:
    """Return for each signal whether its last sample belongs to the next cycle.

    A flow that rests at zero may end where it began by chance, so signals of equal length decide together; and where
    both times and period are given, these decide.
    """
    same = []
    for signal in signals:
        repeats = repeats_first(signal.values)
        if signal.time is not None and period is not None:
            lasts = signal.time[-1] - signal.time[0]
            step = lasts / (len(signal.time) - 1)
            repeats = abs(lasts - period) < abs(lasts + step - period)
        same.append(repeats)
    if len(signals[0].values) == len(signals[1].values):
        same = [all(same)] * 2
    return same


def _period(signal: Signal, drop: bool, period: float | None) -> float:
    """Return the period from the times, checked against the one given."""
    if signal.time is None:
        if period is None:
            raise InputError(
                f"{signal.file}: no time column; give the period in seconds "
                "(--period 0.11 on the command line, the column 'period [s]' in a study's table, period=0.11 in Python)"
            )
        return period
    step = even_step(signal.time, signal.quantum, signal.file, signal.places.__getitem__)
    measured = step * (len(signal.time) - drop)
    if period is None:
        check_period(measured, f"{signal.file}, time column")
        return measured
    if abs(measured - period) > 0.5 * step + signal.quantum:
        raise InputError(
            f"{signal.file}: the time column covers {measured:.6g} s, the period given is {period:.6g} s; "
            "correct one of them"
        )
    return period
