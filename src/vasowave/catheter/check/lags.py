"""Whether pressure and flow belong to one instant: a pressure that is late, and clocks that run apart."""

from functools import lru_cache

import numpy as np

from vasowave.base.findings import Finding, look_kind
from vasowave.catheter.beats.cuts import Cuts
from vasowave.pulse.cycle.waveform import amplitudes

_HARMONICS = 8  # of the impedance that are compared with beds
_UNLIKE = 0.1  # by which an impedance differs from that of a bed
_UNSURE = 0.02  # of the largest harmonic of a signal, by which each is taken to be uncertain
_MARGIN = 0.1  # by which misfits summed over harmonics, 1 each where there is none, may be larger than the least
_LATE = 0.015  # of the cycle: 0.5 % in 48 virtual animals, the measured mouse and 40 kinds that are not late
_CLOCK_HARMONICS = 3  # are delayed alike where clocks run apart; an animal that changes moves the first most
_ALIKE = 0.6  # of the largest of their delays that the smallest has at least
_DRIFT, _SURE = 0.005, 6.0  # of a beat, and standard errors, by which delays change over a recording
_DRIFT_OF_ECG = 0.1  # of a beat: the time from the R wave to the ejection changes in an animal, too
_REGULAR, _FEWEST = 0.7, 16  # of the beats, and beats of usual length: with fewer phases cannot be followed

LATE_PRESSURE = look_kind(
    "recording.late-pressure",
    "the pressure follows the flow by {delay:.2g} ms ({percent:.2g} % of the cycle) more than resistances and a "
    "compliance make it: it is recorded late, or its catheter is damped or rings; Z_c and stiffness are too low",
    "Find out the delay of catheter and filters and give it as `pressure delay [s]`, or correct the catheter; what is "
    "not known of the delay is a known error, `flow_delay_sd`.",
)
CLOCKS = look_kind(
    "recording.clocks-apart",
    "the flow comes {drift:+.2g} ms later against the pressure at the end than at the beginning of {lasts:.3g} s "
    "({percent:+.2g} %), as of two clocks; Z_c, stiffness and wave speed depend on the instant that is averaged",
    "Record both on one clock, or resample one of them to that of the other; where both were begun at one instant, "
    "average beats near it (`start` and `end`).",
)
CLOCK_OF_ECG = look_kind(
    "recording.clock-of-ecg",
    "the pressure comes {drift:+.2g} ms later after the R wave at the end than at the beginning of {lasts:.3g} s "
    "({percent:+.2g} %), as of two clocks: beats are cut elsewhere each time. {remedy}",
    "Find beats from the pressure: `fiducial: pressure` (under averaging).",
)


def pressure_lag(pressure: np.ndarray, flow: np.ndarray) -> float:
    """Return by which part of a cycle at least a pressure follows that of a bed of two resistances and a compliance.

    No bed delays a pressure: its phase behind the flow is at most a quarter of each harmonic's own period.
    """
    number = np.arange(1, _HARMONICS + 1)
    spectra = [amplitudes(values)[: _HARMONICS + 1] for values in (pressure, flow)]
    count, beds, weight = min(len(spectrum) for spectrum in spectra) - 1, _beds(), _UNLIKE**2
    P, Q = (spectrum[1 : count + 1] + 1e-9 * np.abs(spectrum).max() for spectrum in spectra)  # none is 0
    for spectrum in (P, Q):
        weight = weight + (_UNSURE * np.abs(spectrum).max() / np.abs(spectrum)) ** 2
    log_ratio = np.log(P / Q * (flow.mean() / pressure.mean()))
    lags = np.arange(-0.05, 0.1001, 0.005)
    misfits = []
    for lag in lags:
        off = log_ratio + 2j * np.pi * lag * number[:count] - beds[:, :count]
        turn = (off.imag + np.pi) % (2 * np.pi) - np.pi
        misfits.append(np.sqrt(1 + (off.real**2 + turn**2) / weight).sum(axis=1).min())
    return round(float(lags[np.array(misfits) <= min(misfits) + _MARGIN][0]), 4)


@lru_cache(maxsize=1)
def _beds() -> np.ndarray:
    """Return logarithms of impedances in that of harmonic 0, shape (bed, harmonic)."""
    proximal, decay = np.geomspace(1e-3, 1.0, 50)[:, None, None], np.geomspace(0.1, 8.0, 60)[:, None]
    beds: np.ndarray = np.log(proximal + 1 / (1 + 2j * np.pi * np.arange(1, _HARMONICS + 1) * decay))
    return beds.reshape(-1, _HARMONICS)


def late_pressure(pressure: np.ndarray, flow: np.ndarray, period: float) -> list[Finding]:
    """Return a finding if the pressure of a cycle of a period, s, follows the flow later than a bed makes it."""
    lag = pressure_lag(pressure, flow)
    return [LATE_PRESSURE(delay=1e3 * lag * period, percent=100 * lag)] if lag >= _LATE else []


def clocks_apart(cut: Cuts, usual: np.ndarray, by_ecg: bool) -> list[Finding]:
    """Return findings if the delay between pressure and flow, or R wave and pressure, changes over a recording.

    Parameters
    ----------
    cut : Cuts
    usual : bool array, shape (beat,)
        Which beats are of usual length.
    by_ecg : bool
        Whether they begin with R waves.
    """
    if usual.mean() < _REGULAR or usual.sum() < _FEWEST:
        return []
    cut = cut.chosen(usual)
    P, Q = (np.fft.rfft(values[:, :-1])[:, 1 : _CLOCK_HARMONICS + 1] for values in (cut.pressure, cut.flow))
    lasts = float(cut.ends[-1] - cut.starts[0])
    drift = lasts * _drift(cut, P * Q.conj(), _DRIFT)
    of_ecg = lasts * _drift(cut, P.conj(), _DRIFT_OF_ECG) if by_ecg else 0.0
    findings = [CLOCKS(drift=1e3 * drift, lasts=lasts, percent=100 * drift / lasts)] if drift else []
    return (
        [*findings, CLOCK_OF_ECG(drift=1e3 * of_ecg, lasts=lasts, percent=100 * of_ecg / lasts)] if of_ecg else findings
    )


def _drift(cut: Cuts, spectra: np.ndarray, least_share: float) -> float:
    """Return by which part of time a delay grows from the first quarter of the beats to the last, 0 if it stays.

    The phases are those of spectra, shape (beat, harmonic); a drift is at least such a share of a beat.
    """
    number, length = np.arange(1, _CLOCK_HARMONICS + 1), float(np.median(cut.ends - cut.starts))
    delays = np.unwrap(np.angle(spectra), axis=0) / (2 * np.pi * number) * length
    quarter = len(delays) // 4
    drifts = np.median(delays[-quarter:], axis=0) - np.median(delays[:quarter], axis=0)
    errors = np.median(np.abs(np.diff(delays, axis=0)), axis=0) / 0.954 * 1.25 * np.sqrt(2 / quarter)
    smallest = int(np.argmin(np.abs(drifts)))
    alike = drifts[smallest] * drifts[np.argmax(np.abs(drifts))] > _ALIKE * np.max(drifts**2)
    if not alike or abs(drifts[smallest]) < max(least_share * length, _SURE * errors[smallest]):
        return 0.0
    return float(drifts[smallest] / (np.median(cut.starts[-quarter:]) - np.median(cut.starts[:quarter])))
