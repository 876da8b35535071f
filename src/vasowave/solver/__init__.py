"""The 1D solver: a model and an inflow in, labelled waveforms of its periodic state out."""

from vasowave.solver.simulate import Numerics, simulate

__all__ = ["Numerics", "simulate"]
