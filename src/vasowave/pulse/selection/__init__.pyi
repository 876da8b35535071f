"""Which wall law the data prefer: AICc and BIC under every model of the noise."""

from vasowave.pulse.selection.averaging import Averaged as Averaged
from vasowave.pulse.selection.averaging import averaged as averaged
from vasowave.pulse.selection.averaging import averaged_draws as averaged_draws
from vasowave.pulse.selection.averaging import law_weights as law_weights
from vasowave.pulse.selection.compare import Comparing as Comparing
from vasowave.pulse.selection.compare import compare_models as compare_models
from vasowave.pulse.selection.compare import compare_residuals as compare_residuals
from vasowave.pulse.selection.criteria import UNDECIDED as UNDECIDED
from vasowave.pulse.selection.criteria import aicc as aicc
from vasowave.pulse.selection.criteria import bic as bic
from vasowave.pulse.selection.criteria import verdicts as verdicts
from vasowave.pulse.selection.stiffening_test import profiled as profiled
from vasowave.pulse.selection.stiffening_test import stiffening as stiffening

__all__: list[str]
