"""Fit a model to a recording: parameters and bounds, objective, many starts, and what the data determine."""

from vasowave.calibration.calibrate import Fitting, Search, calibrate
from vasowave.calibration.profile import profile_likelihood
from vasowave.calibration.result import CalibratedModel
from vasowave.calibration.search import SearchEnd
from vasowave.calibration.starts import SearchCache

__all__ = ["CalibratedModel", "Fitting", "Search", "SearchCache", "SearchEnd", "calibrate", "profile_likelihood"]
