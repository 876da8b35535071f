"""Self-contained pages about one animal or many: words, tables, figures, methods, provenance."""

from vasowave.report.write import write_report

__all__ = ["write_report"]
