"""Read a continuous recording of pressure, flow and ECG from the files a lab has."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from vasowave.base import units
from vasowave.base.cures import UNKNOWN, Cure, SetCells
from vasowave.base.errors import InputError
from vasowave.base.findings import Finding, Severity, note_kind, warn
from vasowave.base.io.textfile import Progress
from vasowave.base.settings import Positive, given_values, settings_class
from vasowave.base.sites import PULMONARY, SiteName
from vasowave.catheter.read.choosing import DIMENSIONS, column_of, pick_channels, wanted_titles
from vasowave.catheter.read.formats import check_sheet, read_blocks
from vasowave.catheter.read.gated import GatedCycle, gated_channel, gated_file, on_beats
from vasowave.catheter.read.joined import joined_blocks
from vasowave.catheter.read.velocity import flow_of_velocity
from vasowave.catheter.signals.channels import Block, Channel
from vasowave.catheter.signals.gaps import Span, describe_gaps, free_between, gaps_in
from vasowave.catheter.signals.interventions import comment_findings
from vasowave.catheter.signals.raw import MIN_DURATION_S, RawRecording, check_rate
from vasowave.catheter.signals.signal import NAME_THE_RATE, RATE, UNIT_REPLACED

_MAX_LENGTH_DIFFERENCE = 0.01  # two channels of a block last equally long within this share and two samples


NO_ECG = note_kind("recording.no-ecg", "no ECG: beats can be found from the pressure only")
LONGEST_BLOCK = note_kind(
    "recording.longest-block", "block {number} of {blocks} was read, the longest (blocks last {lengths})"
)
_LARGEST = 1e100  # above it, slopes between samples may be infinite
ECG_WITHOUT_UNIT = note_kind("recording.ecg-without-unit", "the ECG has no unit; only its shape is used")
GIVEN_UNIT = note_kind("recording.given-unit", "{name} was taken to be in {unit}, as given")
INTERPOLATED = note_kind("recording.interpolated", "'{title}' was interpolated from {given:g} to {rate:g} samples/s")


@settings_class
class Reading:
    """What to read of a continuous recording: what `read_raw_recording` takes by name.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Reading(flow="Flow 2", start=30, end=60).end
    60.0
    """

    pressure: str | None = None
    """Title of its channel; needed where neither titles nor units leave one answer (a note says what was guessed)."""
    flow: str | None = None
    """As `pressure`."""
    ecg: str | None = None
    """As `pressure`."""
    pressure_unit: str | None = None
    """Unit of a channel for which the file names none (in LabChart: for which no units conversion was set), or a wrong
    one: what is given here counts."""
    flow_unit: str | None = None
    """As `pressure_unit`."""
    block: int | None = None
    """Which block to read, counted from 1; by default the longest (a note says which)."""
    start: float | None = None
    """Start of the stretch to read, s since the start of the block. Gaps elsewhere do not matter then. What is outside
    is kept in `RawRecording.beside`, because it shows the drift of the pressure."""
    end: float | None = None
    """Its end, s since the start of the block."""
    sampling_rate: float | None = None
    """Samples per second of a table without a time column."""
    flow_diameter: Positive | None = None
    """Diameter of the vessel, mm, where a velocity was recorded in place of the flow."""
    sheet: str = ""
    """Of a workbook; by default the first that holds pressure and flow (a warning says which, where several do)."""
    site: SiteName = PULMONARY
    """The artery: titles that speak of it are preferred, those of other places are passed over."""


def read_raw_recording(
    path: str | Path, flow_file: str | Path | None = None, *, progress: Progress | None = None, **settings: Any
) -> RawRecording:
    """Read continuous pressure, flow and (if present) ECG from one file, or from two.

    Parameters
    ----------
    path : path
        A CSV, TSV or blank-separated table whose header names columns and units (``time [s]``, ``pressure [mmHg]``,
        ``flow [ml/s]``, ``ecg [mV]``), the text export of a recorder, LabChart's text or MATLAB export, or EDF/EDF+.
    flow_file : path, optional
        The flow, where `path` holds the pressure alone: both are joined on their clocks.
    progress : callable, optional
        Is called with the fraction of a text file that was read, 0 to 1.
    settings
        Those of `Reading` by name: ``flow="Flow 2", start=30, end=60``; needed where the file leaves several answers.

    Raises
    ------
    InputError
        File, block, line or channel of what is wrong, and the cure; for an ``.adicht`` file, how to export it.

    Warns
    -----
    VasowaveWarning
        If the file looks cut off.

    Examples
    --------
    >>> import vasowave as vw
    >>> import numpy as np
    >>> from pathlib import Path
    >>> t = np.arange(0, 4.0, 1e-3)
    >>> beat = np.exp(-0.5 * (((t / 0.11) % 1 - 0.3) / 0.1) ** 2)
    >>> rows = (f"{a:.3f}\\t{8 + 20 * b:.3f}\\t{0.4 * b:.4f}" for a, b in zip(t, beat))
    >>> _ = Path("mouse.txt").write_text("\\n".join(["time [s]\\tpressure [mmHg]\\tflow [ml/s]", *rows, ""]))
    >>> vw.read_raw_recording("mouse.txt").sampling_rate
    1000.0
    """
    reading = given_values(Reading, None, settings)
    path, files = Path(path), [Path(file) for file in (path, flow_file) if file is not None]
    check_sheet(files, reading.sheet)
    blocks, gated = _blocks_of(files, reading, progress)
    reading = reading if gated is None else replace(reading, flow_unit=None)  # it has been applied
    block, notes = read_block(path, blocks, reading.block)
    picked, delay_sd, choices = _picked(path, block, reading, gated)
    start, end, around, remarks = _stretch(path, block, picked, reading)
    gaps = refuse_gaps(list(picked.values()), start, end)
    scaled, converted = in_units(picked, partial(_converted, reading))
    channels = {column_of(name): channel for name, channel in scaled.items()}
    raw = _between(path, block, channels, start, end)
    read_span = Span(start or 0.0, raw.origin + raw.duration if end is None else end)
    shortest = MIN_DURATION_S + 1 / raw.sampling_rate
    spans = [span for span in free_between([*gaps, read_span], *around) if span.end - span.start > shortest]
    notes = [*notes, *choices, *remarks, *converted, *raw.notes]
    neighbors = tuple(_between(path, block, channels, *span) for span in spans)
    return replace(raw, site=reading.site, flow_delay_sd=delay_sd, notes=tuple(notes), beside=neighbors)


def _blocks_of(
    files: Sequence[Path], reading: Reading, progress: Progress | None
) -> tuple[list[Block], GatedCycle | None]:
    """Return the blocks of a file, or of two on one clock, and the cycle of the second where that was gated."""
    path, *further = files
    try:
        blocks = read_blocks(path, reading.sampling_rate, progress, reading.sheet)
    except InputError as error:
        raise _with_units_wanted(error, path, reading) from None
    for file in further:
        described = read_blocks(file, np.nan, progress, reading.sheet)
        length = max(len(channel.values) for block in described for channel in block.channels)
        gated = gated_file(file, reading.flow_unit, reading.site, reading.sheet, length)
        if gated is None:
            of_files = [blocks, read_blocks(file, reading.sampling_rate, progress, reading.sheet)]
            return joined_blocks(files, of_files), None
        if reading.flow or reading.flow_diameter:
            raise InputError(f"{file}: of a gated cycle neither a channel nor a diameter can be chosen; leave its flow "
                             "alone in the file")  # fmt: skip
        return blocks, gated
    return blocks, None


def _warn_of(path: Path, findings: Iterable[Finding]) -> None:
    """Warn of what somebody should look at."""
    for finding in findings:
        if finding.severity is Severity.LOOK:
            warn(finding.at(str(path)), stacklevel=4)


def read_block(path: Path, blocks: list[Block], number: int | None) -> tuple[Block, list[Finding]]:
    """Return the block to read, and what is to be known of it and of the choice, of which some is warned of."""
    index, notes = choose_block(path, blocks, number)
    _warn_of(path, blocks[index].suspicions)
    return blocks[index], [*notes, *blocks[index].suspicions]


def _picked(
    path: Path, block: Block, reading: Reading, gated: GatedCycle | None
) -> tuple[dict[str, Channel], float, list[Finding]]:
    """Return the channels of pressure, flow and ECG, of equal length, the SD of the flow's place, s, and findings."""
    if np.isfinite(fastest := max(channel.sampling_rate for channel in block.channels)):
        check_rate(str(path), fastest)
    titles = wanted_titles(reading.pressure, reading.flow, reading.ecg, reading.flow_diameter is not None)
    if gated is not None:
        titles = {name: title for name, title in titles.items() if name in ("pressure", "ecg")}
    picked, notes = pick_channels(path, block.channels, titles, reading.site, block.program)
    if gated is None and "flow" in picked:
        gated = gated_channel(path, picked["flow"], block.channels)
    delay_sd = 0.0
    if gated is not None:
        picked["flow"], put, delay_sd = on_beats(path, picked["pressure"], gated)
        notes.append(put)
        _warn_of(path, [put])
    check_timed(path, picked)
    return picked, delay_sd, notes if "ecg" in picked else [*notes, NO_ECG()]


