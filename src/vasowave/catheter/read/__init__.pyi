"""Files of recordings: which format, which channels, which of them is pressure, flow and ECG."""

from vasowave.catheter.read.choosing import choose as choose
from vasowave.catheter.read.describe import describe_recording as describe_recording
from vasowave.catheter.read.describe import kind_of as kind_of
from vasowave.catheter.read.loops import LoopReading as LoopReading
from vasowave.catheter.read.loops import read_loops as read_loops
from vasowave.catheter.read.read import read_recording as read_recording
from vasowave.catheter.read.read_raw import Reading as Reading
from vasowave.catheter.read.read_raw import read_raw_recording as read_raw_recording
from vasowave.catheter.read.several_beats import beats_within as beats_within
from vasowave.catheter.read.site_files import read_sites as read_sites
from vasowave.catheter.read.ventricle import read_ventricle as read_ventricle
from vasowave.catheter.read.wedge import read_wedge as read_wedge

__all__: list[str]
