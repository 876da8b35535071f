"""The workbench: a page on this machine over the same files and functions as the command line."""

from vasowave.workbench.actions import act as act
from vasowave.workbench.arrivals import Arrivals as Arrivals
from vasowave.workbench.browser import in_a_browser as in_a_browser
from vasowave.workbench.cures import as_shown as as_shown
from vasowave.workbench.cures import buttons as buttons
from vasowave.workbench.desk import Desk as Desk
from vasowave.workbench.explorer import Explorer as Explorer
from vasowave.workbench.explorer import models_around as models_around
from vasowave.workbench.explorer import parameters_of as parameters_of
from vasowave.workbench.explorer import posterior_draws as posterior_draws
from vasowave.workbench.explorer import total_of as total_of
from vasowave.workbench.lungs import Lungs as Lungs
from vasowave.workbench.lungs import Wishes as Wishes
from vasowave.workbench.lungs import smaller as smaller
from vasowave.workbench.lungs import stored_wishes as stored_wishes
from vasowave.workbench.opening import opened as opened
from vasowave.workbench.recordings import Recordings as Recordings
from vasowave.workbench.recordings import Trace as Trace
from vasowave.workbench.running import Runs as Runs
from vasowave.workbench.server import Workbench as Workbench
from vasowave.workbench.server import server_of as server_of
from vasowave.workbench.studies import checked as checked
from vasowave.workbench.studies import shown as shown
from vasowave.workbench.workplace import Workplace as Workplace

__all__: list[str]
