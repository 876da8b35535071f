"""What the Recording desk shows: signals at the width of a screen, beats and their fate, the average."""

import itertools
import threading
import warnings
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base.errors import InputError, VasowaveError, VasowaveWarning
from vasowave.base.sites import SiteName
from vasowave.catheter.beats.edits import BeatEdit, read_edits
from vasowave.catheter.beats.prepared import Prepared, prepare
from vasowave.catheter.beats.rejection import cause
from vasowave.catheter.ensemble import average_prepared
from vasowave.catheter.read.describe import describe_recording, kind_of
from vasowave.catheter.read.formats import companion_files, read_blocks
from vasowave.catheter.read.read_raw import INTERPOLATED, choose_block
from vasowave.catheter.signals.channels import Block, Comment
from vasowave.catheter.signals.interventions import is_intervention
from vasowave.catheter.signals.raw import MIN_DURATION_S, RawRecording
from vasowave.pulse.cycle.averaged import EnsembleAverage
from vasowave.pulse.cycle.cycle import Recording
from vasowave.study.entering.sorting import used_block
from vasowave.study.entering.table import read_rows
from vasowave.study.folder.animals import read_half_row
from vasowave.study.folder.names import plain_name
from vasowave.study.folder.problems import refuse
from vasowave.study.folder.rows import COLUMNS, AnimalRow
from vasowave.study.folder.settings import averaging_settings
from vasowave.study.folder.study import Study
from vasowave.study.results.loading import read_measured, read_stretch
from vasowave.study.running.plan import inspect_study
from vasowave.workbench.cures import as_shown, buttons
from vasowave.workbench.desk import EDITS, Desk
from vasowave.workbench.values import INDEX_UNITS, number, numbers

SIGNALS = {"pressure": "pressure [mmHg]", "flow": "flow [ml/s]", "ecg": "ECG"}
"""Signals that a recording may have, with what stands beside their curves."""

_INDICES = ("HR", "mPAP", "sPAP", "dPAP", "pPAP", "CO", "PVR")
_CAPACITY, _MOST = 3, 9_000_000  # recordings in memory, and their samples in all, save for the one that is looked at
_FIRST_COUNT, _LEVEL_FACTOR = 32, 4  # samples in a pair of the finest level, and pairs of one level in one of the next
_MAX_PIXELS = 4000  # pixels


class Trace:
    """One signal from the start of its block, as lowest and highest values of ever more samples."""

    def __init__(self, values: np.ndarray, rate: float) -> None:
        self.values, self.rate = values, rate
        self.levels: list[tuple[int, np.ndarray]] = []
        count, low, high = _FIRST_COUNT, values, values
        step = _FIRST_COUNT
        while len(low) > step:
            first = np.arange(0, len(low), step)
            low, high = np.fmin.reduceat(low, first), np.fmax.reduceat(high, first)
            self.levels.append((count, np.stack([low, high])))
            count, step = count * _LEVEL_FACTOR, _LEVEL_FACTOR

    def between(self, start: float, end: float, width: int) -> np.ndarray:
        """Return lowest and highest value in each of `width` equal parts of `start` to `end` (s), shape (2, width).

        NaN where there are no samples.
        """
        edges = np.linspace(start, end, width + 1) * self.rate
        size, pairs = 1, self.values[None]
        for count, level in self.levels:
            if count * 2 <= (edges[-1] - edges[0]) / width:
                size, pairs = count, level
        pair_count = pairs.shape[1]
        first = np.clip(np.floor(edges[:-1] / size).astype(np.int64), 0, pair_count)
        last = np.clip(np.maximum(np.ceil(edges[1:] / size).astype(np.int64), first + 1), 0, pair_count)
        extremes = np.full((2, width), np.nan, dtype=np.float32)
        columns = np.flatnonzero((last > first) & (edges[1:] > 0))
        if len(columns):
            begin = first[columns[0]]
            bounds = np.stack([first[columns], last[columns]], axis=1).ravel() - begin
            window = np.pad(pairs[:, begin : last[columns[-1]]], ((0, 0), (0, 1)), constant_values=np.nan)
            extremes[0, columns] = np.fmin.reduceat(window[0], bounds)[::2]
            extremes[1, columns] = np.fmax.reduceat(window[-1], bounds)[::2]
        return extremes


