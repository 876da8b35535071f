"""Raw signals: channels, gaps, plateaus, spikes, hum and noise of a recording."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
