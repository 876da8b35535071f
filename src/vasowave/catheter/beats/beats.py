"""Find the beats: R waves of the ECG, or feet of the pressure where there is none.

Detectors made for people take 0.1 to 0.2 s for one QRS complex or one refractory time; a mouse's beat lasts 0.11 s.
Here no such time is fixed: the beat length is first read from the signal's own repetition, and everything else is
measured in beat lengths.
"""

from dataclasses import dataclass, replace

import numpy as np

from vasowave.base.cures import SetSetting
from vasowave.base.errors import InputError, NumericalError
from vasowave.base.findings import Finding, look_kind
from vasowave.base.species import SPECIES
from vasowave.catheter.signals.hum import hum_of
from vasowave.catheter.signals.raw import RawRecording
from vasowave.pulse.cycle.repetition import repeat_length
from vasowave.pulse.cycle.waveform import foot


@dataclass(frozen=True)
class BeatRules:
    """What counts as a beat.

    Attributes
    ----------
    refractory_share : float
        Two beats are at least this fraction of the beat length apart.
    rodent_heart_rate : float
        Fastest heart rate, beats/min, from which a QRS complex is as short as a rodent's, 0.01 s; else it is longer.
    large_heart_rate : float
        Heart rate, beats/min, below which no rodent is.
    min_between_share : float
        A beat length holds several beats if this share of all lengths has further peaks between its ends.
    min_between_strength : float
        Such peaks have at least this share of the beats' strength.
    max_interval_lengths : float
        An interval longer than this many beat lengths is searched again with a lower threshold.
    min_signal_to_noise : float
        What is found there is this many times as strong as the signal is half of the time: an ECG hums between its
        beats.
    pieces : tuple of (float, float)
        How much lower than a narrow complex's the frequencies are in which R waves are sought, and how much longer the
        piece is that is matched: a short one cannot tell which slope of a broad complex it holds.
    loose : float
        The next is tried while marks scatter about the pressure's beats by more than this share of a beat.
    closer : float
        It is taken where they scatter less than this share of before.
    surplus : float
        It is not taken where it finds more beats than the pressure has, by more than this share of them.
    """

    refractory_share: float = 0.55
    rodent_heart_rate: float = 650.0
    large_heart_rate: float = 200.0
    min_between_share: float = 0.7
    min_between_strength: float = 0.4
    max_interval_lengths: float = 1.6
    min_signal_to_noise: float = 3.0
    pieces: tuple[tuple[float, float], ...] = ((1.0, 1.0), (1.0, 2.5), (2.5, 1.0), (6.0, 1.0))
    loose: float = 0.005
    closer: float = 0.8
    surplus: float = 0.05


RULES = BeatRules()


SILENT_ECG = look_kind(
    "recording.ecg-silent",
    "the ECG does not beat; beats were found from the pressure",
    "Look at the ECG's channel; `fiducial: pressure` says that the pressure is meant.",
)


@dataclass(frozen=True, eq=False)
class Beats:
    """Where the beats of a recording start.

    Attributes
    ----------
    times : float array, shape (beat,)
        s since the start of the whole recording.
    fiducial : str
        ``ecg`` (R wave) or ``pressure`` (foot of the upstroke).
    notes : tuple of Finding
        Why the ECG was not used although there is one.
    """

    times: np.ndarray
    fiducial: str
    notes: tuple[Finding, ...] = ()

    @property
    def heart_rate(self) -> float:
        """Heart rate, beats/min, from the median interval."""
        return float(60.0 / np.median(np.diff(self.times)))


