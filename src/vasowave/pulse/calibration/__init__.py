"""Fit a model to a recording: parameters and bounds, objective, many starts, and what the data determine."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
