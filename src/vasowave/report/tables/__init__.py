"""The tables of a report, made from the trees of the animals."""
