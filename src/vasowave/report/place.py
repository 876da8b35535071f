"""Putting a finished report into its folder, whole or not at all."""

from vasowave.files import write_folder as placing

__all__ = ["placing"]
