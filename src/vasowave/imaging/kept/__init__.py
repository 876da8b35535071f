"""Stages of an extraction kept on disk, so that an edit repeats only what it changes."""