def _stretch(
    path: Path, block: Block, picked: Mapping[str, Channel], reading: Reading
) -> tuple[float | None, float | None, Span, list[Finding]]:
    """Return start and end of what is read, s, the longest stretch around it without an intervention, and findings."""
    lasts = min(channel.duration for channel in picked.values())
    stretch, around, remarks = comment_findings(block.comments, lasts, reading.start, reading.end)
    _warn_of(path, remarks)
    if not remarks:
        return reading.start, reading.end, around, remarks
    return stretch.start or None, None if stretch.end == lasts else stretch.end, around, remarks


def _converted(reading: Reading, name: str, channel: Channel) -> tuple[np.ndarray, list[Finding]]:
    """Return the values of a channel in the canonical unit, of a velocity the flow, and what was assumed."""
    stated = {"pressure": reading.pressure_unit, "ecg": None}.get(name, reading.flow_unit)
    values, notes = canonical(channel, name, stated)
    if name != "velocity":
        return values, notes
    flow, made = flow_of_velocity(values, reading.flow_diameter or 0.0)
    return flow, [*notes, made]


def in_units(
    picked: Mapping[str, Channel], convert: Callable[[str, Channel], tuple[np.ndarray, list[Finding]]]
) -> tuple[dict[str, Channel], list[Finding]]:
    """Return channels with the values that `convert` makes of them, and its findings; all that is wrong at once."""
    scaled, notes, wrong = dict[str, Channel](), list[Finding](), list[InputError]()
    for name, channel in picked.items():
        try:
            values, words = convert(name, channel)
        except InputError as error:
            wrong.append(error)
        else:
            scaled[name] = replace(channel, values=values)
            notes += words
    if wrong:
        raise all_wanted(wrong)
    return scaled, notes


