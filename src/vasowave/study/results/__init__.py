"""Stored results of a study: what is computed already, and what they hold."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
