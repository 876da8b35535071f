"""The workbench: a page on this machine over the same files and functions as the command line."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
