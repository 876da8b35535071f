"""From files of pressure and flow to one averaged cycle and its hemodynamic indices."""

from vasowave.recording.cycle import INDEX_UNITS, Inflow, Recording, resample
from vasowave.recording.read import read_recording

__all__ = ["INDEX_UNITS", "Inflow", "Recording", "read_recording", "resample"]