def find_beats(
    raw: RawRecording, fiducial: str | None = None, heart_rates: tuple[float, float] = SPECIES["mouse"].heart_rates
) -> Beats:
    """Return the time of every beat, to a fraction of a sample.

    Parameters
    ----------
    raw : RawRecording
    fiducial : {"ecg", "pressure"}, optional
        R wave of the ECG, or foot of the pressure's upstroke. By default the ECG where there is one that
        beats, and else the pressure; `notes` say if the ECG was passed over.
    heart_rates : (float, float), optional
        Slowest and fastest heart rate to look for, beats/min.

    Raises
    ------
    InputError
        An unknown fiducial, no ECG, a range of heart rates that is none, a recording of fewer than three beats.
    NumericalError
        If the signal does not repeat: there are no beats in that range of rates, or noise hides them.
    """
    slowest, fastest = heart_rates
    if not 0 < slowest < fastest:
        raise InputError(f"heart_rates={heart_rates}: give the slowest and the fastest, for example (250, 900)")
    slowest = max(slowest, 180.0 / raw.duration)
    if slowest >= fastest:
        raise InputError(f"{raw.source}: {raw.duration:.3g} s hold fewer than three beats at {fastest:g} beats/min")
    heart_rates = slowest, fastest
    if fiducial not in (None, "ecg", "pressure"):
        raise InputError(f"fiducial '{fiducial}' is neither 'ecg' nor 'pressure'")
    if fiducial != "pressure" and raw.ecg is not None:
        for rates in _of_one_size(heart_rates):
            try:
                return _find_by(raw, "ecg", rates)
            except NumericalError:
                continue
        if fiducial is None:
            return replace(_find_by(raw, "pressure", heart_rates), notes=(SILENT_ECG(),))
    return _find_by(raw, fiducial or "pressure", heart_rates)


def _of_one_size(heart_rates: tuple[float, float]) -> list[tuple[float, float]]:
    """Return a range of heart rates, apart for rodents and for larger animals if it holds both."""
    slowest, fastest = heart_rates
    if slowest < RULES.large_heart_rate and fastest >= RULES.rodent_heart_rate:
        return [(RULES.large_heart_rate, fastest), (slowest, RULES.large_heart_rate)]
    return [heart_rates]


def _find_by(raw: RawRecording, fiducial: str, heart_rates: tuple[float, float]) -> Beats:
    """Return the beats by the fiducial asked for."""
    if fiducial == "ecg":
        if raw.ecg is None:
            raise InputError(f"{raw.source}: no ECG; use fiducial='pressure'")
        times = _r_waves(raw, raw.ecg, heart_rates)
    else:
        quiet = raw.pressure - hum_of(raw.pressure, raw.sampling_rate).course
        shape = np.gradient(_band(quiet, raw.sampling_rate, heart_rates[0] / 120.0, 60.0))
        rise, shortest = np.maximum(shape, 0.0), raw.sampling_rate * 60.0 / heart_rates[1]
        length = _beat_length(rise, raw.sampling_rate, heart_rates, f"{raw.source}, pressure")
        length, peaks = _without_subharmonic(rise, length, shortest)
        times, _ = _align(shape, peaks, max(round(0.2 * length), 3))
        times = times - _foot_before(raw, times, length)
    times = times[(times >= 0) & (times <= len(raw.pressure) - 1)] / raw.sampling_rate
    return Beats(raw.origin + times, fiducial)


def _r_waves(raw: RawRecording, ecg: np.ndarray, heart_rates: tuple[float, float]) -> np.ndarray:
    """Return the samples of the R waves, as broad as those that the pressure's beats follow most closely."""
    times, scatter, length_of_pressure = np.empty(0), np.inf, _pressure_length(raw, heart_rates)
    for broader, longer in RULES.pieces:
        slower = min(1.0, heart_rates[1] / RULES.rodent_heart_rate) / broader
        shape = _band(ecg, raw.sampling_rate, 30.0 * slower, 300.0 * slower)
        strength = _smooth(np.gradient(shape) ** 2, 0.004 / slower * raw.sampling_rate) ** 0.5
        try:
            length = _beat_length(strength, raw.sampling_rate, heart_rates, f"{raw.source}, ecg")
        except NumericalError:
            if not len(times):
                raise
            continue
        length, peaks = _without_subharmonic(strength, length, raw.sampling_rate * 60.0 / heart_rates[1])
        half = max(round(0.006 / slower * raw.sampling_rate), 3)
        marks, shape_of_beat = _align(shape, peaks, round(longer * half))
        of_marks = _scatter(raw.pressure, marks, length_of_pressure or length)
        surplus = len(marks) * (length_of_pressure or length) / len(ecg) - 1
        if not len(times) or (of_marks < RULES.closer * scatter and surplus <= RULES.surplus):
            times, scatter = marks + _extremum(shape_of_beat), of_marks
        if not length_of_pressure or scatter <= RULES.loose * length_of_pressure:
            break
    return times


