"""Fit a model to a recording: parameters and bounds, objective, many starts, and what the data determine."""

from vasowave.calibration.calibrate import Search, calibrate
from vasowave.calibration.parameters import PAPER_BOUNDS, WIDE_BOUNDS
from vasowave.calibration.result import Fit

__all__ = ["PAPER_BOUNDS", "WIDE_BOUNDS", "Fit", "Search", "calibrate"]
