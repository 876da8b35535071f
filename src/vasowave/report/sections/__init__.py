"""The sections of a report, one file each; on the page: summary, data, models, groups, animals, methods."""
