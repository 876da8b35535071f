"""From a micro-CT volume to a vessel network: read, lumen, axes, measure, witness, revise, exchange."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
