"""Conditions that a cycle of pressure and flow must satisfy before a number is read from it."""

import numpy as np

from vasowave.base.cures import UNKNOWN, SetCells, SetSetting, ShiftFlowZero, TurnFlow
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, look_kind, note_kind
from vasowave.base.sites import PULMONARY
from vasowave.catheter.check.lags import late_pressure
from vasowave.pulse.cycle.waveform import foot_delay

PERIOD_LIMITS = (0.04, 3.0)
"""Shortest and longest period taken for a heartbeat, s (1500 and 20 beats/min)."""

MEAN_PRESSURES = (4.0, 150.0)
"""Lowest and highest mean pressure taken for one in mmHg. Below lie arterial pressures in kPa."""

RODENT_FLOWS = (0.02, 4.0)
"""Mean flows that are plausible above 240 beats/min, ml/s: mice have 0.1 to 0.3, rats 0.5 to 2."""

_MAX_PULMONARY_MEAN = 75.0  # mmHg; above lie the means of systemic arteries
_REST_CYCLE_SHARE = 0.25
"""The share of a cycle, its flattest, in which the flow of a closed valve rests."""

_MAX_REST_RANGE_SHARE = 0.05
"""A flow that varies by less than this share of its range rests."""

_MAX_REST_HEIGHT_SHARE = 0.25
"""It rests within this share of its range above the lowest flow."""

_MAX_REST_FLOW_SHARE = 0.02
"""A resting flow larger than this share of the mean flow is reported."""
_MIN_STEADY_FLOW_SHARE = 0.5
"""Of the mean: a flow that stays above this much flows all the time, as in a vein or a small artery."""

OPEN_CYCLE = 0.05
"""A jump between end and start larger than this fraction of the range means that the cycle does not close."""


_ZERO_RANGE_SHARE = 0.1
"""A signal that rests within this share of its range around zero rests at zero, as the flow of a closed valve does."""

_MAX_FLOW_LAG_SHARE = 0.025
"""Of the cycle by which a flow may begin after the pressure; in twelve simulated mice and one measured it begins 0.6 %
before to 2 % after it. Before a bed of little proximal resistance a pressure rises up to 3 % after a flow that begins
slowly, so that feet say nothing of a late pressure (`lags` does), and a late flow may go unseen by as much."""

_MIN_LOW_FLOW_SHARE = 0.2
"""A flow that never falls below this share of its largest value is like a pressure."""


_EQUAL_RANGE_SHARE = 1e-6  # of the range: values that differ by less are the same
_EQUAL_BY_CHANCE_ROUNDINGS = 10.0
"""Times their rounding: where samples differ by more, two are the same in less than a tenth of files."""

_MMHG_PER_KPA = 7.50062
_UNIT_REMEDY = "correct the unit, in the file or beside it"


def _unit(signal: str, unit: str) -> SetCells:
    label = f"Name the unit of the {signal}" if unit == UNKNOWN else f"The {signal} is in {unit}"
    return SetCells(label, ((f"{signal} unit", unit),))


SYSTEMIC = look_kind(
    "recording.systemic-pressure",
    "mean pressure {mean:.4g} mmHg is systemic, not pulmonary; is the unit right? ({mean:.4g} mmHg = {kPa:.3g} kPa)",
    "Correct the unit of the pressure, or the channel; of a systemic artery, name that.",
    _unit("pressure", UNKNOWN),
    SetSetting("It is of the aorta", "site", "aorta"),
)
EXCHANGED = look_kind(
    "recording.exchanged",
    "pressure and flow look exchanged: the pressure rests at {level:.2g} mmHg between beats, as a flow does, and the "
    "flow never falls below {lowest:.3g} ml/s",
    "Exchange the two channels, or the titles of the two columns.",
    SetCells("Name the channels", (("pressure channel", UNKNOWN), ("flow channel", UNKNOWN))),
)
BELOW_ZERO = look_kind(
    "recording.pressure-below-zero",
    "the lowest pressure is {lowest:.3g} mmHg; is the zero of the transducer right?",
    "Correct the zero of the pressure.",
    SetCells("Give the zero of the pressure", (("zero [mmHg]", UNKNOWN),)),
)
ODD_FLOW = look_kind(
    "recording.odd-flow",
    "mean flow {mean:.3g} ml/s at {rate:.0f} beats/min; a mouse has about 0.2 ml/s, a rat about 1 ml/s: is the unit of "
    "flow right?",
    "Correct the unit of the flow, or the channel.",
    _unit("flow", UNKNOWN),
    SetCells("Name the channel", (("flow channel", UNKNOWN),)),
)
FLOW_OFF_ZERO = look_kind(
    "recording.flow-off-zero",
    "the flow rests at {level:+.2g} ml/s in diastole, {percent:.0f} % of its mean, though a closed valve lets nothing "
    "through; is the zero of the flow right? From its resting level the mean flow is {mean:.3g} ml/s",
    "If it is not, take the resting level for the zero.",
    ShiftFlowZero("{level:.6g}"),
)
LATE_FLOW = look_kind(
    "recording.late-flow",
    "the upstroke of the flow begins {delay:.3g} ms after that of the pressure, {percent:.2g} % of the cycle; at one "
    "place none does, and stiffness, wave speed and impedance depend strongly on it",
    "Find out the delay of flow probe and filters and give it; what you do not know of it is a known error. The feet "
    "tell it within a few percent of the cycle.",
    SetCells("Give the delay", (("flow delay [s]", UNKNOWN),)),
    SetSetting("Allow for a delay", "flow_delay_sd"),
)
OPEN_END = note_kind("recording.cycle-open", "{what} ends {percent:.1f} % of its range away from its start")


