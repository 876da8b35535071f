"""From a study to its results: the plan, processes or a cluster, progress, report."""

from vasowave.base.faces import attach_face

__getattr__, __dir__ = attach_face(__name__)
