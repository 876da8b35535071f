"""Whether pressure and flow belong to one instant: a pressure that is late, and clocks that run apart."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from vasowave.base.cures import STRETCH, UNKNOWN, SetCells, SetSetting
from vasowave.base.findings import Finding, look_kind
from vasowave.catheter.beats.cuts import Cuts
from vasowave.pulse.cycle.waveform import amplitudes


@dataclass(frozen=True)
class LagRules:
    """What counts as a pressure that is late, and as clocks that run apart.

    Attributes
    ----------
    harmonics : int
        Harmonics of the impedance that are compared with those of beds.
    bed_misfit : float
        Relative difference by which an impedance differs from that of a bed.
    harmonic_error : float
        Error of each harmonic, as a share of the largest of its signal.
    misfit_margin : float
        By so much misfits, summed over harmonics and 1 each where there is none, may be larger than the least.
    min_lag_share : float
        Share of the cycle from which a pressure is late: it was 0.5 % in 48 virtual animals, the measured mouse and 40
        kinds that are not late.
    clock_harmonics : int
        Harmonics that are delayed alike where clocks run apart; an animal that changes moves the first most.
    min_delay_ratio : float
        The smallest of their delays is at least this share of the largest.
    min_drift_share : float
        Share of a beat by which delays change over a recording, at least.
    min_drift_sd : float
        Standard errors by which they do.
    min_ecg_drift_share : float
        Share of a beat for the ECG: the time from the R wave to the ejection changes in an animal, too.
    min_usual_share : float
        With a smaller share of beats of usual length phases cannot be followed.
    min_beats : int
        With fewer of them, neither.
    """

    harmonics: int = 8
    bed_misfit: float = 0.1
    harmonic_error: float = 0.02
    misfit_margin: float = 0.1
    min_lag_share: float = 0.015
    clock_harmonics: int = 3
    min_delay_ratio: float = 0.6
    min_drift_share: float = 0.005
    min_drift_sd: float = 6.0
    min_ecg_drift_share: float = 0.1
    min_usual_share: float = 0.7
    min_beats: int = 16


RULES = LagRules()


LATE_PRESSURE = look_kind(
    "recording.late-pressure",
    "the pressure follows the flow by {delay:.2g} ms ({percent:.2g} % of the cycle) more than resistances and a "
    "compliance make it: it is recorded late, or its catheter is damped or rings; Z_c and stiffness are too low",
    "Find out the delay of catheter and filters and give it, or correct the catheter; what is not known of the delay "
    "is a known error.",
    SetCells("Give the delay", (("pressure delay [s]", UNKNOWN),)),
    SetSetting("Allow for a delay", "flow_delay_sd"),
)
CLOCKS = look_kind(
    "recording.clocks-apart",
    "the flow comes {size:g} ms {later} against the pressure at the end than at the beginning of {lasts:.3g} s "
    "({percent:+.2g} %), as of two clocks or two animals; Z_c, stiffness and wave speed depend on the "
    "instant that is averaged",
    "Record both on one clock, or resample one of them to that of the other; where both were begun at one instant, "
    "average beats near it.",
    STRETCH,
)
CLOCK_OF_ECG = look_kind(
    "recording.clock-of-ecg",
    "the pressure comes {size:g} ms {later} after the R wave at the end than at the beginning of {lasts:.3g} s "
    "({percent:+.2g} %), as of two clocks or two animals: beats are cut elsewhere each time. {remedy}",
    "Find beats from the pressure: `fiducial: pressure` (under averaging).",
)


def pressure_lag(pressure: np.ndarray, flow: np.ndarray) -> float:
    """Return by which part of a cycle at least a pressure follows that of a bed of two resistances and a compliance.

    No bed delays a pressure: its phase behind the flow is at most a quarter of each harmonic's own period.
    """
    number = np.arange(1, RULES.harmonics + 1)
    spectra = [amplitudes(values)[: RULES.harmonics + 1] for values in (pressure, flow)]
    count, beds, weight = min(len(spectrum) for spectrum in spectra) - 1, _beds(), RULES.bed_misfit**2
    P, Q = (spectrum[1 : count + 1] + 1e-9 * np.abs(spectrum).max() for spectrum in spectra)  # none is 0
    for spectrum in (P, Q):
        weight = weight + (RULES.harmonic_error * np.abs(spectrum).max() / np.abs(spectrum)) ** 2
    log_ratio = np.log(P / Q * (flow.mean() / pressure.mean()))
    lags = np.arange(-0.05, 0.1001, 0.005)
    misfits = []
    for lag in lags:
        off = log_ratio + 2j * np.pi * lag * number[:count] - beds[:, :count]
        turn = (off.imag + np.pi) % (2 * np.pi) - np.pi
        misfits.append(np.sqrt(1 + (off.real**2 + turn**2) / weight).sum(axis=1).min())
    return round(float(lags[np.array(misfits) <= min(misfits) + RULES.misfit_margin][0]), 4)


@lru_cache(maxsize=1)
def _beds() -> np.ndarray:
    """Return logarithms of impedances in that of harmonic 0, shape (bed, harmonic)."""
    proximal, decay = np.geomspace(1e-3, 1.0, 50)[:, None, None], np.geomspace(0.1, 8.0, 60)[:, None]
    beds: np.ndarray = np.log(proximal + 1 / (1 + 2j * np.pi * np.arange(1, RULES.harmonics + 1) * decay))
    return beds.reshape(-1, RULES.harmonics)


def late_pressure(pressure: np.ndarray, flow: np.ndarray, period: float) -> list[Finding]:
    """Return a finding if the pressure of a cycle of a period, s, follows the flow later than a bed makes it."""
    lag = pressure_lag(pressure, flow)
    return [LATE_PRESSURE(delay=1e3 * lag * period, percent=100 * lag)] if lag >= RULES.min_lag_share else []


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
    if usual.mean() < RULES.min_usual_share or usual.sum() < RULES.min_beats:
        return []
    cut = cut.chosen(usual)
    P, Q = (np.fft.rfft(values[:, :-1])[:, 1 : RULES.clock_harmonics + 1] for values in (cut.pressure, cut.flow))
    lasts = float(cut.ends[-1] - cut.starts[0])
    drift = lasts * _drift(cut, P * Q.conj(), RULES.min_drift_share)
    of_ecg = lasts * _drift(cut, P.conj(), RULES.min_ecg_drift_share) if by_ecg else 0.0
    return [
        finding_kind(
            size=float(f"{1e3 * abs(total):.2g}"),  # so that it is written out
            later="later" if total > 0 else "earlier",
            lasts=lasts,
            percent=100 * total / lasts,
        )
        for finding_kind, total in ((CLOCKS, drift), (CLOCK_OF_ECG, of_ecg))
        if total
    ]


def _drift(cut: Cuts, spectra: np.ndarray, least_share: float) -> float:
    """Return by which part of time a delay grows from the first quarter of the beats to the last, 0 if it stays.

    The phases are those of spectra, shape (beat, harmonic); a drift is at least such a share of a beat.
    """
    number, length = np.arange(1, RULES.clock_harmonics + 1), float(np.median(cut.ends - cut.starts))
    delays = np.unwrap(np.angle(spectra), axis=0) / (2 * np.pi * number) * length
    quarter = len(delays) // 4
    drifts = np.median(delays[-quarter:], axis=0) - np.median(delays[:quarter], axis=0)
    errors = np.median(np.abs(np.diff(delays, axis=0)), axis=0) / 0.954 * 1.25 * np.sqrt(2 / quarter)
    smallest = int(np.argmin(np.abs(drifts)))
    alike = drifts[smallest] * drifts[np.argmax(np.abs(drifts))] > RULES.min_delay_ratio * np.max(drifts**2)
    if not alike or abs(drifts[smallest]) < max(least_share * length, RULES.min_drift_sd * errors[smallest]):
        return 0.0
    return float(drifts[smallest] / (np.median(cut.starts[-quarter:]) - np.median(cut.starts[:quarter])))
