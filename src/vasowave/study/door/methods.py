"""Bodies of the methods that draw, simulate and average: each value's own part declares them, see `accessors`."""

from vasowave.catheter.ensemble import average_beats
from vasowave.catheter.signals.raw import RawRecording
from vasowave.pulse.cycle.averaged import EnsembleAverage
from vasowave.pulse.cycle.cycle import Recording
from vasowave.pulse.model.model import Model
from vasowave.pulse.network.network import Network
from vasowave.pulse.solver.simulation import simulate
from vasowave.study.animal.datasets import recording_dataset
from vasowave.study.animal.result import FitPlots
from vasowave.study.cohort.planning import Plan
from vasowave.study.figures.compared import planned_figure
from vasowave.study.figures.fit import PANELS
from vasowave.study.figures.fitted import plot_panel, save_panels
from vasowave.study.figures.signals import draw_average, draw_cycle, draw_network, draw_raw


def register_all() -> None:
    """Register the body of every accessor."""
    Network.plot.register(draw_network)
    Recording.plot.register(draw_cycle)
    Recording.to_dataset.register(recording_dataset)
    RawRecording.plot.register(draw_raw)
    RawRecording.average.register(average_beats)
    EnsembleAverage.plot.register(draw_average)
    Model.simulate.register(simulate)
    Plan.figure.register(planned_figure)
    FitPlots.save.register(save_panels)
    FitPlots.draw.register(plot_panel)
    FitPlots.panels.register(lambda _: {name: panel.draw.__doc__ or panel.title for name, panel in PANELS.items()})
