"""Beats of a raw recording: found, cut, rejected, chosen."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
