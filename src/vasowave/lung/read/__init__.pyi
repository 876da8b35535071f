"""Images from files, checked, on a grid of cubes."""

from vasowave.lung.read.files import read_volume as read_volume
from vasowave.lung.read.formats import VOLUMES as VOLUMES
from vasowave.lung.read.itk import write_volume as write_volume
from vasowave.lung.read.labels import marks as marks
from vasowave.lung.read.labels import on_grid_of as on_grid_of
from vasowave.lung.read.labels import read_labels as read_labels
from vasowave.lung.read.volume import Volume as Volume
from vasowave.lung.read.volume import isotropic as isotropic
from vasowave.lung.read.vti import lz4_block as lz4_block

__all__: list[str]
