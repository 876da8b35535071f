"""Stages of an extraction kept on disk, so that an edit repeats only what it changes."""

from vasowave.lung.kept.stages import FOLDER as FOLDER
from vasowave.lung.kept.stages import Keys as Keys
from vasowave.lung.kept.stages import Stages as Stages
from vasowave.lung.kept.stages import forget_stages as forget_stages
from vasowave.lung.kept.stages import image_key as image_key
from vasowave.lung.kept.stages import keys_of as keys_of
from vasowave.lung.kept.stages import read_value as read_value
from vasowave.lung.kept.stages import volume_key as volume_key
from vasowave.lung.kept.stages import write_value as write_value

__all__: list[str]
