"""The tables of a report, made from the results of the animals."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
