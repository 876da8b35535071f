"""From one row of the table and the settings to an animal that can be analyzed."""

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np

from vasowave.base.cures import AVERAGE_BREATHS, SetCells, field_of
from vasowave.base.errors import InputError, VasowaveError, VasowaveWarning, of_file
from vasowave.base.findings import Finding, found_in, look_kind, note_kind, warn
from vasowave.base.io.textfile import look
from vasowave.base.sites import PULMONARY, SiteName
from vasowave.catheter.baseline.ventilation import BREATH_MOVES, BREATH_MOVES_FLOW
from vasowave.catheter.beats.edits import read_edits
from vasowave.catheter.check.catheter import (
    Catheter,
    LowPass,
    correct_catheter,
    ringing,
    suspect_catheter,
    without_delays,
)
from vasowave.catheter.check.lags import LATE_PRESSURE
from vasowave.catheter.check.plausibility import LATE_FLOW, odd_timing
from vasowave.catheter.ensemble import average_beats
from vasowave.catheter.read.describe import describe_recording, kind_of
from vasowave.catheter.read.loops import read_loops
from vasowave.catheter.read.read import read_recording
from vasowave.catheter.read.read_raw import read_raw_recording
from vasowave.catheter.read.site_files import read_sites
from vasowave.catheter.read.ventricle import read_ventricle
from vasowave.catheter.read.wedge import read_wedge
from vasowave.catheter.signals.raw import RawRecording
from vasowave.pulse.analysis.ventricle_coupling import coupled
from vasowave.pulse.analysis.ventricular_function import VentricularFunction, pressure_volume
from vasowave.pulse.calibration.sites import places_of
from vasowave.pulse.cycle.averaged import EnsembleAverage
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.cycle.waveform import close_cycle, low_pass
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.law_files import LawFile, in_words, learn
from vasowave.pulse.model.nominal import estimate_nominal, oddities
from vasowave.pulse.network.network import Network
from vasowave.pulse.network.tidying import repaired
from vasowave.pulse.network_formats import read_network
from vasowave.pulse.solver.practice import PAPER
from vasowave.study.animal.animal import Animal, Settings
from vasowave.study.animal.files import to_bytes
from vasowave.study.animal.pipeline import Progress, analyze
from vasowave.study.animal.result import AnimalResult
from vasowave.study.folder.animal_columns import COLUMNS
from vasowave.study.folder.rows import AnimalRow
from vasowave.study.folder.settings import StudyFile, animal_settings, averaging_settings
from vasowave.study.results.store import Journal, key_of

WEDGE = note_kind(
    "recording.wedge", "the pressure behind the vascular beds is {wedge:.4g} mmHg (wedge): PVR and R_T count from it"
)
WEDGE_WAVE = note_kind("recording.wedge-wave", "over the cycle that pressure changes by {pulse:.3g} mmHg")
WEDGE_DIFFERS = look_kind(
    "recording.wedge-differs",
    "the wedge pressure is given as {given:.3g} mmHg, the mean of its waveform is {wave:.3g} mmHg; the number counts",
    "Correct one of the two, or leave the number out.",
)
BREATH_MOVES_RESISTANCE = look_kind(
    "recording.breath-moves-resistance",
    "at end-expiration PVR is {resistance:.3g} mmHg s/ml; over whole breaths, if the breath does not move the wedge "
    "pressure, it is {over_breaths:.3g} ({percent:+.1f} %)",
    "Take the wedge pressure at end-expiration as well, or average over the breath.",
    AVERAGE_BREATHS,
)
_MAX_WEDGE_DIFFERENCE = 1.0  # mmHg, between a wedge pressure and the mean of its wave
_MIN_MOVE = 0.02  # of PVR, by the breath, from which it is told
SYNTHETIC_MARK = b"SYNTHETIC"
"""Recordings that vasowave makes carry this word; no table of animals can make them measured ones."""

_HEAD_BYTES = 4096  # bytes from the beginning of a file, where the mark stands
_OF_LOOPS = {title for title, column in COLUMNS.items() if column.scope == "loops"}
_FILE_OF_LOOPS = (
    ". In a study the file of loops holds one pressure with its unit, a volume in ml or µl, and no gap: export these "
    "channels and seconds into a file of its own"
)
_OPTIONAL = {field_of(title) for title, column in COLUMNS.items() if column.enters_key == "where given"}
"""Of a row: what enters the key only where it is given."""
_NOT_IN_KEY = {"recordings", "line", "lab_cells", "errors"} | {
    field_of(title) for title, column in COLUMNS.items() if column.is_file or column.enters_key == "never"
}
"""Of a row: files, which enter the key by their content, what stands in the settings, and what changes no result."""


