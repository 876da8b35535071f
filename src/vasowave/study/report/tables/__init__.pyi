"""The tables of a report, made from the results of the animals."""

from vasowave.study.report.tables.cells import median_iqr as median_iqr
from vasowave.study.report.tables.groups import primary_tables as primary_tables
from vasowave.study.report.tables.models import laws_by_posterior as laws_by_posterior
from vasowave.study.report.tables.models import preference_table as preference_table
from vasowave.study.report.tables.models import selection_table as selection_table
from vasowave.study.report.tables.models import sites_table as sites_table

__all__: list[str]
