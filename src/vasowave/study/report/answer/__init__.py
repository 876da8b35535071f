"""The one result on the first page: an answer to each question, one forest plot, what is not known, what is wrong."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