def at_one_rate(channels: Mapping[str, Channel], start: float | None, end: float | None
                ) -> tuple[dict[str, np.ndarray], float, float, list[Finding]]:  # fmt: skip
    """Return a stretch of all channels at the rate of the fastest; that, its origin, s, and what was interpolated."""
    rate = max(channel.sampling_rate for channel in channels.values())
    pieces = {name: at_rate(stretch_of(channel, channel.values, start, end), channel, rate)
              for name, channel in channels.items()}  # fmt: skip
    count = min(len(values) for values, _ in pieces.values())
    notes = [note for _, words in pieces.values() for note in words]
    signals = {name: values[:count] for name, (values, _) in pieces.items()}
    return signals, rate, round((start or 0.0) * rate) / rate, notes


def _between(
    path: Path, block: Block, channels: Mapping[str, Channel], start: float | None, end: float | None
) -> RawRecording:
    """Return a stretch of a block with its comments."""
    signals, rate, origin, notes = at_one_rate(channels, start, end)
    last = origin + len(signals["pressure"]) / rate
    comments = tuple(comment for comment in block.comments if origin <= comment.time <= last)
    return RawRecording(signals["pressure"], signals["flow"], rate, signals.get("ecg"), str(path), tuple(notes),
                        origin=origin, comments=comments)  # fmt: skip


