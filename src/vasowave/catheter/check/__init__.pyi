"""What is implausible of a recording, and what its instruments did to it."""

from vasowave.catheter.check.catheter import Catheter as Catheter
from vasowave.catheter.check.catheter import LowPass as LowPass
from vasowave.catheter.check.catheter import correct_catheter as correct_catheter
from vasowave.catheter.check.catheter import ringing as ringing
from vasowave.catheter.check.catheter import suspect_catheter as suspect_catheter
from vasowave.catheter.check.catheter import without_delays as without_delays
from vasowave.catheter.check.plausibility import check_closure as check_closure
from vasowave.catheter.check.plausibility import check_flow as check_flow
from vasowave.catheter.check.plausibility import check_period as check_period
from vasowave.catheter.check.plausibility import check_pressure as check_pressure
from vasowave.catheter.check.plausibility import odd_values as odd_values
from vasowave.catheter.check.plausibility import resting_flow as resting_flow

__all__: list[str]
