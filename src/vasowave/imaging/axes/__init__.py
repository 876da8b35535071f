"""Which vessels there are, and where their axes run."""
