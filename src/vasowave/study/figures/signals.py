"""A recording as it was made, its averaged cycle, and the beats that were detected, kept and averaged."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vasowave.base.errors import InputError
from vasowave.catheter.signals.raw import RawRecording
from vasowave.pulse.cycle.averaged import EnsembleAverage
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.network.network import Network
from vasowave.study.animal.result import AnimalResult
from vasowave.study.figures.matplotlib_style import DATA, LABELS, closed, closed_time, label_axes, shown_figure
from vasowave.study.figures.network import plot_network

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

_KEPT, _REJECTED = "#0072b2", "#d55e00"
_SHADES: dict[str, dict[str, Any]] = {
    "averaged": {"facecolor": _KEPT, "alpha": 0.18},
    "rejected": {"facecolor": _REJECTED, "alpha": 0.25, "hatch": "///"},
}
_DRAWN, _PAIRS = 800, 1500  # pairs of lowest and highest value that a trace is drawn with: of an excerpt, of a whole


def plot_detected_beats(ax: "Axes", beats: "xr.Dataset", signal: str = "pressure") -> "Axes":
    """Draw a few seconds of a signal, a mark at every detected beat, and what became of the beats.

    Averaged beats are shaded, rejected ones hatched, so the two differ in grey too.

    Parameters
    ----------
    ax : matplotlib Axes
    beats : Dataset
        ``onset, length, kept, reason`` by beat, and an excerpt ``trace_time, trace_pressure`` and so on.
    signal : {"pressure", "flow", "ecg"}

    Raises
    ------
    InputError
        An unknown signal, or one that was not recorded.
    """
    if signal not in LABELS or f"trace_{signal}" not in beats.data_vars:
        raise InputError(f"no signal '{signal}' to draw; there are pressure, flow, and ecg if recorded")
    time, values = beats["trace_time"].values, beats[f"trace_{signal}"].values
    onset, end = beats["onset"].values, beats["onset"].values + beats["length"].values
    inside = (end >= time[0]) & (onset <= time[-1])
    averaged = beats["kept"].values == 1
    for kind, those in (("averaged", averaged), ("rejected", ~averaged & (beats["reason"].values != ""))):
        spans = np.column_stack([onset, end - onset])[inside & those]
        if len(spans):
            across = ax.get_xaxis_transform()  # from bottom to top, whatever the limits
            ax.broken_barh(spans, (0.0, 1.0), lw=0, label=kind, transform=across, **_SHADES[kind])
    ax.plot(*thinned(time, values, _DRAWN), color=DATA, lw=0.6)
    starts = onset[inside & (onset >= time[0])]
    ax.plot(starts, np.interp(starts, time, values), "v", color=DATA, ms=3, ls="none", label="detected")
    ax.set_xlim(time[0], time[-1])
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.0)
    return label_axes(ax, "time [s]", LABELS[signal])


def plot_baseline(ax: "Axes", beats: "xr.Dataset") -> "Axes":
    """Draw the diastolic level of every beat over the whole recording, its drift, and the drift's size.

    Parameters
    ----------
    ax : matplotlib Axes
    beats : Dataset
        ``onset, length, kept, level, drift`` by beat; attributes ``drift_size``, ``drift_error`` (mmHg) and
        ``drift_removed``.

    Raises
    ------
    InputError
        If the levels are not known: the cycle came averaged, or its results are of an older version.
    """
    if not {"level", "drift"} <= set(beats.data_vars):
        raise InputError("the diastolic levels of the beats are not known; average the beats again")
    middle = beats["onset"].values + 0.5 * beats["length"].values
    level, drift, averaged = beats["level"].values, beats["drift"].values, beats["kept"].values == 1
    ax.plot(middle[~averaged], level[~averaged], ".", color="0.6", ms=2, label="diastolic level")
    ax.plot(middle[averaged], level[averaged], ".", color=_KEPT, ms=4, label="averaged")
    size, error = beats.attrs["drift_size"], beats.attrs["drift_error"]
    done = "removed" if beats.attrs["drift_removed"] else "left in"
    # The drift is relative to its zero; breaths and scatter set aside, it runs through the levels' middle.
    line = drift + float(np.median(level - drift))
    ax.plot(middle, line, color=_REJECTED, lw=1.2, label=f"drift {size:+.1f} ± {error:.1g} mmHg, {done}")
    ax.set_xlim(0.0, float(middle[-1]))
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.0)
    return label_axes(ax, "time [s]", "diastolic level [mmHg]")


def plot_ensemble(ax: "Axes", result: AnimalResult, signal: str = "pressure") -> "Axes":
    """Draw the averaged cycle of pressure or flow with a band of one standard deviation of the beats.

    Raises
    ------
    InputError
        A signal that is neither pressure nor flow, or an animal whose cycle was not averaged here.
    """
    if signal not in ("pressure", "flow"):
        raise InputError(f"signal '{signal}' is neither 'pressure' nor 'flow'")
    recording = result.recording
    if f"{signal}_sd" not in recording.data_vars or result.beats is None:
        raise InputError("the cycle came averaged; the scatter of its beats is not known")
    mean, deviation = recording[signal].values, recording[f"{signal}_sd"].values
    time = recording["time" if signal == "pressure" else "flow_time"].values
    count = int(result.beats["kept"].sum())
    ax.fill_between(time, mean - deviation, mean + deviation, color="0.6", lw=0)
    ax.plot(time, mean, color=DATA, lw=0.9, label=f"mean of {count} beats ± SD")
    ax.set_xlim(0.0, recording.attrs["period"])
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.0)
    return label_axes(ax, "time [s]", LABELS[signal])


def thinned(time: np.ndarray, values: np.ndarray, pairs: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest sample of each of `pairs` stretches, in order; no spike is lost."""
    if len(values) <= 2 * pairs:
        return time, values
    indices: list[int] = []
    for rows in np.array_split(np.arange(len(values)), pairs):
        indices += sorted({int(rows[np.argmin(values[rows])]), int(rows[np.argmax(values[rows])])})
    return time[indices], values[indices]