def file_hashes(row: AnimalRow, folder: Path) -> dict[str, str]:
    """Return the SHA-256 of every file of one animal by its role, and the file's name as seen from `folder`."""
    return {role: f"{look(file).sha256} ({inside(file, folder)})" for role, file in row.files.items()}


def animal_key(row: AnimalRow, study: StudyFile, folder: Path) -> str:
    """Return what stands for everything that enters the analysis of one animal.

    Raises
    ------
    InputError
        One of its files cannot be read.
    """
    inputs: dict[str, Any] = {name: value for name, value in vars(row).items() if name not in _NOT_IN_KEY}
    inputs = {name: value for name, value in inputs.items() if value or name not in _OPTIONAL}
    inputs["settings"], inputs["image pressure"] = animal_settings(study, row).as_json(), study.image_pressure
    inputs["practice"], inputs["catheter"] = study.practice, study.catheter
    inputs["kind"] = row.kind or kind_of(row.recordings, row.sheet)
    if (site := _site(row, study.site)) != PULMONARY:
        inputs["site"] = site
    if inputs["kind"] == "raw":
        inputs["averaging"] = asdict(averaging_settings(study))
    return key_of(inputs, [(inside(file, folder), file) for file in row.files.values()])


def load_animal(row: AnimalRow, study: StudyFile, folder: Path) -> Animal:
    """Read the files of one animal.

    What is noticed on the way stands in the recording's notes. File names in them are relative to `folder`, so that the
    same study gives the same result wherever it lies.

    Raises
    ------
    InputError, NumericalError
        A file is wrong, or its beats cannot be averaged.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", VasowaveWarning)
        network = _filled(read_network(row.network), row, study)
        loops = _loops(row, folder)
        animal = Animal(row.animal, row.group, network, *read_measured(row, study))
    warned = list(found_in(caught))
    synthetic = row.synthetic or any(SYNTHETIC_MARK in look(file).start[:_HEAD_BYTES] for file in row.recordings)
    recording = _corrected(animal.recording, warned, row, study, folder)
    recording = _noted(recording, _oddities(network, recording, animal_settings(study, row).blood))
    if study.practice == "paper":
        recording = PAPER.recording(recording)
    sites = read_sites(row.sites) if row.sites else ()
    with of_file(row.sites):
        places_of(sites, network, recording.period)
    ventricle = read_ventricle(row.ventricle, recording.period) if row.ventricle else None
    if ventricle is not None:
        ventricle = replace(ventricle, source=inside(Path(ventricle.source), folder))
        recording = _noted(recording, coupled(recording, ventricle)[1])
    if loops is not None:
        recording = _noted(recording, loops.findings)
    beats = None if animal.beats is None else _corrected_beats(animal.beats, row, study)
    return replace(animal, recording=recording, beats=beats, synthetic=synthetic, sites=sites, ventricle=ventricle,
                   loops=loops)  # fmt: skip


def _loops(row: AnimalRow, folder: Path) -> VentricularFunction | None:
    """Return what loops of pressure and volume tell, where they were recorded."""
    if row.loops is None:
        return None
    settings = {"volume": row.volume_channel or None, "volume_unit": row.volume_unit or None}
    try:
        recording = read_loops(row.loops, **settings, volume_delay=row.volume_delay or 0.0)
    except InputError as error:  # whose other cures would be written into columns of the recording
        cures = [cure for cure in error.cures if isinstance(cure, SetCells) and {*dict(cure.cells)} <= _OF_LOOPS]
        hint = "" if len(cures) == len(error.cures) else _FILE_OF_LOOPS
        raise InputError(f"{error}{hint}", cures) from None
    notes = tuple(note.inside(f"{folder}/") for note in recording.notes)
    return pressure_volume(replace(recording, source=inside(row.loops, folder), notes=notes))


def load_recording(row: AnimalRow, study: StudyFile) -> tuple[Recording, EnsembleAverage | None]:
    """Read what was recorded of one animal, without its vessels; raises as `load_animal`."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", VasowaveWarning)
        recording, beats, _ = read_measured(row, study)
    corrected = _corrected(recording, list(found_in(caught)), row, study, Path())
    return corrected, None if beats is None else _corrected_beats(beats, row, study)


def _corrected(
    recording: Recording, warned: list[Finding], row: AnimalRow, study: StudyFile, folder: Path
) -> Recording:
    """Return a recording without known errors of instruments, with what lies behind its beds and what was noticed.

    Names of files in it are relative to `folder`.
    """
    further_notes = [finding for finding in warned if finding.at("") not in recording.notes]
    prefix = "" if folder == Path() else f"{folder}/"  # of files beside the current folder nothing is taken away
    notes = dict.fromkeys(finding.inside(prefix) for finding in (*recording.notes, *further_notes))
    relative = replace(recording, source=recording.source.replace(prefix, ""), notes=tuple(notes))
    return _wedged(_through_instruments(relative, row, study), row)


