"""Self-contained pages about one calibrated animal or a cohort: words, tables, figures, methods, provenance."""

from vasowave.report.animal import write_report
from vasowave.report.cohort import write_cohort_report

__all__ = ["write_cohort_report", "write_report"]
