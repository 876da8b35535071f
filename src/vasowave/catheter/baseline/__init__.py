"""The level of the pressure over a recording: drift, steps, breaths and ventilation."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
