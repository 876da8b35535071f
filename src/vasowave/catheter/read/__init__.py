"""Files of recordings: which format, which channels, which of them is pressure, flow and ECG."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
