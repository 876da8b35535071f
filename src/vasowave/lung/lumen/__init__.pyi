"""Which voxels are vessel."""

from vasowave.lung.lumen.contours import level_set as level_set
from vasowave.lung.lumen.inclusions import dark_inclusions as dark_inclusions
from vasowave.lung.lumen.inclusions import without_inclusions as without_inclusions
from vasowave.lung.lumen.levels import background_and_noise as background_and_noise
from vasowave.lung.lumen.levels import background_level as background_level
from vasowave.lung.lumen.levels import levels_of as levels_of
from vasowave.lung.lumen.masks import EditedMask as EditedMask
from vasowave.lung.lumen.masks import Within as Within
from vasowave.lung.lumen.masks import box_region as box_region
from vasowave.lung.lumen.segmentation import Segmentation as Segmentation
from vasowave.lung.lumen.segmentation import Smoothed as Smoothed
from vasowave.lung.lumen.segmentation import segment as segment
from vasowave.lung.lumen.segmentation import smoothed as smoothed
from vasowave.lung.lumen.strangers import without_strangers as without_strangers
from vasowave.lung.lumen.surface import Surface as Surface
from vasowave.lung.lumen.surface import full_mask as full_mask
from vasowave.lung.lumen.surface import smooth_surface as smooth_surface
from vasowave.lung.lumen.surface import surface_points as surface_points
from vasowave.lung.lumen.surface import write_mask as write_mask

__all__: list[str]