def _pressure_length(raw: RawRecording, heart_rates: tuple[float, float]) -> float | None:
    """Return the length of the pressure's beats, samples; None where it does not beat."""
    rise = np.gradient(_band(raw.pressure, raw.sampling_rate, heart_rates[0] / 120.0, 60.0))
    try:
        return _beat_length(np.maximum(rise, 0.0), raw.sampling_rate, heart_rates, raw.source)
    except NumericalError:
        return None


def _scatter(pressure: np.ndarray, times: np.ndarray, length: float) -> float:
    """Return by how much marks and upstrokes of the pressure differ from their usual delay, in nine of ten, samples."""
    slope = np.gradient(_smooth(pressure, 0.01 * length))
    reach = round(0.45 * length)
    centers = np.rint(times).astype(int)
    centers = centers[(centers >= reach) & (centers < len(slope) - reach)]
    around = slope[centers[:, None] + np.arange(-reach, reach + 1)]
    usual = np.median(around, axis=0) if len(centers) else np.zeros(1)
    if not usual.any():
        return np.inf
    steepest = times + int(np.argmax(usual)) - reach
    steepest = steepest[(steepest >= 0) & (steepest < len(slope) - 1)]
    delays = _align(slope, np.rint(steepest).astype(int), max(round(0.2 * length), 3))[0] - steepest
    return float(np.quantile(np.abs(delays - np.median(delays)), 0.9))  # a tenth may be lost, not a third elsewhere


def _band(values: np.ndarray, rate: float, low: float, high: float) -> np.ndarray:
    """Return the signal between two frequencies (Hz), without delay."""
    from scipy.signal import butter, sosfiltfilt

    high = min(high, 0.4 * rate)
    return sosfiltfilt(butter(2, (min(low, 0.5 * high), high), "bandpass", fs=rate, output="sos"), values)


def _smooth(values: np.ndarray, samples: float) -> np.ndarray:
    from scipy.ndimage import gaussian_filter1d

    return gaussian_filter1d(values, max(samples / 2.0, 0.5))


def _beat_length(strength: np.ndarray, rate: float, heart_rates: tuple[float, float], where: str) -> float:
    """Return the beat length in samples: the first strong peak of the autocorrelation in the range of heart rates."""
    # Large beats must not outweigh the others, nor an artefact all of them.
    centred = np.minimum(strength, 4.0 * np.quantile(strength, 0.9))
    centred = _smooth(centred, 0.04 * rate * 60.0 / heart_rates[1])
    centred = centred - centred.mean()
    length = _repeats(centred, rate, heart_rates)
    if length is None:
        raise NumericalError(
            f"{where}: the signal does not repeat between {heart_rates[0]:g} and {heart_rates[1]:g} beats/min; "
            "is it the right channel, is it covered by noise, or is the heart rate in another range? Then name "
            "the species or the range",
            _other_rates(centred, rate, heart_rates),
        )
    return length


def _repeats(values: np.ndarray, rate: float, heart_rates: tuple[float, float]) -> float | None:
    return repeat_length(values, int(rate * 60.0 / heart_rates[1]), int(np.ceil(rate * 60.0 / heart_rates[0])))


def _other_rates(values: np.ndarray, rate: float, heart_rates: tuple[float, float]) -> tuple[SetSetting, ...]:
    """Return the species at whose heart rates a signal repeats, or else all others, and the range."""
    different = {name: species.heart_rates for name, species in SPECIES.items() if species.heart_rates != heart_rates}
    repeating = [name for name, rates in different.items() if _repeats(values, rate, rates) is not None]
    return (
        *(SetSetting(f"It is a {name}", "species", name) for name in repeating or different),
        SetSetting("Name the heart rates", "averaging.heart_rates"),
    )


