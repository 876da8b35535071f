"""Raw signals: channels, gaps, plateaus, spikes, hum and noise of a recording."""

from vasowave.catheter.signals.channels import Block as Block
from vasowave.catheter.signals.channels import Channel as Channel
from vasowave.catheter.signals.channels import Comment as Comment
from vasowave.catheter.signals.gaps import Span as Span
from vasowave.catheter.signals.interventions import comment_findings as comment_findings
from vasowave.catheter.signals.interventions import is_intervention as is_intervention
from vasowave.catheter.signals.plateaus import Plateau as Plateau
from vasowave.catheter.signals.plateaus import plateau_findings as plateau_findings
from vasowave.catheter.signals.plateaus import saturated as saturated
from vasowave.catheter.signals.raw import RawRecording as RawRecording
from vasowave.catheter.signals.raw import SensorCalibration as SensorCalibration
from vasowave.catheter.signals.same_signal import are_of_one as are_of_one
from vasowave.catheter.signals.same_signal import trace_of as trace_of
from vasowave.catheter.signals.signal import even_step as even_step
from vasowave.catheter.signals.spikes import despiked as despiked

__all__: list[str]
