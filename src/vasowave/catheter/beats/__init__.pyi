"""Beats of a raw recording: found, cut, rejected, chosen."""

from vasowave.catheter.beats.beats import find_beats as find_beats
from vasowave.catheter.beats.cuts import Cuts as Cuts
from vasowave.catheter.beats.edits import BeatEdit as BeatEdit
from vasowave.catheter.beats.edits import edits_text as edits_text
from vasowave.catheter.beats.edits import read_edits as read_edits
from vasowave.catheter.beats.prepared import Averaging as Averaging
from vasowave.catheter.beats.prepared import prepare as prepare
from vasowave.catheter.beats.rejection import cause as cause
from vasowave.catheter.beats.steadiness import unsteady as unsteady

__all__: list[str]
