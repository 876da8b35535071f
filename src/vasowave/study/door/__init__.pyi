"""What values of lower parts can do by upper ones: draw, simulate, sample, report."""

from vasowave.study.door.fit import Fit as Fit
from vasowave.study.door.fit import calibrate as calibrate

__all__: list[str]
