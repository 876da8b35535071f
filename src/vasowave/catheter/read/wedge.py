"""The pressure behind the vascular beds over one cycle: that of the left atrium, or of a wedged catheter."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from vasowave.base.errors import InputError
from vasowave.base.findings import Finding
from vasowave.base.io.columns import read_columns
from vasowave.catheter.check.plausibility import check_closure
from vasowave.catheter.read.read import ASSUMED_UNIT
from vasowave.catheter.read.single_wave import single_wave
from vasowave.catheter.signals.signal import ALIASES, WEDGE_TITLES
from vasowave.pulse.cycle.observation import MAX_PERIOD_DIFFERENCE

_MIN_WEDGE_MMHG = -5.0  # mmHg: the atrium of a deep breath
_NAMES = dict.fromkeys((*WEDGE_TITLES, "la", "left atrium"), "pressure")


class Wedge(NamedTuple):
    """Mean of a pressure behind the beds, mmHg, what it does about that over the cycle, shape (sample,), mmHg, and what
    is odd of it.
    """

    mean: float
    pulsation: np.ndarray
    findings: tuple[Finding, ...]


def read_wedge(path: str | Path, period: float) -> Wedge:
    """Read the pressure behind the beds: a table of one cycle, in step with the recording.

    Parameters
    ----------
    path : path
        A column of pressure, with a column of time or without.
    period : float
        Of the recording, s.

    Raises
    ------
    InputError
        File and line of what cannot be read; no pressure; times that last longer or shorter than the cycle; a cycle
        that does not close, or whose pressure falls far below zero.

    Examples
    --------
    >>> import numpy as np
    >>> from vasowave.catheter.read.wedge import read_wedge
    >>> t = np.arange(55) / 500
    >>> np.savetxt("la.csv", np.c_[t, 8 + 2 * np.sin(2 * np.pi * t / 0.11)], delimiter=",",
    ...            header="time [s],pressure [mmHg]", comments="")
    >>> round(read_wedge("la.csv", 0.11).mean, 6)
    8.0
    """
    wave = single_wave(read_columns(path, {**ALIASES, **_NAMES}), "pressure", "pressure", "mmHg")
    cycle, file_period = wave.cycle()
    lasts = file_period or period
    if abs(lasts - period) > MAX_PERIOD_DIFFERENCE * period:
        raise InputError(
            f"{path}: its cycle lasts {lasts:.5g} s and that of the recording {period:.5g} s; give one cycle, averaged "
            "at the same heart rate and in step with the recording"
        )
    findings = check_closure(cycle, "the pressure behind the beds", str(path))
    if cycle.min() < _MIN_WEDGE_MMHG:
        raise InputError(
            f"{path}: the pressure behind the beds falls to {cycle.min():.3g} mmHg; correct its zero, unit or column"
        )
    if not wave.stated:
        findings.append(ASSUMED_UNIT(quantity="the pressure behind the beds", unit="mmHg", name=Path(path).name))
    mean = float(cycle.mean())
    return Wedge(mean, cycle - mean, tuple(findings))
