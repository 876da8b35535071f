"""One animal from its recording to everything the study asks of it, as one labelled result."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
