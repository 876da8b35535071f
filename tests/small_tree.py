"""A tree of three vessels, for what needs no more of them."""

from vasowave.pulse.network import Network

SMALL = Network(("1", "2", "3"), [-1, 0, 0], [0.41, 0.45, 0.37], [0.047, 0.026, 0.037])
