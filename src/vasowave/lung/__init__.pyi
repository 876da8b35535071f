"""From a micro-CT volume to a vessel network: read, lumen, axes, measure, witness, revise, exchange."""

from vasowave.lung.entrances import check_root as check_root
from vasowave.lung.extraction import Extraction as Extraction
from vasowave.lung.extraction import extract as extract
from vasowave.lung.kernels import ahead_of as ahead_of
from vasowave.lung.kernels import encloses as encloses
from vasowave.lung.kernels import in_tube as in_tube
from vasowave.lung.kernels import summed_on_pieces as summed_on_pieces
from vasowave.lung.matching import match as match
from vasowave.lung.matching import unmatched as unmatched
from vasowave.lung.options import Options as Options
from vasowave.lung.options import grey_text as grey_text
from vasowave.lung.options import parse_grey as parse_grey
from vasowave.lung.overview import Overview as Overview
from vasowave.lung.overview import histogram_of as histogram_of
from vasowave.lung.overview import look as look
from vasowave.lung.places import Frame as Frame
from vasowave.lung.places import parse_place as parse_place
from vasowave.lung.places import parse_places as parse_places
from vasowave.lung.places import parse_region as parse_region
from vasowave.lung.places import parse_voxel as parse_voxel
from vasowave.lung.places import read_places as read_places
from vasowave.lung.places import voxel_text as voxel_text
from vasowave.lung.places import written as written
from vasowave.lung.read.files import read_volume as read_volume
from vasowave.lung.read.itk import write_volume as write_volume
from vasowave.lung.read.volume import Volume as Volume
from vasowave.lung.sections import across as across
from vasowave.lung.sections import tangents as tangents
from vasowave.lung.supplied import given as given
from vasowave.lung.tree import Line as Line
from vasowave.lung.tree import Tree as Tree
from vasowave.lung.tree import distance_along as distance_along
from vasowave.lung.tree import free_length as free_length

__all__: list[str]
