"""Vessels that hang together: their table, what is odd about them, and how they are repaired."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
