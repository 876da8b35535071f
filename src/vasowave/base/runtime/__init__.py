"""The needs of a running process: compiled kernels, threads, memory, locks."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
