"""A model and its waves in the files of other programs, and back: ParaView, MATLAB, openBF, svZeroDSolver, tables."""

from vasowave.study.exchange.export import FORMATS as FORMATS
from vasowave.study.exchange.export import export_model as export_model
from vasowave.study.exchange.matlab import write_matlab as write_matlab
from vasowave.study.exchange.openbf import linear_tube as linear_tube
from vasowave.study.exchange.openbf import write_openbf as write_openbf
from vasowave.study.exchange.openbf_reading import read_openbf as read_openbf
from vasowave.study.exchange.paraview import SIDES as SIDES
from vasowave.study.exchange.paraview import drawn_axes as drawn_axes
from vasowave.study.exchange.paraview import read_axes as read_axes
from vasowave.study.exchange.paraview import ring_directions as ring_directions
from vasowave.study.exchange.paraview import write_paraview as write_paraview
from vasowave.study.exchange.solved import solve as solve
from vasowave.study.exchange.svzerod import write_svzerod as write_svzerod
from vasowave.study.exchange.svzerod_reading import read_svzerod as read_svzerod
from vasowave.study.exchange.tables import write_tables as write_tables

__all__: list[str]
