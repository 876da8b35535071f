"""The 1D solver: a model and an inflow in, labelled waveforms of its periodic state out."""

from vasowave.model.numerics import Numerics
from vasowave.solver.circulation import Circulation
from vasowave.solver.simulate import simulate
from vasowave.solver.sweep import changed_model, sweep

__all__ = ["Circulation", "Numerics", "changed_model", "simulate", "sweep"]
