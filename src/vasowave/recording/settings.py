"""How continuous recordings become one cycle: every setting, once."""

from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le

from vasowave.recording.cycle import FEWEST_SAMPLES
from vasowave.settings import Range, settings_class


@settings_class
class Averaging:
    """From continuous recordings to one cycle. Only for animals of kind 'raw'.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.Averaging(beats=12, drift="warn").samples
    256
    """

    beats: Annotated[int, Ge(2)] = 20
    """Number of beats to average, 20 in the paper."""
    samples: Annotated[int, Ge(FEWEST_SAMPLES)] = 256
    """Samples of the cycle."""
    harmonics: Annotated[int, Ge(1)] | None = 20
    """Harmonics of the averaged cycle that are kept; None keeps all. What is above 20 is noise, which would push the
    largest and the smallest value (sPAP, dPAP) apart."""
    fiducial: Literal["ecg", "pressure"] | None = None
    """R wave, or foot of the pressure; by default the ECG where there is one that beats."""
    heart_rates: Range | None = None
    """Slowest and fastest heart rate to look for, beats/min; by default 250 to 900, in a study of rats 150 to 650."""
    length_tolerance: Annotated[float, Gt(0), Le(1)] = 0.1
    """A beat whose length differs by a larger fraction from the median of its neighbours is rejected."""
    least_correlation: Annotated[float, Ge(-1), Le(1)] = 0.9
    """A beat whose pressure or flow correlates less with the median beat is rejected."""
    reject_ventilation: bool = True
    """Whether a beat whose mean pressure or flow stands off the end-expiratory level (more than 2.5 SD of the narrowest
    quarter of all beats) is rejected."""
    correct_delay: bool = False
    """Whether the flow is advanced by the p-q delay that the feet of both show. They tell it within a few percent of
    the cycle, which moves the stiffness by much; a delay that was measured is better."""
    drift: Literal["remove", "warn"] = "remove"
    """Whether the drift of the transducer and its steps are subtracted, or only told. A trend that comes with a change
    of pulse or flow may be the animal's own and is never subtracted. A drift that stays in counts as an error of the
    mean pressure, as large as it is in the averaged beats."""
    zero_time: Annotated[float, Ge(0)] = 0.0
    """The instant at which the transducer's zero is taken to be right, s since the start of the recording: the start by
    default, since catheters are zeroed before they record."""
