"""Pressure and volume of a ventricle from any format of recordings, and the calibration of a conductance."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base import units
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, note_kind
from vasowave.base.settings import Positive, given_values, settings_class
from vasowave.catheter.check.catheter import DELAY_CORRECTED
from vasowave.catheter.read.choosing import VENTRICLE, choose, pick_channels
from vasowave.catheter.read.formats import check_sheet, read_blocks
from vasowave.catheter.read.joined import joined_blocks
from vasowave.catheter.read.read_raw import at_one_rate, canonical, check_timed, in_units, read_block, refuse_gaps
from vasowave.catheter.signals.channels import Block, Channel
from vasowave.pulse.cycle.ventricular import PressureVolume

CALIBRATED = note_kind(
    "loops.volume-calibrated",
    "the volume is ({gain:g} times what the file says [{unit}] {offset:+g} ml − {parallel:g} ml)/{alpha:g}, as given",
)
_RAW_CONDUCTANCE = ("magnitude", "phase", "admittance", "conductance")


@settings_class
class LoopReading:
    """What to read of a recording of a ventricle, and how its volume is calibrated.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.LoopReading(volume="LVV", volume_unit="ul", alpha=0.8).alpha
    0.8
    """

    pressure: str | None = None
    """Title of its channel; needed where neither titles nor units leave one answer."""
    volume: str | None = None
    """As `pressure`."""
    pressure_unit: str | None = None
    """Unit of a channel for which the file names none, or a wrong one: what is given here counts."""
    volume_unit: str | None = None
    """As `pressure_unit`: ml or ul."""
    volume_gain: Positive | None = None
    """Of a volume in relative units (RVU), volts or siemens: ml of one of them, as cuvettes of known volume tell."""
    volume_offset: float = 0.0
    """The volume, ml, of such a reading of 0."""
    parallel_volume: float = 0.0
    """Volume, ml, that the wall's conductance adds, as a bolus of saline tells (Baan et al. 1984); subtracted."""
    alpha: Positive = 1.0
    """Stroke volume by the conductance over the one by a flow probe or by echo; the volume is divided by it."""
    volume_delay: float = 0.0
    """By how much the volume comes later than the pressure, s: it is made that much earlier."""
    block: int | None = None
    """Which block to read, counted from 1; by default the longest."""
    start: float | None = None
    """Start of the stretch to read, s since the start of the block."""
    end: float | None = None
    """Its end, s since the start of the block."""
    sampling_rate: float | None = None
    """Samples per second of a table without a time column."""
    sheet: str = ""
    """Of a workbook."""


def read_loops(path: str | Path, volume_file: str | Path | None = None, **settings: Any) -> PressureVolume:
    """Read pressure and volume of a ventricle, recorded together.

    Parameters
    ----------
    path : path
        Any recording that `read_raw_recording` takes: a table with titles (``time [s]``, ``LVP [mmHg]``, ``LVV [µl]``),
        LabChart's text or MATLAB export, EDF … Titles of either ventricle are known; of both, name one.
    volume_file : path, optional
        The volume, where `path` holds the pressure alone: both are joined on their clocks.
    settings
        Those of `LoopReading` by name: ``volume_unit="ul", parallel_volume=0.012, alpha=0.8``.

    Raises
    ------
    InputError
        File, block, line or channel of what is wrong. A volume in relative units without its gain is none.

    Examples
    --------
    >>> import numpy as np
    >>> import vasowave as vw
    >>> turn = 2 * np.pi * np.arange(0, 4, 0.002)
    >>> table = np.c_[turn / 2 / np.pi, 40 - 40 * np.cos(turn - 1), 9 + 3 * np.cos(turn)]
    >>> np.savetxt("lv.csv", table, delimiter=",", header="time [s],LVP [mmHg],Volume [RVU]", comments="")
    >>> float(vw.read_loops("lv.csv", volume_gain=10.0, parallel_volume=20.0).volume.max())  # ml
    100.0
    """
    reading = given_values(LoopReading, None, settings)
    files = [Path(path)] if volume_file is None else [Path(path), Path(volume_file)]
    check_sheet(files, reading.sheet)
    of_files = [read_blocks(file, reading.sampling_rate, None, reading.sheet) for file in files]
    blocks = of_files[0] if volume_file is None else joined_blocks(files, of_files)
    block, notes = read_block(Path(path), blocks, reading.block)
    picked, guessed = _picked(path, block, reading)
    scaled, calibrated = in_units(picked, partial(_converted, reading))
    signals, rate, origin, interpolated = at_one_rate(scaled, reading.start, reading.end)
    notes = [*notes, *guessed, *calibrated, *interpolated]
    recording = PressureVolume(signals["pressure"], signals["volume"], rate, str(path), tuple(notes), origin)
    return _advanced(recording, reading.volume_delay) if reading.volume_delay else recording


