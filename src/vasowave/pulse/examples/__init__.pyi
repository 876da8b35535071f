"""The published tables and their networks, and a virtual mouse."""

from vasowave.pulse.examples.mouse import TRUTH as TRUTH
from vasowave.pulse.examples.mouse import ejection as ejection
from vasowave.pulse.examples.mouse import virtual_mouse as virtual_mouse
from vasowave.pulse.examples.published import control_network as control_network
from vasowave.pulse.examples.published import hypertensive_network as hypertensive_network
from vasowave.pulse.examples.published import published_table as published_table

__all__: list[str]
