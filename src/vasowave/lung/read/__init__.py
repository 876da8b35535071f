"""Images from files, checked, on a grid of cubes."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
