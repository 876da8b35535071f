"""Entering animals: files sorted into a table, groups, templates, checks."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
