"""Panels that take ``ax`` and return it, and the figures made of them. Nothing is computed here."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
