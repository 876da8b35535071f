"""Animals of a study: their results, the comparison of groups, figures, report and exchange."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
