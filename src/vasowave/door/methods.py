"""Bodies of the methods that draw, simulate and average: each value's own part declares them, see `accessors`."""

from vasowave.animal.datasets import recording_dataset
from vasowave.animal.result import FitPlots
from vasowave.cohort.planning import Plan
from vasowave.figures.compared import planned_figure
from vasowave.figures.fitted import PANELS, plot_panel, save_panels
from vasowave.figures.signals import draw_average, draw_cycle, draw_network, draw_raw
from vasowave.model.model import Model
from vasowave.network.network import Network
from vasowave.recording import EnsembleAverage, RawRecording, Recording, average_beats
from vasowave.solver.simulate import simulate


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
    for name in PANELS:
        getattr(FitPlots, name).register(lambda panels, ax=None, name=name: plot_panel(panels, name, ax))
