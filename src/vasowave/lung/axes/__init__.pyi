"""Which vessels there are, and where their axes run."""

from vasowave.lung.axes.feet import BEYOND as BEYOND
from vasowave.lung.axes.feet import Tubes as Tubes
from vasowave.lung.axes.feet import feet_on as feet_on
from vasowave.lung.axes.feet import near_points as near_points
from vasowave.lung.axes.junctions import to_the_surface as to_the_surface
from vasowave.lung.axes.junctions import with_ends_at_half_grey as with_ends_at_half_grey
from vasowave.lung.axes.junctions import with_ends_at_the_surface as with_ends_at_the_surface
from vasowave.lung.axes.junctions import without_short_vessels as without_short_vessels
from vasowave.lung.axes.skeleton import Skeleton as Skeleton
from vasowave.lung.axes.skeleton import cut_at_junctions as cut_at_junctions
from vasowave.lung.axes.starts import settled as settled
from vasowave.lung.axes.tubes import fitted as fitted
from vasowave.lung.axes.vessels import in_another_lumen as in_another_lumen
from vasowave.lung.axes.vessels import tree_of as tree_of

__all__: list[str]
