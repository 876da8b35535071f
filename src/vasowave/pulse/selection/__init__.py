"""Which wall law the data prefer: AICc and BIC under every model of the noise."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
