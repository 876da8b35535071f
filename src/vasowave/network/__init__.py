"""Vessels that hang together: their table, what is odd about them, and how they are repaired."""
