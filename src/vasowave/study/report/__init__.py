"""Self-contained pages about one animal or many: words, tables, figures, methods, provenance."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
