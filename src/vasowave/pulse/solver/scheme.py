"""What the kernels are given: the parts of a simulation and of its linearization, by name."""

from typing import Any, NamedTuple

import numpy as np

from vasowave.pulse.solver.beds import BedSteps
from vasowave.pulse.solver.cells import Faces, FluidConstants, Fluxes
from vasowave.pulse.solver.grid import Cells, Ends, Vessels
from vasowave.pulse.solver.node_variations import EndChanges, EndSlopes, OutletChanges
from vasowave.pulse.solver.nodes import NodeStates
from vasowave.pulse.solver.variations import Slopes, Stencil, Weights


class Walls(NamedTuple):
    """The wall law at all places; or in each of its parameters a pair of laws beside it (`Tangent.shifted`)."""

    cells: Any
    faces: Any
    ends: Any


class Scheme(NamedTuple):
    """Constants of a simulation."""

    vessels: Vessels
    cells: Cells
    faces: Cells
    ends: Ends
    walls: Walls
    fluid: FluidConstants
    outlet: BedSteps


class SlotStates(NamedTuple):
    """What a cycle begins and ends with."""

    area: np.ndarray  # (slot,) cm²
    flow: np.ndarray  # (slot,) ml/s
    memory: np.ndarray  # (terminal, mode) mmHg


class HalfStep(NamedTuple):
    """Scratch memory of one simulation."""

    cell_fluxes: Fluxes  # at the start of the step
    faces: Faces
    face_fluxes: Fluxes
    nodes: NodeStates


class StepRecords(NamedTuple):
    """Where a cycle is recorded."""

    watched: np.ndarray  # (face,)
    waves: np.ndarray  # (kind, step, face) area, flow, viscous pressure
    stations: np.ndarray  # (kind, sample, vessel, station)
    cells: np.ndarray  # (kind, sample, slot), without samples where cells are not asked for


class RecordChanges(NamedTuple):
    """Where the changes of a cycle are recorded."""

    watched: np.ndarray  # (face,)
    waves: np.ndarray  # (kind, direction, step, face) pressure of the law, flow, viscous pressure
    inlet: np.ndarray  # (direction, step) pressure, mmHg


class StepArguments(NamedTuple):
    """A simulation at one of its steps."""

    inflow: np.ndarray  # (step, inlet) ml/s; mmHg of a given pressure, mmHg/ml of a ventricle's elastance
    state: SlotStates
    scheme: Scheme
    half: HalfStep
    records: StepRecords


class Tangent(NamedTuple):
    """The linearized scheme in all directions, and its scratch memory."""

    changed: Faces  # (direction, slot) of area and flow of the cells
    shifted: Walls
    outlets: OutletChanges
    in_slots: Weights
    in_faces: Weights
    in_ends: Weights
    cell_slopes: Slopes
    face_slopes: Slopes
    to_faces: Stencil
    to_cells: Stencil
    lines: EndSlopes
    at_nodes: EndChanges
    faces: Faces  # changes in one direction
    records: RecordChanges
