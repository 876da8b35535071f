"""Whether the answer fits the image: what contradicts it, and where."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
