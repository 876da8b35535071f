"""What is implausible of a recording, and what its instruments did to it."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
