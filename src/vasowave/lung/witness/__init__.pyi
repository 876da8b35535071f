"""Whether the answer fits the image: what contradicts it, and where."""

from vasowave.lung.witness.doubts import Doubt as Doubt
from vasowave.lung.witness.doubts import Grade as Grade
from vasowave.lung.witness.doubts import gravest as gravest
from vasowave.lung.witness.doubts import ranked as ranked
from vasowave.lung.witness.doubts import warn_of as warn_of
from vasowave.lung.witness.faults import fault_doubts as fault_doubts
from vasowave.lung.witness.grey import grey_look as grey_look
from vasowave.lung.witness.grey import saturation as saturation
from vasowave.lung.witness.loops import euler_number as euler_number
from vasowave.lung.witness.loops import loop_count as loop_count
from vasowave.lung.witness.loops import loops_after_closing as loops_after_closing
from vasowave.lung.witness.loops import loops_of as loops_of
from vasowave.lung.witness.loops import opening_threshold as opening_threshold
from vasowave.lung.witness.skeleton import Branches as Branches
from vasowave.lung.witness.skeleton import skeleton_branches as skeleton_branches
from vasowave.lung.witness.skeleton import thinned as thinned
from vasowave.lung.witness.topology import apart_doubts as apart_doubts
from vasowave.lung.witness.topology import crossing_doubts as crossing_doubts
from vasowave.lung.witness.topology import topology_doubts as topology_doubts
from vasowave.lung.witness.witness import NOT_ROUND as NOT_ROUND
from vasowave.lung.witness.witness import SHATTER as SHATTER
from vasowave.lung.witness.witness import UNSURE_LENGTH as UNSURE_LENGTH
from vasowave.lung.witness.witness import doubts_about as doubts_about
from vasowave.lung.witness.witness import surface_misfit as surface_misfit

__all__: list[str]
