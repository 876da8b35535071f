"""Which wall law the data prefer: AICc and BIC under every model of the noise."""

from vasowave.selection.compare import Comparing, compare_models, compare_residuals
from vasowave.selection.criteria import UNDECIDED, aicc, bic, verdicts

__all__ = ["UNDECIDED", "Comparing", "aicc", "bic", "compare_models", "compare_residuals", "verdicts"]
