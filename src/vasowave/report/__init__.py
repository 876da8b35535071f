"""Self-contained pages about one animal or many: words, tables, figures, methods, provenance."""
