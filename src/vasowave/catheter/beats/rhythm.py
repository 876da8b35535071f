"""What of the beats' mean pressures follows their mean flows, as where beats come early or late."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class RhythmRules:
    """How a pressure follows the flow.

    Attributes
    ----------
    remains : tuple of float
        Shares of what lies above the level behind the bed that remain after a beat, 0 to 1, that are tried.
    before : float
        Share of a beat's pressure that the flow of the beat before moves, that of its own the rest: a beat that is cut
        at the R wave begins before its flow does.
    max_gain : float
        The pressure changes by at most this many times its own share for a share of the flow: 1 where the pressure
        behind the bed is 0, and less where it is more; the rest is for errors of the flow.
    explains : float
        Flow that explains this share of what breaths explain of the pressure is what moves it: breaths that lift the
        pressure lower the flow.
    by_length : float
        Share of the flow's changes that are those of unusual beats, or explained by the lengths of beats, where the
        rhythm makes them.
    flow_by_length : float
        What lengths explain of the flow's changes is at most this many times their own changes, both as shares: a
        breath that moves the feet, at which beats are cut without an ECG, seems to change the lengths, too.
    """

    remains: tuple[float, ...] = (0.1, 0.25, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
    before: float = 0.6
    max_gain: float = 1.3
    explains: float = 0.75
    by_length: float = 0.5
    flow_by_length: float = 4.0


RULES = RhythmRules()


def led_by_flow(pressure: np.ndarray, flow: np.ndarray, used: np.ndarray, rules: RhythmRules = RULES) -> np.ndarray:
    """Return the part of the beats' mean pressures that their flows and those of the beats before explain.

    A bed fills with the flow of each beat and empties between (a Windkessel, beat by beat), so that a long or an empty
    beat lowers the pressure of its own and the next ones; more flow never lowers it.

    Parameters
    ----------
    pressure, flow : float array, shape (beat,)
        Means of all beats, mmHg and ml/s.
    used : bool array, shape (beat,)
        Beats whose pressures are to be explained.
    rules : RhythmRules, optional

    Returns
    -------
    float array, shape (beat,)
        Of mean zero over the beats used, mmHg.
    """
    from scipy.optimize import nnls
    from scipy.signal import lfilter

    off = flow - np.median(flow)
    moves = (1.0 - rules.before) * off + rules.before * np.append(off[:1], off[:-1])
    gain_limit = rules.max_gain * abs(float(np.mean(pressure[used]) / np.mean(flow))) if np.mean(flow) else 0.0
    aims = pressure[used] - pressure[used].mean()
    best, best_squares = np.zeros(len(pressure)), float(aims @ aims)
    for share in rules.remains:
        columns = np.stack([off, lfilter([1.0 - share], [1.0, -share], moves)], axis=1)
        columns -= columns[used].mean(axis=0)
        gains = nnls(columns[used], aims)[0]
        led = columns @ (gains * min(1.0, gain_limit / max(gains.sum(), 1e-300)))
        squares = float(np.sum((aims - led[used]) ** 2))
        if squares < best_squares:
            best, best_squares = led, squares
    return best


def of_rhythm(
    pressure: np.ndarray, flow: np.ndarray, lengths: np.ndarray, used: np.ndarray, breath: np.ndarray,
    rules: RhythmRules = RULES,
) -> np.ndarray:  # fmt: skip
    """Return what the rhythm explains of the mean pressures, mmHg, if it explains what a breath does; zeros else.

    Parameters
    ----------
    pressure, flow, used
        As of `led_by_flow`.
    lengths : float array, shape (beat,)
        s.
    breath : float array, shape (beat,)
        What returns with every breath, mmHg.
    rules : RhythmRules, optional
    """
    led = led_by_flow(pressure, flow, used, rules)
    columns = np.stack([np.roll(lengths, lag) for lag in range(3)], axis=1)
    columns, changes = columns - columns.mean(axis=0), flow - flow.mean()
    of_lengths = columns @ np.linalg.lstsq(columns, changes, rcond=None)[0]
    if _variation(of_lengths[used], flow) > rules.flow_by_length * _variation(lengths[used], lengths):
        of_lengths = np.zeros(len(flow))
    residual = (changes - of_lengths)[used]
    rhythmic = float(residual @ residual) < (1.0 - rules.by_length) * float(changes @ changes)
    leads = _explained(led, pressure, used) > rules.explains * _explained(breath, pressure, used)
    return led if rhythmic and leads else np.zeros(len(led))


def _variation(changes: np.ndarray, values: np.ndarray) -> float:
    """Return the SD of changes as a share of the mean of values."""
    return float(np.std(changes)) / max(abs(float(np.mean(values))), 1e-300)


def _explained(prediction: np.ndarray, pressure: np.ndarray, used: np.ndarray) -> float:
    """Return the squares that a part explains of the pressures of the beats used, mmHg²."""
    aims, residual = pressure[used], (pressure - prediction)[used]
    return float(np.sum((aims - aims.mean()) ** 2) - np.sum((residual - residual.mean()) ** 2))
