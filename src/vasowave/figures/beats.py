"""What was detected in a continuous recording, what of it was kept, and the average with its scatter."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.errors import InputError
from vasowave.recording import EnsembleAverage, RawRecording

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LABELS = {"pressure": "pressure (mmHg)", "flow": "flow (ml/s)", "ecg": "ECG (mV)"}
_KEPT, _REJECTED = "#0072b2", "#d55e00"


def plot_detected_beats(
    ax: "Axes", raw: RawRecording, average: EnsembleAverage, signal: str = "pressure", margin: float = 0.5
) -> "Axes":
    """Draw a signal around the averaged beats, a mark at every detected beat, and what became of the beats.

    Averaged beats are shaded, rejected ones hatched, so the two differ in grey too.

    Parameters
    ----------
    ax : matplotlib Axes
    raw : RawRecording
    average : EnsembleAverage
    signal : {"pressure", "flow", "ecg"}
    margin : float
        Time shown before the first and after the last averaged beat, s.

    Raises
    ------
    InputError
        An unknown signal, or an ECG that was not recorded.
    """
    values = getattr(raw, signal) if signal in _LABELS else None
    if values is None:
        raise InputError(f"{raw.source}: no signal '{signal}' to draw; there are pressure, flow, and ecg if recorded")
    used = [beat for beat in average.beats if beat.averaged]
    start, end = used[0].start - margin, used[-1].end + margin
    shown = [beat for beat in average.beats if beat.end >= start and beat.start <= end]
    labels = {"averaged", "rejected"}
    for beat in shown:
        kind = "averaged" if beat.averaged else "rejected" if beat.rejected else ""
        if kind:
            look: dict[str, Any] = {"color": _KEPT, "alpha": 0.18}
            if beat.rejected:
                look = {"color": _REJECTED, "alpha": 0.25, "hatch": "///"}
            ax.axvspan(beat.start, beat.end, lw=0, label=kind if kind in labels else None, **look)
            labels.discard(kind)
    inside = (raw.time >= start) & (raw.time <= end)
    ax.plot(raw.time[inside], values[inside], color="black", lw=0.8)
    starts = np.array([beat.start for beat in shown])
    ax.plot(starts, np.interp(starts, raw.time, values), "v", color="black", ms=4, ls="none", label="detected")
    ax.set(xlabel="time (s)", ylabel=_LABELS[signal], xlim=(max(start, 0.0), min(end, raw.duration)))
    ax.legend(loc="upper left", bbox_to_anchor=(0.0, 1.18), ncols=3, frameon=False, fontsize="small")
    return ax


def plot_ensemble(ax: "Axes", average: EnsembleAverage, signal: str = "pressure") -> "Axes":
    """Draw the averaged cycle of pressure or flow with a band of one standard deviation of the beats.

    Raises
    ------
    InputError
        A signal that is neither pressure nor flow.
    """
    if signal not in ("pressure", "flow"):
        raise InputError(f"signal '{signal}' is neither 'pressure' nor 'flow'")
    mean, deviation = getattr(average.recording, signal), getattr(average, f"{signal}_sd")
    time = 1e3 * average.recording.time
    count = sum(beat.averaged for beat in average.beats)
    ax.fill_between(time, mean - deviation, mean + deviation, color="0.6", lw=0, label="± 1 SD of the beats")
    ax.plot(time, mean, color="black", lw=0.9, label=f"mean of {count} beats")
    ax.set(xlabel="time (ms)", ylabel=_LABELS[signal], xlim=(0.0, 1e3 * average.recording.period))
    ax.legend(frameon=False, fontsize="small")
    return ax
