"""Corrections by hand, and parts of a tree."""