def _noted(recording: Recording, findings: Iterable[Finding]) -> Recording:
    """Return a recording with further findings among its notes."""
    return replace(recording, notes=tuple(dict.fromkeys((*recording.notes, *findings))))


def _corrected_beats(average: EnsembleAverage, row: AnimalRow, study: StudyFile) -> EnsembleAverage:
    """Return an average whose single beats are without known errors of instruments, as its cycle is."""
    corrections = (row.pressure_delay, row.flow_delay, row.pressure_cutoff, row.flow_cutoff, study.catheter)
    if not any(corrections):
        return average
    harmonics = averaging_settings(study).harmonics  # what no response of an instrument can bring back
    lengths, cycles = (beat.end - beat.start for beat in average.beats if beat.averaged), []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VasowaveWarning)  # what the mean cycle has warned of
        for pressure, flow, length in zip(average.beat_pressure, average.beat_flow, lengths, strict=True):
            closed = (close_cycle(signal)[0] for signal in (pressure, flow))
            signals = [signal if harmonics is None else low_pass(signal, harmonics) for signal in closed]
            beat = Recording(signals[0], signals[1], length, site=average.recording.site)
            cycle = _through_instruments(beat, row, study)
            cycles.append((cycle.pressure, cycle.flow))
    pressures, flows = (np.pad(np.array(beats), ((0, 0), (0, 1)), "wrap") for beats in zip(*cycles, strict=True))
    return replace(average, beat_pressure=pressures, beat_flow=flows)


def _wedged(recording: Recording, row: AnimalRow) -> Recording:
    """Return a recording with what lies behind its beds, and what is to be known of it."""
    wave = read_wedge(row.wedge_wave, recording.period) if row.wedge_wave else None
    mean = row.wedge if row.wedge is not None or wave is None else wave.mean
    findings = [WEDGE(wedge=mean)] if mean else []
    if wave is not None:
        findings += [WEDGE_WAVE(pulse=float(np.ptp(wave.pulsation))), *wave.findings]
        if mean is not None and abs(mean - wave.mean) > _MAX_WEDGE_DIFFERENCE:
            findings.append(WEDGE_DIFFERS(given=mean, wave=wave.mean))
    pulsation = None if wave is None else wave.pulsation
    wedged = replace(recording, wedge_pressure=mean or 0.0, wedge_pulsation=pulsation)
    return _noted(wedged, [*findings, *_moved_by_breaths(wedged)])


def _moved_by_breaths(recording: Recording) -> list[Finding]:
    """Return what is to be said of PVR where breaths move the pressure before the beds and perhaps not that behind."""
    moves = [dict(note.values) for note in recording.notes if note.code in (BREATH_MOVES.code, BREATH_MOVES_FLOW.code)]
    if not moves or not recording.wedge_pressure:
        return []
    resistance = recording.vascular_resistance
    over_breaths = (float(moves[0]["breath_pressure"]) - recording.wedge_pressure) / float(moves[0]["breath_flow"])
    share = over_breaths / resistance - 1
    values = {"resistance": resistance, "over_breaths": over_breaths, "percent": 100 * share}
    return [BREATH_MOVES_RESISTANCE(**values)] if abs(share) > _MIN_MOVE else []


def read_measured(row: AnimalRow, study: StudyFile) -> tuple[Recording, EnsembleAverage | None, RawRecording | None]:
    """Return the cycle of one animal, and the beats and the continuous recording that it is the average of; raises as
    `load_animal`.
    """
    if (row.kind or kind_of(row.recordings, row.sheet)) == "cycle":
        try:
            cycle = read_recording(
                *row.recordings, period=row.period, calibration=row.calibration, site=_site(row, study.site),
                sheet=row.sheet, subject_row=row.subject_row, flow_diameter=row.flow_diameter, **_units(row),
            )  # fmt: skip
        except InputError:
            for file in () if row.kind else row.recordings:  # what nobody can describe is refused in the same words
                describe_recording(file, sheet=row.sheet)
            raise
        return cycle, None, None
    raw = read_stretch(row, study.site)
    edits = read_edits(row.beat_edits) if row.beat_edits else ()
    beats = average_beats(raw, averaging=averaging_settings(study), edits=edits)
    return beats.recording, beats, raw


