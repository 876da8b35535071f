"""Corrections by hand, and parts of a tree."""

from vasowave.lung.revise.edits import edited as edited
from vasowave.lung.revise.edits import outlets_of as outlets_of
from vasowave.lung.revise.edits import read_edits as read_edits
from vasowave.lung.revise.edits import root_of as root_of
from vasowave.lung.revise.edits import with_radii as with_radii
from vasowave.lung.revise.junctions import with_junctions_at as with_junctions_at
from vasowave.lung.revise.parts import first_generations as first_generations
from vasowave.lung.revise.parts import largest_vessels as largest_vessels
from vasowave.lung.revise.parts import part_of as part_of
from vasowave.lung.revise.parts import scaled as scaled
from vasowave.lung.revise.parts import wider_than as wider_than

__all__: list[str]
