"""Stages of an extraction kept on disk, so that an edit repeats only what it changes."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
