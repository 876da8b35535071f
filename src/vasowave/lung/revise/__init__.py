"""Corrections by hand, and parts of a tree."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
