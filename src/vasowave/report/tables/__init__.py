"""The tables of a report, made from the results of the animals."""
