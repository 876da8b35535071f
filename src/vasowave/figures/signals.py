"""A recording as it was made, its averaged cycle, the beats that were averaged: what `plot` of these values draws."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vasowave.figures.beats import thinned
from vasowave.figures.network import plot_network
from vasowave.figures.style import DATA, closed, closed_time, label_axes, shown_figure
from vasowave.network.network import Network
from vasowave.recording import EnsembleAverage, RawRecording, Recording

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PAIRS = 1500  # of lowest and highest value, with which a trace is drawn
_LABELS = {"pressure": "pressure [mmHg]", "flow": "flow [ml/s]", "ecg": "ECG [mV]"}


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
        label_axes(ax, "", _LABELS[name])
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
        label_axes(ax, "", _LABELS[name])
    return _timed(panels, start, end)


def _panels(axes: "Sequence[Axes] | None", count: int) -> "np.ndarray":
    if axes is not None:
        return np.asarray(axes, dtype=object)
    return np.atleast_1d(shown_figure(12.0, 4.2 * count).subplots(count, sharex=True))


def _timed(panels: "np.ndarray", start: float, end: float) -> "np.ndarray":
    panels[-1].set_xlim(start, end)
    panels[-1].set_xlabel("time [s]")
    return panels