def _picked(path: str | Path, block: Block, reading: LoopReading) -> tuple[dict[str, Channel], list[Finding]]:
    """Return the channels of pressure and volume, of equal length and without gaps."""
    titles = {"pressure": reading.pressure, "volume": reading.volume}
    channels = _without_raw_conductance(block.channels)
    if choose(channels, titles, VENTRICLE).problems:
        channels = list(block.channels)
    picked, guessed = pick_channels(path, channels, titles, VENTRICLE, block.program)
    check_timed(path, picked)
    refuse_gaps(list(picked.values()), reading.start, reading.end)
    return picked, guessed


def _converted(reading: LoopReading, name: str, channel: Channel) -> tuple[np.ndarray, list[Finding]]:
    """Return mmHg or ml, and what was given or assumed."""
    return _calibrated(channel, reading) if name == "volume" else canonical(channel, name, reading.pressure_unit)


def _advanced(recording: PressureVolume, delay: float) -> PressureVolume:
    """Return a recording whose volume is earlier by a delay, s, between samples by cubic splines."""
    from scipy.interpolate import CubicSpline

    if not abs(delay) < 0.5 * recording.duration:
        raise InputError(f"{recording.source}: a volume delay of {delay:g} s is half of the recording or more; give s")
    samples = np.arange(len(recording.volume))
    places = samples + delay * recording.sampling_rate
    inside = np.flatnonzero((places >= 0) & (places <= samples[-1]))
    volume = CubicSpline(samples, recording.volume)(places[inside])
    note = DELAY_CORRECTED(signal="volume", delay=1e3 * delay)
    origin = recording.origin + inside[0] / recording.sampling_rate
    return replace(recording, pressure=recording.pressure[inside], volume=volume, origin=origin,
                   notes=(*recording.notes, note), volume_delay=delay)  # fmt: skip


def _without_raw_conductance(channels: tuple[Channel, ...]) -> list[Channel]:
    """Return the channels that may hold a volume: what a system makes its volume of stands beside it."""
    return [channel for channel in channels if not channel.title.strip().lower().startswith(_RAW_CONDUCTANCE)]


def _calibrated(channel: Channel, reading: LoopReading) -> tuple[np.ndarray, list[Finding]]:
    """Return the volume in ml, and what was given or assumed."""
    unit = reading.volume_unit or channel.unit
    if reading.volume_gain is not None and units.is_of(unit, "volume"):
        raise InputError(
            f"{channel.place}: the volume is in {unit} already; leave the gain out, or give alpha, the stroke volume "
            "that it tells over the true one"
        )
    if reading.volume_gain is None and reading.volume_offset:
        raise InputError(f"{channel.place}: an offset of the volume belongs to its gain; give both, or parallel_volume")
    if reading.volume_gain is None and units.is_of(unit, "relative volume"):
        raise InputError(
            f"{channel.place}: {unit} are relative units, no volume; give the gain (ml of one unit) and the offset "
            "(ml) of the calibration with cuvettes, or export the calibrated channel"
        )
    if reading.volume_gain is None:
        values, notes = canonical(channel, "volume", reading.volume_unit)
    else:
        values, notes = reading.volume_gain * channel.values + reading.volume_offset, []
    if reading.volume_gain is None and reading.parallel_volume == 0.0 and reading.alpha == 1.0:
        return values, notes
    applied = CALIBRATED(
        gain=reading.volume_gain or units.factor(unit, "volume"), unit=unit or "1",
        offset=reading.volume_offset, parallel=reading.parallel_volume, alpha=reading.alpha,
    )  # fmt: skip
    return (values - reading.parallel_volume) / reading.alpha, [*notes, applied]
