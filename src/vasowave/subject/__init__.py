"""One animal from its recording to everything the study asks of it, as one tree of labelled data."""

from vasowave.subject.animal import Animal, Settings
from vasowave.subject.pipeline import analyze
from vasowave.subject.quantities import QUANTITIES, Quantity
from vasowave.subject.tree_file import read_tree, write_tree

__all__ = ["QUANTITIES", "Animal", "Quantity", "Settings", "analyze", "read_tree", "write_tree"]
