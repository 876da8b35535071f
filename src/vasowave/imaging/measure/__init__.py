"""Lengths, radii, scale and their spread."""
