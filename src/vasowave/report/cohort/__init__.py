"""The report of a cohort, from the trees of its animals alone."""

from vasowave.report.cohort.write import write_cohort_report

__all__ = ["write_cohort_report"]