def draw_network(network: Network, ax: "Axes | None" = None) -> "Axes":
    """Draw the tree from the root at the left, see `plot_network`; returns the axes."""
    return plot_network(ax or shown_figure(17.4, 10.0).subplots(), network)


def draw_cycle(recording: Recording, axes: "Sequence[Axes] | None" = None) -> "np.ndarray":
    """Draw pressure and flow over one cycle, one below the other; returns the two axes."""
    panels = _panels(axes, 2)
    for ax, name in zip(panels, ("pressure", "flow"), strict=True):
        values = getattr(recording, name)
        time = np.arange(len(values)) * (recording.period / len(values))
        ax.plot(closed_time(time, recording.period), closed(values), color=DATA)
        label_axes(ax, "", LABELS[name])
    return _timed(panels, 0.0, recording.period)


def draw_average(average: EnsembleAverage, axes: "Sequence[Axes] | None" = None) -> "np.ndarray":
    """Draw the averaged cycle with a band of one standard deviation of the beats; returns the two axes."""
    panels = draw_cycle(average.recording, axes)
    for ax, name in zip(panels, ("pressure", "flow"), strict=True):
        values, deviation = getattr(average.recording, name), getattr(average, f"{name}_sd")
        time = np.arange(len(values)) * (average.recording.period / len(values))
        ax.fill_between(time, values - deviation, values + deviation, color="0.75", lw=0, label="SD of the beats")
    panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
    return panels


def draw_raw(raw: RawRecording, stretch: slice = slice(None), axes: "Sequence[Axes] | None" = None) -> "np.ndarray":
    """Draw all signals between two times (s), ``slice(10, 12)``; returns one axes a signal."""
    names = ["pressure", "flow", *(["ecg"] if raw.ecg is not None else [])]
    start, end = stretch.start or 0.0, raw.duration if stretch.stop is None else stretch.stop
    first, last = (int(np.clip(round(t * raw.sampling_rate), 0, len(raw.pressure))) for t in (start, end))
    panels = _panels(axes, len(names))
    for ax, name in zip(panels, names, strict=True):
        ax.plot(*thinned(raw.time[first:last], getattr(raw, name)[first:last], _PAIRS), color=DATA, lw=0.7)
        label_axes(ax, "", LABELS[name])
    return _timed(panels, start, end)


def _panels(axes: "Sequence[Axes] | None", count: int) -> "np.ndarray":
    if axes is not None:
        return np.asarray(axes, dtype=object)
    return np.atleast_1d(shown_figure(12.0, 4.2 * count).subplots(count, sharex=True))


def _timed(panels: "np.ndarray", start: float, end: float) -> "np.ndarray":
    panels[-1].set_xlim(start, end)
    panels[-1].set_xlabel("time [s]")
    return panels