def _site(row: AnimalRow, site: SiteName) -> SiteName:
    """Return the artery of an animal: of its row, else that of the study."""
    return cast(SiteName, row.site) or site


def read_stretch(row: AnimalRow, site: SiteName = PULMONARY) -> RawRecording:
    """Return the stretch of a continuous recording that is averaged; raises as its reader."""
    raw = read_raw_recording(
        *row.recordings,
        pressure=row.pressure_channel or None,
        flow=row.flow_channel or None,
        ecg=row.ecg_channel or None,
        block=row.block,
        start=row.start,
        end=row.end,
        sampling_rate=row.sampling_rate,
        site=_site(row, site),
        sheet=row.sheet,
        flow_diameter=row.flow_diameter,
        progress=None,
        **_units(row),
    )
    return raw.calibrated(*row.calibration)


def _through_instruments(recorded: Recording, row: AnimalRow, study: StudyFile) -> Recording:
    """Return the recording without known delays, filters and the study's catheter; else say if a catheter rings."""
    recording = without_delays(recorded, row.pressure_delay or 0.0, row.flow_delay or 0.0)
    signals: Sequence[Literal["pressure", "flow"]] = ("pressure", "flow")
    responses = (row.pressure_cutoff, row.pressure_damping), (row.flow_cutoff, row.flow_damping)
    for signal, (cutoff, damping) in zip(signals, responses, strict=True):
        if cutoff and cutoff * recording.period < 1:
            raise InputError(
                f"{recording.source}: a {signal} cutoff of {cutoff:g} Hz is below the heart rate, "
                f"{1 / recording.period:.3g} Hz, and leaves no pulse; give it in Hz"
            )
        if cutoff:
            response = Catheter(cutoff, damping) if damping else LowPass(cutoff)
            recording = correct_catheter(recording, response, signal)
    if study.catheter is not None and not row.pressure_damping:
        recording = correct_catheter(recording, Catheter(*study.catheter))
    if recording is not recorded:
        late = odd_timing(recording.pressure, recording.flow, recording.period)  # in the place of what it was late
        notes = [note for note in recording.notes if note.code not in (LATE_FLOW.code, LATE_PRESSURE.code)]
        recording = replace(recording, notes=(*notes, *late))
    if study.catheter is not None or row.pressure_damping or (suspected := suspect_catheter(recording)) is None:
        return recording
    return replace(recording, notes=(*recording.notes, ringing(suspected, recording)))


def _oddities(network: Network, recording: Recording, blood: Blood) -> Sequence[Finding]:
    """Return which nominal values no artery has; none where there are no nominal values, which the fit says."""
    try:
        return oddities(estimate_nominal(network, recording, blood), recording.flow)
    except VasowaveError:
        return ()


def _filled(network: Network, row: AnimalRow, study: StudyFile) -> Network:
    """Return the network with the pressure of its image: of its file, else the row, else the study; or the paper's."""
    if network.pressure and row.image_pressure not in (None, network.pressure):
        raise InputError(
            f"{row.network}: its vessels were imaged at {network.pressure:g} mmHg, the table of animals says "
            f"{row.image_pressure:g}; correct one of the two"
        )
    filled = replace(network, pressure=network.pressure or row.image_pressure or study.image_pressure)
    if study.practice == "paper":
        return PAPER.network(filled)
    repaired_network, repairs = repaired(filled)
    for repair in repairs:
        warn(repair.at(str(row.network)), stacklevel=4)
    return repaired_network


@in_words()
def analyze_animal(
    animal: Animal,
    settings: Settings,
    hashes: Mapping[str, str],
    journal: str,
    key: str,
    laws: Sequence[LawFile],
    progress: Progress | None = None,
) -> AnimalResult:
    """Analyze one animal; searches that its journal (a file) knows are not made again.

    The SHA-256 of its files and the key of the piece (see `results.store`) stand in the `origin` of the result.
    """
    learn(laws)
    result = analyze(animal, settings, progress, Journal(Path(journal)))
    of_files = {f"sha256 of {role}": digest for role, digest in hashes.items()}
    return replace(result, origin={**result.origin, **of_files, "key": key})


def analyzed_bytes(*arguments: Any) -> bytes:
    """Return the result of `analyze_animal` as the bytes of a netCDF-4 file. Runs in a worker."""
    return to_bytes(analyze_animal(*arguments).to_datatree())


def _units(row: AnimalRow) -> dict[str, Any]:
    return {"pressure_unit": row.pressure_unit or None, "flow_unit": row.flow_unit or None}


def inside(file: Path, folder: Path) -> str:
    """Return the name of a file as seen from `folder`."""
    return file.relative_to(folder).as_posix() if file.is_relative_to(folder) else file.as_posix()