class LoadedRecording:
    """A continuous recording in memory: signals, what the file says of its channels, and the beats averaged last.

    Parameters
    ----------
    traces : dict of Trace
    rate : float
        Samples a second.
    duration : float
        s.
    recording : RawRecording or None
        The recording, where it has no gap, no intervention and one rate, so that any stretch of it is at hand.
    channels : dict
        See `_channels`.
    comments : sequence of Comment, optional
        Remarks made during the recording.
    refusal : VasowaveError, optional
        Why nothing can be averaged; the traces are those of the file's channels then, by their titles.
    of_stretch : bool
        Whether another stretch of the row may show more.
    """

    def __init__(
        self, traces: dict[str, Trace], rate: float, duration: float, recording: RawRecording | None,
        channels: dict[str, Any], comments: Sequence[Comment] = (), refusal: VasowaveError | None = None,
        of_stretch: bool = False,
    ) -> None:  # fmt: skip
        self.traces, self.rate, self.duration, self.whole, self.channels = traces, rate, duration, recording, channels
        self.comments, self.refusal, self.of_stretch = comments, refusal, of_stretch or refusal is not None
        self.prepared: tuple[Any, Prepared] | None = None

    def beats(self, row: AnimalRow, study: Study, edits: Sequence[BeatEdit]) -> Prepared:
        """Return the beats of the stretch of a row, cut anew only if the stretch or the settings changed."""
        settings = averaging_settings(study.settings)
        key = (row.start, row.end, row.calibration, settings)
        if self.prepared is None or self.prepared[0] != key:
            self.prepared = None  # room for the next
            self.prepared = key, prepare(self._stretch(row, study.settings.site), settings)
        self.prepared = key, self.prepared[1].with_moves(edits)
        return self.prepared[1]

    def _stretch(self, row: AnimalRow, site: SiteName) -> RawRecording:
        """Return what `read_stretch` does, without the file if it can be."""
        if self.whole is not None and row.start is None and row.end is None:
            return self.whole.calibrated(*row.calibration)
        if self.whole is None or row.start is None or row.end is None:
            return read_stretch(row, site)
        try:
            stretch = self.whole.between(row.start, row.end)
        except InputError:  # said by the reader in its own words
            return read_stretch(row, site)
        neighbors = tuple(piece for piece in stretch.beside if piece.duration > MIN_DURATION_S + 1.5 / self.rate)
        return replace(stretch, notes=self.whole.notes, beside=neighbors).calibrated(*row.calibration)


