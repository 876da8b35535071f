"""The beats of a continuous recording and a few seconds of it, as labelled data."""

from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr

from vasowave.animal.datasets import recording_dataset
from vasowave.animal.labelled import labelled
from vasowave.findings import Finding
from vasowave.recording import Beat, EnsembleAverage, RawRecording, Recording, resample
from vasowave.recording.rejection import cause

EXCERPT = 6.0
"""Length of the stretch of raw signals that is kept for a figure, s."""


def beats_dataset(average: EnsembleAverage, raw: RawRecording | None) -> xr.Dataset:
    """Return onset, length, level and fate of every beat, and an excerpt of the signals around the averaged ones."""
    beats, baseline = average.beats, average.baseline
    here = np.searchsorted(baseline.time, [beat.start for beat in beats])  # others are beside what is read
    variables = {
        "onset": labelled("beat", [beat.start for beat in beats], "s", "start of the beat"),
        "length": labelled("beat", [beat.end - beat.start for beat in beats], "s", "length of the beat"),
        "kept": labelled(
            "beat", np.array([beat.averaged for beat in beats], dtype=np.int8), "1", "part of the average"
        ),
        "reason": _why(beats, str, "why it was rejected"),
        "cause": _why(beats, cause, "the same in one word"),
        "level": labelled("beat", baseline.level[here], "mmHg", "diastolic level of the beat"),
        "drift": labelled("beat", baseline.trend[here], "mmHg", "drift of the level since the zero of the transducer"),
        "delay": labelled((), average.delay, "s", "flow behind pressure (p-q delay)"),
    }
    done = {
        "fiducial": average.fiducial,
        "delay_corrected": int(average.delay_corrected),
        "drift_size": baseline.size,
        "drift_error": baseline.error,
        "drift_removed": int(baseline.removed),
    }
    dataset = xr.Dataset(variables, attrs=done)
    return dataset if raw is None else dataset.merge(_excerpt(average, raw))


def recording_with_scatter(recording: Recording, average: EnsembleAverage | None) -> xr.Dataset:
    """Return the recording, with the standard deviation of the averaged beats where there are any."""
    dataset = recording_dataset(recording)
    if average is None:
        return dataset
    for name, dim, unit in (("pressure", "time", "mmHg"), ("flow", "flow_time", "ml/s")):
        words = f"standard deviation of the {name} of the averaged beats"
        deviation = resample(getattr(average, f"{name}_sd"), dataset.sizes[dim])  # the paper's practice has others
        dataset[f"{name}_sd"] = labelled(dim, np.maximum(deviation, 0.0), unit, words)
    return dataset


def _excerpt(average: EnsembleAverage, raw: RawRecording) -> xr.Dataset:
    """Return the signals from the first averaged beat on, or as near as the recording's end allows."""
    used = [beat for beat in average.beats if beat.averaged]
    count = min(len(raw.pressure), round(EXCERPT * raw.sampling_rate))
    middle = (0.5 * (used[0].start + used[-1].end) - raw.origin) * raw.sampling_rate
    first = int(np.clip(middle - count / 2, 0, len(raw.pressure) - count))
    part = slice(first, first + count)
    traces = {
        "trace_pressure": labelled("trace_time", raw.pressure[part], "mmHg", "pressure as recorded"),
        "trace_flow": labelled("trace_time", raw.flow[part], "ml/s", "flow as recorded"),
    }
    if raw.ecg is not None:
        traces["trace_ecg"] = labelled("trace_time", raw.ecg[part], "mV", "ECG as recorded")
    return xr.Dataset(traces, coords={"trace_time": labelled("trace_time", raw.time[part], "s", "time")})


def _why(beats: Sequence[Beat], text: Callable[[Finding], str], meaning: str) -> xr.Variable:
    words = [text(beat.rejected) if beat.rejected else "" for beat in beats]
    return xr.Variable("beat", np.array(words, dtype=object), {"long_name": meaning})