def check_period(period: float, where: str) -> None:
    """Raise `InputError` unless `period` (s) can be a heartbeat's."""
    shortest, longest = PERIOD_LIMITS
    if not np.isfinite(period) or period <= 0:
        raise InputError(f"{where}: period {period:g} s is not a positive number")
    if not shortest <= period <= longest:
        hint = (
            "is it in ms, or a continuous recording ('raw' in the column 'kind' of a study, with pressure and flow in "
            "one table)?"
            if period > longest
            else "is the unit of time right, and is it one whole cycle?"
        )
        raise InputError(
            f"{where}: period {period:g} s is {60 / period:.3g} beats/min, which no heart has; {hint} "
            f"One cycle of {shortest:g} to {longest:g} s is needed"
        )


def check_pressure(pressure: np.ndarray, where: str) -> None:
    """Raise `InputError` if the mean of `pressure` (mmHg) is of another unit, or if it does not pulsate."""
    mean = float(pressure.mean())
    lowest, highest = MEAN_PRESSURES
    if np.ptp(pressure) <= 1e-9 * max(1.0, abs(mean)):
        raise InputError(f"{where}: the pressure is constant ({mean:g} mmHg); is this the right column?")
    if mean <= 0:
        raise InputError(f"{where}: mean pressure {mean:.3g} mmHg is not positive; correct the zero of the transducer")
    if mean < lowest and (_rests_at_zero(pressure) or mean * _MMHG_PER_KPA < lowest):
        raise InputError(
            f"{where}: mean pressure {mean:.3g} mmHg is too low for an artery; is the unit right, are pressure and "
            "flow exchanged, or is it another channel?"
        )
    if mean < lowest:
        raise InputError(
            f"{where}: mean pressure {mean:.3g} mmHg looks like kPa "
            f"({mean:.3g} kPa = {mean * _MMHG_PER_KPA:.3g} mmHg); {_UNIT_REMEDY}",
            [_unit("pressure", "kPa")],
        )
    if mean > highest:
        shown = {"mmHg": mean / _MMHG_PER_KPA, "Pa": mean * _MMHG_PER_KPA / 1000}  # where kPa, or mmHg, were stated
        plausible = {unit: value for unit, value in shown.items() if lowest <= value <= highest}
        would_be = " or ".join(f"in {unit} their mean is {value:.3g} mmHg" for unit, value in plausible.items())
        raise InputError(
            f"{where}: mean pressure {mean:.4g} mmHg is too high for an artery; the numbers look like another unit "
            f"than the one stated{f' ({would_be})' if would_be else ''}; {_UNIT_REMEDY}",
            [*(_unit("pressure", unit) for unit in plausible), _unit("pressure", UNKNOWN)],
        )


def check_flow(flow: np.ndarray, where: str) -> None:
    """Raise `InputError` if `flow` (ml/s) runs backward or does not pulsate."""
    mean = float(flow.mean())
    turn = "flow out of the heart is positive: turn its sign, as of a probe mounted backward"
    if np.ptp(flow) == 0:
        raise InputError(f"{where}: the flow is constant ({mean:g} ml/s); is this the right column?")
    if mean <= 0:
        level = resting_flow(flow)
        shift = [ShiftFlowZero(f"{level:.6g}")] if abs(level) > _MAX_REST_FLOW_SHARE * float(np.ptp(flow)) else []
        raise InputError(f"{where}: mean flow {mean:.3g} ml/s; {turn}, or correct its zero", [TurnFlow(), *shift])
    if -flow.min() > flow.max():
        raise InputError(
            f"{where}: the largest flow is backward ({flow.min():.3g} against {flow.max():.3g} ml/s); {turn}",
            [TurnFlow()],
        )


