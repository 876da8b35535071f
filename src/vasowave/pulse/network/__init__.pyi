"""Vessels that hang together: their table, what is odd about them, and how they are repaired."""

from vasowave.pulse.network.graph import in_loops as in_loops
from vasowave.pulse.network.network import Network as Network
from vasowave.pulse.network.remarks import NO_PRESSURE as NO_PRESSURE
from vasowave.pulse.network.remarks import implausible_sizes as implausible_sizes
from vasowave.pulse.network.remarks import unknown_pressure as unknown_pressure
from vasowave.pulse.network.tidying import SHORTEST as SHORTEST
from vasowave.pulse.network.tidying import repaired as repaired
from vasowave.pulse.network.tidying import tidy as tidy
from vasowave.pulse.network.vessel_table import COUNTED as COUNTED
from vasowave.pulse.network.vessel_table import write_network as write_network

__all__: list[str]
