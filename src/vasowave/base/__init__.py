"""What every part stands on: errors, findings, settings, units, species, stored files, processes."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
