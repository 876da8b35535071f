"""Reading and writing files of any content: text, tables, workbooks, columns with units."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
