"""The folder of a study: its settings, its table of animals, its design."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
