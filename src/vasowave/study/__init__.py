"""A study: settings and a table of animals in; results, tables, figures and a report out."""