def _peaks(strength: np.ndarray, length: float) -> np.ndarray:
    """Return the samples of the beats: peaks a beat apart, against a threshold that follows their height."""
    from scipy.ndimage import median_filter
    from scipy.signal import find_peaks

    peaks = find_peaks(strength, distance=max(1, int(RULES.refractory_share * length)))[0]
    if len(peaks) == 0:
        return peaks
    # The largest peak of every beat length is a beat's; their running median is the height beats have here.
    width = max(1, int(length))
    blocks = strength[: len(strength) // width * width].reshape(-1, width).max(axis=1)
    typical = median_filter(blocks, 15, mode="nearest")
    height = typical[np.minimum(peaks // width, len(typical) - 1)]
    strong = peaks[strength[peaks] > 0.4 * height]
    above = np.maximum(0.15 * height, RULES.min_signal_to_noise * np.median(strength))
    weak = peaks[(strength[peaks] > above) & (strength[peaks] <= 0.4 * height)]
    gaps = np.flatnonzero(np.diff(strong) > RULES.max_interval_lengths * length)
    for gap in gaps[::-1]:
        inside = weak[(weak > strong[gap]) & (weak < strong[gap + 1])]
        strong = np.insert(strong, gap + 1, inside)
    return strong


def _without_subharmonic(strength: np.ndarray, length: float, shortest: float) -> tuple[float, np.ndarray]:
    """Return beat length and peaks; where every length holds several beats that are nearly as strong, those.

    Beats that alternate in length or size repeat in pairs, and hum may let a pair repeat better than a beat.
    """
    peaks = _peaks(strength, length)
    for divisor in (2, 3):
        if length / divisor < shortest or len(peaks) < 3:
            continue
        finer_peaks = _peaks(strength, length / divisor)
        between = np.setdiff1d(finer_peaks, peaks)
        if len(between) > RULES.min_between_share * (divisor - 1) * len(peaks) and np.median(
            strength[between]
        ) > RULES.min_between_strength * np.median(strength[peaks]):
            return length / divisor, finer_peaks
    return length, peaks


def _align(shape: np.ndarray, peaks: np.ndarray, half: int) -> tuple[np.ndarray, np.ndarray]:
    """Return where every beat best matches the mean beat (in samples, sub-sample), and the mean beat around it.

    A peak of the noisy signal jitters; the match of a whole complex does not.
    """
    times = peaks.astype(float)
    template = np.zeros(2 * half + 1)
    for _ in range(2):
        inside = times[(times >= 2 * half + 1) & (times < len(shape) - 2 * half - 1)]
        if len(inside) == 0:
            return times, template
        centres = np.rint(inside).astype(int)
        template = np.median(shape[centres[:, None] + np.arange(-half, half + 1)], axis=0)
        times = _best_matches(shape, template, np.rint(times).astype(int), half)
    return times, template


def _best_matches(shape: np.ndarray, template: np.ndarray, centres: np.ndarray, half: int) -> np.ndarray:
    """Return the places within `half` of `centres` where the correlation with the template peaks, by a parabola."""
    places = centres.astype(float)
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(shape, 2 * half), len(template))  # nothing moves outside
    lags = np.arange(-half, half + 1)
    score = np.stack([windows[centres + half + lag] @ template for lag in lags], axis=1)
    best = np.argmax(score, axis=1)
    inner = np.flatnonzero((best > 0) & (best < 2 * half))
    three = score[inner[:, None], best[inner, None] + np.arange(-1, 2)]
    places[inner] += lags[best[inner]] + _vertex(three.T)
    return np.clip(places, 0, len(shape) - 1)


def _extremum(template: np.ndarray) -> float:
    """Return where the R wave stands in the mean complex, relative to its middle, in samples."""
    top = int(np.argmax(np.abs(template)))
    inner = 0 < top < len(template) - 1
    return top - len(template) // 2 + (float(_vertex(np.abs(template[top - 1 : top + 2]))) if inner else 0.0)


def _vertex(three: np.ndarray) -> np.ndarray:
    """Return the place of a parabola's vertex through three samples (first axis), relative to the middle one."""
    bend = three[0] - 2 * three[1] + three[2]
    return np.clip(np.divide(0.5 * (three[0] - three[2]), bend, out=np.zeros_like(bend), where=bend != 0), -0.5, 0.5)


def _foot_before(raw: RawRecording, times: np.ndarray, length: float) -> float:
    """Return by how many samples the foot precedes the steepest rise, from the mean beat (intersecting tangents)."""
    reach = round(0.45 * length)
    centres = np.rint(times).astype(int)
    centres = centres[(centres >= reach) & (centres < len(raw.pressure) - reach)]
    if len(centres) == 0:
        return 0.0
    mean = raw.pressure[centres[:, None] + np.arange(-reach, reach + 1)].mean(axis=0)
    return reach - foot(_smooth(mean, 0.03 * length), reach)
