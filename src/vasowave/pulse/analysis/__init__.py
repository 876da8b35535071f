"""What waveforms and calibrated models say: waves, impedance, compliance, and what changes along the tree."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
