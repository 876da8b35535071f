"""The sections of a report, one file each; on the page: summary, data, models, groups, animals, methods."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
