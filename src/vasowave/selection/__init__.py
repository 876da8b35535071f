"""Which wall law the data prefer: AICc and BIC under every model of the noise."""

from vasowave.selection.averaging import Averaged, averaged, law_weights
from vasowave.selection.compare import Comparing, compare_models, compare_residuals
from vasowave.selection.criteria import UNDECIDED, aicc, bic, verdicts
from vasowave.selection.stiffening import profiled, stiffening

__all__ = [
    "UNDECIDED",
    "Averaged",
    "Comparing",
    "aicc",
    "averaged",
    "bic",
    "compare_models",
    "compare_residuals",
    "law_weights",
    "profiled",
    "stiffening",
    "verdicts",
]