def check_timed(path: str | Path, picked: Mapping[str, Channel]) -> None:
    """Refuse channels of one block without times, or that do not last equally long: a rate or an end is wrong."""
    if not all(np.isfinite(channel.sampling_rate) for channel in picked.values()):
        raise InputError(f"{path}: no times; {NAME_THE_RATE}", [RATE])
    shortest, *_, longest = sorted(picked.values(), key=lambda channel: channel.duration)
    if longest.duration > (1 + _MAX_LENGTH_DIFFERENCE) * shortest.duration + 2 / shortest.sampling_rate:
        durations = " and ".join(
            f"'{extreme.title}' {extreme.duration:.6g} s ({len(extreme.values)} samples at {extreme.sampling_rate:g} a "
            "second)"
            for extreme in (shortest, longest)
        )
        raise InputError(f"{shortest.place}: channels of one block last equally long, but {durations}; export it again")


def refuse_gaps(channels: list[Channel], start: float | None, end: float | None) -> list[Span]:
    """Return all gaps; refuse a stretch in which samples are missing, with seconds, and which stretch is whole."""
    first, last = start or 0.0, min(channel.duration for channel in channels)
    last = last if end is None else min(end, last)
    gaps = {channel.place: gaps_in(channel.values, channel.sampling_rate) for channel in channels}
    gaps_within = {
        place: [gap for gap in spans if gap.end > first and gap.start < last] for place, spans in gaps.items()
    }
    if any(gaps_within.values()):
        all_gaps = [gap for spans in gaps_within.values() for gap in spans]
        place = next(place for place, spans in gaps_within.items() if spans)
        text, cures = describe_gaps(all_gaps, first, last, MIN_DURATION_S)
        raise InputError(f"{place}: {text}", cures)
    return [gap for spans in gaps.values() for gap in spans]


def choose_block(path: str | Path, blocks: list[Block], block: int | None) -> tuple[int, list[Finding]]:
    """Return the index of the block to read and a note if a choice was made."""
    if block is not None:
        if not 1 <= block <= len(blocks):
            raise InputError(f"{path}: no block {block}; it has {len(blocks)}")
        return block - 1, []
    longest = max(range(len(blocks)), key=lambda i: blocks[i].duration)
    if len(blocks) == 1 or blocks[0].sheet:
        return 0, []
    lengths = ", ".join(f"{candidate.duration:.4g} s" for candidate in blocks)
    return longest, [LONGEST_BLOCK(number=longest + 1, blocks=len(blocks), lengths=lengths)]


def canonical(channel: Channel, name: str, stated_unit: str | None) -> tuple[np.ndarray, list[Finding]]:
    """Return the values in the canonical unit, and what was assumed."""
    quantity = DIMENSIONS[name]
    unit = channel.unit
    if name == "ecg" and not unit:
        return channel.values, [ECG_WITHOUT_UNIT()]
    if stated_unit is not None and channel.unit and name != "ecg" and not _unconverted(channel):
        same = _factor_or_none(unit, quantity) == units.factor(stated_unit, quantity)
        notes = [] if same else [UNIT_REPLACED(name=name, unit=stated_unit, stated=unit)]
        return channel.values * units.factor(stated_unit, quantity), [*notes]
    if name != "ecg" and _unconverted(channel):
        if stated_unit is None:
            generic = SetCells(f"Name the unit of {name}", ((f"{column_of(name)} unit", UNKNOWN),))
            raise InputError(_unit_wanted(channel, name), [*_usual_units(channel, name), generic])
        return channel.values * units.factor(stated_unit, quantity), [GIVEN_UNIT(name=name, unit=stated_unit)]
    try:
        return channel.values * units.factor(unit, quantity), []
    except InputError as error:
        cure = SetCells(f"Name the unit of {name}", ((f"{column_of(name)} unit", UNKNOWN),))
        raise InputError(f"{channel.place}: {error}; if the file is wrong, name the unit", [cure]) from None


def _with_units_wanted(error: InputError, path: str | Path, reading: Reading) -> InputError:
    """Return an error that asks for the sampling rate, and, if they are missing, for the units as well."""
    asked_for = {title for cure in error.cures if isinstance(cure, SetCells) for title, _ in cure.cells}
    if not asked_for & dict(RATE.cells).keys():
        return error
    wrong = [error]
    with suppress(InputError):
        block = read_blocks(path, np.nan, None, reading.sheet)[0]
        titles = wanted_titles(reading.pressure, reading.flow, reading.ecg, reading.flow_diameter is not None)
        for name, channel in pick_channels(path, block.channels, titles, reading.site, block.program)[0].items():
            try:
                _converted(reading, name, channel)
            except InputError as unit_error:
                wrong.append(unit_error)
    return all_wanted(wrong)


