"""Files of other programs."""

from vasowave.lung.exchange.centerlines import measured_lines as measured_lines
from vasowave.lung.exchange.centerlines import read_centerlines as read_centerlines
from vasowave.lung.exchange.centerlines import write_centerlines as write_centerlines
from vasowave.lung.exchange.convention import Alike as Alike
from vasowave.lung.exchange.convention import as_extracted as as_extracted
from vasowave.lung.exchange.legacy_vtk import PolyLines as PolyLines
from vasowave.lung.exchange.legacy_vtk import parse_legacy as parse_legacy
from vasowave.lung.exchange.merging import merged as merged
from vasowave.lung.exchange.polydata import read_polydata as read_polydata
from vasowave.lung.exchange.polydata import write_vtp as write_vtp
from vasowave.lung.exchange.swc import read_swc as read_swc
from vasowave.lung.exchange.swc import require_radii as require_radii
from vasowave.lung.exchange.swc import write_swc as write_swc
from vasowave.lung.exchange.tables import write_author_tables as write_author_tables
from vasowave.lung.exchange.tables import write_network_table as write_network_table
from vasowave.lung.exchange.tables import write_points as write_points
from vasowave.lung.exchange.triangles import read_surface_points as read_surface_points
from vasowave.lung.exchange.triangles import write_stl as write_stl
from vasowave.lung.exchange.triangles import write_surface_vtp as write_surface_vtp

__all__: list[str]
