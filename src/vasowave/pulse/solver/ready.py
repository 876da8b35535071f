"""Compiling before the work: all that a fit with one wall law asks of the solver, on the smallest model there is."""

from dataclasses import replace

import numpy as np

from vasowave.pulse.cycle.cycle import Inflow
from vasowave.pulse.model.blood import Blood
from vasowave.pulse.model.law_files import in_words
from vasowave.pulse.model.laws import find_law
from vasowave.pulse.model.model import Model
from vasowave.pulse.model.nominal import windkessels
from vasowave.pulse.model.numerics import Numerics
from vasowave.pulse.model.shape import Shape
from vasowave.pulse.network.network import Network
from vasowave.pulse.solver.direction import direction_between
from vasowave.pulse.solver.run import run_to_periodic
from vasowave.pulse.solver.sensitivity import pressure_derivatives

_STIFFNESS = 50.0  # mmHg


@in_words()
def compile_kernels(wall: str | type) -> None:
    """Compile the kernels of a wall law, or load them where another process has compiled them.

    Parameters
    ----------
    wall : str or type
        As for `calibrate`.

    Raises
    ------
    InputError
        There is no such law, or its equations cannot be compiled.
    """
    law = find_law(wall)
    tube = Network(("1",), np.array([-1]), np.array([1.0]), np.array([0.05]))
    values = [np.full(1, parameter.nominal * parameter.scale(_STIFFNESS)) for parameter in law.law().parameters]
    model = Model(tube, law(*values), windkessels(tube, 75.0, 0.12), Blood())
    inflow, numerics = Inflow(np.full(32, 0.1), 0.12), Numerics(samples=32)
    run = run_to_periodic(model, inflow, numerics)
    pressure_derivatives(run, inflow, [direction_between(model, model, 1.0)], numerics)
    run_to_periodic(replace(model, shape=Shape([1.0, 0.99])), inflow, numerics)  # what an untold taper would do
