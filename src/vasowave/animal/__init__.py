"""One animal from its recording to everything the study asks of it, as one tree of labelled data."""

from vasowave.animal.animal import Animal, Settings
from vasowave.animal.files import read_tree, write_tree
from vasowave.animal.pipeline import analyze
from vasowave.animal.quantities import QUANTITIES, Quantity

__all__ = ["QUANTITIES", "Animal", "Quantity", "Settings", "analyze", "read_tree", "write_tree"]
