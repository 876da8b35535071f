"""The 1D solver: a model and an inflow in, labelled waveforms of its periodic state out."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
