"""Lengths, radii, scale and their spread."""

from vasowave.lung.measure.cannula import cannula_radius as cannula_radius
from vasowave.lung.measure.cannula import cannula_tip as cannula_tip
from vasowave.lung.measure.cannula import tip_sd as tip_sd
from vasowave.lung.measure.cannula import without_cannula as without_cannula
from vasowave.lung.measure.contrast import contrasts as contrasts
from vasowave.lung.measure.contrast import own_contrast as own_contrast
from vasowave.lung.measure.evening import evened_sections as evened_sections
from vasowave.lung.measure.evening import moderated as moderated
from vasowave.lung.measure.grey_levels import GreyScale as GreyScale
from vasowave.lung.measure.grey_levels import corrected as corrected
from vasowave.lung.measure.grey_levels import grey_scale as grey_scale
from vasowave.lung.measure.measurement import RELIABLE as RELIABLE
from vasowave.lung.measure.measurement import filled_at as filled_at
from vasowave.lung.measure.measurement import measured_alone as measured_alone
from vasowave.lung.measure.measurement import measured_in as measured_in
from vasowave.lung.measure.measurement import network_of as network_of
from vasowave.lung.measure.measurement import taper as taper
from vasowave.lung.measure.measurement import with_errors as with_errors
from vasowave.lung.measure.profiles import DISC as DISC
from vasowave.lung.measure.profiles import RING as RING
from vasowave.lung.measure.profiles import Profile as Profile
from vasowave.lung.measure.profiles import profile as profile
from vasowave.lung.measure.profiles import signal_beside as signal_beside
from vasowave.lung.measure.radii import Densitometry as Densitometry
from vasowave.lung.measure.radii import densitometric_radii as densitometric_radii
from vasowave.lung.measure.radii import densitometric_radius as densitometric_radius
from vasowave.lung.measure.radii import densitometry as densitometry
from vasowave.lung.measure.radii import windows as windows

__all__: list[str]