def all_wanted(wrong: list[InputError]) -> InputError:
    """Return errors as one; of several the first cure mends all in the first way of each, the next in the last."""
    ways_of = [[cure for cure in error.cures if isinstance(cure, SetCells)] for error in wrong]
    cures: list[Cure] = [cure for error in wrong for cure in error.cures]
    if len(wrong) > 1 and all(ways_of):
        rows = [[cures_of[place] for cures_of in ways_of] for place in (0, -1)]
        cures[:0] = [SetCells("; ".join(cure.label for cure in row), tuple(cell for cure in row for cell in cure.cells))
                     for row in rows]  # fmt: skip
    return InputError("\n".join(map(str, wrong)), cures)


def _unconverted(channel: Channel) -> bool:
    """Whether the numbers of a channel are volts, or nobody knows what."""
    return not channel.unit or _factor_or_none(channel.unit, "voltage") is not None


def _factor_or_none(unit: str, quantity: str) -> float | None:
    try:
        return units.factor(unit, quantity)
    except InputError:
        return None


def _unit_wanted(channel: Channel, name: str) -> str:
    """Say that a channel's unit is not known, and how to name it."""
    advice = "name its unit"
    if not channel.unit:
        return f"{channel.place}: {name} has no unit; {advice}"
    title_units = [
        text for text in re.findall(r"[(\[]([^)\]]+)[)\]]", channel.title) if _factor_or_none(text, DIMENSIONS[name])
    ]
    title = f", though its title speaks of {title_units[0]}" if title_units else ""
    return (
        f"{channel.place}: {name} is in {channel.unit}{title}; set the units conversion in the recording program and "
        f"export again, or, if the numbers are {name} already, {advice}"
    )


def _usual_units(channel: Channel, name: str) -> list[SetCells]:
    """Return what the usual units would make of a channel, its mean in each, as cures."""
    quantity = DIMENSIONS[name]
    usual, mean = units.CANONICAL[quantity], float(np.nanmean(channel.values))
    alternatives = {"pressure": ["kPa"], "flow": ["ml/min"]}.get(quantity, [])
    return [
        SetCells(f"The {name} is in {unit}: mean {mean * units.factor(unit, quantity):.3g} {usual}",
                 ((f"{column_of(name)} unit", unit),)) for unit in (usual, *alternatives)
    ]  # fmt: skip


def stretch_of(channel: Channel, values: np.ndarray, start: float | None, end: float | None) -> np.ndarray:
    """Return the samples from `start` to `end`."""
    lasts = channel.duration
    first = round((start or 0.0) * channel.sampling_rate)
    last = len(values) if end is None else round(end * channel.sampling_rate)
    if start is not None and end is not None and end <= start:
        raise InputError(f"{channel.place}: the stretch ends at {end:g} s and starts at {start:g} s; exchange them")
    if not 0 <= first < last <= len(values):
        until = lasts if end is None else end
        raise InputError(f"{channel.place}: {start or 0:g} to {until:g} s does not lie in 0 to {lasts:.5g} s")
    return values[first:last]


def at_rate(values: np.ndarray, channel: Channel, rate: float) -> tuple[np.ndarray, list[Finding]]:
    """Return the values at the rate of the fastest channel, by cubic splines."""
    if abs(channel.sampling_rate - rate) <= 1e-9 * rate:
        return values, []
    from scipy.interpolate import CubicSpline

    if len(values) < 4:
        raise InputError(f"{channel.place}: {len(values)} samples; a continuous recording is needed")
    if (largest := float(np.abs(values).max())) > _LARGEST:
        raise InputError(f"{channel.place}: a sample of {largest:.3g} is no measurement; correct it")
    times = np.arange(int(len(values) * rate / channel.sampling_rate)) / rate
    times = times[times <= (len(values) - 1) / channel.sampling_rate]
    spline = CubicSpline(np.arange(len(values)) / channel.sampling_rate, values)
    return spline(times), [INTERPOLATED(title=channel.title, given=channel.sampling_rate, rate=rate)]
