"""What values of lower parts can do by upper ones: draw, simulate, sample, report."""
