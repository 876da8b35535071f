"""The settings of a study's report."""

from vasowave.base.settings import settings_class
from vasowave.study.cohort.primary import Family


@settings_class
class ReportFiles:
    """The files of the report."""

    pdf: bool = True
    """Whether the pages are also written as PDF."""


@settings_class
class ReportSettings(Family, ReportFiles):
    """The report: its files, and what of it is primary.

    Examples
    --------
    >>> import vasowave as vw
    >>> vw.ReportSettings(pdf=False, quantities=("mPAP", "stiffness")).pdf
    False
    """
