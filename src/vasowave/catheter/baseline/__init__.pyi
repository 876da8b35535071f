"""The level of the pressure over a recording: drift, steps, breaths and ventilation."""

from vasowave.catheter.baseline.baseline import baseline_findings as baseline_findings
from vasowave.catheter.baseline.baseline import with_comments as with_comments
from vasowave.catheter.baseline.breaths import breathing as breathing

__all__: list[str]
