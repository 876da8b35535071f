"""A virtual mouse: the recording of a control mouse that the package makes from known parameters."""

import numpy as np

from vasowave.base.findings import note_kind
from vasowave.pulse.cycle.cycle import Inflow, Recording
from vasowave.pulse.examples.published import control_network
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.nominal import windkessels
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.walls import LinearWall
from vasowave.pulse.solver.simulation import simulate

TRUTH = {"beta": 57.0, "R_T": 76.0, "a": 0.12, "tau": 0.12}
"""Parameters of the virtual mouse: mmHg, mmHg s/ml, 1, s; near those of the published control mouse 6."""

_PERIOD = 60 / 533  # s, the published mean heart rate of the control mice
_CARDIAC_OUTPUT = 0.18  # ml/s, likewise
SAMPLES = 512  # a cycle
FROM_PARAMETERS = note_kind(
    "recording.from-parameters",
    "This recording is synthetic: vasowave made it from {which} parameters and added noise.",
)


def ejection(samples: int = SAMPLES, length: float = 0.40, skewness: float = 0.70) -> Inflow:
    """Return a pulmonary flow: a rounded, early-peaked ejection, a small backflow, rest; 0.18 ml/s.

    Parameters
    ----------
    samples : int
    length : float
        Of the ejection, as a share of the cycle.
    skewness : float
        How much weaker the ejection's end is than its start.
    """
    phase = np.arange(samples) / samples
    systole = np.clip((phase - 0.05) / length, 0, 1)
    flow = np.sin(np.pi * systole) ** 2 * (1.35 - skewness * systole)
    flow -= 0.03 * np.exp(-0.5 * ((phase - 0.07 - length) / 0.015) ** 2)
    return Inflow(_CARDIAC_OUTPUT * flow / flow.mean(), _PERIOD)


def virtual_mouse(noise: float = 0.15, seed: int = 6) -> Recording:
    """Return the synthetic recording of a control mouse with the linear wall and the parameters `TRUTH`.

    Parameters
    ----------
    noise : float
        Standard deviation of the pressure noise, mmHg: smooth over a few milliseconds, as what remains after averaging
        twenty beats.
    seed : int
        Of the noise.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.virtual_mouse()
    Recording(mPAP ... mmHg, CO 0.180 ml/s, HR 533/min, 512 pressure and 512 flow samples, virtual mouse, synthetic)
    """
    network = control_network()
    outlets = windkessels(network, TRUTH["R_T"], TRUTH["tau"], TRUTH["a"])
    inflow = ejection()
    result = simulate(Model(network, LinearWall(TRUTH["beta"]), outlets), inflow, Numerics(samples=SAMPLES))
    pressure = result["pressure"].values[:, network.root, 0]
    rough = np.random.default_rng(seed).standard_normal(SAMPLES)
    k = np.fft.rfftfreq(SAMPLES, 1 / SAMPLES)
    smooth = np.fft.irfft(np.fft.rfft(rough) * np.exp(-0.5 * (k / 25) ** 2), SAMPLES)
    return Recording(
        pressure + noise * smooth / smooth.std() if noise > 0 else pressure,
        inflow.flow,
        _PERIOD,
        "virtual mouse, synthetic",
        (FROM_PARAMETERS(which="known"),),
    )