def odd_values(pressure: np.ndarray, flow: np.ndarray, period: float, site: str = PULMONARY) -> list[Finding]:
    """Return a finding for every value that is possible at an artery, yet more likely a slip."""
    if _rests_at_zero(pressure) and flow.min() > _MIN_LOW_FLOW_SHARE * flow.max():
        return [EXCHANGED(level=resting_flow(pressure), lowest=float(flow.min()))]
    findings = []
    if pressure.mean() > _MAX_PULMONARY_MEAN and site == PULMONARY:
        findings.append(SYSTEMIC(mean=float(pressure.mean()), kPa=float(pressure.mean() / _MMHG_PER_KPA)))
    if pressure.min() < 0:
        findings.append(BELOW_ZERO(lowest=float(pressure.min())))
    slowest, fastest = RODENT_FLOWS
    if period < 0.25 and site == PULMONARY and not slowest <= flow.mean() <= fastest:
        findings.append(ODD_FLOW(mean=float(flow.mean()), rate=60 / period))
    level, mean = resting_flow(flow), float(flow.mean())
    limit = np.inf if site == PULMONARY else _MIN_STEADY_FLOW_SHARE  # no blood flows all the time through its valve
    if _MAX_REST_FLOW_SHARE * mean < abs(level) < limit * mean:
        findings.append(FLOW_OFF_ZERO(level=level, percent=100 * level / mean, mean=mean - level))
    return [*findings, *odd_timing(pressure, flow, period)]


def odd_timing(pressure: np.ndarray, flow: np.ndarray, period: float) -> list[Finding]:
    """Return a finding if one signal of a cycle of a period, s, is late against the other."""
    delay = foot_delay(pressure, flow, period)
    late = [LATE_FLOW(delay=1e3 * delay, percent=100 * delay / period)] if delay > _MAX_FLOW_LAG_SHARE * period else []
    return [*late, *late_pressure(pressure, flow, period)]


def resting_flow(flow: np.ndarray) -> float:
    """Return the level, ml/s, at which the flow of a cycle rests, 0 if it never does: its narrowest quarter."""
    return _resting(flow) or 0.0


def _rests_at_zero(values: np.ndarray) -> bool:
    level = _resting(values)
    return level is not None and abs(level) < _ZERO_RANGE_SHARE * float(np.ptp(values))


def _resting(values: np.ndarray) -> float | None:
    """Return the level at which a signal rests, None if it never does."""
    ordered = np.sort(values)
    count, span = max(2, round(_REST_CYCLE_SHARE * len(ordered))), np.ptp(values)
    widths = ordered[count - 1 :] - ordered[: len(ordered) - count + 1]
    first = int(np.argmin(widths))
    rests = widths[first] < _MAX_REST_RANGE_SHARE * span and ordered[first] - ordered[0] < _MAX_REST_HEIGHT_SHARE * span
    return float(ordered[first : first + count].mean()) if rests else None


def repeats_first(values: np.ndarray) -> bool:
    """Whether the last sample is the first one again (to a millionth of the range)."""
    return bool(abs(values[-1] - values[0]) <= _EQUAL_RANGE_SHARE * np.ptp(values))


def moves_at_ends(values: np.ndarray) -> bool:
    """Whether a signal moves before its last sample and after its first by more than what it is rounded to.

    If it does, its last sample is the first one again by no chance.
    """
    span = float(np.ptp(values))
    steps = np.diff(np.unique(values))
    rounding = float(steps[steps > _EQUAL_RANGE_SHARE * span].min(initial=span))
    return bool(min(abs(values[1] - values[0]), abs(values[-1] - values[-2])) > _EQUAL_BY_CHANCE_ROUNDINGS * rounding)


def check_closure(values: np.ndarray, name: str, where: str) -> list[Finding]:
    """Raise `InputError` if a cycle (first sample not repeated) does not close; return a finding if it barely does.

    The step from the last sample to the first may be as large as the largest step inside the cycle, and 5 % of the
    range more.
    """
    span = float(np.ptp(values))
    jump = abs(float(values[0] - values[-1]))
    excess = (jump - float(np.abs(np.diff(values)).max())) / span
    if excess > OPEN_CYCLE:
        raise InputError(
            f"{where}: the cycle of {name} does not close: it ends at {values[-1]:.4g} and starts at {values[0]:.4g} "
            f"({100 * jump / span:.0f} % of its range); cut exactly one cycle, or correct the period"
        )
    if excess > 0.01:
        return [OPEN_END(what=name, percent=100 * jump / span)]
    return []
