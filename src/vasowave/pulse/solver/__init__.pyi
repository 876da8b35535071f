"""The 1D solver: a model and an inflow in, labelled waveforms of its periodic state out."""

from vasowave.pulse.solver.accuracy import run_to_accuracy as run_to_accuracy
from vasowave.pulse.solver.circulation import Circulation as Circulation
from vasowave.pulse.solver.direction import direction_between as direction_between
from vasowave.pulse.solver.grid import make_grid as make_grid
from vasowave.pulse.solver.parameter_sweep import sweep as sweep
from vasowave.pulse.solver.parameter_sweep import sweep_table as sweep_table
from vasowave.pulse.solver.places import QUANTITIES as QUANTITIES
from vasowave.pulse.solver.places import Places as Places
from vasowave.pulse.solver.places import Waves as Waves
from vasowave.pulse.solver.places import waves_at as waves_at
from vasowave.pulse.solver.powers import power as power
from vasowave.pulse.solver.powers import tangent as tangent
from vasowave.pulse.solver.practice import PAPER as PAPER
from vasowave.pulse.solver.ready import compile_kernels as compile_kernels
from vasowave.pulse.solver.relaxation import bed_relaxation as bed_relaxation
from vasowave.pulse.solver.result import Run as Run
from vasowave.pulse.solver.result import difference as difference
from vasowave.pulse.solver.run import run_cycles as run_cycles
from vasowave.pulse.solver.run import run_on_cells as run_on_cells
from vasowave.pulse.solver.run import run_to_periodic as run_to_periodic
from vasowave.pulse.solver.sensitivity import derivatives as derivatives
from vasowave.pulse.solver.sensitivity import pressure_derivatives as pressure_derivatives
from vasowave.pulse.solver.simulation import simulate as simulate
from vasowave.pulse.solver.simulation import simulate_run as simulate_run
from vasowave.pulse.solver.simulation import simulate_runs as simulate_runs
from vasowave.pulse.solver.state import State as State
from vasowave.pulse.solver.stepper import Stepper as Stepper
from vasowave.pulse.solver.terms import changes_of_all as changes_of_all
from vasowave.pulse.solver.terms import of_all as of_all
from vasowave.pulse.solver.terms import of_one as of_one
from vasowave.pulse.solver.validity import STRAINED as STRAINED
from vasowave.pulse.solver.valve import Heart as Heart
from vasowave.pulse.solver.valve import require_emptied as require_emptied
from vasowave.pulse.solver.valve import ventricular_waves as ventricular_waves

__all__: list[str]
