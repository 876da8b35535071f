"""One self-contained page about one calibrated animal: summary in words, tables, figures, methods, provenance."""

from vasowave.report.page import write_report

__all__ = ["write_report"]