class Recordings:
    """Recordings of a study that were looked at last."""

    def __init__(self) -> None:
        self._opened: OrderedDict[Any, LoadedRecording] = OrderedDict()
        self._lock, self._averaging = threading.Lock(), threading.Lock()

    def trace(self, desk: Desk, animal: str, signal: str, start: float, end: float, width: int) -> np.ndarray:
        """Return a part of one signal, see `Trace.between`."""
        if not (0 < width <= _MAX_PIXELS and np.isfinite([start, end]).all() and start < end):
            raise InputError("a stretch begins before it ends, and a screen has 1 to 4000 pixels")
        row, study = row_of(desk, animal)
        traces = self.opened(row, study).traces
        if signal not in traces:
            raise InputError(f"'{signal}' is no signal of this recording; it has: {', '.join(traces)}")
        zero, gain, flow_gain, flow_zero = row.calibration
        above, factor = {"pressure": (zero, gain), "flow": (flow_zero, flow_gain)}.get(signal, (0.0, 1.0))
        return (traces[signal].between(start, end, width) - above) * factor

    def opened(self, row: AnimalRow, study: Study) -> LoadedRecording:
        """Return a recording from the start of its block as it was read, gaps and all, whatever is averaged of it."""
        states = [file.stat() for recording in row.recordings
                  for file in (recording, *filter(Path.is_file, companion_files(recording)))]  # fmt: skip
        ignored = ("start", "end", "zero", "pressure_gain", "flow_gain", "flow_zero", "beat_edits", "group", "network",
                   "line")  # fmt: skip
        key = (*((state.st_mtime_ns, state.st_size) for state in states), study.settings.site,
               tuple(str(value) for name, value in vars(row).items() if name not in ignored))  # fmt: skip
        of_stretch = (*key, row.start, row.end)  # a refusal, or what lies between gaps, is of one stretch
        with self._lock:
            stored = next((candidate for candidate in (key, of_stretch) if candidate in self._opened), None)
            if stored is None:
                opened = _opened_or_channels(row, study.settings.site)
                stored = of_stretch if opened.of_stretch else key
                self._opened[stored] = opened
                while len(self._opened) > _CAPACITY or (len(self._opened) > 1 and self._samples() > _MOST):
                    self._opened.popitem(last=False)
            self._opened.move_to_end(stored)
            return self._opened[stored]

    def _samples(self) -> int:
        longest = (max(len(trace.values) for trace in opened.traces.values()) for opened in self._opened.values())
        counts = (max(1, len(opened.traces) // len(SIGNALS)) for opened in self._opened.values())
        return sum(length * count for length, count in zip(longest, counts, strict=True))

    def _average(self, row: AnimalRow, study: Study, cells: Mapping[str, str]) -> dict[str, Any]:
        """Return beats and average, or why there is none; the same numbers as `vasowave check` and `run`."""
        edits, opened = read_edits(row.beat_edits) if row.beat_edits else (), self.opened(row, study)
        with warnings.catch_warnings(), self._averaging:
            warnings.simplefilter("ignore", VasowaveWarning)  # they stand among the findings
            prepared = opened.beats(row, study, edits)
            average = average_prepared(prepared, edits)
        raw = prepared.raw
        return {"beats": _beats(average), "fiducial": average.fiducial, "origin": raw.origin,
                "from": raw.origin, "to": raw.origin + raw.duration,
                "baseline": {"removed": average.baseline.removed, "size": number(average.baseline.size)},
                "sd": {"pressure": numbers(average.pressure_sd), "flow": numbers(average.flow_sd)},
                **_cycle(average.recording, [row.animal], cells)}  # fmt: skip

    def described(self, desk: Desk, animal: str) -> dict[str, Any]:
        """Return all that the desk shows of an animal beside its signals."""
        row, study = row_of(desk, animal)
        cells = next(table_row for table_row in read_rows(desk.table).rows if table_row["animal"] == animal)
        description: dict[str, Any] = {
            "animal": animal,
            "cells": {title: cells.get(title, "") for title in COLUMNS},
            "drift": study.settings.averaging.drift,
            "labels": SIGNALS,
            "units": {name: INDEX_UNITS[name] for name in _INDICES},
            "kind": row.kind or kind_of(row.recordings, row.sheet),
            "edits": [list(edit) for edit in read_edits(row.beat_edits)] if row.beat_edits else [],
        }
        try:
            if description["kind"] == "raw":
                opened = self.opened(row, study)
                description |= opened.channels | {
                    "error": "",
                    "duration": opened.duration,
                    "rate": opened.rate,
                    "signals": list(opened.traces),
                    "labels": {name: SIGNALS.get(name, name) for name in opened.traces},
                    "comments": [[comment.time, comment.text] for comment in opened.comments],
                }
                if opened.refusal is not None:
                    raise opened.refusal
                description |= self._average(row, study, cells)
            else:
                description |= {"error": "", **_cycle(read_measured(row, study.settings)[0], [animal], cells)}
        except VasowaveError as error:
            description |= {"error": str(error), "remedies": buttons(error.cures, [animal], cells)}
            description |= {} if "channels" in description else _channels_if_any(row)
        return description


def row_of(desk: Desk, animal: str) -> tuple[AnimalRow, Study]:
    """Return the row of an animal, whose network and group may still be empty, and the study.

    Raises
    ------
    InputError
        The study file is wrong, there is no such animal, or its row is wrong.
    """
    study, problems = inspect_study(desk.folder)
    if study is None:
        refuse(problems)
        raise InputError(f"{desk.file}: mend the study file first")
    animal_row = next((candidate for candidate in study.animals if candidate.animal == animal), None)
    if animal_row is not None:
        return animal_row, study
    cells = next((candidate for candidate in read_rows(desk.table).rows if candidate["animal"] == animal), None)
    if cells is None:
        raise InputError(f"there is no animal '{animal}' in {desk.table.name}")
    row, wrong = read_half_row(cells, study.folder, study.settings.groups)
    refuse(wrong)
    assert row is not None
    return row, study


def _opened_or_channels(row: AnimalRow, site: SiteName) -> LoadedRecording:
    """Return a recording, or what its files hold where nobody knows which channel is pressure and which is flow."""
    try:
        return _opened(row, site)
    except VasowaveError as refusal:
        try:
            blocks = [_block_of(file, row) for file in row.recordings]
        except (VasowaveError, OSError):
            raise refusal from None
        channels = [channel for block in blocks for channel in block.channels if channel.duration > 0]
        if not channels:
            raise
        traces: dict[str, Trace] = {}
        for number, channel in enumerate(channels, 1):
            title, unit = channel.title or f"channel {number}", channel.unit or "no unit"
            name = f"{title} [{unit}]" if f"{title} [{unit}]" not in traces else f"{title} ({number}) [{unit}]"
            traces[name] = Trace(channel.values.astype(np.float32), channel.sampling_rate)
        comments = [comment for block in blocks for comment in block.comments]
        longest = max(channels, key=lambda channel: channel.duration)
        return LoadedRecording(traces, longest.sampling_rate, longest.duration, None, _channels(row), comments, refusal)


def _opened(row: AnimalRow, site: SiteName) -> LoadedRecording:
    as_read = replace(row, zero=None, pressure_gain=None, flow_gain=None, flow_zero=None)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)  # those of the stretch that is averaged are shown
        try:
            raw, has_gaps = read_stretch(replace(as_read, start=0.0, end=None), site), False  # beyond a drug, too
        except InputError:  # a gap: the stretch of the row is whole, and what is beside it
            raw, has_gaps = read_stretch(as_read, site), True
    pieces = (raw, *raw.beside)
    alone = not raw.beside and raw.origin == 0
    count = max(round((piece.origin + piece.duration) * raw.sampling_rate) for piece in pieces)
    traces = {}
    for name in SIGNALS:
        values = getattr(raw, name)
        if values is not None and not alone:
            values = np.full(count, np.nan, dtype=np.float32)
            for piece in pieces:
                first = round(piece.origin * raw.sampling_rate)
                values[first : first + len(piece.pressure)] = getattr(piece, name)
        if values is not None:
            traces[name] = Trace(values, raw.sampling_rate)
    one_rate = not any(note.code == INTERPOLATED.code for note in raw.notes)
    divided = any(is_intervention(comment.text) for comment in raw.every_comment)
    recording = raw if alone and one_rate and not divided else None
    return LoadedRecording(
        traces,
        raw.sampling_rate,
        count / raw.sampling_rate,
        recording,
        _channels(row),
        raw.every_comment,
        of_stretch=has_gaps,
    )


def _block_of(file: Path, row: AnimalRow) -> Block:
    blocks = read_blocks(file, row.sampling_rate, sheet=row.sheet)
    return blocks[choose_block(file, blocks, row.block)[0]]


def _channels(row: AnimalRow) -> dict[str, Any]:
    described = [describe_recording(file, sheet=row.sheet) for file in row.recordings]
    channels = [channel for of_file in described for channel in used_block(of_file, row.block).channels]
    return {
        "channels": [[channel.title, channel.unit, channel.quantity] for channel in channels],
        "blocks": len(described[0].blocks),
    }


def _channels_if_any(row: AnimalRow) -> dict[str, Any]:
    """Return the channels of a recording that could not be read, so that they can be named all the same."""
    try:
        return _channels(row)
    except (VasowaveError, OSError):
        return {}


def _beats(average: EnsembleAverage) -> dict[str, Any]:
    """Return where beats begin, which are averaged, and why others may not be."""
    beats = average.beats
    return {
        "starts": [round(beat.start, 5) for beat in beats],
        "end": round(beats[-1].end, 5),
        "averaged": [i for i, beat in enumerate(beats) if beat.averaged],
        "rejected": {i: str(beat.rejected) for i, beat in enumerate(beats) if beat.rejected},
        "causes": {i: cause(beat.rejected) for i, beat in enumerate(beats) if beat.rejected},
    }


def _cycle(cycle: Recording, *of_animal: Any) -> dict[str, Any]:
    """Return an averaged cycle with what was noted of it; `of_animal` are the arguments of `as_shown` beside."""
    return {
        "period": cycle.period,
        "pressure": numbers(cycle.pressure),
        "flow": numbers(cycle.flow),
        "indices": {name: number(value) for name, value in cycle.indices().items()},
        "findings": [as_shown(note, *of_animal) for note in cycle.notes],
    }


def mean_between(traces: Mapping[str, Trace], signal: str, start: float, end: float) -> float:
    """Return the mean of a signal in a stretch as it was read: mmHg, ml/s."""
    if signal not in traces:
        raise InputError(f"nobody knows yet which channel is the {signal}; name it first")
    trace = traces[signal]
    values = trace.values[max(0, round(start * trace.rate)) : max(0, round(end * trace.rate))]
    if not np.isfinite(values).any():
        raise InputError(f"there is no {signal} in this stretch")
    return float(np.nanmean(values, dtype=np.float64))


def edits_file(desk: Desk, animal: str) -> Path:
    """Return a file for the edits of an animal's beats; one that is there may be that of an animal once called so."""
    name = plain_name(animal)
    names = (name if number == 1 else f"{name} {number}" for number in itertools.count(1))
    return next(path for candidate in names if not (path := desk.inside(f"{EDITS}/{candidate}.csv")).exists())
